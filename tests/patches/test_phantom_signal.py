"""[phantom~]: audio meets the servo of a [phantom], in a headless Pd."""
import re

import numpy
import pytest

from harness import Patch, read_trace
from harness.sound import RATE

T = numpy.arange(RATE) / RATE


def scene(folder, *options, block=64, force=(), vibration=None, device="", seconds=0.5, rate=RATE, messages=(),
          rebuilds=()):
    """One [phantom] named hand and one [phantom~] on it; every servo tick traced into ticks.csv."""
    patch = Patch(block=block)
    box = patch.obj("phantom", "-name", "hand", *device.split())
    patch.at(0, box, f"trace {folder}/ticks.csv")
    for ms, message in messages:
        patch.at(ms, box, message)
    signals = patch.obj("phantom~", "hand", *options)
    for inlet, samples in [*enumerate(force), (3, vibration)]:
        if samples is not None:
            patch.signal(samples) >> signals[inlet]
    for label, outlet in (("x", 0), ("y", 1), ("z", 2), ("vx", 4), ("left", 7), ("right", 8)):
        patch.record(label, signals[outlet])
    for ms in rebuilds:
        patch.rebuild_dsp(ms)
    patch.at(1000 * seconds - 2, box, "trace stop")
    return patch.render(seconds, rate=rate), read_trace(folder / "ticks.csv")


def ramp(newton):
    return numpy.linspace(0, newton, RATE, dtype=numpy.float32)


def test_each_tick_reads_the_sample_at_which_it_falls_due(tmp_path):
    force = ramp(4)
    _, rows = scene(tmp_path, force=[force, 0.5 * force], device="-hand rigid")
    assert int(numpy.argmax(rows["fx_n"] > 0)) <= 4
    heard = force[numpy.rint(48 * rows["ms"][4:404]).astype(int)]
    for axis, share in (("fx_n", 1), ("fy_n", 0.5)):
        assert rows[axis][4:404] == pytest.approx(share * heard, abs=1e-6)


@pytest.mark.parametrize("rate", [44100, 48000])
def test_the_servo_s_clock_is_the_patch_s_with_phantom_tilde_and_without(tmp_path, rate):
    """The same ticks at the same times meet the same plane; made later, paused and in larger blocks, too."""
    found = {}
    for name, block, ms in (("alone", 64, None), ("beside", 64, 0), ("small", 16, 0), ("large", 1024, 0), ("late", 64, 123.4)):
        patch = Patch(block=block)
        if ms:
            patch.sub("late").obj("inlet")
            patch.send(ms, "pd-late", "obj 10 10 phantom~ hand")
        box = patch.obj("phantom", "-name", "hand", *"-hand rigid -path line 0 0 5 0 0 -5 200".split())
        patch.at(0, box, f"scene add wall plane 0 0 1 0, trace {tmp_path}/{name}.csv")
        if ms == 0:
            patch.obj("phantom~", "hand")
        patch.at(398, box, "trace stop")
        patch.render(0.4, rate=rate)
        rows = read_trace(tmp_path / f"{name}.csv")
        found[name] = {column: rows[column][:380] for column in ("tick", "ms", "x_mm", "z_mm", "fz_n")}
    for name, rows in found.items():
        assert rows["ms"] == pytest.approx(rows["tick"], abs=1e-9), name
        assert rows["z_mm"] == pytest.approx(found["alone"]["z_mm"], abs=1e-9), name
        assert rows["fz_n"] == pytest.approx(found["alone"]["fz_n"], abs=1e-7), name


def test_positions_are_the_ticks_joined_by_straight_lines_one_period_late(tmp_path):
    result, rows = scene(tmp_path, "-vel 1", device="-hand rigid -path lissajous 0 0 0 40 20 10 3 2 1")
    heard = (result["x"] - 0.5) * 100
    # At sample 48 k tick k is stepped and the position of tick k - 1 is reached.
    reached = numpy.rint(48 * (rows["ms"][2:400] + 1)).astype(int)
    positions = heard[reached]
    assert positions == pytest.approx(rows["x_mm"][2:400], abs=1e-4)
    between = numpy.linspace(positions[99], positions[100], 48, endpoint=False)
    assert heard[reached[99]:reached[100]] == pytest.approx(between, abs=1e-4)
    assert result["vx"][reached] == pytest.approx(rows["vx_m_per_s"][2:400], abs=1e-5)


