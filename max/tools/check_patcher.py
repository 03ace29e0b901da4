#!/usr/bin/env python3
"""Checks Max patchers without Max.

    check_patcher.py --declarations declarations.json PATCHER...

What is checked: JSON and required keys; unique ids; cords between existing ports; outlet types; objects
that are ours or in max_objects.py, with their numbers of inlets and outlets; attributes and messages that
the declaration has; whole numbers within 32 bits; signals into signal inlets only; no control fan-out without [t], but from attrui, whose
order does not matter; boxes that overlap; text that its box cuts off; cords that go up, unless they close
a loop, or run through another box; headings in the background may lie under cords. Not checked: whether Max accepts the file.
"""
import argparse
import json
import pathlib
import re
import sys

import geometry
import max_objects
import text_size
from pd_vocabulary import LARGEST_INTEGER

REQUIRED_OF_PATCHER = ("fileversion", "appversion", "classnamespace", "rect", "boxes", "lines")
REQUIRED_OF_BOX = ("id", "maxclass", "numinlets", "numoutlets", "patching_rect")
TEXT_BOXES = ("newobj", "message", "comment")
COMMON_MESSAGES = {"get", "dump"}


class Window:
    """One patcher of a file, with its boxes by id."""

    def __init__(self, patcher, where):
        self.patcher, self.where = patcher, where
        self.boxes = [entry["box"] for entry in patcher.get("boxes", [])]
        self.by_id = {b["id"]: b for b in self.boxes if "id" in b}
        self.lines = [entry["patchline"] for entry in patcher.get("lines", [])]

    def say(self, text):
        return f"{self.where}: {text}"

    def name(self, box):
        return f"[{box.get('text') or box.get('attr') or box.get('maxclass')}]"


def windows(patcher, where="patcher"):
    yield Window(patcher, where)
    for entry in patcher.get("boxes", []):
        if "patcher" in entry.get("box", {}):
            box = entry["box"]
            yield from windows(box["patcher"], f"{where}/{box.get('text', '').removeprefix('p ')}")


def check_keys(w):
    for key in REQUIRED_OF_PATCHER:
        if key not in w.patcher:
            yield w.say(f"the patcher has no {key}")
    seen = set()
    for box in w.boxes:
        for key in REQUIRED_OF_BOX:
            if key not in box:
                yield w.say(f"{w.name(box)} has no {key}")
        if box.get("id") in seen:
            yield w.say(f"two boxes have the id {box['id']}")
        seen.add(box.get("id"))
        if box.get("maxclass") in TEXT_BOXES and "text" not in box:
            yield w.say(f"{w.name(box)} has no text")
        if len(box.get("outlettype", [])) != box.get("numoutlets", 0):
            yield w.say(f"{w.name(box)} has {box.get('numoutlets')} outlets and "
                        f"{len(box.get('outlettype', []))} outlet types")


def subpatcher_ports(box):
    inner = [entry["box"] for entry in box["patcher"]["boxes"]]
    return (sum(b["maxclass"] == "inlet" for b in inner), sum(b["maxclass"] == "outlet" for b in inner))


def check_objects(w):
    for box in w.boxes:
        maxclass, text = box["maxclass"], box.get("text")
        if "patcher" in box:
            expected = subpatcher_ports(box)
        elif not max_objects.known(maxclass, text):
            what = text.split(" ")[0] if maxclass == "newobj" and text else maxclass
            yield w.say(f"{what} is none of our objects and not in max_objects.py")
            continue
        else:
            inlets, outlets = max_objects.ports(maxclass, text)
            expected = len(inlets), len(outlets)
            types = box.get("outlettype", [])
            if maxclass == "newobj" and len(types) == len(outlets) and any(
                    ("signal" in (a, b)) and a != b for a, b in zip(types, outlets)):
                yield w.say(f"{w.name(box)} has outlet types {types}, expected {outlets}")
        if (box["numinlets"], box["numoutlets"]) != expected:
            yield w.say(f"{w.name(box)} has {box['numinlets']} inlets and {box['numoutlets']} outlets, "
                        f"expected {expected[0]} and {expected[1]}")


