"""Mutants of the header's implementation: mutate.py HEADER list | HEADER write NUMBER FILE | HEADER sample COUNT

A mutant is the header with one token changed: an operator replaced by a near one, a constant by its neighbour, a
condition negated, or a statement dropped. Tables of priors, comments, strings and preprocessor lines are left alone.
Mutants are numbered in the order of their places. A sample takes the first COUNT in an order that depends on the text
of their lines alone, so that it hardly changes with the header. Printed are number, line, column in the line without
its indentation, what was there, what is there now, and the line, with tabs between.
"""
import hashlib
import re
import sys

OPERATORS = {
    "<=": ["<"], ">=": [">"], "==": ["!="], "!=": ["=="], "&&": ["||"], "||": ["&&"],
    "<<": [">>"], ">>": ["<<"], "+=": ["-="], "-=": ["+="], "|=": ["&="], "&=": ["|="],
    "++": ["--"], "--": ["++"], "<": ["<=", ">"], ">": [">=", "<"],
    "+": ["-"], "-": ["+"], "*": ["+"], "/": ["*"], "%": ["*"],
    "&": ["|"], "|": ["&"], "^": ["|"], "~": [""], "!": [""],
}
TOKEN = re.compile(
    r"/\*.*?\*/|\"(?:\\.|[^\"\\])*\"|'(?:\\.|[^'\\])*'"
    r"|(?P<number>\b(?:0x[0-9a-fA-F]+|\d+)[uU]?\b)"
    r"|->|(?P<operator><<=|>>=|<=|>=|==|!=|&&|\|\||<<|>>|\+=|-=|\|=|&=|\+\+|--|[-+*/%&|^~!<>])",
    re.DOTALL)
STATEMENT = re.compile(r"^(?P<indent> +)(?P<body>[\w*(][^{}:]*;)(?: */\*.*\*/)? *$")
DECLARATION = re.compile(r"^(?:static |const |struct |union |enum |typedef |u?int\w*_t |cq_\w+ [*\w]"
                         r"|cqi_\w+ [*\w]|int |size_t |return\b|break|continue|unsigned |for\b|while\b|if\b|else\b"
                         r"|case\b|do\b|void )")


def blank(match):
    """Keeps the place of text that must not be touched."""
    return re.sub(r"[^\n]", " ", match.group(0))


def implementation(text):
    """Where mutants may be: between the implementation's guard and the end, without comments, tables and macros."""
    start = text.index("\n", text.index("defined(CONQUEST_IMPLEMENTATION)"))
    body = text[start:]
    body = re.sub(r"/\*.*?\*/", blank, body, flags=re.DOTALL)
    body = re.sub(r"\"(?:\\.|[^\"\\\n])*\"", blank, body)
    body = re.sub(r"^ *#(?:.*\\\n)*.*$", blank, body, flags=re.MULTILINE)
    body = re.sub(r"^ *(?:CQ_ASSERT|CQI_TRACE(?:_IF)?)\(.*$", blank, body, flags=re.MULTILINE)
    body = re.sub(r"\bstatic const \w+ \w+[^={;]*= \{(?:[^{}]|\{[^{}]*\})*\};", blank, body)
    body = re.sub(r"\b(?:enum|struct|union)(?: \w+)? \{(?:[^{}]|\{[^{}]*\})*\}[^;]*;", blank, body)
    body = re.sub(r"^(?:static |CQ_API )?[\w ]+[ *]+\w+\([^;{]*\)(?=\s*\{|;)", blank, body, flags=re.MULTILINE)
    return re.sub(r"[^\n]", " ", text[:start]) + body


def is_cast_or_pointer(code, at, token):
    """Stars and ampersands of declarations, dereferences and addresses, and signs of constants."""
    before = code[:at].rstrip()[-1:]
    if token in "*&":
        return before in "(,=;{}?:&|!<>+-*/" or before == "" or re.search(
            r"(?:cq_\w+|cqi_\w+|int|void|uint8_t|char|return|struct \w+)\s*$", code[max(0, at - 40):at]) is not None
    if token in "+-":
        return before in "(,=;{}?:&|<>*/" or code[max(0, at - 8):at].rstrip().endswith("return")
    return False


def token_mutants(code):
    for match in TOKEN.finditer(code):
        at, token = match.start(), match.group(0)
        if match.group("operator"):
            if token not in OPERATORS or is_cast_or_pointer(code, at, token):
                continue
            for other in OPERATORS[token]:
                yield at, token, other
        elif match.group("number"):
            digits = token.rstrip("uU")
            value = int(digits, 0)
            tail = token[len(digits):]
            yield at, token, f"{value + 1}{tail}"
            if value > 0:
                yield at, token, f"{value - 1}{tail}"


def dropped_statements(code):
    place = 0
    for line in code.split("\n"):
        match = STATEMENT.match(line)
        if match and not DECLARATION.match(match.group("body")) and match.group("body").count("(") == \
                match.group("body").count(")"):
            yield place + match.start("body"), match.group("body"), ";"
        place += len(line) + 1


def mutants(text):
    code = implementation(text)
    found = sorted(set(token_mutants(code)) | set(dropped_statements(code)))
    return [(at, old, new) for at, old, new in found if text[at:at + len(old)] == old]


def describe(text, number, mutant):
    at, old, new = mutant
    line = text.count("\n", 0, at) + 1
    source = text.split("\n")[line - 1]
    column = at - text.rfind("\n", 0, at) - 1 - (len(source) - len(source.lstrip()))
    return f"{number}\t{line}\t{column}\t{old}\t{new or '(nothing)'}\t{source.strip()}"


def turn(text, mutant):
    """A number that depends on the line's text and the change, not on where in the file it is."""
    at, old, new = mutant
    start = text.rfind("\n", 0, at) + 1
    line = text[start:text.index("\n", at)]
    return hashlib.sha256(f"{line}|{at - start}|{old}|{new}".encode()).hexdigest()


def main(header, command, *arguments):
    with open(header) as file:
        text = file.read()
    everything = mutants(text)
    numbers = range(len(everything))
    if command == "write":
        at, old, new = everything[int(arguments[0])]
        with open(arguments[1], "w") as file:
            file.write(text[:at] + new + text[at + len(old):])
        return 0
    if command == "sample":
        numbers = sorted(sorted(numbers, key=lambda k: turn(text, everything[k]))[:int(arguments[0])])
    for number in numbers:
        print(describe(text, number, everything[number]))
    return 0


if __name__ == "__main__":
    sys.exit(main(*sys.argv[1:]))
