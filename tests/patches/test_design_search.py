"""The search by feel of ./play design: equal volume and limits, forces of Pd, and moves that follow these alone."""
import types

import _design_search as search
import numpy
import pytest
import scipy.optimize
from _design import Part

from harness import stage_folder

if not (stage_folder() / "lift_arm.stress.npz").is_file():
    pytest.skip("the table of the arm is not made in this build", allow_module_level=True)


@pytest.fixture(scope="module")
def shapes():
    return search.Shapes(Part("lift_arm", 18))


def number_felt(part, parameters, power):
    stress = part.taylor(parameters)
    largest = stress.max()
    return largest * (part.weights @ (stress / largest).clip(0) ** power) ** (1 / power)


def test_the_volume_is_that_of_the_skin_and_is_kept_within_the_limits(shapes):
    draw = numpy.random.default_rng(1)
    for scale in (1e-3, 8e-3, 50e-3):
        x = draw.uniform(-scale, scale, shapes.size)
        assert shapes.volume(x) == pytest.approx(shapes.part.volume(shapes.part.spread @ x), rel=1e-12)
        step = 1e-6 * draw.normal(size=shapes.size)
        change = shapes.volume(x + step) - shapes.volume(x - step)
        assert 2 * shapes.volume_slope(x) @ step == pytest.approx(change, rel=1e-6)
        kept = shapes.restored(x)
        assert numpy.abs(kept).max() <= search.LIMIT
        assert shapes.volume(kept) == pytest.approx(shapes.first_volume, rel=1e-9)


@pytest.mark.parametrize("setup, power", [(search.CHOSEN, 30), (search.PAPER, 1),
                                          (search.Setup("-weights volume", 0.05, 1, False, True), 1)])
def test_pd_answers_a_pull_by_the_spring_of_the_shape(shapes, setup, power):
    """k = 100 + 400 gamma N/m at 10 mm, gamma from the table's own numbers, the range about the hand or the table."""
    part = shapes.part
    hands = []
    for handle in part.handles[:3]:
        here = shapes.restored(shapes.along(handle, 1e-3, -2e-3))
        hands.append((part.spread @ here, [part.spread @ shapes.restored(here + shapes.along(handle, *by))
                                           for by in setup.pulls()]))
    found = search.felt_forces(part, setup, hands)
    for force, (here, pulls) in zip(found, hands):
        middle = number_felt(part, 0 * here if setup.table else here, power)
        for newton, parameters in zip(force, pulls):
            gamma = numpy.clip((number_felt(part, parameters, power) / middle - 1) / (2 * setup.band) + 0.5, 0, 1)
            assert newton == pytest.approx(0.01 * (100 + 400 * gamma), rel=1e-3)
    assert numpy.ptp(found) > 0.01


def test_the_point_and_its_direction_come_from_the_forces(shapes, monkeypatch):
    """One move of one hand whose third point is softer, or harder, on the side of +y alone."""
    monkeypatch.setattr(search, "ROUNDS", 1)
    setup = search.CHOSEN
    third = numpy.random.default_rng(7).choice(shapes.part.handles, setup.points, replace=False)[2]
    for difference, moved in ((0.1, search.STEP), (-0.1, -search.STEP), (0.06, 0)):
        def forces(part, setup, hands):
            newton = numpy.full((len(hands), setup.points * len(setup.pulls())), 3.0)
            newton[:, 2 * len(setup.pulls()) + 2] -= 3 * difference  # the pull towards +y of the third point
            return newton
        _, x, moves, _ = search.by_feel(shapes, setup, [7], 0.07, forces)
        assert moves[0] == bool(moved)
        assert x[0] == pytest.approx(shapes.restored(shapes.along(third, 0, moved)), abs=1e-12)


def test_a_point_at_its_limit_leaves_the_move_to_the_next(shapes, monkeypatch):
    """The third point is the clearest each time; when it cannot go on towards +y, the second goes towards +x."""
    monkeypatch.setattr(search, "ROUNDS", 12)
    first, second, third = shapes.part.handles[:3]
    same = types.SimpleNamespace(choice=lambda *_, **__: [first, second, third])
    monkeypatch.setattr(numpy.random, "default_rng", lambda seed: same)

    def forces(part, setup, hands):
        newton = numpy.full((len(hands), setup.points * 4), 3.0)
        newton[:, 4] -= 0.4
        newton[:, 10] -= 0.5
        return newton
    _, x, _, _ = search.by_feel(shapes, search.CHOSEN, [1], 0.07, forces)
    where = dict(zip(shapes.part.coordinates, x[0]))
    assert where[third, 1] > search.LIMIT - 1.5e-3
    assert where[second, 0] > 2e-3


class Series:
    """In the place of part_stress: the series, which has the same derivatives everywhere; refuses beyond a reach."""

    def __init__(self, part, reach):
        self.part, self.reach, self.refused = part, reach, 0

    def linearised(self, parameters):
        if numpy.abs(parameters).max() > self.reach:
            self.refused += 1
            return None
        return self.part.taylor(parameters), self.part.slope


def test_descent_ends_near_the_optimum_of_a_linear_program_with_steps_of_any_size(shapes, monkeypatch):
    """min t with s0 + S x <= t, |x| <= 8 mm and the volume to first order; by HiGHS. Steps of 40 mm go from limit to limit
    and are halved."""
    part, slope = shapes.part, shapes.volume_slope(numpy.zeros(shapes.size))
    scale = part.stress.max()
    program = scipy.optimize.linprog(
        [0] * shapes.size + [1], b_ub=-part.stress / scale, A_eq=[[*(slope / numpy.abs(slope).max()), 0]], b_eq=[0],
        A_ub=numpy.column_stack([shapes.slope.T * search.LIMIT / scale, -numpy.ones(len(part.stress))]),
        bounds=[(-1, 1)] * shapes.size + [(0, None)])
    assert program.status == 0
    peaks, last = search.descend(shapes, Series(part, 1))
    assert (numpy.diff(peaks[0]) < 0.01 * scale).all()
    assert shapes.volume(last[0]) == pytest.approx(shapes.first_volume, rel=1e-9)
    assert program.fun <= peaks[0, -1] / scale < program.fun + 0.03
    monkeypatch.setattr(search, "STEP", 40e-3)
    assert search.descend(shapes, Series(part, 1))[0][0, -1] == pytest.approx(peaks[0, -1], rel=0.01)


def test_descent_stays_where_the_mesh_is_valid(shapes):
    solver = Series(shapes.part, 5e-3)
    peaks, last = search.descend(shapes, solver)
    assert solver.refused > 0
    assert numpy.abs(last[0]).max() <= 5e-3
    assert peaks[0, -1] < peaks[0, 0]
