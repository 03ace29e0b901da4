"""[phantom] with its simulated device in a headless Pd."""

import csv
import os
import random
import re
import subprocess
import time

import pytest

from harness import Patch, run_pd, stage_folder


class DevicePatch:
    """A patch with one [phantom], messages at given times and a print on each outlet."""

    def __init__(self, arguments="", end_ms=100):
        self.lines = ["#N canvas 0 0 800 600 12;"]
        self.cords = []
        self.box = self.obj(f"phantom {arguments}")
        self.start = self.obj("loadbang")
        for outlet, name in enumerate(("x", "y", "z", "info")):
            self.cord(self.box, outlet, self.obj(f"print {name}"), 0)
        self.at(end_ms, r"\; pd quit", None)

    def obj(self, text, kind="obj"):
        self.lines.append(f"#X {kind} 10 10 {text};")
        return len(self.lines) - 2

    def cord(self, source, outlet, sink, inlet):
        self.cords.append(f"#X connect {source} {outlet} {sink} {inlet};")

    def at(self, ms, message, inlet=0):
        """Sends the message to an inlet of [phantom] (None: nowhere); returns the message box."""
        delay = self.obj(f"delay {ms}")
        box = self.obj(message, "msg")
        self.cord(self.start, 0, delay, 0)
        self.cord(delay, 0, box, 0)
        if inlet is not None:
            self.cord(box, 0, self.box, inlet)
        return box

    def run(self, folder, *flags, batch=True):
        file = folder / "patch.pd"
        file.write_text("\n".join(self.lines + self.cords) + "\n")
        if batch:
            return Result(run_pd([file], path=[stage_folder()], arguments=flags))
        begun = time.monotonic()
        live = subprocess.run([os.environ.get("TACTUS_PD", "pd"), "-nogui", "-nosound", "-noprefs",
                               "-stderr", "-path", str(stage_folder()), "-open", str(file)],
                              capture_output=True, text=True, timeout=300, check=True)
        return Result(live.stderr, time.monotonic() - begun)


