"""[modal_impact~] on a board: a bar that is struck is heard with the board's modes."""
import numpy
import pytest
from harness import Patch
from harness.struck_reference import closed_form_bar, closed_form_board

RATE = 48000
POINTS = "rest -82.7 0 -6 82.7 0 -6"  # where the bar's first mode is at rest, and beside
OFF_NODE = "rest -110 0 -6 60 0 -6"


def render(folder, messages, seconds=1., moves=(), expect_errors=(), with_files=True, **flags):
    if with_files:
        numpy.savez(folder / "bar.npz", **closed_form_bar())
        numpy.savez(folder / "board.npz", **closed_form_board())
    patch = Patch()
    options = [x for name, value in flags.items() for x in (f"-{name}", value)]
    body = patch.obj("modal_impact~", "bar.npz", "-sync", 1, "-gain", 1, *options)
    for name, outlet in (("left", 0), ("right", 1), ("contact", 2)):
        patch.record(name, body[outlet])
    for message in messages:
        patch.at(0, body, message)
    for time, message in moves:
        patch.at(1000 * time, body, message)
    return patch.render(seconds, RATE, path=[folder], timeout=120, expect_errors=list(expect_errors))


def sound(result, name="left"):
    return numpy.asarray(result[name], float)


def level(samples, hz, width=3.):
    """Energy within a few Hz of a tone."""
    spectrum = numpy.fft.rfft(samples * numpy.hanning(len(samples)))
    found = numpy.fft.rfftfreq(len(samples), 1 / RATE)
    return 10 * numpy.log10((abs(spectrum[abs(found - hz) < width]) ** 2).sum() + 1e-30)


HIT = "hit 20 0 6 1"
MALLET = "hardness 1e6 2"


def test_a_struck_bar_is_heard_with_its_boards_modes(tmp_path):
    alone = sound(render(tmp_path, [MALLET], moves=[(.1, HIT)]))
    lying = ["board board.npz 0 0 -15", OFF_NODE, MALLET]
    felt = sound(render(tmp_path, lying, moves=[(.1, HIT)]))
    screwed = sound(render(tmp_path, [*lying, "rest_stiffness 1e7", "rest_exponent 1.5", "rest_force 100"],
                           moves=[(.1, HIT)]))
    low, next_one = numpy.load(tmp_path / "board.npz")["freq"][:2]
    assert level(felt, low, 15) > level(alone, low, 15) + 15
    assert level(screwed, low, 15) > level(alone, low, 15) + 15
    assert level(screwed, next_one, 15) > max(level(x, next_one, 15) for x in (alone, felt)) + 10
    # Hard points lead the bar's energy into the board, which loses it sooner.
    bar = numpy.load(tmp_path / "bar.npz")["freq"][0]
    late = slice(int(.5 * RATE), None)
    assert level(screwed[late], bar, 12) < level(alone[late], bar, 12) - 6
    # Everything is silent before the strike, though the body lies there.
    assert not numpy.any(felt[:int(.1 * RATE) - 64])


def test_without_points_of_rest_the_board_is_not_heard(tmp_path):
    alone = sound(render(tmp_path, [MALLET], moves=[(.1, HIT)]))
    beside = sound(render(tmp_path, ["board board.npz 0 0 -15", MALLET], moves=[(.1, HIT)]))
    difference = abs(beside - alone).max() / abs(alone).max()
    assert difference < 3e-3  # the same modes in another order of a bank in single precision
    again = sound(render(tmp_path, ["board board.npz 0 0 -15", POINTS, "board none", MALLET], moves=[(.1, HIT)]))
    assert numpy.array_equal(again, alone)


def test_the_board_is_struck_too_and_shakes_the_bar(tmp_path):
    on_the_bar = ["board board.npz 0 0 -15", "radiation none", "listener 1 20 0 6", MALLET]
    strike = [(.1, "hit 200 100 -11 1")]
    shaken = render(tmp_path, [*on_the_bar, OFF_NODE], moves=strike)
    assert abs(sound(shaken, "contact")).max() > 1  # the mallet's force alone
    assert abs(sound(shaken)).max() > 1e-6  # m/s of its modes, through felt
    assert not numpy.any(sound(render(tmp_path, on_the_bar, moves=strike)))


@pytest.mark.parametrize("messages, words", [
    (["board nowhere.npz"], "there is no such file"),
    (["board bar.npz"], "nothing holds the body of this table"),
    (["board 3"], "board 3: expected a file's name"),
    (["board board.npz 1 2"], "board board.npz 1 2: expected a file's name"),
    (["rest 1 2"], "rest: 2 numbers: expected x y z for each point"),
    (["rest_stiffness 1"], "rest_stiffness"),
    (["board board.npz 0 0 -15", "rest 100 0 -6 140 0 -6"], "the body tips over"),
])
def test_what_cannot_be_is_said_once_and_the_body_rings_on(tmp_path, messages, words):
    result = render(tmp_path, [MALLET, *messages], moves=[(.1, HIT)], seconds=.3, expect_errors=[words])
    assert abs(sound(result)).max() > 1e-3


def test_a_bar_that_cannot_rest_so_rests_as_it_did(tmp_path):
    lying = ["board board.npz 0 0 -15", OFF_NODE, MALLET]
    good = sound(render(tmp_path, lying, moves=[(.1, HIT)], seconds=.3))
    refused = sound(render(tmp_path, [*lying, "rest 100 0 -6 140 0 -6"], moves=[(.1, HIT)], seconds=.3,
                           expect_errors=["tips over"]))
    assert numpy.array_equal(refused, good)


def test_points_and_board_come_and_go_while_it_rings(tmp_path):
    result = render(tmp_path, ["board board.npz 0 0 -15", OFF_NODE, MALLET], seconds=1.2, moves=[
        (.05, HIT), (.2, "rest"), (.3, HIT), (.4, OFF_NODE), (.5, "rest_stiffness 1e9"), (.6, "size 0.8"),
        (.7, "rest_force 50"), (.8, "board none"), (.9, HIT), (1., "board board.npz 0 0 -15"), (1.1, "reset")])
    x = sound(result)
    assert numpy.isfinite(x).all()
    assert abs(x).max() < 1e4
    assert not numpy.any(x[int(1.16 * RATE):])
