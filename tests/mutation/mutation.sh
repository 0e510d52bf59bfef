#!/bin/bash
# Mutation testing: how many small changes of the header do the tests notice?
#
#     tests/mutation/mutation.sh [COUNT]      a sample of 300, or of COUNT
#     tests/mutation/mutation.sh only NUMBER ...
#
# Each mutant of mutate.py is built into the programs of `stages`, one after the other until one of them fails, prints
# something else than with the header as it is, or runs out of processor time: then it is killed. A mutant that does not
# compile is none, nor is one that an optimising compiler makes the same code of. Survivors that change nothing that
# anybody could see are listed in explained.txt, with the reason, and do not count.
#
# JOBS mutants are tried at once, as many as there are cores if it is not said. A run that was interrupted goes on where
# it was: build/mutation/HASH.tsv keeps what became of the mutants of a header.
# Survivors are tried again, for the tests may have become better. The last line is `N passed, N failed`: 1 passed if at
# least 97 % were killed; survivors are printed.
set -u
shopt -s nullglob
cd "$(dirname "$0")/../.." || exit 1
root=$PWD
clang=${CLANG:-clang-19}
jobs=${JOBS:-$(nproc)}
base=build/mutation
work=$base
least=97
killed=0 survived=0 explained=0 same=0 invalid=0
flags=(-w -Itests/support -Iexamples '-DCQ_ASSERT(c)=((c) ? (void)0 : __builtin_trap())')
sanitizers=(-fsanitize=address,undefined -fno-sanitize-recover=all)
meshes=(ref_data/*.off ref_data/bad/*.off)
mutate() { python3 tests/mutation/mutate.py include/conquest.h "$@"; }

compile() { # include-directory program source... options
    local include=$1 program=$2
    shift 2
    case $1 in
    *.cpp) g++ -std=c++17 -I"$include" "${flags[@]}" "$@" -lrapidcheck -o "$program" ;;
    *) "$clang" -std=c99 -I"$include" "${flags[@]}" "$@" -lm -o "$program" ;;
    esac 2>"$program.log"
}

# Seconds of processor time, and bytes in a file: so that a loaded machine kills no more than an idle one.
limited() { # seconds command...
    (
        ulimit -t "$1" -f 1000000
        shift
        exec "$@"
    )
}

# The stages, those first that kill most in the least time; each prints what must be the same as without a mutant. 2: it
# does not compile. Not optimised: that is built ten times as fast.
stages=(portability unit/range_coder unit/header unit/quantiser unit/mesh unit/encoder unit/decoder unit/levels unit/lods
    unit/wedges unit/attributes unit/labels unit/polygon
    same_code unit-16/header unit-16/mesh unit-16/encoder unit-16/decoder fuzz ref_data narrow
    checked/range_coder checked/header checked/mesh checked/encoder checked/decoder checked/levels
    property/range_coder property/quantiser property/mesh property/codec regular)

stage() { # name include-directory
    local program=$work/program status
    case $1 in
    portability)
        compile "$2" "$program" tests/portability/portability.c || return 2
        limited 5 "$program" "${meshes[@]}"
        ;;
    unit/*)
        compile "$2" "$program" "tests/$1.c" || return 2
        limited 20 "$program"
        ;;
    regular)
        compile "$2" "$program" tests/unit/regular.c -O1 || return 2
        limited 60 "$program"
        ;;
    unit-16/*)
        compile "$2" "$program" "tests/unit/${1#*/}.c" -DCQ_INDEX_BITS=16 || return 2
        limited 20 "$program"
        ;;
    checked/*)
        compile "$2" "$program" "tests/unit/${1#*/}.c" -O1 "${sanitizers[@]}" || return 2
        limited 20 "$program"
        ;;
    narrow)
        compile "$2" "$program" tests/portability/portability.c -DCQ_INDEX_BITS=16 "${sanitizers[@]}" || return 2
        limited 20 "$program" "${meshes[@]}"
        ;;
    ref_data)
        compile "$2" "$program" examples/cqm/*.c examples/mesh_file/*.c || return 2
        replay "$program" >"$work/said" 2>&1
        status=$?
        sed "s,$work/,,g" "$work/said"
        return $status
        ;;
    fuzz) fuzz_replay "$2" "$program" ;;
    same_code) code "$2" ;;
    property/*)
        compile "$2" "$program" "tests/$1.cpp" -O1 || return 2
        RC_PARAMS="seed=1" limited 20 "$program"
        ;;
    esac
}

# Reports, levels and prefixes of the reference meshes.
replay() { # program
    local mesh
    for mesh in ref_data/*.off; do
        limited 5 "$1" encode "$mesh" "$work/stream" || return 1
        limited 5 "$1" info --json "$work/stream" || return 1
        limited 5 "$1" decode --quiet --level 1 "$work/stream" "$work/decoded.off" || return 1
        limited 5 "$1" decode --quiet --bytes 80 "$work/stream" "$work/decoded.off"
        sha256sum <"$work/decoded.off"
    done
}

# The committed inputs, those of the operations and of hostile streams.
fuzz_replay() { # include-directory program
    local source name objects=()
    for source in fuzz/*.c; do
        name=$(basename "${source%.c}")
        case $name in work | mutator) continue ;; esac
        "$clang" -std=c99 -w -I"$1" -Iexamples -Itests/support "${sanitizers[@]}" -DLLVMFuzzerTestOneInput="fuzz_$name" \
            -c "$source" -o "$work/$name.o" 2>/dev/null || return 2
        objects+=("$work/$name.o")
    done
    "$clang" "${sanitizers[@]}" "${objects[@]}" -lm -o "$2" && limited 30 "$2"
}

# The header compiled, with both widths of indices.
code() { # include-directory
    local bits
    for bits in 32 16; do
        gcc -std=c99 -O2 -S -w -DCONQUEST_IMPLEMENTATION -DCQ_INDEX_BITS=$bits -x c - -o - <"$1/conquest.h"
    done
}

# What a stage prints without a mutant, twice the same; found when it is first needed.
expect() { # name
    [ -e "$base/expected/$1" ] && return 0
    mkdir -p "$(dirname "$base/expected/$1")"
    stage "$1" "$root/include" >"$work/now" 2>&1 </dev/null &&
        stage "$1" "$root/include" >"$work/again" 2>&1 </dev/null &&
        cmp -s "$work/now" "$work/again" && mv "$work/again" "$base/expected/$1"
}

# Prints the stage that notices the header in a directory, or `none`, `same` or `invalid`; or `broken` and a stage that
# fails without a mutant, or does not print the same twice.
first_to_notice() { # include-directory
    local name status
    for name in "${stages[@]}"; do
        expect "$name" || { echo "broken $name"; return; }
        stage "$name" "$1" >"$work/now" 2>&1 </dev/null
        status=$?
        if [ "$name" = same_code ]; then
            if cmp -s "$work/now" "$base/expected/$name"; then echo same; return; fi
            continue
        fi
        if [ $status = 2 ] && [ "$name" = portability ]; then echo invalid; return; fi
        if [ $status != 0 ] || ! cmp -s "$work/now" "$base/expected/$name"; then echo "$name"; return; fi
    done
    echo none
}

is_explained() { # column old new source
    awk -F'\t' -v key="$1|$2|$3|$4" '!/^#/ && $1 "|" $2 "|" $3 "|" $4 == key { found = 1 } END { exit !found }' \
        tests/mutation/explained.txt
}

known() { # number
    awk -F'\t' -v number="$1" '$1 == number { by = $2 } END { print by }' "$results"
}

# Every jobs-th mutant of the list, in a directory of its own.
try_some() { # which
    local number by at=0
    work=$base/job-$1
    mkdir -p "$work/mutant"
    while IFS=$'\t' read -r number _; do
        [ $((at++ % jobs)) = "$1" ] || continue
        by=$(known "$number")
        [ -n "$by" ] && [ "$by" != none ] && continue
        mutate write "$number" "$work/mutant/conquest.h"
        by=$(first_to_notice "$work/mutant")
        printf '%s\t%s\n' "$number" "$by" >>"$results"
        case $by in broken*) return 1 ;; esac
    done <<<"$list"
}

count() { # number line column old new source
    local by
    by=$(known "$1")
    case $by in
    '' | broken*)
        echo "without a mutant, stage ${by#* } fails, or does not print the same twice"
        echo "0 passed, 1 failed"
        exit 1
        ;;
    invalid) invalid=$((invalid + 1)) ;;
    same) same=$((same + 1)) ;;
    none)
        if is_explained "$3" "$4" "$5" "$6"; then
            explained=$((explained + 1)) by=explained
        else
            survived=$((survived + 1)) by='SURVIVED'
        fi
        ;;
    *) killed=$((killed + 1)) ;;
    esac
    printf '%-20s  %s: line %d, column %d: %s -> %s in: %s\n' "$by" "$1" "$2" "$3" "$4" "$5" "$6"
}

rm -rf "$base/expected"
mkdir -p "$base/expected"
results=$work/$(sha256sum <include/conquest.h | cut -c 1-16).tsv
touch "$results"
sed -i '/\tbroken/d' "$results"
if [ "${1:-}" = only ]; then
    shift
    list=$(for number; do mutate list | grep "^$number	"; done)
else
    list=$(mutate sample "${1:-300}")
fi
for ((job = 0; job < jobs; job++)); do try_some $job & done
wait
while IFS=$'\t' read -r number line column old new source; do
    count "$number" "$line" "$column" "$old" "$new" "$source"
done <<<"$list"
total=$((killed + survived))
echo "$killed of $total killed; of the others $same are the same code, $explained change nothing," \
    "$invalid do not compile"
if [ $total -gt 0 ] && [ $((100 * killed)) -ge $((least * total)) ]; then
    echo "1 passed, 0 failed"
else
    echo "0 passed, 1 failed"
    exit 1
fi
