#!/bin/bash
# What a reader should not have to notice. Prints each line that fails, and last `N passed, N failed`, in files and rules.
#
#   - .editorconfig: no tabs but in makefiles, no blanks at ends of lines, a newline at the end; lines of 120 columns but for some
#   - one brace style: that of a function has a line of its own
#   - names: what the header defines begins with cq_, CQ_, cqi_ or CQI_, whatever is private included
#   - a function of the header is defined before it is called: sections do not call upwards, but for a few that are named
#   - the shell has nothing to say of scripts (shellcheck, if it is there, else bash -n), nor python of its own
set -u
shopt -s lastpipe
cd "$(dirname "$0")/../.." || exit 1
header=include/conquest.h
most_long=500 # lines of more than 120 columns; may become fewer
passed=0 failed=0

# $(1) what is checked; the input has its failures
check() {
    local said
    said=$(cat)
    if [ -z "$said" ]; then
        passed=$((passed + 1))
    else
        failed=$((failed + 1))
        printf 'FAIL %s\n%s\n' "$1" "$(head -n 20 <<<"$said")"
    fi
}

texts() { git ls-files '*.[ch]' '*.[ch]pp' '*.py' '*.sh' '*.js' '*.ts' '*.mk' Makefile; }
programs() { git ls-files '*.[ch]' '*.[ch]pp' '*.py' '*.sh' '*.js' '*.ts'; }

# Definitions of functions, macros and types of the header, one a line: the first word after the return type, #define, or
# the one before the ; of a typedef.
names() {
    sed -nE 's/^([a-z_][a-z0-9_ ]* \*?)?([a-z_0-9]+)\(.*[^;,]$/\2/p; s/^#define ([A-Za-z_0-9]+).*/\1/p; s/^} ([a-z_0-9]+);$/\1/p' \
        $header
}

# Private functions that are declared before they are defined.
upwards='cqi_model_keep|cqi_step_base_values|cqi_preparing_bytes|cqi_prepared_bytes|cqi_is_seam'
declared() { sed -nE 's/^static [a-z0-9_ ]*[ *](cqi?_[a-z0-9_]+)\(.*\);$/\1/p' $header; }

programs | xargs grep -nP '^\s*\t' | check 'tabs'
texts | xargs grep -nE '[[:blank:]]+$' | check 'blanks at the end of a line'
texts | while read -r file; do [ -z "$(tail -c 1 "$file")" ] || echo "$file"; done | check 'no newline at the end'
texts | xargs awk -v most=$most_long 'length($0) > 120 { text = text "\n" FILENAME ":" FNR; n++ }
    END { if (n > most) print n " lines, at most " most ": " text }' | check 'lines of more than 120 columns'
git ls-files '*.[ch]' '*.[ch]pp' | xargs grep -nE '^[A-Za-z_].*\)( const)? \{$' | check 'braces of functions'
{ [ "$(names | wc -l)" -gt 500 ] || echo "only $(names | wc -l) names were found"; } | check 'names are found'
names | grep -vE '^(cqi?_|CQI?_)|^CONQUEST_IMPLEMENTATION' | check 'names that do not begin with cq'
declared | grep -vwE "$upwards" | check 'functions that are called before they are defined'
if command -v shellcheck >/dev/null; then
    git ls-files '*.sh' .ci/run | xargs shellcheck -S warning -e SC2034,SC2046,SC2054,SC2128,SC2178 -f gcc 2>&1 | check 'shellcheck'
else
    git ls-files '*.sh' .ci/run | while read -r file; do bash -n "$file" 2>&1; done | check 'bash -n'
fi
git ls-files '*.py' | xargs python3 -W error -c 'import ast, sys
from pathlib import Path
for path in sys.argv[1:]: ast.parse(Path(path).read_text("utf-8"), path)' 2>&1 | check 'python'

echo "$passed passed, $failed failed"
[ $failed = 0 ]
