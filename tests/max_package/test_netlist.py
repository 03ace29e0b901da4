"""Every control cord of every converted patch, and the order in which an outlet's cords fire.

Pd fires an outlet's cords in the order of their making; Max's [t] from right to left. The layout is switched
off here: it is not about the netlist.
"""
import pytest

import make_package
import pd_file
import pd_to_max
from conftest import ROOT

PATCHES = [make_package.help_source(path.stem.removesuffix("-help"))
           for path in sorted((ROOT / "help").glob("*-help.pd"))] + make_package.PATCHES


@pytest.fixture
def canvases(monkeypatch, package):
    """A list that fills with each canvas that is converted, before it is arranged."""
    seen = []
    monkeypatch.setattr(pd_to_max._Canvas, "arrange", lambda self, top: seen.append(self))
    return seen


def in_max(canvas, box, outlet):
    """The (box, inlet) that an outlet reaches, in the order in which Max fires."""
    own = {id(made[0]) for made in canvas.made.values()} | {id(made[1]) for made in canvas.made.values()}
    cords = [c for c in canvas.patcher.cords if c[0] is box and c[1] == outlet and not c[4]]
    if len(cords) == 1 and (cords[0][2].text or "").startswith("t ") and id(cords[0][2]) not in own:
        trigger = cords[0][2]
        return [end for i in reversed(range(len(trigger.outlets))) for end in in_max(canvas, trigger, i)]
    assert len(cords) < 2
    return [(c[2], c[3]) for c in cords]


def in_pd(canvas, index, outlet):
    """The same from the Pd file, without what a scope~ needs not and what was left out with a reason."""
    ends = []
    for source, port, end, inlet in canvas.canvas.cords:
        pd_box = canvas.canvas.boxes[end]
        if (source, port) != (index, outlet) or end not in canvas.made or pd_box.name == "tabwrite~" or (
                pd_box.name == "tabwrite" and inlet) or (
                pd_box.name == "s" and pd_box.words[1] in canvas.converter.names.only_scopes):
            continue
        box, _, swapped = canvas.made[end]
        ends.append((box, 1 - inlet if swapped else inlet))
    return ends


@pytest.mark.parametrize("path", PATCHES, ids=lambda path: path.stem)
def test_every_control_cord_is_there_and_fires_in_its_turn(path, canvases, declarations):
    names = pd_to_max.Names([pd_to_max.read(p, make_package.ABSTRACTIONS) for p in PATCHES])
    pd_to_max.convert_file(path, names, make_package.ABSTRACTIONS, make_package.WITHOUT.get(path.stem))
    compared = 0
    for canvas in canvases:
        for index, (_, box, _) in canvas.made.items():
            if box not in canvas.patcher.boxes:
                continue  # drove a scope alone
            for outlet, kind in enumerate(box.outlets):
                if kind != "signal":
                    assert in_max(canvas, box, outlet) == in_pd(canvas, index, outlet), (box.text, outlet)
                    compared += len(in_pd(canvas, index, outlet))
    assert compared
