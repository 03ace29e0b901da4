#!/usr/bin/env python3
"""The objects' declarations as Markdown: docs/reference/NAME.md, and the keys of a ground's text.

    reference_page.py --declarations declarations.json --surface-keys surface_keys.json --docs FOLDER
    reference_page.py ... --check FOLDER                        checks that the pages in FOLDER are up to date

FOLDER is docs/; the pages are FOLDER/reference/NAME.md, their list FOLDER/reference/README.md, and the part of FOLDER/formats/surface.md between its
two marks.
"""
import argparse
import json
import pathlib
import re

from stage import initial_text, number, ports, range_text, spell_choices

ROOT = pathlib.Path(__file__).resolve().parents[1]
BEGIN = "<!-- written by help/reference_page.py -->\n"
END = "<!-- end -->\n"
SECTIONS = {  # headings for the sections of a ground's text
    "": "Keys before the first section",
    "solid": "`[solid]`: a floor that heel and ball strike",
    "friction": "`[friction]`: creaking boards",
    "grains": "`[grains]`: particles",
    "bubbles": "`[bubbles]`: bubbles in water",
    "rustle": "`[rustle]`: very many small particles",
    "room": "`[room]`: reflections of the walls",
}


def table(head, rows):
    """A Markdown table; a bar within a cell is escaped."""
    lines = [head, ["---"] * len(head), *([cell.replace("|", "\\|") for cell in row] for row in rows)]
    return ["| " + " | ".join(line).replace("|  |", "| |") + " |" for line in lines] + [""]


def with_unit(value, unit):
    return f"{value} {unit}" if unit else value


def code(text):
    return f"`{text}`" if text else ""


def related(declaration):
    """Links to the objects and patches to look at next."""
    links = []
    for word in filter(None, declaration["related"].split(", ")):
        if (ROOT / "externals" / word).is_dir():
            links.append(f"[{word}]({word}.md)")
            continue
        found = sorted((ROOT / "patches").rglob(word if word.endswith(".pd") else f"{word}.pd"))
        if not found:
            raise SystemExit(f"{declaration['name']}: 'related' names {word}: expected an object, or a patch in patches/")
        links.append(f"[{word}](../../{found[0].relative_to(ROOT).as_posix()})")
    return ", ".join(links)


def explained(declaration, docs):
    """Links to the pages that explain the object."""
    links = []
    for words in filter(None, declaration["pages"].split(", ")):
        title, _, file = words.partition(": ")
        if not (docs / file).is_file():
            raise SystemExit(f"{declaration['name']}: its declaration names the page `{words}`: expected `title: FILE` with a file of docs/")
        links.append(f"[{title}](../{file})")
    return ", ".join(links)


def forms(message):
    """The forms of a message as the user types them. There are several if the declaration separates them by " | "
    outside brackets."""
    given = re.split(r" \| (?![^(\[]*[)\]])", message["arguments"])  # not within ( ) or [ ]
    if all(" " not in form for form in given):
        given = [message["arguments"]]
    return [code(f"{message['name']} {form}".strip()) for form in given]


def in_the_box(declaration):
    """A paragraph about what the user may write in the object's box."""
    name, arguments = declaration["name"], declaration["arguments"]
    flags = [f"-{p['name']} {initial_text(p)}" for p in declaration["parameters"][:1]]
    flags += [f"-{m['name']} {m['arguments'].split('|')[0].split()[0]}" for m in declaration["messages"]
              if m["arguments"] and m["arguments"][0].isalpha()][:1]
    text = ""
    if arguments:
        text = f"`[{name} {' '.join(arguments)}]`: the first word or number without a flag is the message `{arguments[0]}`. "
    return text + ("Every parameter and every message below can also be given as a flag, before or after other "
                   "arguments: `-name` followed by the values of the message"
                   + (f", as in `[{name} {' '.join(flags)}]`" if flags else "")
                   + ". Flags are applied in order when the object is created.")


def page(declaration):
    d = declaration
    name = d["name"]
    next_ones = [("Read more", explained(d, ROOT / "docs")), ("Related", related(d))]
    out = [f"# {name}", "", f"**{d['title'][0].upper()}{d['title'][1:]}.** {d['description']}", "",
           f"First steps: [tutorial](../tutorials/{name}.md). "
           + "".join(f"{title}: {links}. " for title, links in next_ones if links) + "Help patch: "
           f"right-click the object in Pd, or [{name}-help.pd](../../help/{name}-help.pd).", ""]
    if d["sound"]:
        file, _, text = d["sound"].partition(": ")
        out += [f"Listen, after `./play {file.split('/')[0]}`: [{text}](../../out/{file}).", ""]
    out += ["## In the box", "", in_the_box(d), ""]
    for side in ("inlets", "outlets"):
        out += [f"## {side.capitalize()}", ""]
        out += table(["", "type", "name", "unit", "meaning"],
                     [[str(i + 1), kind, code(port), unit, text] for i, (kind, port, unit, text) in
                      enumerate(ports(d, side))])
    if d["parameters"]:
        out += ["## Parameters", "", "Flag `-name value` in the object's box, message `name value`, query `get name`.", ""]
        out += table(["parameter", "range", "initially", "meaning"],
                     [[code(p["name"]), range_text(p), with_unit(initial_text(p), "" if p["choices"] else p["unit"]),
                       p["text"]] for p in d["parameters"]])
    out += ["## Messages", ""]
    rows = [[forms(m), m["text"]] for m in d["messages"]]
    rows += [(["`get [name ...]`"], "send the named values of `dump`, by default all parameters, to the info outlet"),
             (["`dump`"], "send all parameters and derived values to the info outlet")]
    out += table(["message", "meaning"], [["<br>".join(typed), text] for typed, text in rows])
    return "\n".join(out + ["Written from the object's own declaration by `help/reference_page.py`.", ""])


def surface_tables(keys):
    """Units, ranges and initial values of all keys, in one table for each section."""
    out = []
    for section, title in SECTIONS.items():
        out += [f"### {title}", ""]
        out += table(["key", "range", "default", "meaning"],
                     [[code(k["name"]), with_unit(f"{number(k['lowest'])}..{number(k['highest'])}", k["unit"]),
                       with_unit(number(k["initial"]), k["unit"]), k["text"]]
                      for k in keys if k["section"] == section])
    return "\n".join(out) + "\n"


def index(declarations, folder):
    """The list of all objects, each with its reference and its tutorial."""
    tutorials = {p.stem for p in (folder / "tutorials").glob("*.md")}
    rows = [[f"[{d['name']}]({d['name']}.md)", d["title"],
             f"[first messages](../tutorials/{d['name']}.md)" if d["name"] in tutorials else ""] for d in declarations]
    return "\n".join(["# Reference of the objects", "",
                      "Every inlet, outlet, parameter and message, with unit and range. Written by "
                      "`help/reference_page.py`.", "", *table(["object", "purpose", "tutorial"], rows)])


def pages(declarations, keys, folder):
    """The texts of all pages, by path."""
    yield folder / "reference" / "README.md", index(declarations, folder)
    for d in declarations:
        spell_choices(d)
        yield folder / "reference" / f"{d['name']}.md", page(d)
    surfaces = folder / "formats" / "surface.md"
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
        raise SystemExit(f"{a.check}: out of date: {', '.join(stale)}{'; pages of unknown objects: ' if extra else ''}"
                         f"{', '.join(sorted(extra))}; run: ninja -C build reference")


if __name__ == "__main__":
    main()
