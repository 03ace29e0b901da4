"""Renders of patches/audiohaptics/audiohaptics.pd: the bus's messages, the servo's force, the sound."""
import csv
import pathlib
import tempfile

import numpy
from harness import Patch, stage_folder

ROOT = pathlib.Path(__file__).resolve().parents[2]
PATCH = ROOT / "patches" / "audiohaptics" / "audiohaptics.pd"
RATE = 48000
TOPICS = ("hit", "contact", "release")
NEAR, FAR = "ah-near", "ah-far"  # receivers of the listener at the hand's speaker and in the chair


def taps_seconds():
    """Length of the staged hand's path in s."""
    return float((stage_folder() / "taps.txt").read_text().splitlines()[-1].split()[0]) / 1000


def render(listener, seconds, path="taps.txt", pair=False, begin_ms=100):
    """Dictionary: sound [samples, 2], ticks (columns of the servo's trace), hits [rows of numbers
    t x y z nx ny nz vn vt], bodies [their names]. The hand follows `path` from begin_ms on."""
    with tempfile.TemporaryDirectory(prefix="tactus-") as folder:
        patch = Patch(opens=PATCH, own="own")
        for channel in (1, 2):
            patch.record(str(channel), patch.dac(channel))
        patch.log("hit", patch.obj("ioa_bus", "own-bus", "hit") >> patch.obj("route hit"))
        patch.send(1, listener, "bang")
        if pair:
            patch.send(2, "ah-pair", "bang")
            patch.send(2, "ah-words", "choke 0.35")  # so that one disk is quiet before the other is struck
        patch.send(3, "ah.phantom", f"trace {folder}/ticks.csv")
        patch.send(begin_ms, "ah-hand", f"path {path}")
        patch.send(1000 * seconds - 5, "ah.phantom", "trace stop")
        result = patch.render(seconds, RATE, timeout=120)
        with open(f"{folder}/ticks.csv", encoding="utf-8") as file:
            rows = list(csv.DictReader(file))
    ticks = {key: numpy.array([float(row[key]) for row in rows]) for key in rows[0] if key}
    logged = [atoms for ms, atoms in result.logs["hit"] if begin_ms < ms < 1000 * seconds]
    return {"sound": numpy.stack([result["1"], result["2"]], axis=1), "ticks": ticks,
            "bodies": [h[1] for h in logged],
            "hits": numpy.array([[h[0], *h[2:]] for h in logged], float)}


def table_modes(name="disk"):
    """Frequencies of the elastic modes in the staged table, Hz."""
    return numpy.load(stage_folder() / f"{name}.modal.npz")["freq"]


def latencies(path, rate=RATE, seconds=7.2, table="disk.modal.npz"):
    """[(hit's tick in ms, first tick with force in ms, first sample of the contact's sound in ms)] of each tap with a
    rigid hand, to measure the delay from the servo's contact to force and sound."""
    with tempfile.TemporaryDirectory(prefix="tactus-") as folder:
        patch = Patch()
        sensor = patch.obj("ioa_sdd_phantom", "lab")
        for box in (("ioa_re", "lab"), ("ioa_is", "lab"), ("ioa_mm_haptic", "lab", "disk_scene.txt"),
                    ("ioa_r_spring", "lab"), ("ioa_ddd_phantom", "lab")):
            patch.obj(*box)
        contents = patch.obj("ioa_cs_modal", "lab", "disk", table)
        patch.at(0, contents, "choke 0.01")
        body = patch.obj("ioa_r_modal", "lab", "disk")
        patch.record("contact", body[2])
        patch.log("hit", patch.obj("ioa_bus", "lab", "hit") >> patch.obj("route hit"))
        patch.at(0, sensor, f"hand rigid, path {path}, trace {folder}/ticks.csv")
        patch.at(1000 * seconds - 5, sensor, "trace stop")
        result = patch.render(seconds, rate, timeout=120)
        with open(f"{folder}/ticks.csv", encoding="utf-8") as file:
            ticks = [(float(row["ms"]), float(row["fz_n"])) for row in csv.DictReader(file)]
    found = []
    for ms, atoms in result.logs["hit"]:
        if ms >= 1000 * seconds:
            break
        t = atoms[0]
        felt = next(m for m, f in ticks if m >= t - 5 and f > 0)
        first = int((t - 5) * rate / 1000)
        heard = (first + numpy.flatnonzero(result["contact"][first:])[0]) * 1000 / rate
        found.append((t, felt, heard))
    return found
