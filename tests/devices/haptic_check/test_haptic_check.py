"""haptic_check from outside: with the simulated device, with doubles of devices, with none."""
import math
import os
import platform
import re
import shutil
import signal
import subprocess
import time

import pytest

PROGRAM = os.environ["HAPTIC_CHECK"]


def start(*words, before=(), **surroundings):
    environment = {**os.environ, "TACTUS_HAPLY": "127.0.0.1:1", **surroundings}
    return subprocess.Popen([*before, PROGRAM, *words], stdin=subprocess.DEVNULL, text=True,
                            stdout=subprocess.PIPE, stderr=subprocess.PIPE, env=environment)


def run(*words, before=(), **surroundings):
    process = start(*words, before=before, **surroundings)
    output, errors = process.communicate(timeout=600)
    return process.returncode, output, errors


def number(pattern, text):
    found = re.search(pattern, text)
    assert found, f"{pattern} is not in\n{text}"
    return float(found.group(1))


class Run:
    """A run that has been started, so that several go on at once; its outcome when it is asked for."""

    def __init__(self, file, *words, before=(), **surroundings):
        self.file, self.outcome = file, None
        self.process = start("--yes", "--report", file, *words, before=before, **surroundings)

    def report(self):
        if self.outcome is None:
            self.outcome = self.process.communicate(timeout=600)
        output, errors = self.outcome
        assert self.process.returncode == 0, output + errors
        text = self.file.read_text()
        assert text in output
        return text


@pytest.fixture(scope="module")
def runs(tmp_path_factory):
    folder = tmp_path_factory.mktemp("reports")
    started = {
        "sim": Run(folder / "sim.txt", "--device", "sim", "--seconds", "2"),
        "hd": Run(folder / "hd.txt", "--device", "openhaptics", "--seconds", "0.5",
                  PHANTOM_LIBHD=os.environ["FAKE_HD"])}
    for name, double, options in (("stick", "JOYSTICK_DOUBLE", ""), ("hid", "HID_DOUBLE", "navigator"),
                                  ("falcon", "FALCON_DOUBLE", "--loaded")):
        if os.environ.get(double):
            # The double's library comes before a sanitizer's; GLib keeps memory to the end.
            started[name] = Run(folder / f"{name}.txt", "--seconds", "0.5",
                                before=f"{os.environ[double]} {options}".split(),
                                ASAN_OPTIONS="verify_asan_link_order=0:detect_leaks=0")
    yield started
    for one in started.values():
        one.process.kill()


@pytest.fixture
def simulated(runs):
    return runs["sim"].report()


def skip_if_ticks_are_missing(report, station):
    """A missed tick holds the force for longer; a few of them leave the tolerances."""
    missed = number(rf"\[{station}\][^[]*skipped (\d+)", report)
    if missed > 8:
        pytest.skip(f"this machine missed {missed:.0f} ticks meanwhile")


@pytest.mark.slow  # analysis_test has its arithmetic, without real time
def test_the_wall_has_the_stiffness_that_was_asked_for(simulated):
    assert re.search(r"loop: \w+, [\d.]+ Hz", simulated) and "ENDED EARLY" not in simulated
    assert re.search(r"limits: peak 40\.00 N, continuous 40\.00 N, stiffness not stated, damping 20\.0 N s/m\n", simulated)
    skip_if_ticks_are_missing(simulated, "wall")
    asked = number(r"N/m of (\d+) requested", simulated)
    assert number(r"force over depth (\d+) N/m", simulated) == pytest.approx(asked, rel=0.02)
    assert number(r"(\d+) hits", simulated) >= 2


@pytest.mark.slow
def test_the_sines_move_mass_spring_and_damper_as_they_must(simulated):
    """M 0.1 kg, B 0.5 + 2 N s/m, K 200 N/m; the force is held over 1 ms, hence the sinc."""
    skip_if_ticks_are_missing(simulated, "sine")
    for hz in (5, 40, 150):
        omega = 2 * math.pi * hz
        hold = math.sin(omega * 5e-4) / (omega * 5e-4)
        theory = 1e3 * hold / abs(complex(200 - 0.1 * omega**2, 2.5 * omega))
        measured = number(rf"\b{hz} Hz: .* ([\d.]+) mm/N", simulated)
        assert measured == pytest.approx(theory, rel=0.2)


STATIONS = ["position", "wall", "sphere", "sine"]


@pytest.mark.parametrize("name, stations, words", [
    ("sim", STATIONS, ["[jitter]", "[drivers]"]),
    ("hd", STATIONS, ["PHANTOM Omni", "loop: driver"]),
    ("stick", ["position", "wall"], ["device: evdev, Double Stick", "fewer than three motors"]),
    ("hid", ["position"], ["device: hid, 3Dconnexion SpaceNavigator"] + 3 * ["no motors"]),
    ("falcon", STATIONS, ["device: falcon, Novint Falcon"])])
def test_a_device_goes_through_the_stations_that_it_has_motors_for(runs, name, stations, words):
    if name not in runs:
        pytest.skip("umockdev is missing")
    report = runs[name].report()
    for station in STATIONS:
        ran = re.search(rf"\[{station}\](\n  .*)*loop: ", report)
        assert bool(ran) == (station in stations) or name == "stick", station
    for word in words:
        assert report.count(word) >= words.count(word), word
    assert "F-0042" not in report and "DOUBLE01" not in report  # serial numbers stay at home
    assert name != "stick" or "150 Hz" not in report  # beyond what 250 forces a second can say


