"""Converts a Pd patch of this package into a Max patcher.

Objects (pd_vocabulary.py) and cords stay the same, with these differences. Max orders a fan-out by position, so every
control outlet with several cords gets a [t]. Max's sliders have no send and receive names, so pd_widgets.py adds [r]
and [s]. Arrays become scope~ and multislider. If a Pd object has no equivalent, the conversion ends with its name,
unless the caller lists it, with the reason, in `without`.
"""
import re

import layout
import pd_file
import pd_widgets
import text_size
from patcher import Box, Patcher
from pd_file import plain
from pd_vocabulary import NoEquivalent, decimal, message_text, object_text

TRIGGER = {"bang": "b", "int": "i", "float": "f"}
PURE = ("metro", "loadbang", "f", "+", "%", "t", "message", "r", "sel")  # left out if nothing receives their output


class Names:
    """The send and receive names in all patches of a set."""

    def __init__(self, canvases):
        self.sent, self.received, self.arrays = set(), set(), {}
        self.only_scopes = set()  # only [tabwrite~] receives them, which a scope~ does not need
        for canvas in canvases:
            self._collect(canvas)
        self.only_scopes -= self.received

    def _collect(self, canvas):
        for name, size in canvas.arrays:
            self.arrays[name] = size
        for box in canvas.boxes:
            if box.canvas:
                self._collect(box.canvas)
            words = [plain(w) for w in box.words]
            if box.kind == "obj" and len(words) > 1:
                ends = [canvas.boxes[d].name for s, _, d, _ in canvas.cords if canvas.boxes[s] is box]
                if words[0] == "r" and ends and set(ends) == {"tabwrite~"}:
                    self.only_scopes.add(words[1])
                else:
                    self._object(words)
            elif box.kind == "msg":
                self.sent |= set(re.findall(r"; (\S+)", " ".join(words)))
            elif box.kind == "floatatom":
                self.received.add((words + ["-"] * 7)[5])
                self.sent.add((words + ["-"] * 7)[6])

    def _object(self, words):
        at = pd_widgets.SENDS.get(words[0])
        if at:
            self.sent.add(words[at])
            self.received.add(words[at + 1])
        elif words[0] in ("s", "send", "tabwrite", "tabwrite~"):
            self.sent.add(words[1])
        elif words[0] in ("r", "receive"):
            self.received.add(words[1])


class Converter:
    def __init__(self, where, names, abstractions=(), without=None, top=20):
        self.where, self.names, self.abstractions = where, names, abstractions
        self.without, self.top = without or {}, top
        self.left_out = []  # (object, reason) for each object left out, to report to the reader

    def convert(self, canvas, top=None, patcher=None):
        work = _Canvas(self, canvas, patcher or Patcher(0, 0))
        work.boxes_from_pd()
        work.cords_from_pd()
        work.order_fan_outs()
        work.arrange(self.top if top is None else top)
        return work.patcher

    def omitted(self, what):
        """Whether the caller gave a reason to leave this object out."""
        for name, reason in self.without.items():
            if what == name or " " in name and what.startswith(name):
                if reason:
                    self.left_out.append((name, reason))
                return True
        return False

    def shortened(self, text):
        """The text without the sentences whose beginnings are in `without`."""
        for name in self.without:
            if " " in name and (start := text.find(name)) > 0:
                end = text.find(". ", start)
                text = text[:start].rstrip() + (text[end + 1:] if end >= 0 else "")
        return text


