"""The passivity controller of [phantom] must never make a quiet contact worse."""

import csv

import numpy as np
import pytest

from test_phantom import DevicePatch


def trace_of(folder, passivity, flags, messages=(), end_ms=3000):
    """Position (mm) and force (N) of the last second, from every tick of the servo."""
    folder.mkdir()
    patch = DevicePatch(f"-passivity {passivity} {flags} -trace ticks.csv", end_ms=end_ms + 10)
    for ms, message in messages:
        patch.at(ms, message)
    patch.at(end_ms, "trace stop")
    result = patch.run(folder)
    assert not result.errors
    rows = list(csv.DictReader((folder / "ticks.csv").open()))
    columns = {name: np.array([float(row[name]) for row in rows]) for name in rows[0]}
    forces = np.stack([columns[f"f{axis}_n"] for axis in "xyz"], axis=1)
    slew = np.linalg.norm(np.diff(forces, axis=0), axis=1).max()
    assert slew <= 2 + 1e-6, "2 N a millisecond"
    last = columns["ms"] >= end_ms - 1000
    return np.stack([columns[f"{axis}_mm"] for axis in "xyz"], axis=1)[last], forces[last]


def worst_of(positions, forces):
    """RMS of the force about its mean, N, and the largest motion of an axis, mm."""
    rms = np.sqrt(((forces - forces.mean(axis=0)) ** 2).sum(axis=1).mean())
    return rms, np.ptp(positions, axis=0).max()



@pytest.mark.parametrize("name, flags, messages", [
    # 4.74 N rms against 0.04, with a brake that had no bound
    ("a person on 300 N/m with an encoder", "-resolution 0.034 -hand person 200 2 0.1 0 0",
     [(1, "scene add wall plane 0 1 0 0"), (2, "scene mat wall 300 0 0")]),
    # 5.6 mm of motion against 0.06
    ("a loose hand on 500 N/m", "-resolution 0.034 -hand spring 50 0.5",
     [(1, "scene add wall plane 0 1 0 0"), (2, "scene mat wall 500 0 0"),
      (3, "path line 0 -5 0 0 -5 0 1000")]),
    # ideal readings: 2.5 mm against 0.04
    ("a push of 1 N on 200 N/m", "-hand free",
     [(1, "scene add wall plane 0 1 0 0"), (2, "scene mat wall 200 0 0"), (3, "list 0 -1 0")]),
    ("a person on a wall of 2000 N/m", "-resolution 0.034 -hand person 200 2 0.1 0 0",
     [(1, "scene add wall plane 0 1 0 0"), (2, "scene mat wall 2000 0 0"),
      (3, "path line 0 -2 0 0 -2 0 1000")]),
])
def test_the_controller_makes_no_quiet_contact_worse(tmp_path, name, flags, messages):
    off = worst_of(*trace_of(tmp_path / "off", 0, flags, messages))
    on = worst_of(*trace_of(tmp_path / "on", 1, flags, messages))
    print(f"{name}: force rms {off[0]:.4f} N without, {on[0]:.4f} with; "
          f"motion {off[1]:.3f}, {on[1]:.3f} mm")
    assert on[0] <= max(1.1 * off[0], 2e-3)
    assert on[1] <= max(1.1 * off[1], 0.02)


def test_a_wall_too_stiff_for_the_servo_is_tamed(tmp_path):
    """5000 N/m with 0.5 N s/m at 1 kHz is five times what friction holds: 1 N of push hums 10 mm."""
    messages = [(1, "scene add wall plane 0 1 0 0"), (2, "scene mat wall 5000 0 0"),
                (3, "list 0 -1 0")]
    off = worst_of(*trace_of(tmp_path / "off", 0, "-hand free", messages))
    on = worst_of(*trace_of(tmp_path / "on", 1, "-hand free", messages))
    print(f"5000 N/m: motion {off[1]:.2f} mm without, {on[1]:.3f} with")
    assert off[1] > 5
    assert on[1] < 1.5
