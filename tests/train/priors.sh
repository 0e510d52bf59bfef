#!/bin/sh
# The priors of conquest.h, which stand between `/* priors begin */` and `/* priors end */`.
#
#     priors.sh write    puts what build/train learns from tests/train/meshes.txt into the header
#     priors.sh check    compares that with the header: exit status 1 if they differ
#
# Run by `make train` and `make check-train`. Takes a minute or two. What was learned stays in build/priors.txt.
set -eu
cd "$(dirname "$0")/../.."
header=include/conquest.h
priors=build/priors.txt
list=tests/train/meshes.txt

fail() {
    echo "train: $1" >&2
    exit 1
}

# Prints the header with the learned priors between its marks.
trained_header() {
    awk -v priors="$priors" '
        $0 == "/* priors end */" { inside = 0 }
        !inside { print }
        $0 == "/* priors begin */" { inside = 1; while ((getline line <priors) > 0) print line }' $header
}

[ "$(grep -o '^/\* priors [a-z]* \*/$' $header | tr -d '\n')" = '/* priors begin *//* priors end */' ] ||
    fail "$header needs the two marks of the priors, each once"

meshes=$(sed '/^#/d; s|^|build/meshes/|' $list)
for mesh in $meshes; do
    [ -e "$mesh" ] || fail "$list names $mesh, which is not there"
done
# shellcheck disable=SC2086 # names without spaces
build/train $meshes >$priors
trained_header >build/conquest.h.trained

if cmp -s build/conquest.h.trained $header; then
    echo "train: the priors of $header are those of $list"
elif [ "$1" = write ]; then
    cp build/conquest.h.trained $header.part
    mv $header.part $header
    echo "train: new priors in $header"
else
    fail "the priors of $header differ from those of $list, which are in $priors"
fi
