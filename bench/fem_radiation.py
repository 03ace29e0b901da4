#!/usr/bin/python3
"""The free disk's sound by another way: boundary elements of a body of revolution.

    bench/fem_radiation.py BUILD [RINGS ...]

Prints |p| in Pa for 1 m/s at the antinode, at the places of tests/fem/radiation_test.cpp, for each
number of rings on a face (16 32 64). Nothing is shared with fem/radiation but the mode's velocities:
the equation is the direct one,

    p(x)/2 = ∫ p dG/dn dS + j omega rho ∫ G v_n dS      G = exp(-jkR)/(4 pi R)

for the harmonic cos(n theta), with constant elements on the generating line graded to the rim, rings
integrated with theta = d sinh(u), which takes out their nearness, and five points inside where the
field must vanish (Schenck 1968) against the resonances within.
"""
import subprocess
import sys
import tempfile
from pathlib import Path

import numpy
from scipy.interpolate import CubicSpline

DENSITY, SPEED, RADIUS, HALF = 1.184, 346.1, 0.05, 0.006
OUTER = numpy.polynomial.legendre.leggauss(6)
CLOSE = numpy.polynomial.legendre.leggauss(16)
AROUND = numpy.polynomial.legendre.leggauss(48)
# mode of the table, its nodal diameters, places (r, z) in m
CASES = ((0, 2, ((.03, .026), (.354, .354), (.5, .02))), (2, 0, ((1e-9, .5), (.354, .354))),
         (3, 3, ((.03, .026), (.354, .354), (.5, .02))))


def ring_integrals(x, y, normal, n, k):
    """∫ G cos(n t) r dt and ∫ dG/dn cos(n t) r dt over the ring through each y, seen from each x."""
    r, z = x[:, None, 0], x[:, None, 1]
    ring, height = y[None, :, 0], y[None, :, 1]
    gap = numpy.hypot(r - ring, z - height)
    scale = gap / numpy.sqrt(numpy.maximum(r * ring, 1e-30))
    end = numpy.arcsinh(numpy.pi / scale)
    single = numpy.zeros(gap.shape, complex)
    double = numpy.zeros(gap.shape, complex)
    for at, weight in zip(*AROUND):
        u = end * (at + 1) / 2
        angle = numpy.minimum(scale * numpy.sinh(u), numpy.pi)
        step = scale * numpy.cosh(u) * end / 2 * weight * 2 * ring
        far = numpy.sqrt(gap ** 2 + 4 * r * ring * numpy.sin(angle / 2) ** 2)
        green = numpy.exp(-1j * k * far) / (4 * numpy.pi * far) * numpy.cos(n * angle) * step
        along = (ring - r * numpy.cos(angle)) * normal[None, :, 0] + (height - z) * normal[None, :, 1]
        single += green
        double -= (1j * k + 1 / far) * green * along / far
    return single, double


