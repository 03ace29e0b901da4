"""The checker finds each kind of mistake, and nothing in a patcher without one."""
import pytest

import check_patcher
from patcher import Box, Patcher

pytestmark = pytest.mark.usefixtures("declarations")


def good():
    """A small patcher with one of everything that a rule looks at."""
    inner = Patcher(0, 0)
    inlet = inner.add(Box("inlet", x=20, y=20, width=30, height=30, ports=([], ["signal"]), comment=""))
    outlet = inner.add(Box("outlet", x=20, y=100, width=30, height=30, ports=(["both"], []), comment=""))
    inner.connect(inlet, 0, outlet, 0)
    p = Patcher(500, 500)
    message = p.message("type open", 20, 20)
    reed = p.object("greed~ @type closed", 20, 80, width=150)
    sub = p.subpatcher("through", inner.fit(), 20, 140)
    speaker = p.add(Box("ezdac~", x=20, y=200, width=45, height=45))
    button = p.add(Box("button", x=240, y=20, width=24, height=24))
    trigger = p.object("t b b", 240, 70)
    first, second = p.object("print a", 240, 120), p.object("print b", 330, 120)
    menu = p.add(Box("attrui", x=120, y=20, width=100, height=22, attr="type"))
    p.comment("a remark", 240, 200)
    for cord in ((message, 0, reed, 0), (reed, 0, sub, 0), (sub, 0, speaker, 0), (sub, 0, speaker, 1),
                 (button, 0, trigger, 0), (trigger, 0, first, 0), (trigger, 1, second, 0),
                 (menu, 0, reed, 0)):
        p.connect(*cord)
    return p


def box(patcher, text):
    return next(b for b in patcher.boxes if text in (b.text, b.maxclass))


def cord(source, outlet, target, inlet=0):
    return lambda p: p.connect(box(p, source), outlet, box(p, target), inlet)


def change(text, /, **values):
    return lambda p: vars(box(p, text)).update(values)


REED = "greed~ @type closed"
MISTAKES = {
    "a cord to no box": (lambda p: p.boxes.remove(box(p, "ezdac~")), "expected both in the patcher"),
    "a signal into a message inlet": (cord(REED, 1, "print a"), "which accepts no signal"),
    "a fan-out": (cord("button", 0, "print b"), "has 2 cords"),
    "an unknown attribute": (change(REED, text="greed~ @tipe closed"), "no attribute tipe"),
    "an attrui of nothing": (lambda p: box(p, "attrui").extra.update(attr="tipe"), "no such parameter"),
    "an unknown message": (change("type open", text="tipe open"), "no message tipe"),
    "an unknown choice": (change("type open", text="type ajar"), "type: expected"),
    "too many arguments": (change("type open", text="preset a b c d e f g"), "arguments"),
    "a whole number beyond 32 bits": (change("type open", text="mass 206000000000, gain -2147483647"),
                                      "206000000000 is beyond 32 bits: expected 206000000000."),
    "an overlap": (change("print b", x=250), "overlap"),
    "a box outside": (change("comment", x=-20), "outside the window"),
    "text cut at the right": (change("print a", width=30), "pixels wide"),
    "text cut below": (change("comment", text="one two", width=40), "pixels high"),
}


def test_a_good_patcher_has_no_finding():
    assert check_patcher.check(good()) == []


def test_a_cord_between_ports_that_there_are_not_cannot_be_made():
    with pytest.raises(ValueError, match="5 outlets and 1 inlets"):
        cord(REED, 5, "print a")(good())


@pytest.mark.parametrize("name", MISTAKES)
def test_a_mistake_is_found_in_a_subpatcher_too(name):
    spoil, expected = MISTAKES[name]
    outer, spoilt = Patcher(500, 500), good()
    spoil(spoilt)
    outer.subpatcher("inner", spoilt, 20, 20)
    findings = check_patcher.check(outer)
    assert any(f.startswith("patcher/inner: ") and expected in f for f in findings), findings
