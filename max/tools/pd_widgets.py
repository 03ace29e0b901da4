"""Pd's interface objects as Max's: what is on the screen, and the named wires that Pd keeps in them.

A Pd slider sends to a name and receives from one. In Max these are [s] and [r] boxes; they stand in
columns at the right of the window, hidden while the patcher is locked.
"""
import math

import text_size
from patcher import Box
from pd_file import plain

COLUMN = 190
NOTHING = "empty"
BAR = 36  # a cnv no higher than this is a heading


class Widget:
    """A Max box, what stands beside it, and its wiring."""

    def __init__(self, box, sends=None, receives=None, before=(), after=(), receiver="r"):
        self.box, self.sends, self.receives, self.receiver = box, sends, receives, receiver
        self.same_name = sends is not None and sends == receives  # set without an output, or it loops
        self.before, self.after = before, after  # texts of objects between the names and the box
        self.outlet, self.after_is_shown = None, False  # set where `after` is a shown box
        self.labels = []


def colour(word):
    """#rrggbb as Max writes it."""
    return [round(int(word[i:i + 2], 16) / 255, 3) for i in (1, 3, 5)] + [1.0]


def name_or_none(word):
    return None if word == NOTHING else word


def label_of(word):
    return "" if word == NOTHING else reworded(plain(word))


def reworded(text):
    """A text of a Pd patch in Max's words."""
    for pd_words, max_words in (("Pd's window", "the Max console"), ("-> log", "-> Max console"),
                                ("see the log", "see the Max console"), ("in the log", "in the console"),
                                ("[netreceive]", "[udpreceive]"),
                                ("guidance: computed while guide is on", "guidance")):
        text = text.replace(pd_words, max_words)
    return text


def label_box(widget, text, x, y, width, dx, dy, height):
    """The comment that replaces a label drawn beside, above or below a widget."""
    if not text:
        return
    if dy < 0:
        position = (x, y - 18)
    elif dy > height:
        position = (x, y + height + 3)
    else:
        position = (x + width + 4, y)
    label = Box("comment", text)
    label.pd = (*position, label.width / 1.12, 16)
    widget.labels.append(label)


def bang(x, y, words):
    size = int(words[1])
    box = Box("button", width=max(size, 18), height=max(size, 18))
    box.pd = (x, y, size, size)
    widget = Widget(box, name_or_none(words[5]), name_or_none(words[6]))
    label_box(widget, label_of(words[7]), x, y, size, int(words[8]), int(words[9]), size)
    return widget


def toggle(x, y, words):
    size = int(words[1])
    box = Box("toggle", width=max(size, 20), height=max(size, 20))
    box.pd = (x, y, size, size)
    widget = Widget(box, name_or_none(words[3]), name_or_none(words[4]))
    label_box(widget, label_of(words[5]), x, y, size, int(words[6]), int(words[7]), size)
    return widget


def slider(x, y, words):
    """hsl and vsl. Max's slider is linear: a logarithmic one gets expressions on both sides."""
    across = words[0] == "hsl"
    width, height = int(words[1]), int(words[2])
    low, high, logarithmic = float(words[3]), float(words[4]), int(words[5])
    shape = dict(orientation=1 if across else 2, floatoutput=1, parameter_enable=0)
    before = after = ()
    if logarithmic:
        shape.update(min=0.0, size=1.0)
        ratio = high / low
        after = (f"expr {low:g}*pow({ratio:g}\\, $f1)",)
        before = (f"expr log($f1/{low:g})/{math.log(ratio):.6g}",)
    else:
        shape.update(min=low, size=high - low)
    box = Box("slider", width=round(width * 1.12) if across else max(width, 18),
              height=max(height, 16) if across else round(height * 1.12), **shape)
    box.pd = (x, y, width, height)
    widget = Widget(box, name_or_none(words[7]), name_or_none(words[8]), before, after)
    label_box(widget, label_of(words[9]), x, y, width, int(words[10]), int(words[11]), height)
    return widget


