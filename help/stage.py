#!/usr/bin/env python3
"""Fills the flat library folder that Pd loads: help patches, abstractions, object list, meta patch.

A help patch in this folder is drawn by hand and contains only a window and an example. This script adds, from the
object's declaration, a title bar, one line for each inlet, outlet and argument along the bottom, links to what to look
at next, a sub-patch [pd reference] with every argument, parameter and message, and the sub-patch [pd META] that Pd's
help browser and deken read.

    stage.py --declarations declarations.json --version 0.1.0 --stage FOLDER SOURCE...
    stage.py --stage FOLDER SOURCE...                             only abstractions, which need no declaration

reference_page.py writes the same content as Markdown, docs/reference/NAME.md.
"""
import argparse
import json
import pathlib
import re
import shutil

AUTHOR = "the tactus authors"
LICENCE = "GPL-3.0-or-later"
WEBSITE = "see README.md"
TITLE_COLOUR = "#2f4f5f"
RULE_COLOUR = "#dcdcdc"
LINE = 17  # height of a line of text in pixels
PAGE = 640  # height of one window of [pd reference] in pixels


def escape(text):
    """Escapes text for a Pd file. Semicolons are replaced, because Pd ends a line of a comment at a semicolon."""
    text = text.replace(";", ",")
    for symbol in ("\\", ",", "$"):
        text = text.replace(symbol, " \\" + symbol if symbol == "," else "\\" + symbol)
    return text


def comment(x, y, text, width=0):
    return f"#X text {x} {y} {escape(text)}" + (f", f {width}" if width else "") + ";"


def rule(x, y, width, height, label="", colour=RULE_COLOUR, text_colour="#303030"):
    label = label.replace(",", "\\,").replace(" ", "\\ ") if label else "empty"
    return (f"#X obj {x} {y} cnv 4 {width} {height} empty empty {label} 8 {height // 2} 0 "
            f"{14 if height < 30 else 22} {colour} {text_colour} 0;")


def number(value):
    digits = 8 if value == int(value) else 7  # enough digits for 16777216
    return f"{value:.{digits}g}".replace("e+0", "e").replace("e+", "e")


def range_text(parameter):
    if parameter["choices"]:
        return " | ".join(parameter["choices"])
    if parameter["values"]:
        return " | ".join(map(number, parameter["values"]))
    unit = f" {parameter['unit']}" if parameter["unit"] else ""
    return f"{number(parameter['lowest'])}..{number(parameter['highest'])}{unit}"


def initial_text(parameter):
    if parameter["choices"]:
        return parameter["choices"][int(parameter["initial"])]
    return number(parameter["initial"])


def spaced(text):
    """Rewrites choices left|right of the declaration as "left | right", in parentheses if other words stand beside
    them: "number (0 | 1)", "[left | right] (wood | snow)"."""
    def spell(match):
        inner = match[1] or match[2]
        choices = " | ".join(inner.split("|"))
        return f"[{choices}]" if match[1] else choices if inner == text else f"({choices})"
    return re.sub(r"\[([^\s\[\]|]+(?:\|[^\s\[\]|]+)+)\]|([^\s\[\]|,;]+(?:\|[^\s\[\]|,;]+)+)", spell, text)


def spell_choices(declaration):
    """Applies spaced() to a declaration's texts about messages and ports."""
    for entry in declaration["messages"] + declaration["inlets"] + declaration["outlets"]:
        for key in {"arguments", "text"} & entry.keys():
            entry[key] = spaced(entry[key])


def ports(declaration, side):
    """The declared ports of one side, and the info outlet at the right if it is not among them."""
    listed = [(p["kind"], p["name"], p["unit"], p["text"]) for p in declaration[side]]
    if side == "outlets" and "info" not in (name for _, name, *_ in listed):
        listed.append(("control", "info", "", "answers to `get`, `dump` and other queries"))
    return listed


def wrap(text, width):
    """The number of lines of a Pd comment of that width. Lines break at blanks; a word longer than a line breaks
    inside."""
    lines = 1
    while len(text) > width:
        blank = text[:width + 1].rfind(" ")
        text = text[blank + 1:] if blank >= 0 else text[width:]
        lines += 1
    return lines


def reference_rows(declaration):
    """The rows of [pd reference]. Each row is a heading, or a left and a right text."""
    if declaration["arguments"]:
        yield "arguments (flags may stand before, between or after them)", None
        for i, name in enumerate(declaration["arguments"]):
            yield f"{i + 1}: {name}", f"same as the message {name}"
    if declaration["parameters"]:
        yield "parameters: flag -name value, message name value, query get name", None
        for p in declaration["parameters"]:
            yield f"{p['name']}  {range_text(p)}", f"{p['text']} (initially {initial_text(p)})"
    yield "messages (each is also a flag: -name arguments)", None
    for m in declaration["messages"]:
        yield f"{m['name']} {m['arguments']}".strip(), m["text"]
    yield "get [name ...]", "send the named values of dump, by default all parameters, to the info outlet"
    yield "dump", "send all parameters and derived values to the info outlet"


def reference_patch(declaration):
    """The lines of [pd reference]: arguments, parameters, messages. Each window holds a page and the box of the
    next one."""
    pages, page, y = [], [], 10
    for left, right in reference_rows(declaration):
        step = 24 if right is None else 16 * max(wrap(left, 40), wrap(right, 62)) + 3
        if y + step > PAGE:
            pages.append((page, y))
            page, y = [], 10
        if right is None:
            page.append(rule(10, y, 730, 20, left))
        else:
            page += [comment(14, y, left, 40), comment(300, y, right, 62)]
        y += step
    lines = [f"#N canvas 80 80 760 {y + 10} more 0;", *page]
    for page, y in reversed(pages):
        lines = [f"#N canvas 80 80 760 {y + 40} more 0;", *page, *lines, f"#X restore 14 {y + 8} pd more;"]
    lines[0] = lines[0].replace(" more 0;", " reference 0;")
    return lines