class _Canvas:
    """One canvas during its conversion."""

    def __init__(self, converter, canvas, patcher):
        self.converter, self.canvas, self.patcher = converter, canvas, patcher
        self.made = {}  # index of a Pd box: (box for its inlets, box for its outlets, swapped inlets)
        self.widgets, self.panels, self.dropped = [], [], []

    # -- boxes ------------------------------------------------------------------------------------

    def boxes_from_pd(self):
        texts = [b for b in self.canvas.boxes if b.kind == "text"]
        consumed = self._menus(texts)
        for index, pd_box in enumerate(self.canvas.boxes):
            if pd_box in consumed or index in self.made or pd_box.kind == "array":
                continue
            try:
                self._box(index, pd_box)
            except NoEquivalent as error:
                if not self.converter.omitted(str(error)):
                    raise ValueError(f"{self.converter.where.name}: [{error}] at {pd_box.x} {pd_box.y} "
                                     "has no equivalent in Max") from error

    def _menus(self, texts):
        consumed = []
        for index, pd_box in enumerate(self.canvas.boxes):
            if pd_box.kind == "obj" and pd_box.name in ("vradio", "hradio"):
                widget, used = pd_widgets.menu(pd_box.x, pd_box.y, pd_box.words, texts)
                consumed += used
                self._widget(index, widget)
        return consumed

    def _widget(self, index, widget):
        if any(self.converter.omitted(label.text) for label in widget.labels):
            return
        names = self.converter.names
        if widget.receives and widget.receives not in names.sent:
            widget.receives = None
        if widget.sends and widget.sends not in names.received:
            widget.sends = None
        self.patcher.add(widget.box)
        for label in widget.labels:
            self.patcher.add(label)
        self.widgets.append(widget)
        if index is not None:
            self.made[index] = (widget.box, widget.box, False)

    def _box(self, index, pd_box):
        if pd_box.kind == "text":
            self._comment(pd_box)
        elif pd_box.kind == "msg":
            self._message(index, pd_box)
        elif pd_box.kind == "floatatom":
            self._widget(index, pd_widgets.number_atom(pd_box))
        elif pd_box.kind == "symbolatom":
            self._add(index, pd_box, Box("message", "", width=70, height=22), 7 * 7, 18)
        elif pd_box.kind == "canvas":
            self._subpatch(index, pd_box)
        else:
            self._object(index, pd_box)

    def _add(self, index, pd_box, box, width, height):
        box.pd = (pd_box.x, pd_box.y, width, height)
        self.patcher.add(box)
        if index is not None:
            self.made[index] = (box, box, False)
        return box

    def _comment(self, pd_box):
        text = pd_widgets.reworded(" ".join(plain(w) for w in pd_box.words).replace(" ,", ",").replace(" ;", ";"))
        if self.converter.omitted(text):
            return
        text = self.converter.shortened(text)
        chars = pd_box.chars or min(60, len(text))
        width, _ = text_size.box_size(text, "comment", chars * 7 + 10)
        self._add(None, pd_box, Box("comment", text, width=width), chars * 7, 15 * (1 + len(text) // 61))

    def _message(self, index, pd_box):
        words = [plain(w) for w in pd_box.words]
        if " ".join(words) == "; pd dsp $1":
            self._add(index, pd_box, Box("newobj", "adstatus switch"), 80, 19)
            return
        if self.converter.omitted(" ".join(words)):
            return
        targets = [self.canvas.boxes[d] for s, _, d, _ in self.canvas.cords if s == index]
        to_vline = bool(targets) and all(t.name == "vline~" for t in targets)
        text = message_text(pd_box.words, to_vline)
        if text == "set $1":
            text = "$1"  # a message box that received `set` would lose its words
        most = pd_box.chars * 7 + 12 if pd_box.chars else 420
        width, _ = text_size.box_size(text, "message", most)
        length = pd_box.chars or min(60, len(" ".join(words)))
        self._add(index, pd_box, Box("message", text, width=width), length * 7 + 6, 19)

    def _subpatch(self, index, pd_box):
        inner = pd_box.canvas
        if inner.arrays:
            name = inner.arrays[0][0]
            values = self._how_filled(name)
            name, box = pd_widgets.graph(pd_box, values)
            self.patcher.add(box)
            self.widgets.append(pd_widgets.Widget(box, None, name, receiver="r" if values else "receive~"))
            return
        name = " ".join(pd_box.words[1:]) if pd_box.words[:1] == ["pd"] else " ".join(pd_box.words)
        if self.converter.omitted(f"pd {name}"):
            return
        converted = self.converter.convert(inner, top=16)
        box = Box("newobj", f"p {name}", ports=converted.ports())
        box.patcher = converted
        ports = max(len(box.inlets), len(box.outlets))
        box.width = max(box.width, 22.0 * ports)
        self._add(index, pd_box, box, max(7 * len(name) + 24, 20 * ports), 19)

    def _how_filled(self, name):
        """"" for a signal, "list" or "scroll" for numbers."""
        def uses(canvas):
            for box in canvas.boxes:
                if box.canvas:
                    yield from uses(box.canvas)
                elif box.kind == "obj" and name in [plain(w) for w in box.words[1:]]:
                    yield box.name
        kinds = set(uses(self.converter.root))
        return "scroll" if "tabwrite" in kinds else "list" if "s" in kinds else ""

    WIDGETS = {"bng": pd_widgets.bang, "tgl": pd_widgets.toggle, "hsl": pd_widgets.slider,
               "vsl": pd_widgets.slider, "nbx": pd_widgets.number_box, "cnv": pd_widgets.panel}

    def _object(self, index, pd_box):
        name = pd_box.name
        if name in self.WIDGETS:
            widget = self.WIDGETS[name](pd_box.x, pd_box.y, pd_box.words)
            self._widget(index, widget)
            if name == "cnv" and not widget.is_bar:
                self.panels.append(widget.box)
            return
        length = pd_box.chars or len(" ".join(pd_box.words))
        if " ".join(plain(w) for w in pd_box.words) in self.converter.without:
            return
        if name in PURE and not any(index in (c[0], c[2]) for c in self.canvas.cords):
            return  # left over in the Pd patch: wired to nothing
        if name in ("inlet", "inlet~", "outlet", "outlet~"):
            self._port(index, pd_box)
        elif name == "dac~":
            self._add(index, pd_box, Box("ezdac~", width=45, height=45), 34, 30)
        elif name == "hip~":
            self._high_pass(index, pd_box)
        elif name in ("sel", "select"):
            self._select(index, pd_box)
        elif name in ("tabwrite~", "tabwrite"):
            text = ("send~ " if name == "tabwrite~" else "s ") + plain(pd_box.words[1])
            self._add(index, pd_box, Box("newobj", text), length * 7 + 5, 19)
        else:
            text = object_text(pd_box.words, self.converter.abstractions)
            if text == "prepend 0" and any(b.name == "s" and b.words[1] in self.converter.names.arrays
                                           for b in self.canvas.boxes):
                text = "t l"  # drops the index at which writing begins, since a multislider takes only the list
            box = Box("newobj", text)
            ports = max(len(box.inlets), len(box.outlets))
            wanted = pd_box.chars * 7.6 if pd_box.chars else 0
            box.width = round(max(box.width, wanted, 14.0 * ports))
            box = self._add(index, pd_box, box, length * 7 + 5, 19)
            self.made[index] = (box, box, name == "spigot")

    def _port(self, index, pd_box):
        kind = pd_box.name.rstrip("~")
        outlets = (["signal"] if pd_box.name.endswith("~") else [""]) if kind == "inlet" else []
        inlets = [] if kind == "inlet" else ["both"]
        text = " ".join(plain(w) for w in pd_box.words[1:])
        box = Box(kind, width=30, height=30, ports=(inlets, outlets), comment=text)
        self._add(index, pd_box, box, 30, 19)
        if text:
            label = Box("comment", text)
            label.pd = (pd_box.x + 32, pd_box.y + 1, len(text) * 7, 16)
            self.patcher.add(label)

    def _high_pass(self, index, pd_box):
        """Converts hip~ to the signal minus its low-pass with the same corner frequency."""
        low = Box("newobj", f"onepole~ {pd_box.words[1]}.")
        low.pd = (pd_box.x + 24, pd_box.y, 80, 19)
        self.patcher.add(low)
        difference = Box("newobj", "-~")
        difference.pd = (pd_box.x, pd_box.y + 8, 30, 19)
        self.patcher.add(difference)
        self.patcher.connect(low, 0, difference, 1)
        self.made[index] = (difference, difference, False)
        difference.low_pass = low

    def _select(self, index, pd_box):
        """Max's sel ignores floats. Whole numbers become integers before sel. Objects that calculate give floats, for
        which sel has an attribute."""
        sources = [self.canvas.boxes[s] for s, _, d, _ in self.canvas.cords if d == index]
        numbers = [plain(w) for w in pd_box.words[1:]]
        if any(s.name == "expr" or s.name == "f" and len(s.words) > 1 and "$" in s.words[1] for s in sources):
            text = " ".join(["sel"] + [decimal(n) for n in numbers] + ["@matchfloat", "1"])
            self._add(index, pd_box, Box("newobj", text), 7 * len(text), 19)
            return
        whole = self._add(None, pd_box, Box("newobj", "i"), 20, 8)
        chosen = self._add(None, pd_box, Box("newobj", " ".join(["sel"] + numbers)),
                           len(" ".join(pd_box.words)) * 7 + 5, 19)
        chosen.pd = (pd_box.x, pd_box.y + 9, *chosen.pd[2:])
        self.patcher.connect(whole, 0, chosen, 0)
        self.made[index] = (whole, chosen, False)

    # -- cords ------------------------------------------------------------------------------------

    def cords_from_pd(self):
        for s, outlet, d, inlet in self.canvas.cords:
            if s not in self.made or d not in self.made:
                if s in self.made:
                    self.dropped.append(self.made[s][1])
                continue  # one end was left out, with a reason
            source, destination, swapped = self.made[s][1], self.made[d][0], self.made[d][2]
            pd_target = self.canvas.boxes[d]
            if pd_target.name == "s" and pd_target.words[1] in self.converter.names.only_scopes:
                self.dropped.append(source)
                if destination in self.patcher.boxes:
                    self.patcher.boxes.remove(destination)
                continue
            if swapped:
                inlet = 1 - inlet
            signal = source.outlets[outlet] == "signal"
            if pd_target.name == "tabwrite~" and not signal or pd_target.name == "tabwrite" and inlet:
                self.dropped.append(source)
                continue
            self.patcher.connect(source, outlet, destination, inlet)
            if low := getattr(destination, "low_pass", None):
                self.patcher.connect(source, outlet, low, 0)
        self._prune()

    def _prune(self):
        """Removes objects that only drove a tabwrite, since scope~ and multislider need no metro."""
        waiting = list(self.dropped)
        while waiting:
            box = waiting.pop()
            if box not in self.patcher.boxes or any(c[0] is box for c in self.patcher.cords):
                continue
            if (box.text or "").split(" ")[0] not in PURE and box.maxclass != "message":
                continue
            waiting += [c[0] for c in self.patcher.cords if c[2] is box]
            self.patcher.cords = [c for c in self.patcher.cords if c[2] is not box]
            self.patcher.boxes.remove(box)

    def order_fan_outs(self):
        """Inserts [t] after each control outlet with several cords; Pd's first cord becomes the rightmost outlet of
        [t]."""
        groups = {}
        for widget in self.widgets:
            if (widget.sends or widget.after) and any(c[0] is widget.box for c in self.patcher.cords):
                raise ValueError(f"{self.converter.where.name}: a widget has a cord beside a name or a logarithm")
        for cord in self.patcher.cords:
            if cord[0].outlets[cord[1]] != "signal":
                groups.setdefault((id(cord[0]), cord[1]), []).append(cord)
        for cords in groups.values():
            if len(cords) > 1:
                self._trigger(cords)

    def _trigger(self, cords):
        source, outlet = cords[0][0], cords[0][1]
        letter = TRIGGER.get(source.outlets[outlet], "l")
        box = Box("newobj", " ".join(["t"] + [letter] * len(cords)))
        x, y, w, h = source.pd
        offset = 0 if len(source.outlets) == 1 else w * outlet / (len(source.outlets) - 1) * 0.9
        box.pd = (x + offset, y + min(h, 19) * 0.55, 7 * len(box.text), 8)
        self.patcher.add(box)
        self.patcher.cords = [c for c in self.patcher.cords if c not in cords]
        self.patcher.connect(source, outlet, box, 0)
        for i, (_, _, destination, inlet, hidden) in enumerate(cords):
            self.patcher.connect(box, len(cords) - 1 - i, destination, inlet, hidden)

    # -- positions --------------------------------------------------------------------------------

    def arrange(self, top):
        boxes = [b for b in self.patcher.boxes if b not in self.panels and hasattr(b, "pd")]
        layout.arrange_all(boxes, self.panels, self.patcher.cords, top)
        ports = [b for b in self.patcher.boxes if b.maxclass in ("inlet", "outlet")]  # Max numbers them by x
        for kind in ("inlet", "outlet"):
            drawn = sorted((b for b in ports if b.maxclass == kind), key=lambda b: b.pd[0])
            if drawn != sorted(drawn, key=lambda b: b.x):
                raise ValueError(f"{self.converter.where.name}: the {kind}s of {self.canvas.name} changed order")
        pd_widgets.hide_wires(self.patcher, self.widgets)
        self.patcher.boxes.sort(key=lambda b: b in self.panels)  # Max draws the first box on top
        self.patcher.fit()


def read(path, abstractions=()):
    """A Pd file whose own names begin with the file's name: in Max, #0 is a number only in abstractions."""
    return pd_file.read(path, "#0" if path.stem in abstractions else path.stem.removesuffix("-help"))


def convert_file(path, names, abstractions=(), without=None, top=20, patcher=None):
    """The patcher of a Pd file, and the objects that were left out, with the reasons."""
    converter = Converter(path, names, abstractions, without, top)
    converter.root = read(path, abstractions)
    result = converter.convert(converter.root, patcher=patcher)
    return result, converter.left_out
