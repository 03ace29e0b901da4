"""The names by which boxes of Pd reach each other without a cord, and who sends to, hears or owns them."""
import re

WIDGETS = {"bng": 5, "tgl": 3, "hsl": 7, "vsl": 7, "nbx": 7, "vradio": 5, "hradio": 5, "cnv": 4}
SENDS = {"s", "send", "s~", "send~", "throw~", "tabwrite", "tabwrite~", "v", "value"}
HEARS = {"r", "receive", "r~", "receive~", "catch~", "tabread", "tabread4~", "v", "value"}
OWNS = {"struct": 1, "table": 1, "array": 2, "text": 2}  # the word that holds the name, where it is defined
DEVICES = {"phantom", "phantom~", "haptic_server"}


def is_own(name):
    """Whether a name is a patch's or an instance's own: it carries $0 or an argument."""
    return bool(re.search(r"\$\d", name))


def uses(canvas):
    """(name, "sent", "heard" or "owned") for every use of a name in a canvas and what is in it."""
    for name, _ in canvas.arrays:
        yield name, "owned"
    for box in canvas.boxes:
        if box.canvas:
            yield from uses(box.canvas)
        elif box.kind == "msg":
            for name in re.findall(r"\\; (\S+)", " ".join(box.words)):
                yield name.replace("\\$", "$"), "sent"
        elif box.kind in ("floatatom", "symbolatom", "listbox"):
            words = [w.replace("\\", "") for w in box.words] + ["-"] * 8
            yield words[5], "heard"
            yield words[6], "sent"
        elif box.kind == "obj" and box.words:
            yield from of_object(box.plain_words())


def of_object(words):
    kind = words[0]
    if kind in WIDGETS:
        yield words[WIDGETS[kind]], "sent"
        yield words[WIDGETS[kind] + 1], "heard"
    elif kind in OWNS and len(words) > OWNS[kind] and (kind not in ("array", "text") or words[1] == "define"):
        yield [w for w in words[OWNS[kind]:] if w != "-k"][0], "owned"
    elif kind in DEVICES:
        if "-name" in words:
            yield words[words.index("-name") + 1], "owned"
        elif kind == "phantom~" and len(words) > 1:
            yield words[1], "owned"
    if len(words) > 1:
        if kind in SENDS:
            yield words[1], "sent"
        if kind in HEARS:
            yield words[1], "heard"


def shared(canvas):
    """Of each name that is nobody's own: how the patch uses it."""
    found = {}
    for name, use in uses(canvas):
        if name not in ("empty", "-") and not is_own(name):
            found.setdefault(name, set()).add(use)
    return found


def crosstalk(patches):
    """The names by which one of these patches (a dict of name and canvas) reaches another, or a copy of itself:
    {name: {patch: uses}}. A name that is only heard, or only sent, connects nobody."""
    found = {}
    for patch, canvas in patches.items():
        for name, how in shared(canvas).items():
            found.setdefault(name, {})[patch] = how
    return {name: users for name, users in found.items()
            if {"sent", "heard"} <= set().union(*users.values()) or any("owned" in how for how in users.values())}
