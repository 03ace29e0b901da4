"""[stress_haptic] solves its part again by the program part_stress: in a render, whose results repeat, and
live, where the child may die, Pd may die and the object may be deleted. Live tests wait for events."""
import json
import os
import pathlib
import re
import signal
import socket
import struct
import subprocess
import time

import numpy
import pytest

from harness import Patch, stage_folder
from harness.live import WAIT_S, LivePd, free_port, patch_text

PROGRAM = stage_folder() / "part_stress"
if not PROGRAM.exists():
    pytest.skip("the program part_stress is not built", allow_module_level=True)
MOVE_MM = 4  # a fifth of the height
POINTS = (21, 26)  # of the top edge, across the beam, a sixth of the length from the clamp


@pytest.fixture(scope="module", params=[10, pytest.param(5, marks=pytest.mark.slow)])
def beam(tmp_path_factory, request):
    """A cantilever of 200 x 20 x 20 mm, 80 hex20, or 640; a lattice of 5 x 2 x 3, of which two points may move."""
    path = tmp_path_factory.mktemp("beam") / "beam.stress.npz"
    subprocess.run([PROGRAM, *"bar --length 200 --width 20 --thickness 20 --fix x=-100 --force x=100:0,0,-100 "
                    "--lattice 5 2 3 --controls 21,26 --quiet --h".split(), str(request.param), "-o", path],
                   check=True, capture_output=True, timeout=300)
    return path


def moved(table):
    """Displacements of all parameters, m, with the points down."""
    return numpy.array([-1e-3 * MOVE_MM if row[0] in POINTS and row[1] == 2 else 0 for row in table["parameters"]])


def solve(path, p, method):
    """von Mises [N] and iterations by `serve` itself: method 1 PCG on the first factor, 2 a new factor."""
    table = numpy.load(path)
    with subprocess.Popen([PROGRAM, "serve", path, "--tolerance", "1e-8"], stdin=subprocess.PIPE,
                          stdout=subprocess.PIPE) as child:
        request = struct.pack("<II", method, 2) + p.astype("<f8").tobytes()
        said = child.communicate(struct.pack("<IIQ", 0x31525354, 1, len(request)) + request, timeout=300)[0]
    answer = said[16 + 40 + 16:]
    found, iterations = struct.unpack_from("<II", answer)
    assert found == method
    return numpy.frombuffer(answer, "<f4", len(table["s0"]), 32 + 8 * len(p)), iterations


def test_gradients_on_the_old_factor_find_the_stress_of_a_full_solve(beam):
    """P22. Stresses travel in single precision: one rounding in an element, 1e-8 in the mean."""
    table = numpy.load(beam)
    p = moved(table)
    (pcg, iterations), (full, _) = solve(beam, p, 1), solve(beam, p, 2)
    assert 5 <= iterations <= 20
    assert numpy.all(numpy.abs(pcg - full) <= numpy.spacing(full))
    mean = full.mean(dtype=float)
    assert pcg.mean(dtype=float) == pytest.approx(mean, rel=1e-8)
    taylor = (table["s0"] + p @ table["S"].astype(float)).mean()
    assert 0.01 < abs(taylor / mean - 1) < 0.05


def render(beam, resolve, seconds=1.0, solver=None, fails=()):
    """The points move down at 300 ms; a handle 40 mm from its anchor feels k = 500 N/m times gamma."""
    table = numpy.load(beam)
    mm = " ".join(f"{1e3 * x:g}" for x in moved(table))
    patch = Patch()
    box = patch.obj("stress_haptic", str(beam), "-resolve", resolve)
    for ms, message in [(1, "range fixed 0 8e+06"), (2, "gains 0 500 0 0"), (3, "anchor 0 0 0"), (300, f"list {mm}")]:
        patch.at(ms, box, message)
    if solver:
        patch.at(4, box, f"solver {solver}")
    patch.at(250, box[1], "40 0 0 0 0 0")
    patch.at(900, box, "bang")
    for i, name in enumerate(("gamma", "force", "info", "protocol")):
        patch.log(name, box[i])
    return patch.render(seconds, expect_errors=fails)


def told(result, word):
    return [(ms, atoms[1]) for ms, atoms in result.logs["info"] if atoms[0] == word]


def test_the_object_solves_by_gradients_and_the_force_goes_over_without_a_jump(beam):
    result = render(beam, "pcg")
    assert told(result, "method")[-1][1] == "pcg"
    assert 5 <= told(result, "iters")[-1][1] <= 20
    assert told(result, "ms")[-1][1] > 0
    full, _ = solve(beam, moved(numpy.load(beam)), 2)
    # Pd's floats: 6e-8.
    assert told(result, "mean")[-1][1] == pytest.approx(full.mean(dtype=float), rel=1.2e-7)
    force = [(ms, atoms[0]) for ms, atoms in result.logs["force"] if ms >= 250]
    taylor = told(result, "mean")
    before, after = force[0][1], force[-1][1]
    assert after == pytest.approx(-20 * full.mean(dtype=float) / 8e6, rel=1e-6)
    # The fades are linear over 100 ms: no step above 1 % of the change, the series' own overshoot included.
    change = 20 * max(abs(mean - told(result, "mean")[0][1]) for _, mean in taylor) / 8e6
    assert abs(after - before) > 0.1
    steps = [abs(b - a) / max(1, tb - ta) for (ta, a), (tb, b) in zip(force, force[1:])]
    assert max(steps) < change / 50 * 1.01


