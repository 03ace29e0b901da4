"""Converts Pd's interface objects to Max's: their appearance, and the names to which they send and listen.

A Pd slider sends to a name and receives from one. In Max these are [s] and [r] boxes; they stand in
columns at the right of the window, hidden while the patcher is locked.
"""
import math

import text_size
from patcher import Box
from pd_file import plain

COLUMN = 190
NOTHING = "empty"
# The index of the name to which a Pd object sends. After it follow the name that it receives, a label and the label's
# position.
SENDS = {"bng": 5, "tgl": 3, "hsl": 7, "vsl": 7, "nbx": 7, "vradio": 5, "hradio": 5}
BAR = 36  # a cnv no higher than this is a heading


class Widget:
    """A Max box, the boxes beside it, and their cords."""

    def __init__(self, box, sends=None, receives=None, before=(), after=(), receiver="r"):
        self.box, self.sends, self.receives, self.receiver = box, sends, receives, receiver
        self.same_name = sends is not None and sends == receives  # the box is then set without output, to avoid a loop
        self.before, self.after = before, after  # texts of objects between the names and the box
        self.labels = []


def colour(word):
    """#rrggbb as Max writes it."""
    return [round(int(word[i:i + 2], 16) / 255, 3) for i in (1, 3, 5)] + [1.0]


def reworded(text):
    """A text of a Pd patch with Max's terms."""
    for pd_words, max_words in (("Pd's window", "the Max console"), ("-> log", "-> Max console"),
                                ("see the log", "see the Max console"), ("in the log", "in the console"),
                                ("[netreceive]", "[udpreceive]"),
                                ("guidance: computed while guide is on", "guidance")):
        text = text.replace(pd_words, max_words)
    return text


def widget(box, x, y, width, height, words, before=(), after=()):
    """The box that replaces a Pd object with these words, and a comment that replaces its label."""
    at = SENDS[words[0]]
    sends, receives, label = (None if word == NOTHING else plain(word) for word in words[at:at + 3])
    box.pd = (x, y, width, height)
    made = Widget(box, sends, receives, before, after)
    if label:
        comment, dy = Box("comment", reworded(label)), int(words[at + 4])
        position = (x, y - 18) if dy < 0 else (x, y + height + 3) if dy > height else (x + width + 4, y)
        comment.pd = (*position, comment.width / 1.12, 16)
        made.labels.append(comment)
    return made


def bang(x, y, words):
    size = int(words[1])
    return widget(Box("button", width=max(size, 18), height=max(size, 18)), x, y, size, size, words)


def toggle(x, y, words):
    size = int(words[1])
    return widget(Box("toggle", width=max(size, 20), height=max(size, 20)), x, y, size, size, words)


def slider(x, y, words):
    """hsl and vsl. Max's slider is linear: a logarithmic slider gets expressions on both sides."""
    across = words[0] == "hsl"
    width, height, low, high = int(words[1]), int(words[2]), float(words[3]), float(words[4])
    shape, before, after = dict(min=low, size=high - low), (), ()
    if int(words[5]):
        shape = dict(min=0.0, size=1.0)
        after = (f"expr {low:g}*pow({high / low:g}\\, $f1)",)
        before = (f"expr log($f1/{low:g})/{math.log(high / low):.6g}",)
    box = Box("slider", width=round(width * 1.12) if across else max(width, 18),
              height=max(height, 16) if across else round(height * 1.12),
              orientation=1 if across else 2, floatoutput=1, parameter_enable=0, **shape)
    return widget(box, x, y, width, height, words, before, after)


def number_box(x, y, words):
    """nbx. Its range is kept."""
    width, height, low, high = 9 * int(words[1]) + 6, int(words[2]), float(words[3]), float(words[4])
    limits = dict(minimum=low, maximum=high) if high > low else {}
    return widget(Box("flonum", width=max(50, width + 6), height=22, parameter_enable=0, **limits), x, y, width, height,
                  words)


def number_atom(pd_box):
    """floatatom: width lower upper label_position label receive send."""
    words = pd_box.words
    chars = int(words[0]) or 5
    box = Box("flonum", width=max(50, chars * 8 + 6), height=22, parameter_enable=0)
    box.pd = (pd_box.x, pd_box.y, chars * 7 + 3, 18)
    fields = [None if w in ("-", "\\-") else plain(w) for w in (words + ["-"] * 7)[:7]]
    return Widget(box, fields[6], fields[5])


