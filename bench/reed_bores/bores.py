"""Bores of the woodwinds: what lies beyond the tube that [greed~] computes as a line.

Lengths in metres. A woodwind has one tone hole a semitone, as the clarinet of Noreland et al. (2013);
the note's first open hole is where the line ends. Hole sizes follow from one figure, the lattice's
cut-off frequency, which is nearly the same all along a clarinet whatever its holes look like (Moers &
Kergomard 2011). Benade's formula (Fundamentals of Musical Acoustics, 1976, chapter 21) gives the
radius b of a hole in a bore of radius a:

    f_c = 0.11 c (b/a) sqrt(1/(s t_e)),    t_e = t + 1.5 b,

s being half the distance to the next hole and t the height of the chimney. Cut-offs: clarinet 1500 Hz,
oboe 1500 Hz (Benade), tenor saxophone 800 Hz (an alto has 850 to 1000 Hz, a tenor is a fourth
lower)."""

from dataclasses import dataclass, field

import numpy as np

SOUND_SPEED = 331.45 * np.sqrt(1 + 20 / 273.15)
DENSITY = 1.2929 * 273.15 / 293.15
VISCOSITY, PRANDTL, GAMMA = 1.51e-5, 0.71, 1.402  # as core/reed/bore/air.hpp


def key_frequency(key: float) -> float:
    return 440.0 * 2 ** ((key - 69) / 12)


@dataclass
class Hole:
    distance: float  # from the plane where the line ends
    radius: float
    height: float


@dataclass
class Beyond:
    """Bore beyond the end of the line: (distance, radius) corners joined by straight walls, holes on
    it, an unflanged opening at its end. `apex` > 0: the line is a cone whose apex lies so far
    before the plane."""
    corners: list[tuple[float, float]]
    holes: list[Hole] = field(default_factory=list)
    apex: float = 0.0


@dataclass
class Woodwind:
    keys: range            # first: all holes closed
    input_radius: float
    apex: float            # from the apex to the reed's end; 0: cylinder
    cutoff: float          # of the lattice, Hz; at its lowest hole where it rises
    chimney: float
    bell: list[tuple[float, float]]  # (distance from the last hole, radius over the bore's)
    cutoff_rise: float = 0.0  # power of the note by which the cut-off rises up the bore,
    cutoff_top: int = 127     # up to this key's hole
    vent: Hole | None = None  # the register vent, from the reed's end

    def acoustic_length(self, key: float) -> float:
        """Of the tube from the reed's end (of a cone: from its apex) for a note."""
        return SOUND_SPEED / ((2 if self.apex > 0 else 4) * key_frequency(key))

    def position(self, key: float) -> float:
        """Where the note's first open hole is: an end correction of 2 cm before that."""
        return self.acoustic_length(key) - 0.02

    def radius(self, position: float) -> float:
        """Of the bore at a position."""
        return self.input_radius * (position / self.apex if self.apex > 0 else 1)

    def cutoff_at(self, key: int) -> float:
        """Of the lattice about the hole that a note opens first."""
        octaves = (min(max(key, self.keys[0]), self.cutoff_top) - self.keys[0]) / 12
        return self.cutoff * 2 ** (self.cutoff_rise * octaves)

    def hole(self, key: int) -> tuple[float, float]:
        """Position and radius of the hole that the note opens first."""
        position = self.position(key)
        spacing = self.position(key - 1) - position
        bore = self.radius(position)
        ratio = 0.5
        for _ in range(50):
            thickness = self.chimney + 1.5 * ratio * bore
            ratio = self.cutoff_at(key) / (0.11 * SOUND_SPEED) * np.sqrt(spacing / 2 * thickness)
        return position, min(ratio, 0.9) * bore

    def beyond(self, key: int) -> Beyond:
        """What a note's wave meets where its first open hole is; the lowest note's meets the bell."""
        lowest = self.keys[0]
        start, end = self.position(max(key, lowest)), self.position(lowest)
        corners = [(0.0, self.radius(start))]
        for distance, ratio in self.bell:
            position = end + distance
            corners.append((position - start, self.radius(end) * ratio))
        if corners[1][0] <= 0:
            corners.pop(0)
        holes = [Hole(position - start, radius, self.chimney)
                 for position, radius in (self.hole(k) for k in range(key, lowest, -1))]
        return Beyond(corners, holes, start if self.apex > 0 else 0.0)

    def fingered(self, closed: list[float]) -> tuple[int, Beyond]:
        """Key and bore beyond the first open hole for any state of the holes, from the reed down: 1
        closed (pad or finger fill the chimney), 0 open, in between the share of its area covered."""
        keys = range(self.keys[-1], self.keys[0], -1)
        share = {k: 1 - c for k, c in zip(keys, closed, strict=True)}
        key = next((k for k in keys if share[k] > 0), self.keys[0])
        full = self.beyond(key)
        holes = [Hole(hole.distance, hole.radius * np.sqrt(share[k]), hole.height)
                 for k, hole in zip(range(key, self.keys[0], -1), full.holes) if share[k] > 0]
        return key, Beyond(full.corners, holes, full.apex)


WOODWINDS = {
    # Bore 15 mm; the lower joint opens before the bell, which ends 60 mm wide (Nederveen 1969).
    "clarinet": Woodwind(range(50, 71), 7.5e-3, 0.0, 1500.0, 8e-3,
                         [(0.0, 1.0), (0.02, 1.15), (0.06, 1.6), (0.10, 2.6), (0.125, 4.0)],
                         # The register tube: 3 mm wide (Nederveen 1969), some 12 mm long.
                         vent=Hole(0.11, 1.5e-3, 12e-3)),
    # The presets' cones, and bells that end where a real one's does: a tenor's 1.69 m from the cone's
    # apex (1.49 m from the mouthpiece's tip, Chen et al. 2009), 75 mm in radius. The oboe's cone is
    # twice as wide as a real one, and its bell flares less.
    "saxophone": Woodwind(range(44, 77), 6.2e-3, 0.2, 800.0, 4e-3,
                          [(0.0, 1.0), (0.06, 1.48)], 0.5, 59),
    "oboe": Woodwind(range(58, 89), 3e-3, 0.1, 1500.0, 5e-3,
                     [(0.0, 1.0), (0.04, 1.1), (0.08, 1.4)]),
}
