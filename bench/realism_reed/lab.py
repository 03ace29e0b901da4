"""Plays greed~'s core and STK through the small programs beside this file."""

import subprocess
import tempfile
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np


@dataclass
class Request:
    preset: str
    pressure: float
    bore: float
    reed: float = 0.0
    rate: int = 48000
    seconds: float = 1.6
    options: dict = field(default_factory=dict)


@dataclass
class Played:
    sound: np.ndarray
    bore_pressure: np.ndarray
    flow: np.ndarray


def play(program: Path, requests: list[Request]) -> list[Played]:
    with tempfile.TemporaryDirectory() as folder:
        lines = []
        for i, r in enumerate(requests):
            options = " ".join(f"{name} {value!r}" for name, value in r.options.items())
            lines.append(f"{folder}/{i} {r.preset} {r.rate} {r.seconds} {r.pressure!r} {r.reed!r} "
                         f"{r.bore!r} {options}")
        subprocess.run([program], input="\n".join(lines), text=True, check=True)
        return [Played(*np.fromfile(f"{folder}/{i}").reshape(3, -1)) for i in range(len(requests))]


def play_stk(program: Path, name: str, frequency: float, breath: float, rate: int = 48000,
             seconds: float = 1.6) -> np.ndarray:
    with tempfile.TemporaryDirectory() as folder:
        subprocess.run([program], input=f"{folder}/0 {name} {rate} {seconds} {breath} {frequency}",
                       text=True, check=True)
        return np.fromfile(f"{folder}/0")
