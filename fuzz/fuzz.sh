#!/usr/bin/env bash
# fuzz.sh SECONDS: builds every target with libFuzzer, runs all of them for SECONDS in all, one after the other, and
# prints executions and coverage of each. build/fuzz/executions.tsv keeps the executions of all runs; those of the header
# as it is are added up, and the commits told. What the fuzzer keeps goes to build/fuzz/corpus/TARGET and is the start of the next run; what breaks a
# promise goes to build/fuzz/findings, and its replay is printed. The last line is `N passed, N failed`: targets without
# and with findings.
#
#     fuzz/fuzz.sh 600                  all targets; `make fuzz SECONDS=600`
#     fuzz/fuzz.sh 60 decode flip-16    only these
#     fuzz/fuzz.sh coverage             what the corpora and the committed inputs reach in the header (needs llvm-19)
#     fuzz/fuzz.sh reduce               rewrites fuzz/seeds with few inputs of the corpora that reach as much
set -euo pipefail
cd "$(dirname "$0")/.."

clang=${CLANG:-clang-19}
header_dir=${HEADER_DIR:-include}
warnings=(-Wall -Wextra -Wconversion -pedantic)
all=(decode lean chunks truncate flip roundtrip triangles mesh_ops range_coder mesh_file decode-16 lean-16 chunks-16 roundtrip-16
    decode-msan lean-msan)
most_bytes=1000

build() {
    local variant=$1 name=${1%-*} flags=(-O1 -fsanitize=fuzzer,address,undefined) mutator=()
    case $variant in
    lean*) flags=(-O2 -fsanitize=fuzzer,address) mutator=("build/fuzz/bin/$variant-mutator.o") ;;
    esac
    case $variant in
    *-16) flags+=(-DCQ_INDEX_BITS=16) ;;
    *-msan) flags=(-O1 -fsanitize=fuzzer,memory) ;;
    esac
    case $variant in
    lean*) flags+=(-fno-sanitize-coverage=trace-cmp) ;;     # no byte of a range coder is compared with anything
    esac
    [ ${#mutator[@]} = 0 ] || build_mutator "$variant" -o "${mutator[@]}"
    "$clang" -std=c99 -g "${warnings[@]}" "${flags[@]}" -fno-sanitize-recover=all \
        -I"$header_dir" -Iexamples -Itests/support "fuzz/$name.c" "${mutator[@]}" -lm -o "build/fuzz/bin/$variant"
}

# As fast as can be: its own decoding is not what is tested.
build_mutator() {
    local variant=$1 flags=(-O2)
    shift
    case $variant in
    *-16) flags+=(-DCQ_INDEX_BITS=16) ;;
    *-msan) flags+=(-fsanitize=memory) ;;       # what it writes is initialised
    esac
    fuzz/asked.sh "$header_dir/conquest.h" build/fuzz/asked
    "$clang" -std=c99 "${warnings[@]}" "${flags[@]}" -Ibuild/fuzz/asked -Itests/support -c fuzz/mutator.c "$@"
}

# Runs a target and prints one line of the table. libFuzzer's last status line has cov: blocks reached and ft: features.
run() {
    local variant=$1 seconds=$2 name=${1%-*} log=build/fuzz/$1.log status=0 fast=()
    mkdir -p "build/fuzz/corpus/$name"
    unset ASAN_OPTIONS
    case $name in
    lean)       # which block was reached counts, not how often: twice as many executions
        export ASAN_OPTIONS=quarantine_size_mb=1:malloc_context_size=0
        fast=(-use_counters=0)
        ;;
    esac
    # shellcheck disable=SC2046
    "build/fuzz/bin/$variant" -max_total_time="$seconds" -max_len=$most_bytes -timeout=20 -rss_limit_mb=2000 \
        "${fast[@]}" -dict=fuzz/dictionary.txt \
        -artifact_prefix="build/fuzz/findings/$variant-" $(inputs "$name") >"$log" 2>&1 || status=$?
    awk -v variant="$variant" -v status=$status -v commit="$commit" -v header="$header" '
        /^INFO: Loaded .* inline 8-bit counters/ { match($0, /\([0-9]+ inline/); blocks = substr($0, RSTART + 1) + 0 }
        / cov: [0-9]/ {
            for (i = 1; i < NF; i++) if ($i == "cov:") reached = $(i + 1); else if ($i == "ft:") features = $(i + 1)
        }
        /^#[0-9]+/ { executions = substr($1, 2) }
        END { print variant "\t" executions "\t" commit "\t" header >>"build/fuzz/executions.tsv"
              printf "%-14s %11d executions %7d of %5d blocks %8d features  %s\n", variant, executions, reached, blocks,
                     features, status == 0 ? "ok" : "FINDING, status " status }' "$log"
    if [ $status != 0 ]; then
        grep -E 'not true|runtime error|ERROR: |written, but' "$log" | head -n 3 | sed 's/^/    /'
        sed -n "s|.*Test unit written to \(.*\)|    replay: build/fuzz/bin/$variant \1|p" "$log"
    fi
    return $status
}

