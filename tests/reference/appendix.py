#!/usr/bin/env python3
"""Appendix A of SPEC.md, generated from the header: appendix.py write | check

write  puts the tables of include/conquest.h into SPEC.md, between the two marks.
check  compares them; the last line is `N passed, N failed`.

Names and sizes of the bit models are read from the header too, so that a table that moves is a failure here.
SPDX-License-Identifier: MIT"""

import pathlib
import re
import sys
import textwrap

ROOT = pathlib.Path(__file__).resolve().parents[2]
SPEC = ROOT / "SPEC.md"
HEADER = ROOT / "include" / "conquest.h"
BEGIN, END = "<!-- appendix begin -->\n", "<!-- appendix end -->\n"
WIDTH = 118

# Names of SPEC.md for the tables of the header.
BIT_TABLES = [("COMPONENT", "COMPONENT"), ("LOOP", "LOOP"), ("OTHER_LEVEL", "OTHER_LEVEL"), ("SIDE", "SIDE"),
              ("GROW", "KIND_GROW"), ("TURN", "KIND_TURN"), ("CLOSE", "KIND_CLOSE"), ("FLAG", "FLAG"),
              ("BASE", "OF_BASE"), ("ALONG", "ALONG"), ("ACROSS", "ACROSS"), ("NORMAL", "NORMAL"), ("FAST", "FAST"),
              ("PLAIN", "PLAIN"), ("FACE", "FACE")]
BIT_USE = {"COMPONENT": "5.2", "LOOP": "5.3", "OTHER_LEVEL": "7.1", "SIDE": "7.3", "GROW": "5.4", "TURN": "5.4",
           "CLOSE": "5.4", "FLAG": "7.4", "BASE": "6.1", "ALONG": "6.1", "ACROSS": "6.1", "NORMAL": "6.1",
           "FAST": "6.7", "PLAIN": "6.1", "FACE": "6.5"}
WEIGHT_TABLES = [("SIZE_B", "SIZE_B"), ("SIZE_A", "SIZE_A"), ("STATE", "END_STATE"), ("VALENCE", "END_VALENCE"),
                 ("EDGE", "END_EDGE"), ("RULE", "RULE"), ("EDGES", "EDGES"), ("OUTER", "OUTER"),
                 ("BETWEEN", "BETWEEN")]


def number(text, names):
    """The value of a constant expression of C, or of SPEC.md."""
    return eval(text.replace("/", "//").replace("·", "*"), {"__builtins__": {}}, names)


def enum_values(header):
    """All enumerators and number macros of the header."""
    values = {}
    header = re.sub(r"/\*.*?\*/", "", header, flags=re.S)
    for _ in range(2):  # a macro may use an enumerator
        for name, text in re.findall(r"^#define (CQI?_\w+) +([\w ()+*/<-]+?) *$", header, flags=re.M):
            try:
                values[name] = number(re.sub(r"\(u?int32_t\)", "", text), values)
            except (NameError, SyntaxError, TypeError):
                pass
        for body in re.findall(r"enum *\{(.*?)\};", header, flags=re.S):
            at = -1
            for item in filter(None, (part.strip() for part in body.split(","))):
                name, _, text = (part.strip() for part in item.partition("="))
                at = number(text, values) if text else at + 1
                values[name] = at
    steps = re.search(r"#define CQI_RATE\(\w+\) (.*)", header).group(1)
    values["CQI_RATE"] = tuple(numbers(steps))
    return values


def numbers(text):
    return [int(n) for n in re.findall(r"-?\d+", text)]


def header_tables(header):
    """The lists of the header: bit priors, weight priors (three), shares."""
    names = "prior_bit", "prior_bare", "prior_located", "prior_fast", "shares"
    return [numbers(re.search(rf"cqi_{name}\[.*?\] = \{{(.*?)\}};", header, re.S).group(1)) for name in names]


def block(values):
    return "```\n" + textwrap.fill(", ".join(map(str, values)), WIDTH) + "\n```\n"