def test_auto_solves_by_gradients_then_finds_new_sensitivities_at_rest_and_repeats_exactly(beam):
    first, second = render(beam, "auto"), render(beam, "auto")
    methods = [method for _, method in told(first, "method")]
    assert [m for i, m in enumerate(methods) if i == 0 or m != methods[i - 1]] == ["taylor", "pcg", "full"]
    assert {method for _, method in told(render(beam, "taylor"), "method")} == {"taylor"}
    for outlet in ("gamma", "force", "protocol"):
        assert first.logs[outlet] == second.logs[outlet]
    for word in ("raw", "mean", "method", "iters"):
        assert told(first, word) == told(second, word)


def test_a_solver_that_is_not_there_or_of_another_table_is_one_sentence(beam, tmp_path):
    result = render(beam, "auto", solver="/nowhere/part_stress", fails=["solver /nowhere/part_stress: there is no"])
    assert told(result, "method")[-1][1] == "full"  # the one before goes on
    fake = tmp_path / "part_stress"
    fake.write_text("#!/bin/sh\necho 'part_stress: I am ill' >&2\nexit 1\n")
    fake.chmod(0o755)
    result = render(beam, "auto", solver=fake, fails=["resolve: the solver ended: part_stress: I am ill; Taylor"])
    assert len(result.errors) == 1
    assert set(method for _, method in told(result, "method")) == {"taylor"}
    arrays = dict(numpy.load(beam))
    meta = json.loads(bytes(arrays["meta"]))
    del meta["command"]
    other = tmp_path / "other.stress.npz"
    for changes, resolve, sentence in [  # mesh and words of one part, stresses of another
            ({"s0": arrays["s0"] * 1.01}, "auto", "another stress at the table's own shape"),
            ({"meta": numpy.frombuffer(json.dumps(meta).encode(), numpy.uint8)}, "auto", "does not say how it was made"),
            ({"mesh": None}, "full", "resolve full: no solver for a table without its mesh"),
            ({"mesh": None}, "auto", None)]:
        numpy.savez(other, **{k: v for k, v in {**arrays, **changes}.items() if v is not None})
        result = render(other, resolve, fails=[sentence] if sentence else [])
        assert len(result.errors) == bool(sentence)


class Live(LivePd):
    """With the object in a subpatch and a socket to its inlet."""

    def __init__(self, folder, beam):
        port, patch = free_port(), folder / "live.pd"
        patch.write_text(patch_text(
            ["obj 10 10 pd part", f"obj 10 100 netreceive {port}", "obj 10 130 route object canvas", "obj 10 160 s live-in",
             "obj 200 160 s pd-part"], ["1 0 2 0", "2 0 3 0", "2 1 4 0"]).replace("#X obj 10 10 pd part", f"""\
#N canvas 0 0 400 300 part 0;
#X obj 10 10 r live-in;
#X obj 10 40 stress_haptic {beam} -resolve auto;
#X obj 10 80 print gamma;
#X obj 200 80 print info;
#X connect 0 0 1 0;
#X connect 1 0 2 0;
#X connect 1 2 3 0;
#X restore 10 10 pd part"""))
        super().__init__(patch)
        self.socket = None
        self.wait_until(lambda: self.connects(port), "a socket")

    def connects(self, port):
        try:
            self.socket = socket.create_connection(("127.0.0.1", port), 5)
        except OSError:
            return False
        return True

    def say(self, message):
        self.socket.sendall((message + ";\n").encode())

    def children(self):
        """{pid: state} of part_stress; Z is one that nobody has reaped."""
        found = {}
        for stat in pathlib.Path("/proc").glob("[0-9]*/stat"):
            try:
                name, fields = re.match(r"\d+ \((.*)\) (.*)", stat.read_text(), re.S).groups()
            except (OSError, AttributeError):
                continue
            if name == "part_stress" and int(fields.split()[1]) == self.process.pid:
                found[int(stat.parent.name)] = fields[0]
        return found

    def the_child(self):
        self.wait_for("^info: solver ready")
        (child, state), = self.children().items()
        assert state != "Z"
        return child


@pytest.fixture
def live(tmp_path, beam):
    with Live(tmp_path, beam) as pd, pd.socket:
        yield pd


def is_gone(pid):
    """Ended; a process whose parent has died is reaped by another."""
    try:
        return pathlib.Path(f"/proc/{pid}/stat").read_text().rsplit(")", 1)[1].split()[0] == "Z"
    except OSError:
        return True


def test_no_child_outlives_its_object(live):
    child = live.the_child()
    assert sorted(os.listdir(f"/proc/{child}/fd")) == ["0", "1", "2"]  # none of Pd's files
    assert any(int(fd) > 2 for fd in os.listdir(f"/proc/{live.process.pid}/fd"))
    live.say("canvas clear")
    live.wait_until(lambda: live.children() == {}, "the child's end")  # reaped too
    assert is_gone(child) and live.process.poll() is None


@pytest.mark.parametrize("number", [signal.SIGKILL, signal.SIGTERM])
def test_no_child_outlives_pd(live, number):
    child = live.the_child()
    live.process.send_signal(number)
    live.process.wait(WAIT_S)
    end = time.monotonic() + WAIT_S
    while not is_gone(child):
        assert time.monotonic() < end
        time.sleep(0.02)
