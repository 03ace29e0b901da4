"""The sanitizers work inside Pd: a read beyond an object's memory ends the run."""
import os
import pathlib
import sys

import pytest

ROOT = pathlib.Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "tests" / "patches"))
from harness import Patch, PdFailure  # noqa: E402

OBJECTS = pathlib.Path(os.environ["TACTUS_BUILD"]) / "test-objects"


@pytest.mark.parametrize("crime", ["none", "overflow"])
def test_a_read_beyond_the_heap_is_seen(crime):
    patch = Patch()
    patch.record("out", patch.obj("culprit~", crime))
    if crime == "none":
        patch.render(0.1, path=[OBJECTS])
        return
    with pytest.raises(PdFailure, match="heap-buffer-overflow"):
        patch.render(0.1, path=[OBJECTS])
