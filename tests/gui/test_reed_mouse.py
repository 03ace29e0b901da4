"""The map on the front of patches/reed/reed_haptic.pd is dragged with a mouse: a spring pulls the hand after it."""
import re

import pytest
from test_ioa_mouse import BUILD, ROOT, drag, opened, pytestmark  # noqa: F401

LISTENER = """#N canvas 1100 40 200 200 12;
#X obj 20 20 r reed-y;
#X obj 20 50 print y;
#X obj 100 20 r reed-z;
#X obj 100 50 print z;
#X connect 0 0 1 0;
#X connect 2 0 3 0;
"""
LEFT, TOP, SIDE = 34, 162, 287  # of the map in reed_haptic.pd, pixels


def test_dragging_the_square_in_the_map_pulls_the_hand_there(tmp_path):
    (tmp_path / "listener.pd").write_text(LISTENER)
    with opened(ROOT / "patches" / "reed" / "reed_haptic.pd", 766, "-open", str(tmp_path / "listener.pd"), "-send",
                "reed-force-on 0", "-send", "pd dsp 1") as desk:
        def last(name):
            found = re.findall(rf"^{name}: (\S+)$", desk.words(), re.M)
            return float(found[-1]) if found else None

        def pixel(y, z):
            return LEFT + SIDE * y, TOP + SIDE * (1 - z)
        desk.wait_for(lambda: last("y") is not None, 60, "a position")
        drag(desk.ask, desk.move_to, [pixel(0.5, 0.5), pixel(0.3, 0.8)])
        desk.wait_for(lambda: abs(last("y") - 0.3) < 0.03 and abs(last("z") - 0.8) < 0.03, 30, "the hand")
        folder = BUILD / "photographs"
        folder.mkdir(exist_ok=True)
        desk.ask("import", "-window", desk.window, str(folder / "reed_dragged.png"))
        assert (last("y"), last("z")) == pytest.approx((0.3, 0.8), abs=0.03)
        assert not re.search(r"error|couldn't create", desk.words()), desk.words()
