"""Small meaningful changes to C++ source: what a slip of the hand could have written, and the switch that makes it.

Sources are formatted by clang-format, so that a binary operator has spaces on both sides and a
template's bracket has none. A change never spans two lines, so line numbers stay.
"""
import re
from dataclasses import dataclass


@dataclass(frozen=True)
class Change:
    """`old` at `line` (from 1) and `column` (from 0) of `path` becomes `new`; `switch` has both, and @ for its number.

    `early`: the compiler may decide it already (a member's default value, a constexpr function).
    """
    path: str
    line: int
    column: int
    old: str
    new: str
    kind: str
    switch: str
    early: bool

    def __str__(self):
        return f"{self.path}:{self.line}: {self.kind}: `{self.old.strip()}` -> `{self.new.strip()}`"

    def switched(self, text, number):
        """The line with the switch."""
        end = self.column + len(self.old)
        assert text[self.column:end] == self.old, "the source has changed"
        return text[:self.column] + self.switch.replace("@", str(number)) + text[end:]


MUTANT = "mutation::mutant(@)"
FUNCTIONS = {"+": "std::plus<>", "-": "std::minus<>", "*": "std::multiplies<>", "/": "std::divides<>",
             "<": "std::less<>", ">": "std::greater<>", "<=": "std::less_equal<>", ">=": "std::greater_equal<>",
             "==": "std::equal_to<>", "!=": "std::not_equal_to<>", "=": "mutation::Second"}
OTHERS = {"+": "-", "-": "+", "*": "/", "/": "*", "<": ">= <=", ">": "<= >=", "<=": "> <", ">=": "< >", "==": "!=",
          "!=": "==", "+=": "-= =", "-=": "+= =", "*=": "/= =", "/=": "*="}
CALLS = {"min": "std::max", "max": "std::min", "sin": "std::cos", "cos": "std::sin", "sqrt": "std::identity{}", "abs": "std::identity{}",
         "exp": "std::identity{}",
         "floor": "std::ceil", "ceil": "std::floor", "sinh": "std::cosh", "cosh": "std::sinh"}
OPERATOR = re.compile(r" ([-+*/<>]|[-+*/<>=!]=) (?=\S)")
LOGIC = re.compile(r" (&&|\|\|) (?=\S)")
CALL = re.compile(rf"\bstd::({'|'.join(CALLS)})(?=\([^{{)])")
NUMBER = re.compile(r"(?<![\w.'])(\d+\.\d*|\.\d+|\d+)(e[+-]?\d+)?(?![\w.'])")
NEGATIVE = re.compile(r"(?<=[(,=?:] )-(?=[\w(])|(?<=[(\[])-(?=[\w(])|(?<=return )-(?=[\w(])")
CONDITION = re.compile(r"\b(?:if|while) \((.*)\)(?: \{)?$")
WORD = re.compile(r"\b(true|false|continue;|break;)(?!\w)")
STATEMENT = re.compile(r"^ +(?!return\b)([\w.:\[\]()*>+-]+ [-+*/|&]?= .*|[\w.:\[\]>-]+\(.*\));$")  # no declaration
# Where no switch can stand, or none that is decided when the program runs.
CONSTANT = re.compile(r"\b(constexpr|consteval|constinit|static_assert|enum|template|using|requires|operator|case|goto|assert)\b")
STATIC = re.compile(r"\b(static|const)\b[^)]*$")
LITERAL = re.compile(r"^ *(const (int|unsigned|auto|bool|std::\w+_t) \w+ = [\w.]+|.*(\)|const|noexcept|override) = (0|default|delete)|virtual .*);")
UNSET = re.compile(r"^\s+(?!for\b)[\w:<>,&* ]+ \w+ = 0(\.0)?[,;]")  # is set later anyway


def code_only(text):
    """The text with comments, strings, character constants and preprocessor lines blanked, of the same length and lines."""
    found = r"^ *#if.*?^ *#endif[^\n]*|//[^\n]*|/\*.*?\*/|\"(\\.|[^\"\\\n])*\"|(?<!\w)'(\\.|[^'\\\n])+'|^ *#(\\\n|[^\n])*"
    return re.sub(found, lambda m: re.sub(r"[^\n]", " ", m[0]), text, flags=re.DOTALL | re.MULTILINE)


def run_time(code):
    """Of each character whether it is in the body of a function (2) or of a constexpr one (3), elsewhere (1), or constant (0)."""
    kinds, head, stack, fixed = [], "", [(1, "")], False
    for i, letter in enumerate(code):
        inside = stack[-1][0]
        if not letter.isalnum():
            fixed = inside == 0 or CONSTANT.search(head) or (STATIC.search(head) if inside == 1 else "static " in head)
        kinds.append(0 if fixed else inside)
        if letter == "{":
            body = re.search(r"(\)|\])[^=;]*$", head) and not re.match(r"\s*(struct|class|namespace|union|enum)\b", head)
            plain = re.match(r"\s*((inline )?namespace|struct|class|union|extern|template <[^{]*>\s*(struct|class))\b", head)
            entered = inside if inside != 1 else 3 if "constexpr" in head else 2
            stack.append((entered if body else 1 if plain and inside == 1 else 0 if fixed else inside, head))
            head = ""
        elif letter == "}" and len(stack) > 1:
            _, before = stack.pop()
            head = before + "()" if re.match(r"\s*[,.;)(]|\s*\{", code[i + 1:i + 40]) else ""
        elif letter == ";" and head.count("(") <= head.count(")"):
            head = ""
        else:
            head += letter
    return kinds


