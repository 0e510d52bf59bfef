#!/usr/bin/env python3
"""Compares the numbers that documents quote with what commands printed last.   SPDX-License-Identifier: MIT

    quotes.py [--list] [--gate] [DOCUMENT ...]   those of DOCUMENTS; --list also shows what was found and where;
                                                 --gate compares only what `make test` prints, and lists the others

A paragraph, list item or table row quotes the commands that it names as `make NAME`, but a sentence that names some quotes
those alone; a table without one those of the paragraph before it. Of any other paragraph or sentence quotes.tsv says what
it quotes, and which numbers no command prints because they are no measurements. Each other number must be among those that one of its commands printed: as it is, or, if it
has decimals, rounded. A row of a table is looked for in the lines with its first cell and the two that follow each, if
there are any. Headings of tables, code, addresses and words such as 12-bit or C99 hold no numbers.

A number fails if it has no command, or if its commands print other numbers or were not run: what they print is kept in
build/printed by `make NAME`, and in build/log by tests. Nearest numbers that were printed instead are told. The last line is `N passed, N failed`.
"""
import glob
import importlib.util
import re
import sys
from decimal import ROUND_HALF_EVEN, ROUND_HALF_UP, Decimal
from pathlib import Path

HERE = Path(__file__).resolve().parent
ROOT = HERE.parent.parent
DOCUMENTS = ["README.md", "SECURITY.md", "tests/README.md", "tests/measure/README.md"]
NUMBER = re.compile(r"(?<![\w.,/-])(?:\d{1,3}(?: \d{3})+|\d+(?:\.\d+)?)(?![\w]|-[a-z]|\.\d)")
PRINTED = re.compile(r"\d+(?:\.\d+)?")
GROUPED = re.compile(r"\d{1,3}(?:[ ,]\d{3})+")
COMMAND = re.compile(r"`make ([a-z0-9-]+)[^`]*`")
SENTENCE_END = re.compile(r"[.;:](?=\s+[A-Z`])")
NOISE = re.compile(r"`[^`]*`|<!--.*?-->|\]\([^)]*\)|https?://\S+|!\[[^\]]*\]", re.S)

# Where a command's output is, if it is not in build/printed/NAME.txt or below build/log.
SOURCES = {
    "test": ["build/log/**/*.log"],
    "figures": ["tests/embedded/figures.tsv", "tests/embedded/budgets.tsv"],
    "embedded": ["tests/embedded/figures.tsv", "tests/embedded/budgets.tsv"],
    "web-test": ["build/log/web-*.log"],
    "fuzz": ["build/printed/fuzz.txt"],
    "bench": ["build/printed/bench.txt", "build/bench/results.csv"],
}


# What `make test` runs: in its logs, or before it, or for this.
GATE = {"demo", "test", "exhaustive", "cgal", "web-test", "meshes", "figures", "embedded", "fuzz-work", "memory"}


class Printed:
    """What a command printed last, in lines and as numbers."""

    def __init__(self, command):
        patterns = SOURCES.get(command, [f"build/printed/{command}.txt", f"build/log/{command}.log",
                                         f"build/log/{command}/*.log", f"build/log/verify/{command}*.log"])
        paths = sorted({path for pattern in patterns for path in glob.glob(str(ROOT / pattern), recursive=True)})
        self.lines = [line for path in paths for line in Path(path).read_text("utf-8", "replace").splitlines()]
        self.numbers = numbers_of(self.lines)

    def has(self, quoted, name):
        """The number as it is or rounded, in the lines with the name if there are some."""
        found = [k for k, line in enumerate(self.lines) if name and name.lower() in line.lower()]
        lines = [line for k in found for line in self.lines[k:k + 3]]
        return any(map(quoted.__eq__, rounded(numbers_of(lines) if lines else self.numbers, quoted)))


def numbers_of(lines):
    found = set()
    for line in lines:
        found.update(Decimal(text) for text in PRINTED.findall(line))
        found.update(Decimal(re.sub("[ ,]", "", text)) for text in GROUPED.findall(line))
    return found


def rounded(numbers, quoted):
    exponent = quoted.as_tuple().exponent
    for number in numbers:
        yield number
        if exponent < 0 and number.as_tuple().exponent < exponent:
            for rule in (ROUND_HALF_UP, ROUND_HALF_EVEN):
                yield number.quantize(Decimal(1).scaleb(exponent), rule)


def blocks_of(lines):
    """Pairs of the first line's number and text: paragraphs, list items, and rows of tables. Headings begin with #."""
    block, fenced = [], False
    for number, line in enumerate(lines, 1):
        begins = not line.strip() or re.match(r"\s*(- |\|)", line) or line.startswith(("#", "<!--", "```"))
        if begins and block and not fenced:
            yield block[0][0], "\n".join(text for _, text in block)
            block = []
        if line.startswith("```"):
            fenced = not fenced
        elif line.strip() and not fenced:
            block.append((number, line))
    if block:
        yield block[0][0], "\n".join(text for _, text in block)


def rules_of(document):
    """Rows of quotes.tsv: phrases whose numbers are fixed, and commands of blocks."""
    fixed, commands = [], []
    for line in (HERE / "quotes.tsv").read_text("utf-8").splitlines():
        if line and not line.startswith("#"):
            of, words, command = line.split("\t")[:3]
            if of in (document, "*"):
                (fixed if command == "fixed" else commands).append((words, command))
    return fixed, commands


