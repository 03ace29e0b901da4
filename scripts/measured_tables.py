#!/usr/bin/python3
"""Writes and checks the tables in the docs that programs print.

    scripts/measured_tables.py write [--build build] [FILE...]
    scripts/measured_tables.py check [--build build] [FILE...]
    scripts/measured_tables.py stale [FILE...]
    scripts/measured_tables.py stamp FILE [WORD...]

A measured block of a Markdown page names the command that prints it:

    <!-- measured by: COMMAND
         check by: COMMAND
         within: TOLERANCE; COLUMN: TOLERANCE; ... -->
    | the | table |
    <!-- end of measured -->

`write` runs the first command in the repository's root and puts its output between the marks. `check` runs the second
command, or the first if there is no second; it may print only some of the tables. For each printed table, and each
group of rows with the same first cell, the page must have the same rows in the same order, equal except for numbers
that differ by at most the tolerance of their column: a number, or a fraction of the larger one (`20 %`); the default is
0. {build} and {python} in a command are the build folder and this Python. Without FILE all pages under docs/. Status 1
and one line for each difference.

Below each table of docs/results is a line with the inputs of the measurement:

    Inputs at `1a2b3c4d`: `core/reed`, `programs/reed_study`.

`stale` prints a line for each table whose inputs have changed since that commit: measure it again, or look at the
changes and `stamp` it. `stamp` writes the commit of the work tree below the page's tables, or below those whose first
row contains one of the words. `write` stamps the tables that it writes. Status 1 if a table has no such line, or if its
commit or a path is unknown."""
import argparse
import dataclasses
import pathlib
import re
import shlex
import subprocess
import sys

ROOT = pathlib.Path(__file__).resolve().parents[1]
BLOCK = re.compile(r"(<!-- measured by:(.*?)-->\n)(.*?)(<!-- end of measured -->)", re.DOTALL)
RESULTS = ROOT / "docs" / "results"
STAMP = re.compile(r"Inputs at `([0-9a-f]{8})`: ((?:`[^`]+`(?:, )?)+)\.")
NUMBER = re.compile(r"[-+]?\d+(?:\.\d+)?(?:e[-+]?\d+)?")
# Separates 0.05..0.10 into two numbers, and keeps a hyphen from being read as a sign.
APART = re.compile(r"\.\.|(?<=[\w)])-")


@dataclasses.dataclass
class Table:
    header: list
    rows: list

    def groups(self):
        """The rows by their first cell."""
        found = {}
        for row in self.rows:
            found.setdefault(row[0], []).append(row)
        return found


@dataclasses.dataclass(frozen=True)
class Tolerance:
    absolute: float = 0
    relative: float = 0

    @classmethod
    def read(cls, text):
        text = text.strip()
        return (cls(relative=float(text[:-1]) / 100) if text.endswith("%") else cls(absolute=float(text)))

    def allows(self, a, b):
        limit = max(self.absolute, self.relative * max(abs(a), abs(b)))
        return abs(a - b) <= limit * (1 + 1e-9)

    def __str__(self):
        return f"{100 * self.relative:g} %" if self.relative else f"{self.absolute:g}"


@dataclasses.dataclass
class Orders:
    write: str
    check: str
    tolerance: Tolerance
    columns: dict


def orders_of(comment):
    """The commands and tolerances of an opening mark; raises ValueError if it is not one."""
    parts = re.split(r"\n\s*(check by|within):", "\nmeasured by:" + comment)
    found = {"measured by": " ".join(parts[0].split()).removeprefix("measured by:").strip()}
    found.update({name: " ".join(text.split()) for name, text in zip(parts[1::2], parts[2::2])})
    tolerance, columns = Tolerance(), {}
    for item in filter(None, (item.strip() for item in found.get("within", "").split(";"))):
        name, _, value = item.rpartition(":")
        if name:
            columns[name.strip()] = Tolerance.read(value)
        else:
            tolerance = Tolerance.read(value)
    if not found["measured by"]:
        raise ValueError("measured by: expected a command")
    return Orders(found["measured by"], found.get("check by", found["measured by"]), tolerance, columns)


def tables_of(text):
    """The Markdown tables of a text."""
    tables, header = [], None
    for line in [*text.splitlines(), ""]:
        if not line.lstrip().startswith("|"):
            header = None
            continue
        cells = [cell.strip() for cell in line.strip().strip("|").split("|")]
        if header is None:
            header = cells
            tables.append(Table(cells, []))
        elif not all(re.fullmatch(r":?-+:?", cell) for cell in cells):
            tables[-1].rows.append(cells)
    return tables


def agree(committed, fresh, tolerance):
    """Whether two cells are equal, with numbers compared within the tolerance."""
    ours, theirs = (APART.sub(" ", cell) for cell in (committed, fresh))
    if NUMBER.sub("#", ours) != NUMBER.sub("#", theirs):
        return False
    return all(tolerance.allows(float(a), float(b))
               for a, b in zip(NUMBER.findall(ours), NUMBER.findall(theirs)))