def in_brackets(before, after):
    """Whether a template's brackets, or the bounds of a declared array, enclose what is between."""
    left = None
    while left != before:
        left, before = before, re.sub(r"<[^<> ][^<>]*>|<>", "", before)
    return re.search(r"\w<[^ <>][^<>]*$|\w<$", before) and ">" in after or re.search(r"(?<!return)[\w>&*] \w+\[$", before)


def other_number(text, random):
    """A number that is wrong by half, double or one."""
    if re.fullmatch(r"\d+", text):
        value = int(text)
        return str(random.choice([value + 1, value - 1]) if value > 0 else 1)
    value = float(text)
    return repr(value * random.choice([0.5, 2.0]) if value else 1.0)


def right_side(rest, operator):
    """How far the right side of `&&` or `||` goes; 0 where it ends on another line."""
    depth = 0
    for match in re.finditer(r"[(\[{]|[)\]},;?]| : | && | \|\| ", rest):
        depth += match[0] in "([{"
        if depth == 0 and not (match[0] == " && " and operator == "||"):
            return match.start()
        depth -= match[0] in ")]}"
    return 0


def changes_of(path, text, random):
    """All changes of a source, in order of its lines."""
    found, code = [], code_only(text)
    kinds, begin, ended = run_time(code), 0, False
    for number, (line, whole) in enumerate(zip(code.split("\n"), text.split("\n")), 1):
        kind_at, begin = kinds[begin:], begin + len(line) + 1
        starts, ended = ended, bool(re.search(r"([;{}]|\belse)$", line.strip() or (";" if ended else "")))

        def add(at, old, new, kind, switch, body=False):
            where = kind_at[at]
            if where and (where > 1 or not body) and not in_brackets(line[:at], line[at:]):
                found.append(Change(path, number, at, old, new, kind, switch, where != 2))

        if LITERAL.match(line):
            continue
        for match in OPERATOR.finditer(line):
            operator, new = match[1], random.choice(OTHERS[match[1]].split())
            if operator not in ("+", "+=") or '"' not in whole:  # no text
                kind = "comparison" if operator in "< > <= >= == !=" else "arithmetic" if operator in "+-*/" else "assignment"
                function = FUNCTIONS[new if kind != "assignment" else new.replace("=", "") or "="]
                add(match.start(), match[0], f" {new} ", kind,
                    f" {operator} mutation::Or<@, {function}>{{}} {operator} ")
        for match in LOGIC.finditer(line):
            end = right_side(line[match.end():], match[1])
            if end:
                right = whole[match.end():match.end() + end]
                switched = f"({MUTANT} || ({right}))" if match[1] == "&&" else f"(!{MUTANT} && ({right}))"
                add(match.start(), match[0] + right, "", "logic", f"{match[0]}{switched}", True)
        for match in CALL.finditer(line):
            other = CALLS[match[1]]
            add(match.start(), match[0], other, "function", f"TACTUS_CALL(@, {match[0]}, {other})")
        if "alignas" not in line and not UNSET.match(line):
            for match in NUMBER.finditer(line):
                new = other_number(match[0], random)
                add(match.start(), match[0], new, "number", f"({MUTANT} ? {new} : {match[0]})")
        for match in NEGATIVE.finditer(line):
            add(match.start(), "-", "+", "sign", "mutation::Sign<@>{}->*")
        for match in WORD.finditer(line):
            word = match[0]
            new = {"true": "false", "false": "true", "continue;": "break;", "break;": "continue;"}[word]
            switch = f"(!{MUTANT})" if word == "true" else MUTANT if word == "false" else f"{{ if ({MUTANT}) {new} {word} }}"
            add(match.start(), word, new, "flow" if ";" in word else "truth", switch)
        match = CONDITION.search(line.rstrip())
        if match and match[1].count("(") == match[1].count(")") and not re.search(r";| = ", match[1]):
            condition = whole[match.start(1):match.end(1)]
            add(match.start(1), condition, f"!({condition})", "condition", f"{MUTANT} == !({condition})")
        if starts and STATEMENT.match(line.rstrip()) and line.count("(") == line.count(")"):
            at = len(line) - len(line.lstrip())
            statement = whole[at:len(line.rstrip())]
            add(at, statement, ";", "statement left out", f"{{ if (!{MUTANT}) {statement} }}", True)
    return found
