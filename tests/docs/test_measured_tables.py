"""scripts/measured_tables.py: tables of the docs against what their programs print."""
import pathlib
import shlex
import subprocess
import sys

import pytest

ROOT = pathlib.Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "scripts"))

import measured_tables as tables  # noqa: E402

PAGE = """Before.
<!-- measured by: all
     check by: some
     within: 0; cents: 1; ns: 10 % -->
| preset | key | cents | ns |
|---|---|---|---|
| sax | 50 | +0.4 (0.1..0.9) | 100 |
| sax | 51 | -0.2 | 20 |
| oboe | 60 | 3 | 7 |

| other | x |
|---|---|
| a | 1 |
<!-- end of measured -->
After.
"""
HEAD = "| preset | key | cents | ns |\n|---|---|---|---|\n"
SAX = HEAD + "| sax | 50 | +0.4 (0.1..0.9) | 100 |\n| sax | 51 | -0.2 | 20 |\n"


def said(fresh):
    """The differences between PAGE and a fresh run that prints this."""
    asked = []
    found = list(tables.checked(PAGE, lambda command: asked.append(command) or fresh))
    assert asked == ["some"]
    return found


@pytest.mark.parametrize("old, new", [("", ""), ("+0.4", "+1.4"), ("+0.4", "-0.6"), ("0.9)", "-0.1)"), ("100", "111"),
                                      ("100", "90"), ("-0.2", "0.8"), (SAX, "| other | x |\n|---|---|\n| a | 1 |\n")])
def test_a_part_of_the_tables_and_numbers_within_the_column_s_tolerance_agree(old, new):
    assert said(SAX.replace(old, new)) == []


@pytest.mark.parametrize("old, new, sentence", [
    ("+0.4", "+1.5", "cents is '"), ("0.1..", "1.3..", "cents is '"), ("| 100 |", "| 112 |", "ns is '"),
    ("| 20 |", "| 17.9 |", "ns is '"), ("| 51 |", "| 52 |", "key is '"), ("+0.4 (", "+0.4 [", "cents is '"),
    ("| 20 |", "| silent |", "ns is '"), ("| 20 |", "| |", "ns is '"),
    (SAX[SAX.rindex("| sax"):], "", "sax: 2 rows, a fresh run has 1"),
    (SAX, SAX + "| flute | 1 | 2 | 3 |\n", "flute: 0 rows, a fresh run has 1"),
    (SAX, "| a | b |\n|---|---|\n| 1 | 2 |\n", "no table with the columns a | b"),
    (SAX, "nothing", "the command prints no table")])
def test_anything_else_is_one_sentence_that_names_the_cell(old, new, sentence):
    found = said(SAX.replace(old, new))
    assert len(found) == 1 and sentence in found[0]
    assert "is '" not in sentence or "a fresh run has" in found[0]


def test_the_commands_of_the_docs_are_scripts_of_this_repository():
    found = 0
    for path in (ROOT / "docs").rglob("*.md"):
        for block in tables.BLOCK.finditer(path.read_text()):
            orders = tables.orders_of(block[2])
            for command in (orders.write, orders.check):
                python, script, *_ = shlex.split(command)
                assert python == "{python}" and (ROOT / script).is_file(), f"{path}: {command}"
            found += 1
    assert found >= 11


STAMPED = """| a | b |
|---|---|
| 1 | 2 |

Inputs at `{}`: `core/reed`, `{}`.

| c |
|---|
| 3 |
<!-- end of measured -->

Inputs at `{}`: `core`.
"""
FIRST, LAST = (tables.git(*words.split()) for words in ("log --format=%h --abbrev=8 --reverse", "rev-parse --short=8 HEAD"))
needs_history = pytest.mark.skipif(not FIRST, reason="no git checkout")


@needs_history
def test_a_table_of_inputs_that_have_changed_since_is_found_by_its_line():
    first = FIRST.split()[0]
    page = STAMPED.format(first, "core", LAST).split("\n")
    (old, fault, since), fresh = tables.staleness(page)
    assert (old, fault, fresh) == (5, None, (12, None, 0))
    assert since == int(tables.git("rev-list", "--count", f"{first}..HEAD", "--", "core", "core/reed"))
    stamped = tables.stamp(page, ["| a "], LAST)
    assert [since for *_, since in tables.staleness(stamped)] == [0, 0]


@needs_history
@pytest.mark.parametrize("page, sentence", [
    (STAMPED.format("12345678", "core", "{}").replace("{}", str(LAST)), "no commit 12345678"),
    (STAMPED.format(LAST, "core/none", LAST), "core/none does not exist"),
    (STAMPED.format(LAST, "core", LAST).replace("Inputs", "Input", 1), "has no line of its inputs")])
def test_a_stamp_that_says_nothing_is_named(page, sentence):
    assert [sentence in fault for _, fault, _ in tables.staleness(page.split("\n")) if fault] == [True]


@needs_history
def test_the_script_lists_the_tables_of_a_page_named_from_here():
    done = subprocess.run([sys.executable, "scripts/measured_tables.py", "stale", "docs/results/packages.md"], cwd=ROOT,
                          capture_output=True, text=True)
    assert done.returncode == 0 and done.stdout.splitlines()[-1].startswith("2 tables, ")


def test_every_table_of_the_results_says_of_which_inputs_it_is():
    found = [(path, *rest) for path in sorted(tables.RESULTS.glob("*.md"))
             for rest in tables.staleness(path.read_text().split("\n"))]
    assert len(found) >= 40
    shallow = tables.git("rev-parse", "--is-shallow-repository") != "false"
    assert [one for one in found if one[2] and not (shallow and "no commit" in one[2])] == []
