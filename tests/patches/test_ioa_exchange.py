"""Each module is exchanged by changing one object box: the rows of docs/results/audiohaptics.md's table."""
import socket
import struct

import numpy
import pytest

from harness import Patch, stage_folder
from harness.live import LivePd, free_port, patch_text
from ioa_system import NEEDS_DISK, System, of, taps

needs_disk = pytest.mark.skipif(NEEDS_DISK, reason="the disk's table is made where modal_fem is built")
PLACES = ((25, 0), (-10, 20))


def played(tmp_path, **exchanged):
    """A system whose device is the simulated one on a rigid hand, unless exchanged."""
    patch = Patch()
    modules = {"sdd": "ioa_sdd_phantom", **exchanged}
    system = System(patch, **modules)
    path = taps(tmp_path / "hand.txt", *PLACES, start=50)
    sensor = (modules["sdd"] if isinstance(modules["sdd"], str) else modules["sdd"][0])
    words = "start" if sensor == "ioa_sdd_script" else "hand rigid, path"
    patch.at(10, system.box["sdd"], f"{words} {path}")
    patch.log("info", patch.obj("r", "lab.phantom-info"))
    patch.send(128, "lab.phantom", "bang")
    result = patch.render(0.5)
    result.force = [a[1:] for _, a in result.logs["info"] if a[0] == "force"]
    return result


def positions(result):
    return [pytest.approx(h[2:5], abs=1e-3) for h in of(result, "lab", "hit")]


@pytest.fixture(scope="module")
def first(tmp_path_factory):
    return played(tmp_path_factory.mktemp("first"))


@needs_disk
def test_the_first_system_is_felt_heard_and_seen(first):
    assert [h[2:5] for h in of(first, "lab", "hit")] == [pytest.approx([x, y, 6], abs=1e-3)
                                                        for x, y in PLACES]
    assert first.force[0][2] > 0.5
    assert abs(first["lab.left"]).max() > 1e-3
    assert len(of(first, "lab", "mark")) == 2


@needs_disk
@pytest.mark.parametrize("sensor", ["ioa_sdd_mouse", "ioa_sdd_script"])
def test_device_another_sensor_driver(first, tmp_path, sensor):
    result = played(tmp_path, sdd=sensor if sensor == "ioa_sdd_mouse" else [sensor])
    assert [h[2:5] for h in of(first, "lab", "hit")] == positions(result)
    assert abs(result["lab.left"]).max() == pytest.approx(abs(first["lab.left"]).max(), rel=0.02)


@needs_disk
def test_device_the_motors_become_a_file(first, tmp_path):
    result = played(tmp_path, ddd="ioa_ddd_file")
    assert [h[2:5] for h in of(first, "lab", "hit")] == positions(result)
    assert all(not any(f) for f in result.force)  # nothing is felt
    assert numpy.array_equal(result["lab.left"], first["lab.left"])


@needs_disk
def test_the_interaction_server_in_plain_pd(first, tmp_path):
    result = played(tmp_path, **{"is": "ioa_is_pd"})
    for plain, servo in zip(of(result, "lab", "hit"), of(first, "lab", "hit"), strict=True):
        assert plain[1] == servo[1] and plain[0] == pytest.approx(servo[0], abs=2)
        assert plain[2:5] == pytest.approx(servo[2:5], abs=1e-3)
    assert result.force[0][2] == pytest.approx(first.force[0][2], abs=1)  # 4 ms steps


@needs_disk
def test_content_another_body_and_another_law(first, tmp_path):
    other = played(tmp_path, cs=["ioa_cs_modal", "disk", "plate.modal.npz"])
    bounces = played(tmp_path, cs=["ioa_cs_physics", "disk", "disk.modal.npz"])
    for result in (other, bounces):
        assert of(result, "lab", "hit") == of(first, "lab", "hit")
    spectra = [abs(numpy.fft.rfft(r["lab.left"])) for r in (first, other)]
    peaks = [numpy.argmax(s) * 48000 / len(first["lab.left"]) for s in spectra]
    modes = numpy.load(stage_folder() / "disk.modal.npz")["freq"]
    assert abs(modes - peaks[0]).min() < 5 and abs(modes - peaks[1]).min() > 50
    assert len(of(bounces, "lab", "excite")) > 2 * len(of(first, "lab", "excite"))


@needs_disk
@pytest.mark.parametrize("part, felt, heard, seen", [
    ("r_spring", False, True, True), ("r_modal", True, False, True), ("mm_screen", True, True, False)])
