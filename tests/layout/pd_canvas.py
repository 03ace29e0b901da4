"""A canvas as drawn: its boxes by pd_boxes.py, its cords by pd_ports.py."""
import functools
import json
import pathlib
import sys
from dataclasses import dataclass

import pd_boxes
from pd_ports import Ports

ROOT = pathlib.Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "max" / "tools"))

import pd_file  # noqa: E402


@dataclass
class Cord:
    source: int
    outlet: int
    target: int
    inlet: int
    start: tuple
    end: tuple


class Stage:
    """The flat folder that Pd loads, with what is known of the library's objects."""

    def __init__(self, folder, declarations):
        self.folder = pathlib.Path(folder)
        self.ports = Ports(json.loads(pathlib.Path(declarations).read_text()), self.abstraction)
        self.abstraction = functools.lru_cache(None)(self.abstraction)

    def abstraction(self, name):
        path = self.folder / f"{name}.pd"
        return pd_file.read(path) if name and path.is_file() else None

    def patches(self):
        """Every patch, in the order in which people meet them: help, instruments, their parts."""
        return sorted(self.folder.glob("*.pd"), key=lambda p: (not p.stem.endswith("-help"), p.name))


class Drawing:
    """`boxes`: Drawn, by the number that cords use; None for an array, which its graph draws. `cords`: Cord."""

    def __init__(self, canvas, stage, path=()):
        self.canvas, self.path = canvas, path
        self.boxes = [None if b.kind in ("array", "scalar") else
                      pd_boxes.drawn_box(b, canvas.font, stage.abstraction) for b in canvas.boxes]
        self.cords = [self.cord(stage, *ends) for ends in canvas.cords]

    def port(self, number, index, count):
        """Where the cord of that outlet or inlet begins, across."""
        drawn = self.boxes[number]
        left, right = drawn.frame.left, drawn.frame.right
        if drawn.box.kind == "msg":
            right -= pd_boxes.flag_width(drawn.frame)
        return left + (int(right - left - pd_boxes.PORT) * index // (count - 1) if count > 1 else 0) + 3

    def cord(self, stage, source, outlet, target, inlet):
        a, b = self.boxes[source], self.boxes[target]
        outlets, inlets = stage.ports.of(a.box)[1], stage.ports.of(b.box)[0]
        if outlet >= outlets or inlet >= inlets:
            raise ValueError(f"a cord from outlet {outlet} of {a.name} ({outlets}) to inlet {inlet} of {b.name} "
                             f"({inlets})")
        return Cord(source, outlet, target, inlet, (self.port(source, outlet, outlets), a.frame.bottom),
                    (self.port(target, inlet, inlets), b.frame.top))

    @property
    def where(self):
        return "/".join(self.path) or "front"


def drawings(canvas, stage, path=()):
    """The canvas and all within it that have a window of their own, outermost first."""
    yield Drawing(canvas, stage, path)
    for box in canvas.boxes:
        if box.canvas and not box.canvas.arrays:
            yield from drawings(box.canvas, stage, (*path, " ".join(box.words[1:]) or box.name))
