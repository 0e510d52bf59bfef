#!/bin/sh
# asked.sh HEADER DIR: writes DIR/conquest.h for mutator.c and tests/exhaustive/regular.cpp, in which the definitions of
# the functions that decode have other names: original_decode_raw for cq_decode_raw and so on. Those that are private are
# declared in their place.
set -eu
mkdir -p "$2"
sed -E '/^CQ_API/!s/^([a-z0-9_]+) cq_(decode_(slot|freq|raw))\(/\1 original_\2(/
    s/^static inline int cqi_(decode_(adaptive|part)\((.*)\))$/static int cqi_\1;\nstatic inline int original_\1/' "$1" >"$2/conquest.h"
renamed=$(grep -c '^[a-z0-9_ ]* original_decode_[a-z]*(' "$2/conquest.h") || true
[ "$renamed" = 5 ] || { echo "asked.sh: $renamed functions renamed, expected 5" >&2; rm "$2/conquest.h"; exit 1; }
