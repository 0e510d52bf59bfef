#!/bin/sh
# manual.sh CQM: writes the manual page of the program, cqm.1, from what its --help says. SPDX-License-Identifier: MIT
set -eu
cqm=$1

# Texts, and entries of two columns: "  NAME  text", where the name may have the line for itself.
format() {
    awk '
        function escape(s) { gsub(/\\/, "\\e", s); gsub(/-/, "\\-", s); return s ~ /^[.\047]/ ? "\\&" s : s }
        /^$/ { print ".PP"; next }
        /^  [^ ]/ {
            text = substr($0, 3); at = match(text, /  +/)
            print ".TP\n.B " escape(at ? substr(text, 1, at - 1) : text)
            if (at) print escape(substr(text, at + RLENGTH))
            next
        }
        { sub(/^ +/, ""); print escape($0) }'
}

version=$("$cqm" --version)
cat <<EOF
.\" Made by manual.sh from what cqm says of itself.
.TH CQM 1 "" "$version" "User Commands"
.SH NAME
cqm \\- progressive to lossless coding of triangle meshes
.SH SYNOPSIS
.B cqm
.I COMMAND
.RI [ OPTION ]...
.IR FILE ...
.SH DESCRIPTION
EOF
"$cqm" --help | sed 1,2d | format
for command in encode decode info verify trace; do
    printf '.SH CQM %s\n' "$(echo $command | tr a-z A-Z)"
    "$cqm" $command --help | sed '2d; 1s/^/  /' | format
done
cat <<'EOF'
.SH LICENSE
MIT
EOF
