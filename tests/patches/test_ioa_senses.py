"""The modules of patches/audiohaptics/ioa that make sound, force and files."""
import numpy
import pytest
import scipy.io.wavfile

from harness import Patch
from ioa_system import NEEDS_DISK, System, hits, of, render, rows, taps

needs_disk = pytest.mark.skipif(NEEDS_DISK, reason="the disk's table is made where modal_fem is built")


# ---- contents, sound, listener --------------------------------------------------------------------

@needs_disk
@pytest.mark.parametrize("rate, server, latency", [
    (44100, "ioa_is", 0), (48000, "ioa_is_pd", 3), pytest.param(96000, "ioa_is", 3, marks=pytest.mark.slow),
    pytest.param(96000, "ioa_is_pd", 0, marks=pytest.mark.slow)])
def test_the_sound_begins_at_the_sample_of_the_servos_tick_or_late_by_the_latency(tmp_path, rate, server, latency):
    script = taps(tmp_path / "hand.txt", (25, 0), (0, 30), (-40, 5))
    result = render(0.5, script, rate=rate, **{"is": server}, messages=[
        (0, "bus", "model set disk choke 0.01"), (0, "r_modal", f"latency {latency}")])
    force = result["lab.contact_force"]
    assert len(hits(result)) == 3
    for t, _ in hits(result):
        sample = round((t + latency) * rate / 1000)
        assert not force[sample - 48:sample].any()
        assert force[sample:sample + 2].any()


@needs_disk
def test_thrown_balls_fall_back_by_the_law_of_gravity(tmp_path):
    script = taps(tmp_path / "hand.txt", (25, 0))
    result = render(1.0, script, cs=["ioa_cs_physics", "disk", "disk.modal.npz"],
                    messages=[(0, "cs", "restitution 0.7"), (0, "cs", "gravity 1.62")])
    struck = of(result, "lab", "excite")
    (hit,) = of(result, "lab", "hit")
    speed = hit[8] * 0.7 ** numpy.arange(len(struck))
    assert [e[5] for e in struck] == pytest.approx(speed, rel=1e-5)
    flights = 2 * speed[1:] / 1.62 * 1000
    assert numpy.diff([e[0] for e in struck]) == pytest.approx(flights, abs=1e-2)
    assert all(e[1:5] == ["disk", *hit[2:5]] for e in struck)


def test_the_speaker_is_at_the_hand_or_fixed(tmp_path):
    script = rows(tmp_path / "hand.txt", (0, 0, 0, 30), (100, 50, 10, 30))
    result = render(0.1, script, r_modal=None, messages=[(1, "mm_sound", "speaker hand 1 2 3")])
    moving = [p for p in of(result, "lab", "listener") if 1 < p[0] < 100]
    assert 8 <= len(moving) <= 11  # at most one in 10 ms
    for t, *position in moving:
        assert position == pytest.approx([t / 2 + 1, t / 10 + 2, 33], abs=1e-4)
    result = render(0.1, script, r_modal=None, messages=[(1, "mm_sound", "speaker 0 200 400")])
    assert of(result, "lab", "listener")[-1][1:] == [0, 200, 400]


def test_a_hit_becomes_a_mark_by_the_root_of_its_speed(tmp_path):
    result = render(0.3, taps(tmp_path / "hand.txt", (25, 0), speed=0.36), r_modal=None)
    (mark,) = of(result, "lab", "mark")
    assert mark[1:] == ["disk", pytest.approx(25), 0, pytest.approx(6), pytest.approx(20 * 0.6, rel=1e-3)]


# ---- force -----------------------------------------------------------------------------------------

def test_a_hand_on_a_spring_is_held_back_by_the_disk(tmp_path):
    patch = Patch()
    system = System(patch, sdd="ioa_sdd_phantom", r_modal=None)
    patch.at(0, system.box["sdd"], "hand spring 300 4, path line 25 0 20 25 0 -6 1000000")
    patch.at(500, system.box["sdd"], "seek 500000")
    patch.log("info", patch.obj("r", "lab.phantom-info"))
    result = patch.render(1.5)
    depth = of(result, "lab", "contact")[-1]
    # 300 N/m pull 12 mm - d against 900 N/m: d = 12 * 300 / 1200 = 3 mm, 2.7 N
    assert depth[2] == pytest.approx(3, abs=0.02) and depth[5] == pytest.approx(2.7, abs=0.02)


def test_files_take_the_place_of_motors_and_loudspeakers(tmp_path):
    patch = Patch()
    system = System(patch, sdd=["ioa_sdd_script", taps(tmp_path / "hand.txt", (25, 0))],
                    ddd=["ioa_ddd_file"], r_modal=None)
    tone = patch.obj("osc~ 440")
    tone >> system.box["ddd"][0]
    tone >> system.box["ddd"][1]
    patch.at(0, system.box["sdd"], "bang")
    patch.at(5, system.box["ddd"][2], "stop")  # nothing is recorded yet
    patch.at(10, system.box["ddd"][2], f"start {tmp_path}/take 0.25")
    patch.at(350, system.box["ddd"][2], "stop")  # nor any more
    patch.log("ended", system.box["ddd"][0])
    ended = patch.render(0.4).logs["ended"]
    assert [ms for ms, _ in ended] == [pytest.approx(260, abs=2)]
    rate, sound = scipy.io.wavfile.read(tmp_path / "take.wav")
    assert rate == 48000 and sound.shape == (12000, 2) and abs(sound).max() == pytest.approx(1, abs=0.01)
    lines = (tmp_path / "take.txt").read_text().splitlines()
    assert {line.split()[0] for line in lines} == {"hit", "contact", "release", "excite"}


def test_forces_stop_when_none_comes_for_100_ms(tmp_path):
    patch = Patch()
    sensor, driver = patch.obj("ioa_sdd_phantom", "lab"), patch.obj("ioa_ddd_phantom", "lab")
    patch.at(0, sensor, "hand rigid")
    patch.at(10, patch.obj("ioa_bus", "lab"), "force 10 0 1.5 0")
    patch.log("info", patch.obj("r", "lab.phantom-info"))
    for ms in (100, 200):
        patch.at(ms, driver, "bang")
    found = [a[1:] for _, a in patch.render(0.25).logs["info"] if a[0] == "force"]
    assert found[0] == pytest.approx([0, 1.5, 0], abs=1e-3) and found[-1] == [0, 0, 0]


@pytest.mark.parametrize("message, end", [("path hand.txt", (9, 8, 7)), ("path line 1 2 3 4 5 6 100", (4, 5, 6))])
def test_the_devices_path_is_a_file_beside_the_patch_that_uses_the_module(tmp_path, message, end):
    (tmp_path / "patch").mkdir()
    rows(tmp_path / "patch" / "hand.txt", (0, 1, 2, 3), (100, *end))
    patch = Patch()
    sensor = patch.obj("ioa_sdd_phantom", "lab")
    patch.log("raw", sensor)
    patch.at(10, patch.obj("s", "lab.phantom"), "hand rigid")
    patch.at(10, patch.obj("s", "lab.phantom"), message)
    raw = [atoms for _, atoms in patch.render(0.4, keep=tmp_path / "patch").logs["raw"] if atoms[0] == "raw"]
    positions = numpy.array([atoms[2:5] for atoms in raw], float)
    assert numpy.abs(positions - end).sum(1).min() < 0.2
