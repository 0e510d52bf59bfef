#!/bin/sh
# Round trip of every mesh at hand: check.sh CQM [--update]
#
# Each mesh of ref_data, build/meshes (make meshes) and build/generated (generated.txt, made here) goes through
# `CQM verify` with positions and through `CQM verify --connectivity`. The outcome, `ok`, the counts and what is told of a
# mesh that is no oriented manifold of triangles, or `refused` and the reason, is compared with expected.tsv; --update writes
# that file instead. The last line is `N passed, N failed`.
set -eu
cd "$(dirname "$0")/../.."
cqm=$1
expected=tests/meshes/expected.tsv
found=build/found.tsv

make_generated() {
    mkdir -p build/generated
    grep -v '^#' tests/meshes/generated.txt | while read -r file arguments; do
        # shellcheck disable=SC2086 # arguments are words
        build/meshgen $arguments >"build/generated/$file"
    done
}

# told: the messages in build/verify.log, in one line
told() {
    sed -n 's|^cqm: [^ ]*: ||p' build/verify.log | sed 's|; decoding gives all of it back||' | tr '\n' ';' | sed 's|;$||; s|;|; |g'
}

# outcome MESH [OPTION]: "ok TAB counts", "refused TAB reason", or for any other exit status "crashed TAB reason"
outcome() {
    mesh=$1
    shift
    status=0
    "$cqm" verify "$@" "$mesh" >build/verify.log 2>&1 || status=$?
    reason=$(tail -n 1 build/verify.log | sed 's|^cqm: ||; s|^[^ ]*: ||')
    case $status in
    0) counts=$(grep ': ok, ' build/verify.log | sed 's/.*: ok, //; s/ faces, .*/ faces/')
        messages=$(told)
        printf 'ok\t%s%s\n' "$counts" "${messages:+, told: $messages}" ;;
    1) printf 'refused\t%s\n' "$reason" ;;
    *) printf 'crashed\tstatus %s: %s\n' "$status" "$reason" ;;
    esac
}

# One line for a mesh: path, outcome; both outcomes if they differ.
row() {
    full=$(outcome "$1")
    connectivity=$(outcome "$1" --connectivity)
    if [ "$full" = "$connectivity" ]; then
        printf '%s\t%s\n' "$1" "$full"
    else
        printf '%s\t%s\tbut --connectivity: %s\n' "$1" "$full" "$connectivity"
    fi
}

make_generated
for mesh in build/meshes/* build/generated/*.off ref_data/*.off ref_data/bad/*.off; do
    row "$mesh"
done >$found

if [ "${2-}" = --update ]; then
    cp $found $expected
    exit
fi
status=0
diff $expected $found || status=1
passed=$(grep -Fxc -f $expected $found || true)
failed=$(grep -Fxvc -f $found $expected || true)
[ $status -eq 0 ] || [ "$failed" -gt 0 ] || failed=1
echo "$passed passed, $failed failed"
exit $status
