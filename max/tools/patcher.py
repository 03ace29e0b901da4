"""A Max patcher as Python objects, and the JSON that Max reads.

The format is known from patchers that Max saved. A patcher has boxes and lines; a box has an id, a maxclass, a
rectangle and its numbers of inlets and outlets; a subpatcher is the `patcher` of a box whose text is `p NAME`; a tab of
a help patcher is a subpatcher with `showontab`.
"""
import json

import max_objects
import text_size

APPLICATION = {"major": 8, "minor": 6, "revision": 0, "architecture": "x64", "modernui": 1}
WINDOW_TITLE = 26.0  # a tab begins below the row of tabs


class Box:
    """One box. `ports` is (kinds of the inlets, types of the outlets)."""

    def __init__(self, maxclass, text=None, x=0.0, y=0.0, width=None, height=None, ports=None, **extra):
        self.maxclass, self.text, self.extra = maxclass, text, dict(extra)
        self.x, self.y = float(x), float(y)
        self.patcher = None
        self.name = None  # "obj-N", set when its patcher is written
        self.inlets, self.outlets = ports or max_objects.ports(maxclass, text)
        if text is not None and maxclass in ("newobj", "message", "comment"):
            size = self.extra.get("fontsize", text_size.FONT_SIZE)
            natural = text_size.box_size(text, maxclass, width, size, self.extra.get("fontface") == 1)
            self.width = float(width or natural[0])
            self.height = float(height or natural[1])
        else:
            self.width, self.height = float(width or 24), float(height or 24)

    @property
    def hidden(self):
        return bool(self.extra.get("hidden"))

    @property
    def bottom(self):
        return self.y + self.height

    @property
    def right(self):
        return self.x + self.width

    def lines_of_text(self):
        size = self.extra.get("fontsize", text_size.FONT_SIZE)
        return text_size.wrap(self.text or "", self.width - text_size.MARGIN + 0.5, size,
                              self.extra.get("fontface") == 1)

    def as_json(self):
        box = {"id": self.name, "maxclass": self.maxclass, "numinlets": len(self.inlets),
               "numoutlets": len(self.outlets)}
        if self.outlets:
            box["outlettype"] = list(self.outlets)
        box["patching_rect"] = [round(v, 1) for v in (self.x, self.y, self.width, self.height)]
        if self.text is not None:
            box["text"] = self.text
            if self.maxclass == "comment" and (lines := len(self.lines_of_text())) > 1:
                box["linecount"] = lines
        box.update(self.extra)
        if self.patcher:
            box["patcher"] = self.patcher.as_json()
        return {"box": dict(sorted(box.items()))}


class Patcher:
    """Boxes and cords. A cord is (source box, outlet, destination box, inlet, hidden)."""

    def __init__(self, width, height, tab=False, with_tabs=False, **extra):
        self.width, self.height = width, height
        self.tab, self.with_tabs, self.extra = tab, with_tabs, extra
        self.boxes, self.cords = [], []

    def add(self, box):
        self.boxes.append(box)
        return box

    def object(self, text, x, y, **more):
        return self.add(Box("newobj", text, x, y, **more))

    def message(self, text, x, y, **more):
        return self.add(Box("message", text, x, y, **more))

    def comment(self, text, x, y, **more):
        return self.add(Box("comment", text, x, y, **more))

    def connect(self, source, outlet, destination, inlet, hidden=False):
        if not 0 <= outlet < len(source.outlets) or not 0 <= inlet < len(destination.inlets):
            raise ValueError(f"from outlet {outlet} of [{source.text}] to inlet {inlet} of [{destination.text}]: "
                             f"they have {len(source.outlets)} outlets and {len(destination.inlets)} inlets")
        self.cords.append((source, outlet, destination, inlet, hidden))

    def subpatcher(self, name, patcher, x, y, **more):
        ports = patcher.ports()
        box = self.add(Box("newobj", f"p {name}", x, y, ports=ports, **more))
        box.patcher = patcher
        return box

    def ports(self):
        """Inlets and outlets of the subpatcher box, from the inlet and outlet boxes within, left to right."""
        inlets = sorted((b for b in self.boxes if b.maxclass == "inlet"), key=lambda b: b.x)
        outlets = sorted((b for b in self.boxes if b.maxclass == "outlet"), key=lambda b: b.x)
        signal = {id(d) for s, o, d, _, _ in self.cords if s.outlets[o] == "signal"}
        return ([("both" if b.outlets[0] == "signal" else "control") for b in inlets],
                ["signal" if id(b) in signal else "" for b in outlets])

    def fit(self, margin=16):
        """Makes the window as large as its content."""
        shown = [b for b in self.boxes if not b.hidden]
        if shown:
            self.width = max(self.width, max(b.right for b in shown) + margin)
            self.height = max(b.bottom for b in shown) + margin
        return self

    def as_json(self):
        patcher = {"fileversion": 1, "appversion": APPLICATION, "classnamespace": "box",
                   "rect": [0.0 if self.tab else 80.0, WINDOW_TITLE if self.tab else 100.0,
                            round(float(self.width), 1), round(float(self.height), 1)],
                   "bglocked": 0, "openinpresentation": 0, "default_fontsize": text_size.FONT_SIZE,
                   "default_fontface": 0, "default_fontname": "Arial", "gridonopen": 1,
                   "gridsize": [15.0, 15.0], "gridsnaponopen": 1}
        if self.with_tabs:
            patcher.update(showrootpatcherontab=0, showontab=0)
        elif self.tab:
            patcher["showontab"] = 1
        patcher.update(self.extra)
        for number, box in enumerate(self.boxes, 1):
            box.name = f"obj-{number}"
        patcher["boxes"] = [b.as_json() for b in self.boxes]
        patcher["lines"] = [self._line(*cord) for cord in self.cords]
        return patcher

    def _line(self, source, outlet, destination, inlet, hidden):
        line = {"destination": [destination.name, inlet], "source": [source.name, outlet]}
        if hidden:
            line["hidden"] = 1
        return {"patchline": line}

    def text(self):
        return json.dumps({"patcher": self.as_json()}, indent="\t", ensure_ascii=False) + "\n"
