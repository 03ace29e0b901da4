"""[tactus_preset]: whatever is set in an object comes back exactly, from memory and from a file, and what lies
between two presets is reached without an error. On every object, with random settings."""
import json
import math
import os
import pathlib
import random

import numpy
import pytest

from harness import Patch, stage_folder
from harness.run import ROOT

LIVE = ROOT / "patches" / "live"
BUILD = pathlib.Path(os.environ.get("TACTUS_BUILD", stage_folder().parent))
DECLARATIONS = {d["name"]: d for d in json.loads((BUILD / "declarations.json").read_text())}
ARGUMENTS = {"modal_impact~": ["plate.modal.npz"], "footstep~": ["gravel"]}
FIXED = {"modal_impact~": {"radiation"}, "haptic_server": {"port"}}  # the plate has one kind; no port is opened
# Settings that are messages and no parameters: in dump, and kept.
MESSAGES = {
    "greed~": [["end", "trumpet"], ["valves", 1, 3]],
    "modal_impact~": [["material", 7.12345e10, 2712.3], ["damping", "rayleigh", 3, 2e-7], ["striker", 0.002, 0.004, 7e10, 0.3],
                      ["hardness", 123456, 2.5, 0.1], ["friction", 0.5, 0.3, 0.1, 0.5, 12345, 1, 0, 0.2],
                      ["normal", 0, 0.6, 0.8], ["point", 31.5, 22.25, 2.5], ["rub", 10, 20, 2.5, 1, 0, 0],
                      ["listener", 1, 12.5, -30, 456.5], ["damping", "losscurve", 100, 1e-3, 5000, 0.02]],
    "footstep~": [["surface", "snow", "gravel", 0.3712345]],
    "contact_impact~": [["modes", 331.2345678, 0.61, 1, 912.3, 0.31, 0.7]],
    "contact_friction~": [["modes", 331.2345678, 0.61, 1, 912.3, 0.31, 0.7]],
    "particle~": [["modes", 331.2345678, 0.61, 1]],
    "playability_map": [["range", 100.12345, 5000.678, 900.5, 3000.25]],
    "greed_gradient~": [["range", 100.12345, 5000.678, 900.5, 3000.25]],
    "phantom": [["workspace", -40.12345, -30, -20, 40, 30, 20], ["map", "zxy", 1, -1, 1], ["watchdog", 90, 45],
                ["interp", 12], ["hand", "person", 310.12345, 2.5]],
    "stress_haptic": [["gains", 10.12345, 410, 0.1, 5]],
}
NOT_SETTINGS = {"modes": {"modal_impact~"}}  # a result there


def random_settings(name, seed):
    """[message]: every parameter at random, and what else can be set."""
    generator = random.Random(f"{name} {seed}")
    messages = []
    for p in DECLARATIONS[name]["parameters"]:
        if p["name"] in FIXED.get(name, ()) or not p["stored"]:
            continue
        if p["choices"]:
            value = generator.choice(p["choices"])
        elif p["values"]:
            value = generator.choice(p["values"])
        else:
            low, high = p["lowest"], p["highest"]
            nearby = min(high, max(low, p["initial"]) + 0.1 * (high - low))
            value = float(numpy.float32(generator.uniform(low, nearby)))
            if high - low > 1 and float(p["initial"]).is_integer() and low >= 0 and generator.random() < 0.5:
                value = float(max(math.ceil(low), int(value)))
        messages.append([p["name"], value])
    return messages


def settings(lines, name):
    """The lines of a dump that a preset is to restore: parameters, and messages that are in it."""
    parameters = {p["name"] for p in DECLARATIONS[name]["parameters"] if p["stored"]}
    others = {m[0] for m in MESSAGES.get(name, ())} - parameters
    found, seen = [], set()
    for line in lines:
        word = line[0]
        if word in parameters and word not in seen or word in others and name not in NOT_SETTINGS.get(word, ()):
            found.append(line)
        seen.add(word)
    return found


