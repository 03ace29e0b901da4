"""Moves boxes that were placed for Pd's font to where Max's larger boxes do not overlap.

Every box has a place in the Pd patch (`pd`: x, y, width, height). Rows of the same y stay rows, columns
of the same x stay columns; a row is only pushed as far down as the boxes above it need, so the picture
keeps its proportions where there is room.
"""
SCALE_X = 1.12
ROW = 5  # Pd pixels within which boxes belong to one row
GAP_X = 8


def gap_below(upper, lower, joined):
    if joined:
        return 13
    if upper.maxclass == "comment" and lower.maxclass == "comment":
        return 1
    if "comment" in (upper.maxclass, lower.maxclass):
        return 3
    return 7


def rows_of(boxes):
    rows = []
    for box in sorted(boxes, key=lambda b: (b.pd[1], b.pd[0])):
        if rows and box.pd[1] - rows[-1][0].pd[1] <= ROW and not any(
                overlap_in_x(box.pd, other.pd) for other in rows[-1]):
            rows[-1].append(box)
        else:
            rows.append([box])
    return rows


def overlap_in_x(a, b):
    return a[0] < b[0] + b[2] and b[0] < a[0] + a[2]


def place(boxes, cords, top):
    """Sets x and y of all boxes; top is where the first row may begin."""
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
        y = top if previous is None else previous[0] + max(0, row[0].pd[1] - previous[1])
        for box in row:
            for above in done:
                if above.x < box.right + 2 and box.x < above.right + 2:
                    y = max(y, above.bottom + gap_below(above, box, (id(above), id(box)) in joined))
                elif (id(above), id(box)) in joined:
                    y = max(y, above.bottom + 9)
        for box in row:
            box.y = round(y)
        middle = max(b.height for b in row if b.height <= 24) if any(b.height <= 24 for b in row) else 0
        for box in row:  # small things of one row share their middle line
            if box.height < middle:
                box.y += round((middle - box.height) / 2)
        done += row
        previous = (y, row[0].pd[1])


def surround(panel, boxes, margin=8):
    """A panel around what lay inside it in the Pd patch."""
    x, y, w, h = panel.pd
    inside = [b for b in boxes if b is not panel and not b.hidden
              and x - 2 <= b.pd[0] and b.pd[0] + 4 <= x + w and y - 2 <= b.pd[1] and b.pd[1] + 4 <= y + h]
    if not inside:
        return
    panel.x = min(b.x for b in inside) - margin
    panel.y = min(b.y for b in inside) - margin
    panel.width = max(b.right for b in inside) + margin - panel.x
    panel.height = max(b.bottom for b in inside) + margin - panel.y


def shift_right(boxes):
    """What a panel or a long text pushed beyond the left edge comes back."""
    least = min((b.x for b in boxes), default=0)
    if least < 8:
        for box in boxes:
            box.x += 8 - least
