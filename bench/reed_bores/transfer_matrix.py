"""Reflectance and radiation of what lies beyond the end of the line, by transfer matrices.

Plane waves in short cylinders with viscous and thermal losses (thin boundary layer), or in a cone's
slices as many short cylinders; side holes as T-sections (Keefe 1982, 1990; lengths of Dubos et al.
1999 and Nederveen et al. 1998); openings as unflanged pipes (Silva et al. 2009). Each opening is a
source of the power that it sends out; sources interfere, averaged over all directions, as
sin(kd)/(kd)."""

import numpy as np

from bores import DENSITY, GAMMA, PRANDTL, SOUND_SPEED, VISCOSITY, Beyond

SLICE = 2e-3  # m, of a cone


def line(s, radius, length):
    """Matrix from (p, U) at the end to (p, U) at the beginning of a lossy cylinder."""
    area = np.pi * radius**2
    root = np.sqrt(s)
    series = s * DENSITY / area * (1 + 2 * np.sqrt(VISCOSITY) / (radius * root))
    shunt = s * area / (DENSITY * SOUND_SPEED**2) * (
        1 + 2 * (GAMMA - 1) * np.sqrt(VISCOSITY / PRANDTL) / (radius * root))
    gamma, z = np.sqrt(series * shunt), np.sqrt(series / shunt)
    ch, sh = np.cosh(gamma * length), np.sinh(gamma * length)
    return ch, z * sh, sh / z, ch


def opening(s, radius):
    """Impedance of an unflanged open end."""
    j = s * radius / SOUND_SPEED
    reflection = -(1 + 0.167 * j) / (1 + 1.393 * j + 0.457 * j * j)
    return DENSITY * SOUND_SPEED / (np.pi * radius**2) * (1 + reflection) / (1 - reflection)


def hole_lengths(hole, bore_radius):
    """Inner correction of the chimney and series length of an open hole."""
    b = hole.radius
    d = b / bore_radius
    inner = b * (0.82 - 0.193 * d - 1.09 * d**2 + 1.27 * d**3 - 0.71 * d**4)
    matching = b * d / 8 * (1 + 0.207 * d**3)
    series = -b * d**2 / (1.78 / np.tanh(1.84 * hole.height / b) + 0.940 + 0.540 * d + 0.285 * d**2)
    return hole.height + inner + matching, series


def bore_radius_at(beyond: Beyond, distance):
    corners = np.array(beyond.corners)
    return float(np.interp(distance, corners[:, 0], corners[:, 1]))


def respond(beyond: Beyond, frequency):
    """(R, T): reflected wave, and pressure at 1 m as the root of its mean square over directions,
    for an arriving wave of 1 Pa at the plane. With an apex both waves are spherical there."""
    s = 2j * np.pi * np.asarray(frequency, float)
    end, radius = beyond.corners[-1]
    # From the far end back to the plane, kept for the way out.
    parts = []
    positions = {0.0, end} | {d for d, _ in beyond.corners if 0 < d < end}
    positions |= {h.distance for h in beyond.holes if 0 <= h.distance < end}
    positions = sorted(positions)
    for left, right in zip(positions[:-1], positions[1:]):
        for hole in beyond.holes:
            if hole.distance == left:
                parts.append(hole)
        wide = (bore_radius_at(beyond, left), bore_radius_at(beyond, right))
        count = 1 if abs(wide[0] - wide[1]) < 1e-9 else max(1, int(np.ceil((right - left) / SLICE)))
        for i in range(count):
            at = (i + 0.5) / count
            parts.append((wide[0] + at * (wide[1] - wide[0]), (right - left) / count))

    p, u = opening(s, radius), np.ones_like(s)
    flows = [(end, u, opening(s, radius))]  # per unit flow at the end
    for part in reversed(parts):
        if isinstance(part, tuple):
            a, b, c, d = line(s, *part)
            p, u = a * p + b * u, c * p + d * u
            continue
        bore = bore_radius_at(beyond, part.distance)
        height, series = hole_lengths(part, bore)
        extra = s * DENSITY * series / (np.pi * bore**2) / 2
        p = p + extra * u
        outside = opening(s, part.radius)
        a, b, c, d = line(s, part.radius, height)
        out = p / (a * outside + b)
        flows.append((part.distance, out, outside))
        u = u + (c * outside + d) * out
        p = p + extra * u
    radius = bore_radius_at(beyond, 0.0)
    unit = np.pi * radius**2 / (DENSITY * SOUND_SPEED)
    bend = SOUND_SPEED / (s * beyond.apex) if beyond.apex > 0 else 0 * s
    admittance = u / p / unit
    reflected = (1 + bend - admittance) / (admittance + 1 - bend)
    pressure = 1 + reflected  # at the plane, for a wave of 1
    # Each source's size: the root of its power, so that a wide opening sends out all it gets.
    k = np.abs(s) / SOUND_SPEED
    total = 0.0
    sized = []
    for position, flow, load in flows:
        size = np.sqrt(np.maximum(load.real, 0) * DENSITY * SOUND_SPEED / (4 * np.pi))
        sized.append((position, flow / p * pressure * size))
    for i, (x, one) in enumerate(sized):
        for y, other in sized[i:]:
            share = np.sinc(k * abs(x - y) / np.pi) * (1 if x == y else 2)
            total = total + share * (one * np.conj(other)).real
    return reflected, np.sqrt(np.maximum(total, 0))
