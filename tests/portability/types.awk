# Sums up what -fsanitize=type prints: how often memory that holds one type was read or written as another. Says nothing
# of accesses where both are the same type, as a member of different structures, nor of those by a character type, which
# may access anything (C99 6.5p7).
/^(READ|WRITE) of size/ && match($0, /with type .* accesses (an|part of an) existing object of type .*/) {
    split(substr($0, RSTART + 10), side, / accesses (an|part of an) existing object of type /)
    for (k = 1; k <= 2; k++) sub(/ (\(in|that starts).*/, "", side[k])
    if (side[1] != side[2] && side[1] != "omnipotent char") count[side[1] " where there is " side[2]]++
}
END { for (what in count) print count[what] " times " what }
