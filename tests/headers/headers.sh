#!/bin/bash
# The header in every way that it may be compiled; prints what fails, and last `N passed, N failed`. With the argument
# `quick`: only whether compilers have something to say.
#
#   - both compilers, oldest and newest standards, both widths: included twice, before and behind the implementation, in
#     two units, or private; those between are compiled without making code
#   - decoders without any of their parts, encoders without some
#   - the two examples at the top of the header
#   - files that disagree about the width of indices or about regular levels do not link; libraries of both widths do
#   - a switch that changes the size of a public structure changes all names for the linker
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

# Code in the header's first comment, part $1 of those between empty lines, without what is said behind it.
example() {
    sed -nE '1,/^ \* Words/s/^ \*(    | *$)//p' "$include/conquest.h" | sed -E 's/([;{])  +[a-z0-9].*$/\1/' |
        awk -v part="$1" 'NF { if (!inside) n++; inside = 1; if (n == part) print } !NF { inside = 0 }'
}

examples() {
    cat <<C
$(example 1)
#include <stdlib.h>
$(example 2)
size_t read_some(uint8_t *bytes);
void draw(const cq_index *index, cq_index num_faces, const cq_value *values, cq_index num_vertices);
cq_result decode(void);
cq_result decode(void)
{
    cq_result result;
    uint8_t bytes[100];
    size_t n;
$(example 3)
    return result;
}
cq_result encode(uint32_t num_vertices, uint32_t num_faces, const float *floats,
                 const cq_index *indices, cq_value *values);
cq_result encode(uint32_t num_vertices, uint32_t num_faces, const float *floats,
                 const cq_index *indices, cq_value *values)
{
    static uint8_t out[1000];
    cq_result result;
    size_t size, stream_size, out_size = sizeof out;
    void *memory;
$(example 4)
    free(memory);
    return result;
}
C
}

finish() {
    echo "$passed passed, $failed failed"
    [ $failed = 0 ]
    exit
}

for compiler in gcc "$clang"; do
    for standard in c99 c11 c++11 c++17; do
        for bits in 16 32; do
            case $compiler$bits in # gcc warns of more where it optimises
            gcc32) optimised=-O2 ;;
            gcc16) optimised=-O1 ;;
            *) optimised=-O0 ;;
            esac
            options=(-x "${standard%%[0-9]*}" "-std=$standard" "-DCQ_INDEX_BITS=$bits" "$optimised" "${warnings[@]}" -I"$include")
            case $standard${1:-} in
            c11 | c++11 | *quick)
                syntax "$compiler" "${options[@]}"
                continue
                ;;
            esac
            check "$compiler" "${options[@]}" first second -o program && check ./program
            check "$compiler" "${options[@]}" -O0 private -o program && check ./program
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

for parts in -DCQ_NO_WEDGES "-DCQ_NO_WEDGES -DCQ_NO_REPORTS -DCQ_NO_QUANTISER"; do
    # shellcheck disable=SC2086 # words
    syntax gcc -x c -std=c99 "${warnings[@]}" -I"$include" $parts
done

examples >example.c
check grep -q cq_encode example.c
check gcc -std=c99 "${warnings[@]}" -I"$include" -fsyntax-only example.c

[ "${1:-}" != quick ] || finish

for bits in 16 32; do
    for unit in first second; do gcc -x c -std=c99 -I"$include" -DCQ_INDEX_BITS=$bits -c $unit -o $unit-$bits.o; done
    gcc -x c -std=c99 -I"$include" -DCQ_INDEX_BITS=$bits -Dmain=other_main -c first -o library-$bits.o
done
for bits in 16 32; do
    check unresolved gcc first-$bits.o second-$((48 - bits)).o -o program
    check gcc first-$bits.o second-$bits.o library-$((48 - bits)).o -o program && check ./program
done

# The widths and regular levels of a file, as flags
layouts=("-DCQ_INDEX_BITS=32" "-DCQ_INDEX_BITS=16" "-DCQ_INDEX_BITS=32 -DCQ_NO_REGULAR" "-DCQ_INDEX_BITS=16 -DCQ_NO_REGULAR")
for one in "${layouts[@]}"; do
    # shellcheck disable=SC2086 # words
    gcc -x c -std=c99 -I"$include" -DCQ_NO_ENCODER $one -c first -o first.o
    for other in "${layouts[@]}"; do
        # shellcheck disable=SC2086
        gcc -x c -std=c99 -I"$include" $other -c second -o second.o
        if [ "$one" = "$other" ]; then check gcc first.o second.o -o program; else
            check unresolved gcc first.o second.o -o program
        fi
    done
done

public_types() { sed -nE '/^#if.*CONQUEST_IMPLEMENTATION.*DONE/q; s/^\} (cq_[a-z_]+);$/\1/p' "$include/conquest.h"; }

# The sizes of public structures with these flags, each with what the linker calls them by.
sizes() {
    local name
    name=$(printf '#include "conquest.h"\nCQI_SYMBOL(suffix)\n' | gcc -E -P -I"$include" "$@" - | tail -n 1)
    {
        printf '#include "conquest.h"\n#include <stdio.h>\nint main(void) {\n'
        public_types | sed "s/.*/printf(\"& %zu $name\\\\n\", sizeof(&));/"
        printf 'return 0; }\n'
    } >sizes.c
    gcc -std=c99 -I"$include" "$@" sizes.c -o sizes && ./sizes
}

# Where one differs, all do, or the linker does not know.
agree() { # switch
    sizes "$1" >with.txt && sizes >without.txt && [ "$(wc -l <with.txt)" -gt 15 ] &&
        { cmp -s with.txt without.txt || ! grep -qxFf without.txt with.txt; }
}
for switch in $(grep -oE 'CQ_NO_(WEDGES|REGULAR|ATTRIBUTES|REPORTS|ENCODER|QUANTISER)' "$include/conquest.h" | sort -u) \
    CQ_INDEX_BITS=16; do
    check agree "-D$switch"
done

# Every function has such a name.
library_16() { gcc -x c -std=c99 -I"$include" -DCQ_INDEX_BITS=16 -Dmain=other_main_16 -c first -o library.o; }
named() { library_16 && [ "$(nm library.o | grep -c ' T .*_16$')" -gt 30 ] && ! nm library.o | grep ' T ' | grep -v '_16$'; }
check named

check "${freestanding[@]}" -c first -o first.o && check no_symbols first.o
check "${freestanding[@]}" -O0 -mgeneral-regs-only -DCQ_NO_QUANTISER -c first -o integers.o
finish
