#!/usr/bin/env python3
"""Appendix A of SPEC.md, generated from the header, and its worked example: appendix.py write [CQM] | check

write  puts the tables of include/conquest.h into SPEC.md, between two marks; and with CQM, the program, the stream of
       the example and what decoder.py makes of it between two others.
check  compares the tables; the last line is `N passed, N failed`. (compare.py checks the example.)

Names and sizes of the bit models are read from the header too, so that a table that moves is a failure here.
SPDX-License-Identifier: MIT"""

import math
import pathlib
import re
import subprocess
import sys
import tempfile
import textwrap

sys.dont_write_bytecode = True

ROOT = pathlib.Path(__file__).resolve().parents[2]
SPEC = ROOT / "SPEC.md"
HEADER = ROOT / "include" / "conquest.h"
BEGIN, END = "<!-- %s begin -->\n", "<!-- %s end -->\n"
WIDTH = 118

# Names of SPEC.md for the tables of the header, and where they are used.
BIT_TABLES = [("COMPONENT", "COMPONENT", "5.2"), ("LOOP", "LOOP", "5.3"), ("OTHER_LEVEL", "OTHER_LEVEL", "7.1"),
              ("BEGINS", "BEGINS", "7.3"), ("RULED", "RULED", "7.1"), ("ERROR", "ERROR", "7.2"), ("SIDE", "SIDE", "7.5"),
              ("PASSED", "PASSED", "7.4"), ("GROW", "KIND_GROW", "5.4"), ("TURN", "KIND_TURN", "5.4"),
              ("CLOSE", "KIND_CLOSE", "5.4"), ("FLAG", "FLAG", "7.4"), ("BASE", "OF_BASE", "6.1"),
              ("FIRST", "FIRST", "6.1"), ("SECOND", "SECOND", "6.1"), ("NORMAL", "NORMAL", "6.1"),
              ("AGREED", "AGREED", "6.1"),
              ("SMALL", "SIGN_SMALL", "6.1"), ("MARK", "MARK", "17.2"), ("DISSOLVED", "DISSOLVED", "17.5"),
              ("SECOND_FLIP", "SECOND_FLIP", "17.8"), ("TWO", "TWO", "17.5"),
              ("CENTRAL", "CENTRAL", "17.5"), ("SHORTEST", "SHORTEST", "17.5"), ("SHORTER", "SHORTER", "17.5"),
              ("NEW_ALONG", "NEW_ALONG", "17.6"), ("NEW_ABOVE", "NEW_ABOVE", "17.6"), ("PLAIN", "PLAIN", "6.1"),
              ("COPY", "FACE", "6.3"), ("JOINT", "OTHER_JOINT", "9.10"), ("TWO_ROWS", "TWO_ROWS", "17.10"), ("REST", "REST", "9.9"),
              ("FOLDS_BACK", "FOLDS_BACK", "9.14"), ("COMMON", "COMMON_PAIR", "9.14"), ("AHEAD", "AHEAD", "9.15"),
              ("BACK", "BACK", "9.15"), ("SIGN_BIT", "SIDE_IS_BIT", "9.15"), ("SAME_SIDE", "SAME_SIDE", "9.15")]
WEIGHT_TABLES = ["END", "BETWEEN", "STEPS", "GAP", "RULE"]


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
    for name in "CQI_RATE", "CQI_LEARN", "CQI_MIN_SPLITS":  # macros with an argument: the numbers in them
        values[name] = tuple(numbers(re.search(rf"#define {name}\(\w+\) (.*)", header).group(1)))
    return values


def numbers(text):
    return [int(n) for n in re.findall(r"-?\d+", text)]


def table(header, name):
    return numbers(re.search(rf"cqi_{name}\[.*?\] = \{{(.*?)\}};", header, re.S).group(1))


def block(values):
    return "```\n" + textwrap.fill(", ".join(map(str, values)), WIDTH) + "\n```\n"


def bit_tables(enum):
    """Name, first model, number of models, use."""
    starts = [enum[f"CQI_{c}"] for _, c, _ in BIT_TABLES] + [enum["CQI_MODELS"]]
    return [(name, starts[k], starts[k + 1] - starts[k], use) for k, (name, _, use) in enumerate(BIT_TABLES)]


