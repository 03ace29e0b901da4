"""patches/design/beam.pd is dragged with a mouse: the control point follows, and its force is felt."""
import re

import pytest
from test_ioa_mouse import BUILD, ROOT, STAGE, drag, opened, pytestmark  # noqa: F401

LISTENER = """#N canvas 900 40 200 200 12;
#X obj 20 20 r design-info;
#X obj 20 50 route point;
#X obj 20 80 route 8;
#X obj 20 110 print point;
#X obj 120 20 r design-force;
#X obj 120 50 print force;
#X connect 0 0 1 0;
#X connect 1 0 2 0;
#X connect 2 0 3 0;
#X connect 4 0 5 0;
"""
SCALE, LEFT, TOP, WIDTH, HEIGHT = 3.1, 23, 136, 640, 250  # of the picture in beam.pd, pixels


def test_dragging_a_control_point_reshapes_the_beam_against_a_spring(tmp_path):
    if not (STAGE / "cantilever.stress.npz").is_file():
        pytest.skip("the tables of the parts are not made in this build")
    (tmp_path / "listener.pd").write_text(LISTENER)
    with opened(ROOT / "patches" / "design" / "beam.pd", 700, "-open", str(tmp_path / "listener.pd")) as desk:
        def last(name):
            found = re.findall(rf"^{name}: (\S+) (\S+) (\S+)", desk.words(), re.M)
            return [float(x) for x in found[-1]] if found else None

        def pixel(x, y):
            return LEFT + WIDTH / 2 + SCALE * x, TOP + HEIGHT / 2 - SCALE * y
        desk.wait_for(lambda: last("point"), 60, "the first picture")
        x, y, _ = last("point")
        assert (x, y) == pytest.approx((66.6667, 10), abs=1e-3)
        drag(desk.ask, desk.move_to, [pixel(x, y), pixel(x, y + 5)])
        # The hand of 400 N/m pulls 5 mm up, the spring k(gamma) within 100 and 500 N/m holds against it.
        desk.wait_for(lambda: last("point")[1] > y + 1.8 and last("force")[1] < -0.3, 60, "the point")
        folder = BUILD / "photographs"
        folder.mkdir(exist_ok=True)
        desk.ask("import", "-window", desk.window, str(folder / "design_dragged.png"))
        assert last("point")[1] < y + 4.3
        assert last("point")[0] == pytest.approx(x, abs=1e-3)
        assert not re.search(r"error|couldn't create", desk.words()), desk.words()
