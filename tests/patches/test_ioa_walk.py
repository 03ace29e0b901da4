"""patches/audiohaptics/walk_and_touch.pd: a walker's steps sound in a plank and are felt by the hand on it."""
import numpy
import pytest

from harness import Patch, read_trace, stage_folder
from harness.run import ROOT

pytestmark = pytest.mark.skipif(not (stage_folder() / "plank.modal.npz").is_file(),
                                reason="the plank's table is made where modal_fem is built")


def played(folder, walking):
    patch = Patch(opens=ROOT / "patches" / "audiohaptics" / "walk_and_touch.pd", own="own")
    patch.record("left", patch.dac(1))
    patch.log("excite", patch.obj("ioa_bus", "own-bus", "excite") >> patch.obj("route excite"))
    patch.send(1, "walk.phantom", f"trace {folder}/ticks.csv")
    patch.send(50, "help-play", "bang")
    if not walking:
        patch.send(60, "walk-feet", "reset, walk 0")
    patch.send(3990, "walk.phantom", "trace stop")
    result = patch.render(4, timeout=120)
    rows = read_trace(folder / "ticks.csv")
    ticks = numpy.stack([rows["ms"], rows["fz_n"]], 1)
    steps = [atoms[0] for ms, atoms in result.logs["excite"] if ms < 3800 and atoms[3] != 0]
    return result["left"], ticks, steps


@pytest.fixture(scope="module")
def walk(tmp_path_factory):
    return played(tmp_path_factory.mktemp("walk"), True)


def test_each_step_sounds_in_the_plank(walk):
    sound, _, steps = walk
    assert len(steps) >= 8 and abs(sound).max() < 0.9
    heels = steps[::2]
    for t in heels:
        begin = int((t + 2) * 48)  # the patch plays 2 ms late, since [phantom~] steps the servo
        assert abs(sound[begin:begin + 1440]).max() > 1.5 * abs(sound[begin - 480:begin - 48]).max()


def test_the_resting_hand_feels_the_walker(walk, tmp_path):
    def shaken(ticks):
        """RMS of the force's changes from tick to tick, N, while the hand rests."""
        force = ticks[ticks[:, 0] > 2000, 1]
        assert force.min() > 0  # it rests on the plank all the time
        return numpy.diff(force).std()
    _, still, steps = played(tmp_path, False)
    assert still[still[:, 0] > 2000, 1].min() > 0.3
    assert all(t < 1000 for t in steps)  # the foot that was on its way
    assert shaken(walk[1]) > 10 * shaken(still) and shaken(walk[1]) > 0.01
