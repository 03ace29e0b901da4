"""[modal_impact~] in Pd: a plate from a closed form, struck, pushed, exchanged and misused."""
import json
import os
import pathlib
import subprocess

import numpy
import pytest
from harness import Patch, stage_folder

RATE = 48000


def table(path, **changes):
    """A square membrane of a plate with three modes, as numpy.savez writes it; changes replace
    arrays, None leaves one out."""
    n = 9
    x, y = numpy.meshgrid(numpy.linspace(-.1, .1, n), numpy.linspace(-.1, .1, n))
    xyz = numpy.stack([x.ravel(), y.ravel(), 0 * x.ravel()], 1)
    tri = []
    for k in range(n - 1):
        for i in range(n - 1):
            p = k * n + i
            tri += [[p, p + 1, p + n + 1], [p, p + n + 1, p + n]]
    phi = numpy.zeros((3, n * n, 3))
    for k, (a, b) in enumerate([(1, 1), (2, 1), (2, 2)]):
        phi[k, :, 2] = (5 * numpy.sin(a * numpy.pi * (xyz[:, 0] / .2 + .5))
                        * numpy.sin(b * numpy.pi * (xyz[:, 1] / .2 + .5)))
    meta = {"format": "modal-table", "version": "1.0", "body_name": "square", "bc": "held edges",
            "material": {"name": "glass", "E": 6.2e10, "nu": 0.2, "rho": 2600}}
    arrays = {"meta": numpy.frombuffer(json.dumps(meta).encode(), dtype=numpy.uint8),
              "freq": numpy.array([400.0, 1000.0, 1600.0]), "eta": numpy.full(3, 2e-3),
              "phi": phi.astype("f4"), "xyz": xyz.astype("f4"), "tri": numpy.array(tri, "i4"),
              "mass": numpy.array(0.3), "com": numpy.zeros(3), "inertia": numpy.eye(3) * 1e-3}
    arrays.update(changes)
    with open(path, "wb") as file:
        numpy.savez(file, **{k: v for k, v in arrays.items() if v is not None})
    return path


def struck(folder, *arguments, block=64):
    table(folder / "square.modal.npz")
    patch = Patch(block=block)
    box = patch.obj("modal_impact~", "square.modal.npz", "-sync", 1, *arguments)
    for i, name in enumerate(["left", "right", "contact"]):
        patch.record(name, box[i])
    patch.log("info", box[3])
    return patch, box


