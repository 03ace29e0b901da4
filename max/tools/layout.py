"""Moves boxes that were placed for Pd's font, so that Max's larger boxes do not overlap.

Every box has a place in the Pd patch (`pd`: x, y, width, height). Rows of the same y stay rows, columns of the same x
stay columns; a row is only pushed as far down as the boxes above it need, and long gaps shrink. A panel and the boxes
on it are laid out first and then placed as one block.
"""
SCALE_X = 1.12
ROW = 5  # Pd pixels within which boxes belong to one row
GAP_X = 8
LONGEST_GAP = 30
MARGIN = 8


class Block:
    """A panel with its boxes, placed as one."""
    maxclass = "block"

    def __init__(self, panel, boxes):
        self.panel, self.boxes, self.pd = panel, boxes, panel.pd
        left, top = min(b.x for b in boxes), min(b.y for b in boxes)
        for box in boxes:
            box.x, box.y = box.x - left + MARGIN, box.y - top + MARGIN
        self.x = self.y = 0
        self.width = max(b.right for b in boxes) + MARGIN
        self.height = max(b.bottom for b in boxes) + MARGIN

    @property
    def right(self):
        return self.x + self.width

    @property
    def bottom(self):
        return self.y + self.height

    def settle(self):
        for box in self.boxes:
            box.x, box.y = box.x + self.x, box.y + self.y
        self.panel.x, self.panel.y = self.x, self.y
        self.panel.width, self.panel.height = self.width, self.height


def gap_below(upper, lower, joined):
    """Pixels between two boxes; more if a cord between them runs far to the side."""
    if joined:
        return 14 + min(24, 0.06 * abs(upper.x - lower.x))
    kinds = (upper.maxclass, lower.maxclass)
    if "block" in kinds:
        return 12
    if kinds == ("comment", "comment"):
        return 1
    return 4 if "comment" in kinds else 8


def overlap_in_x(a, b):
    return a[0] < b[0] + b[2] and b[0] < a[0] + a[2]


def rows_of(boxes):
    rows = []
    for box in sorted(boxes, key=lambda b: (b.pd[1], b.pd[0])):
        if rows and box.pd[1] - rows[-1][0].pd[1] <= ROW and not any(
                overlap_in_x(box.pd, other.pd) for other in rows[-1]):
            rows[-1].append(box)
        else:
            rows.append([box])
    return rows


def arrange(boxes, cords, top):
    """Sets x and y of all boxes of one group; the first row may begin at y = top."""
    joined = {(id(s), id(d)) for s, _, d, _, _ in cords}
    rows = rows_of(boxes)
    for row in rows:
        right = None
        for box in sorted(row, key=lambda b: b.pd[0]):
            box.x = round(box.pd[0] * SCALE_X)
            if right is not None:
                box.x = max(box.x, right + GAP_X)
            right = box.right
    done, previous = [], None
    for row in rows:
        here = row[0].pd[1]
        y = top if previous is None else previous[0] + min(max(0, here - previous[1]), LONGEST_GAP)
        for box in row:
            y = max([y] + [above.bottom + gap_below(above, box, (id(above), id(box)) in joined)
                           for above in done if (id(above), id(box)) in joined
                           or above.x < box.right + 2 and box.x < above.right + 2])
        small = [b.height for b in row if b.height <= 24]
        for box in row:  # small boxes of one row share their middle line
            box.y = round(y + (max(small) - box.height) / 2 if box.height <= 24 else y)
        done += row
        previous = (y, here)


def arrange_all(boxes, panels, cords, top):
    """Boxes on panels first, each panel by itself; then the rest with the panels as blocks."""
    owner = {}
    for panel in sorted(panels, key=lambda p: p.pd[2] * p.pd[3]):
        x, y, w, h = panel.pd
        for box in boxes:
            if x - 2 <= box.pd[0] and box.pd[0] + 4 <= x + w and y - 2 <= box.pd[1] and box.pd[1] + 4 <= y + h:
                owner.setdefault(id(box), panel)
    for box in boxes:  # a box that is wired only to boxes outside does not belong to the panel
        wired = [o for c in cords for o in ((c[2],) if c[0] is box else (c[0],) if c[2] is box else ())]
        if wired and id(box) in owner and all(owner.get(id(o)) is not owner[id(box)] for o in wired):
            del owner[id(box)]
    blocks, free = [], [b for b in boxes if id(b) not in owner]
    for panel in panels:
        inside = [b for b in boxes if owner.get(id(b)) is panel]
        if inside:
            arrange(inside, cords, 0)
            blocks.append(Block(panel, inside))
    block_of = {id(b): block for block in blocks for b in block.boxes}
    arrange(free + blocks, [(block_of.get(id(c[0]), c[0]), c[1], block_of.get(id(c[2]), c[2]), *c[3:])
                          for c in cords if id(c[0]) not in block_of or id(c[2]) not in block_of], top)
    for block in blocks:
        block.settle()
