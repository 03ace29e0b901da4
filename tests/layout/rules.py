"""What is wrong with a drawn canvas, by rule.

crossed   a cord runs through a box, a comment, a label or the name of a graph
overlap   two boxes, comments, labels or graphs' names share more than an edge
cut       something reaches beyond its window, or beyond the part of it that the parent shows
up        a cord ends above the place where it begins; except in a counter, [f] with [+ 1] close below it, and where
          a box hears itself ([list split] that takes a list apart), for which no place is better
hidden    a coloured panel is drawn over something that came before it
astride   something lies half on a coloured panel and half beside it
web       more cords cross each other than a reader can follow
"""
from dataclasses import dataclass

from pd_boxes import Rectangle, is_graph

INSET = 2  # a cord or a box that touches an edge is drawn beside it
ROW_INSET = 3  # above and below the letters of a line
SMALL_PANEL = 40  # a panel no wider or higher than this carries a heading: boxes beside it are not on it
COUNTER = 80  # across and down, of the cord that closes a counter
WEB = 4  # crossings that any patch may have; one more for each eight cords


@dataclass(frozen=True)
class Fault:
    rule: str
    text: str


@dataclass
class Item:
    """Something that takes room: a frame, or a line of letters."""
    number: int
    what: str
    name: str
    room: Rectangle


def letters(rectangle):
    return Rectangle(rectangle.left, rectangle.top + ROW_INSET, rectangle.right, rectangle.bottom - ROW_INSET)


def items(drawing):
    """All that takes room, except panels, on which things stand."""
    found = []
    for number, drawn in enumerate(drawing.boxes):
        if not drawn:
            continue
        if drawn.kind in ("box", "widget", "graph"):
            found.append(Item(number, "box", drawn.name, drawn.frame))
        if drawn.kind == "text":
            found += [Item(number, "comment", text[:40], letters(room)) for text, room in drawn.lines]
        what = "graph's name" if drawn.kind == "graph" else "label"
        found += [Item(number, what, text, letters(room)) for text, room in drawn.labels]
    return found


def runs_through(start, end, room):
    """Whether the straight cord passes through a rectangle: Liang and Barsky's clipping."""
    (x0, y0), (x1, y1) = start, end
    dx, dy, first, last = x1 - x0, y1 - y0, 0.0, 1.0
    if room.right <= room.left or room.bottom <= room.top:
        return False
    for p, q in ((-dx, x0 - room.left), (dx, room.right - x0), (-dy, y0 - room.top), (dy, room.bottom - y0)):
        if p == 0:
            if q <= 0:
                return False
            continue
        t = q / p
        if p < 0:
            first = max(first, t)
        else:
            last = min(last, t)
        if first >= last:
            return False
    return True


def cord_name(drawing, cord):
    return f"the cord from [{drawing.boxes[cord.source].name}] to [{drawing.boxes[cord.target].name}]"


def crossed(drawing):
    for cord in drawing.cords:
        for item in items(drawing):
            own = item.number in (cord.source, cord.target) and item.what == "box"
            inset = 0 if item.what != "box" else INSET
            if not own and runs_through(cord.start, cord.end, item.room.shrunk(inset)):
                yield Fault("crossed", f"{cord_name(drawing, cord)} runs through the {item.what} '{item.name}'")


def overlap(drawing):
    found = items(drawing)
    for i, a in enumerate(found):
        for b in found[:i]:
            if a.number == b.number and a.what == b.what:
                continue  # lines of one comment
            across, down = a.room.shared_with(b.room)
            if across > 1 and down > 1:
                yield Fault("overlap", f"the {b.what} '{b.name}' and the {a.what} '{a.name}' share {across:.0f} x "
                                       f"{down:.0f} pixels")


