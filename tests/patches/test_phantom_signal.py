"""[phantom~]: audio meets the servo of a [phantom], in a headless Pd."""

import csv
import re

import numpy
import pytest

from harness import Patch

RATE = 48000


def rows_of(file):
    return [{key: float(value) for key, value in row.items()} for row in csv.DictReader(file.open())]


def scene(folder, *options, block=64, force=None, vibration=None, device="", seconds=0.5,
          rate=RATE, record=("x", "y", "z"), messages=()):
    """One [phantom] named hand and one [phantom~] on it; every servo tick traced into ticks.csv."""
    patch = Patch(block=block)
    box = patch.obj("phantom", "-name", "hand", *device.split())
    patch.log("info", box[3])
    patch.at(0, box, f"trace {folder}/ticks.csv")
    for ms, message in messages:
        patch.at(ms, box, message)
    signals = patch.obj("phantom~", "hand", *options)
    patch.log("signals", signals[3])
    for inlet, samples in enumerate(force or ()):
        if samples is not None:
            patch.signal(samples) >> signals[inlet]
    if vibration is not None:
        patch.signal(vibration) >> signals[3]
    for label, outlet in (("x", 0), ("y", 1), ("z", 2), ("vx", 4), ("vy", 5), ("vz", 6)):
        if label in record:
            patch.record(label, signals[outlet])
    patch.at(1000 * seconds - 2, box, "trace stop")
    return patch.render(seconds, rate=rate)


def ramp(newton, seconds=1):
    return numpy.linspace(0, newton, round(seconds * RATE), dtype=numpy.float32)


def test_each_tick_reads_the_sample_at_which_it_falls_due(tmp_path):
    force = ramp(4)
    scene(tmp_path, force=[force, 0.5 * force], device="-hand rigid")
    rows = rows_of(tmp_path / "ticks.csv")
    fx = numpy.array([row["fx_n"] for row in rows])
    fy = numpy.array([row["fy_n"] for row in rows])
    first = int(numpy.argmax(fx > 0))
    assert first <= 4
    heard = force[48 * numpy.arange(1, len(fx) - first + 1)]
    assert fx[first:first + 400] == pytest.approx(heard[:400], abs=1e-6)
    assert fy[first:first + 400] == pytest.approx(0.5 * heard[:400], abs=1e-6)


def test_positions_are_the_ticks_joined_by_straight_lines_one_period_late(tmp_path):
    result = scene(tmp_path, "-vel 1", device="-hand rigid -path lissajous 0 0 0 40 20 10 3 2 1",
                   record=("x", "y", "z", "vx"))
    rows = rows_of(tmp_path / "ticks.csv")
    ticks = numpy.array([row["x_mm"] for row in rows])
    heard = (result["x"] - 0.5) * 100
    # Sample 48 k is tick k's position before, sample 48 (k + 1) its own: one period late.
    positions = heard[48 * numpy.arange(1, 400)]
    start = min(range(6), key=lambda s: numpy.abs(ticks[s:s + 399] - positions).max())
    assert positions == pytest.approx(ticks[start:start + 399], abs=1e-4)
    between = heard[48 * 100:48 * 101]
    assert between == pytest.approx(
        numpy.linspace(positions[99], positions[100], 48, endpoint=False), abs=1e-4)
    speed = numpy.array([row["vx_m_per_s"] for row in rows])
    assert result["vx"][48 * numpy.arange(1, 400)] == pytest.approx(speed[start:start + 399],
                                                                    abs=1e-5)


def test_blocks_of_any_size_give_the_same_samples_and_ticks(tmp_path):
    """A force that sings, a hand that yields: every sample and every tick the same bits."""
    t = numpy.arange(RATE) / RATE
    force = (1.5 * numpy.sin(2 * numpy.pi * 7 * t)).astype(numpy.float32)
    seen = set()
    for block in (1, 16, 64, 256, 1024, 4096):
        folder = tmp_path / str(block)
        folder.mkdir()
        result = scene(folder, block=block, force=[force, None, 0.3 * force], device="",
                       seconds=0.6)
        end = 400  # ticks; a large block runs ahead of the patch's clock
        rows = (folder / "ticks.csv").read_text().splitlines()[1:end]
        samples = tuple(result[axis][:48 * end].tobytes() for axis in "xyz")
        seen.add((samples, tuple(rows)))
    assert len(seen) == 1


