#!/bin/sh
# Compares the meshes of the package, and with DIR those of that directory, if there is one: peers.sh [DIR]
#
#     build/peers/results.tsv    a line for each mesh, see peers.cpp
#     build/peers/skipped.txt    what was not compared, and why
set -eu
cd "$(dirname "$0")/../../.."
out=build/peers
if [ -d "${1-}" ]; then set -- build/meshes "$1"; else set -- build/meshes; fi

find "$@" -type f \( -name '*.off' -o -name '*.ply' -o -name '*.obj' -o -name '*.stl' \) | LC_ALL=C sort >$out/files.txt
tests/measure/peers/compare.sh $out/files.txt $out/peers tests/measure/peers/report.py $out/results.tsv $out/skipped.txt
