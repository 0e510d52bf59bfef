#!/bin/sh
# Compares the meshes of the package, and with DIR those of that directory, if there is one: peers.sh [DIR]
#
#     build/peers/results.tsv    a line for each mesh, see peers.cpp
#     build/peers/skipped.txt    what was not compared, and why
set -eu
cd "$(dirname "$0")/../.."
out=build/peers
if [ -d "${1-}" ]; then set -- build/meshes "$1"; else set -- build/meshes; fi

# A pipe would hide the exit status.
find "$@" -type f \( -name '*.off' -o -name '*.ply' -o -name '*.obj' -o -name '*.stl' \) | LC_ALL=C sort >$out/files.txt
status=0
xargs -d '\n' $out/peers <$out/files.txt >$out/results.tsv 2>$out/skipped.txt || status=1
python3 tests/peers/report.py $out/results.tsv
echo
echo "$(wc -l <$out/files.txt) files, $(grep -c '^not compared' $out/skipped.txt || true) of them not compared" \
    "($out/skipped.txt); each mesh in $out/results.tsv"
if grep '^FAILED' $out/skipped.txt; then status=1; fi
exit $status