def number_box(x, y, words):
    """nbx. Its range is kept."""
    digits, height = int(words[1]), int(words[2])
    low, high = float(words[3]), float(words[4])
    limits = dict(minimum=low, maximum=high) if high > low else {}
    box = Box("flonum", width=max(50, 9 * digits + 12), height=22, parameter_enable=0, **limits)
    box.pd = (x, y, 9 * digits + 6, height)
    widget = Widget(box, name_or_none(words[7]), name_or_none(words[8]))
    label_box(widget, label_of(words[9]), x, y, 9 * digits + 6, 9 * digits + 10, int(words[11]), height)
    return widget


def number_atom(pd_box):
    """floatatom: width lower upper label_position label receive send."""
    words = pd_box.words
    chars = int(words[0]) or 5
    box = Box("flonum", width=max(50, chars * 8 + 6), height=22, parameter_enable=0)
    box.pd = (pd_box.x, pd_box.y, chars * 7 + 3, 18)
    fields = [None if w in ("-", "\\-") else plain(w) for w in (words + ["-"] * 7)[:7]]
    return Widget(box, fields[6], fields[5])


def menu(x, y, words, texts):
    """A column of radio buttons and the texts beside it become a menu that gives the same numbers."""
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
    box.pd = (x, y, pitch + 4 + 7 * max(map(len, items)), 19)
    return Widget(box, name_or_none(words[5]), name_or_none(words[6])), used


def panel(x, y, words):
    """cnv: a coloured area, and its label as a comment on it."""
    width, height, label = int(words[2]), int(words[3]), label_of(words[6])
    box = Box("panel", width=width, height=height, background=1, bgcolor=colour(words[11]), mode=0,
              border=0, rounded=0, angle=270.0, proportion=0.5)
    box.pd = (x, y, width, height)
    widget = Widget(box)
    widget.is_bar = height <= BAR
    dark = sum(colour(words[11])[:3]) < 1.2
    extra = dict(fontface=1, fontsize=18.0 if int(words[10]) > 14 else 12.0, background=1)
    if dark:
        extra["textcolor"] = [1.0, 1.0, 1.0, 1.0]
    if widget.is_bar:  # a heading: a comment with a background, as wide as the bar
        widget.box = Box("comment", label, width=round(width * 1.12), bgcolor=colour(words[11]), **extra)
        widget.box.pd = (x, y, width, height)
    elif label:
        comment = Box("comment", label, **extra)
        comment.pd = (x + 4, y + 2, comment.width / 1.12, min(16, height - 2))
        widget.labels.append(comment)
    return widget


def graph(pd_box, values):
    """An array that tabwrite~ fills becomes a scope~; one that a list or numbers fill a multislider."""
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
    """Adds the [r], [s] and what is between, in columns right of everything shown."""
    left = max((b.right for b in patcher.boxes), default=0) + 40
    columns = []
    for widget in widgets:
        above = list(widget.before) if widget.receives else []
        if widget.receives:
            above = [f"{widget.receiver} {widget.receives}"] + above
            if widget.same_name:
                above.append("prepend set")
        below = ([] if widget.after_is_shown else list(widget.after)) + (
            [f"s {widget.sends}"] if widget.sends else [])
        if above or below:
            _wire(patcher, widget, above, below, left, columns)


def _wire(patcher, widget, above, below, left, columns):
    box, step = widget.box, 28
    top, bottom = box.y - step * len(above), box.bottom + step * len(below)
    column = next((c for c, taken in enumerate(columns)
                   if all(bottom < t or b < top for t, b in taken)), len(columns))
    if column == len(columns):
        columns.append([])
    columns[column].append((top, bottom))
    x = left + COLUMN * column
    previous = None
    for i, text in enumerate(above):
        made = patcher.object(text, x, top + step * i, hidden=1)
        if previous:
            patcher.connect(previous, 0, made, 0, hidden=True)
        previous = made
    if previous:
        patcher.connect(previous, 0, box, 0, hidden=True)
    previous = widget.outlet or box
    for i, text in enumerate(below):
        made = patcher.object(text, x, box.bottom + 6 + step * i, hidden=1)
        patcher.connect(previous, 0, made, 0, hidden=True)
        previous = made
