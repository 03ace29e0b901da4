"""The map on the front of patches/reed/reed_haptic.pd is dragged with a mouse: a spring pulls the hand after it."""
from test_ioa_mouse import ROOT, drag, last, listener, no_error, opened, pytestmark  # noqa: F401


def test_dragging_the_square_in_the_map_pulls_the_hand_there(tmp_path):
    with opened(ROOT / "patches" / "reed" / "reed_haptic.pd", 766, "-send", "reed-force-on 0", "-send", "pd dsp 1",
                *listener(tmp_path, y=["reed-y"], z=["reed-z"])) as desk:
        def pixel(y, z):  # the map in reed_haptic.pd: 287 pixels wide at 34, 162
            return 34 + 287 * y, 162 + 287 * (1 - z)
        desk.wait_for(lambda: last(desk, "y"), 60, "a position")
        drag(desk.ask, desk.move_to, [pixel(0.5, 0.5), pixel(0.3, 0.8)])
        desk.wait_for(lambda: abs(last(desk, "y")[0] - 0.3) < 0.03 and abs(last(desk, "z")[0] - 0.8) < 0.03, 30, "the hand")
        no_error(desk)