def test_sense_a_renderer_or_manager_is_left_out(first, tmp_path, part, felt, heard, seen):
    result = played(tmp_path, **{part: None})
    assert of(result, "lab", "hit") == of(first, "lab", "hit")
    assert (result.force[0][2] > 0.5) == felt
    assert ("lab.left" in result.recordings and abs(result["lab.left"]).max() > 1e-3) == heard
    assert bool(of(result, "lab", "mark")) == seen


@needs_disk
def test_the_listener_moves_with_the_hand(first, tmp_path):
    result = played(tmp_path, mm_sound=["ioa_mm_sound", 0, 0, 100])
    assert abs(result["lab.left"]).max() > 2 * abs(first["lab.left"]).max()  # five times as near


def live(folder, lines, cords):
    """A Pd in real time with that patch."""
    patch = folder / "live.pd"
    patch.write_text(patch_text(lines, cords))
    return LivePd(patch)


def test_place_the_interaction_server_behind_a_network(tmp_path):
    """The hand's bus and the server's bus are mirrored over a socket, in one live Pd: the hits are the
    same as beside each other, and their times, translated twice, within 2 ms (case P23)."""
    path, port = taps(tmp_path / "hand.txt", *PLACES, start=500), free_port()
    with live(tmp_path, [
            f"obj 10 10 ioa_sdd_script near {path}", "obj 10 40 ioa_re near 1",
            "obj 10 70 ioa_net near hand", "obj 300 70 ioa_net far hit release contact",
            "obj 300 100 ioa_is_pd far", "obj 300 130 ioa_mm_haptic far disk_scene.txt",
            "obj 10 130 ioa_bus near hit", "obj 10 160 print near", "obj 300 10 loadbang",
            "obj 300 30 t b b b", f"msg 400 40 listen {port}", f"msg 300 40 connect {port}",
            "msg 200 40 bang", "obj 150 70 ioa_is_pd near", "obj 150 100 ioa_mm_haptic near disk_scene.txt",
            "obj 300 160 ioa_bus far hit", "obj 300 190 print far"],
            ["8 0 9 0", "9 2 10 0", "10 0 3 0", "9 1 11 0", "11 0 2 0", "9 0 12 0", "12 0 0 0", "6 0 7 0",
             "15 0 16 0"]) as pd:
        # On the near bus each hit is heard twice: from its own server and from the far one.
        near = pd.wait_for(r"^near: hit (\S+) disk (\S+) (\S+) (\S+)", 4)
        far = pd.wait_for(r"^far: hit (\S+) disk (\S+) (\S+) (\S+)", 2)
    assert sorted(hit[1:] for hit in near) == sorted(hit[1:] for hit in 2 * far)
    for x in {hit[1] for hit in near}:
        times = [float(hit[0]) for hit in near if hit[1] == x]
        assert len(times) == 2 and max(times) - min(times) <= 2


def test_a_topic_that_would_run_in_a_circle_is_refused(tmp_path):
    port = free_port()
    with live(tmp_path, [
            "obj 10 10 ioa_net left hand", "obj 300 10 ioa_net right hand", "obj 10 40 loadbang",
            "obj 10 70 t b b", f"msg 10 100 connect {port}", f"msg 100 100 listen {port}",
            "obj 10 130 delay 300", "msg 10 160 hand 1 2 3 4 0 0 0", "obj 10 190 ioa_bus left hand",
            "obj 10 220 print left", "obj 300 190 ioa_bus right hand", "obj 300 220 print right"],
            ["2 0 3 0", "3 1 5 0", "5 0 1 0", "3 0 4 0", "4 0 0 0", "2 0 6 0", "6 0 7 0", "7 0 8 0", "8 0 9 0",
             "10 0 11 0"]) as pd:
        pd.wait_for("ioa-error: right ioa_net a topic came that this side sends")
        assert len(pd.find("^left: hand 1 2 3 4")) == 1 and not pd.find("^right: hand")


def test_osc_packets_over_udp_become_raw_positions_of_this_computer_alone(tmp_path):
    port = free_port(socket.SOCK_DGRAM)
    packet = b"/raw\0\0\0\0,fff\0\0\0\0" + struct.pack(">fff", 25, -3.5, 6)
    with live(tmp_path, [f"obj 10 10 ioa_sdd_osc lab {port}", "obj 10 40 print osc"], ["0 0 1 0"]) as pd, \
            socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as out:
        pd.wait_until(lambda: out.sendto(packet, ("127.0.0.1", port)) and pd.find(r"^osc: raw \S+ 25 -3.5 6$"), "a position")
        with open("/proc/net/udp", encoding="ascii") as sockets:
            bound = {line.split()[1] for line in sockets if f":{port:04X} " in line}
    assert bound == {f"0100007F:{port:04X}"}
