"""Lets measure_reed play and measure many notes at once, on two cores."""

import os
import subprocess
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from recordings import key_frequency

RAMP_S = 0.02  # of the breath


@dataclass
class Request:
    """One note: breath as points (s, Pa), measured between two times."""
    preset: str
    key: float
    points: tuple
    window: tuple = (0.5, 1.2)
    swell: bool = False
    rate: int = 48000
    options: dict = field(default_factory=dict)

    def line(self) -> str:
        points = ",".join(f"{t:.4f}:{p:.2f}" for t, p in self.points)
        options = " ".join(f"{name} {value!r}" for name, value in self.options.items())
        return (f"{self.preset} {self.rate} {key_frequency(self.key)!r} {self.window[0]} "
                f"{self.window[1]} {int(self.swell)} {points} {options}")


@dataclass
class Heard:
    cents: float
    foreign_db: float
    foreign_hz: float
    first_db: float
    rms: float
    bore_rms: float
    centroid: float
    right: bool
    half_s: float
    tenth_s: float
    top: float
    swell_db: float
    swell_cents: float
    swell_wrong: int
    harmonics: np.ndarray


def hear(program: Path, requests: list[Request], workers: int = 2) -> list[Heard]:
    def run(part: list[Request]) -> list[str]:
        done = subprocess.run([program], input="\n".join(w.line() for w in part), text=True,
                              check=True, capture_output=True)
        return done.stdout.splitlines()

    parts = [requests[i::workers] for i in range(workers)]
    with ThreadPoolExecutor(workers) as pool:
        lines = list(pool.map(run, parts))
    heard = []
    for i, request in enumerate(requests):
        v = [float(x) for x in lines[i % workers][i // workers].split()]
        swell = v[11:14] if request.swell else (-300.0, 0.0, 0)
        heard.append(Heard(*v[:7], v[7] > 0.5, *v[8:11], *swell, np.array(v[-10:])))
    return heard


def held(preset: str, key: float, pressure: float, seconds: float = 1.2, **rest) -> Request:
    return Request(preset, key, ((0, 0), (RAMP_S, pressure), (seconds, pressure)), **rest)


def short(preset: str, key: float, pressure: float, seconds: float, **rest) -> Request:
    """Breath that rises over 20 ms and ends `seconds` after its beginning, over 10 ms."""
    return Request(preset, key, ((0, 0), (RAMP_S, pressure), (seconds - 0.01, pressure), (seconds, 0),
                              (0.5, 0)), (0.1, 0.5), **rest)


def swell(preset: str, key: float, soft: float, loud: float, **rest) -> Request:
    """From soft to loud in 2 s and back."""
    return Request(preset, key, ((0, 0), (RAMP_S, soft), (0.3, soft), (2.3, loud), (4.3, soft)),
                (2.0, 2.6), True, **rest)


def slow(preset: str, key: float, pressure: float, **rest) -> Request:
    """2 s from nothing to the pressure, which then stays."""
    return Request(preset, key, ((0, 0), (2, pressure), (4, pressure)), (3.2, 4), **rest)


def cores() -> int:
    return min(2, os.cpu_count() or 1)
