#!/usr/bin/python3
"""Lists the faults of patches, and draws them on a sketch of each canvas: cords and boxes at fault in red.

    draw.py [PATCH.pd...] [--pictures FOLDER] [--stage FOLDER] [--declarations FILE]
"""
import argparse
import pathlib

import rules
from pd_canvas import ROOT, Stage, drawings, pd_file


def sketch(drawing, found, path):
    """A picture of the canvas as Pd would draw it, without Pd."""
    import matplotlib
    matplotlib.use("Agg")
    from matplotlib import pyplot
    from matplotlib.patches import Rectangle
    width, height = drawing.canvas.width, drawing.canvas.height
    figure = pyplot.figure(figsize=(width / 100, height / 100), dpi=100)
    axes = figure.add_axes((0, 0, 1, 1), xlim=(0, width), ylim=(height, 0))

    def frame(room, **style):
        axes.add_patch(Rectangle((room.left, room.top), room.right - room.left, room.bottom - room.top, **style))

    for drawn in filter(None, drawing.boxes):
        if drawn.kind == "panel":
            frame(drawn.frame, color=drawn.box.plain_words()[11])
        elif drawn.kind != "text":
            frame(drawn.frame, fill=False, linewidth=1)
        for text, room in drawn.lines + drawn.labels:
            axes.text(room.left, (room.top + room.bottom) / 2, text.replace("$", r"\$"), fontfamily="DejaVu Sans Mono",
                      fontsize=8.4, va="center")
    for cord in drawing.cords:
        axes.plot(*zip(cord.start, cord.end), color="black", linewidth=1)
    for mark in (mark for fault in found for mark in fault.marks):
        if isinstance(mark, tuple):
            axes.plot(*zip(*mark), color="red", linewidth=1.5)
        else:
            frame(mark, color="red", alpha=0.25)
    figure.savefig(path)
    pyplot.close(figure)


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("patches", nargs="*", type=pathlib.Path)
    parser.add_argument("--pictures", type=pathlib.Path)
    parser.add_argument("--stage", type=pathlib.Path, default=ROOT / "build" / "tactus")
    parser.add_argument("--declarations", type=pathlib.Path, default=ROOT / "build" / "declarations.json")
    a = parser.parse_args()
    stage = Stage(a.stage, a.declarations)
    for path in a.patches or stage.patches():
        for drawing in drawings(pd_file.read(path), stage):
            found = rules.faults(drawing)
            print(*(f"{path.name}: {drawing.where}: {f.rule}: {f.text}\n" for f in found), sep="", end="")
            if a.pictures:
                a.pictures.mkdir(exist_ok=True)
                sketch(drawing, found, a.pictures / f"{path.stem}.{drawing.where.replace('/', '.')}.png")


if __name__ == "__main__":
    main()