def check_cords(w):
    for line in w.lines:
        (source, outlet), (target, inlet) = line["source"], line["destination"]
        if source not in w.by_id or target not in w.by_id:
            yield w.say(f"a cord from {source} to {target}: no such box")
            continue
        s, d = w.by_id[source], w.by_id[target]
        if not 0 <= outlet < s["numoutlets"] or not 0 <= inlet < d["numinlets"]:
            yield w.say(f"a cord from outlet {outlet} of {w.name(s)} to inlet {inlet} of {w.name(d)}: "
                        f"they have {s['numoutlets']} outlets and {d['numinlets']} inlets")
        elif s["outlettype"][outlet] == "signal" and not takes_signal(d, inlet):
            yield w.say(f"a signal of {w.name(s)} into inlet {inlet} of {w.name(d)}, which takes none")


def takes_signal(box, inlet):
    if box["maxclass"] == "outlet":
        return True
    if "patcher" in box:
        inlets = sorted((entry["box"] for entry in box["patcher"]["boxes"]
                         if entry["box"]["maxclass"] == "inlet"), key=lambda b: b["patching_rect"][0])
        return inlets[inlet]["outlettype"][0] == "signal"
    if not max_objects.known(box["maxclass"], box.get("text")):
        return True  # said elsewhere
    return max_objects.ports(box["maxclass"], box.get("text"))[0][inlet] == "both"


def check_fan_out(w):
    ends = {}
    for line in w.lines:
        source = w.by_id.get(line["source"][0])
        if source and line["source"][1] < source["numoutlets"] and source["maxclass"] != "attrui" and \
                source["outlettype"][line["source"][1]] != "signal":
            ends.setdefault(tuple(line["source"]), []).append(line["destination"])
    for (source, outlet), targets in ends.items():
        if len(targets) > 1:
            yield w.say(f"outlet {outlet} of {w.name(w.by_id[source])} has {len(targets)} cords: "
                        "Max orders them by position, put a [t] there")


def our_object(box):
    return max_objects.declaration((box.get("text") or " ").split(" ")[0]) if box["maxclass"] == "newobj" \
        else None


def check_words(w):
    """Attributes in our objects' boxes, attrui's, and what messages wired to them say."""
    for box in w.boxes:
        if d := our_object(box):
            known = {p["name"] for p in d["parameters"]} | {m["name"] for m in d["messages"]}
            for word in re.findall(r" [@-]([A-Za-z_]\w*)", box["text"]):
                if word not in known:
                    yield w.say(f"{d['name']} has no attribute {word}")
    for line in w.lines:
        source, target = w.by_id.get(line["source"][0]), w.by_id.get(line["destination"][0])
        if not source or not target or not (d := our_object(target)):
            continue
        if source["maxclass"] == "attrui" and source["attr"] not in {p["name"] for p in d["parameters"]}:
            yield w.say(f"attrui {source['attr']}: {d['name']} has no such parameter")
        if source["maxclass"] == "message" and line["destination"][1] == 0:
            yield from _message_words(w, d, source["text"])


def _message_words(w, d, text):
    parameters = {p["name"]: p for p in d["parameters"]}
    messages = {m["name"]: m for m in d["messages"]}
    for part in re.split(r",\s*", text.split(";")[0].strip()):
        words = part.split()
        if not words or re.match(r"[-$\d.]", words[0]):
            continue
        name, count = words[0], len(words) - 1
        if name in messages and not messages[name]["fewest"] <= count <= messages[name]["most"]:
            m = messages[name]
            yield w.say(f"[{part}]: {d['name']}'s {name} takes {m['fewest']} to {m['most']} arguments")
        elif name in parameters and parameters[name]["choices"] and count and "$" not in part and \
                words[1] not in parameters[name]["choices"]:
            yield w.say(f"[{part}]: {name} is one of {', '.join(parameters[name]['choices'])}")
        elif name not in messages and name not in parameters and name not in COMMON_MESSAGES:
            yield w.say(f"[{part}]: {d['name']} has no message {name}")


def check_integers(w):
    """A whole number beyond 32 bits in a text depends on how wide the system's C long is."""
    for box in w.boxes:
        if box["maxclass"] in ("newobj", "message"):
            for word in re.split(r"[\s,;]+", box["text"]):
                if re.fullmatch(r"-?\d+", word) and abs(int(word)) > LARGEST_INTEGER:
                    yield w.say(f"{w.name(box)}: {word} is beyond 32 bits: expected {word}.")


