"""Recorded footsteps that two of Debian's games bring: minetest-data and ardentryst.

They are read where they are installed, or where fetch() has unpacked them, and never copied. Who made them, and their licences:
minetest_game's README (dirt, grass, gravel, wood: Mito551, CC BY-SA 3.0; metal: mypantsfelldown,
CC0; water: AGFX, CC BY 3.0; snow: Ryding, CC0; hard: Erdie, CC BY 3.0; sand: worthahep88, CC0; ice:
InspectorJ, CC BY 3.0) and ardentryst's (CC BY-SA 3.0). Ice stands for frozen snow, "hard" for concrete.
"""
import os
import subprocess
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import soundfile

from features import to_rate

PACKAGES = ("minetest-data", "ardentryst")
ROOT = Path(os.environ.get("TACTUS_RECORDINGS", "/"))
MINETEST = "usr/share/games/minetest/games/minetest_game/mods/default/sounds"
ARDENTRYST = "usr/share/games/ardentryst/Sounds/NYX"
LABELS = {"dirt": "dirt", "grass": "highgrass", "gravel": "gravel", "hard": "concrete",
          "ice": "frozensnow", "metal": "metal", "sand": "sand", "snow": "snow", "water": "water",
          "wood": "wood"}


@dataclass
class Recording:
    source: str
    label: str
    path: Path

    def sound(self) -> np.ndarray:
        samples, rate = soundfile.read(self.path)
        return to_rate(samples, rate)


def fetch(folder):
    """Unpacks the two packages there, by Debian's own tools, without installing them."""
    folder = Path(folder).resolve()
    folder.mkdir(parents=True, exist_ok=True)
    if not (folder / MINETEST).is_dir() or not (folder / ARDENTRYST).is_dir():
        subprocess.run(["apt-get", "download", *PACKAGES], cwd=folder, check=True)
        for package in folder.glob("*.deb"):
            subprocess.run(["dpkg", "-x", package, folder], check=True)
            package.unlink()
    return folder


def recordings(root=None):
    root = Path(root) if root else ROOT
    found = [Recording("minetest", label, path) for name, label in LABELS.items()
             for path in sorted((root / MINETEST).glob(f"default_{name}_footstep*.ogg"))]
    found += [Recording("ardentryst", "highgrass" if name == "GRASS" else name.lower(), path)
              for name in ("CONCRETE", "DIRT", "GRASS", "SNOW")
              for path in sorted((root / ARDENTRYST).glob(f"NYX_STEP_{name}[1-4].ogg"))]
    return found
