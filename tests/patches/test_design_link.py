"""patches/design/design_link.pd: a design session over TCP with the program haptic_server.

Live: Pd, the server and its simulated hand play in real time. The tests wait for events and read the
server's trace, whose rows carry their own times, so a busy machine makes them slow and nothing else."""
import os
import signal
import sys

import numpy
import pytest

from harness import read_trace
from harness.live import LivePd, patch_text
from harness.run import ROOT

sys.dont_write_bytecode = True

if not os.environ.get("HAPTIC_SERVER"):
    pytest.skip("the program haptic_server is not built", allow_module_level=True)

from peer import Program  # noqa: E402

# ms x y z buttons: the hand takes the middle control point, (0, 10, 0) mm, and lifts it by 4 mm.
PATH = """0 0 10 0 0
1500 0 10 0 0
1510 0 10 0 1
2500 0 10 0 1
5500 0 14 0 1
600000 0 14 0 1
"""


def serve(folder, port=0):
    folder.mkdir()
    path = folder / "path.txt"
    path.write_text(PATH)
    return Program(folder, "--hand", "rigid", "--path", str(path), "--port", str(port), force_limit=8.0)


def test_points_are_dragged_and_stress_is_felt_and_a_killed_server_is_found_again(tmp_path):
    first = serve(tmp_path / "first")
    servers = [first]
    watch = tmp_path / "watch.pd"
    watch.write_text(patch_text(
        ["obj 10 10 loadbang", "obj 10 40 delay 500", f"msg 10 70 \\; design-link connect 127.0.0.1 {first.port}",
         "obj 10 110 r design-heard", "obj 10 140 print heard", "obj 200 110 r design-gamma", "obj 200 140 print gamma"],
        ["0 0 1 0", "1 0 2 0", "3 0 4 0", "5 0 6 0"]))
    try:
        with LivePd(ROOT / "patches" / "design" / "design_link.pd", watch) as pd:
            def lifted_to(mm, count, since=0):
                """The session begins, for the nth time, and the point rises."""
                for said in ("welcome 1 simulated", "status started spring design$", "grab 1 1$"):
                    pd.wait_for(f"^heard: {said}", count)
                pd.wait_until(lambda: [h for h in pd.find(r"^heard: cp move 1 \S+ (\S+) \S+$", since) if float(h) >= mm],
                              f"a height of {mm} mm")
                written = servers[-1].trace.stat().st_size + 40000  # it is felt for a while: some hundred rows
                pd.wait_until(lambda: servers[-1].trace.stat().st_size > written, "the trace")
                return [float(g) for g in pd.find(r"^gamma: (\S+)$")]
            gammas = lifted_to(13.9, 1)
            # The beam is higher: less stress, and the server was told.
            assert 0 < gammas[-1] < 0.95 * max(gammas)
            assert not pd.find(r"^design: error")
            first.signal(signal.SIGKILL)
            first.process.wait()
            since = len(pd.read())
            servers.append(serve(tmp_path / "second", first.port))
            # The session knows where the point was left, 4 mm up, so 4 mm more are 8.
            lifted_to(17.9, 2, since)
            servers[1].signal(signal.SIGKILL)
            servers[1].process.wait()
    finally:
        for server in servers:
            server.process.kill()
            server.process.wait()
    for server in servers:
        lines = server.trace.read_text().splitlines()
        server.trace.write_text("\n".join(lines[:-1]) + "\n")  # the last row of a killed server may be cut off
        rows = read_trace(server.trace)
        force = numpy.stack([rows[f"f{axis}_n"] for axis in "xyz"])
        assert force.shape[1] > 100 and abs(force).max() > 0.2
        # For each nominal tick of 1 ms: a late tick may change more.
        assert (abs(numpy.diff(force)).max(axis=0) / numpy.maximum(1, numpy.diff(rows["ms"]))).max() < 0.05
