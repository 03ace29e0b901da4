"""Where a cord runs and what it crosses, for the checker and for the untangling of layouts."""

STEPS = 20
INSET = 2.5  # a cord that only touches a box's edge does not cross it


def port_x(rectangle, index, count):
    x, _, w, _ = rectangle
    if w <= 22:
        return x + w / 2
    return x + 9 + (index * (w - 18) / (count - 1) if count > 1 else 0)


def curve(start, end):
    """Points of a cord: a cubic that leaves downwards and arrives from above."""
    (x0, y0), (x1, y1) = start, end
    bend = min(abs(y1 - y0) * 0.5 + abs(x1 - x0) * 0.1, 60)
    points = []
    for i in range(STEPS + 1):
        t = i / STEPS
        a, b, c, d = (1 - t) ** 3, 3 * t * (1 - t) ** 2, 3 * t * t * (1 - t), t ** 3
        points.append((a * x0 + b * x0 + c * x1 + d * x1,
                       a * y0 + b * (y0 + bend) + c * (y1 - bend) + d * y1))
    return points


def crosses(points, rectangle):
    """Whether the cord runs through the inside of a rectangle."""
    x, y, w, h = rectangle
    left, right, top, bottom = x + INSET, x + w - INSET, y + INSET, y + h - INSET
    xs, ys = [p[0] for p in points], [p[1] for p in points]
    if max(xs) < left or min(xs) > right or max(ys) < top or min(ys) > bottom:
        return False
    for (x0, y0), (x1, y1) in zip(points, points[1:]):
        for k in range(4):
            px, py = x0 + (x1 - x0) * k / 4, y0 + (y1 - y0) * k / 4
            if left < px < right and top < py < bottom:
                return True
    return False


def overlap(a, b, gap=0.0):
    """Whether two rectangles share more than an edge."""
    return (a[0] < b[0] + b[2] + gap and b[0] < a[0] + a[2] + gap
            and a[1] < b[1] + b[3] + gap and b[1] < a[1] + a[3] + gap)


def contains(outer, inner):
    return (outer[0] <= inner[0] and outer[1] <= inner[1] and outer[0] + outer[2] >= inner[0] + inner[2]
            and outer[1] + outer[3] >= inner[1] + inner[3])