def meta_patch(declaration):
    lines = ["#N canvas 100 100 500 360 META 0;"]
    entries = [("KEYWORDS", declaration["keywords"]), ("DESCRIPTION", declaration["title"]),
               ("LICENSE", LICENCE), ("LIBRARY", "tactus")]
    for side in ("inlets", "outlets"):
        for i, (kind, name, unit, text) in enumerate(ports(declaration, side)):
            entries.append((f"{side[:-1].upper()}_{i}", f"{kind} {name} {unit} {text}"))
    entries.append(("AUTHOR", AUTHOR))
    y = 10
    for key, value in entries:
        lines.append(comment(10, y, f"{key} {value}", 66))
        y += 15 * wrap(f"{key} {value}", 66) + 4
    lines[0] = f"#N canvas 100 100 500 {y + 10} META 0;"
    return lines


def fill_help(source, declaration):
    """The finished help patch: the drawn patch completed from the declaration."""
    window = re.match(r"#N canvas (-?\d+) (-?\d+) (\d+) (\d+) (\d+);", source)
    if not window:
        raise SystemExit(f"{declaration['name']}-help.pd: first line: expected #N canvas X Y WIDTH HEIGHT SIZE;")
    width, height = int(window.group(3)), int(window.group(4))
    rows = []
    for side in ("inlets", "outlets"):
        for i, (kind, name, unit, text) in enumerate(ports(declaration, side)):
            rows.append((side if i == 0 else "", f"{i + 1}  {kind}",
                         f"{name}{', ' + unit if unit else ''}: {text}"))
    rows += [("arguments" if i == 0 else "", f"{i + 1}  {name}", f"same as the message {name}")
             for i, name in enumerate(declaration["arguments"])]
    if declaration["related"]:
        rows.append(("see also", "", declaration["related"]))
    columns = (width - 190) // 7
    heights = [LINE * wrap(text, columns) for _, _, text in rows]
    y = height - sum(heights) - 38
    out = [source.rstrip("\n")]
    out.append(rule(1, 6, width - 3, 32, "", TITLE_COLOUR))
    out.append(rule(1, 6, 4, 32, declaration["name"], TITLE_COLOUR, "#ffffff"))
    out.append(rule(width - 112, 6, 4, 32, "tactus", TITLE_COLOUR, "#ffffff"))
    out.append(comment(10, 44, declaration["title"]))
    out.append(rule(6, y - 6, width - 14, 3))
    for (side, kind, text), step in zip(rows, heights):
        if side:
            out.append(comment(10, y, side))
        if kind:
            out.append(comment(86, y, kind))
        out.append(comment(170, y, text, columns))
        y += step
    out += reference_patch(declaration) + [f"#X restore 10 {height - 28} pd reference;"]
    out.append(comment(110, height - 28, "<- click: all arguments, parameters and messages"))
    out += meta_patch(declaration) + [f"#X restore {width - 80} {height - 28} pd META;"]
    return "\n".join(out) + "\n"


def library_meta(version, declarations):
    lines = ["#N canvas 100 100 500 300 12;", "#N canvas 100 100 500 300 META 0;"]
    entries = [("NAME", "tactus"), ("DESCRIPTION", "physical models that you can hear and feel"),
               ("AUTHOR", AUTHOR), ("VERSION", version), ("LICENSE", LICENCE),
               ("WEBSITE", WEBSITE), ("OBJECTS", " ".join(d["name"] for d in declarations))]
    for i, (key, value) in enumerate(entries):
        lines.append(comment(10, 10 + LINE * i, f"{key} {value}"))
    return "\n".join(lines + ["#X restore 20 20 pd META;"]) + "\n"


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("--declarations", type=pathlib.Path)
    parser.add_argument("--version", default="0")
    parser.add_argument("--stage", type=pathlib.Path, required=True)
    parser.add_argument("sources", nargs="*", type=pathlib.Path)
    arguments = parser.parse_args()
    declarations = json.loads(arguments.declarations.read_text()) if arguments.declarations else []
    by_name = {d["name"]: d for d in declarations}
    for d in declarations:
        spell_choices(d)

    arguments.stage.mkdir(parents=True, exist_ok=True)
    for source in arguments.sources:
        for path in sorted(source.rglob("*")):
            if path.suffix not in (".pd", ".txt", ".mid") or path.name == "CMakeLists.txt":
                continue
            name = path.name.removesuffix("-help.pd")
            if path.name.endswith("-help.pd") and name in by_name:
                (arguments.stage / path.name).write_text(fill_help(path.read_text(), by_name[name]))
            else:
                shutil.copyfile(path, arguments.stage / path.name)
    if not declarations:
        return
    for name in by_name:
        if not any((source / f"{name}-help.pd").exists() for source in arguments.sources):
            raise SystemExit(f"{name}: expected a help patch, help/{name}-help.pd")
    (arguments.stage / "tactus-meta.pd").write_text(library_meta(arguments.version, declarations))
    (arguments.stage / "tactus-objects.txt").write_text(
        "".join(f"{d['name']}\t{d['title']}\n" for d in declarations))


if __name__ == "__main__":
    main()