def test_a_list_names_all_drivers_and_what_they_lack():
    status, output, _ = run("--list", PHANTOM_LIBHD="/nowhere/libHD.so")
    assert status == 0
    for driver in ("sim", "falcon", "hid", "openhaptics", "dhd", "haply", "evdev"):
        assert re.search(rf"^{driver}:", output, re.MULTILINE), driver
    assert "/nowhere/libHD.so" in output


def damaged(file, at, byte):
    library = bytearray(open(os.environ["FAKE_HD"], "rb").read())
    library[at] = byte
    file.write_bytes(library)


@pytest.mark.parametrize("name, make, says", [
    ("libHD.so.3.4", lambda file: shutil.copy(os.environ["HD_WITHOUT_DRIVER"], file),
     ["libPhantomIOLib42.so: cannot open", "Touch device driver: install it"]),
    ("libHD.so", lambda file: file.write_text("no library"), ["invalid ELF header|file too short|not a shared library"]),
    ("libHD.so.3.4", lambda file: damaged(file, 18, 0xb7 if platform.machine() != "aarch64" else 0x3e),
     ["another machine"]),
    ("libHD.so.3.4", lambda file: damaged(file, 4, 1), ["wrong ELF class|another machine"]),
    ("libdhd.so.3", lambda file: file.write_text("no library"), ["invalid ELF header|file too short|not a shared library"]),
    ("libhidapi-hidraw.so.0", lambda file: damaged(file, 4, 1), []),  # the system's is found behind it
])
def test_the_reason_why_a_vendors_library_does_not_load_is_told(tmp_path, name, make, says):
    make(tmp_path / name)
    status, output, _ = run("--list", LD_LIBRARY_PATH=str(tmp_path))
    assert status == 0
    driver = "openhaptics" if "HD" in name else "dhd"
    line = re.search(rf"^{driver}:.*(\n .*)*", output, re.MULTILINE).group()
    for words in says:
        assert re.search(words, line), line
        assert "was not found" not in line


@pytest.mark.skipif(os.geteuid() == 0, reason="root may read every file")
def test_a_library_without_permission_to_read_it_is_told(tmp_path):
    (tmp_path / "libHD.so.3.4").write_bytes(open(os.environ["FAKE_HD"], "rb").read())
    (tmp_path / "libHD.so.3.4").chmod(0)
    assert "is not readable" in run("--list", LD_LIBRARY_PATH=str(tmp_path))[1]


@pytest.mark.parametrize("words, sentence", [
    (["--dance"], "unknown option --dance; see --help"),
    (["--dance", "3"], "unknown option --dance; see --help"),
    (["--rate"], "--rate needs a value"),
    (["--rate", "100"], "--rate 100: expected 200..4000 ticks a second (1000)"),
    (["--seconds", "x"], "--seconds x: expected 0.5..300 s for each of the four stations (8)"),
])
def test_wrong_options_are_one_sentence(words, sentence):
    status, output, errors = run(*words)
    assert (status, output, errors) == (2, "", f"haptic_check: {sentence}\n")


def test_an_unknown_driver_and_a_missing_library_are_told(tmp_path):
    status, _, errors = run("--device", "spoon", "--yes")
    assert status == 2 and "spoon" in errors
    file = tmp_path / "report.txt"
    status, _, errors = run("--device", "openhaptics", "--yes", "--report", file,
                            PHANTOM_LIBHD="/nowhere/libHD.so")
    assert status == 1 and "install" in errors
    assert "ENDED EARLY" in file.read_text()  # worth an issue, too
    status, _, errors = run("--device", "sim", "--seconds", "-3")
    assert status == 2 and "--seconds" in errors


def test_an_interrupt_ends_in_order(tmp_path):
    file = tmp_path / "report.txt"
    process = start("--device", "sim", "--yes", "--seconds", "100", "--report", file)
    deadline = time.monotonic() + 300
    while time.monotonic() < deadline and "1. Position" not in process.stdout.readline():
        pass
    time.sleep(0.3)
    process.send_signal(signal.SIGINT)
    process.communicate(timeout=300)
    assert process.returncode == 1
    assert "ENDED EARLY: interrupted" in file.read_text()


@pytest.mark.parametrize("call, seen", [
    ("hdInitDevice", "Opening"), pytest.param("hdEndFrame", "1. Position", marks=pytest.mark.slow)])
def test_an_interrupt_ends_a_call_that_does_not_return(tmp_path, call, seen):
    hang = tmp_path / "hang.txt"
    hang.write_text(call if seen == "Opening" else "")
    process = start("--device", "openhaptics", "--yes", "--seconds", "100", "--report",
                    tmp_path / "report.txt", PHANTOM_LIBHD=os.environ["HANGING_HD"],
                    HANG=str(hang), before=("stdbuf", "-o0"))
    text, deadline = "", time.monotonic() + 300
    while time.monotonic() < deadline and seen not in text:
        text += process.stdout.read(1)
    if seen != "Opening":  # written anew, the file would be empty for a moment and the call return
        hang.write_text(call)
    time.sleep(0.3)
    process.send_signal(signal.SIGINT)
    try:
        _, errors = process.communicate(timeout=60)  # promised: 3 s
    finally:
        process.kill()
    assert process.returncode == 1
    assert "a call of the device's driver does not return" in errors