def shown_part(canvas):
    """The rectangle that a graph on its parent shows; None where the canvas shows nothing there."""
    if is_graph(canvas) and len(canvas.coordinates) > 8 and not canvas.arrays:
        width, height, _, left, top = canvas.coordinates[4:9]
        return Rectangle(left, top, left + width, top + height)
    return None


def cut(drawing):
    window = Rectangle(0, 0, drawing.canvas.width, drawing.canvas.height)
    panels = [Item(n, "panel", d.name, d.frame) for n, d in enumerate(drawing.boxes) if d and d.kind == "panel"]
    everything = items(drawing) + panels
    for item in everything:
        if not window.holds(item.room):
            yield Fault("cut", f"the {item.what} '{item.name}' reaches beyond the window")
    part = shown_part(drawing.canvas)
    for item in everything if part else ():
        drawn = drawing.boxes[item.number]
        shown = drawn.kind in ("widget", "graph", "panel", "text") and part.holds(drawn.frame)
        across, down = part.shared_with(drawn.frame)
        astride = drawn.kind != "box" and not shown and across > 1 and down > 1
        if astride or (shown and not part.holds(item.room)):
            yield Fault("cut", f"the {item.what} '{item.name}' reaches beyond what the parent shows")


def counts(drawing, cord):
    """Whether the cord closes a counter as Pd's users draw it: [f] and, close below it, [+ 1], or [+ 1] and
    [mod], whose cord goes back up into its right inlet."""
    after = {c.target for c in drawing.cords if c.source == cord.target}
    forth = cord.source in after or any(c.source in after and c.target == cord.source for c in drawing.cords)
    (x0, y0), (x1, y1) = cord.start, cord.end
    return forth and cord.inlet > 0 and abs(x1 - x0) <= COUNTER and y0 - y1 <= COUNTER


def up(drawing):
    for cord in drawing.cords:
        if cord.end[1] <= cord.start[1] and cord.source != cord.target and not counts(drawing, cord):
            yield Fault("up", f"{cord_name(drawing, cord)} goes up")


def hidden(drawing):
    for number, panel in enumerate(drawing.boxes):
        if not panel or panel.kind != "panel":
            continue
        for before, drawn in enumerate(drawing.boxes[:number]):
            if not drawn or (drawn.kind == "panel" and drawn.frame.holds(panel.frame)):
                continue
            across, down = panel.frame.shared_with(drawn.frame)
            if across > 1 and down > 1:
                yield Fault("hidden", f"the panel '{panel.name}' is drawn over '{drawn.name}'")


def astride(drawing):
    panels = [d.frame for d in drawing.boxes if d and d.kind == "panel"]
    for panel in panels:
        if panel.right - panel.left <= SMALL_PANEL or panel.bottom - panel.top <= SMALL_PANEL:
            continue
        for item in items(drawing):
            across, down = panel.shared_with(item.room)
            if across > INSET and down > INSET and not panel.holds(item.room, 1):
                yield Fault("astride", f"the {item.what} '{item.name}' lies half on a panel")


def cross(a, b):
    """Whether two cords with no end in common cross."""
    if (a.source, a.outlet) == (b.source, b.outlet) or (a.target, a.inlet) == (b.target, b.inlet):
        return False

    def side(p, q, r):
        return (q[0] - p[0]) * (r[1] - p[1]) - (q[1] - p[1]) * (r[0] - p[0])
    return (side(a.start, a.end, b.start) * side(a.start, a.end, b.end) < 0
            and side(b.start, b.end, a.start) * side(b.start, b.end, a.end) < 0)


def web(drawing):
    cords = drawing.cords
    pairs = [(a, b) for i, a in enumerate(cords) for b in cords[:i] if cross(a, b)]
    if len(pairs) > WEB + len(cords) // 8:
        yield Fault("web", f"{len(pairs)} crossings of {len(cords)} cords")


def faults(drawing):
    found = []
    for rule in (crossed, overlap, cut, up, hidden, astride, web):
        found += dict.fromkeys(rule(drawing))
    return found
