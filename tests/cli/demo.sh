#!/bin/sh
# `make demo`: encodes some meshes, decodes them at several levels into build/demo and prints a table.
#
# The last level is checked against the input by `cqm verify`; whatever fails ends the demo with its message and exit
# status 1. Bits per vertex: the whole stream with 12-bit positions, and the connectivity alone (--connectivity).
# Seconds are of processor time.
set -eu
cd "$(dirname "$0")/../.."
cqm=build/cqm
out=build/demo
meshes="build/meshes/fandisk.off build/meshes/bunny00.off build/meshes/armadillo.off build/meshes/couplingdown.off
    build/meshes/cheese.off build/meshes/lion-head.off build/meshes/elephant-with-holes.off build/meshes/bones.off
    build/meshes/boeing.off ref_data/random_genus_holes.off"

# number KEY: the value of a key in the JSON text that `info` holds
number() {
    printf '%s\n' "$info" | sed -n "s/^ *\"$1\": *\([0-9.]*\).*/\1/p"
}

# seconds COMMAND...: runs it and prints the processor time that it took
seconds() {
    spent=$("$@" >/dev/null && times) || return 1
    printf '%s\n' "$spent" | tail -n 1 | awk '{ gsub(/[ms]/, " "); printf "%.2f", $1 * 60 + $2 + $3 * 60 + $4 }'
}

# decode_levels NAME LEVELS: the base, then levels at a third and two thirds of the way, then the whole mesh
decode_levels() {
    for level in 0 $(($2 / 3)) $(($2 * 2 / 3)) "$2"; do
        "$cqm" decode --level "$level" "$out/$1.cqm" "$out/$1.level$level.off"
    done
}

# per_vertex BYTES: in bits
per_vertex() {
    awk -v bytes="$1" -v vertices="$vertices" 'BEGIN { printf "%.2f", 8 * bytes / vertices }'
}

row() {
    printf '%-20s %6s %6s %5s %5s %5s %4s %8s %7s %7s %7s %7s\n' "$@"
}

# show MESH: one line of the table
show() {
    name=$(basename "$1" .off)
    encode_seconds=$(seconds "$cqm" encode "$1" "$out/$name.cqm")
    decode_seconds=$(seconds "$cqm" decode "$out/$name.cqm" "$out/$name.off")
    "$cqm" encode --connectivity "$1" "$out/$name.connectivity.cqm"
    connectivity=$(wc -c <"$out/$name.connectivity.cqm")
    info=$("$cqm" info --json "$out/$name.cqm")
    levels=$(number levels)
    vertices=$(number vertices)
    bytes=$(number bytes)
    decode_levels "$name" "$levels"
    cmp "$out/$name.level$levels.off" "$out/$name.off"
    "$cqm" verify "$1" >/dev/null
    row "$name" "$vertices" "$(number faces)" "$(number genus)" "$(number boundary_loops)" "$(number components)" \
        "$levels" "$bytes" "$(per_vertex "$bytes")" "$(per_vertex "$connectivity")" "$encode_seconds" "$decode_seconds"
}

# show_order MESH: bits per vertex of the numbers of --keep-order, and of exact coordinates
show_order() {
    name=$(basename "$1" .off)
    "$cqm" encode --keep-order --bits 32 "$1" "$out/$name.order.cqm"
    info=$("$cqm" info --json "$out/$name.order.cqm")
    printf '%s\n' "$info" | awk -v name="$name" -v vertices="$(number vertices)" -F '[:,}]' '
        /^ *"bits": [{]/ {
            for (i = 1; i < NF; i++) if ($i ~ /"positions"/) positions = $(i + 1); else if ($i ~ /"channels"/) order = $(i + 1)
            printf "%s, %d vertices: the order of vertices takes %.1f bits per vertex, exact coordinates %.1f\n",
                name, vertices, order / vertices, positions / vertices
        }'
}

rm -rf "$out"
mkdir -p "$out"
row '' '' '' '' bound- comp- lev- '' bits/ connec- encode decode
row mesh V F genus aries nents els bytes vertex tivity s s
for mesh in $meshes; do
    show "$mesh"
done
for mesh in build/meshes/elephant.off build/meshes/bunny00.off; do
    show_order "$mesh"
done
echo "Each mesh came back exactly. Levels as OFF files, coarsest first: $out/NAME.level*.off"
