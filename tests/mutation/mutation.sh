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
# Those that are explained are not tried, unless they are asked for.
#
# JOBS mutants are tried at once, as many as there are cores if it is not said. A run that was interrupted goes on where
# it was: build/mutation/HASH.tsv keeps what became of the mutants of a header.
# Survivors are tried again, for the tests may have become better. The last line is `N passed, N failed`: 1 passed if at
# least 97 % were killed; survivors are printed.
set -u
shopt -s nullglob
cd "$(dirname "$0")/../.." || exit 1
clang=${CLANG:-clang-19}
jobs=${JOBS:-$(nproc)}
base=build/mutation
work=$base
least=97
killed=0 survived=0 explained=0 same=0 invalid=0
flags=(-w -DTEST_STOPS -Itests/support -Iexamples '-DCQ_ASSERT(c)=((c) ? (void)0 : __builtin_trap())')
private='cqi_|CQI_|define CQ_(ASSERT|NO_)'
meshes=(ref_data/*.off ref_data/bad/*.off)
subdivided=(build/generated/subdivided/*.off)
mutate() { python3 tests/mutation/mutate.py include/conquest.h "$@"; }

# A build is quick to compile, or fast to run, or checked by sanitizers, at which an optimising compiler is slow; also with
# 16-bit indices.
compile() { # build argument...
    local build=$1 by=("$clang")
    shift
    case $build in
    fast*) by=(gcc -O2) ;;
    checked*) by+=(-O1) ;;
    esac
    case $build in *checked*) by+=("-fsanitize=address,undefined" -fno-sanitize-recover=all) ;; esac
    case $build in *-16) by+=(-DCQ_INDEX_BITS=16) ;; esac
    case " $* " in *.cpp\ *) by+=(-x c++ -std=c++17) ;; *) by+=(-std=c99) ;; esac
    "${by[@]}" "${flags[@]}" "$@" 2>"$work/log"
}

# The header, compiled once for each build, beside it.
library() { # build include-directory
    [ -e "$2/$1.o" ] || compile "$1" -DCONQUEST_IMPLEMENTATION -c -x c "$2/conquest.h" -o "$2/$1.o"
}

# A program that looks at what is private compiles its own. Others are compiled once: mutants are in the implementation.
program() { # build include-directory source...
    local build=$1 include=$2 source object objects=()
    shift 2
    if grep -qE "$private" "$@"; then
        compile "$build" -I"$include" "$@" -lm -o "$work/program"
        return
    fi
    for source; do
        object=$base/objects/$build/$source.o
        mkdir -p "${object%/*}"
        [ -e "$object" ] ||
            compile "$build" -Iinclude -DCONQUEST_IMPLEMENTATION_DONE -c "$source" -o "$object" || return
        objects+=("$object")
    done
    library "$build" "$include" || return
    case $1 in *.cpp) objects+=(-lrapidcheck -lstdc++) ;; esac
    compile "$build" "${objects[@]}" "$include/$build.o" -lm -o "$work/program"
}

# Seconds of processor time, and bytes in a file: so that a loaded machine kills no more than an idle one.
limited() { # seconds command...
    (
        ulimit -t "$1" -f 1000000
        shift
        exec "$@"
    )
}

# The stages, BUILD/TEST, those first that kill most in the least time; each prints what must be the same as without a
# mutant. 2: it does not compile.
stages=(quick/portability quick/unit/{range_coder,header,quantiser,mesh,planes,lods,attributes,textures,fits,labels,polygon} fast/same
    quick/cqm quick/channels fast/unit/{wedges,levels,decoder} quick-checked/unit/{range_coder,header,mesh} quick/unit/encoder
    fast/unit/regular fast/meshes quick-checked/fuzz quick-16/unit/{header,mesh,encoder} fast-16/unit/decoder
    quick-checked-16/portability fast/property/{range_coder,quantiser,mesh,codec} checked/unit/{levels,decoder,encoder})

stage() { # name include-directory
    local build=${1%%/*} test=${1#*/}
    case $test in
    same) for build in fast fast-16; do library $build "$2" && sha256sum <"$2/$build.o"; done ;;
    portability)
        program "$build" "$2" tests/portability/portability.c || return 2
        limited 6 "$work/program" "${meshes[@]}"
        ;;
    unit/*)
        program "$build" "$2" "tests/$test.c" || return 2
        limited 60 "$work/program"
        ;;
    property/*)
        program "$build" "$2" "tests/$test.cpp" || return 2
        RC_PARAMS="seed=1" limited 60 "$work/program"
        ;;
    cqm)
        program "$build" "$2" examples/cqm/*.c examples/mesh_file/*.c || return 2
        replay "$work/program"
        ;;
    meshes)
        program "$build" "$2" examples/cqm/*.c examples/mesh_file/*.c || return 2
        encode_meshes "$work/program"
        ;;
    channels)
        program "$build" "$2" tests/reference/channels.c || return 2
        hash_streams "$work/program"
        ;;
    fuzz) fuzz_replay "$build" "$2" ;;
    esac
}

# Reports, levels and prefixes of the reference meshes. What is printed must not name a folder: other jobs have others.
replay() { # program
    local mesh
    for mesh in ref_data/*.off; do
        limited 5 "$1" encode --connectivity "$mesh" "$work/stream" || return 1
        sha256sum <"$work/stream"
        limited 5 "$1" encode "$mesh" "$work/stream" || return 1
        limited 5 "$1" info --json "$work/stream" || return 1
        limited 5 "$1" decode --quiet --level 1 "$work/stream" "$work/decoded.off" || return 1
        limited 5 "$1" decode --quiet --bytes 80 - "$work/decoded.off" <"$work/stream"
        sha256sum <"$work/decoded.off"
    done
}

# Streams of the published meshes, and of some that are regular: what an encoder chooses shows in its bytes.
encode_meshes() { # program
    local mesh options
    for mesh in build/meshes/*.off "${subdivided[@]}"; do
        for options in "" --connectivity; do
            # shellcheck disable=SC2086 # no option is no word
            limited 20 "$1" encode --quiet $options "$mesh" "$work/stream" 2>/dev/null
            sha256sum <"$work/stream"
        done
    done
}

# Streams with channels of all kinds, without and with seams, of surfaces with and without boundary, and with regular
# levels; then with texture coordinates, tangents, joints and weights; normals and tangents of regular meshes.
hash_streams() { # program
    local mesh seed channels
    for mesh in ref_data/{components_open,random_genus_holes,disc,cylinder_40x1,sphere,torus_12x8}.off; do
        for seed in {1..12} {1000..1011}; do
            limited 5 "$1" "$seed" <"$mesh" | sha256sum
            limited 5 "$1" "$seed" 0,0,3,12 3,0,2,12 10,0,3,10 5,1,4,8 6,0,4,8 <"$mesh" | sha256sum
        done
    done
    for mesh in "${subdivided[@]}"; do
        for seed in 0 1 1000; do
            for channels in 1,0,2,10 2,0,2,10 "3,0,2,12 10,0,3,10"; do
                # shellcheck disable=SC2086 # words
                limited 5 "$1" $seed 0,0,3,12 $channels <"$mesh" | sha256sum
            done
        done
    done
}

# The committed inputs, those of the operations and of hostile streams. The header is compiled once for most targets.
fuzz_replay() { # build include-directory
    local name all=()
    for name in decode lean chunks truncate flip roundtrip triangles mesh_ops; do
        printf '#define LLVMFuzzerTestOneInput fuzz_%s\n#include "fuzz/%s.c"\n#undef LLVMFuzzerTestOneInput\n' $name $name
    done >"$work/all.c"
    for name in range_coder mesh_file run; do
        all+=("$work/$name.o")
        compile "$1" -I"$2" -DLLVMFuzzerTestOneInput=fuzz_$name -c fuzz/$name.c -o "$work/$name.o" || return 2
    done
    compile "$1" -I"$2" -I. "$work/all.c" "${all[@]}" -lm -o "$work/program" && limited 60 "$work/program"
}

# What a stage prints without a mutant, twice the same; found when it is first needed, while other jobs wait.
expect() { # name
    local expected=$base/expected/$1
    (
        flock 9
        [ -e "$expected" ] && exit 0
        mkdir -p "${expected%/*}"
        stage "$1" "$base/header" >"$work/now" 2>&1 </dev/null &&
            stage "$1" "$base/header" >"$work/again" 2>&1 </dev/null &&
            cmp -s "$work/now" "$work/again" && mv "$work/again" "$expected"
    ) 9>"$base/lock"
}

# Prints the stage that notices the header in a directory, or `none`, `same` or `invalid`; or `broken` and a stage that
# fails without a mutant, or does not print the same twice.
first_to_notice() { # include-directory
    local name status
    for name in "${stages[@]}"; do
        expect "$name" || { echo "broken $name"; return; }
        stage "$name" "$1" >"$work/now" 2>&1 </dev/null
        status=$?
        if [ "$name" = fast/same ]; then
            if cmp -s "$work/now" "$base/expected/$name"; then echo same; return; fi
            continue
        fi
        if [ $status = 2 ] && [ "$name" = "${stages[0]}" ]; then echo invalid; return; fi
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
    local number line column old new source by at=0
    work=$base/job-$1
    while IFS=$'\t' read -r number line column old new source; do
        [ $((at++ % jobs)) = "$1" ] || continue
        case $(known "$number") in '' | none | explained) ;; *) continue ;; esac
        rm -rf "$work"
        mkdir -p "$work/mutant"
        mutate write "$number" "$work/mutant/conquest.h"
        if [ "$which" = sample ] && is_explained "$column" "$old" "$new" "$source"; then
            by=explained
        else
            by=$(first_to_notice "$work/mutant")
        fi
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
    none | explained)
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

rm -rf "$base"/{expected,objects,header}
mkdir -p "$base/header"
cp include/conquest.h "$base/header"
which=sample
results=$work/$(sha256sum <include/conquest.h | cut -c 1-16).tsv
touch "$results"
sed -i '/\tbroken/d' "$results"
if [ "${1:-}" = only ]; then
    shift
    which=only
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