def test_rebuilding_the_graph_moves_no_tick(tmp_path):
    force = ramp(4)
    rows = []
    for rebuilds in ((), (100, 101, 155, 300)):
        patch = Patch()
        box = patch.obj("phantom", "-name", "hand", "-hand rigid")
        patch.at(0, box, f"trace {tmp_path}/ticks.csv")
        patch.signal(force) >> patch.obj("phantom~", "hand")
        for ms in rebuilds:
            patch.rebuild_dsp(ms)
        patch.at(495, box, "trace stop")
        patch.render(0.5)
        rows.append((tmp_path / "ticks.csv").read_text())
    assert rows[0] == rows[1]


@pytest.mark.parametrize("rate", [44100, 48000, 96000])
def test_other_sample_rates_keep_the_servo_s_thousand_ticks(tmp_path, rate):
    scene(tmp_path, device="-hand rigid", rate=rate)
    rows = rows_of(tmp_path / "ticks.csv")
    assert len(rows) == pytest.approx(498, abs=3)
    steps = numpy.diff([row["ms"] for row in rows])
    assert steps == pytest.approx(numpy.ones(len(steps)), abs=1e-6)


def test_signals_and_numbers_add_up(tmp_path):
    force = numpy.full(RATE, 0.5, dtype=numpy.float32)
    scene(tmp_path, force=[force], device="-hand rigid -interp off",
          messages=[(100, "list 1 2 0"), (300, "list -0.5 0 0")])
    rows = rows_of(tmp_path / "ticks.csv")
    at = {round(row["ms"]): (row["fx_n"], row["fy_n"]) for row in rows}
    assert at[90] == pytest.approx((0.5, 0), abs=1e-6)
    assert at[200] == pytest.approx((1.5, 2), abs=1e-6)
    assert at[400] == pytest.approx((0, 0), abs=1e-6)


def test_what_is_no_number_is_no_force_for_that_tick(tmp_path):
    force = numpy.ones(RATE, dtype=numpy.float32)
    force[48 * 200 - 20:48 * 200 + 20] = numpy.nan
    force[48 * 300 - 20:48 * 300 + 20] = numpy.inf
    scene(tmp_path, force=[force], device="-hand rigid -slew 1000")
    forces = [row["fx_n"] for row in rows_of(tmp_path / "ticks.csv")]
    assert set(forces[10:]) == {0.0, 1.0} and forces[10:].count(0.0) == 2


def touching(z):
    return (f"-hand rigid -path line 0 0 {z} 0 0 {z} 1000 -passivity 0 -slew 1000",
            [(0, "scene add wall plane 0 0 1 0")])


def test_vibration_acts_along_the_normal_of_what_is_touched_and_only_then(tmp_path):
    t = numpy.arange(RATE) / RATE
    vibration = (0.4 * numpy.sin(2 * numpy.pi * 200 * t)).astype(numpy.float32)
    felt = {}
    for name, z, options in (("in", -2, ()), ("out", 2, ()), ("free", 2, ("-gate 0",))):
        folder = tmp_path / name
        folder.mkdir()
        device, messages = touching(z)
        scene(folder, *options, vibration=vibration, device=device, messages=messages)
        felt[name] = numpy.array([row["fz_n"] for row in rows_of(folder / "ticks.csv")])[100:450]
    assert felt["in"].mean() == pytest.approx(1, abs=0.01)
    assert felt["in"].std() * numpy.sqrt(2) == pytest.approx(0.4, rel=0.02)
    assert not felt["out"].any()
    assert felt["free"].std() * numpy.sqrt(2) == pytest.approx(0.4, rel=0.02)