def differences(committed, fresh, orders):
    """One sentence for each cell, row or table of the fresh text that the committed text lacks."""
    by_header = {tuple(table.header): table for table in tables_of(committed)}
    found = tables_of(fresh)
    if not found:
        yield "the command prints no table"
    for table in found:
        ours = by_header.get(tuple(table.header))
        if ours is None:
            yield f"no table with the columns {' | '.join(table.header)}"
            continue
        groups = ours.groups()
        for name, rows in table.groups().items():
            mine = groups.get(name, [])
            if len(mine) != len(rows):
                yield f"{name}: {len(mine)} rows, a fresh run has {len(rows)}"
                continue
            for old, new in zip(mine, rows):
                for column, a, b in zip(table.header, old, new):
                    limit = orders.columns.get(column, orders.tolerance)
                    if not agree(a, b, limit):
                        yield (f"{' | '.join(old[:3])}: {column} is '{a}', a fresh run has '{b}' "
                               f"(within {limit})")


def git(*words):
    done = subprocess.run(["git", *words], cwd=ROOT, capture_output=True, text=True)
    return done.stdout.strip() if done.returncode == 0 else None


def stamps_of(lines):
    """(Line of the first row, line of its stamp or None) of each table, counted from 0."""
    begin = None
    for i, line in enumerate(lines):
        if lines[i + 1:i + 2] and re.match(r"\|:?--", lines[i + 1]):
            if begin is not None:
                yield begin, None
            begin = i
        elif begin is not None and line and not line.startswith(("|", "<!-- end")):
            yield begin, i if STAMP.fullmatch(line) else None
            begin = None
    if begin is not None:
        yield begin, None


def staleness(lines):
    """(Line, fault or None, number of later commits to the inputs) of each table."""
    for begin, stamp in stamps_of(lines):
        if stamp is None:
            yield begin + 1, "the table has no line of its inputs", 0
            continue
        commit, paths = STAMP.fullmatch(lines[stamp]).groups()
        paths = re.findall("`([^`]+)`", paths)
        missing = [path for path in paths if not (ROOT / path).exists()]
        since = git("rev-list", "--count", f"{commit}..HEAD", "--", *paths)
        if missing:
            yield stamp + 1, f"the input {missing[0]} does not exist", 0
        elif since is None:
            yield stamp + 1, f"no commit {commit} in this checkout; expected a commit of its history", 0
        else:
            yield stamp + 1, None, int(since)


def stamp(lines, words, commit):
    """Writes the commit below the tables whose first row contains one of the words (all tables without
    words)."""
    for begin, line in stamps_of(lines):
        if line is not None and (not words or any(word in lines[begin] for word in words)):
            lines[line] = re.sub("`[0-9a-f]{8}`", f"`{commit}`", lines[line], count=1)
    return lines


def print_stale(pages):
    wrong = tables = stale = 0
    for path in pages:
        for line, fault, since in staleness(path.read_text().split("\n")):
            tables, stale, wrong = tables + 1, stale + (since > 0), wrong + (fault is not None)
            if fault or since:
                print(f"{path.relative_to(ROOT)}:{line}: {fault or f'{since} later commits change its inputs'}")
    print(f"{tables} tables, {stale} measured with older inputs")
    return wrong


def output_of(command, build):
    words = [word.format(build=build, python=sys.executable) for word in shlex.split(command)]
    done = subprocess.run(words, cwd=ROOT, capture_output=True, text=True)
    if done.returncode:
        raise RuntimeError(f"{command}: status {done.returncode}: {done.stderr.strip()[-300:]}")
    return done.stdout.strip() + "\n"


def rewritten(text, run, commit):
    """The page with every block as its command now prints it, and the commit below; run(command) returns the text."""
    text = BLOCK.sub(lambda block: block[1] + run(orders_of(block[2]).write) + block[4], text)
    return re.sub(r"(<!-- end of measured -->\n+Inputs at )`[0-9a-f]{8}`", rf"\1`{commit}`", text)


def checked(text, run):
    """One sentence for each difference between the page and a fresh run."""
    for block in BLOCK.finditer(text):
        orders = orders_of(block[2])
        yield from differences(block[3], run(orders.check), orders)


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("command", choices=("write", "check", "stale", "stamp"))
    parser.add_argument("--build", type=pathlib.Path, default=ROOT / "build")
    parser.add_argument("files", metavar="FILE", nargs="*", type=pathlib.Path)
    arguments = parser.parse_intermixed_args()
    head = git("rev-parse", "--short=8", "HEAD")
    if arguments.command == "stale":
        sys.exit(1 if print_stale([path.resolve() for path in arguments.files] or sorted(RESULTS.glob("*.md"))) else 0)
    if arguments.command == "stamp":
        path, *words = arguments.files or [parser.error("stamp: expected FILE")]
        path.write_text("\n".join(stamp(path.read_text().split("\n"), list(map(str, words)), head)))
        return
    build = arguments.build.resolve()
    pages = [path.resolve() for path in arguments.files] or [
        path for path in sorted((ROOT / "docs").rglob("*.md")) if BLOCK.search(path.read_text())]
    wrong = 0
    for path in pages:
        text = path.read_text()
        if not BLOCK.search(text):
            sys.exit(f"{path}: no measured block")
        try:
            if arguments.command == "write":
                path.write_text(rewritten(text, lambda command: output_of(command, build), head))
                continue
            for sentence in checked(text, lambda command: output_of(command, build)):
                print(f"{path.relative_to(ROOT) if path.is_relative_to(ROOT) else path}: {sentence}")
                wrong += 1
        except (RuntimeError, OSError, ValueError) as error:
            sys.exit(f"{path}: {error}")
    if wrong:
        sys.exit("the pages are out of date: scripts/measured_tables.py write")


if __name__ == "__main__":
    main()
