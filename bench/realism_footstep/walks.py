"""Lets the object itself walk in Pd and cuts its sound into steps, as a listener's recorder would."""
import subprocess
import tempfile
from pathlib import Path

import numpy as np
from scipy.io import wavfile

from features import to_rate
from steps import RATE

NAMES = ("sound", "sound_2", "force", "force_2")
OUTLETS = (0, 4, 3, 7)
BEGIN_MS = 100


def patch_text(surface, flags, samples, rate):
    """[footstep~] walks, four of its outlets go to tables, those to one file."""
    lines = ["#N canvas 0 0 600 400 12;", f"#X obj 20 20 footstep~ {surface} {flags};"]
    cords = []

    def box(text, *sources):
        lines.append(f"#X {text};")
        for source, outlet in sources:
            cords.append(f"#X connect {source} {outlet} {len(lines) - 2} 0;")
        return len(lines) - 2

    load = box("obj 20 60 loadbang")
    order = box("obj 20 80 t b b b", (load, 0))
    box("msg 20 100 \\; pd dsp 1", (order, 2))
    start = box("obj 20 100 t b", (order, 1))
    for name, outlet in zip(NAMES, OUTLETS):
        box(f"obj 20 120 table {name} {samples}")
        box(f"obj 20 140 tabwrite~ {name}", (0, outlet), (start, 0))
    walk = box(f"obj 20 160 delay {BEGIN_MS}", (order, 0))
    box("msg 20 180 walk 1", (walk, 0))
    cords.append(f"#X connect {len(lines) - 2} 0 0 0;")
    end = box(f"obj 20 200 delay {1000 * samples / rate + 100:.6f}", (order, 0))
    done = box("obj 20 220 t b b", (end, 0))
    write = box(f"msg 20 240 write -wave -bytes 4 -rate {rate} out.wav {' '.join(NAMES)}", (done, 1))
    box("obj 20 260 soundfiler", (write, 0))
    box("msg 20 280 \\; pd quit", (done, 0))
    return "\n".join(lines + cords) + "\n"


def walk(library, surface, seconds, rate=RATE, flags=""):
    """Dictionary of NAMES: what [footstep~ surface flags] in the folder `library` gives in Pd."""
    samples = int(seconds * rate)
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder, "walk.pd")
        path.write_text(patch_text(surface, flags, samples, rate))
        subprocess.run(["pd", "-nogui", "-batch", "-nosound", "-noprefs", "-r", str(rate), "-path",
                        str(Path(library).resolve()), "-open", str(path)],
                       check=True, capture_output=True, timeout=600)
        _, sound = wavfile.read(Path(folder, "out.wav"))
    return dict(zip(NAMES, sound.T.astype(float)))


def contacts(force):
    """Samples at which a foot that was in the air meets the ground."""
    return np.flatnonzero((force[1:] > 0) & (force[:-1] == 0)) + 1


def onsets(sound, rate, apart_s):
    """Samples at which the envelope first passes a tenth of the median loudest, at least apart_s after
    the one before: what one does who has nothing but the sound."""
    width = int(0.005 * rate)
    level = np.sqrt(np.convolve(sound * sound, np.ones(width) / width, "same"))
    size = int(apart_s * rate)
    loudest = level[:len(level) // size * size].reshape(-1, size).max(axis=1)
    loud = np.flatnonzero(level > 0.1 * np.median(loudest[loudest > 0.1 * loudest.max()]))
    found = []
    for at in loud:
        if not found or at - found[-1] > size:
            found.append(at)
    return np.array(found, int)


def walked_steps(library, surface, count, speed=1.4, rate=RATE, feet=1, seed=1, by="contacts"):
    """(count) steps at 22.05 kHz. Each from 10 ms before its contact (50 ms before its onset) until the
    next begins; of two feet the outlets are added and every step of both is cut out."""
    seconds = (count + 3) * 1.6 / feet / min(max(speed, 0.6), 1.4) + 1
    got = walk(library, surface, seconds, rate, f"-feet {feet} -speed {speed} -seed {seed}")
    sound = got["sound"] + got["sound_2"]
    if by == "onsets":
        at, before = onsets(sound, rate, 0.7 / feet), int(0.05 * rate)
    else:
        at = np.sort(np.concatenate([contacts(got["force"]), contacts(got["force_2"])]))
        before = int(0.01 * rate)
    steps = [sound[max(0, a - before):b - before] for a, b in zip(at, at[1:])][:count]
    if len(steps) < count:
        raise RuntimeError(f"{surface}: {len(steps)} steps of {count} found in {seconds:.0f} s")
    return [to_rate(step, rate) for step in steps]
