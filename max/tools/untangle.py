"""Moves boxes a little so that cords do not run through other boxes.

A greedy search: for each cord that crosses a box, it tries to move the box, or an end of the cord, to the
side or down, and keeps the move that leaves the fewest crossings and overlaps. The same input gives the
same result.
"""
import geometry
import layout

MOVES = [(dx, dy) for distance in (10, 20, 35, 50, 75, 100, 130, 170, 220, 280, 350) for dx, dy in
         ((distance, 0), (-distance, 0))] + [
    (dx, dy) for dy in (-24, -12, 12, 24, 45) for dx in (0, 14, -14, 40, -40, 80, -80)] + [
    (dx, dy) for dy in (70, 100, 140) for dx in (0, 60, -60, 150, -150)]
MOVES_OF_TEXT = [(dx, dy) for dx, dy in MOVES if abs(dx) <= 50 and abs(dy) <= 24]  # it says what is beside it
ROUNDS = 60
COST_OF_MOVE = 0.0015  # crossings that a pixel of movement is worth


class Scene:
    """The shown boxes and cords, and what is wrong with them."""

    def __init__(self, patcher, fixed, areas):
        self.boxes = [b for b in patcher.boxes if not b.hidden and not b.extra.get("background")]
        self.headings = [b for b in patcher.boxes if b.maxclass == "comment" and b.extra.get("background")]
        self.cords = [c for c in patcher.cords if not c[4] and c[0] in self.boxes and c[2] in self.boxes]
        self.loops = layout.loops([b for b in self.boxes if hasattr(b, "pd")], self.cords)
        self.fixed, self.areas = fixed, areas
        self.right = max((b.right for b in self.boxes), default=0)

    def rectangle(self, box):
        return box.x, box.y, box.width, box.height

    def points(self, cord):
        s, outlet, d, inlet, _ = cord
        start = (geometry.port_x(self.rectangle(s), outlet, len(s.outlets)), s.bottom)
        end = (geometry.port_x(self.rectangle(d), inlet, len(d.inlets)), d.y)
        return geometry.curve(start, end)

    def crossings(self, cords, boxes):
        found = []
        for cord in cords:
            points = self.points(cord)
            for box in boxes:
                if box is not cord[0] and box is not cord[2] and \
                        geometry.crosses(points, self.rectangle(box)):
                    found.append((cord, box))
        return found

    def trouble(self, box):
        """Crossings by the box's cords and through the box."""
        own = [c for c in self.cords if c[0] is box or c[2] is box]
        others = [c for c in self.cords if c[0] is not box and c[2] is not box]
        return len(self.crossings(own, self.boxes)) + len(self.crossings(others, [box]))

    def allowed(self, box):
        rectangle = self.rectangle(box)
        if box.x < 8 or box.y < 0 or box.right > self.right + 60:
            return False
        for cord in self.cords:
            if box in (cord[0], cord[2]) and (id(cord[0]), id(cord[2])) not in self.loops and \
                    cord[2].y < cord[0].bottom + 8:
                return False
        for panel, inside in self.areas:
            if id(box) in inside:
                if not geometry.contains(panel, rectangle):
                    return False
            elif geometry.overlap(panel, rectangle, 3):
                return False
        return not any(other is not box and geometry.overlap(self.rectangle(other), rectangle, 4)
                       for other in self.boxes + self.headings)


def best_move(scene, box):
    """(improvement, dx, dy) of the best allowed move of one box, with its labels."""
    group = [box] + [b for b in scene.boxes if getattr(b, "attached_to", None) is box]
    before, positions = sum(scene.trouble(b) for b in group), [(b, b.x, b.y) for b in group]
    best = (0, 0, 0)
    for dx, dy in MOVES_OF_TEXT if box.maxclass == "comment" else MOVES:
        cost = COST_OF_MOVE * (abs(dx) + 2 * abs(dy))
        if before - cost <= best[0]:
            continue
        for b, x, y in positions:
            b.x, b.y = x + dx, y + dy
        if all(scene.allowed(b) for b in group):
            gain = before - sum(scene.trouble(b) for b in group) - cost
            if gain > best[0]:
                best = (gain, dx, dy)
    for b, x, y in positions:
        b.x, b.y = x, y
    return best