def test_blocks_of_any_size_give_the_same_samples_and_ticks(tmp_path):
    """A force that sings, a hand that yields, a string that it touches: every sample and every tick the same bits."""
    force = (1.5 * numpy.sin(2 * numpy.pi * 7 * T)).astype(numpy.float32)
    string = [(0, "network string s 19 -50 0 0 50 0 0 0.001 10 0.0005, network listen s-4 z, network touch 8 300 0.2"),
              (0, "network listen s-9 y 2 displacement")]
    seen, end = set(), 400  # ticks; a large block runs ahead of the patch's clock
    for block in (1, 64, 1024, 4096):
        result, _ = scene(tmp_path, block=block, force=[force, None, 0.3 * force], seconds=0.6, messages=string,
                          device="-hand spring 300 3 -path circle 0 0 5 10 200 xz")
        assert numpy.abs(result["left"][:48 * end]).max() > 1e-3
        rows = (tmp_path / "ticks.csv").read_text().splitlines()[1:end]
        seen.add((*(result[name][:48 * end].tobytes() for name in ("x", "y", "z", "left", "right")), tuple(rows)))
    assert len(seen) == 1


def test_rebuilding_the_graph_moves_no_tick(tmp_path):
    rows = []
    for rebuilds in ((), (100, 101, 155, 300)):
        scene(tmp_path, force=[ramp(4)], device="-hand rigid", rebuilds=rebuilds)
        rows.append((tmp_path / "ticks.csv").read_text())
    assert rows[0] == rows[1]


@pytest.mark.parametrize("rate", [44100, 96000])
def test_other_sample_rates_keep_the_servo_s_thousand_ticks(tmp_path, rate):
    ms = scene(tmp_path, device="-hand rigid", rate=rate)[1]["ms"]
    assert len(ms) == pytest.approx(498, abs=3)
    assert numpy.diff(ms) == pytest.approx(numpy.ones(len(ms) - 1), abs=1e-6)


def test_signals_and_numbers_add_up(tmp_path):
    _, rows = scene(tmp_path, force=[numpy.full(RATE, 0.5, dtype=numpy.float32)], device="-hand rigid -interp off",
                    messages=[(100, "list 1 2 0"), (300, "list -0.5 0 0")])
    for ms, force in ((90, (0.5, 0)), (200, (1.5, 2)), (400, (0, 0))):
        at = int(numpy.argmin(abs(rows["ms"] - ms)))
        assert (rows["fx_n"][at], rows["fy_n"][at]) == pytest.approx(force, abs=1e-6)


def test_what_is_no_number_is_no_force_for_that_tick(tmp_path):
    force = numpy.ones(RATE, dtype=numpy.float32)
    force[48 * 200 - 20:48 * 200 + 20] = numpy.nan
    force[48 * 300 - 20:48 * 300 + 20] = numpy.inf
    forces = scene(tmp_path, force=[force], device="-hand rigid -slew 1000")[1]["fx_n"].tolist()
    assert set(forces[10:]) == {0.0, 1.0} and forces[10:].count(0.0) == 2


def shaken(folder, z, hertz, newton, *options):
    """The force along z on a hand at that height over a plane, N, whose vibration is a sine."""
    vibration = (newton * numpy.sin(2 * numpy.pi * hertz * T)).astype(numpy.float32)
    _, rows = scene(folder, *options, vibration=vibration, messages=[(0, "scene add wall plane 0 0 1 0")],
                    device=f"-hand rigid -path line 0 0 {z} 0 0 {z} 1000 -passivity 0 -slew 1000")
    return rows["fz_n"][100:450]


