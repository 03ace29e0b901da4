"""Every patch of the library is drawn so that it can be read: the rules of rules.py, on every canvas of every file."""
import os
import pathlib

import pytest
import rules
from pd_canvas import ROOT, Stage, drawings, pd_file

BUILD = pathlib.Path(os.environ.get("TACTUS_BUILD", ROOT / "build"))
STAGE = Stage(os.environ.get("TACTUS_STAGE", BUILD / "tactus"), BUILD / "declarations.json")


@pytest.mark.parametrize("path", STAGE.patches(), ids=lambda p: p.name)
def test_a_patch_is_drawn_so_that_it_can_be_read(path):
    lines = [f"{drawing.where}: {fault.rule}: {fault.text}"
             for drawing in drawings(pd_file.read(path), STAGE) for fault in rules.faults(drawing)]
    assert not lines, "\n".join(lines)
