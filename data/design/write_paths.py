#!/usr/bin/python3
"""Writes cantilever_path.txt and lift_arm_path.txt: where a hand that reshapes a part wants to be.

Rows ms x y z, mm from where the control point was taken, x right, y up. The hand goes from corner to
corner with the least jerk (Flash & Hogan 1985): s(u) = 10 u^3 - 15 u^4 + 6 u^5, and rests between. It
aims as a person does, 0.2 mm scatter (our choice, seed 7). No person was recorded.
"""
import pathlib

import numpy

STEP_MS = 4
# where to (mm), in how many ms, and how long it rests there
PATHS = {"cantilever": [((0, 3), 900, 500), ((0, -3), 1400, 500), ((0, 5), 1600, 700),
                        ((0, 2), 700, 300), ((0, 0), 900, 500)],
         "lift_arm": [((0, 12), 1200, 500), ((8, 4), 900, 400), ((-8, -8), 1600, 500),
                      ((0, 14), 1500, 800), ((0, 0), 1200, 400)]}


def minimum_jerk(begin, end, ms):
    u = numpy.arange(0, ms, STEP_MS)[:, None] / ms
    return begin + (end - begin) * (10 * u ** 3 - 15 * u ** 4 + 6 * u ** 5)


def main():
    for name, corners in PATHS.items():
        draw = numpy.random.default_rng(7)
        here = numpy.zeros(2)
        path = [numpy.repeat(here[None], 200 // STEP_MS, axis=0)]
        for corner, ms, rest_ms in corners:
            aim = numpy.array(corner) + draw.normal(0, 0.2, 2)
            path += [minimum_jerk(here, aim, ms), numpy.repeat(aim[None], rest_ms // STEP_MS, axis=0)]
            here = aim
        text = "# ms x y z by write_paths.py in mm\n" + "".join(
            f"{STEP_MS * i} {x:.3f} {y:.3f} 0\n" for i, (x, y) in enumerate(numpy.concatenate(path)))
        (pathlib.Path(__file__).parent / f"{name}_path.txt").write_text(text)


if __name__ == "__main__":
    main()