class Rig:
    """An object with [tactus_preset], played by (ms, to whom, message)."""

    def __init__(self, name):
        self.name, self.patch = name, Patch()
        self.object = self.patch.obj(name, *ARGUMENTS.get(name, []))
        self.preset = self.patch.obj("tactus_preset")
        outlets = [o["name"] for o in DECLARATIONS[name]["outlets"]]
        info = outlets.index("info") if "info" in outlets else len(outlets)
        self.object[info] >> self.preset[1]
        self.preset >> self.object
        self.patch.log("info", self.object[info])
        self.patch.log("report", self.preset[1])
        self.dumps, self.time = {}, 0

    def set(self, messages):
        for message in messages:
            self.do(self.object, message)

    def ask(self, *messages):
        """The preset."""
        for message in messages:
            self.do(self.preset, message)

    def do(self, box, message):
        self.time += 1
        self.patch.at(self.time, box, message)

    def dump(self, label):
        self.do(self.object, "dump")
        self.dumps[label] = self.time

    def render(self, **options):
        result = self.patch.render((self.time + 50) / 1000, path=[LIVE], **options)
        lines = {label: [] for label in self.dumps}
        for ms, atoms in result.logs["info"]:
            for label, time in self.dumps.items():
                if abs(ms - time) < 1e-3:
                    lines[label].append(atoms)
        return {label: settings(found, self.name) for label, found in lines.items()}, [
            atoms for _, atoms in result.logs["report"]]


OBJECTS = sorted(name for name in DECLARATIONS if name not in ("ioa_link",))


@pytest.mark.parametrize("name", OBJECTS)
def test_everything_that_can_be_set_comes_back_exactly(name, tmp_path):
    rig = Rig(name)
    first, second = random_settings(name, 1), random_settings(name, 2)
    file = tmp_path / "presets.txt"
    rig.set(first + MESSAGES.get(name, []))
    rig.dump("first")
    rig.ask("store 1")
    rig.set(second)
    rig.dump("second")
    rig.ask("store loud", "recall 1")
    rig.dump("first again")
    rig.ask(f"write {file}", "clear", f"read {file}", "recall loud")
    rig.dump("second from the file")
    rig.ask("recall 1")
    rig.dump("first from the file")
    dumps, report = rig.render()
    assert len(dumps["first"]) >= len(first) and dumps["first"] != dumps["second"]
    assert dumps["first again"] == dumps["first from the file"] == dumps["first"]
    assert dumps["second from the file"] == dumps["second"]
    assert ["keys", 1, "loud"] in report
    assert not [line for line in report if line[0] == "error"]


# How each sounds: constants of its signal inlets, two states, and what plays it.
PLAYED = {
    "greed~": ((2500, 0, 220), [["preset", "clarinet"], ["tune", 1], ["gain", 1.5]], [["preset", "trombone"], ["q", 4]], []),
    "greed~ without a player": ((2500, 0, 0), [["preset", "sax"]], [["preset", "syrinx"]], []),
    "greed_gradient~": ((0.5, 0.4, 220), [["preset", "sax"], ["tune", 1]], [["preset", "oboe"]], []),
    "footstep~": ((), [["surface", "snow", "gravel", 0.4], ["seed", 7]], [["surface", "wood"], ["seed", 3]], [["step"]]),
    "particle~": ((), [["preset", "maraca"], ["count", 20]], [["preset", "tambourine"]], [["shake", 1]]),
    "modal_impact~": ((), [["material", 7e10, 2700], ["size", 1.2]], [["material", 1e10, 1200], ["size", 0.7]],
                      [["hit", 0.05, 0.02, 0, 1]]),
    "modal_impact~ as it was made": ((), [["out", 2]], [
        ["preset", "rubber"], ["striker", 0.1, 0.02, 1e9, 0.3], ["hardness", 1e6, 2, 1], ["restitution", 0.5],
        ["normal", 0, 1, 1], ["listener", 1, 0, 0, 900], ["point", -20, 10, 0]], [["hit", 40, 30, 0, 1], ["hit", 1]]),
    "contact_impact~": ((), [["modes", 331, 0.6, 1, 912, 0.3, 0.7]], [["modes", 500, 0.1, 1]], [["strike", 1]]),
    "contact_friction~": ((0.1, 1), [["modes", 331, 0.6, 1]], [["modes", 500, 0.1, 1]], []),
}


