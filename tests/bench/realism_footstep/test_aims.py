"""What a fit searches, and what it aims at."""
import numpy
import pytest
from aims import Aim, Played, shares_of
from features import RATE
from searched import TABLE, RecipeText, rounded
from targets import MATERIALS

TIME = numpy.arange(RATE) / RATE
RECIPE = "# mine\nlevel 1\n[solid]\npatches 4\nstiffness 1e9\n[grains]\ncount 40\nspread 0.7  # wide\n[room]\nlevel -12\n"


def steps(count, seed=1):
    random = numpy.random.RandomState(seed)
    return [numpy.exp(0.2 * random.randn()) * random.randn(RATE) * numpy.exp(-TIME / 0.03) * (TIME > 0)
            for _ in range(count)]


def test_a_recipe_survives_being_made_a_point():
    recipe = RecipeText(RECIPE)
    assert [(n.section, n.key) for n in recipe.numbers] == [
        ("solid", "patches"), ("solid", "stiffness"), ("grains", "count"), ("grains", "spread"),
        ("room", "level")]
    again = recipe.at(recipe.start)
    assert "# mine\nlevel 1\n" in again and "patches 4\n" in again and "count 40\n" in again
    assert "# wide" in again and "level -12\n" in again


def test_a_point_outside_the_bounds_stays_inside_and_patches_are_whole():
    recipe = RecipeText(RECIPE)
    low, high = recipe.at(recipe.start * 0 - 1), recipe.at(recipe.start * 0 + 2)
    assert "patches 1\n" in low and "count 3\n" in low and "level -40\n" in low
    assert "patches 8\n" in high and "count 3000\n" in high and "level 0\n" in high
    point = recipe.start.copy()
    point[0] = (3.7 - 1) / (8 - 1)
    assert "patches 4\n" in recipe.at(point)


def test_numbers_are_written_with_three_digits():
    written = [rounded(v) for v in (0.012345, 1.7e3, 1234.5, 6.4512e9, 0, 1.23456e-5, 99960)]
    assert written == ["0.0123", "1700", "1230", "6.45e9", "0", "1.23e-5", "1e5"]


def test_every_number_searched_has_bounds_around_its_prior():
    for number in TABLE:
        assert number.low < number.high and number.deviation > 0, number
        assert number.scale in ("log", "linear") and (number.scale == "linear" or number.low > 0), number
        assert number.median is None or number.low <= number.median <= number.high, number
    assert len({(n.section, n.key) for n in TABLE}) == len(TABLE)


def test_a_number_without_a_median_begins_at_its_prior():
    recipe = RecipeText(RECIPE)
    beyond = dict(zip([n.key for n in recipe.numbers], recipe.beyond_prior(recipe.start)))
    assert beyond["patches"] == 0 and beyond["count"] == 0
    assert beyond["spread"] == pytest.approx((0.7 - 0.8) / 0.4)
    # One deviation of a logarithm.
    moved = RecipeText(RECIPE.replace("1e9", str(1e9 * numpy.exp(1.5))))
    assert recipe.beyond_prior(moved.start)[1] == pytest.approx(1)


def test_what_sounds_is_counted_by_kind():
    assert shares_of([("grains", 1.0), ("impact", 2.0), ("grains", 1.0)]) == {"grains": 0.5, "impact": 0.5}


def cost(label, sections, made=None):
    made = made or steps(2)
    return Aim.of_label(label).cost(Played([made], sections))[1]


def test_a_ground_without_its_section_costs_and_a_slope_leads_back():
    good = cost("wood", [("impact", 0.7), ("grains", 0.3)])
    quiet = cost("wood", [("impact", 0.1), ("grains", 0.9)])
    quieter = cost("wood", [("impact", 0.01), ("grains", 0.99)])
    assert good["shares"] == 0
    assert 10 < quiet["shares"] < quieter["shares"]
    assert cost("wood", [("impact", 0.9), ("rustle", 0.1)])["shares"] > 5
    assert cost("gravel", [("grains", 0.95), ("rustle", 0.05)])["shares"] == 0
    assert cost("creak", [("impact", 0.9), ("friction", 0.1)])["shares"] > 1


def test_a_lost_step_costs():
    made = steps(8)
    assert cost("wood", [("impact", 1.0)], made)["levels"] < 0.5
    lost = made[:-1] + [made[-1] * 0.05]
    assert cost("wood", [("impact", 1.0)], lost)["levels"] > 10


@pytest.mark.parametrize("label", [
    label if label in ("wood", "creak") else pytest.param(label, marks=pytest.mark.slow) for label in MATERIALS])
def test_every_ground_has_an_aim_and_finite_residuals(label):
    aim = Aim.of_label(label)
    played = Played([steps(2), steps(2, 2)], [("impact", 1.0)])
    found = aim.residuals(played, numpy.zeros(3))
    assert numpy.isfinite(found).all()
    total, costs = aim.cost(played, numpy.zeros(3))
    assert total == pytest.approx(numpy.sum(found ** 2), rel=1e-9)
    assert set(costs) - {"bursts"} == {"features", "profile", "time_band", "energy", "contacts", "shares",
                                       "levels", "prior"}
    assert ("bursts" in costs) == (label == "creak")
