#!/bin/sh
# Compares the files that a list has: compare.sh LIST PROGRAM REPORT RESULTS SKIPPED. Its status is 1 if a comparison failed.
#
#     PROGRAM    writes a line for each mesh, and to standard error what it did not compare, and why
#     REPORT     a Python program, prints what the lines come to
set -eu
list=$1 program=$2 report=$3 results=$4 skipped=$5

# A pipe would hide the exit status.
status=0
xargs -d '\n' "$program" <"$list" >"$results" 2>"$skipped" || status=1
python3 "$report" "$results"
echo
echo "$(wc -l <"$list") files, $(grep -c '^not compared' "$skipped" || true) of them not compared" \
    "($skipped); each mesh in $results"
if grep '^FAILED' "$skipped"; then status=1; fi
exit $status
