#!/bin/sh
# asked.sh HEADER DIR: writes DIR/conquest.h for mutator.c, in which the definitions of the functions that decode have
# other names: original_decode_bit for cq_decode_bit and so on.
set -eu
mkdir -p "$2"
sed -E '/^CQ_API/!s/^([a-z0-9_]+) cq_(decode_(bit|slot|freq|raw))\(/\1 original_\2(/' "$1" >"$2/conquest.h"
renamed=$(diff "$1" "$2/conquest.h" | grep -c '^>') || true
[ "$renamed" = 4 ] || { echo "asked.sh: $renamed functions renamed, expected 4" >&2; rm "$2/conquest.h"; exit 1; }
