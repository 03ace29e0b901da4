"""Patches of patches/audiohaptics are dragged with a mouse: the disk on the screen is struck, a finger presses on a
reed."""
import contextlib
import importlib.machinery
import importlib.util
import os
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile
import time
import types

import pytest

ROOT = pathlib.Path(__file__).resolve().parents[2]
BUILD = pathlib.Path(os.environ.get("TACTUS_BUILD", ROOT / "build"))
STAGE = pathlib.Path(os.environ.get("TACTUS_STAGE", BUILD / "tactus"))
PROGRAMS = ("Xvfb", "openbox", "xdotool", "import", "compare", "pd")
PATCH = """#N canvas 60 40 580 420 12;
#X obj 20 20 ioa_r_screen lab;
#X obj 20 330 ioa_sdd_mouse lab;
#X obj 20 355 ioa_re lab;
#X obj 20 380 ioa_is lab;
#X obj 160 330 ioa_mm_haptic lab disk_scene.txt;
#X obj 160 355 ioa_r_spring lab;
#X obj 160 380 ioa_ddd_phantom lab;
#X obj 300 355 ioa_mm_screen lab;
#X obj 400 355 ioa_bus lab hit release;
#X obj 400 380 print bus;
#X connect 8 0 9 0;
"""

pytestmark = pytest.mark.skipif(any(not shutil.which(p) for p in PROGRAMS),
                                reason="needs xvfb openbox xdotool imagemagick")


def photograph():
    """scripts/photograph as a module: a screen of its own and how to ask it."""
    sys.dont_write_bytecode = True
    loader = importlib.machinery.SourceFileLoader("photograph", str(ROOT / "scripts" / "photograph"))
    module = importlib.util.module_from_spec(importlib.util.spec_from_loader("photograph", loader))
    loader.exec_module(module)
    return module


def drag(ask, move_to, points, pause=0.02):
    """Presses at the first point, moves through the others in small steps and lets go."""
    move_to(*points[0])
    ask("xdotool", "mousedown", "1")
    for (x0, y0), (x1, y1) in zip(points, points[1:]):
        for k in range(1, 11):
            move_to(x0 + (x1 - x0) * k / 10, y0 + (y1 - y0) * k / 10)
            time.sleep(pause)
    ask("xdotool", "mouseup", "1")


@contextlib.contextmanager
def opened(patch, height, *options):
    """A patch of that height in a Pd with a screen of its own: what asks the screen, what Pd said, what
    moves the mouse to a point of the patch, and the window."""
    tools = photograph()
    with tools.screen() as environment, tempfile.TemporaryFile("w+") as said, \
            tempfile.TemporaryDirectory() as hosts:
        command = ["pd", "-noprefs", "-nosound", "-stderr", "-path", str(STAGE), *options, "-open", str(patch)]
        with tools.running(command, env=tools.with_localhost(environment, hosts), stdout=said,
                           stderr=said):
            def ask(*words):
                return tools.ask(environment, *words)

            def words():
                return os.pread(said.fileno(), 1 << 20, 0).decode(errors="replace")
            title = re.escape(patch.name)
            window = tools.wait_for(lambda: ask("xdotool", "search", "--onlyvisible", "--name",
                                                title).split(), 30, "the window")[-1]
            time.sleep(2)
            geometry = dict(line.split("=") for line in
                            ask("xdotool", "getwindowgeometry", "--shell", window).split())
            bar = int(geometry["HEIGHT"]) - height

            def move_to(x, y):
                ask("xdotool", "mousemove", "--sync", "--window", window, str(round(x)),
                    str(round(y) + bar))
            yield types.SimpleNamespace(ask=ask, words=words, move_to=move_to, window=window,
                                        wait_for=tools.wait_for)


def listener(folder, **receivers):
    """A patch that prints, by name, what comes to a receiver and the boxes behind it."""
    lines, cords = ["#N canvas 900 40 200 200 12;"], []
    for name, boxes in receivers.items():
        boxes = [f"r {boxes[0]}", *boxes[1:], f"print {name}"]
        cords += [f"#X connect {len(lines) - 1 + i} 0 {len(lines) + i} 0;" for i in range(len(boxes) - 1)]
        lines += [f"#X obj 20 20 {box};" for box in boxes]
    path = folder / "listener.pd"
    path.write_text("\n".join(lines + cords) + "\n")
    return "-open", str(path)


def last(desk, name):
    """The numbers that it printed last."""
    found = re.findall(rf"^{name}: (.*)$", desk.words(), re.M)
    return [float(x) for x in found[-1].split()] if found else None


def no_error(desk):
    assert not re.search(r"error|couldn't create", desk.words()), desk.words()


def test_dragging_the_cross_onto_the_disk_strikes_it_there(tmp_path):
    patch = tmp_path / "drag.pd"
    patch.write_text(PATCH)
    folder = BUILD / "photographs"
    folder.mkdir(exist_ok=True)
    with opened(patch, 420) as desk:
        def struck():
            return re.findall(r"^bus: hit \S+ disk (\S+) (\S+) (\S+)", desk.words(), re.M)
        # 2 pixels a mm: the cross begins at x = 25, z = 40 of the right view, whose middle is
        # x = 0 at 417 and whose z = 0 lies 60 above its lower end at 292.
        desk.ask("import", "-window", desk.window, str(folder / "ioa_drag_before.png"))
        assert not struck()
        drag(desk.ask, desk.move_to, [(467, 153), (427, 153), (427, 243)])
        desk.wait_for(struck, 60, "a hit")
        x, y, z = map(float, struck()[0])
        assert abs(x - 5) < 4 and abs(y) < 1 and z == pytest.approx(6)
        desk.ask("import", "-window", desk.window, str(folder / "ioa_drag_after.png"))
        no_error(desk)
    changed = subprocess.run(["compare", "-metric", "AE", str(folder / "ioa_drag_before.png"),
                              str(folder / "ioa_drag_after.png"), "null:"],
                             capture_output=True, text=True).stderr
    assert float(changed.split()[0]) > 300


def test_dragging_the_finger_onto_the_reed_is_felt_and_ends_the_note(tmp_path):
    with opened(ROOT / "patches" / "audiohaptics" / "finger_on_reed.pd", 734, "-send", "pd dsp 1", "-send",
                "finger-breath 2200", *listener(tmp_path, force=["finger-force-now"], level=["finger-level-now"])) as desk:
        def force():
            return (last(desk, "force") or [1])[0]

        def level():
            return (last(desk, "level") or [-50])[0]

        def pixel(x, z):  # 70 mm over 250 pixels; the view's left is -35 mm at 282, its top 53.2 mm at 162
            return 282 + (x + 35) / 70 * 250, 162 + (53.2 - z) / 70 * 248
        desk.wait_for(lambda: level() > -30 and force() == 0, 60, "a note")
        drag(desk.ask, desk.move_to, [pixel(15, 40), pixel(15, 20), pixel(15, -14)])
        # The reed is shut, so the hand feels 10 x 300 N/m of its depth over 20: 0.15 N/mm from z = 3 mm on
        # against the 0.5 N/mm between hand and cross.
        y_f = (-14 + 10 * 0.3 * 17 / 20 / (0.5 + 0.15) - 3) / 20
        desk.wait_for(lambda: abs(force() + 0.3 * y_f) < 0.02 and level() < -60, 60, "silence")
        drag(desk.ask, desk.move_to, [pixel(15, -14), pixel(15, 40)])
        desk.wait_for(lambda: force() == 0 and level() > -30, 60, "the note")
        no_error(desk)