def test_an_impact_rings_at_the_tables_frequencies_and_has_the_balls_impulse(tmp_path):
    patch, box = struck(tmp_path)
    patch.at(100, box, "hit 30 40 0 1")
    result = patch.render(1.5, path=[tmp_path])
    sound = result["left"][RATE // 2:]
    spectrum = abs(numpy.fft.rfft(sound * numpy.hanning(len(sound)), 1 << 19))
    for expected in (400, 1000, 1600):
        near = slice(int((expected - 20) * (1 << 19) / RATE), int((expected + 20) * (1 << 19) / RATE))
        peak = (spectrum[near].argmax() + near.start) * RATE / (1 << 19)
        assert abs(peak - expected) < 0.05
    impulse = result["contact"].sum() / RATE
    assert 0.0071 < impulse < 2 * 0.0071
    assert not result["left"][:4700].any()


def test_two_more_listeners_come_out_right_of_the_info_outlet(tmp_path):
    def play(listeners):
        patch, box = struck(tmp_path, "-radiation", "none", "-out", listeners)
        patch.record("third", box[4])
        patch.record("fourth", box[5])
        # Listeners 2 and 4 at one place, where the even mode along x is still.
        for i, position in enumerate(["30 40 100", "0 40 100", "-30 40 100", "0 40 100"]):
            patch.at(10, box, f"listener {i + 1} {position}")
        patch.at(100, box, "hit 30 40 0 1")
        return patch.render(0.5, path=[tmp_path])
    four, two = play(4), play(2)
    assert abs(four["third"]).max() > 0
    assert (four["fourth"] == four["right"]).all()
    assert not (four["third"] == four["left"]).all()
    assert (four["left"] == two["left"]).all()
    assert not two["third"].any() and not two["fourth"].any()


def test_a_render_repeats_to_the_bit_at_any_block_size(tmp_path):
    def play(block):
        patch, box = struck(tmp_path, block=block)
        patch.at(64 * 64000 / 48000, box, "hit 30 40 0 1")
        return patch.render(1, path=[tmp_path])["left"]
    first = play(64)
    assert abs(first).max() > 0
    assert (first == play(64)).all()


def test_a_hundred_loads_while_it_sounds(tmp_path):
    patch, box = struck(tmp_path)
    table(tmp_path / "other.modal.npz", freq=numpy.array([300.0, 700.0, 900.0]))
    for i in range(100):
        patch.at(20 + 10 * i, box, f"load {['square', 'other'][i % 2]}.modal.npz")
        patch.at(25 + 10 * i, box, "hit 30 40 0 1")
    result = patch.render(1.2, path=[tmp_path])
    assert abs(result["left"]).max() > 0


def test_a_load_in_the_background_comes_in_while_the_old_body_sounds(tmp_path):
    table(tmp_path / "square.modal.npz")
    patch = Patch()
    box = patch.obj("modal_impact~")
    patch.log("info", box[3])
    for i in range(40):
        patch.at(10 + 100 * i, box, "load square.modal.npz")
    patch.end_on(box[3], "loaded")
    result = patch.render(1e6, path=[tmp_path], timeout=120)
    assert any(atoms[0] == "loaded" for _, atoms in result.logs["info"])


@pytest.mark.parametrize("changes, sentence", [
    ({"freq": numpy.array([400.0, 300.0, 1600.0])}, "'freq' must ascend"),
    ({"freq": numpy.array([400.0, numpy.nan, 1600.0])}, "not finite"),
    ({"freq": None}, "'freq' is missing"),
    ({"phi": numpy.zeros((3, 81, 3), "f4")}, "'phi' is all zero"),
    ({"tri": numpy.full((4, 3), 81, "i4")}, "a corner 81 of 81"),
    ({"mass": numpy.array(-1.0)}, "mass"),
    ({"meta": numpy.frombuffer(b"{", dtype=numpy.uint8)}, "not JSON"),
])
def test_a_bad_table_is_refused_with_a_sentence_and_the_old_body_goes_on(tmp_path, changes, sentence):
    patch, box = struck(tmp_path)
    table(tmp_path / "bad.modal.npz", **changes)
    patch.at(50, box, "load bad.modal.npz")
    patch.at(100, box, "hit 30 40 0 1")
    result = patch.render(0.3, path=[tmp_path],
                          expect_errors=[f"modal_impact~: load bad.modal.npz: .*{sentence}"])
    assert abs(result["left"]).max() > 0
    assert len(result.errors) == 1


def test_numpys_other_layouts_are_read_and_compressed_ones_refused(tmp_path):
    table(tmp_path / "odd.modal.npz", freq=numpy.array([400.0, 1000.0, 1600.0], ">f8"),
          xyz=numpy.asfortranarray(numpy.load(table(tmp_path / "square.modal.npz"))["xyz"]))
    patch, box = struck(tmp_path)
    patch.at(20, box, "load odd.modal.npz")
    patch.at(30, box, "hit 30 40 0 1")
    assert abs(patch.render(0.3, path=[tmp_path])["left"]).max() > 0
    with open(tmp_path / "small.modal.npz", "wb") as file:
        numpy.savez_compressed(file, **numpy.load(tmp_path / "square.modal.npz"))
    patch, box = struck(tmp_path)
    patch.at(20, box, "load small.modal.npz")
    patch.render(0.1, path=[tmp_path], expect_errors=["small.modal.npz: .*compressed"])


@pytest.mark.parametrize("message, sentence", [
    ("hit 30 40 0 -1", "hit: v -1 m/s: expected 1e-06..50"),
    ("hit 30 40 0 nan", "hit 30 40 0 nan: expected numbers"),
    ("hit 1 2", "hit: expected v, or x y z v"),
    ("hitv 81 1", "hitv: vertex 81: expected 0..80"),
    ("hitf 0 0.7 0.7 1", "hitf: v 0.7: expected 0..0.3"),
    ("load nowhere.npz", "load nowhere.npz: there is no such file"),
    ("preset jelly", "preset jelly: expected aluminium"),
    ("listener 5 0 0 0", "listener: i 5: expected 1..4"),
    ("losscurve 100 0.1 50 0.1", "losscurve: f 50"),
    ("striker 0 0 0 0", "striker: mass 0 kg"),
])
def test_misuse_is_one_sentence_and_changes_nothing(tmp_path, message, sentence):
    patch, box = struck(tmp_path)
    patch.at(50, box, message)
    patch.at(100, box, "hit 30 40 0 1")
    result = patch.render(0.3, path=[tmp_path], expect_errors=["modal_impact~: " + sentence])
    assert len(result.errors) == 1
    assert abs(result["left"]).max() > 0


def test_a_gain_of_creation_holds_from_the_first_strike(tmp_path):
    def play(gain):
        patch, box = struck(tmp_path, "-gain", gain)
        patch.at(1.4, box, "hit 30 40 0 1")
        return patch.render(0.1, path=[tmp_path])["left"]
    loud, quiet = play(0.1), play(0.001)
    assert abs(100 * quiet - loud).max() < 1e-5 * abs(loud).max()


def far_from_tones(sound, tones, width):
    """Energy further than `width` Hz from all tones against the rest, dB."""
    spectrum = abs(numpy.fft.rfft(sound * numpy.blackman(len(sound)))) ** 2
    f = numpy.arange(len(spectrum)) * RATE / len(sound)
    far = numpy.min([abs(f - tone) for tone in tones], axis=0) > width
    return 10 * numpy.log10(spectrum[far].sum() / spectrum.sum())


@pytest.mark.parametrize("every", [pytest.param(1, marks=pytest.mark.slow), 4 / 3, 5, 37])
@pytest.mark.parametrize("doppler", [0, 1])
@pytest.mark.parametrize("jumps", [False, True])
def test_a_moving_listener_never_clicks(tmp_path, every, doppler, jumps):
    # Far from the edges of a mode's tone there is what a slow motion gives: nothing.
    table(tmp_path / "one.modal.npz", freq=numpy.array([400.0, 401.0, 402.0]), eta=numpy.full(3, 1e-4))
    patch = Patch()
    box = patch.obj("modal_impact~", "one.modal.npz", "-sync", 1, "-doppler", doppler)
    patch.record("left", box[0])
    patch.at(10, box, "hit 30 40 0 1")
    random = numpy.random.default_rng(2)
    for i in range(int(400 / every)):
        t = every * i / 1000
        position = (random.uniform([-2000, -2000, -900], [2000, 2000, 1100]) if jumps
                 else [400 * numpy.cos(2 * t), 100, 300 + 500 * t])
        patch.at(100 + every * i, box, "listener 1 " + " ".join(f"{x:.3f}" for x in position))
    sound = patch.render(0.5, path=[tmp_path])["left"][int(0.1 * RATE):int(0.5 * RATE)]
    assert far_from_tones(sound, [401], 1000 if jumps else 200) < -60


@pytest.mark.parametrize("message", ["reset", "load other.modal.npz"])
def test_silence_and_another_body_come_without_a_click(tmp_path, message):
    for name in ("one", "other"):
        table(tmp_path / f"{name}.modal.npz", freq=numpy.array([400.0, 401.0, 402.0]),
              eta=numpy.full(3, 1e-4))
    patch = Patch()
    box = patch.obj("modal_impact~", "one.modal.npz", "-sync", 1)
    patch.record("left", box[0])
    patch.at(10, box, "hit 30 40 0 1")
    patch.at(300, box, message)
    sound = patch.render(0.5, path=[tmp_path])["left"][int(0.1 * RATE):]
    assert far_from_tones(sound, [401], 1000) < -60
    assert abs(sound[-4800:]).max() < 1e-4 * abs(sound).max()


def test_force_at_the_inlet_rings_the_body_and_a_pressed_hand_feels_it(tmp_path):
    patch, box = struck(tmp_path, "-pos", 1)
    patch.at(5, box, "hardness 1e5 1")
    patch.at(6, box, "point 30 40 0")
    patch.at(7, box, "loss 0.2")
    t = numpy.arange(RATE) / RATE
    patch.signal(numpy.where(t < 0.1, 5 * numpy.sin(2 * numpy.pi * 400 * t), 0)) >> box[0]
    height = numpy.where((t > 0.5) & (t < 0.9), -1e-4, 1e-3)
    patch.signal(numpy.interp(t, t[::480], height[::480])) >> box[1]
    result = patch.render(1, path=[tmp_path])
    assert abs(result["left"][4800:9600]).max() > 1e-3
    pressed = result["contact"][int(0.7 * RATE):int(0.85 * RATE)].mean()
    # 0.1 mm against the spring of 1e5 N/m and the body's own compliance behind it.
    assert 5 < pressed < 10
    assert result["contact"][:int(0.45 * RATE)].max() == 0


def test_the_module_needs_neither_finite_elements_nor_meshers_nor_hdf5():
    module = next(stage_folder().glob("modal_impact~.l_*"))
    needs = subprocess.run(["ldd", module], check=True, capture_output=True, text=True).stdout
    for library in ("fem", "gmsh", "hdf5", "cholmod", "blas", "faust"):
        assert library not in needs


@pytest.mark.parametrize("block", [1, 16, 1024, 4096])
def test_any_block_size_gives_the_same_impact(tmp_path, block):
    def play(size):
        patch, box = struck(tmp_path, block=size)
        patch.at(0, box, "hit 30 40 0 1")
        return patch.render(0.4, path=[tmp_path])["left"]
    ours, reference = play(block), play(64)
    length = 16384 - max(block, 64)
    start = [int(numpy.argmax(abs(x) > 1e-6 * abs(x).max())) for x in (ours, reference)]
    a, b = (x[s:s + length // 2] for x, s in zip((ours, reference), start))
    assert abs(a - b).max() < 1e-6 * abs(b).max()


def test_a_dropped_ball_bounces_until_it_lies(tmp_path):
    patch, box = struck(tmp_path, "-restitution", 0.5)
    patch.at(100, box, "drop 30 40 0 20")
    contact = patch.render(1.5, path=[tmp_path])["contact"]
    hit = numpy.flatnonzero(contact > 0)
    onsets = hit[numpy.flatnonzero(numpy.diff(hit, prepend=-10000) > 500)]
    assert len(onsets) >= 3
    speed = (2 * 9.80665 * 0.02) ** 0.5
    # Restitution limits the first bounce; of the later ones the swinging plate throws some higher.
    flight = numpy.diff(onsets) / RATE
    assert (flight < 2 * 0.5 * speed / 9.80665 + 0.002).all()
    assert not contact[RATE:].any()


@pytest.mark.parametrize("wrong, sentence", [("drop 1 2", "drop: expected h, or x y z h"),
                                             ("drop -5", "drop: h -5 mm: expected"),
                                             ("drop 0 0 0 1e9", "drop: h 1e.09 mm: expected"),
                                             ("drop 0 0 0 high", "drop 0 0 0 high: expected numbers")])
def test_a_drop_from_nowhere_is_refused(tmp_path, wrong, sentence):
    patch, box = struck(tmp_path)
    patch.at(50, box, wrong)
    result = patch.render(0.2, path=[tmp_path], expect_errors=["modal_impact~: " + sentence])
    assert not result["left"].any()


def test_the_help_patchs_hammer_strikes_at_the_speed_it_is_thrown_with():
    patch = Patch(opens=[stage_folder() / "modal_impact~-help.pd"], own="help")
    patch.log("hits", patch.obj("r", "help-help") >> patch.obj("route", "hit"))
    for ms, height_mm in [(300, 120), (310, 100), (330, 40), (350, 0), (600, 90), (640, 0)]:
        patch.send(ms, "help-hammer", height_mm)
    hits = [line for _, line in patch.render(1.0).logs["hits"]]
    # 60 mm in 20 ms; 90 mm in 40 ms
    assert [hit[-1] for hit in hits] == pytest.approx([3.0, 2.25], rel=0.05)


def strikes(folder, block, times, message, arguments=(), rate=RATE, seconds=0.6):
    """Contact force and sound of strikes at these logical ms, from a window of that block size; the
    first sample recorded is the block's whose end comes first after time 0."""
    table(folder / "square.modal.npz")
    patch = Patch()
    window = patch.sub("inner", block=block)
    box = window.obj("modal_impact~", "square.modal.npz", "-sync", 1, *arguments)
    window.at(0, box, "striker 0.0005 0.003 2.06e11 0.29")
    for ms in times:
        window.at(ms, box, message)
    window.record("left", box[0])
    window.record("contact", box[2])
    return patch.render(seconds, rate=rate, path=[folder])


TIMES = [7.3, 31.07, 90, 90.4, 111.11, 200.02]


@pytest.mark.parametrize("message", ["hit 30 40 0 .2", "hitv 40 .2", "hitf 20 .2 .3 .2", "bang"])
def test_strikes_land_at_the_samples_of_their_messages_in_any_block_size(tmp_path, message):
    results = {}
    for block in (1, 16, 64, 256, 4096):
        result = strikes(tmp_path, block, TIMES, message)
        force = numpy.flatnonzero(result["contact"])
        assert len(force)
        first = force[0]
        # A block is recorded from the start of the window's first whole one: one shift for all.
        shift = first - round(TIMES[0] * RATE / 1000)
        assert -1 <= shift <= max(block, 64)
        begun = force[numpy.flatnonzero(numpy.diff(force, prepend=-100) > 5)] - shift
        for ms in TIMES:
            assert abs(begun - ms * RATE / 1000).min() <= 1
        results[block] = result["left"][first:first + 16384], result["contact"][first:first + 16384]
    for block, (sound, contact) in results.items():
        assert numpy.array_equal(sound, results[64][0]), block
        assert numpy.array_equal(contact, results[64][1]), block


@pytest.mark.parametrize("block", ["64 1 2", "64 1 0.5", "512 1 4", "1024 4 1"])
def test_strikes_land_at_their_samples_in_windows_at_another_rate(tmp_path, block):
    size, overlap, rate = (float(x) for x in block.split())
    factor = rate * overlap
    result = strikes(tmp_path, block, TIMES, "hit 30 40 0 .2", seconds=1)
    # Recorded sample by sample of the window.
    force = numpy.flatnonzero(result["contact"])
    begun = force[numpy.flatnonzero(numpy.diff(force, prepend=-100) > 5)]
    expected = numpy.array(TIMES) * RATE / 1000 * factor
    expected = expected[expected < len(result["contact"]) - 2 * size * factor]
    shift = begun[0] - expected[0]
    for sample in expected - expected[0]:
        assert abs(begun - begun[0] - sample).min() <= 1 + 0.5 * factor
    assert -1 <= shift <= max(size, 64 * factor) + 1


def test_a_roll_every_three_milliseconds_has_no_jitter(tmp_path):
    table(tmp_path / "square.modal.npz")
    patch = Patch()
    window = patch.sub("inner", block=4096)
    box = window.obj("modal_impact~", "square.modal.npz", "-sync", 1)
    window.at(0, box, "striker 0.0005 0.003 2.06e11 0.29")
    metro, speed = window.obj("metro", 3), window.msg("hit 30 40 0 .1")
    window.start >> metro
    metro >> speed >> box
    window.record("contact", box[2])
    contact = patch.render(1, path=[tmp_path])["contact"]
    force = numpy.flatnonzero(contact)
    begun = set(force[numpy.flatnonzero(numpy.diff(force, prepend=-100) > 5)])
    first = min(begun)
    missing = [n for n in range(first, first + 300 * 144, 144) if n not in begun]
    assert not missing


PRESETS = ("table aluminium steel iron brass bronze copper lead glass ceramic wood plastic "
           "polycarbonate rubber").split()


def test_no_material_of_the_plate_clips_at_the_defaults_and_gain_is_full_scales_for_a_pascal():
    spots = ["0 0", "40 30", "80 50", "-100 60", "20 -70", "130 80"]
    patch = Patch()
    for name in PRESETS:
        for gain in ([], ["-gain", 1]):
            box = patch.obj("modal_impact~", "plate.modal.npz", "-sync", 1, *gain)
            if name != "table":
                patch.at(1, box, f"preset {name}")
            for i, spot in enumerate(spots):
                patch.at(20 + 150 * i, box, "reset")
                patch.at(70 + 150 * i, box, f"hit {spot} 2.5 1")
            for side in (0, 1):
                patch.record(f"{name} {side} {len(gain)}", box[side])
    result = patch.render(1, path=[stage_folder()])
    for name in PRESETS:
        for side in (0, 1):
            ours, pascal = result[f"{name} {side} 0"], result[f"{name} {side} 2"]
            assert 0 < abs(ours).max() < 0.7  # 3 dB of headroom
            assert abs(100 * ours - pascal).max() < 1e-5 * abs(pascal).max()


@pytest.mark.skipif(not (stage_folder() / "plate.modal.npz").is_file(), reason="the plate's table is made by modal_fem")
@pytest.mark.parametrize("click", ["cell-0-0", "play", "ui-drop"])
@pytest.mark.parametrize("size", [0.3, 2])
def test_the_help_of_modal_impact_strikes_a_body_of_any_size_within_its_rim(size, click):
    def loudest(factor):
        patch = Patch(opens=stage_folder() / "modal_impact~-help.pd", own="own")
        patch.send(0, "pd", "dsp 1")
        patch.send(50, "own-help", "sync 1")
        patch.send(100, "own-ui-size", factor)
        patch.send(400, f"own-{click}", "bang")
        patch.record("sound", patch.dac(1))
        return abs(patch.render(0.8, 48000, dsp=False)["sound"]).max()
    # Off the body the striker would meet its rim, 50 dB softer.
    assert 0.1 * loudest(1) < loudest(size) < 0.9