class Body:
    """The disk's generating line in elements, with a velocity that turns its sign from face to face."""

    def __init__(self, rings, face, rim):
        t = numpy.linspace(0, 1, rings + 1)
        radius = RADIUS * (1 - (1 - t) ** 2.5)
        s = numpy.linspace(0, 1, max(rings // 3, 8) + 1)
        height = HALF - 2 * HALF * numpy.where(s < .5, .5 * (2 * s) ** 2.5, 1 - .5 * (2 - 2 * s) ** 2.5)
        line = numpy.concatenate([numpy.stack([radius, numpy.full_like(radius, HALF)], 1),
                                  numpy.stack([numpy.full_like(height, RADIUS), height], 1)[1:],
                                  numpy.stack([radius, numpy.full_like(radius, -HALF)], 1)[-2::-1]])
        self.first, self.step = line[:-1], line[1:] - line[:-1]
        self.size = numpy.hypot(*self.step.T)
        self.normal = numpy.stack([-self.step[:, 1], self.step[:, 0]], 1) / self.size[:, None]
        self.middle = self.first + self.step / 2
        self.face, self.rim = face, rim

    def velocity(self, position, element):
        up = self.normal[element, 1]
        return numpy.where(abs(up) > .5, up * self.face(position[:, 0]), self.rim(position[:, 1]))

    def rows(self, x, n, k, on_skin):
        """Single layer of the velocity, and double layer of each element, seen from x."""
        elements, points = len(self.size), len(OUTER[0])
        which = numpy.tile(numpy.arange(elements), points)
        share = numpy.repeat((1 + OUTER[0]) / 2, elements)
        y = self.first[which] + share[:, None] * self.step[which]
        single, double = ring_integrals(x, y, self.normal[which], n, k)
        weight = numpy.repeat(OUTER[1] / 2, elements) * self.size[which]
        single = (single * weight * self.velocity(y, which)).reshape(len(x), points, elements).sum(1)
        double = (double * weight).reshape(len(x), points, elements).sum(1)
        for i in range(len(x)) if on_skin else ():
            gap = numpy.hypot(*(self.middle - x[i]).T)
            for j in numpy.flatnonzero(gap < 3 * (self.size + self.size[i])):
                nearest = numpy.clip((x[i] - self.first[j]) @ self.step[j] / self.size[j] ** 2, 0, 1)
                t = (CLOSE[0] + 1) / 2  # points gather where the ring passes closest
                at = numpy.concatenate([nearest + (end - nearest) * t ** 4 for end in (0, 1)])
                part = numpy.concatenate([abs(end - nearest) * 2 * t ** 3 * CLOSE[1] for end in (0, 1)])
                y, own = self.first[j] + at[:, None] * self.step[j], numpy.full(len(at), j)
                g, d = ring_integrals(x[i:i + 1], y, self.normal[own], n, k)
                single[i, j] = (g[0] * part * self.velocity(y, own)).sum() * self.size[j]
                double[i, j] = (d[0] * part).sum() * self.size[j]
        return single.sum(1), double

    def pressure(self, points, n, k):
        drive = 1j * k * SPEED * DENSITY
        single, double = self.rows(self.middle, n, k, True)
        inside = numpy.array([[.61, .13], [.37, -.29], [.83, .41], [.5, .02], [.7, -.5]]) * [RADIUS, HALF]
        inner_single, inner_double = self.rows(inside, n, k, False)
        matrix = numpy.vstack([numpy.eye(len(self.size)) / 2 - double, -inner_double])
        skin = numpy.linalg.lstsq(matrix, drive * numpy.concatenate([single, inner_single]), rcond=None)[0]
        single, double = self.rows(numpy.array(points), n, k, False)
        return double @ skin + drive * single


def main(build, *rings):
    with tempfile.TemporaryDirectory() as folder:
        table = Path(folder) / "disk.modal.npz"
        subprocess.run([Path(build) / "programs/modal_fem/modal_fem", "disk", "--diameter", "100", "--thickness", "12",
                        "--material", "aluminium", "--h", "4", "--modes", "7", "--quiet", "-o", table], check=True,
                       stdout=subprocess.DEVNULL)
        table = numpy.load(table)
    position, shapes = table["xyz"].astype(float), table["phi"].astype(float)
    on_ray = (abs(position[:, 1]) < 1e-6) & (position[:, 0] > -1e-9)
    top, rim = abs(position[:, 2] - HALF) < 1e-7, abs(position[:, 0] - RADIUS) < 1e-6
    for mode, diameters, points in CASES:
        shape, hertz = shapes[mode], table["freq"][mode]
        shape = shape / abs(shape[top, 2]).max()
        face = CubicSpline(*numpy.array(sorted(zip(position[on_ray & top, 0], shape[on_ray & top, 2]))).T)
        side = CubicSpline(*numpy.array(sorted(zip(position[on_ray & rim, 2], shape[on_ray & rim, 0]))).T)
        for count in map(int, rings or (16, 32, 64)):
            p = abs(Body(count, face, side).pressure(points, diameters, 2 * numpy.pi * hertz / SPEED))
            print(f"{hertz:9.2f} Hz, {count:3d} rings: " + ", ".join(
                f"({1e3 * r:.0f}, 0, {1e3 * z:.0f}) {level:.4g}" for (r, z), level in zip(points, p)), flush=True)


if __name__ == "__main__":
    if len(sys.argv) < 2:
        sys.exit(__doc__)
    main(*sys.argv[1:])