class Result:
    def __init__(self, text, wall_seconds=0):
        self.text, self.wall_seconds = text, wall_seconds
        self.errors = re.findall(r"^error: (.*)$", text, re.M)
        self.info = [line.split() for line in re.findall(r"^info: (.*)$", text, re.M)]

    def positions(self):
        """Triples in the order they came; the outlets fire from right to left."""
        numbers = re.findall(r"^([xyz]): (\S+)$", self.text, re.M)
        assert [name for name, _ in numbers] == ["z", "y", "x"] * (len(numbers) // 3)
        values = [float(value) for _, value in numbers]
        return [tuple(reversed(values[i:i + 3])) for i in range(0, len(values), 3)]

    def tagged(self, tag):
        return [[float(word) for word in row[1:]] for row in self.info if row[0] == tag]

    def stat(self, name):
        return [float(row[2]) for row in self.info if row[:2] == ["stats", name]][-1]


def force_after(result):
    return result.tagged("force")[-1]


# ---- repeatability -------------------------------------------------------------------------

def guided_patch():
    """A spring hand on a path, force -6 (x - 0.5) from the patch, every tick traced."""
    patch = DevicePatch("-hand spring 200 2 -path lissajous 0 0 0 20 10 5 1 1.5 0.7 "
                        "-trace ticks.csv", end_ms=2000)
    expression = patch.obj(r"expr -6*($f1-0.5)")
    patch.cord(patch.box, 0, expression, 0)
    patch.cord(expression, 0, patch.box, 0)
    patch.at(1999.5, "trace stop")
    return patch


def in_blocks(patch, size):
    """Puts the patch on that block size with its audio on."""
    patch.obj(f"block~ {size}")
    osc, dac = patch.obj("osc~ 440"), patch.obj("send~ nowhere")
    patch.cord(osc, 0, dac, 0)
    patch.at(0, r"\; pd dsp 1", None)
    return patch


def test_three_runs_give_the_same_bytes(tmp_path):
    seen = set()
    for run in range(3):
        folder = tmp_path / str(run)
        folder.mkdir()
        result = guided_patch().run(folder)
        assert len(result.positions()) == 2000
        seen.add((result.text, (folder / "ticks.csv").read_bytes()))
    assert len(seen) == 1


def test_block_size_changes_no_position(tmp_path):
    seen = set()
    for size in (1, 64, 1024):  # of the patch
        folder = tmp_path / str(size)
        folder.mkdir()
        result = in_blocks(guided_patch(), size).run(folder)
        rows = list(csv.DictReader((folder / "ticks.csv").open()))
        assert len(rows) == 2000
        seen.add((tuple(result.positions()), (folder / "ticks.csv").read_bytes()))
    for size in ("64", "1024"):  # of Pd's audio
        folder = tmp_path / f"audio{size}"
        folder.mkdir()
        result = in_blocks(guided_patch(), 64).run(folder, "-blocksize", size)
        seen.add((tuple(result.positions()), (folder / "ticks.csv").read_bytes()))
    assert len(seen) == 1


def test_every_tick_is_one_millisecond_and_the_force_is_the_patch_s(tmp_path):
    guided_patch().run(tmp_path)
    rows = [{k: float(v) for k, v in row.items()}
            for row in csv.DictReader((tmp_path / "ticks.csv").open())]
    assert [row["tick"] for row in rows] == list(range(2000))
    assert all(row["ms"] == pytest.approx(i, abs=1e-6) for i, row in enumerate(rows))
    # The patch sees tick n and its answer is what tick n + 1 writes; -6 N over 100 mm.
    for before, after in zip(rows[100:], rows[101:]):
        assert after["fx_n"] == pytest.approx(-0.06 * before["x_mm"], abs=2e-6)


# ---- the numbers -----------------------------------------------------------------------------

@pytest.mark.parametrize("mm, normal", [((0, 0, 0), (0.5, 0.5, 0.5)),
                                        ((40, -75, 10), (0.75, 0, 0.642857))])
def test_positions_are_normalised_over_the_workspace(tmp_path, mm, normal):
    point = " ".join(map(str, mm))
    patch = DevicePatch(f"-hand rigid -path line {point} {point} 1000 "
                  "-workspace -80 -60 -35 80 60 35", 20)
    patch.at(10, "bang")
    result = patch.run(tmp_path)
    assert result.positions()[-1] == pytest.approx(normal, abs=1e-5)
    assert result.tagged("mm")[-1] == pytest.approx(mm, abs=1e-4)


def test_the_limit_keeps_the_direction(tmp_path):
    patch = DevicePatch("-hand rigid -forcemax 2", 100)
    patch.at(10, "list 3 -4 0")
    patch.at(50, "bang")
    assert force_after(patch.run(tmp_path)) == pytest.approx([1.2, -1.6, 0], abs=1e-5)


def test_forces_on_separate_inlets_are_one_force(tmp_path):
    patch = DevicePatch("-hand rigid -interp off -report force 1", 60)
    for inlet, newtons in enumerate((0.25, -0.5, 1)):
        patch.at(20.5, str(newtons), inlet)
    forces = [row for row in patch.run(tmp_path).tagged("force")]
    assert {tuple(f) for f in forces} == {(0, 0, 0), (0.25, -0.5, 1)}


def test_a_norm_of_one_is_the_largest_force(tmp_path):
    patch = DevicePatch("-hand rigid -forcemax 4 -units norm", 100)
    patch.at(10, "0.5", 1)
    patch.at(50, "bang")
    assert force_after(patch.run(tmp_path)) == pytest.approx([0, 2, 0], abs=1e-5)


@pytest.mark.parametrize("bad", ["inf", "nan"])
def test_what_is_no_number_is_refused_once_and_the_last_good_force_stays(tmp_path, bad):
    patch = DevicePatch("-hand rigid", 200)
    patch.at(10, "1.5", 1)
    huge = patch.obj("* 1e38")
    if bad == "inf":
        patch.cord(huge, 0, patch.box, 1)
    else:  # infinity minus infinity
        twice, difference = patch.obj("t f f"), patch.obj("-")
        patch.cord(huge, 0, twice, 0)
        patch.cord(twice, 1, difference, 1)
        patch.cord(twice, 0, difference, 0)
        patch.cord(difference, 0, patch.box, 1)
    patch.cord(patch.at(50, "1e38", None), 0, huge, 0)
    patch.at(60, "bang")
    patch.at(60, "stats")
    patch.at(100, "0.25", 1)
    patch.at(180, "bang")
    result = patch.run(tmp_path)
    first, last = result.tagged("force")
    assert first == pytest.approx([0, 1.5, 0], abs=1e-6)
    assert last == pytest.approx([0, 0.25, 0], abs=1e-6)
    assert result.stat("refused") == 1
    assert len(result.errors) == 1 and "not a finite number" in result.errors[0]


def test_a_strict_watchdog_wants_forces_to_keep_coming(tmp_path):
    patch = DevicePatch("-hand rigid -strict 1 -watchdog 100 50 -interp off", 400)
    patch.at(19.5, "list 1 0 0")
    for ms in (110.5, 145.5, 175.5):
        patch.at(ms, "bang")
    patch.at(200.5, "list 1 0 0")
    patch.at(300.5, "bang")
    forces = [f[0] for f in patch.run(tmp_path).tagged("force")]
    assert forces[0] == 1
    assert forces[1] == pytest.approx(0.5, abs=0.03)
    assert forces[2] == 0
    assert forces[3] == 1


def test_an_emergency_stop_lasts_until_motors_on(tmp_path):
    patch = DevicePatch("-hand rigid", 1200)
    patch.at(10, "list 2 0 0")
    patch.at(99, "estop")
    patch.at(102, "bang")
    patch.at(200, "list 3 0 0")
    patch.at(300, "bang")
    patch.at(400, "motors 1")
    patch.at(650.5, "bang")
    patch.at(1000, "bang")
    forces = [f[0] for f in patch.run(tmp_path).tagged("force")]
    assert forces[0] == 0 and forces[1] == 0
    assert forces[2] == pytest.approx(1.5, abs=0.02)
    assert forces[3] == pytest.approx(3, abs=1e-5)


def forces_at(patch, folder, times, *flags, batch=True):
    for ms in times:
        patch.at(ms, "bang")
    return [f[0] for f in patch.run(folder, *flags, batch=batch).tagged("force")]


@pytest.mark.parametrize("between", [["close", "open"], ["clock wall", "clock logical"],
                                     ["rate 2000"], ["backend sim"], ["name other"],
                                     ["motors 0"]])
def test_an_emergency_stop_holds_whatever_happens_to_the_connection(tmp_path, between):
    patch = DevicePatch("-hand rigid", 1700)
    patch.at(10, "list 2 0 0")
    patch.at(100, "estop")
    for i, message in enumerate(between):
        patch.at(110 + i, message)
    for ms in range(120, 900, 20):
        patch.at(ms, f"list 2.{ms} 0 0")
    patch.at(980, "dump")
    patch.at(1000, "motors 1")
    patch.at(1010, "list 2 0 0")
    before, held, back = forces_at(patch, tmp_path, (99, 900, 1650))
    assert before == pytest.approx(2)
    assert held == 0
    assert back == pytest.approx(2)


def made_twice(folder, name, say, first=("estop",)):
    """A phantom that is stopped and deleted, and the one that is made after it, with what is said
    to that; the forces of both, half a second after they were asked for."""
    patch = DevicePatch("", 3000)
    patch.obj("pd made")
    lines = ["obj 10 10 r say", f"obj 10 50 phantom sim -hand rigid {name}",
             "obj 10 90 print again", "connect 0 0 1 0", "connect 1 3 2 0"]
    for start in (10, 310):
        for i, line in enumerate(lines):
            patch.at(start + i, rf"\; pd-made {line}", None)
    patch.at(100, r"\; say list 2 0 0", None)
    patch.at(150, r"\; say bang", None)
    for i, message in enumerate(first):
        patch.at(200 + i, rf"\; say {message}", None)
    patch.at(300, r"\; pd-made clear", None)
    for i, message in enumerate(say):
        patch.at(350 + i, rf"\; say {message}", None)
    patch.at(1000, r"\; say list 2 0 0", None)
    patch.at(1600, r"\; say bang", None)
    result = patch.run(folder)
    return [float(x) for x in re.findall(r"^again: force (\S+)", result.text, re.M)], result


def test_an_emergency_stop_holds_for_the_next_phantom_of_that_name(tmp_path):
    forces, result = made_twice(tmp_path, "-name left", ["dump"])
    assert forces == [pytest.approx(2), 0]
    assert "the estop of an earlier phantom holds for this one" in result.text
    assert re.search(r"^again: estop 1", result.text, re.M)


def test_the_user_ends_the_stop_of_an_earlier_phantom_of_that_name(tmp_path):
    forces, result = made_twice(tmp_path, "-name left", ["motors 1", "dump"])
    assert forces == [pytest.approx(2), pytest.approx(2)]
    assert re.search(r"^again: estop 0", result.text, re.M)


def test_a_stop_that_was_ended_is_not_inherited(tmp_path):
    forces, result = made_twice(tmp_path, "-name left", [], ("estop", "motors 1"))
    assert forces == [pytest.approx(2), pytest.approx(2)]
    assert "earlier phantom" not in result.text


def test_a_creation_argument_does_not_end_it(tmp_path):
    assert made_twice(tmp_path, "-name left -motors 1", [])[0] == [pytest.approx(2), 0]


def test_a_phantom_without_a_name_that_is_simulated_leaves_no_stop(tmp_path):
    assert made_twice(tmp_path, "", [])[0] == [pytest.approx(2), pytest.approx(2)]


def test_a_gradient_in_the_patch_becomes_the_force(tmp_path):
    """f = 1 - (y - 0.6)^2 - (z - 0.3)^2 at (0.5, 0.5): central differences give (0.2, -0.4)."""
    patch = DevicePatch("-hand rigid -repeat 1", 100)
    for axis, best in ((1, 0.6), (2, 0.3)):
        high, low = (rf"(1-pow($f1{sign}0.01-{best}\, 2))" for sign in "+-")
        slope = patch.obj(f"expr ({high}-{low})/0.02")
        patch.cord(patch.box, axis, slope, 0)
        patch.cord(slope, 0, patch.box, axis)
    patch.at(90, "bang")
    assert force_after(patch.run(tmp_path)) == pytest.approx([0, 0.2, -0.4], abs=1e-4)


def test_guidance_moves_a_hand_to_its_equilibrium(tmp_path):
    patch = DevicePatch("-hand spring 200 2", 2100)
    patch.at(100, "list 1 0 0")
    patch.at(2000, "bang")
    assert patch.run(tmp_path).tagged("mm")[-1] == pytest.approx([5, 0, 0], abs=1e-3)


# ---- the simulated hand ------------------------------------------------------------------------

def test_a_path_file_moves_the_hand_and_its_buttons(tmp_path):
    (tmp_path / "stroke.txt").write_text("# ms x y z buttons\n0 0 0 0 0\n100 10 20 -30 2\n")
    patch = DevicePatch("-hand rigid -path stroke.txt", 200)
    patch.at(50.5, "bang")
    patch.at(150.5, "bang")
    patch.at(160.2, "seek 50")
    patch.at(161.5, "bang")
    result = patch.run(tmp_path)
    assert result.tagged("mm")[0] == pytest.approx([5, 10, -15], abs=1e-4)
    assert result.tagged("mm")[1] == pytest.approx([10, 20, -30], abs=1e-4)
    assert result.tagged("mm")[2][0] == pytest.approx(5.1, abs=1e-4)
    assert result.tagged("vel")[0] == pytest.approx([0.1, 0.2, -0.3], abs=1e-5)
    assert result.tagged("button")[0] == [1, 1]


def test_arrays_are_a_path(tmp_path):
    patch = DevicePatch("-hand rigid", 100)
    for name, top in (("ax", 9), ("ay", 0), ("az", -4.5)):
        patch.obj(f"table {name} 10")
        values = " ".join(str(top * i / 9) for i in range(10))
        patch.at(1, rf"\; {name} 0 {values}", None)
    patch.at(10.5, "path array ax ay az 2")
    patch.at(19.5, "bang")
    patch.at(60.5, "bang")
    first, last = patch.run(tmp_path).tagged("mm")
    assert first == pytest.approx([4.5, 0, -2.25], abs=1e-4)
    assert last == pytest.approx([9, 0, -4.5], abs=1e-4)


def test_a_target_draws_the_hand_there(tmp_path):
    patch = DevicePatch("-hand spring 500 5", 1000)
    patch.at(10, "target 12 -8 30")
    patch.at(900, "bang")
    assert patch.run(tmp_path).tagged("mm")[-1] == pytest.approx([12, -8, 30], abs=1e-2)


def test_learning_takes_the_workspace_from_the_motion(tmp_path):
    patch = DevicePatch("-hand rigid -path line -10 5 0 30 -15 0 400", 900)
    patch.at(5.5, "workspace learn 1")
    patch.at(600.5, "workspace learn 0")
    box = patch.run(tmp_path).tagged("workspace")[0]
    assert box == pytest.approx([-10, -15, 0, 30, 5, 0], abs=1e-2)


def test_axes_can_be_exchanged(tmp_path):
    patch = DevicePatch("-hand rigid -path line 10 20 30 10 20 30 1000 -map zxy 1 -1 1", 50)
    patch.at(20, "bang")
    assert patch.run(tmp_path).tagged("mm")[-1] == pytest.approx([30, -10, 20], abs=1e-4)


def test_seeds_choose_the_person(tmp_path):
    texts = []
    for seed in (1, 1, 2):
        patch = DevicePatch(f"-hand person -seed {seed}", 300)
        texts.append(patch.run(tmp_path).text)
    assert texts[0] == texts[1] != texts[2]


def test_an_encoder_step_shows_and_velocity_is_estimated(tmp_path):
    patch = DevicePatch("-hand rigid -resolution 0.05 -report mm 1 -report vel 1 "
                  "-path line -20 0 0 20 0 0 1000", 251)
    result = patch.run(tmp_path)
    steps = [row[0] / 0.05 for row in result.tagged("mm")]
    assert all(abs(s - round(s)) < 1e-2 for s in steps)
    # Half way after 250 ms at pi * 40 mm / 1 s.
    assert result.tagged("vel")[-1][0] == pytest.approx(0.1257, rel=0.05)


def test_output_can_be_slow_on_demand_or_repeated(tmp_path):
    moving = "-path lissajous 0 0 0 20 10 5 1 1 1"
    assert len(DevicePatch(f"{moving} -outrate 100", 99.5).run(tmp_path).positions()) == 10
    assert DevicePatch(f"{moving} -outrate 0", 99.5).run(tmp_path).positions() == []
    assert len(DevicePatch("", 99.5).run(tmp_path).positions()) == 1
    assert len(DevicePatch("-repeat 1", 99.5).run(tmp_path).positions()) == 100
    patch = DevicePatch(f"{moving} -rate 4000", 99.5)
    patch.at(99, "stats")
    result = patch.run(tmp_path)
    assert result.stat("ticks") == pytest.approx(397, abs=1)
    assert len(result.positions()) == 100


def test_a_rate_changed_on_the_way_goes_on_at_once(tmp_path):
    patch = DevicePatch("-path lissajous 0 0 0 20 10 5 1 1 1", 2000)
    patch.at(1000.2, "rate 200")
    patch.at(1999, "stats")
    assert patch.run(tmp_path).stat("ticks") == pytest.approx(1200, abs=2)


def test_closing_stops_and_opening_starts_afresh(tmp_path):
    patch = DevicePatch("-path lissajous 0 0 0 20 10 5 1 1 1", 300)
    patch.at(99.5, "close")
    patch.at(199.5, "open")
    result = patch.run(tmp_path)
    assert len(result.positions()) == pytest.approx(200, abs=2)
    assert [row for row in result.info if row[0] == "status"] == [
        ["status", "closed", "sim"], ["status", "open", "sim"]]


# ---- refusals -----------------------------------------------------------------------------------

@pytest.mark.parametrize("message, sentence", [
    ("backend sim 3", "backend sim: takes no arguments"),
    ("hand soft", "hand soft: expected free, rigid, spring or person"),
    ("hand spring 1", "hand spring: 1 number: expected none, or K (N/m) and B (N s/m)"),
    ("hand spring -1 2", "hand: K -1 N/m: expected 0..20000 N/m"),
    ("path nix.txt", "path nix.txt: no such file; or use line, circle, lissajous or array"),
    ("path line 1 2", "path line: z1 is missing: expected -10000..10000 mm"),
    ("path array a b c", "path array: no array named a"),
    ("path circle 0 0 0 10 1000 xw", "path circle: plane xw: expected xy, yz or xz"),
    ("watchdog 0 1", "watchdog: hold 0 ms: expected 1..10000 ms"),
    ("forcemax 99", "forcemax 99 N: expected 0..40"),
    ("rate 100", "rate 100 Hz: expected 200..4000"),
    ("extrap 21", "extrap 21 ms: expected 0..20"),
    ("units pound", "units pound: expected newton or norm"),
    ("map xxy", "map xxy: expected the letters xyz in some order and three signs 1 or -1"),
    ("map xyz 1 2 1", "map xyz 1 2 1: expected the letters xyz in some order and three signs 1 or -1"),
    ("interp 2000", "interp 2000: expected auto, off or 0.25..1000 ms"),
    ("workspace 5 0 0 1 1 1",
     "workspace 5 0 0 1 1 1: expected no minimum above its maximum, xmin ymin zmin xmax ymax zmax in mm"),
    ("workspace 1 2",
     "workspace 1 2: expected device, learn 0|1 or xmin ymin zmin xmax ymax zmax in mm"),
    ("report x 1", "report x: expected mm, vel, force, button, status, jitter, "
     "error, hit, contact, release, rot, torque or grip"),
    ("list 1 2", "list: expected 3 arguments (fx fy fz), got 2"),
    ("open falcon",
     "open falcon: expected nothing or 0, since sim is one device; backend chooses another"),
    ("hand rigid 3", "hand rigid: 1 number: expected none"),
    ("scene add b box 0 0 0 1 1 1 0 0 0 0", "scene add: box: the quaternion qw qx qy qz is 0 0 0 0: "
     "expected one that is a rotation, as 1 0 0 0"),
    ("list 1 two 3", "list two: expected three numbers, fx fy fz"),
    ("button 40 1", "button: number 40: expected 0..31"),
    ("clock sundial", "clock sundial: expected auto, logical or wall"),
    ("stats now", "stats now: expected reset"),
    ("trace /nowhere/x.csv", "trace /nowhere/x.csv: cannot be written, No such file or directory"),
    ("target 1 2 99999", "target: z 99999 mm: expected -10000..10000 mm"),
    ("firmware f.bin", "firmware: only a real device has one; choose it first with backend evdev, falcon, "
     "dhd, haply, hid, openhaptics or net"),
    ("sedd 3", "no message 'sedd'; did you mean 'seed'?"),
])
def test_a_refused_message_costs_one_sentence(tmp_path, message, sentence):
    patch = DevicePatch("-hand rigid", 30)
    patch.at(10, message)
    patch.at(20, "bang")
    result = patch.run(tmp_path)
    assert result.errors == [f"phantom: {sentence}"]
    assert result.tagged("mm") == [[0, 0, 0]]


@pytest.mark.parametrize("driver, message, sentence", [
    ("hid", "driver deadzone 500", "driver deadzone 500: hid: deadzone 500 is not possible: expected 0 to 90"),
    ("haply", "driver rate 9", "driver rate 9: haply: rate 9 is not possible: expected 50 to 4000 Hz"),
    ("haply", "driver rat 90", "driver rat 90: haply: rat is not understood; there are: device INDEX or ID"),
    ("evdev", "driver peak x", "driver peak x: evdev: peak x is not possible: expected 0.1 to 40 N"),
    ("net", "driver rat 90", "driver rat 90: net: rat is not understood; there are: host HOST PORT"),
    ("net", "driver device 5", "driver device 5: net: there is no device 5: expected 0, HOST or HOST:PORT"),
    ("net", "driver host here y", "driver host here y: net: the port y is no whole number from 1 to 65535"),
])
def test_a_setting_that_a_driver_refuses_is_named_with_its_value(driver, message, sentence):
    patch = Patch()
    box = patch.obj("phantom", driver)
    patch.at(10, box, message)
    result = patch.render(0.1, expect_errors=[f"phantom: {sentence}"])
    assert len(result.errors) == 1


def test_a_path_file_that_is_wrong_names_the_line(tmp_path):
    (tmp_path / "bad.txt").write_text("0 0 0 0\n5 1 2\n")
    patch = DevicePatch("", 20)
    patch.at(10, "path bad.txt")
    assert patch.run(tmp_path).errors == [
        "phantom: path bad.txt: line 2: expected ms x y z [buttonmask]"]


# ---- anything goes -----------------------------------------------------------------------------

NAMES = ("bang list scene backend open close devices driver home workspace map interp watchdog estop report stats "
         "hand path target seek button rate outrate repeat units forcemax slew extrap strict "
         "passivity tank allowance damp walls motors mass viscous stops resolution noise seed get "
         "dump trace").split()
WORDS = ("sim device learn auto off zxy xyz reset free rigid spring person line circle lissajous "
         "array add mat move del k sphere box plane disk all mm vel force button norm newton logical stop yz nonsense").split()
NUMBERS = (0, 1, -1, 0.001, 2, 5, 10, 50, 200, 999, 4000, -300, 1e6, 1e30, -1e30, 1e-30, 0.5)


@pytest.mark.parametrize("seed", range(4))
def test_any_messages_leave_it_alive_and_its_positions_in_range(tmp_path, seed):
    rng = random.Random(seed)
    patch = DevicePatch("-hand person", 4000)
    for index in range(1500):
        if rng.random() < 0.3:
            patch.at(rng.uniform(0, 3900), f"{rng.choice(NUMBERS):g}", rng.randrange(3))
        else:
            arguments = [rng.choice(WORDS) if rng.random() < 0.4 else f"{rng.choice(NUMBERS):g}"
                         for _ in range(rng.choice((0, 1, 1, 1, 2, 3, 6, 7, 9)))]
            patch.at(rng.uniform(0, 3900), " ".join([rng.choice(NAMES), *arguments]))
    for ms in (3950, 3990):
        patch.at(ms, "open")
    patch.at(3995, "bang")
    result = patch.run(tmp_path)
    assert result.positions()
    assert all(0 <= p <= 1 for triple in result.positions() for p in triple)
    assert result.tagged("mm")[-1] == pytest.approx(result.tagged("mm")[-1])  # no NaN
    assert all(abs(f) <= 40 * (1 + 1e-6) for row in result.tagged("force") for f in row)


def test_the_wall_clock_steps_the_simulated_device_too(tmp_path):
    """Live Pd: time is real, so only counts are checked, not lateness. A machine that is too busy
    to step gets longer."""
    for ms in (500, 4000, 30000):
        patch = DevicePatch("-clock wall -path lissajous 0 0 0 20 10 5 1 1 1", ms + 100)
        patch.at(ms, "stats")
        result = patch.run(tmp_path, batch=False)
        assert ["status", "sched"] in [row[:2] for row in result.info]
        ran, skipped = result.stat("ticks"), result.stat("skipped")
        assert ran % 128 == 0  # reported every 128 ticks
        assert ran + skipped <= 1000 * result.wall_seconds
        if ran >= 128 and len(result.positions()) > 5:  # one every 10 ms, fewer when it is busy
            return
    pytest.fail(f"{ran} ticks and {len(result.positions())} positions in {ms} ms")
