#!/bin/bash
# Coverage of the header by the unit tests, the property tests, the reference meshes and the committed fuzz inputs.
#
#     tests/coverage/coverage.sh
#
# Each program is built with clang's source-based coverage and without assertions; report.py adds up what all of them
# reach, line by line and branch by branch, and decides. Properties draw the same meshes in each run. The last line is
# `N passed, N failed`.
set -u
shopt -s nullglob
cd "$(dirname "$0")/../.." || exit 1
clang=${CLANG:-clang-19}
version=${clang#clang}
work=build/coverage
flags=(-O1 -g -fprofile-instr-generate -fcoverage-mapping -Iinclude -Iexamples -Itests/support)
reports=()
export RC_PARAMS=seed=1

build() { # name source... options
    local name=$1
    shift
    case $1 in
    *.cpp) set -- "${clang/clang/clang++}" -std=c++17 "${flags[@]}" "$@" -lrapidcheck ;;
    *) set -- "$clang" -std=c99 "${flags[@]}" "$@" -lm ;;
    esac
    "$@" -o "$work/$name" 2>"$work/$name.log" || { echo "not built: $name"; return 1; }
    export LLVM_PROFILE_FILE=$PWD/$work/$name.raw/%8m.profraw
}

# What a program reached. Each has its own report: the same function of two builds need not have the same counters.
export_counts() { # name
    "llvm-profdata$version" merge "$work/$1.raw"/*.profraw -o "$work/$1.profdata" &&
        "llvm-cov$version" export -instr-profile="$work/$1.profdata" "$work/$1" include/conquest.h >"$work/$1.json" ||
        return 1
    reports+=("$work/$1.json")
}

run() { # name arguments...
    local name=$1
    shift
    "$work/$name" "$@" >"$work/$name.log" 2>&1 || { echo "failed: $name $*"; return 1; }
}

# Encodes a reference mesh in both ways, and decodes whole streams, levels and prefixes.
replay() { # mesh
    local stream=$work/stream options
    for options in "" --connectivity; do
        # shellcheck disable=SC2086 # no option is no word
        "$work/cqm" encode $options "$1" "$stream" >/dev/null 2>&1 || return 0
        "$work/cqm" decode --quiet "$stream" "$work/decoded.off" || return 1
        "$work/cqm" decode --quiet --level 1 "$stream" "$work/decoded.off" || return 1
        "$work/cqm" decode --quiet --bytes 60 "$stream" "$work/decoded.off" >/dev/null 2>&1
        head -c 60 "$stream" | "$work/cqm" trace - >/dev/null 2>&1
        "$work/cqm" trace "$stream" >/dev/null || return 1
        "$work/cqm" info "$stream" >/dev/null || return 1
    done
}

everything() {
    local source name
    for source in tests/unit/*.c tests/property/*.cpp; do
        name=$(basename "${source%.*}")-${source##*.}
        [ "$name" = index_width-cpp ] && continue # renames by macros, which cuts the header into other regions
        build "$name" "$source" && run "$name" && export_counts "$name" || return 1
    done
    for source in tests/unit/*.c; do
        name=$(basename "${source%.c}")-16
        [ "$name" = words-16 ] && continue # cqm has 32-bit indices
        build "$name" "$source" -DCQ_INDEX_BITS=16 && run "$name" && export_counts "$name" || return 1
    done
    build cqm examples/cqm/*.c examples/mesh_file/*.c || return 1
    for source in ref_data/*.off ref_data/bad/*.off; do
        replay "$source" || { echo "failed: cqm of $source"; return 1; }
    done
    export_counts cqm || return 1
    local objects=()
    for source in fuzz/*.c; do
        name=$(basename "${source%.c}")
        case $name in work | mutator) continue ;; esac
        "$clang" -std=c99 "${flags[@]}" -DLLVMFuzzerTestOneInput="fuzz_$name" -c "$source" -o "$work/$name.o" ||
            return 1
        objects+=("$work/$name.o")
    done
    build fuzz "${objects[@]}" && run fuzz && export_counts fuzz
}

rm -rf "$work"
mkdir -p "$work"
if ! everything; then
    echo "0 passed, 1 failed"
    exit 1
fi
python3 tests/coverage/report.py include/conquest.h "${reports[@]}"
