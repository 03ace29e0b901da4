"""Every patch of the library is drawn so that it can be read: the rules of rules.py, on every canvas of every file.

known_faults.txt names the files that are not clean yet, with their faults by rule. It only shrinks: a file with
more faults than it says fails, and so does one with fewer, until `draw.py --count` is written into it.
"""
import collections
import os
import pathlib

import pytest
import rules
from pd_canvas import ROOT, Stage, drawings, pd_file

BUILD = pathlib.Path(os.environ.get("TACTUS_BUILD", ROOT / "build"))
STAGE = Stage(os.environ.get("TACTUS_STAGE", BUILD / "tactus"), BUILD / "declarations.json")
KNOWN = pathlib.Path(__file__).with_name("known_faults.txt")


def known_faults():
    found = {}
    for line in KNOWN.read_text().splitlines():
        if line and not line.startswith("#"):
            name, *counts = line.split(" ")
            found[name] = {rule: int(count) for rule, count in (c.split("=") for c in counts)}
    return found


@pytest.mark.parametrize("path", STAGE.patches(), ids=lambda p: p.name)
def test_a_patch_is_drawn_so_that_it_can_be_read(path):
    lines, counts = [], collections.Counter()
    for drawing in drawings(pd_file.read(path), STAGE):
        for fault in rules.faults(drawing):
            counts[fault.rule] += 1
            lines.append(f"{drawing.where}: {fault.rule}: {fault.text}")
    assert counts == known_faults().get(path.name, {}), "\n".join(lines)


def test_the_list_of_known_faults_names_files_that_exist():
    assert known_faults().keys() <= {p.name for p in STAGE.patches()}
