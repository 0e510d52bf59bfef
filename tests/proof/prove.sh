#!/bin/bash
# Runs the claims of README.md, or with --bugs shows that each fails on a header with a bug in it.
#
#     tests/proof/prove.sh [--bugs] [NAME ...]
#
# A row of the table says harness, claim, options and functions to replace by stubs. A claim passes if CBMC proves it
# and if the end of the harness can be reached at all (with `assert(0)` there it must fail). Verification that runs out
# of time, or a verifier that cannot be had, is a failure. The last line is `N passed, N failed`.
set -u
here=$(cd "$(dirname "$0")" && pwd)
root=$(cd "$here/../.." && pwd)
tools=${CBMC_DIR:-$root/build/cbmc}
work=$root/build/proof
limit=${PROOF_SECONDS:-1800}
passed=0 failed=0
mkdir -p "$work"
model=$work/model.$$.gb
trap 'rm -rf "$model" "$work/planted.$$"' EXIT

checks=(--bounds-check --pointer-check --div-by-zero-check --signed-overflow-check --undefined-shift-check
    --pointer-overflow-check --pointer-primitive-check --unwinding-assertions --slice-formula --drop-unused-functions)

# Of meshes without a bound, only what the claim itself says, and static variables are the verifier's choice.
said=(--no-standard-checks --unwinding-assertions --slice-formula --drop-unused-functions)

# To see that the end of a harness is reached, nothing else is asked.
reach=(--no-standard-checks --no-unwinding-assertions --slice-formula --drop-unused-functions)

# The cells of a table whose first cell is `name`, one row a line, separated by tabs.
rows() { # file
    sed -n 's/^| `\(.*\) |$/\1/p' "$1" | sed 's/` | `/\t/g; s/` | /\t/; s/ | `/\t/g; s/`$//'
}

# Prints proved, refuted or what else happened.
verify() { # include-directory harness claim replace options...
    local include=$1 harness=$2 claim=$3 replace=$4 defines=() options=() stubs=() option asked=("${checks[@]}")
    shift 4
    for option; do
        case $option in
        -DPROOF_REACH) defines+=("$option") asked=("${reach[@]}") ;;
        cvc5) options+=(--nondet-static --cvc5) asked=("${said[@]}") ;;
        -D*) defines+=("$option") ;;
        kissat) options+=(--external-sat-solver "$tools/bin/kissat") ;;
        *) options+=("$option") ;;
        esac
    done
    for option in ${replace#-}; do stubs+=(--replace-calls "$option"); done
    "$tools/bin/goto-cc" "$here/$harness.c" -I "$include" $bits "${defines[@]}" --function "claim_$claim" \
        -o "$model" >"$work/$claim.log" 2>&1 || { echo "not compiled"; return; }
    if [ ${#stubs[@]} != 0 ]; then
        "$tools/bin/goto-instrument" "${stubs[@]}" "$model" "$model" >>"$work/$claim.log" 2>&1 ||
            { echo "not instrumented"; return; }
    fi
    timeout "$limit" "$tools/bin/cbmc" "$model" "${asked[@]}" "${options[@]}" >"$work/$claim.log" 2>&1
    case $? in
    0) grep -q '^VERIFICATION SUCCESSFUL' "$work/$claim.log" && echo proved || echo "no verdict" ;;
    10) echo refuted ;;
    124) echo "out of time" ;;
    *) echo "verifier failed" ;;
    esac
}

report() { # verdict name seconds
    if [ "$1" = ok ]; then
        passed=$((passed + 1))
    else
        failed=$((failed + 1))
    fi
    printf '%-5s %-34s %5d s%s\n' "$([ "$1" = ok ] && echo ok || echo FAIL)" "$2" "$3" \
        "$([ "$1" = ok ] || echo ": $1")"
}

# A claim, and that its end is reached.
prove() { # harness claim replace options
    local bits='' options=$4 verdict
    case " $options " in *' --32 '*) bits=-m32 options=${options/--32/} ;; esac
    verdict=$(verify "$root/include" "$1" "$2" "$3" $options)
    [ "$verdict" = proved ] || { echo "$verdict"; return; }
    verdict=$(verify "$root/include" "$1" "$2" "$3" $options -DPROOF_REACH)
    [ "$verdict" = refuted ] && echo ok || echo "its end is not reached ($verdict)"
}

# A bug is a `sed` expression for the header; the claim must then be refuted.
plant() { # harness claim replace options expression
    local bits='' options=$4 verdict
    case " $options " in *' --32 '*) bits=-m32 options=${options/--32/} ;; esac
    mkdir -p "$work/planted.$$"
    sed "$5" "$root/include/conquest.h" >"$work/planted.$$/conquest.h"
    cmp -s "$root/include/conquest.h" "$work/planted.$$/conquest.h" && { echo "the bug changes nothing"; return; }
    verdict=$(verify "$work/planted.$$" "$1" "$2" "$3" $options --stop-on-fail)
    [ "$verdict" = refuted ] && echo ok || echo "the bug is not found ($verdict)"
}

wanted() { # name
    [ ${#names[@]} = 0 ] && return 0
    local name
    for name in "${names[@]}"; do [ "$name" = "$1" ] && return 0; done
    return 1
}

bugs=0
[ "${1:-}" = --bugs ] && { bugs=1; shift; }
names=("$@")
if ! "$here/fetch.sh" "$tools" >"$work/fetch.log" 2>&1; then
    tail -n 3 "$work/fetch.log"
    echo "not run: the verifier could not be fetched"
    echo "0 passed, 1 failed"
    exit 1
fi

while IFS=$'\t' read -r name text harness claim options replace; do
    wanted "$name" || continue
    if [ $bugs = 0 ]; then
        start=$SECONDS
        verdict=$(prove "$harness" "$claim" "$replace" "$options")
        report "$verdict" "$name" $((SECONDS - start))
        continue
    fi
    while IFS=$'\t' read -r of expression; do
        [ "$of" = "$name" ] || continue
        start=$SECONDS
        verdict=$(plant "$harness" "$claim" "$replace" "$options" "$expression")
        report "$verdict" "$name: $expression" $((SECONDS - start))
    done < <(grep -v '^#' "$here/bugs.txt")
done < <(rows "$here/README.md")
echo "$passed passed, $failed failed"
[ $failed = 0 ] && [ $passed != 0 ]
