#!/bin/bash
# The header in every way that it may be compiled; prints what fails, and last `N passed, N failed`. With the argument
# `quick`: only whether compilers have something to say.
#
#   - both compilers, oldest and newest standards, both widths: included twice, before and behind the implementation, in
#     two units, or private; those between are compiled without making code
#   - decoders without any of their parts
#   - files that disagree about the width of indices do not link; libraries of both widths do
#   - what the compiled header asks of the system is memcpy and memset, and nothing of it is writable memory
#   - a compiler that may not use floating point has nothing to say, beside the quantiser
set -u
cd "$(dirname "$0")/../.." || exit 1
include=$PWD/include
clang=${CLANG:-clang-19}
warnings=(-Wall -Wextra -Wconversion -pedantic -Werror)
freestanding=(gcc -x c -std=c99 -Os -ffreestanding -fno-stack-protector -fno-pic -I"$include")
imports='memcpy|memset|second_unit'
passed=0 failed=0
mkdir -p build/headers
cd build/headers || exit 1

check() { if "$@"; then passed=$((passed + 1)); else failed=$((failed + 1)); echo "FAIL $*"; fi; }

unresolved() { ! "$@" >link.log 2>&1 && grep -q 'undefined reference to .cq_result_string' link.log; }

no_symbols() { # file: beside those that may be imported
    ! nm "$1" | grep -E ' [BbCDdU] ' | grep -Evw "$imports"
}

cat >first <<'C'
#include "conquest.h"
#define CONQUEST_IMPLEMENTATION
#include "conquest.h"
#include "conquest.h"
extern const char *second_unit(void);
int main(void) { return second_unit() != cq_result_string(CQ_DONE); }
C
cat >second <<'C'
#include "conquest.h"
#include "conquest.h"
extern const char *second_unit(void);
const char *second_unit(void) { return cq_result_string(CQ_DONE); }
C
cat >private <<'C'
#define CQ_API static inline
#define CONQUEST_IMPLEMENTATION
#include "conquest.h"
int main(void) { return !cq_result_string(CQ_DONE); }
C

syntax() { # compiler options
    for unit in first second private; do check "$@" -fsyntax-only $unit; done
}

finish() {
    echo "$passed passed, $failed failed"
    [ $failed = 0 ]
    exit
}

for compiler in gcc "$clang"; do
    for standard in c99 c11 c++11 c++17; do
        for bits in 16 32; do
            options=(-x "${standard%%[0-9]*}" "-std=$standard" "-DCQ_INDEX_BITS=$bits" -O2 "${warnings[@]}" -I"$include")
            case $standard${1:-} in
            c11 | c++11 | *quick)
                syntax "$compiler" "${options[@]}"
                continue
                ;;
            esac
            check "$compiler" "${options[@]}" first second -o program && check ./program
            check "$compiler" "${options[@]}" private -o program && check ./program
        done
    done
done

for reports in "" -DCQ_NO_REPORTS; do
    for quantiser in "" -DCQ_NO_QUANTISER; do
        for wedges in "" -DCQ_NO_WEDGES; do
            for regular in "" -DCQ_NO_REGULAR; do
                for attributes in "" -DCQ_NO_ATTRIBUTES; do
                    # shellcheck disable=SC2086 # none if it is empty
                    check gcc -x c -std=c99 "${warnings[@]}" -I"$include" -DCQ_NO_ENCODER $reports $quantiser $wedges \
                        $regular $attributes -fsyntax-only first
                done
            done
        done
    done
done

[ "${1:-}" != quick ] || finish

for bits in 16 32; do
    for unit in first second; do gcc -x c -std=c99 -I"$include" -DCQ_INDEX_BITS=$bits -c $unit -o $unit-$bits.o; done
    gcc -x c -std=c99 -I"$include" -DCQ_INDEX_BITS=$bits -Dmain=other_main -c first -o library-$bits.o
done
for bits in 16 32; do
    check unresolved gcc first-$bits.o second-$((48 - bits)).o -o program
    check gcc first-$bits.o second-$bits.o library-$((48 - bits)).o -o program && check ./program
done

check "${freestanding[@]}" -c first -o first.o && check no_symbols first.o
check "${freestanding[@]}" -mgeneral-regs-only -DCQ_NO_QUANTISER -c first -o integers.o
finish
