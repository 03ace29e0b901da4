"""Small meaningful changes to C++ source: what a slip of the hand could have written.

Sources are formatted by clang-format, so that a binary operator has spaces on both sides and a
template's bracket has none. A change never spans two lines, so line numbers stay.
"""
import re
from dataclasses import dataclass


@dataclass(frozen=True)
class Change:
    """`old` at `line` (from 1) and `column` (from 0) of `path` becomes `new`."""
    path: str
    line: int
    column: int
    old: str
    new: str
    kind: str

    def apply(self, text):
        lines = text.split("\n")
        before = lines[self.line - 1]
        assert before[self.column:self.column + len(self.old)] == self.old, "the source has changed"
        lines[self.line - 1] = before[:self.column] + self.new + before[self.column + len(self.old):]
        return "\n".join(lines)

    def __str__(self):
        return f"{self.path}:{self.line}: {self.kind}: `{self.old.strip()}` -> `{self.new.strip()}`"


OPERATORS = {  # binary, each between spaces
    " + ": [" - "], " - ": [" + "], " * ": [" / "], " / ": [" * "], " < ": [" >= ", " <= "], " > ": [" <= ", " >= "],
    " <= ": [" > ", " < "], " >= ": [" < ", " > "], " == ": [" != "], " != ": [" == "], " && ": [" || "],
    " || ": [" && "], " += ": [" -= ", " = "], " -= ": [" += ", " = "], " *= ": [" /= ", " = "], " /= ": [" *= "],
}
CALLS = {
    "std::min": "std::max", "std::max": "std::min", "std::sin": "std::cos", "std::cos": "std::sin", "std::sqrt": "",
    "std::abs": "", "std::exp": "", "std::floor": "std::ceil", "std::ceil": "std::floor", "std::sinh": "std::cosh",
    "std::cosh": "std::sinh",
}
NUMBER = re.compile(r"(?<![\w.'])(\d+\.\d*|\.\d+|\d+)(e[+-]?\d+)?(?![\w.'])")
NEGATIVE = re.compile(r"(?<=[(,=?:] )-(?=[\w(])|(?<=[(\[])-(?=[\w(])|(?<=return )-(?=[\w(])")
CONDITION = re.compile(r"\b(if|while) \((.*)\)( \{)?$")
WORD = re.compile(r"\b(true|false|continue|break)\b")
STATEMENT = re.compile(r"^\s+(?!return\b)([\w.:\[\]()*>+-]+ [-+*/|&]?= .*|[\w.:\[\]>-]+\(.*\));$")  # no declaration
DECLARED_ZERO = re.compile(r"^\s+(?!for\b)[\w:<>,&* ]+ \w+ = 0(\.0)?[,;]")
SKIPPED_LINE = re.compile(r"^\s*(#|static_assert|using |namespace |template|assert\(|\[\[)")


def kind_of(operator):
    if operator in ("&&", "||"):
        return "logic"
    if operator in ("<", ">", "<=", ">=", "==", "!="):
        return "comparison"
    return "assignment" if operator.endswith("=") else "arithmetic"


def code_only(text):
    """The text with comments, strings and character constants blanked, of the same length and lines."""
    out, i, n = list(text), 0, len(text)
    while i < n:
        two = text[i:i + 2]
        if two == "//":
            end = text.find("\n", i)
        elif two == "/*":
            end = text.find("*/", i) + 2
        elif text[i] == '"' or (text[i] == "'" and not (i and text[i - 1].isalnum())):
            quote, end = text[i], i + 1
            while end < n and text[end] != quote and text[end] != "\n":
                end += 2 if text[end] == "\\" else 1
            end += 1
        else:
            i += 1
            continue
        end = n if end < i else min(end, n)
        for k in range(i, end):
            if out[k] != "\n":
                out[k] = " "
        i = end
    return "".join(out)


def other_number(text, random):
    """A number that is wrong by half, double or one."""
    if re.fullmatch(r"\d+", text):
        value = int(text)
        return str(random.choice([value + 1, value - 1]) if value > 0 else 1)
    value = float(text)
    return repr(value * random.choice([0.5, 2.0]) if value else 1.0)


def changes_of(path, text, random):
    """All changes of a source, in order."""
    found = []
    for number, (line, whole) in enumerate(zip(code_only(text).split("\n"), text.split("\n")), 1):
        if SKIPPED_LINE.match(line) or not line.strip():
            continue

        def add(column, old, new, kind, number=number, whole=whole):
            found.append(Change(path, number, column, whole[column:column + len(old)], new, kind))

        for old, others in OPERATORS.items():
            at = line.find(old)
            while at >= 0:
                add(at, old, random.choice(others), kind_of(old.strip()))
                at = line.find(old, at + 1)
        for old, new in CALLS.items():
            for match in re.finditer(re.escape(old) + r"(?=\()", line):
                add(match.start(), old, new, "function")
        if "alignas" not in line and not DECLARED_ZERO.match(line):  # what is set later anyway
            for match in NUMBER.finditer(line):
                add(match.start(), match[0], other_number(match[0], random), "number")
        for match in NEGATIVE.finditer(line):
            add(match.start(), "-", "+", "sign")
        for match in WORD.finditer(line):
            word = {"true": "false", "false": "true", "continue": "break", "break": "continue"}[match[0]]
            add(match.start(), match[0], word, "flow" if match[0] in ("break", "continue") else "truth")
        match = CONDITION.search(line)
        if match and match[2].count("(") == match[2].count(")") and ";" not in match[2]:
            add(match.start(2), match[2], f"!({whole[match.start(2):match.end(2)]})", "condition")
        if STATEMENT.match(line) and line.count("(") == line.count(")"):
            begin = len(line) - len(line.lstrip())
            add(begin, line[begin:], ";", "statement left out")
    return found
