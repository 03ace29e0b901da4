"""The study of what the force does for simulated hands: the program's table, and its claim."""
import csv
import io
import subprocess

import pytest
from harness import stage_folder

PROGRAM = stage_folder().parent / "programs" / "reed_study" / "tactus_reed_study"


def study(*arguments):
    done = subprocess.run([PROGRAM, *map(str, arguments)], check=True, capture_output=True, text=True)
    return done.stdout


def rows(text):
    return list(csv.DictReader(io.StringIO(text)))


def test_the_same_seeds_give_the_same_trials_however_they_are_shared_out():
    order = ("trumpet", "--feel", "off", "guidance", "--ceiling", 2, "--seeds", 3, 4, "--seconds", 4)
    whole = study(*order)
    assert study(*order) == whole
    shared = study(*order, "--part", "1/3") + study(*order, "--part", "2/3") + study(*order, "--part",
                                                                                   "3/3")
    assert sorted(shared.splitlines()) == sorted(whole.splitlines())
    assert len(rows(whole)) == 4


@pytest.mark.slow
@pytest.mark.parametrize("preset", ["trumpet", "clarinet"])
@pytest.mark.parametrize("hand", ["searches", "wanders"])
def test_guidance_at_least_halves_the_time_out_of_the_playable_region(preset, hand):
    trials = rows(study(preset, "--hand", hand, "--feel", "off", "guidance", "--ceiling", 2, "--seeds",
                        101, 108))
    out = {feel: [1 - float(t["playing"]) for t in trials if t["feel"] == feel]
           for feel in ("off", "guidance")}
    assert sum(out["guidance"]) <= 0.5 * sum(out["off"])
    speed = {feel: [float(t["speed_mm_s"]) for t in trials if t["feel"] == feel]
             for feel in ("off", "guidance")}
    assert sum(speed["guidance"]) <= 1.5 * sum(speed["off"])  # it leads, it does not shake


@pytest.mark.parametrize("wrong", [[], ["kazoo"], ["trumpet", "--feel", "warm"],
                                   ["trumpet", "--stiffness", "-3"], ["trumpet", "--part", "3/2"],
                                   ["trumpet", "--seeds", "4"], ["trumpet", "--loud"]])
def test_a_wrong_order_gets_one_sentence(wrong):
    done = subprocess.run([PROGRAM, *wrong], capture_output=True, text=True)
    assert done.returncode == 1
    assert done.stdout == "" and len(done.stderr.splitlines()) == 1
