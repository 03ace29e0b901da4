"""Moves boxes a little so that cords do not run through other boxes.

A greedy search: for each cord that crosses a box, it tries to move the box, or an end of the cord, to the
side or down, and keeps the move that leaves the fewest crossings and overlaps. The same input gives the
same result.
"""
import geometry

MOVES = [(dx, dy) for distance in (10, 20, 35, 50, 75, 100, 130, 170, 220, 280, 350) for dx, dy in
         ((distance, 0), (-distance, 0))] + [
    (dx, dy) for dy in (-24, -12, 12, 24, 45) for dx in (0, 14, -14, 40, -40, 80, -80)] + [
    (dx, dy) for dy in (70, 100, 140) for dx in (0, 60, -60, 150, -150)]
ROUNDS = 60
COST_OF_MOVE = 0.004  # crossings that a pixel of movement is worth


class Scene:
    """The shown boxes and cords, and what is wrong with them."""

    def __init__(self, patcher, fixed, areas):
        self.boxes = [b for b in patcher.boxes if not b.hidden and not b.extra.get("background")]
        self.cords = [c for c in patcher.cords if not c[4] and c[0] in self.boxes and c[2] in self.boxes]
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
            if cord[0] is box and cord[2].y < box.bottom + 8 and cord[2].y > box.y - 60 or \
                    cord[2] is box and cord[0].bottom + 8 > box.y:
                return False
        for panel, inside in self.areas:
            if id(box) in inside:
                if not geometry.contains(panel, rectangle):
                    return False
            elif geometry.overlap(panel, rectangle, 3):
                return False
        return not any(other is not box and geometry.overlap(self.rectangle(other), rectangle, 4)
                       for other in self.boxes)


def best_move(scene, box):
    """(improvement, dx, dy) of the best allowed move of one box."""
    before, x, y = scene.trouble(box), box.x, box.y
    best = (0, 0, 0)
    for dx, dy in MOVES:
        box.x, box.y = x + dx, y + dy
        if scene.allowed(box):
            gain = before - scene.trouble(box) - COST_OF_MOVE * (abs(dx) + 2 * abs(dy))
            if gain > best[0]:
                best = (gain, dx, dy)
    box.x, box.y = x, y
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
    """Where a cord still runs through a box above its end, everything from that end on moves down."""
    for _ in range(ROUNDS):
        found = scene.crossings(scene.cords, scene.boxes)
        for cord, box in found:
            if box.bottom <= cord[2].y + 1 and shift_helps(scene, patcher, panels, cord[2].y, len(found)):
                break
        else:
            return


def shift_helps(scene, patcher, panels, y, before):
    """Moves all from y on down by what helps most, if it helps."""
    moved = [b for b in patcher.boxes if b.y >= y - 1 and b not in panels]
    results = []
    for distance in (10, 20, 34):
        for box in moved:
            box.y += distance
        results.append((len(scene.crossings(scene.cords, scene.boxes)), distance))
        for box in moved:
            box.y -= distance
    crossings, distance = min(results)
    if crossings >= before:
        return False
    for box in moved:
        box.y += distance
    for panel in panels:
        if panel.y >= y - 1:
            panel.y += distance
        elif panel.bottom > y:
            panel.height += distance
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
        candidates[i].x += dx
        candidates[i].y += dy