def commands_in(text, rules):
    """Those that the text names, and those that quotes.tsv says."""
    found = COMMAND.findall(text)
    for words, command in rules:
        if re.search(words_pattern(words), text):
            found += command.split(",")
    return found


def sentence_at(text, place):
    ends = [0, *(match.end() for match in SENTENCE_END.finditer(text)), len(text)]
    return next(text[begin:end] for begin, end in zip(ends, ends[1:]) if place < end)


def words_pattern(words):
    return r"\s+".join(map(re.escape, words.split()))


def blank(text, pattern):
    return re.sub(pattern, lambda match: re.sub(r"\S", " ", match.group()), text)


def nearest(printed, quoted):
    """Up to three numbers that were printed, nearest first."""
    found = sorted({n for p in printed for n in p.numbers}, key=lambda n: abs(n - quoted))
    return ", ".join(f"{n}" for n in found[:3])


class Check:
    def __init__(self, show, gate):
        self.show, self.gate, self.passed, self.failed, self.printed = show, gate, 0, 0, {}
        self.not_compared = {}

    def result(self, ok, where, text):
        self.passed += ok
        self.failed += not ok
        if self.show or not ok:
            print(f"{'ok   ' if ok else 'FAIL '} {where}: {text}")

    def number(self, where, text, commands, name):
        quoted = Decimal(text.replace(" ", ""))
        commands = list(dict.fromkeys(command.rstrip("*") for command in commands))
        if self.gate and commands and not GATE.intersection(commands):
            self.not_compared.setdefault(" or ".join(commands), []).append(f"{where}: {text}")
            return
        for command in commands:
            self.printed.setdefault(command, Printed(command))
        ran = [self.printed[command] for command in commands if self.printed[command].lines]
        told = f"make {' or '.join(commands)}" + (f" of {name}" if name else "")
        if not commands:
            self.result(False, where, f"{text} has no command")
        elif any(printed.has(quoted, name) for printed in ran):
            self.result(True, where, f"{text} ({', '.join(commands)})")
        elif len(ran) < len(commands) and self.gate:
            self.not_compared.setdefault(" or ".join(commands), []).append(f"{where}: {text}")
        elif ran:
            self.result(False, where, f"{text} is not what {told} printed last; {nearest(ran, quoted)}")
        else:
            self.result(False, where, f"{text}: {told} was not run")

    def document(self, document):
        fixed, rules = rules_of(document)
        unused = {words for words, _ in fixed + rules}
        headings = [words for words, _ in fixed if words.startswith("## ")]
        heading, before, generated = "", [], False
        blocks = list(blocks_of((ROOT / document).read_text("utf-8").splitlines()))
        for (number, text), (_, following) in zip(blocks, blocks[1:] + [(0, "")]):
            if text.startswith("<!--"):
                generated = " begin " in text
            if generated or text.startswith("<!--"):
                continue
            if text.startswith("#"):
                heading, before = text, []
                continue
            is_row = text.lstrip().startswith("|")
            commands = commands_in(text, [])
            for words, command in rules:
                if re.search(words_pattern(words), heading + "\n" + text):
                    commands += command.split(",")
                    unused.discard(words)
            whole = text
            if is_row and not commands:
                commands = before
            before = commands
            if is_row and following.startswith("| ---"):
                continue
            if heading in headings:
                unused.discard(heading)
                continue
            named = is_row and not any(command.endswith("*") for command in commands)
            name = re.sub(r"[`*]", "", text.split("|")[1]).split("(")[0].strip() if named else ""
            for words, _ in fixed:
                if re.search(words_pattern(words), text):
                    text = blank(text, words_pattern(words))
                    unused.discard(words)
            for match in NUMBER.finditer(blank(text, NOISE)):
                line = number + text.count("\n", 0, match.start())
                own = [] if is_row else commands_in(sentence_at(whole, match.start()), rules)
                self.number(f"{document}:{line}", match.group(), own or commands, name)
        for words in sorted(unused):
            self.result(False, "quotes.tsv", f"{document} no longer has: {words}")

    def generated(self):
        """README's tables, which tests/embedded/readme.py makes of figures and results."""
        spec = importlib.util.spec_from_file_location("readme", ROOT / "tests/embedded/readme.py")
        readme = importlib.util.module_from_spec(spec)
        spec.loader.exec_module(readme)
        text = (ROOT / "README.md").read_text("utf-8")
        figures, budgets = (readme.read(ROOT / f"tests/embedded/{name}.tsv") for name in ("figures", "budgets"))
        same = readme.replace(text, "figures", readme.tables(figures, budgets)) == text
        self.result(same, "README.md", "table of figures, as make figures has it")
        results = ROOT / "build/bench/results.csv"
        if self.gate:
            return
        same = results.exists() and readme.replace(text, "bench", readme.bench_table(results)) == text
        self.result(same, "README.md", "table of the bench, as make bench printed it last" +
                    ("" if results.exists() else ", which was not run"))


def main():
    arguments = sys.argv[1:]
    check = Check("--list" in arguments, "--gate" in arguments)
    for document in [a for a in arguments if not a.startswith("-")] or DOCUMENTS:
        check.document(document)
    check.generated()
    for commands, numbers in sorted(check.not_compared.items()):
        print(f"not compared, make {commands} prints them: {len(numbers)}" + (": " + ", ".join(numbers) if check.show else ""))
    print(f"{check.passed} passed, {check.failed} failed")
    sys.exit(check.failed != 0 or check.passed == 0)


if __name__ == "__main__":
    main()
