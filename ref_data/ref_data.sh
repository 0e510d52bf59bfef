#!/bin/sh
# Reference data: ref_data.sh make | check
#
# make   makes the meshes of meshes.txt, and of each good one the streams of this library's format version, vN/:
#        NAME.cqm with positions, NAME.c.cqm without (--connectivity); of some NAME.l.cqm (--goal least-connectivity),
#        NAME.a.cqm with attributes, NAME.x.cqm with exact floats; SHA256SUMS of them and of what they decode to:
#        NAME.cqm.off the whole mesh, NAME.cqm.levels all levels, coarsest first; NAME.cqm.dump the mesh with all values,
#        of those with attributes or exact floats. Other versions are never touched.
# check  meshes come out of meshgen as they are here; streams of every version decode to the same hashes; this library
#        writes the same bytes again. The last line is `N passed, N failed`.
set -eu
cd "$(dirname "$0")"
cqm=../build/cqm
meshgen=../build/meshgen
out=../build/ref_data
channels=../build/tests/reference/channels
dump=../build/tests/reference/dump
least="grid random_genus_holes sphere terrain"
attributes="components_open cone_60 depths disc holes random_genus_holes tetrahedron triangle"
# positions, normals, colours, joints (copied), groups of faces; exact: positions, averaged and copied floats, of faces
with_attributes="0,0,3,12 2,0,2,10 4,0,3,8 5,1,4,8 8,2,1,5"
with_exact="0,0,3,32 1,0,1,32 6,1,2,32 1,2,1,32 0,0,3,14"
version=v$(sed -n 's/^#define CQ_STREAM_VERSION \([0-9]*\).*/\1/p' ../include/conquest.h)

list_meshes() { grep -v '^#' meshes.txt; }
list_good() { list_meshes | sed -n '/^bad\//d; s/\.off .*//p'; }
list_of() { # NAME: its streams
    echo "$1.cqm $1.c.cqm"
    case " $least " in *" $1 "*) echo "$1.l.cqm" ;; esac
    case " $attributes " in *" $1 "*) echo "$1.a.cqm $1.x.cqm" ;; esac
}
list_streams() { sed -n 's/.*  \(.*\.cqm\)$/\1/p' "$1"; }

# encode MESH STREAM: with the options that the stream's name asks for
encode() {
    # shellcheck disable=SC2086 # channels are words
    case $2 in
    *.c.cqm) "$cqm" encode --connectivity "$1" "$2" ;;
    *.l.cqm) "$cqm" encode --goal least-connectivity "$1" "$2" ;;
    *.a.cqm) "$channels" 1 $with_attributes <"$1" >"$2" ;;
    *.x.cqm) "$channels" 2 $with_exact <"$1" >"$2" ;;
    *) "$cqm" encode "$1" "$2" ;;
    esac
}

# decode STREAM FOLDER: all files that SHA256SUMS has for it
decode() {
    result=$2/${1##*/}
    case $1 in
    *.a.cqm | *.x.cqm)
        "$dump" <"$1" >"$result.dump"
        return
        ;;
    esac
    "$cqm" decode --quiet "$1" "$result.off"
    levels=$("$cqm" info --json "$1" | sed -n 's/.*"levels": *\([0-9]*\).*/\1/p')
    : >"$result.levels"
    level=0
    while [ "$level" -le "$levels" ]; do
        "$cqm" decode --quiet --level "$level" "$1" "$result.level.off"
        cat "$result.level.off" >>"$result.levels"
        level=$((level + 1))
    done
    rm "$result.level.off"
}

# make_mesh ARGUMENTS of meshes.txt
make_mesh() {
    if [ "$1" != join ]; then
        "$meshgen" "$@"
        return
    fi
    shift
    awk 'FNR == 1 { first += v; v = f = 0; next }
        FNR == 2 { v = $1; f = $2; next }
        FNR <= 2 + v { point[++points] = $0; next }
        { face[++faces] = "3 " $2 + first " " $3 + first " " $4 + first }
        END {
            print "OFF\n" points, faces, 0
            for (k = 1; k <= points; k++) print point[k]
            for (k = 1; k <= faces; k++) print face[k]
        }' $(printf '%s.off ' "$@")
}

make_meshes() {
    mkdir -p bad
    list_meshes | while read -r file arguments; do
        # shellcheck disable=SC2086 # arguments are words
        make_mesh $arguments >"$file"
    done
}

make_streams() {
    rm -rf "$version" "$out"
    mkdir -p "$version" "$out"
    list_good | while read -r name; do
        for stream in $(list_of "$name"); do
            encode "$name.off" "$version/$stream"
            decode "$version/$stream" "$out"
            cp "$version/$stream" "$out"
        done
    done
    (cd "$out" && sha256sum -- *) >"$version/SHA256SUMS"
}

passed=0
failed=0
check() {
    if "$@" >/dev/null 2>&1; then
        passed=$((passed + 1))
    else
        failed=$((failed + 1))
        echo "FAIL  $*"
    fi
}

is_made_again() {
    # shellcheck disable=SC2086
    make_mesh $2 | cmp - "$1"
}

decodes_as_before() {
    decode "$1/$2" "$out"
    grep " $2\(\.off\|\.levels\|\.dump\)\$" "$1/SHA256SUMS" | (cd "$out" && sha256sum -c --strict)
}

encodes_as_before() {
    encode "$2" "$out/$3" && cmp "$out/$3" "$1/$3"
}

check_all() {
    rm -rf "$out"
    mkdir -p "$out"
    while read -r file arguments; do
        case $file in \#*) continue ;; esac
        check is_made_again "$file" "$arguments"
    done <meshes.txt
    for sums in v*/SHA256SUMS; do
        [ -e "$sums" ] || continue
        for stream in $(list_streams "$sums"); do
            check decodes_as_before "${sums%/*}" "$stream"
        done
    done
    for name in $(list_good); do
        [ -d "$version" ] || continue
        for stream in $(list_of "$name"); do
            check encodes_as_before "$version" "$name.off" "$stream"
        done
    done
    echo "$passed passed, $failed failed"
    [ "$failed" -eq 0 ] && [ "$passed" -gt 0 ]
}

case ${1-} in
make) make_meshes && make_streams ;;
check) check_all ;;
*) echo "usage: ref_data.sh make | check" >&2; exit 2 ;;
esac
