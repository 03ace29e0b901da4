"""Boxes that stand better elsewhere in Max than in the Pd patch: {patch: {"text@x,y": (x, y)}}, in Pd's
pixels. In Pd a cord may run behind a box or upwards; here none does (check_patcher.py)."""

POSITIONS = {}


def move(canvas, positions):
    """Moves the boxes of a canvas and its subpatches; returns the keys that were found."""
    found = set()
    for box in canvas.boxes:
        key = f"{' '.join(box.plain_words())}@{box.x},{box.y}"
        if key in positions:
            found.add(key)
            box.x, box.y = positions[key]
        if box.canvas:
            found |= move(box.canvas, positions)
    return found