def untangle(patcher, panels=(), fixed=()):
    """Moves the boxes of a placed patcher; panels grow with what stands on them."""
    areas = []
    for panel in panels:
        area = (panel.x, panel.y, panel.width, panel.height)
        inside = {id(b) for b in patcher.boxes
                  if b is not panel and geometry.contains(area, (b.x, b.y, b.width, b.height))}
        areas.append(((*area[:2], area[2] + room_right(patcher, panel, inside), area[3]), inside))
    scene = Scene(patcher, fixed, areas)
    search(scene, fixed)
    make_room(scene, patcher, panels)
    for panel, (_, inside) in zip(panels, areas):
        panel.width = max([panel.width] + [b.right + 8 - panel.x for b in patcher.boxes if id(b) in inside])


def room_right(patcher, panel, inside):
    """By how much a panel may grow to the right before it meets something."""
    beside = [b.x - panel.x - panel.width for b in patcher.boxes if id(b) not in inside and b is not panel
              and b.x >= panel.x + panel.width and b.y < panel.bottom + 8 and panel.y < b.bottom + 8]
    return max(0, min([90] + [room - 12 for room in beside]))


def make_room(scene, patcher, panels):
    """Where a cord still runs through a box, everything below or right of a line moves away."""
    for _ in range(ROUNDS):
        found = scene.crossings(scene.cords, scene.boxes)
        for cord, box in found:
            if box.bottom <= cord[2].y + 1 and shift_helps(scene, patcher, panels, "y", cord[2].y, len(found)):
                break
            lines = [end.x for end in (cord[0], cord[2]) if end.x > box.x] + [box.x]
            if any(shift_helps(scene, patcher, panels, "x", line, len(found)) for line in lines):
                break
            if both_shifts_help(scene, patcher, panels, cord, box, len(found)):
                break
        else:
            return


def both_shifts_help(scene, patcher, panels, cord, box, before):
    """A gap above or below the box in the way, and one beside it, together."""
    boxes = [b for b in patcher.boxes if hasattr(b, "pd")]
    saved = [(b, b.x, b.y, b.width, b.height) for b in boxes]
    for down in (20, 45, 80, 120):
        for y in (cord[2].y, box.y):
            for across in (0, 45, 90):
                for x in sorted({box.x, cord[0].x, cord[2].x}):
                    shift(boxes, panels, "y", y, down)
                    shift(boxes, panels, "x", x, across)
                    if len(scene.crossings(scene.cords, scene.boxes)) < before:
                        return True
                    for b, *rectangle in saved:
                        b.x, b.y, b.width, b.height = rectangle
    return False


def shift(boxes, panels, axis, line, distance):
    """Moves all from a line on; a panel that the line cuts grows."""
    size = "height" if axis == "y" else "width"
    for box in boxes:
        if getattr(box, axis) >= line - 1:
            setattr(box, axis, getattr(box, axis) + distance)
        elif box in panels and getattr(box, axis) + getattr(box, size) > line:
            setattr(box, size, getattr(box, size) + distance)


def shift_helps(scene, patcher, panels, axis, line, before):
    """Moves all from a line on by what helps most, if it helps."""
    boxes = [b for b in patcher.boxes if hasattr(b, "pd")]
    saved = [(b, b.x, b.y, b.width, b.height) for b in boxes]
    results = []
    for distance in (10, 20, 34, 60, 90) if axis == "y" else (20, 40, 70, 90, 120):
        shift(boxes, panels, axis, line, distance)
        results.append((len(scene.crossings(scene.cords, scene.boxes)), distance))
        for box, *rectangle in saved:
            box.x, box.y, box.width, box.height = rectangle
    crossings, distance = min(results)
    if crossings >= before:
        return False
    shift(boxes, panels, axis, line, distance)
    return True


def search(scene, fixed):
    for _ in range(ROUNDS):
        found = scene.crossings(scene.cords, scene.boxes)
        if not found:
            return
        candidates = []
        for cord, box in found:
            candidates += [b for b in (box, cord[0], cord[2]) if b not in candidates and b not in fixed]
        moves = [(best_move(scene, box), i) for i, box in enumerate(candidates)]
        (gain, dx, dy), i = max(moves, key=lambda m: (m[0][0], -m[1]))
        if gain <= 0:
            return
        for box in [candidates[i]] + [b for b in scene.boxes
                                      if getattr(b, "attached_to", None) is candidates[i]]:
            box.x, box.y = box.x + dx, box.y + dy
