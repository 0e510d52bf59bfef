#!/bin/sh
# The small programs of examples/ against the command line, on every good mesh of ref_data that has positions: whole
# streams, and streams cut in the middle. The last line is `N passed, N failed`.
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

minimal_decode_agrees_on_a_part() {
    head -c "$2" "$1" >"$out/part.cqm"
    build/minimal_decode <"$out/part.cqm" >"$out/minimal.off"
    minimal=$?
    build/cqm decode --bytes "$2" "$1" "$out/cqm.off"
    [ $minimal -eq $? ] && { [ $minimal -ne 0 ] || cmp "$out/minimal.off" "$out/cqm.off"; }
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

check make_door
build/meshgen random 3000 1 >"$out/random.off"
check build/cqm encode "$out/random.off" "$out/random.cqm"
check "$out/engine" "$out/random.cqm"

for mesh in ref_data/*.off; do
    stream=$out/$(basename "$mesh" .off).cqm
    check build/cqm encode "$mesh" "$stream"
    vertices=$(sed -n '2s/ .*//p' "$mesh")
    half=$(($(wc -c <"$stream") / 2))
    check minimal_decode_agrees "$stream"
    check sixteen_bits_decode_the_same "$stream"
    check minimal_decode_agrees_on_a_part "$stream" $half
    check stream_reaches_the_end "$stream" "$vertices"
    check game_loop_reaches_the_end "$stream" "$vertices"
    check stream_says_truncated "$stream" $half
done
echo "$passed passed, $failed failed"
[ $failed -eq 0 ] && [ $passed -gt 0 ]
