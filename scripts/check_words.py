#!/usr/bin/env python3
"""Lists file:line of every word that scripts/words_to_avoid.txt asks to avoid; status 1 if there is one.

    check_words.py           the whole checkout
    check_words.py FILE...   these files
"""
import dataclasses
import fnmatch
import io
import pathlib
import re
import sys
import tokenize

from source_files import C_FAMILY, ROOT, source_files

RULES = pathlib.Path(__file__).with_name("words_to_avoid.txt")
# Files that are not current prose: the released changes, the list itself and its test.
EXEMPT = {"CHANGELOG.md", "scripts/words_to_avoid.txt", "tests/style/test_check_words.py"}
IDENTIFIER = re.compile(r"[A-Za-z_][A-Za-z0-9_]*")
# Parts of C++ that are not code: comments, strings and characters. A quote inside a number only separates digits.
C_PARTS = re.compile(
    r"""(?P<comment>//(?:\\\n|[^\n])*|/\*.*?\*/)
      | (?P<string>R"(?P<end>[^(\s]*)\(.*?\)(?P=end)"
          | "(?:\\.|[^"\\\n])*" | (?<![0-9a-fA-F])'(?:\\.|[^'\\\n])+')""", re.S | re.X)
CMAKE_PARTS = re.compile(
    r"""(?P<string>"(?:\\.|[^"\\])*" | \[(?P<end>=*)\[.*?\](?P=end)\]) | (?P<comment>\#[^\n]*)""",
    re.S | re.X)


@dataclasses.dataclass(frozen=True)
class Rule:
    """where: name, word or text; but: patterns of file names to which the rule does not apply."""
    where: str
    pattern: re.Pattern
    instead: str
    but: tuple


def read_rules(text):
    rules = []
    for number, line in enumerate(text.splitlines(), 1):
        if not line.strip() or line.startswith("#"):
            continue
        columns = re.split(r"\s{2,}", line.strip())
        if len(columns) not in (3, 4) or columns[0] not in ("name", "word", "text"):
            raise SystemExit(f"{RULES.name}:{number}: expected  where  pattern  instead  [but]")
        rules.append(Rule(columns[0], re.compile(columns[1]), columns[2], tuple(columns[3:])))
    return rules


def blank(text):
    """The same number of lines as the text, all blank."""
    return re.sub(r"[^\n]", " ", text)


def split_by(parts, text):
    """(code, prose) of a text, whose comments and strings the expression `parts` finds. Both have the text's length, so
    that lines keep their numbers."""
    code, prose, end = [], [], 0
    for match in parts.finditer(text):
        before, found = text[end:match.start()], match.group()
        code += [before, blank(found)]
        prose += [blank(before), found if match.group("comment") else blank(found)]
        end = match.end()
    return "".join(code + [text[end:]]), "".join(prose + [blank(text[end:])])


def python_tokens(text):
    """The tokens of a text up to the first syntax error, which scripts/check_python.py reports."""
    try:
        yield from tokenize.generate_tokens(io.StringIO(text).readline)
    except (tokenize.TokenError, IndentationError):
        return


def split_python(text):
    """As split_by(), for Python. A string that is a statement is documentation."""
    lines = text.splitlines(keepends=True)
    code, prose = [list(line) for line in lines], [list(blank(line)) for line in lines]

    def clear(start, end, says):
        for row in range(start[0], end[0] + 1):
            line = lines[row - 1]
            first = start[1] if row == start[0] else 0
            last = end[1] if row == end[0] else len(line)
            for column in range(first, min(last, len(line))):
                if line[column] != "\n":
                    code[row - 1][column] = " "
                    if says:
                        prose[row - 1][column] = line[column]

    # From Python 3.12 on, a formatted string consists of several tokens. Its text is not code, but the expressions in
    # its braces are.
    text_of_formatted = getattr(tokenize, "FSTRING_MIDDLE", None)
    begins = True  # a new statement begins
    for token in python_tokens(text):
        if token.type == tokenize.COMMENT:
            clear(token.start, token.end, True)
        elif token.type == tokenize.STRING:
            clear(token.start, token.end, begins)
            begins = False
        elif token.type == text_of_formatted:
            clear(token.start, token.end, False)
        elif token.type in (tokenize.NEWLINE, tokenize.INDENT, tokenize.DEDENT):
            begins = True
        elif token.type != tokenize.NL:
            begins = False
    return "".join(map("".join, code)), "".join(map("".join, prose))


def split(name, text):
    """(code, prose) of a file, by its name; None if the file is neither code nor a document."""
    path = pathlib.PurePosixPath(name)
    suffix = path.with_suffix("").suffix if path.suffix == ".in" else path.suffix
    if suffix in C_FAMILY:
        return split_by(C_PARTS, text)
    if suffix == ".py":
        return split_python(text)
    if suffix == ".cmake" or path.name == "CMakeLists.txt":
        return split_by(CMAKE_PARTS, text)
    if suffix == ".md":
        return blank(text), text
    return None


def hits(name, text, rules):
    """(line, found, instead) of one file; line 0 is its name."""
    rules = [rule for rule in rules if not any(fnmatch.fnmatch(name, but) for but in rule.but)]
    found, known = [], {}

    def look_at_words(line, where, words):
        for word in words:
            if (where, word) not in known:
                known[where, word] = [rule.instead for rule in rules
                                      if rule.where in where and rule.pattern.search(word)]
            found.extend((line, word, instead) for instead in known[where, word])

    parts = split(name, text)
    if parts is None:
        return []
    look_at_words(0, ("name", "word"), IDENTIFIER.findall(pathlib.PurePosixPath(name).stem))
    for number, (code, prose) in enumerate(zip(*(part.split("\n") for part in parts)), 1):
        look_at_words(number, ("name", "word"), IDENTIFIER.findall(code))
        # Words in sentences are plain English, so only words marked as code are checked.
        look_at_words(number, ("word",), [word for word in IDENTIFIER.findall(prose)
                                          if "_" in word or re.search(r"[a-z][A-Z]", word)])
        for rule in rules:
            if rule.where == "text" and (match := rule.pattern.search(prose)):
                found.append((number, match.group(), rule.instead))
    return found


def main(arguments):
    rules = read_rules(RULES.read_text())
    names = [str(pathlib.Path(argument).resolve().relative_to(ROOT)) for argument in arguments] \
        or map(str, source_files())
    count = 0
    for name in names:
        if name in EXEMPT or split(name, "") is None:
            continue
        for line, word, instead in hits(name, (ROOT / name).read_text(errors="replace"), rules):
            print(f"{name}:{line}: {word}: write {instead}")
            count += 1
    if count:
        print(f"{count} words to avoid (scripts/words_to_avoid.txt)")
    return 1 if count else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
