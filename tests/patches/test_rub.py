"""[modal_impact~] rubbed, and resting on a board: a string in closed form against Helmholtz, a bar that is heard with
the board's modes."""
import numpy
import pytest
from harness import Patch
from harness.sound import RATE, part
from harness.struck_reference import closed_form_bar, closed_form_board, closed_form_string

BETA, SPEED, HZ, LENGTH = .13, .1, 196., 330.


def render(folder, table, messages, seconds=1., moves=(), signals=(), rate=RATE, errors=()):
    """moves: (s, message); signals: normal force and velocity of what rubs."""
    numpy.savez(folder / "body.npz", **table)
    numpy.savez(folder / "board.npz", **closed_form_board())
    patch = Patch()
    box = patch.obj("modal_impact~", "body.npz", "-sync", 1, "-gain", 1)
    for inlet, samples in enumerate(signals, 2):
        patch.signal(samples) >> box[inlet]
    for name, outlet in (("left", 0), ("contact", 2), ("friction", 6)):
        patch.record(name, box[outlet])
    for time, message in [*((0, m) for m in messages), *moves]:
        patch.at(1000 * time, box, message)
    result = patch.render(seconds, rate, path=[folder], timeout=120, expect_errors=list(errors))
    return {name: numpy.asarray(result[name], float) for name in ("left", "contact", "friction")}


def bowed(folder, force, rate=RATE):
    """Velocity under the bow over the last 0.4 s of 1.2, and all that was recorded."""
    rise = numpy.clip(numpy.arange(int(1.2 * rate)) / rate / .05, 0, 1)
    position = (BETA - .5) * LENGTH
    heard = render(folder, closed_form_string(hz=HZ),
                   ["radiation none", f"listener 1 {position} 0.5 0", "friction 0.8 0.3 0.1 0.5 1000000 5 0",
                    f"rub {position} 0 0.5 0 1 0"], 1.2, signals=[force * rise, SPEED * rise], rate=rate)
    return heard["left"][int(.8 * rate):], heard


def slips(velocity, rate=RATE):
    """Begun in a period."""
    low = velocity < 0
    return (low[1:] & ~low[:-1]).sum() / (len(velocity) / rate * HZ)


@pytest.mark.parametrize("rate", [44100, pytest.param(96000, marks=pytest.mark.slow)])
def test_a_bowed_string_moves_as_helmholtz_saw_it(tmp_path, rate):
    velocity, heard = bowed(tmp_path, .2, rate)
    assert abs(slips(velocity, rate) - 1) < .02
    assert abs(numpy.median(velocity) - SPEED) < .01 * SPEED  # it sticks for most of the time
    assert abs((velocity < .3 * SPEED).mean() / BETA - 1) < .1
    assert abs(numpy.median(velocity[velocity < -.5 * SPEED]) / (-SPEED * (1 - BETA) / BETA) - 1) < .1
    # No friction is above the static coefficient's, none of it is pressing.
    assert abs(heard["friction"]).max() < 1.6 * .8 * .2  # bristles' damping on top
    assert not heard["contact"].any()


def test_friction_takes_hold_and_lets_go_and_slides_on_to_another_position(tmp_path):
    """Coulomb's: both coefficients are the same. Over half the string, a hundred places a second, without gaps."""
    time = numpy.arange(RATE) / RATE
    normal = numpy.where((time > .1) & (time < .9), 2., 0)
    moves = [(n / 100, f"rub {-60 + 1.2 * n} 0 0.5 0 1 0") for n in range(100)]
    friction = render(tmp_path, closed_form_string(hz=HZ), ["radiation none", "friction 0.3 0.3 0.1 0.5 100000 5 0"],
                      moves=moves, signals=[normal, .5 + 0 * time])["friction"]
    assert not friction[time < .1].any() and not friction[time > .9].any()
    sliding = friction[(time > .2) & (time < .89)]
    assert abs(sliding / .6 - 1).max() < .6 and abs(sliding.mean() / .6 - 1) < .02


# ---- on a board ------------------------------------------------------------------------------

BAR = closed_form_bar()
HIT = "hit 20 0 6 1"
MALLET = "hardness 1e6 2"
LYING = ["board board.npz 0 0 -15", "rest -110 0 -6 60 0 -6", MALLET]  # off the first mode's nodes


def struck(folder, messages, seconds=1., hit=HIT, moves=(), errors=()):
    return render(folder, BAR, messages, seconds, [(.1, hit), *moves], errors=errors)


def level(samples, hz, width):
    """Energy within a few Hz of a tone, dB."""
    magnitude = abs(numpy.fft.rfft(samples * numpy.hanning(len(samples))))
    return 10 * numpy.log10((magnitude[abs(numpy.fft.rfftfreq(len(samples), 1 / RATE) - hz) < width] ** 2).sum() + 1e-30)


def test_a_struck_bar_is_heard_with_its_boards_modes(tmp_path):
    screws = ["rest_stiffness 1e7", "rest_exponent 1.5", "rest_force 100"]
    alone, felt, screwed = (struck(tmp_path, messages)["left"] for messages in ([MALLET], LYING, LYING + screws))
    low, next_one = closed_form_board()["freq"][:2]
    assert min(level(x, low, 15) for x in (felt, screwed)) > level(alone, low, 15) + 15
    assert level(screwed, next_one, 15) > max(level(x, next_one, 15) for x in (alone, felt)) + 10
    # Hard points lead the bar's energy into the board, which loses it sooner.
    assert level(part(screwed, .5), BAR["freq"][0], 12) < level(part(alone, .5), BAR["freq"][0], 12) - 6
    # Everything is silent before the strike, though the body lies there.
    assert not numpy.any(felt[:int(.1 * RATE) - 64])
    # Without points of rest the board is not heard; without a board the points are nothing.
    beside = struck(tmp_path, ["board board.npz 0 0 -15", MALLET])["left"]
    assert abs(beside - alone).max() < 3e-3 * abs(alone).max()  # other order of a bank in single precision
    assert numpy.array_equal(struck(tmp_path, [*LYING[:2], "board none", MALLET])["left"], alone)


def test_the_board_is_struck_too_and_shakes_the_bar(tmp_path):
    on_the_bar, hit = ["radiation none", "listener 1 20 0 6"], "hit 200 100 -11 1"
    shaken = struck(tmp_path, LYING + on_the_bar, .4, hit)
    assert abs(shaken["contact"]).max() > 1  # the mallet's force alone
    assert abs(shaken["left"]).max() > 1e-6  # m/s of its modes, through felt
    assert not numpy.any(struck(tmp_path, [LYING[0], MALLET, *on_the_bar], .4, hit)["left"])


@pytest.mark.parametrize("message, words", [("board body.npz", "the body of this table has no supports"),
                                            ("rest 100 0 -6 140 0 -6", "the body tips over")])
def test_a_bar_that_cannot_rest_so_rests_as_it_did(tmp_path, message, words):
    good, refused = (struck(tmp_path, LYING + more, .3, errors=[words] if more else [])["left"] for more in ([], [message]))
    assert numpy.array_equal(refused, good)


def test_points_and_board_come_and_go_while_it_rings(tmp_path):
    x = struck(tmp_path, LYING, 1.2, moves=[
        (.2, "rest"), (.3, HIT), (.4, LYING[1]), (.5, "rest_stiffness 1e9"), (.6, "size 0.8"), (.7, "rest_force 50"),
        (.8, "board none"), (.9, HIT), (1., LYING[0]), (1.1, "reset")])["left"]
    assert abs(x).max() < 1e4 and not numpy.any(x[int(1.16 * RATE):])
