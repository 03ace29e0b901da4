"""How large Pd 0.53 draws what stands in a patch: boxes, comments, sliders and their labels, in pixels.

Pd sets type in a fixed cell per font size; Tk measures it in DejaVu Sans Mono (`font measure`, `font
metrics -linespace`). Object boxes as in Pd's g_rtext.c and g_text.c, sliders as in its g_*slider.c,
number boxes as in g_numbox.c.
"""
import math
import re
from dataclasses import dataclass, field

CELL = {8: (5, 10), 10: (6, 13), 12: (7, 15), 16: (10, 19), 24: (14, 29), 36: (22, 44)}
MARGIN = 2  # left and right of a box's text
ABOVE, BELOW = 3, 2
LINE_LIMIT = 60  # characters, of a box without a width of its own
PORT = 7  # width of an inlet or outlet
WIDGETS = {  # words that hold: label, the fields after it are dx dy font size
    "bng": 7, "tgl": 5, "hsl": 9, "vsl": 9, "nbx": 9, "hradio": 7, "vradio": 7, "vu": 4, "cnv": 6}


@dataclass(frozen=True)
class Rectangle:
    left: float
    top: float
    right: float
    bottom: float

    def shrunk(self, by):
        return Rectangle(self.left + by, self.top + by, self.right - by, self.bottom - by)

    def moved(self, x, y):
        return Rectangle(self.left + x, self.top + y, self.right + x, self.bottom + y)

    def shared_with(self, other):
        """Width and height of what both cover; negative where they are apart."""
        return (min(self.right, other.right) - max(self.left, other.left),
                min(self.bottom, other.bottom) - max(self.top, other.top))

    def holds(self, other, slack=0):
        return (self.left - slack <= other.left and other.right <= self.right + slack
                and self.top - slack <= other.top and other.bottom <= self.bottom + slack)


@dataclass
class Drawn:
    """A box as drawn: its frame (None for a comment), the lines of its text, of its label or of the names above a
    graph, each with the rectangle of its letters."""
    box: object
    kind: str  # box, text, graph, panel, widget
    frame: Rectangle = None
    lines: list = field(default_factory=list)  # (text, Rectangle)
    labels: list = field(default_factory=list)

    @property
    def name(self):
        words = " ".join(self.box.plain_words()) if self.box.words else self.box.kind
        if self.kind in ("widget", "panel") and self.labels:
            words = f"{self.box.name} {self.labels[0][0]}"
        return words[:44].strip()


def cell(size):
    """Width and height of a character in a box or comment."""
    fitting = [s for s in CELL if s <= size]
    return CELL[max(fitting)] if fitting else CELL[8]


def label_width(text, size):
    """Of a label of a slider, button or panel: its font has `size` pixels, not those of the nearest cell."""
    return round(0.602 * size) * len(text)


def number_text(word):
    """A word as Pd shows it: numbers in the shortest form."""
    if re.fullmatch(r"[-+]?(\d+\.?\d*|\.\d+)(e[-+]?\d+)?", word):
        return f"{float(word):.6g}"
    return word


def shown_text(box):
    """The text of a box as Pd sets it: commas close to the word before, a new line after a semicolon."""
    out = ""
    for word in box.words:
        if word in ("\\,", ","):
            out = out.rstrip(" ") + ", "
        elif word in ("\\;", ";"):
            out = out.rstrip(" ") + ";\n"
        else:
            word = re.sub(r"\\([$,;])", r"\1", word)
            out += number_text(word) + " "
    return out[:-1] if out.endswith(" ") else out


def wrapped(text, limit):
    """Lines as Pd breaks them: at the last blank within the limit, else in the word."""
    lines = []
    while text:
        end = text[:limit].find("\n")
        if end >= 0:
            line, text = text[:end], text[end + 1:]
        elif len(text) <= limit:
            line, text = text, ""
        else:
            blank = text[:limit + 1].rfind(" ")
            line, text = (text[:blank], text[blank + 1:]) if blank >= 0 else (text[:limit], text[limit:])
        lines.append(line)
    return lines or [""]


def text_lines(lines, x, y, size):
    width, height = cell(size)
    return [(line, Rectangle(x, y + height * i, x + width * len(line), y + height * (i + 1)))
            for i, line in enumerate(lines) if line.strip()]


def text_box(box, size, text=None):
    """An object, a message or a comment."""
    text = shown_text(box) if text is None else text
    width, height = cell(size)
    lines = wrapped(text, box.chars or LINE_LIMIT)
    columns = box.chars or max(max(map(len, lines)), 1 if box.kind == "text" else 3)
    frame = Rectangle(box.x, box.y, box.x + columns * width + 2 * MARGIN,
                      box.y + len(lines) * height + ABOVE + BELOW)
    drawn = Drawn(box, "text" if box.kind == "text" else "box", frame,
                  text_lines(lines, box.x + MARGIN, box.y + ABOVE, size))
    return drawn


