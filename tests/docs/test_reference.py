"""Every object's page of the reference names what to read next; what the pages hold, docs_reference compares."""
import pathlib
import sys

ROOT = pathlib.Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "help"))

import reference_page  # noqa: E402
import stage  # noqa: E402


def test_every_object_has_a_page_to_read_and_related_objects():
    objects = {path.parent.name for path in ROOT.glob("externals/*/CMakeLists.txt")}
    assert objects == set(reference_page.MODELS) == set(stage.RELATED)
