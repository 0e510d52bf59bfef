#!/bin/sh
# Compares meshes with attributes: assets.sh SET=FOLDER..., the OBJ files of these; of assimp's those of all formats.
#
#     build/peers/inputs         small files that inputs.py makes, compared too
#     build/peers/assets.tsv     a line for each mesh, see assets.cpp
#     build/peers/assets.txt     what was not compared, and why
set -eu
cd "$(dirname "$0")/../../.."
out=build/peers
rm -rf $out/inputs
python3 tests/measure/peers/inputs.py $out/inputs
for set in inputs=$out/inputs "$@"; do
    case $set in assimp*) kinds='obj|ply|stl|off' ;; *) kinds=obj ;; esac
    test -d "${set#*=}"
    find "${set#*=}" -type f | grep -iE "\.($kinds)\$"
done | LC_ALL=C sort >$out/asset_files.txt
tests/measure/peers/compare.sh $out/asset_files.txt $out/assets tests/measure/peers/assets_report.py $out/assets.tsv $out/assets.txt