def appendix():
    header = HEADER.read_text(encoding="utf-8")
    enum = enum_values(header)
    bits, bare, located, linear, yes, gain, logistic = (
        table(header, name) for name in ("prior_bit", "prior_bare", "prior_located", "prior_linear", "prior_yes",
                                         "prior_gain", "logistic"))
    bits += table(header, "prior_regular")
    assert len(bits) == enum["CQI_PRIORS"] == enum["CQI_PLAIN"]
    assert len(bare) == len(located) == enum["CQI_WEIGHTS"]
    assert len(yes) == len(gain) == enum["CQI_QUESTIONS"]
    assert len(linear) == 2 * enum["CQI_FAN_CLASSES"] * enum["CQI_FEATURES"]
    assert logistic == [round(65536 / (1 + math.exp((63.5 - k) / 8))) for k in range(24, 104)]
    text = "### A.1 Bit models\n\nA bit model begins with 256 · n + 128. The tables, one behind the other:\n\n"
    text += "| table | first | size | used in |\n| --- | --- | --- | --- |\n"
    for row in bit_tables(enum):
        text += "| %s | %d | %d | %s |\n" % row
    text += "\nThe models of PLAIN begin like those of FIRST; those of COPY and all behind it with n = 240. The n of all others:\n\n"
    text += block(bits)
    text += "\n### A.2 Weights without a position channel\n\n"
    text += "A weight begins with n / 16 nat, that is 256 · n. Tables as in 8.2. Their n:\n\n" + block(bare)
    text += "\n### A.3 Weights with a position channel\n\nAs in A.2:\n\n" + block(located)
    text += "\n### A.4 Weights of the linear prediction\n\nA weight of 9.5 begins with 128 · n. First along[0][0 .. 2], "
    text += "... along[7][0 .. 2], then above. Their n:\n\n" + block(linear)
    text += "\n### A.5 Questions\n\nyes[i] of 9.6 begins with 256 · n + 128. First HIT, then SAME, then FLAT. Their n:\n\n"
    text += block(yes) + "\ngain[i] begins with 16 · n. Their n:\n\n" + block(gain)
    text += "\n### A.6 logistic\n\n65536 / (1 + exp((39.5 - k) / 8)), rounded, for k = 0 .. 79:\n\n" + block(logistic)
    return text


def fields(data):
    """The bytes of the header as rows of a table."""
    names = [("magic", 2, '"CQ"'), ("version", 1, "0"), ("V", 1, "6"), ("loops", 1, "0, so there is no field edges"),
             ("chi", 1, "zigzag 2 is 1: one component of genus 0. F = 2 · 6 - 4 · 1 = 8"), ("channels", 1, "none"),
             ("size", 1, f"bytes of the payload: {len(data) - 14}"),
             ("payload check", 4, f"CRC-32 of the payload, {int.from_bytes(data[8:12], 'little'):08X}"),
             ("header check", 2, "low half of the CRC-32 of the 12 bytes before"), ("payload", len(data) - 14, "")]
    text, at = "| bytes | field | value |\n| --- | --- | --- |\n", 0
    for name, size, value in names:
        text += f"| {data[at:at + size].hex(' ')} | {name} | {value} |\n".replace("|  |", "| |")
        at += size
    return text


def example(data):
    import decoder  # reads the appendix, which must be there
    events, symbols = [], []
    result = decoder.Decoder(data, events=events, symbols=symbols)
    text = "```\n" + data.hex(" ") + "\n```\n\n" + fields(data)
    text += "\nThe symbols, with the state after each; the frequency of a bit is that of a 1:\n\n```\n"
    text += f"{'symbol':18} value  frequency/total  range      code       used\n"
    text += "".join(decoder.symbol_line(*symbol) + "\n" for symbol in symbols)
    text += "```\n\nThe events, as `cqm trace` prints them (14.6):\n\n```\n"
    text += "".join(line + "\n" for line in decoder.trace(events))
    text += "```\n\nThe triangles:\n\n```\n"
    return text + "".join(" ".join(map(str, triangle)) + "\n" for triangle in result.triangles()) + "```\n"


def encode(cqm):
    with tempfile.TemporaryDirectory() as folder:
        path = pathlib.Path(folder) / "example.cqm"
        subprocess.run([cqm, "encode", "--quiet", "--connectivity", ROOT / "ref_data" / "octahedron.off", path], check=True)
        return path.read_bytes()


def section(spec, name="appendix"):
    return spec.index(BEGIN % name) + len(BEGIN % name), spec.index(END % name)


def rows_of_weights(spec):
    """The table of 8.2: name -> (first, size)."""
    text = spec[spec.index("### 8.2"):spec.index("### 8.3")]
    rows = re.findall(r"^\| ([A-Z_3]+) \| (\d+) \| ([\d ·]+) \| ", text, re.M)
    return {name: (int(first), number(size, {})) for name, first, size in rows}


