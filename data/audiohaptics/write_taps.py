#!/usr/bin/python3
"""Writes taps.txt: where a hand wants to be that taps a disk at several places and speeds.

Rows ms x y z, mm, x right, y up, z towards the user; the disk's face is z = 6. Each tap is an approach
from 40 mm, a stroke to 5 mm below the face and a lift, all with the least jerk (Flash & Hogan 1985):
s(u) = 10 u^3 - 15 u^4 + 6 u^5, whose largest speed is 1.875 times the mean. Aim and speed scatter as a
person's do: 1.5 mm and 8 % (our choice, seed 7). No person was recorded.
"""
import pathlib

import numpy

FACE, HIGH, DEEP = 6.0, 40.0, 1.0
# radius mm, angle degrees, largest speed of the stroke m/s
TAPS = [(25, 0, 0.5), (0, 0, 0.5), (46, 60, 0.5), (12, 180, 0.8), (38, 240, 0.3), (25, 120, 1.0),
        (44, 300, 0.8), (25, 0, 0.25), (5, 90, 1.2)]


def minimum_jerk(begin, end, ms):
    u = numpy.arange(0, ms, 4)[:, None] / ms
    return begin + (end - begin) * (10 * u ** 3 - 15 * u ** 4 + 6 * u ** 5)


def main():
    draw = numpy.random.default_rng(7)
    here, path = numpy.array([25.0, 0.0, HIGH]), []
    for radius, degrees, speed in TAPS:
        angle = numpy.radians(degrees)
        aim = radius * numpy.array([numpy.cos(angle), numpy.sin(angle)]) + draw.normal(0, 1.5, 2)
        speed *= draw.normal(1, 0.08)
        above, below = numpy.array([*aim, HIGH]), numpy.array([*aim, DEEP])
        stroke = 1.875 * (HIGH - DEEP) / speed  # ms, since mm/ms = m/s
        for end, ms in ((above, 260), (below, stroke), (below, 40), (above, 1.3 * stroke), (above, 120)):
            path.append(minimum_jerk(here, end, max(4, round(ms / 4) * 4)))
            here = end
    rows = numpy.concatenate([*path, here[None]])
    text = "# ms x y z by write_taps.py in mm\n" + "".join(
        f"{4 * i} {x:.3f} {y:.3f} {z:.3f}\n" for i, (x, y, z) in enumerate(rows))
    (pathlib.Path(__file__).parent / "taps.txt").write_text(text)


if __name__ == "__main__":
    main()