def test_vibration_beyond_the_servo_s_rate_does_not_alias(tmp_path):
    """Butterworth of the eighth order at 400 Hz: 800 Hz, heard as 200, is 48 dB down."""
    t = numpy.arange(RATE) / RATE
    level = {}
    for hertz in (400, 800, 2200):
        folder = tmp_path / str(hertz)
        folder.mkdir()
        device, messages = touching(-2)
        scene(folder, device=device, messages=messages,
              vibration=(0.5 * numpy.sin(2 * numpy.pi * hertz * t)).astype(numpy.float32))
        fz = numpy.array([row["fz_n"] for row in rows_of(folder / "ticks.csv")])[100:450]
        level[hertz] = 20 * numpy.log10((fz - 1).std() * numpy.sqrt(2) / 0.5 + 1e-12)
    assert level[400] == pytest.approx(-3.01, abs=0.2)
    assert level[800] == pytest.approx(-48.2, abs=0.7)
    assert level[2200] < -100


def test_the_two_find_each_other_and_part_in_either_order(tmp_path):
    """Sub-patches made and cleared while the sound runs, device first and signals first."""
    patch = Patch()
    canvas = patch.sub("stage")
    canvas.obj("inlet")
    both = [(10, "obj 10 10 phantom -name late"), (400, "obj 10 50 phantom~ late"),
            (700, "clear"), (800, "obj 10 50 phantom~ late"), (1000, "obj 10 10 phantom -name late"),
            (1400, "obj 10 90 phantom~ late"), (1700, "clear"), (1900, "obj 10 10 phantom~")]
    for ms, message in both:
        patch.send(ms, "pd-stage", message)
    outside = patch.obj("phantom~", "late")
    patch.log("status", outside[3])
    patch.record("x", outside[0])
    result = patch.render(2.2, expect_errors=["another phantom~ has this device"])
    words = [atoms[:2] for _, atoms in result.logs["status"]]
    assert words == [["status", "attached"], ["status", "waiting"], ["status", "attached"],
                     ["status", "waiting"]]
    assert numpy.isfinite(result["x"]).all()


def test_a_name_passes_to_the_next_device_that_has_it(tmp_path):
    patch = Patch()
    for name in ("first", "second"):
        patch.sub(name).obj("inlet")
    for ms, name, mm in ((10, "first", 10), (20, "second", -20)):
        patch.send(ms, f"pd-{name}",
                   f"obj 10 10 phantom -hand rigid -path line {mm} 0 0 {mm} 0 0 1000")
    patch.send(500, "pd-first", "clear")
    signals = patch.obj("phantom~")
    patch.record("x", signals)
    x = patch.render(1)["x"]
    assert x[round(0.45 * RATE)] == pytest.approx(0.6, abs=1e-6)
    assert x[round(0.95 * RATE)] == pytest.approx(0.3, abs=1e-6)


def test_a_second_listener_is_refused_once(tmp_path):
    patch = Patch()
    patch.obj("phantom", "-name", "hand")
    for _ in range(2):
        patch.obj("phantom~", "hand")
    result = patch.render(0.5, expect_errors=["phantom~: name hand: another phantom~ has this"])
    assert len(result.errors) == 1


def test_a_name_that_no_phantom_has_is_told_once_in_pds_window(tmp_path):
    patch = Patch()
    patch.obj("phantom", "-name", "hand")
    patch.obj("phantom~", "hnad")
    patch.obj("phantom~", "hand")
    output = patch.render(5).output
    # Without a window Pd writes the level in front; above 2 its window would hide the line.
    assert len(re.findall(r"^(?:verbose\(2\): )?phantom~: name hnad: still waiting for a phantom", output, re.M)) == 1
    assert output.count("waiting") == 1


def test_the_clock_steps_again_when_the_sound_is_off(tmp_path):
    patch = Patch()
    box = patch.obj("phantom", "-name", "hand")
    patch.obj("phantom~", "hand")
    patch.log("info", box[3])
    for ms in (900, 1900):
        patch.at(ms, box, "stats")
    patch.send(1000, "pd", "dsp 0")
    result = patch.render(2)
    ticks = [atoms[2] for _, atoms in result.logs["info"] if atoms[:2] == ["stats", "ticks"]]
    assert ticks[0] == pytest.approx(900, abs=4)
    assert ticks[1] == pytest.approx(1900, abs=40)