def test_vibration_acts_along_the_normal_of_what_is_touched_and_only_then(tmp_path):
    touching, away, free = shaken(tmp_path, -2, 200, 0.4), shaken(tmp_path, 2, 200, 0.4), shaken(
        tmp_path, 2, 200, 0.4, "-gate 0")
    assert touching.mean() == pytest.approx(1, abs=0.01)
    assert touching.std() * 2 ** 0.5 == pytest.approx(0.4, rel=0.02)
    assert not away.any()
    assert free.std() * 2 ** 0.5 == pytest.approx(0.4, rel=0.02)


@pytest.mark.parametrize("hertz, decibel, tolerance", [(400, -3.01, 0.2), (800, -48.2, 0.7)])
def test_vibration_beyond_the_servo_s_rate_does_not_alias(tmp_path, hertz, decibel, tolerance):
    """Butterworth of the eighth order at 400 Hz: 800 Hz, heard as 200, is 48 dB down."""
    level = 20 * numpy.log10((shaken(tmp_path, -2, hertz, 0.5) - 1).std() * 2 ** 0.5 / 0.5)
    assert level == pytest.approx(decibel, abs=tolerance)


# ---- how the two find each other -------------------------------------------------------------

def test_the_two_find_each_other_and_part_in_either_order():
    """Sub-patches made and cleared while the sound runs, device first and signals first."""
    patch = Patch()
    patch.sub("stage").obj("inlet")
    for ms, message in [(10, "obj 10 10 phantom -name late"), (400, "obj 10 50 phantom~ late"), (700, "clear"),
                        (800, "obj 10 50 phantom~ late"), (1000, "obj 10 10 phantom -name late"),
                        (1400, "obj 10 90 phantom~ late"), (1700, "clear"), (1900, "obj 10 10 phantom~")]:
        patch.send(ms, "pd-stage", message)
    outside = patch.obj("phantom~", "late")
    patch.log("status", outside[3])
    patch.record("x", outside[0])
    result = patch.render(2.2, expect_errors=["another phantom~ already uses this phantom"])
    assert [atoms[:2] for _, atoms in result.logs["status"]] == [["status", word] for word in 2 * ("attached", "waiting")]


def test_a_name_passes_to_the_next_device_that_has_it():
    patch = Patch()
    for ms, name, mm in ((10, "first", 10), (20, "second", -20)):
        patch.sub(name).obj("inlet")
        patch.send(ms, f"pd-{name}", f"obj 10 10 phantom -hand rigid -path line {mm} 0 0 {mm} 0 0 1000")
    patch.send(500, "pd-first", "clear")
    patch.record("x", patch.obj("phantom~"))
    x = patch.render(1)["x"]
    assert x[[round(0.45 * RATE), round(0.95 * RATE)]] == pytest.approx([0.6, 0.3], abs=1e-6)


def test_a_second_listener_is_refused_and_a_name_that_no_phantom_has_is_told_once():
    patch = Patch()
    patch.obj("phantom", "-name", "hand")
    for name in ("hnad", "hand", "hand"):
        patch.obj("phantom~", name)
    result = patch.render(5, expect_errors=["phantom~: name hand: another phantom~ already uses this"])
    assert len(result.errors) == 1
    # Without a window Pd writes the level in front; above 2 its window would hide the line.
    told = re.findall(r"^(?:verbose\(2\): )?phantom~: name hnad: no phantom of this name", result.output, re.M)
    assert len(told) == 1 and result.output.count("found yet") == 1


def test_the_clock_steps_again_when_the_sound_is_off():
    patch = Patch()
    box = patch.obj("phantom", "-name", "hand")
    patch.obj("phantom~", "hand")
    patch.log("info", box[3])
    for ms in (900, 1900):
        patch.at(ms, box, "stats")
    patch.send(1000, "pd", "dsp 0")
    ticks = [atoms[2] for _, atoms in patch.render(2).logs["info"] if atoms[:2] == ["stats", "ticks"]]
    assert ticks[0] == pytest.approx(900, abs=4) and ticks[1] == pytest.approx(1900, abs=40)