@pytest.mark.parametrize("how", PLAYED)
def test_a_recalled_state_sounds_as_one_never_changed(how):
    constants, first, second, strikes = PLAYED[how]
    rig = Rig(how.split()[0])
    other = rig.patch.obj(rig.name, *ARGUMENTS.get(rig.name, []))
    for inlet, value in enumerate(constants):
        source = rig.patch.obj("sig~", value)
        for box in (rig.object, other):
            source >> box[inlet]
    for message in [["seed", 1], *first]:  # or each would have its own
        rig.patch.at(10, other, message)
        rig.patch.at(10, rig.object, message)
    rig.time = 20
    rig.ask("store 1")
    rig.time = 100
    rig.set(second + strikes)
    rig.time = 500
    rig.ask("recall 1")
    for box in (other, rig.object):
        for time, messages in ((900, [["reset"]]), (1250, strikes)):
            for message in messages:
                rig.patch.at(time, box, message)
    rig.patch.record("recalled", rig.object[0])
    rig.patch.record("unchanged", other[0])
    result = rig.patch.render(2, path=[LIVE])
    recalled, unchanged = (numpy.asarray(result[name])[48000 * 6 // 5:] for name in ("recalled", "unchanged"))
    # A preset goes through Pd's numbers of 24 bits.
    assert abs(unchanged).max() > 1e-4 and abs(recalled - unchanged).max() < 1e-4 * abs(unchanged).max()


@pytest.mark.parametrize("name", [pytest.param(name, marks=pytest.mark.slow if name == "modal_impact~" else ())
                                  for name in OBJECTS])  # which finds its modes anew for each setting
def test_between_two_presets_numbers_glide_and_switches_switch(name):
    rig = Rig(name)
    for seed, label in ((3, "a"), (4, "b")):
        rig.set(random_settings(name, seed))
        rig.dump(label)
        rig.ask(f"store {label}")
    for label, x in (("0", 0), ("0.25", 0.25), ("1", 1), ("0.75", 0.75), ("0 again", 0)):
        rig.ask(f"morph a b {x}")
        rig.dump(label)
    dumps, report = rig.render()
    assert dumps["0"] == dumps["a"] and dumps["1"] == dumps["b"] and dumps["0 again"] == dumps["a"]
    glided = 0
    for a, b, quarter, three in zip(dumps["a"], dumps["b"], dumps["0.25"], dumps["0.75"]):
        if len(a) == 2 and isinstance(a[1], float) and quarter not in (a, b):
            glided += 1
            assert quarter[1] == pytest.approx(0.75 * a[1] + 0.25 * b[1], rel=1e-5, abs=1e-30)
            assert three[1] == pytest.approx(0.25 * a[1] + 0.75 * b[1], rel=1e-5, abs=1e-30)
        elif len(a) == 2 or quarter[:2] == a[:2] == b[:2]:  # a surface's mixture is a parameter, too
            assert quarter[:2] == a[:2] and three[:2] == b[:2]
    assert glided >= sum(1 for line in dumps["a"] if isinstance(line[-1], float)) // 3
    assert report.count(["recalled", "a"]) == 1


def test_a_recalled_instrument_is_named():
    rig = Rig("greed~")
    rig.set([["preset", "clarinet"], ["gain", 1.5]])
    rig.ask("store 1")
    rig.set([["preset", "oboe"]])
    rig.ask("recall 1")
    rig.set(["get preset"])
    info = [atoms for _, atoms in rig.patch.render((rig.time + 50) / 1000, path=[LIVE]).logs["info"]]
    assert [atoms for atoms in info if atoms[0] == "preset"][-1] == ["preset", "clarinet"]


def messages_of_the_patch():
    """The names in $0-settings, as the file has them."""
    text = (LIVE / "tactus_preset.pd").read_text()
    return set(text.split("$0-settings;\n#A set ")[1].split(";\n")[0].replace("\\;", "").split())


def test_kept_are_messages_of_some_object():
    declared = {m["name"] for d in DECLARATIONS.values() for m in d["messages"]}
    assert messages_of_the_patch() <= declared
    assert {m[0] for messages in MESSAGES.values() for m in messages} <= messages_of_the_patch() | {"end"}


def test_mistakes_are_one_error_each_and_change_nothing(tmp_path):
    rig = Rig("particle~")
    bad = tmp_path / "bad.txt"
    bad.write_text("count 3;\n")
    rig.ask("store 1")
    rig.dump("before")
    rig.ask("recall 7", "delete seven", "morph 1 7 0.5", "frobnicate", "read no/such/file.txt", f"read {bad}")
    rig.dump("after")
    rig.ask("keys")
    dumps, report = rig.render(expect_errors=["no preset 7", "no preset seven", "morph needs two presets",
                                              "no message frobnicate", "such.file.txt", "cannot read",
                                              "not a file of presets"])
    assert dumps["before"] == dumps["after"]
    assert [line[0] for line in report] == ["stored", *["error"] * 6, "keys"]
    assert report[-1] == ["keys", 1]


def test_a_recalled_preset_ends_no_emergency_stop():
    rig = Rig("phantom")
    rig.set([["slew", 3]])
    rig.ask("store 1")
    rig.set([["slew", 5], "estop"])
    rig.ask("recall 1")
    rig.set(["dump"])
    info = [atoms for _, atoms in rig.patch.render((rig.time + 50) / 1000, path=[LIVE]).logs["info"]]
    assert ["estop", 1] in info and ["status", "estop", 0] not in info
    assert [atoms for atoms in info if atoms[0] == "slew"][-1] == ["slew", 3]
    stored = {name for name, d in DECLARATIONS.items() for p in d["parameters"] if not p["stored"]}
    assert stored == {"phantom"}  # the patch knows its parameter by name


def test_an_object_that_does_not_answer_is_said():
    patch = Patch()
    preset = patch.obj("tactus_preset")
    preset >> patch.obj("greed~")
    patch.log("report", preset[1])
    patch.at(10, preset, "store 1")
    patch.at(20, preset, "keys")
    result = patch.render(0.05, path=[LIVE], expect_errors=["nothing came"])
    assert [atoms[0] for _, atoms in result.logs["report"]] == ["error", "keys"]


def test_a_preset_stored_again_replaces_the_old_one_and_two_copies_do_not_meet():
    patch = Patch()
    for count in (10, 20):
        box, preset = patch.obj("particle~"), patch.obj("tactus_preset")
        box[3] >> preset[1]
        preset >> box
        patch.log(f"info-{count}", box[3])
        patch.log(f"report-{count}", preset[1])
        for ms, to, message in ((10, box, f"count {count}"), (20, preset, "store 1"), (30, box, f"count {count + 1}"),
                                (40, preset, "store 1"), (50, box, "count 3"), (60, preset, "recall 1"),
                                (70, box, "get count"), (80, preset, "keys")):
            patch.at(ms, to, message)
    logs = patch.render(0.1, path=[LIVE]).logs
    for count in (10, 20):
        assert [a for ms, a in logs[f"info-{count}"] if ms == 70] == [["count", count + 1]]
        assert logs[f"report-{count}"][-1][1] == ["keys", 1]