def flag_width(frame):
    """How far the corners of a message stand out on its right."""
    return min((int(frame.bottom) - int(frame.top)) // 4, 10)


def label(text, x, y, size):
    return [(text, Rectangle(x, y - size / 2, x + label_width(text, size), y + size / 2))]


def widget(box):
    """A slider, button, number box, meter or panel, and its label."""
    w = box.plain_words()
    kind, at = w[0], WIDGETS[w[0]]
    number = [float(v) if re.fullmatch(r"[-+\d.e]+", v) else 0 for v in w]
    x, y = box.x, box.y
    if kind in ("bng", "tgl"):
        frame = Rectangle(x, y, x + number[1], y + number[1])
    elif kind == "hsl":
        frame = Rectangle(x - 3, y, x + number[1] + 2, y + number[2])
    elif kind == "vsl":
        frame = Rectangle(x, y - 2, x + number[1], y + number[2] + 3)
    elif kind == "nbx":
        width = math.floor(number[at + 4] * 31 * number[1]) // 36 + int(number[2]) // 2 + 4
        frame = Rectangle(x, y, x + width, y + number[2])
    elif kind == "hradio":
        frame = Rectangle(x, y, x + number[1] * number[4], y + number[1])
    elif kind == "vradio":
        frame = Rectangle(x, y, x + number[1], y + number[1] * number[4])
    elif kind == "vu":
        frame = Rectangle(x - 1, y - 2, x + number[1] + 1, y + number[2] + 2)
    else:
        frame = Rectangle(x, y, x + number[2], y + number[3])
    drawn = Drawn(box, "panel" if kind == "cnv" else "widget", frame)
    if w[at] != "empty":
        drawn.labels = label(w[at], x + number[at + 1], y + number[at + 2], number[at + 4])
    return drawn


def atom_box(box, size):
    """floatatom, symbolatom, listbox: width low high label_position label receive send font_size."""
    words = box.words + ["-"] * 8
    own = int(words[7]) if re.fullmatch(r"\d+", words[7]) else 0
    width, height = cell(own or size)
    columns = int(words[0]) or 3
    frame = Rectangle(box.x, box.y, box.x + columns * width + 2, box.y + height + 4)
    drawn = Drawn(box, "widget", frame)
    text = re.sub(r"\\(.)", r"\1", words[4])
    if text != "-":
        length, tall = cell(size)[0] * len(text), cell(size)[1]
        x, y = {"0": (frame.left - 3 - length, frame.top + 2), "1": (frame.right + 2, frame.top + 2),
                "2": (frame.left - 1, frame.top - 1 - tall), "3": (frame.left - 1, frame.bottom + 3)}[words[3]]
        drawn.labels = [(text, Rectangle(x, y, x + length, y + tall))]
    return drawn


def is_graph(canvas):
    """Whether a canvas shows itself on its parent."""
    return bool(canvas and canvas.coordinates and len(canvas.coordinates) > 6 and canvas.coordinates[6])


def graph_box(box, canvas, size):
    """An array's graph with the arrays' names above it, or a sub-patch or abstraction that shows what is in it."""
    width, height = canvas.coordinates[4:6]
    frame = Rectangle(box.x, box.y, box.x + width, box.y + height)
    drawn = Drawn(box, "graph", frame)
    hidden = int(canvas.coordinates[6]) & 2
    y = box.y - 1
    across, tall = cell(canvas.font or size)
    for name, _ in canvas.arrays:
        if not hidden and name not in canvas.hidden_names:
            y -= tall
            name = name.replace("$0", "1000")
            drawn.labels.append((name, Rectangle(box.x, y, box.x + across * len(name), y + tall)))
    if not hidden and not canvas.arrays and len(canvas.coordinates) > 8:
        drawn.lines = text_box(box, size).lines
    return drawn


def drawn_box(box, size, abstractions):
    """Any box of a canvas as Pd draws it. `abstractions(name)`: the canvas of a file, or None."""
    if box.kind in ("floatatom", "symbolatom", "listbox"):
        return atom_box(box, size)
    if box.kind == "obj" and box.name in WIDGETS:
        return widget(box)
    canvas = box.canvas if box.kind == "canvas" else abstractions(box.name) if box.kind == "obj" else None
    if is_graph(canvas):
        return graph_box(box, canvas, size)
    drawn = text_box(box, size)
    if box.kind == "msg":
        f = drawn.frame
        drawn.frame = Rectangle(f.left, f.top, f.right + flag_width(f), f.bottom)
    return drawn
