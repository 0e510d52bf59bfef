"""Adds up coverage of the header over all programs: report.py HEADER EXPORT.json ...

A line is covered if every region that begins on it ran in some program; a branch if both its outcomes were taken. A
line that ends in the comment `/* unreachable: why */` says that one outcome of its branches, or the line itself, cannot
happen; these marks are counted, and one that is wrong, because all of its line is reached, is a failure. Ends with
`N passed, N failed`; passes are lines and branches within the two limits.
"""
import collections
import json
import re
import sys

LINES = 1.00
BRANCHES = 0.99
MARK = re.compile(r"/\* unreachable: .*\*/\s*$")


def add(table, key, *counts):
    old = table.get(key, (0,) * len(counts))
    table[key] = tuple(a + b for a, b in zip(old, counts))


def gather(regions, branches, layouts, export, header):
    """Adds the counts of all instantiations of the header's functions, by place; and counts how each is cut into regions."""
    for function in export["data"][0]["functions"]:
        files = [name.endswith(header) for name in function["filenames"]]
        if not files[0]:
            continue
        layout = []
        for line, column, end_line, end_column, count, file, _, kind in function["regions"]:
            if files[file] and kind == 0:
                layout.append((line, column, end_line, end_column))
                add(regions, layout[-1], count)
        for line, column, end_line, end_column, yes, no, file, *_ in function["branches"]:
            if files[file]:
                add(branches, (line, column, end_line, end_column), yes, no)
        layouts.setdefault(layout[0][:2], collections.Counter())[tuple(layout)] += 1


def places(layouts, text):
    """Regions of the functions as most programs have them. Programs with macros of their own, for assertions or for parts
    that are left out, cut some functions in another way, and count only where both do. What begins with a space is the
    rest of an expression behind a constant, which has no counter."""
    common = {place for counts in layouts.values() for place in counts.most_common(1)[0][0]}
    return {place for place in common if text[place[0] - 1][place[1] - 1] != " "}


def part(name, reached, total, limit):
    share = reached / total if total else 0.0
    ok = total > 0 and share >= limit
    print(f"{'ok  ' if ok else 'FAIL'}  {reached} of {total} {name}, {100 * share:.2f} %, at least {100 * limit:.0f} %")
    return ok


def main(header, *exports):
    with open(header) as file:
        text = file.read().split("\n")
    regions, branches, layouts = {}, {}, {}
    for export in exports:
        with open(export) as file:
            gather(regions, branches, layouts, json.load(file), header)
    common = places(layouts, text)
    regions = {place: count for place, count in regions.items() if place in common}
    marked = {number for number, line in enumerate(text, 1) if MARK.search(line)}
    missed_lines = {place[0] for place, (count,) in regions.items() if not count}
    lines = {place[0] for place in regions}
    missed = {place: counts for place, counts in branches.items() if not all(counts)}
    for number in sorted(missed_lines - marked):
        print(f"not reached  {header}:{number}: {text[number - 1].strip()}")
    for (line, column, *_), (yes, _) in sorted(missed.items()):
        if line not in marked:
            print(f"never {'false' if yes else 'true '}  {header}:{line}:{column}: {text[line - 1].strip()}")
    outcomes = [count for place, counts in branches.items() if place[0] not in marked for count in counts]
    wrong = marked - missed_lines - {place[0] for place in missed}
    results = [
        part("lines", len(lines - marked - missed_lines), len(lines - marked), LINES),
        part("branch outcomes", sum(1 for count in outcomes if count), len(outcomes), BRANCHES),
    ]
    for number in sorted(wrong):
        print(f"FAIL  marked, but reached: {header}:{number}")
    print(f"{len(marked)} lines marked unreachable")
    results += [False] * len(wrong)
    print(f"{sum(results)} passed, {len(results) - sum(results)} failed")
    return 0 if all(results) else 1


if __name__ == "__main__":
    sys.exit(main(*sys.argv[1:]))
