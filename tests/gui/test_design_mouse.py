"""patches/design/beam.pd is dragged with a mouse: the control point follows, and its force is felt."""
import pytest
from test_ioa_mouse import ROOT, STAGE, drag, last, listener, no_error, opened, pytestmark  # noqa: F401


def test_dragging_a_control_point_reshapes_the_beam_against_a_spring(tmp_path):
    if not (STAGE / "cantilever.stress.npz").is_file():
        pytest.skip("the tables of the parts are not made in this build")
    with opened(ROOT / "patches" / "design" / "beam.pd", 700, *listener(
            tmp_path, point=["design-info", "route point", "route 8"], force=["design-force"])) as desk:
        def pixel(x, y):  # the picture in beam.pd: 640 x 250 pixels at 23, 136, 3.1 a mm
            return 23 + 320 + 3.1 * x, 136 + 125 - 3.1 * y
        desk.wait_for(lambda: last(desk, "point"), 60, "the first picture")
        x, y, *_ = last(desk, "point")
        assert (x, y) == pytest.approx((66.6667, 10), abs=1e-3)
        drag(desk.ask, desk.move_to, [pixel(x, y), pixel(x, y + 5)])
        # The hand of 400 N/m pulls 5 mm up, the spring k(gamma) within 100 and 500 N/m holds against it.
        desk.wait_for(lambda: last(desk, "point")[1] > y + 1.8 and last(desk, "force")[1] < -0.3, 60, "the point")
        assert last(desk, "point")[1] < y + 4.3
        assert last(desk, "point")[0] == pytest.approx(x, abs=1e-3)
        no_error(desk)
