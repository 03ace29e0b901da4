#!/usr/bin/env python3
"""The objects' declarations as Markdown: docs/reference/NAME.md, and the keys of a ground's text.

    reference_page.py --declarations declarations.json --surface-keys surface_keys.json --docs FOLDER
    reference_page.py ... --check FOLDER                        are the pages in FOLDER up to date?

FOLDER is docs/; the pages are FOLDER/reference/NAME.md, and the part of FOLDER/surfaces.md between its two marks.
"""
import argparse
import json
import pathlib
import re

from stage import RELATED, initial_text, number, ports, range_text, spell_choices

ROOT = pathlib.Path(__file__).resolve().parents[1]
BEGIN = "<!-- written by help/reference_page.py -->\n"
END = "<!-- end -->\n"
MODELS = {  # the pages that explain an object: title and file in docs/
    "contact_friction~": [("the model", "contact.md")],
    "contact_impact~": [("the model", "contact.md")],
    "footstep~": [("the model", "footstep.md"), ("your own surface", "surfaces.md")],
    "greed_gradient~": [("the model", "guidance.md")],
    "greed~": [("the model", "greed.md"), ("wind controllers", "wind_controller.md")],
    "haptic_server": [("the protocol", "haptic_network.md")],
    "ioa_link": [("AudioHaptics", "audiohaptics.md"), ("four computers", "four_computers.md")],
    "modal_impact~": [("the model", "modal_impact.md"), ("making a body", "modal_fem.md")],
    "particle~": [("the model", "particle.md")],
    "phantom": [("the servo", "phantom.md"), ("bodies to touch", "scene.md"), ("force effects", "effects.md"),
                ("masses and springs", "network.md"), ("real devices", "devices/README.md")],
    "phantom~": [("the servo", "phantom.md"), ("masses and springs", "network.md")],
    "playability_map": [("guidance", "guidance.md")],
    "playability~": [("the model", "playability.md")],
    "stress_haptic": [("the model", "stress_haptic.md"), ("making a table", "part_stress.md")],
}
HEARD = {  # a sound of it that ./play makes: scene, file, what it is
    "footstep~": ("walking", "tour.wav", "one walker in one take"),
    "greed_gradient~": ("reed", "adagio_room.wav", "the clarinet of Mozart's Adagio, played by a hand"),
    "greed~": ("fanfare", "fanfare.wav", "two trumpets and two trombones"),
    "modal_impact~": ("bodies", "piece.wav", "a piece for nine bodies"),
    "particle~": ("particles", "piece.wav", "maraca, cabasa, tambourine and coins over rain and bubbles"),
    "phantom": ("strike", "struck_disk.wav", "a hand strikes a disk"),
    "phantom~": ("spring", "string.wav", "a string that a hand plucks"),
    "stress_haptic": ("design", "struck_beam.wav", "a beam struck while it changes shape"),
}
SECTIONS = {  # of a ground's text
    "": "Before the first section",
    "solid": "`[solid]`: a floor that heel and ball strike",
    "friction": "`[friction]`: boards that creak",
    "grains": "`[grains]`: particles",
    "bubbles": "`[bubbles]`: bubbles in water",
    "rustle": "`[rustle]`: countless small particles",
    "room": "`[room]`: what the walls send back",
}


def table(head, rows):
    """A Markdown table; a bar within a cell is escaped."""
    lines = [head, ["---"] * len(head), *([cell.replace("|", "\\|") for cell in row] for row in rows)]
    return ["| " + " | ".join(line).replace("|  |", "| |") + " |" for line in lines] + [""]


def with_unit(value, unit):
    return f"{value} {unit}" if unit else value


def code(text):
    return f"`{text}`" if text else ""


def related(name):
    """Links to the objects and patches to look at next."""
    links = []
    for word in RELATED[name].split(", "):
        if (ROOT / "externals" / word).is_dir():
            links.append(f"[{word}]({word}.md)")
        else:
            found = sorted((ROOT / "patches").rglob(word if word.endswith(".pd") else f"{word}.pd"))
            links.append(f"[{word}](../../{found[0].relative_to(ROOT).as_posix()})")
    return ", ".join(links)


def forms(message):
    """A message as it is typed: one form, or several where the declaration separates more than single words by " | "."""
    given = re.split(r" \| (?![^(\[]*[)\]])", message["arguments"])  # not within ( ) or [ ]
    if all(" " not in form for form in given):
        given = [message["arguments"]]
    return [code(f"{message['name']} {form}".strip()) for form in given]