def check():
    """Pairs: what is compared, whether it agrees."""
    spec, enum = SPEC.read_text(encoding="utf-8"), enum_values(HEADER.read_text(encoding="utf-8"))
    begin, end = section(spec)
    rows = rows_of_weights(spec)
    firsts = [enum["CQI_" + name] for name in WEIGHT_TABLES] + [enum["CQI_WEIGHTS"]]
    results = [("appendix A", spec[begin:end] == appendix())]
    for k, name in enumerate(WEIGHT_TABLES):
        results.append(("8.2 " + name, rows.get(name) == (firsts[k], firsts[k + 1] - firsts[k])))
    kinds = dict(re.findall(r"^\| ([A-Z_2, ]+) \| of .* \| (\d+) \|$", spec, re.M))
    sizes = {name: size for name, _, size, use in bit_tables(enum) if use == "6.1" and name != "SMALL"}
    results.append(("6.1 kinds", {n: int(size) for names, size in kinds.items() for n in names.split(", ")} == sizes))
    enum["residual"] = 2 - enum["CQI_TOP"], enum["CQI_BITS"]
    enum["expected"] = enum["CQI_EXPECTED"] - 2, enum["CQI_EXPECTED"] - 2
    enum["questions"] = ()
    for first, end in ("CQI_HIT", "CQI_SAME"), ("CQI_SAME", "CQI_FLAT"), ("CQI_FLAT", "CQI_QUESTIONS"):
        enum["questions"] += enum[end] - enum[first], enum[end] - enum[first] - 1
    enum["step"] = enum["CQI_LINEAR_STEP"], enum["CQI_LINEAR_STEP"]
    enum["learn"] = tuple(16 - enum["CQI_NAT_BITS"] + shift for shift in enum["CQI_LEARN"])
    enum["last try"] = enum["CQI_TRIES"] - 1
    enum["far"] = 4 << enum["CQI_RING_BITS"], 4 << enum["CQI_RING_BITS"]
    for name, text in [("CQ_STREAM_VERSION", "Version %d of the format"), ("CQ_MAX_LEVELS", "at most %d"),
                       ("CQ_MAX_VALENCE", "If D ≤ %d: available"), ("CQI_HUB", "if flag = 0 and D ≥ %d: bit PASSED"),
                       ("CQI_RATE", "if n < %d: %d; else n < %d: %d; else %d"),
                       ("CQI_MIN_SPLITS", "s ≥ n / %d + %d"),
                       ("residual", "TOP[n] is model n - %d and BITS[n] is model %d + n"),
                       ("expected", "16 · e if e < %d, else 16 · (%d + e mod 2)"),
                       ("CQI_RING_BITS", "min(%d - bits(m),"), ("CQI_FRACTION", "- bits(m), %d)"),
                       ("last try", "for rank = 0, 1, ... %d"),
                       ("learn", "65536 · bit - P + 1024 >> %d with a position channel error = 65536 · bit - P + 2048 >> %d"),
                       ("CQI_WORTH_IT", "worthHit > %d"), ("CQI_PROBE", "n mod %d = 0 is a *probe*"),
                       ("CQI_RIVALS", "the first %d with"),
                       ("questions", "The first %d questions are named HIT[0 .. %d], the next %d SAME[0 .. %d], "
                                     "the other %d FLAT[0 .. %d]."),
                       ("CQI_LESS", "half(3 · spread x) - 2 · h - %d"),
                       ("CQI_LESS_ABOVE", "half(extent) - 2 · h - %d"), ("CQI_LINEAR_STEP", "along[c][k] + %d · sign"),
                       ("CQI_FLAT_BITS", "all x and y are shifted: >> bits(n >> %d)"), ("CQI_ROW_SETS", "there are %d sets"),
                       ("far", "clamp(Bx - Mx, -%d, %d)"), ("CQ_MAX_CHANNELS", "0 .. %d"),
                       ("CQI_NAT", "units of 1/%d nat")]:
        value = enum.get(name)
        found = text.count("%d") == (len(value) if isinstance(value, tuple) else 1) if value is not None else False
        results.append((name, found and text % value in " ".join(spec.split())))
    return results


def report(results):
    for name, good in results:
        if not good:
            print("FAIL  SPEC.md and the header differ:", name)
    failed = sum(not good for _, good in results)
    print(f"{len(results) - failed} passed, {failed} failed")
    return 1 if failed or not results else 0


def replace(name, text):
    spec = SPEC.read_text(encoding="utf-8")
    begin, end = section(spec, name)
    SPEC.write_text(spec[:begin] + text + spec[end:], encoding="utf-8")


def write(cqm=None):
    replace("appendix", appendix())
    if cqm:
        replace("example", example(encode(cqm)))
    return 0


if __name__ == "__main__":
    if sys.argv[1:] != ["check"] and (sys.argv[1:2] != ["write"] or len(sys.argv) > 3):
        sys.exit(__doc__)
    sys.exit(write(*sys.argv[2:]) if sys.argv[1] == "write" else report(check()))
