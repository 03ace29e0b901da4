"""The checker finds each kind of mistake, and nothing in a patcher without one."""
import copy

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
    return {"patcher": p.as_json()}


def box(document, text):
    return next(e["box"] for e in document["patcher"]["boxes"] if text in (e["box"].get("text"),
                                                                           e["box"]["maxclass"]))


def lines(document):
    return [entry["patchline"] for entry in document["patcher"]["lines"]]


def add_cord(document, source, outlet, target, inlet):
    document["patcher"]["lines"].append({"patchline": {
        "source": [box(document, source)["id"], outlet], "destination": [box(document, target)["id"], inlet]}})


def change(text, /, **values):
    return lambda document: box(document, text).update(values)


def move(text, *rectangle):
    return change(text, patching_rect=list(rectangle))


MISTAKES = {
    "no lines": (lambda d: d["patcher"].pop("lines"), "has no lines"),
    "one id twice": (lambda d: box(d, "print a").update(id=box(d, "print b")["id"]), "two boxes have the id"),
    "outlet types": (change("t b b", outlettype=["bang"]), "1 outlet types"),
    "an unknown object": (change("print a", text="prynt a"), "none of our objects"),
    "too few inlets": (change("greed~ @type closed", numinlets=2), "expected 3 and 5"),
    "a signal outlet declared as messages": (
        change("greed~ @type closed", outlettype=["", "signal", "signal", "signal", ""]), "has outlet types"),
    "a cord to no box": (lambda d: lines(d)[0].update(destination=["obj-99", 0]), "no such box"),
    "a signal into a message inlet": (lambda d: add_cord(d, "greed~ @type closed", 1, "print a", 0),
                                      "which takes none"),
    "a fan-out": (lambda d: add_cord(d, "button", 0, "print b", 0), "has 2 cords"),
    "an unknown attribute": (change("greed~ @type closed", text="greed~ @tipe closed"), "no attribute tipe"),
    "an attrui of nothing": (change("attrui", attr="tipe"), "no such parameter"),
    "an unknown message": (change("type open", text="tipe open"), "no message tipe"),
    "too many arguments": (change("type open", text="preset a b c d e f g"), "takes"),
    "a whole number beyond 32 bits": (change("type open", text="mass 206000000000, gain -2147483647"),
                                      "206000000000 is beyond 32 bits: expected 206000000000."),
    "an overlap": (move("print b", 250.0, 125.0, 52.0, 22.0), "overlap"),
    "a box outside": (move("comment", -20.0, 200.0, 60.0, 20.0), "outside of the window"),
    "text cut at the right": (move("print a", 240.0, 120.0, 30.0, 22.0), "pixels wide"),
    "a cord that goes up": (move("print a", 240.0, 20.0, 52.0, 22.0), "goes up"),
    "a cord through a box": (move("comment", 235.0, 95.0, 60.0, 20.0), "runs through"),
}


def test_a_good_patcher_has_no_finding():
    assert check_patcher.check(good()) == []


@pytest.mark.parametrize("name", MISTAKES)
def test_a_mistake_is_found(name):
    spoil, expected = MISTAKES[name]
    document = copy.deepcopy(good())
    spoil(document)
    assert any(expected in finding for finding in check_patcher.check(document)), check_patcher.check(document)