def check_positions(w):
    shown = [b for b in w.boxes if not b.get("background") or b["maxclass"] == "comment"]
    for i, a in enumerate(shown):
        for b in shown[i + 1:]:
            if bool(a.get("hidden")) == bool(b.get("hidden")) and geometry.overlap(
                    a["patching_rect"], b["patching_rect"]):
                yield w.say(f"{w.name(a)} and {w.name(b)} overlap")
    for box in w.boxes:
        if not box.get("hidden") and min(box["patching_rect"][:2]) < 0:
            yield w.say(f"{w.name(box)} is outside of the window")
        if box["maxclass"] in TEXT_BOXES:
            yield from _cut_text(w, box)


def _cut_text(w, box):
    _, _, width, height = box["patching_rect"]
    size, bold = box.get("fontsize", text_size.FONT_SIZE), box.get("fontface") == 1
    room = width - text_size.MARGIN + 1
    lines = text_size.wrap(box.get("text", ""), room, size, bold)
    widest = max(text_size.width(line, size, bold) for line in lines)
    if widest > room + 1:
        yield w.say(f"{w.name(box)} is {width:g} pixels wide, its text {widest + text_size.MARGIN:.0f}")
    elif text_size.box_height(len(lines), box["maxclass"], size) > height + 2:
        yield w.say(f"{w.name(box)} is {height:g} pixels high, its text has {len(lines)} lines")


def loops(w):
    """Cords from which their own source can be reached again."""
    following = {}
    for line in w.lines:
        following.setdefault(line["source"][0], set()).add(line["destination"][0])

    def reaches(start, goal):
        waiting, seen = [start], set()
        while waiting:
            here = waiting.pop()
            if here == goal:
                return True
            if here not in seen:
                seen.add(here)
                waiting += following.get(here, ())
        return False
    return [line for line in w.lines if reaches(line["destination"][0], line["source"][0])]


def check_cord_paths(w):
    looping = loops(w)
    for line in w.lines:
        s, d = w.by_id.get(line["source"][0]), w.by_id.get(line["destination"][0])
        if not s or not d or s["numoutlets"] == 0 or d["numinlets"] == 0 or line in looping:
            continue
        if line.get("hidden") and "attrui" in s["maxclass"] + d["maxclass"]:
            continue
        start, end = cord_ends(s, d, line)
        if end[1] < start[1]:
            yield w.say(f"the cord from {w.name(s)} to {w.name(d)} goes up")
        elif not line.get("hidden"):
            points = geometry.curve(start, end)
            for box in w.boxes:
                if box not in (s, d) and not box.get("background") and not box.get("hidden") and \
                        geometry.crosses(points, box["patching_rect"]):
                    yield w.say(f"the cord from {w.name(s)} to {w.name(d)} runs through {w.name(box)}")


def cord_ends(s, d, line):
    a, b = s["patching_rect"], d["patching_rect"]
    return ((geometry.port_x(a, line["source"][1], s["numoutlets"]), a[1] + a[3]),
            (geometry.port_x(b, line["destination"][1], d["numinlets"]), b[1]))


STRUCTURE = (check_keys,)
RULES = (check_objects, check_cords, check_fan_out, check_words, check_integers, check_positions, check_cord_paths)


def check(document):
    """Every finding about the parsed JSON of one file."""
    if not isinstance(document, dict) or "patcher" not in document:
        return ["the file has no patcher"]
    findings = []
    for w in windows(document["patcher"]):
        broken = [f for rule in STRUCTURE for f in rule(w)]
        findings += broken
        if not broken:
            findings += [f for rule in RULES for f in rule(w)]
    return findings


def check_file(path):
    try:
        return check(json.loads(path.read_text(encoding="utf-8")))
    except ValueError as error:
        return [f"not JSON: {error}"]


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--declarations", type=pathlib.Path, required=True)
    parser.add_argument("patchers", nargs="+", type=pathlib.Path)
    arguments = parser.parse_args()
    max_objects.load_declarations(arguments.declarations)
    folders = {path.parent for path in arguments.patchers}
    for folder in folders | {f.parent / "patchers" for f in folders}:
        max_objects.declare_patchers_of(folder)
    count = 0
    for path in arguments.patchers:
        for finding in check_file(path):
            print(f"{path}: {finding}")
            count += 1
    print(f"{len(arguments.patchers)} patchers, {count} findings")
    return 1 if count else 0


if __name__ == "__main__":
    sys.exit(main())
