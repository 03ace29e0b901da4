#!/usr/bin/python3
"""Draws a .maxpat or .maxhelp as a picture, about as Max lays it out, so that someone can look at it.

    draw_patcher.py PATCHER... -o FOLDER [--unlocked] [--all]

One PNG a tab (or the patcher itself, where it has no tabs); with --all one for each subpatcher as well.
Text stands in Arial's widths (text_size.py), drawn in DejaVu Sans. It is our reading of Max's looks.
"""
import argparse
import json
import pathlib

from PIL import Image, ImageDraw, ImageFont

import check_patcher
import geometry
import text_size

SCALE = 2
PAPER, INK, CORD, SIGNAL = "#f0f0f0", "#202020", "#707070", "#8a9a18"
OBJECT, MESSAGE, BORDER = "#ffffff", "#dcdcdc", "#909090"


class Canvas:
    def __init__(self, width, height):
        self.image = Image.new("RGB", (round(width * SCALE), round(height * SCALE)), PAPER)
        self.draw = ImageDraw.Draw(self.image)
        self.fonts = {}

    def rectangle(self, x, y, w, h, fill=None, outline=BORDER, radius=2):
        box = [round(v * SCALE) for v in (x, y, x + max(w, 1), y + max(h, 1))]
        self.draw.rounded_rectangle(box, radius * SCALE, fill=fill, outline=outline)

    def ellipse(self, x, y, w, h, fill=None, outline=BORDER):
        self.draw.ellipse([round(v * SCALE) for v in (x, y, x + w, y + h)], fill=fill, outline=outline)

    def line(self, points, fill, width=1):
        self.draw.line([(round(x * SCALE), round(y * SCALE)) for x, y in points], fill=fill,
                       width=width * SCALE)

    def text(self, x, y, line, size, colour=INK, bold=False):
        """A line of text whose every word begins where Arial would begin it."""
        name = "DejaVuSans-Bold.ttf" if bold else "DejaVuSans.ttf"
        font = self.fonts.setdefault((name, size), ImageFont.truetype(name, round(size * SCALE * 0.92)))
        for word in line.split(" "):
            wanted = round(text_size.width(word, size, bold) * SCALE)
            if word and wanted:
                box = font.getbbox(word)
                mask = Image.new("L", (box[2] + 2, round(size * SCALE * 1.4)), 0)
                ImageDraw.Draw(mask).text((0, 0), word, 255, font)
                mask = mask.resize((max(wanted, 1), mask.height), Image.LANCZOS)
                self.image.paste(Image.new("RGB", mask.size, colour), (round(x * SCALE), round(y * SCALE)),
                                 mask)
            x += text_size.width(word + " ", size, bold)


def rgb(colour, default):
    if not colour:
        return default
    return "#" + "".join(f"{round(c * 255):02x}" for c in colour[:3])


def text_lines(canvas, box, colour=INK):
    x, y, w, h = box["patching_rect"]
    size, bold = box.get("fontsize", text_size.FONT_SIZE), box.get("fontface") == 1
    lines = text_size.wrap(box.get("text", ""), w - text_size.MARGIN + 0.5, size, bold)
    first = (text_size.box_height(1, box["maxclass"], size) - size * 1.25) / 2
    for i, line in enumerate(lines):
        canvas.text(x + 5, y + first + i * text_size.LINE_PITCH * size / 12, line, size, colour, bold)


def draw_box(canvas, box):
    kind = box["maxclass"]
    x, y, w, h = box["patching_rect"]
    if kind == "comment":
        if "bgcolor" in box:
            canvas.rectangle(x, y, w, h, rgb(box["bgcolor"], PAPER), None, 0)
        text_lines(canvas, box, rgb(box.get("textcolor"), INK))
    elif kind == "panel":
        canvas.rectangle(x, y, w, h, rgb(box.get("bgcolor"), "#d0d0d0"), None, 0)
    elif kind in ("newobj", "message"):
        canvas.rectangle(x, y, w, h, OBJECT if kind == "newobj" else MESSAGE,
                         "#404040" if kind == "newobj" else BORDER, 2 if kind == "newobj" else 6)
        text_lines(canvas, box)
    else:
        draw_interface(canvas, box, kind, x, y, w, h)
    if kind not in ("comment", "panel"):
        for i in range(box["numinlets"]):
            canvas.rectangle(geometry.port_x(box["patching_rect"], i, box["numinlets"]) - 3, y - 1, 6, 2, "#404040", None, 0)
        for i in range(box["numoutlets"]):
            canvas.rectangle(geometry.port_x(box["patching_rect"], i, box["numoutlets"]) - 3, y + h - 1, 6, 2, "#404040", None, 0)


