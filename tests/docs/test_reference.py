"""help/reference_page.py and what help/stage.py shares with it: how choices, messages and units read."""
import pathlib
import sys

import pytest

ROOT = pathlib.Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "help"))

import reference_page  # noqa: E402
import stage  # noqa: E402

PARAMETER = {"name": "type", "unit": "", "initial": 1, "lowest": 0, "highest": 1, "text": "of the valve",
             "choices": ["closed", "open"], "values": []}
DECLARATION = {
    "name": "greed~", "title": "a valve", "description": "It is blown.", "arguments": [], "keywords": "",
    "inlets": [{"kind": "signal", "name": "p_m", "unit": "Pa", "text": "mouth pressure"}],
    "outlets": [{"kind": "control", "name": "info", "unit": "", "text": "step left|right"}],
    "parameters": [PARAMETER, dict(PARAMETER, name="mass", unit="kg", initial=0.5, highest=16777216, choices=[])],
    "messages": [{"name": "preset", "arguments": "clarinet|sax|oboe", "text": "all at once"},
                 {"name": "path", "arguments": "file | line ... | loop 0|1", "text": "moves"}]}


@pytest.mark.parametrize("declared, read", [
    ("clarinet|sax|oboe", "clarinet | sax | oboe"), ("[left|right]", "[left | right]"),
    ("n 0|1", "n (0 | 1)"), ("[k b l0 pull|push]", "[k b l0 (pull | push)]"),
    ("[left|right] wood|snow [another]", "[left | right] (wood | snow) [another]"),
    ("[VALVE...|auto]", "[VALVE... | auto]"), ("device | learn 0|1 | a b", "device | learn (0 | 1) | a b"),
    ("x y z [ms]", "x y z [ms]"), ("step left|right, or up|down", "step (left | right), or (up | down)")])
def test_choices_stand_apart(declared, read):
    assert stage.spaced(declared) == read


def test_a_message_with_several_forms_has_a_line_for_each_and_numbers_are_short():
    for arguments, lines in (("a | b", 1), ("x | y z", 2), ("on (0 | 1) | off", 2), ("[a b | c d]", 1), ("", 1)):
        assert len(reference_page.forms({"name": "m", "arguments": arguments})) == lines, arguments
    for value, text in ((16777216, "16777216"), (1e9, "1e9"), (3.376e-06, "3.376e-06"), (0.1 + 0.2, "0.3"), (-40, "-40"),
                        (1e15, "1e15")):
        assert stage.number(value) == text


def test_a_page_has_tables_units_and_links():
    stage.spell_choices(DECLARATION)
    page = reference_page.page(DECLARATION)
    for line in ("| 1 | signal | `p_m` | Pa | mouth pressure |",
                 "| 1 | control | `info` | | step (left \\| right) |",
                 "| `type` | closed \\| open | open | of the valve |",
                 "| `mass` | 0..16777216 kg | 0.5 kg | of the valve |",
                 "| `preset clarinet \\| sax \\| oboe` | all at once |",
                 "| `path file`<br>`path line ...`<br>`path loop (0 \\| 1)` | moves |"):
        assert line in page.splitlines()
    for link in ("(../greed.md)", "(../tutorials/greed~.md)", "(../../help/greed~-help.pd)", "(playability~.md)",
                 "(../../patches/reed/wind_controller.pd)"):
        assert link in page
    assert not page.startswith("---")


def test_every_object_has_a_page_to_read_and_related_objects():
    objects = {path.parent.name for path in ROOT.glob("externals/*/CMakeLists.txt")}
    assert objects == set(reference_page.MODELS) == set(stage.RELATED)


def test_the_tables_of_a_page_are_replaced_and_the_rest_stays(tmp_path):
    (tmp_path / "surfaces.md").write_text(f"before\n{reference_page.BEGIN}old\n{reference_page.END}after\n")
    keys = [{"section": "solid", "name": "t60", "unit": "s", "lowest": 0.001, "highest": 20, "initial": 0.1,
             "text": "decay time"}]
    (_, text), = reference_page.pages([], keys, tmp_path)
    assert text.startswith("before\n") and text.endswith("after\n") and "old" not in text
    assert "| `t60` | 0.001..20 s | 0.1 s | decay time |" in text