def menu(x, y, words, texts):
    """Converts a column of radio buttons and the texts beside it to a menu that outputs the same numbers."""
    pitch, count = int(words[1]), int(words[4])
    upright = words[0] == "vradio"
    items, used = [], []
    for i in range(count):
        found = [t for t in texts if upright and abs(t.y - (y + i * pitch)) <= pitch * 0.7
                 and 0 < t.x - x < 40 and t not in used]
        found.sort(key=lambda t: abs(t.y - (y + i * pitch)))
        if found:
            used.append(found[0])
            items.append(" ".join(plain(w) for w in found[0].words).replace(" ,", "").replace(",", ""))
        else:
            items.append(str(i))
    width = max(text_size.width(item) for item in items) + 36
    listed = [item for pair in ((name, ",") for name in items) for item in pair][:-1]
    box = Box("umenu", width=round(max(width, 70)), height=22, items=listed, parameter_enable=0)
    return widget(box, x, y, pitch + 4 + 7 * max(map(len, items)), 19, words), used


def panel(x, y, words):
    """Converts cnv to a coloured area with its label as a comment on it."""
    width, height, label = int(words[2]), int(words[3]), "" if words[6] == NOTHING else reworded(plain(words[6]))
    box = Box("panel", width=width, height=height, background=1, bgcolor=colour(words[11]), mode=0,
              border=0, rounded=0, angle=270.0, proportion=0.5)
    box.pd = (x, y, width, height)
    made = Widget(box)
    made.is_bar = height <= BAR
    dark = sum(colour(words[11])[:3]) < 1.2
    extra = dict(fontface=1, fontsize=18.0 if int(words[10]) > 14 else 12.0, background=1)
    if dark:
        extra["textcolor"] = [1.0, 1.0, 1.0, 1.0]
    if made.is_bar:  # a heading: a comment with a background, as wide as the bar
        made.box = Box("comment", label, width=round(width * 1.12), bgcolor=colour(words[11]), **extra)
        made.box.pd = (x, y, width, height)
    elif label:
        comment = Box("comment", label, **extra)
        comment.pd = (x + 4, y + 2, comment.width / 1.12, min(16, height - 2))
        made.labels.append(comment)
    return made


def graph(pd_box, values):
    """Converts an array: if tabwrite~ fills it, to a scope~; if a list or numbers fill it, to a multislider."""
    canvas = pd_box.canvas
    name, size = canvas.arrays[0]
    _, high, _, low, width, height = canvas.coordinates[:6]
    low, high = min(low, high), max(low, high)
    width, height = round(width * 1.12), max(round(height), 40)
    if values:
        box = Box("multislider", width=width, height=height, setminmax=[low, high], settype=1,
                  setstyle=3 if values == "scroll" else 1, size=size, parameter_enable=0)
    else:
        points = max(1, min(size, 256))
        box = Box("scope~", width=width, height=height, range=[low, high], bufsize=points,
                  calccount=max(1, round(size / points)))
    box.pd = (pd_box.x, pd_box.y, canvas.coordinates[4], canvas.coordinates[5])
    return name, box


def hide_wires(patcher, widgets):
    """Adds the [r] and [s] boxes and the boxes between them, in columns at the right of all visible boxes."""
    left = max((b.right for b in patcher.boxes), default=0) + 40
    columns = []
    for widget in widgets:
        above = [f"{widget.receiver} {widget.receives}", *widget.before] if widget.receives else []
        if above and widget.same_name:
            above.append("prepend set")
        below = [*widget.after, *([f"s {widget.sends}"] if widget.sends else [])]
        if above or below:
            _wire(patcher, widget.box, above, below, left, columns)


def _wire(patcher, box, above, below, left, columns):
    step = 28
    top, bottom = box.y - step * len(above), box.bottom + step * len(below)
    column = next((c for c, taken in enumerate(columns)
                   if all(bottom < t or b < top for t, b in taken)), len(columns))
    if column == len(columns):
        columns.append([])
    columns[column].append((top, bottom))
    x = left + COLUMN * column
    chain = [patcher.object(text, x, top + step * i, hidden=1) for i, text in enumerate(above)] + [box] + [
        patcher.object(text, x, box.bottom + 6 + step * i, hidden=1) for i, text in enumerate(below)]
    for source, destination in zip(chain, chain[1:]):
        patcher.connect(source, 0, destination, 0, hidden=True)
