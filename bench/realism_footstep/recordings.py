"""Recorded footsteps that two of Debian's games bring: minetest-data and ardentryst.

They are read where they are installed and never copied. Who made them, and their licences:
minetest_game's README (dirt, grass, gravel, wood: Mito551, CC BY-SA 3.0; metal: mypantsfelldown,
CC0; water: AGFX, CC BY 3.0; snow: Ryding, CC0; hard: Erdie, CC BY 3.0; sand: worthahep88, CC0; ice:
InspectorJ, CC BY 3.0) and ardentryst's (CC BY-SA 3.0). Ice stands for frozen snow, "hard" for concrete.
"""
import os
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


def recordings():
    found = [Recording("minetest", label, path) for name, label in LABELS.items()
             for path in sorted((ROOT / MINETEST).glob(f"default_{name}_footstep*.ogg"))]
    found += [Recording("ardentryst", "highgrass" if name == "GRASS" else name.lower(), path)
              for name in ("CONCRETE", "DIRT", "GRASS", "SNOW")
              for path in sorted((ROOT / ARDENTRYST).glob(f"NYX_STEP_{name}[1-4].ogg"))]
    return found
