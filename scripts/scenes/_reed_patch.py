"""The tune of ./play reed, performed through patches/reed/reed_haptic.pd in headless Pd."""
import functools
import pathlib
import tempfile

from harness import Patch

import gesture as gestures
import practice
import score

ROOT = pathlib.Path(__file__).resolve().parents[2]
PATCH = ROOT / "patches" / "reed" / "reed_haptic.pd"
TUNE = ROOT / "data" / "music" / "mozart_k622_adagio.mid"
OCTAVE_DOWN = -12
PRESET = "clarinet"
SIGMA = (0, 5000, 1000, 3500)   # Pa, Pa, Hz, Hz: smallest range of the hand's box
NOISE = 0.02                    # noise of the breath, for a little air in the tone
RATE = 48000
SIGNALS = ("reed-y", "reed-z", "reed-fp", "reed-gradient-y", "reed-gradient-z", "reed-force-y",
           "reed-force-z")


@functools.cache
def learn():
    """(notes, technique, gain of [greed~]) for the tune."""
    notes = score.read(TUNE, OCTAVE_DOWN)
    pressure, lip, level_db, gain = practice.learn_reed(PRESET, {n.pitch for n in notes},
                                                        score.frequency)
    return notes, gestures.Technique(pressure, lip, level_db, dynamic_range=2.1), gain


def gesture(seconds=None, seed=1):
    """The performance of the tune, or of its phrases that begin within this many seconds."""
    notes, technique, _ = learn()
    if seconds is not None:
        kept = [p for p in gestures.phrases(notes) if p[0].onset < seconds]
        notes = [n for p in kept for n in p]
    return gestures.play(notes, technique, seed)


def render(played, hand="rigid", timeout=600):
    """The patch played by a simulated hand on the gesture's path. Returns harness.Render with
    "sound", as [greed~] gives it, and the SIGNALS, all as arrays at the sample rate."""
    sigma = gestures.fitting_sigma(played, SIGMA)
    y, z = gestures.positions(played, sigma)
    with tempfile.TemporaryDirectory(prefix="tactus-") as folder:
        path = pathlib.Path(folder) / "hand.txt"
        gestures.write_path(path, y, z)
        patch = Patch(opens=PATCH)
        for setting in (f"preset {PRESET}", f"gain {learn()[2]}", f"noise {NOISE}", "tune 1"):
            patch.send(0, "reed-all", setting)
        patch.send(0, "reed-range", list(sigma))
        patch.send(0, "reed-volume", 1)
        patch.send(0, "reed-note", played.events[0][1])
        patch.send(0, "reed-hand", f"hand {hand}, path {path}")
        for seconds, pitch in played.events:
            patch.send(1000 * seconds, "reed-note", pitch)
        patch.record("sound", patch.dac(1))
        for name in SIGNALS:
            patch.record(name, patch.obj("r", name) >> patch.obj("sig~"))
        return patch.render(played.seconds, RATE, timeout=timeout)
