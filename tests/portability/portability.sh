#!/bin/bash
# Builds portability.c in many ways and compares what it prints with what gcc -O2 prints on this machine.
#
#     tests/portability/portability.sh native | all
#
# native: C and C++, -O0 -Os -O3, -ffast-math, 32 bits, 16-bit indices, unsigned char, short enums, by gcc and clang in
# turn; link-time optimisation for AVX2 by both; and one big-endian machine. all: each by both, the other machines, each
# also with 16-bit indices, every combination of compiler, level, link-time optimisation and instruction set; accesses out of bounds in code that cannot run, which LLVM has drawn wrong
# conclusions from; and the types of memory. Emulated machines run under qemu; its exit status counts. A compiler that
# is missing is a failure. The last line is `N passed, N failed`.
set -u
cd "$(dirname "$0")/../.." || exit 1
clang=${CLANG:-clang-19}
work=build/portability
source=tests/portability/portability.c
meshes=(ref_data/*.off ref_data/bad/*.off)
include=${HEADER_DIR:-include}
typed=${CLANG_TYPES:-clang-22} # -fsanitize=type came with clang 20
passed=0 failed=0
mkdir -p "$work"

# Options, each with a name.
options() {
    cat <<'END'
-O0            -std=c99 -O0
-Os            -std=c99 -Os
++-O1          -x c++ -std=c++17 -O1
-O3            -std=c99 -O3
-16            -std=c99 -O1 -DCQ_INDEX_BITS=16
-m32           -std=c99 -O2 -m32
-m32-16        -std=c99 -O1 -m32 -DCQ_INDEX_BITS=16
-unsigned-char -std=c99 -O1 -funsigned-char -fshort-enums
-private       -std=c99 -O1 -ftrapv -DNDEBUG
-fast-math     -std=c99 -O1 -ffast-math -march=native
END
    if [ "$1" = all ]; then printf '++%s -x c++ -std=c++17 %s\n' -O0 -O0 -Os -Os -O3 -O3; fi
}

# One a line: name, runner or -, command. `native` has the compilers take turns.
natives() {
    local name flags turn=0
    while read -r name flags; do
        turn=$((turn + 1))
        if [ "$1" = all ] || [ $((turn % 2)) = 0 ]; then echo "gcc$name - gcc $flags"; fi
        if [ "$1" = all ] || [ $((turn % 2)) = 1 ]; then echo "$clang$name - $clang $flags"; fi
    done < <(options "$1")
    cell "$clang" -O3 -flto x86-64-v3
    cell gcc -O3 -flto native
}

# One cell of the matrix.
cell() { # compiler level lto march
    local linker=
    case $1$3 in clang*-flto*) linker=-fuse-ld=${1/clang/lld} ;; esac
    echo "$1$2$3-$4 - $1 -std=c99 $2 $3 -march=$4 $linker"
}

matrix() {
    for compiler in gcc clang-14 clang-16 clang-19; do
        for lto in '' -flto -flto=thin; do
            if [ $compiler$lto = gcc-flto=thin ]; then continue; fi
            for level in -O1 -O2 -O3 -Os; do
                for march in x86-64-v2 x86-64-v3 native; do cell $compiler $level "$lto" $march; done
            done
        done
    done
}

machine() { # architecture triplet flags
    echo "$1 qemu-$1 $2-gcc -static -std=c99 -O2 ${3:-}"
    echo "$1-16 qemu-$1 $2-gcc -static -std=c99 -O2 ${3:-} -DCQ_INDEX_BITS=16"
}

others() {
    machine s390x s390x-linux-gnu
    machine arm arm-linux-gnueabihf
    machine riscv64 riscv64-linux-gnu
    machine aarch64 aarch64-linux-gnu
    machine ppc powerpc-linux-gnu
}

variants() {
    natives "$1"
    if [ "$1" = all ]; then others; matrix; else machine s390x s390x-linux-gnu | head -n 1; fi
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

result() { # status name what
    if [ "$1" = 0 ]; then
        echo "ok    $2"
        passed=$((passed + 1))
    else
        echo "FAIL  $2: $3"
        failed=$((failed + 1))
    fi
}

# LLVM's lint of the whole program, on its way to the linker.
check_bounds() { # compiler march
    local name=$1-bounds-$2 bitcode=$work/bounds.bc
    "$1" -std=c99 -O3 -flto -march="$2" -I"$include" -c "$source" -o "$bitcode" &&
        "${1/clang/opt}" -passes=lint -disable-output "$bitcode" 2>"$work/$name.log"
    [ $? = 0 ] && ! grep -q 'Buffer overflow' "$work/$name.log"
    result $? "$name" "$(grep -A1 -m1 'Buffer overflow' "$work/$name.log" | tail -n 1)"
}

# Memory that is read as another type than was stored. The sanitizer also tells members of one type in two structures
# apart, which a structure copied from one into the other makes it do: that is no finding.
check_types() { # test options...
    local test=$1 log=$work/types-${1##*/}.log
    shift
    "$typed" -std=c99 -g -O1 -fsanitize=type -I"$include" -Itests/support "tests/$test.c" -lm -o "$work/types" &&
        "$work/types" "$@" 2>&1 >/dev/null | awk -f tests/portability/types.awk >"$log"
    [ "${PIPESTATUS[*]}" = "0 0" ] && ! [ -s "$log" ]
    result $? "types of memory in $test" "$(head -n 1 "$log" 2>/dev/null)"
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
if [ "${1:-native}" = all ]; then
    for march in x86-64-v3 x86-64-v4; do check_bounds "$clang" $march; done
    check_types unit/quantiser
    check_types portability/portability "${meshes[@]}"
fi
echo "$(grep -c decoded "$work/reference.out") streams of each"
echo "$passed passed, $failed failed"
[ $failed = 0 ] && [ $passed != 0 ]