def in_the_box(declaration):
    """What may be written in the object's box, as a paragraph."""
    name, arguments = declaration["name"], declaration["arguments"]
    flags = [f"-{p['name']} {initial_text(p)}" for p in declaration["parameters"][:1]]
    flags += [f"-{m['name']} {m['arguments'].split()[0]}" for m in declaration["messages"]
              if m["arguments"] and m["arguments"][0].isalpha()][:1]
    text = "**In the box:** "
    if arguments:
        text += f"`[{name} {' '.join(arguments)}]`, the first word or number without a flag being the message " \
                f"`{arguments[0]}`. "
    return text + ("Every parameter and every message below is also a flag, before or after that: `-name` with what "
                   "follows the name in the message"
                   + (f", as in `[{name} {' '.join(flags)}]`" if flags else "")
                   + ". Flags are carried out in order when the object is made.")


def page(declaration):
    d = declaration
    name = d["name"]
    pages = ", ".join(f"[{title}](../{file})" for title, file in MODELS[name])
    out = [f"# {name}", "", f"**{d['title'][0].upper()}{d['title'][1:]}.** {d['description']}", "",
           f"First steps: [tutorial](../tutorials/{name}.md). Read more: {pages}. Related: {related(name)}. Help patch: "
           f"right-click the object in Pd, or [{name}-help.pd](../../help/{name}-help.pd).", ""]
    if name in HEARD:
        scene, file, text = HEARD[name]
        out += [f"Listen, once `./play {scene}` has made it: [{text}](../../out/{scene}/{file}).", ""]
    out += [in_the_box(d), ""]
    for side in ("inlets", "outlets"):
        out += [f"## {side.capitalize()}", ""]
        out += table(["", "type", "name", "unit", "meaning"],
                     [[str(i + 1), kind, code(port), unit, text] for i, (kind, port, unit, text) in
                      enumerate(ports(d, side))])
    if d["parameters"]:
        out += ["## Parameters", "", "Flag `-name value` in the object's box, message `name value`, question `get name`.", ""]
        out += table(["parameter", "range", "initially", "meaning"],
                     [[code(p["name"]), range_text(p), with_unit(initial_text(p), "" if p["choices"] else p["unit"]),
                       p["text"]] for p in d["parameters"]])
    out += ["## Messages", ""]
    rows = [[forms(m), m["text"]] for m in d["messages"]]
    rows += [(["`get [name ...]`"], "the named lines of `dump`, or all parameters, out of the info outlet"),
             (["`dump`"], "all parameters and what follows from them, out of the info outlet")]
    out += table(["message", "meaning"], [["<br>".join(typed), text] for typed, text in rows])
    return "\n".join(out + ["Written from the object's own declaration by `help/reference_page.py`.", ""])


def surface_tables(keys):
    """Units, ranges and initial values of all keys, a table for each section."""
    out = []
    for section, title in SECTIONS.items():
        out += [f"### {title}", ""]
        out += table(["key", "range", "left out", "meaning"],
                     [[code(k["name"]), with_unit(f"{number(k['lowest'])}..{number(k['highest'])}", k["unit"]),
                       with_unit(number(k["initial"]), k["unit"]), k["text"]]
                      for k in keys if k["section"] == section])
    return "\n".join(out) + "\n"


def pages(declarations, keys, folder):
    """Every page that is written here, by its path."""
    for d in declarations:
        spell_choices(d)
        yield folder / "reference" / f"{d['name']}.md", page(d)
    surfaces = folder / "surfaces.md"
    before, _, rest = surfaces.read_text().partition(BEGIN)
    yield surfaces, before + BEGIN + "\n" + surface_tables(keys) + END + rest.partition(END)[2]


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--declarations", type=pathlib.Path, required=True)
    parser.add_argument("--surface-keys", type=pathlib.Path, required=True)
    parser.add_argument("--docs", type=pathlib.Path)
    parser.add_argument("--check", type=pathlib.Path)
    a = parser.parse_args()
    fresh = list(pages(json.loads(a.declarations.read_text()), json.loads(a.surface_keys.read_text()), a.docs or a.check))
    if a.docs:
        for path, text in fresh:
            path.write_text(text)
        return
    stale = [path.name for path, text in fresh if not path.exists() or path.read_text() != text]
    extra = {p.name for p in (a.check / "reference").glob("*.md")} - {path.name for path, _ in fresh}
    if stale or extra:
        raise SystemExit(f"{a.check}: out of date: {', '.join(stale)}{'; no object: ' if extra else ''}"
                         f"{', '.join(sorted(extra))}; run: ninja -C build reference")


if __name__ == "__main__":
    main()