# The folders that a target starts from, those of them that there are.
inputs() {
    local folder
    for folder in "build/fuzz/corpus/$1" "fuzz/seeds/$1" "fuzz/regressions/$1"; do
        if [ -d "$folder" ]; then echo "$folder"; fi
    done
}

base_names() { printf '%s\n' "${all[@]}" | grep -v -- -; }

# Lines, functions and branches of the header that any input reaches, for each target and for all of them.
coverage() {
    local name objects=() version=${clang#clang}
    for name in $(base_names) all; do
        if [ "$name" != all ]; then
            "$clang" -std=c99 -O1 -fsanitize=fuzzer -fprofile-instr-generate -fcoverage-mapping \
                -I"$header_dir" -Iexamples -Itests/support "fuzz/$name.c" -lm -o "build/fuzz/bin/$name-coverage"
            # shellcheck disable=SC2046
            LLVM_PROFILE_FILE="build/fuzz/$name.profraw" "build/fuzz/bin/$name-coverage" -runs=0 $(inputs "$name") \
                >"build/fuzz/$name-coverage.log" 2>&1
            "llvm-profdata$version" merge "build/fuzz/$name.profraw" -o "build/fuzz/$name.profdata"
            objects+=(${objects:+-object} "build/fuzz/bin/$name-coverage")
            set -- "build/fuzz/bin/$name-coverage"
        else
            "llvm-profdata$version" merge build/fuzz/*.profraw -o build/fuzz/all.profdata
            set -- "${objects[@]}"
        fi
        "llvm-cov$version" report "$@" -instr-profile="build/fuzz/$name.profdata" "$header_dir/conquest.h" |
            awk -v name="$name" '/^TOTAL/ {
                printf "%-14s %4d of %4d lines (%s), %3d of %3d functions, %4d of %4d branches (%s)\n",
                    name, $8 - $9, $8, $10, $5 - $6, $5, $11 - $12, $11, $13
            }'
    done
}

reduce() {
    local name file
    for name in $(base_names); do
        rm -rf build/fuzz/few
        mkdir -p build/fuzz/few "fuzz/seeds/$name"
        "build/fuzz/bin/$name" -set_cover_merge=1 -use_counters=0 -max_len=300 build/fuzz/few \
            "build/fuzz/corpus/$name" >"build/fuzz/$name-reduce.log" 2>&1
        find "fuzz/seeds/$name" -type f -regex ".*/[0-9a-f]*" -delete        # those with names are kept
        for file in build/fuzz/few/*; do cp "$file" "fuzz/seeds/$name/$(basename "$file" | cut -c 1-12)"; done
        echo "$name: $(find "fuzz/seeds/$name" -type f | wc -l) seeds, $(cat "fuzz/seeds/$name"/* | wc -c) bytes"
    done
}

mkdir -p build/fuzz/bin build/fuzz/findings
case ${1:-} in
coverage | reduce)
    "$1"
    exit
    ;;
esac
seconds=${1:?seconds}
shift
targets=("$@")
[ $# -gt 0 ] || targets=("${all[@]}")
commit=$(git describe --always --dirty 2>/dev/null || echo unknown)
header=$(git hash-object "$header_dir/conquest.h")
passed=0 failed=0
for variant in "${targets[@]}"; do
    if build "$variant" && run "$variant" $(((seconds + ${#targets[@]} - 1) / ${#targets[@]})); then
        passed=$((passed + 1))
    else
        failed=$((failed + 1))
    fi
done
echo "all runs of this header:"
awk -F '\t' -v header="$header" '$4 == header { sum[$1] += $2; all += $2; commits[$3] = 1 }
    END { for (v in sum) printf "%-14s %11d executions\n", v, sum[v]; printf "%-14s %11d executions\n", "all", all
          printf "commits"; for (c in commits) printf " %s", c; print "" }' build/fuzz/executions.tsv
echo "$passed passed, $failed failed"
[ $failed = 0 ]
