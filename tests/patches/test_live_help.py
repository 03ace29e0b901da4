"""The help patches of patches/live: silent until one click, then they sound; no name of theirs is another copy's."""
import pathlib
import re

import numpy
import pytest

from harness import Patch

LIVE = pathlib.Path(__file__).resolve().parents[2] / "patches" / "live"
PATCHES = sorted(LIVE.glob("*.pd"))
SENDERS = r"^#X obj -?\d+ -?\d+ (?:s|r|send|receive|v|value|table|throw~|catch~|s~|r~) (\S+?)[;,]?(?: |$)"
WIDGETS = (r"^#X obj -?\d+ -?\d+ (?:bng \d+ \d+ \d+ \d+|tgl \d+ \d+|[hv]radio \S+ \S+ \S+ \S+"
           r"|(?:hsl|vsl|nbx) \S+ \S+ \S+ \S+ \S+ \S+) (\S+) (\S+)")  # send and receive


def front(path):
    """The lines of the outermost canvas."""
    depth, lines = 0, []
    for line in path.read_text().splitlines():
        if line.startswith("#N canvas"):
            depth += 1
        if depth == 1:
            lines.append(line)
        if line.startswith("#X restore"):
            depth -= 1
    return lines


def test_every_abstraction_has_a_help_patch():
    made = {p.stem for p in PATCHES if any(re.match(r"#X obj \d+ \d+ inlet", line) for line in front(p))}
    assert {"tactus_preset", "tactus_osc", "tactus_keys", "tactus_pads", "keys_reed_voice", "keys_body_voice"} <= made
    assert all((LIVE / f"{name}-help.pd").is_file() for name in made)


@pytest.mark.parametrize("path", [p for p in PATCHES if p.stem.endswith("-help")], ids=lambda p: p.stem)
def test_a_help_patch_sounds_by_one_click_and_not_before(path):
    patch = Patch(opens=path)
    patch.send(500, "help-play", "bang")
    patch.record("sound", patch.dac(1))
    sound = patch.render(2.5, path=[LIVE], timeout=200)["sound"]
    assert numpy.abs(sound[:24000]).max() == 0
    assert 0.01 < numpy.abs(sound).max() <= 1


@pytest.mark.parametrize("path", PATCHES, ids=lambda p: p.stem)
def test_two_copies_live_side_by_side(path):
    """All names are the copy's own ($0), an argument's ($1, $2), or those that everybody shares."""
    shared = {"help-play", "pd", "empty", "-", "$0"}
    text = path.read_text()
    names = set(re.findall(SENDERS, text, re.M))
    names |= {name for pair in re.findall(WIDGETS, text, re.M) for name in pair}
    names = {name.rstrip(";").replace("\\", "") for name in names}
    assert names or path.stem.endswith("-help")
    wrong = {n for n in names if n not in shared and not re.match(r"(pd-)?\$[0-9]-", n)}
    assert not wrong


def with_receivers(path, folder):
    """A copy of the patch in which [r click-N] goes to every message box of its front that has neither a semicolon
    nor a dollar, and the texts of these boxes."""
    depth, count, found = 0, 0, []
    lines = re.split(r"(?<!\\);\n", path.read_text())
    for line in lines:
        if line.startswith("#X restore"):
            depth -= 1
        if depth == 1 and re.match(r"#X (obj|msg|text|floatatom|symbolatom|restore)", line):
            if line.startswith("#X msg") and not re.search(r"\\;|\$", line):
                found.append((count, " ".join(line.split()[4:])))
            count += 1
        if line.startswith("#N canvas"):
            depth += 1
    added = [f"#X obj 0 0 r click-{i};\n#X connect {count + n} 0 {i} 0" for n, (i, _) in enumerate(found)]
    copy = folder / path.name
    copy.write_text(";\n".join([line for line in lines if line.strip()] + added) + ";\n")
    return copy, found


@pytest.mark.parametrize("path", [p for p in PATCHES if p.stem.endswith("-help")], ids=lambda p: p.stem)
def test_no_message_box_of_a_help_patch_makes_an_error(path, tmp_path):
    copy, boxes = with_receivers(path, tmp_path)
    assert boxes
    patch = Patch(opens=copy)
    patch.send(100, "help-play", "bang")
    # A file is read after it has been written.
    for n, (i, _) in enumerate(sorted(boxes, key=lambda box: box[1].startswith("read"))):
        patch.send(500 + 40 * n, f"click-{i}", "bang")
    patch.render(0.6 + 0.04 * len(boxes), path=[LIVE], timeout=100)
