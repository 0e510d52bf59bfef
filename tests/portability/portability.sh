#!/bin/bash
# Builds portability.c in many ways and compares what it prints with what gcc -O2 prints on this machine.
#
#     tests/portability/portability.sh native | all
#
# native: gcc and clang, C and C++, -O0 -Os -O3, 32 bits, 16-bit indices, unsigned char, short enums, and one
# big-endian machine. all: the other machines too. Emulated machines run under qemu; its exit status counts. A compiler
# that is missing is a failure. The last line is `N passed, N failed`.
set -u
cd "$(dirname "$0")/../.." || exit 1
clang=${CLANG:-clang-19}
work=build/portability
source=tests/portability/portability.c
meshes=(ref_data/*.off ref_data/bad/*.off)
include=${HEADER_DIR:-include}
passed=0 failed=0
mkdir -p "$work"

# One a line: name, runner or -, command.
natives() {
    for level in -O0 -Os -O3; do
        echo "gcc$level - gcc -std=c99 $level"
        echo "clang$level - $clang -std=c99 $level"
        echo "g++$level - g++ -x c++ -std=c++17 $level"
        echo "clang++$level - ${clang/clang/clang++} -x c++ -std=c++17 $level"
    done
    for compiler in gcc "$clang"; do
        echo "$compiler-16 - $compiler -std=c99 -O2 -DCQ_INDEX_BITS=16"
        echo "$compiler-m32 - $compiler -std=c99 -O2 -m32"
        echo "$compiler-m32-16 - $compiler -std=c99 -O2 -m32 -DCQ_INDEX_BITS=16"
        echo "$compiler-unsigned-char - $compiler -std=c99 -O2 -funsigned-char -fshort-enums"
        echo "$compiler-private - $compiler -std=c99 -O2 -ftrapv -DNDEBUG"
    done
}

machine() { # architecture triplet flags
    echo "$1 qemu-$1 $2-gcc -static -std=c99 -O2 ${3:-}"
    echo "$1-16 qemu-$1 $2-gcc -static -std=c99 -O2 ${3:-} -DCQ_INDEX_BITS=16"
}

others() {
    machine arm arm-linux-gnueabihf
    machine riscv64 riscv64-linux-gnu
    machine aarch64 aarch64-linux-gnu
    machine ppc powerpc-linux-gnu
}

variants() {
    natives
    machine s390x s390x-linux-gnu
    if [ "$1" = all ]; then others; fi
}

# Builds and runs one variant; its output goes to $work/NAME.out.
run() { # name runner command...
    local name=$1 runner=${2#-}
    shift 2
    # shellcheck disable=SC2086 # no runner is no word
    "$@" -Wall -I"$include" "$source" -o "$work/$name" 2>"$work/$name.log" &&
        $runner "$work/$name" "${meshes[@]}" >"$work/$name.out" 2>>"$work/$name.log"
}

compare() { # name runner command...
    local name=$1
    rm -f "$work/$name.out"
    if ! run "$@"; then
        echo "FAIL  $name: not built, or failed"
        tail -n 3 "$work/$name.log"
    elif ! cmp -s "$work/$name.out" "$work/reference.out"; then
        echo "FAIL  $name: other results than gcc -O2 here"
        diff "$work/$name.out" "$work/reference.out" | head -n 4
    else
        echo "ok    $name"
        passed=$((passed + 1))
        return
    fi
    failed=$((failed + 1))
}

if ! run reference - gcc -std=c99 -O2 || [ "$(grep -c decoded "$work/reference.out")" -lt 60 ]; then
    echo "the reference is not built, or has too few meshes"
    cat "$work/reference.log"
    echo "0 passed, 1 failed"
    exit 1
fi
while read -r name runner command; do
    # shellcheck disable=SC2086 # a command is words
    compare "$name" "$runner" $command </dev/null
done < <(variants "${1:-native}")
echo "$(grep -c decoded "$work/reference.out") streams of each"
echo "$passed passed, $failed failed"
[ $failed = 0 ] && [ $passed != 0 ]
