"""Looks for mistakes in a patcher before Max sees it.

It checks that cords join existing boxes; that signals enter only signal inlets; that a control fan-out has a [t],
except from attrui, whose order does not matter; that the declaration has all attributes and messages; that whole
numbers fit 32 bits; that boxes do not overlap; and that no box cuts off its text. Not checked: whether Max accepts the
file.
"""
import re

import max_objects
import text_size
from pd_vocabulary import LARGEST_INTEGER

TEXT_BOXES = ("newobj", "message", "comment")


def name(box):
    return f"[{box.text or box.extra.get('attr') or box.maxclass}]"


def check_cords(patcher):
    for s, outlet, d, inlet, _ in patcher.cords:
        if s not in patcher.boxes or d not in patcher.boxes:
            yield f"a cord from {name(s)} to {name(d)}: expected both in the patcher"
        elif s.outlets[outlet] == "signal" and d.inlets[inlet] != max_objects.S and d.maxclass != "outlet":
            yield f"a signal of {name(s)} into inlet {inlet} of {name(d)}, which accepts no signal"


def check_fan_out(patcher):
    ends = {}
    for s, outlet, *_ in patcher.cords:
        if s.maxclass != "attrui" and s.outlets[outlet] != "signal":
            ends.setdefault((id(s), outlet), []).append(s)
    for (_, outlet), sources in ends.items():
        if len(sources) > 1:
            yield (f"outlet {outlet} of {name(sources[0])} has {len(sources)} cords: "
                   "Max orders them by position: insert a [t]")


def own_declaration(box):
    return max_objects.declaration(box.text.split(" ")[0]) if box.maxclass == "newobj" else None


def check_words(patcher):
    """Checks attributes in our objects' boxes and in attrui, and the messages that are wired to our objects."""
    for box in patcher.boxes:
        if d := own_declaration(box):
            known = {p["name"] for p in d["parameters"]} | {m["name"] for m in d["messages"]}
            for word in re.findall(r" [@-]([A-Za-z_]\w*)", box.text):
                if word not in known:
                    yield f"{d['name']} has no attribute {word}"
    for s, _, target, inlet, _ in patcher.cords:
        if d := own_declaration(target):
            if s.maxclass == "attrui" and s.extra["attr"] not in {p["name"] for p in d["parameters"]}:
                yield f"attrui {s.extra['attr']}: {d['name']} has no such parameter"
            if s.maxclass == "message" and inlet == 0:
                yield from _message_words(d, s.text)


def _message_words(d, text):
    parameters = {p["name"]: p for p in d["parameters"]}
    messages = {m["name"]: m for m in max_objects.messages(d)}
    for part in re.split(r",\s*", text.split(";")[0].strip()):
        words = part.split()
        if not words or re.match(r"[-$\d.]", words[0]):
            continue
        word, count = words[0], len(words) - 1
        if word in messages and not messages[word]["fewest"] <= count <= messages[word]["most"]:
            m = messages[word]
            yield f"[{part}]: {d['name']}'s {word}: expected {m['fewest']} to {m['most']} arguments"
        elif word in parameters and parameters[word]["choices"] and count and "$" not in part and \
                words[1] not in parameters[word]["choices"]:
            yield f"[{part}]: {word}: expected {', '.join(parameters[word]['choices'])}"
        elif word not in messages and word not in parameters:
            yield f"[{part}]: {d['name']} has no message {word}"


def check_integers(patcher):
    """Finds whole numbers beyond 32 bits in texts, whose value depends on the width of the system's C long."""
    for box in patcher.boxes:
        if box.maxclass in ("newobj", "message"):
            for word in re.split(r"[\s,;]+", box.text):
                if re.fullmatch(r"-?\d+", word) and abs(int(word)) > LARGEST_INTEGER:
                    yield f"{name(box)}: {word} is beyond 32 bits: expected {word}."


def overlap(a, b):
    """Whether two boxes share more than an edge."""
    return a.x < b.right and b.x < a.right and a.y < b.bottom and b.y < a.bottom


def check_positions(patcher):
    shown = [b for b in patcher.boxes if not b.extra.get("background") or b.maxclass == "comment"]
    for i, a in enumerate(shown):
        for b in shown[i + 1:]:
            if a.hidden == b.hidden and overlap(a, b):
                yield f"{name(a)} and {name(b)} overlap"
    for box in patcher.boxes:
        if not box.hidden and min(box.x, box.y) < 0:
            yield f"{name(box)} is outside the window"
        if box.maxclass in TEXT_BOXES:
            yield from _cut_text(box)


def _cut_text(box):
    size, bold = box.extra.get("fontsize", text_size.FONT_SIZE), box.extra.get("fontface") == 1
    room = box.width - text_size.MARGIN + 1
    lines = text_size.wrap(box.text, room, size, bold)
    widest = max(text_size.width(line, size, bold) for line in lines)
    if widest > room + 1:
        yield f"{name(box)} is {box.width:g} pixels wide, its text {widest + text_size.MARGIN:.0f}"
    elif text_size.box_height(len(lines), box.maxclass, size) > box.height + 2:
        yield f"{name(box)} is {box.height:g} pixels high, its text has {len(lines)} lines"


RULES = (check_cords, check_fan_out, check_words, check_integers, check_positions)


def check(patcher, where="patcher"):
    """All findings about a patcher and its subpatchers."""
    findings = [f"{where}: {finding}" for rule in RULES for finding in rule(patcher)]
    for box in patcher.boxes:
        if box.patcher:
            findings += check(box.patcher, f"{where}/{box.text.removeprefix('p ')}")
    return findings
