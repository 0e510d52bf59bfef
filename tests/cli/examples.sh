#!/bin/sh
# The small programs of examples/ against the command line, on every good mesh of ref_data that has positions: whole
# streams, and streams cut in the middle; and what they do with input that is none. The last line is `N passed, N failed`.
set -u
cd "$(dirname "$0")/../.." || exit
out=build/examples
rm -rf "$out"
mkdir -p "$out"

passed=0
failed=0
check() {
    if "$@" >"$out/log" 2>&1; then
        passed=$((passed + 1))
    else
        failed=$((failed + 1))
        echo "FAIL  $*"
        cat "$out/log"
    fi
}

minimal_decode_agrees() {
    build/minimal_decode <"$1" >"$out/minimal.off" && build/cqm decode "$1" "$out/cqm.off" &&
        cmp "$out/minimal.off" "$out/cqm.off"
}

sixteen_bits_decode_the_same() {
    build/minimal_decode <"$1" >"$out/32.off" && build/tests/minimal_decode-16 <"$1" >"$out/16.off" &&
        cmp "$out/32.off" "$out/16.off"
}

# Status 2 and the coarser mesh, with a word; 1 if there is none yet.
minimal_decode_agrees_on_a_part() {
    head -c "$2" "$1" >"$out/part.cqm"
    build/minimal_decode <"$out/part.cqm" >"$out/minimal.off" 2>"$out/minimal.err"
    minimal=$?
    if build/cqm decode --bytes "$2" "$1" "$out/cqm.off"; then
        [ $minimal -eq 2 ] && grep 'cut off' "$out/minimal.err" && cmp "$out/minimal.off" "$out/cqm.off" &&
            parts=$((parts + 1))
    else
        [ $minimal -eq 1 ] && [ -s "$out/minimal.err" ] && [ ! -s "$out/minimal.off" ]
    fi
}

# The mesh with whole coordinates, the longest side from 0 to 4095, so that 12 bits are exact.
whole_coordinates() {
    awk 'NR == FNR { if (NF == 3 && FNR > 2) for (k = 1; k <= 3; k++) {
             if (!(k in low) || $k < low[k]) low[k] = $k
             if (!(k in high) || $k > high[k]) high[k] = $k }
             next }
         FNR == 3 { for (k in low) if (high[k] - low[k] > side) side = high[k] - low[k] }
         NF == 3 && FNR > 2 { for (k = 1; k <= 3; k++) $k = int(($k - low[k]) / side * 4095 + 0.5) }
         { print }' "$1" "$1"
}

# Triangles as coordinates of their corners, whatever the order of vertices, of faces, and of the corners of a face.
triangles() {
    awk 'FNR > 2 && NF == 3 { at[n++] = $1 "," $2 "," $3 }
         FNR > 2 && NF == 4 { a = at[$2]; b = at[$3]; c = at[$4]
             print a < b && a < c ? a " " b " " c : b < c ? b " " c " " a : c " " a " " b }' "$1" | sort
}

minimal_encode_keeps_all() {
    whole_coordinates "$1" >"$out/whole.off" && triangles "$out/whole.off" >"$out/in.txt" &&
        build/minimal_encode <"$out/whole.off" >"$out/whole.cqm" &&
        build/minimal_decode <"$out/whole.cqm" >"$out/back.off" && triangles "$out/back.off" >"$out/out.txt" &&
        [ "$(wc -l <"$out/in.txt")" -eq "$(sed -n '2s/^[0-9]* \([0-9]*\) .*/\1/p' "$1")" ] &&
        cmp "$out/in.txt" "$out/out.txt"
}

sanitized_encode_does_the_same() {
    build/minimal_encode <"$1" >"$out/plain.cqm" && build/tests/minimal_encode <"$1" >"$out/sanitized.cqm" &&
        cmp "$out/plain.cqm" "$out/sanitized.cqm"
}

# Status 1, a word, and no output: program, input
refuses() {
    "build/$1" <"$2" >"$out/refused" 2>"$out/refused.err"
    [ $? -eq 1 ] && [ -s "$out/refused.err" ] && [ ! -s "$out/refused" ]
}

stream_reaches_the_end() {
    build/stream <"$1" >"$out/stream.txt" && tail -n 1 "$out/stream.txt" | grep " $2 of $2 vertices\$"
}

stream_says_truncated() {
    head -c "$2" "$1" | build/stream >"$out/stream.txt"
    [ $? -eq 1 ] && tail -n 1 "$out/stream.txt" | grep ' of .* vertices$'
}