def draw_interface(canvas, box, kind, x, y, w, h):
    if kind == "button":
        canvas.rectangle(x, y, w, h, "#ffffff")
        canvas.ellipse(x + 3, y + 3, w - 6, h - 6, "#e0e0e0")
    elif kind == "toggle":
        canvas.rectangle(x, y, w, h, "#ffffff")
        canvas.line([(x + 4, y + 4), (x + w - 4, y + h - 4)], "#c0c0c0")
        canvas.line([(x + 4, y + h - 4), (x + w - 4, y + 4)], "#c0c0c0")
    elif kind == "slider":
        canvas.rectangle(x, y, w, h, "#d0d4d8")
        canvas.rectangle(*((x + 1, y + 1, 5, h - 2) if w > h else (x + 1, y + h - 6, w - 2, 5)), "#404a50")
    elif kind in ("flonum", "number"):
        canvas.rectangle(x, y, w, h, "#ffffff")
        canvas.line([(x + 3, y + 6), (x + 8, y + h / 2), (x + 3, y + h - 6)], "#606060")
        canvas.text(x + 12, y + 3, "0." if kind == "flonum" else "0", 12)
    elif kind == "umenu":
        canvas.rectangle(x, y, w, h, "#e4e8ea")
        canvas.text(x + 5, y + 3, str(box["items"][0]), 12)
        canvas.line([(x + w - 14, y + 9), (x + w - 10, y + 14), (x + w - 6, y + 9)], "#404040")
    elif kind == "attrui":
        label = box["attr"]
        canvas.rectangle(x, y, w, h, "#e8e8e8")
        canvas.text(x + 12, y + 3, label, 12)
        canvas.rectangle(x + box.get("text_width", w / 2), y + 2, w - box.get("text_width", w / 2) - 2, h - 4,
                         "#ffffff")
    elif kind == "ezdac~":
        canvas.rectangle(x, y, w, h, "#ffffff", INK, 6)
        canvas.rectangle(x + 12, y + 17, 7, 11, "#606060", None, 0)
        canvas.line([(x + 19, y + 17), (x + 28, y + 9), (x + 28, y + 36), (x + 19, y + 28)], "#606060")
    elif kind == "scope~":
        canvas.rectangle(x, y, w, h, "#38424a")
        canvas.line([(x + 2, y + h / 2), (x + w - 2, y + h / 2)], "#6a7a84")
    elif kind == "matrixctrl":
        canvas.rectangle(x, y, w, h, "#b8c4cc")
        rows, columns = box["rows"], box["columns"]
        for r in range(rows):
            for c in range(columns):
                canvas.ellipse(x + (c + 0.15) * w / columns, y + (r + 0.15) * h / rows, 0.7 * w / columns,
                               0.7 * h / rows, "#8a98a2", None)
    elif kind == "multislider":
        canvas.rectangle(x, y, w, h, "#dfe4e8")
        canvas.line([(x + 2, y + h * 0.7), (x + w * 0.5, y + h * 0.4), (x + w - 2, y + h * 0.6)], "#506070")
    elif kind == "inlet":
        canvas.rectangle(x, y, w, h, "#ffffff")
        canvas.line([(x + 15, y + 6), (x + 15, y + 24), (x + 9, y + 18)], INK)
    elif kind == "outlet":
        canvas.rectangle(x, y, w, h, "#ffffff")
        canvas.line([(x + 15, y + 6), (x + 15, y + 24), (x + 21, y + 18)], INK)
    else:
        canvas.rectangle(x, y, w, h, "#e0e0e0")
        canvas.text(x + 4, y + 3, kind, 12)


def draw(patcher, path, unlocked=False):
    boxes = [b["box"] for b in patcher["boxes"]]
    by_name = {b["id"]: b for b in boxes}
    shown = [b for b in boxes if unlocked or not b.get("hidden")]
    width = max([patcher["rect"][2]] + [b["patching_rect"][0] + b["patching_rect"][2] + 8 for b in shown])
    height = max([patcher["rect"][3]] + [b["patching_rect"][1] + b["patching_rect"][3] + 8 for b in shown])
    canvas = Canvas(width, height)
    for box in reversed(shown):
        if box.get("background"):
            draw_box(canvas, box)
    for line in (entry["patchline"] for entry in patcher["lines"]):
        if line.get("hidden") and not unlocked:
            continue
        source = by_name[line["source"][0]]
        signal = source["outlettype"][line["source"][1]] == "signal"
        canvas.line(geometry.curve(*check_patcher.cord_ends(source, by_name[line["destination"][0]], line)), SIGNAL if signal else CORD, 2 if signal else 1)
    for box in shown:
        if not box.get("background"):
            draw_box(canvas, box)
    canvas.image.save(path)


def windows(patcher, name, everything, top=True):
    """(name, patcher) of each tab, or of the patcher; with everything also of subpatchers."""
    tabs = [b["box"] for b in patcher["boxes"] if b["box"].get("patcher", {}).get("showontab")]
    if not tabs:
        yield name, patcher
    for box in tabs if not everything else [b["box"] for b in patcher["boxes"] if "patcher" in b["box"]]:
        yield from windows(box["patcher"], f"{name}-{box['text'].removeprefix('p ')}", everything, False)


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("patchers", nargs="+", type=pathlib.Path)
    parser.add_argument("-o", "--output", type=pathlib.Path, required=True)
    parser.add_argument("--unlocked", action="store_true", help="with the boxes that a lock hides")
    parser.add_argument("--all", action="store_true", help="subpatchers as well")
    arguments = parser.parse_args()
    arguments.output.mkdir(parents=True, exist_ok=True)
    for path in arguments.patchers:
        patcher = json.loads(path.read_text())["patcher"]
        for name, window in windows(patcher, path.stem, arguments.all):
            draw(window, arguments.output / f"{name.replace('/', '_').replace(' ', '_')}.png",
                 arguments.unlocked)


if __name__ == "__main__":
    main()
