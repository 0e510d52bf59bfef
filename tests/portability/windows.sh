#!/bin/bash
# The header, cqm and the examples on Windows and macOS. The last line is `N passed, N failed`.
#
# mingw-w64 and zig cc build them for Windows and wine runs them: verify, the same streams and the same decoded files as
# here, bytes through standard input and output. zig cc also compiles for macOS, which nothing here can run. A compiler
# or wine that is missing is a failure.
set -u
cd "$(dirname "$0")/../.." || exit 1
work=build/portability/windows
zig="$PWD/build/portability/venv/bin/python -m ziglang"
warnings="-std=c99 -O2 -Wall -Wextra -Werror -Iinclude"
cqm_sources=(examples/cqm/*.c examples/mesh_file/*.c)
passed=0 failed=0
rm -rf "$work"
mkdir -p "$work"
export WINEPREFIX=$PWD/$work/wine WINEDEBUG=-all

check() {
    if "$@" >"$work/log" 2>&1; then
        passed=$((passed + 1))
    else
        failed=$((failed + 1))
        echo "FAIL  $*"
        tail -n 5 "$work/log"
    fi
}

# Builds everything; programs go to $work/NAME.
build() { # name command...
    local folder=$work/$1 example
    shift
    mkdir -p "$folder"
    # shellcheck disable=SC2086 # flags are words
    "$@" $warnings "${cqm_sources[@]}" -lm -o "$folder/cqm.exe" || return 1
    for example in minimal_decode minimal_encode stream game_loop; do
        # shellcheck disable=SC2086
        "$@" $warnings "examples/$example.c" -lm -o "$folder/$example.exe" || return 1
    done
}

same_stream() { # folder mesh stream
    wine "$1/cqm.exe" encode "$2" "$1/a.cqm" && cmp "$1/a.cqm" "$3" && wine "$1/cqm.exe" encode "$2" "$1/a.cqm"
}

same_file() { # folder stream format
    build/cqm decode --quiet "$2" "$1/native.$3" && wine "$1/cqm.exe" decode --quiet "$2" "$1/windows.$3" &&
        cmp "$1/native.$3" "$1/windows.$3"
}

same_through_pipes() { # folder mesh stream
    wine "$1/cqm.exe" encode --format off - - <"$2" | cmp - "$3" &&
        wine "$1/cqm.exe" decode --format ply - - <"$3" | cmp - <(build/cqm decode --format ply "$3" -)
}

same_minimal_decode() { # folder stream
    wine "$1/minimal_decode.exe" <"$2" | cmp - <(build/minimal_decode <"$2")
}

same_minimal_encode() { # folder mesh
    wine "$1/minimal_encode.exe" <"$2" | cmp - <(build/minimal_encode <"$2")
}

stream_ends_well() { # folder stream
    wine "$1/stream.exe" <"$2" | tail -n 1 | tr -d '\r' | cmp - <(build/stream <"$2" | tail -n 1)
}

game_loop_ends_well() { # folder stream
    wine "$1/game_loop.exe" "$2" | grep '^complete: '
}

# What standard streams in text mode would break: a line feed, and 26, which ends a text.
has_bytes_of_text() { # stream
    [ "$(tr -dc '\n' <"$1" | wc -c)" -gt 0 ] && [ "$(tr -dc '\032' <"$1" | wc -c)" -gt 0 ]
}

refuses() { # folder status words...
    local folder=$1 status=$2 result
    shift 2
    wine "$folder/cqm.exe" "$@"
    result=$?
    [ $result = "$status" ]
}

run() { # folder
    local folder=$work/$1 name
    check wine "$folder/cqm.exe" verify ref_data/*.off
    check wine "$folder/cqm.exe" verify --bits 32 --keep-order ref_data/*.off
    for name in random_genus_holes terrain sponge; do
        local mesh=ref_data/$name.off stream=$work/$name.cqm format
        check build/cqm encode "$mesh" "$stream"
        check has_bytes_of_text "$stream"
        check same_stream "$folder" "$mesh" "$stream"
        for format in off obj ply stl; do check same_file "$folder" "$stream" $format; done
        check same_through_pipes "$folder" "$mesh" "$stream"
        check same_minimal_decode "$folder" "$stream"
        check same_minimal_encode "$folder" "$mesh"
        check stream_ends_well "$folder" "$stream"
        check game_loop_ends_well "$folder" "$stream"
    done
    check refuses "$folder" 1 encode ref_data/bad/range.off "$folder/b.cqm"
    check refuses "$folder" 2 encode ref_data/sponge.off ref_data/sponge.off
    check refuses "$folder" 1 encode no_such_file.off "$folder/b.cqm"
}

check build mingw x86_64-w64-mingw32-gcc
run mingw
for target in x86_64-windows-gnu aarch64-windows-gnu aarch64-macos x86_64-macos; do
    # shellcheck disable=SC2086
    check build "$target" $zig cc -target "$target"
done
run x86_64-windows-gnu
wineserver -k >/dev/null 2>&1
echo "$passed passed, $failed failed"
[ $failed = 0 ] && [ $passed != 0 ]