# The game loop's GPU has all of the mesh in the end, uploaded block by block.
game_loop_reaches_the_end() {
    build/game_loop "$1" >"$out/game.txt" && tail -n 1 "$out/game.txt" | grep "^complete: $2 of $2 vertices\$"
}

# README's lines for an engine
make_door() {
    tests/doors/door.sh engine >"$out/engine.inc" &&
        cc -std=c99 -Wall -Wextra -Werror -fsanitize=address,undefined -fno-sanitize-recover=all -g -Iinclude -I"$out" \
            tests/doors/engine.c -o "$out/engine"
}

# README has the whole of a program.
readme_prints() {
    awk -v first="$(head -n 1 "$1")" '$0 == first { code = 1 } /^```/ { code = 0 } code { print }' README.md | cmp - "$1"
}

# The test that CONTRIBUTING has for somebody who adds one
contributed_test_passes() {
    awk '/^```c$/ { code = 1; next } /^```/ { code = 0 } code { print }' CONTRIBUTING.md >"$out/test.c" &&
        cc -std=c99 -Wall -Wextra -Werror -Iinclude -Iexamples -Itests/support "$out/test.c" -o "$out/test" &&
        "$out/test" | grep '^1 passed, 0 failed$'
}

check contributed_test_passes
check readme_prints examples/minimal_decode.c
check readme_prints examples/minimal_encode.c
check make_door
build/meshgen random 3000 1 >"$out/random.off"
check build/cqm encode "$out/random.off" "$out/random.cqm"
check "$out/engine" "$out/random.cqm"

parts=0
for mesh in ref_data/*.off; do
    stream=$out/$(basename "$mesh" .off).cqm
    check build/cqm encode "$mesh" "$stream"
    vertices=$(sed -n '2s/ .*//p' "$mesh")
    half=$(($(wc -c <"$stream") / 2))
    check minimal_decode_agrees "$stream"
    check sixteen_bits_decode_the_same "$stream"
    check minimal_decode_agrees_on_a_part "$stream" $half
    check minimal_encode_keeps_all "$mesh"
    check sanitized_encode_does_the_same "$mesh"
    check stream_reaches_the_end "$stream" "$vertices"
    check game_loop_reaches_the_end "$stream" "$vertices"
    check stream_says_truncated "$stream" $half
done
check test $parts -gt 10

# Any triangles: more than two faces at an edge, a Moebius strip, faces that repeat.
for mesh in ref_data/bad/*.off; do
    [ "$mesh" = ref_data/bad/range.off ] || check sanitized_encode_does_the_same "$mesh"
done

for bytes in 0 3 20; do
    head -c $bytes "$out/random.cqm" >"$out/short.cqm"
    check refuses minimal_decode "$out/short.cqm"
done
head -c 500 "$out/random.cqm" | tr '\000' '\001' >"$out/corrupt.cqm"
check refuses minimal_decode "$out/corrupt.cqm"
check refuses minimal_decode ref_data/sphere.off

bad() { # name, format, the points
    # shellcheck disable=SC2059 # a format it is
    printf "$2" "${3-}" >"$out/$1.off"
    check refuses minimal_encode "$out/$1.off"
}
points='0 0 0\n1 0 0\n0 1 0\n'
bad empty ''
bad no_off 'FFO\n3 1 0\n%b3 0 1 2\n' "$points"
bad no_counts 'OFF\n3 x\n'
bad negative 'OFF\n-3 1 0\n3 0 1 2\n'
bad too_large 'OFF\n250001 1 0\n3 0 1 2\n'
bad too_many_faces 'OFF\n3 500001 0\n%b3 0 1 2\n' "$points"
bad no_number 'OFF\n3 1 0\n0 0 zero\n1 0 0\n0 1 0\n3 0 1 2\n'
bad not_finite 'OFF\n3 1 0\n0 0 nan\n1 0 0\n0 1 0\n3 0 1 2\n'
bad polygon 'OFF\n4 1 0\n%b1 1 0\n4 0 1 3 2\n' "$points"
bad range 'OFF\n3 1 0\n%b3 0 1 3\n' "$points"
bad wide 'OFF\n3 1 0\n%b3 0 1 4294967298\n' "$points"
bad cut_off 'OFF\n3 1 0\n%b3 0 1\n' "$points"
echo "$passed passed, $failed failed"
[ $failed -eq 0 ] && [ $passed -gt 0 ]