def appendix():
    header = HEADER.read_text()
    enum = enum_values(header)
    bits, weights, located, fast, shares = header_tables(header)
    starts = [enum["CQI_" + c] for _, c in BIT_TABLES] + [enum["CQI_MODELS"]]
    assert len(bits) == enum["CQI_PRIORS"] == enum["CQI_PLAIN"]
    assert len(weights) == enum["CQI_BARE_WEIGHTS"] == enum["CQI_EDGES"]
    assert len(fast) == enum["CQI_FAST_WEIGHTS"] == enum["CQI_RULE"]
    assert len(located) == enum["CQI_WEIGHTS"] and len(shares) == enum["CQI_SHARES"]
    text = "### A.1 Bit models\n\nA bit model begins with 256 · n + 128. The tables, one behind the other:\n\n"
    text += "| table | first | size | used in |\n| --- | --- | --- | --- |\n"
    for k, (name, _) in enumerate(BIT_TABLES):
        text += f"| {name} | {starts[k]} | {starts[k + 1] - starts[k]} | {BIT_USE[name]} |\n"
    text += "\nThe models of PLAIN begin like those of ALONG; those of FACE with n = 240. The n of all others:\n\n"
    text += block(bits)
    text += "\n### A.2 Weights of a stream that is not fast, without positions\n\n"
    text += f"A weight begins with n / 16 octave, that is 2^{enum['CQI_UNIT'] - 4} · n. Tables as in 8.2. Their n:\n\n"
    text += block(weights)
    text += "\n### A.3 Weights of a stream with positions\n\nAs in A.2:\n\n" + block(located)
    text += "\n### A.4 Weights of a fast stream\n\nAs in A.2:\n\n" + block(fast)
    text += f"\n### A.5 shares\n\n1 + 2^({enum['CQI_HEAVIEST']} - (k + 1/2) / 16), rounded down, for k = 0 .. "
    text += f"{enum['CQI_SHARES'] - 2}, and a last 1:\n\n" + block(shares)
    return text


def section(spec):
    begin, end = spec.index(BEGIN) + len(BEGIN), spec.index(END)
    return begin, end


def rows_of_weights(spec):
    """The table of 8.2: name -> (first, size)."""
    text = spec[spec.index("### 8.2"):spec.index("### 8.3")]
    rows = re.findall(r"^\| ([A-Z_]+) \| (\d+) \| ([\d ·]+) \| ", text, re.M)
    return {name: (int(first), number(size, {})) for name, first, size in rows}


def check():
    """Pairs: what is compared, whether it agrees."""
    spec, enum = SPEC.read_text(), enum_values(HEADER.read_text())
    begin, end = section(spec)
    rows = rows_of_weights(spec)
    firsts = [enum["CQI_" + c] for _, c in WEIGHT_TABLES] + [enum["CQI_WEIGHTS"]]
    results = [("appendix A", spec[begin:end] == appendix())]
    for k, (name, _) in enumerate(WEIGHT_TABLES):
        results.append(("8.2 " + name, rows.get(name) == (firsts[k], firsts[k + 1] - firsts[k])))
    for name in "CQI_SETTLED", "CQI_MOST":
        enum[name] >>= enum["CQI_UNIT"]
    enum["last_share"] = enum["CQI_SHARES"] - 1
    enum["spreads"] = enum["CQI_SPREADS"], enum["CQI_SPREADS"] - 1
    enum["residual"] = tuple(enum["CQI_" + name] for name in ("SIGN", "TOP", "BITS"))
    enum["kinds"] = tuple(enum[f"CQI_{b}"] - enum[f"CQI_{a}"] for a, b in [("OF_BASE", "ALONG"), ("ALONG", "ACROSS"),
                          ("ACROSS", "NORMAL"), ("NORMAL", "FAST"), ("PLAIN", "FACE")])
    for name, text in [("CQ_STREAM_VERSION", "Version %d of the format"), ("CQ_MAX_LEVELS", "at most %d"),
                       ("CQ_MAX_VALENCE", "valence is above %d"),
                       ("CQI_RATE", "n < %d: %d; else n < %d: %d; else %d"), ("CQI_UNIT", "2^-%d octave"),
                       ("CQI_STEP", "unit = %d · 2^14 / T"), ("CQI_LIMIT_EVERY", "a multiple of %d, each weight"),
                       ("CQI_LEARN_EVERY", "a multiple of %d, weights move:"), ("spreads", "%d numbers mean[0 .. %d]"),
                       ("CQI_LOCATED", "if %d candidates before it"), ("last_share", "min(t >> 18, %d)"),
                       ("CQI_SETTLED", "highest plain score minus %d octaves, or"),
                       ("CQI_MOST", "beyond %d octaves is set"),
                       ("residual", "SIGN is model %d, TOP[n] is model %d + n and BITS[n] is model %d + n"),
                       ("CQI_TURNED_BITS", "at most %d bits per value"), ("CQ_MAX_CHANNELS", "0 .. %d")]:
        results.append((name, name in enum and text % enum[name] in " ".join(spec.split())))
    return results


def report(results):
    for name, good in results:
        if not good:
            print("FAIL  SPEC.md and the header differ:", name)
    failed = sum(not good for _, good in results)
    print(f"{len(results) - failed} passed, {failed} failed")
    return 1 if failed or not results else 0


def write():
    spec = SPEC.read_text()
    begin, end = section(spec)
    SPEC.write_text(spec[:begin] + appendix() + spec[end:])
    return 0


if __name__ == "__main__":
    if sys.argv[1:] not in (["write"], ["check"]):
        sys.exit(__doc__)
    sys.exit(write() if sys.argv[1] == "write" else report(check()))
