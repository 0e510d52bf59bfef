#!/bin/sh
# The code of one of README's doors: door.sh NAME. SPDX-License-Identifier: MIT
awk -v begin="<!-- door: $1 -->" '
    $0 == begin { door = 1; next }
    door && /^```/ { if (code) exit; code = 1; next }
    code { print; lines++ }
    END { exit !lines }' "$(dirname "$0")/../../README.md"
