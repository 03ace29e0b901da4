"""Reads a Pd patch into canvases of boxes and cords, without Pd."""
import re

OBJECTS_OF_PD = ("obj", "msg", "floatatom", "symbolatom", "text")
HIDDEN_NAME = 8  # a flag of an array


class PdBox:
    """One numbered element of a canvas: `kind` (obj, msg, text, floatatom, canvas, array...), its position, its words
    and the canvas inside it."""

    def __init__(self, kind, x, y, words, chars=0, canvas=None):
        self.kind, self.x, self.y, self.words, self.chars, self.canvas = kind, x, y, words, chars, canvas

    @property
    def name(self):
        return self.words[0] if self.words else ""

    def plain_words(self):
        return [plain(word) for word in self.words]


class PdCanvas:
    """A window: its boxes, cords (outlet's box, outlet, inlet's box, inlet), arrays (name, size), the fields of
    `coords`, and the font size, which is the outermost window's."""

    def __init__(self, name, width, height, font=12):
        self.name, self.width, self.height, self.font = name, width, height, font
        self.boxes, self.cords, self.arrays, self.coordinates = [], [], [], None
        self.hidden_names = set()  # names of arrays that their graph does not show


def records(text):
    """The lines of a Pd file, each ended by a semicolon that no backslash precedes."""
    for record in re.split(r"(?<!\\);\s*(?=\n|$)", text):
        record = record.strip().replace("\n", " ")
        if record.startswith("#"):
            yield record


def words_of(text):
    """Words split at blanks that no backslash precedes; `f 22` after a comma is the box's width."""
    chars = 0
    if found := re.search(r"(?<!\\), f (\d+)\s*$", text):
        chars, text = int(found.group(1)), text[:found.start()]
    words = [w for w in re.split(r"(?<!\\) ", text.strip()) if w]
    return words, chars


def plain(word):
    """A word without Pd's backslashes."""
    return re.sub(r"\\(.)", r"\1", word)


def read(path, own=None):
    """The outermost canvas. `own` replaces $0, the number that makes a patch's names unique."""
    stack, root = [], None
    text = path.read_text()
    for record in records(text.replace("\\$0", own) if own else text):
        kind, rest = record.split(" ", 1)
        fields = rest.split(" ")
        if kind == "#N" and fields[0] == "canvas":
            font = stack[0].font if stack else int(fields[5])
            canvas = PdCanvas(plain(fields[5]) if len(fields) > 5 else "", int(fields[3]), int(fields[4]), font)
            root = root or canvas
            stack.append(canvas)
        elif kind == "#X":
            _element(stack, fields, rest)
        elif kind != "#A":
            raise ValueError(f"{path}: {record[:60]}: expected #N canvas, #X or #A")
    return root


def _element(stack, fields, rest):
    what, canvas = fields[0], stack[-1]
    if what == "connect":
        canvas.cords.append(tuple(int(n) for n in fields[1:5]))
    elif what == "coords":
        canvas.coordinates = [float(n) for n in fields[1:]]
    elif what == "array":
        canvas.arrays.append((plain(fields[1]), int(fields[2])))
        if int(fields[4]) & HIDDEN_NAME:
            canvas.hidden_names.add(plain(fields[1]))
        canvas.boxes.append(PdBox("array", 0, 0, [plain(fields[1])]))
    elif what == "restore":
        inner = stack.pop()
        words, _ = words_of(" ".join(fields[3:]))
        stack[-1].boxes.append(PdBox("canvas", int(fields[1]), int(fields[2]), [plain(w) for w in words],
                                     canvas=inner))
    elif what in OBJECTS_OF_PD:
        words, chars = words_of(" ".join(fields[3:]))
        canvas.boxes.append(PdBox(what, int(fields[1]), int(fields[2]), words, chars))
    else:
        raise ValueError(f"#X {rest[:60]}: this Pd element is not supported")
