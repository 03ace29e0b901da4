#!/usr/bin/env python3
"""Pd in real time for a minute: the five-reed patch with a wall-clock device, an empty patch beside it.

    jack_live.py [SECONDS]          what ./test --live runs

Starts a JACK server of its own without a sound card (48 kHz, periods of 64 samples), and on it two
Pds that compute in JACK's own thread: one plays patches/reed/reed_haptic.pd with the simulated device
stepped by the servo thread, the other plays nothing. JACK says which client was late in which
period, and when its own clock was late; the servo says how many ticks it began late. The reed patch
passes when its late periods are no more than those of the empty patch and of JACK's own clock, which
are the machine's, and one in a thousand: a stall finds a thread that works a tenth of the time more
often than one that does nothing.

Status 0: passed, 1: failed, 77: jackd or Pd is missing. Needs Debian's jackd2.
"""
import os
import pathlib
import re
import shutil
import signal
import socket
import subprocess
import sys
import tempfile
import time

ROOT = pathlib.Path(__file__).resolve().parents[3]
STAGE = pathlib.Path(os.environ.get("TACTUS_STAGE", ROOT / "build" / "tactus")).resolve()
RATE, PERIOD = 48000, 64
SERVER = f"tactus-{os.getpid()}"
ALLOWED = 1e-3  # of all periods, beyond what the machine's own stalls cost

REED = r"""#N canvas 0 0 450 300 12;
#X obj 10 10 loadbang;
#X obj 10 40 delay 500;
#X msg 10 70 \; reed-hand clock wall \, hand spring 300 3 \, path lissajous 0 10 0 0 20 20 0 0.31 0.43 \; reed-volume 0.3 \; reed-force-on 1 \; reed-all preset trumpet \; reed-note 46 \; pd dsp 1;
#X obj 10 130 netreceive -u PORT;
#X obj 10 160 s reed-hand;
#X obj 200 10 r reed-info;
#X obj 200 40 print info;
#X obj 200 130 adc~;
#X connect 0 0 1 0;
#X connect 1 0 2 0;
#X connect 3 0 4 0;
#X connect 5 0 6 0;
"""
EMPTY = r"""#N canvas 0 0 450 300 12;
#X obj 10 10 loadbang;
#X msg 10 70 \; pd dsp 1;
#X connect 0 0 1 0;
"""


def free_port():
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as door:
        door.bind(("127.0.0.1", 0))
        return door.getsockname()[1]


def stop(process):
    process.send_signal(signal.SIGTERM)
    try:
        process.wait(10)
    except subprocess.TimeoutExpired:
        process.kill()
        process.wait()


def wait_for(file, words, seconds=20):
    end = time.monotonic() + seconds
    while words not in file.read_text(errors="replace"):
        if time.monotonic() > end:
            raise SystemExit(f"no '{words}' in:\n{file.read_text(errors='replace')[-2000:]}")
        time.sleep(0.05)


def late_periods(text, client):
    """How often JACK found that client not finished at the end of a period."""
    return len(re.findall(rf"XRun: client = {re.escape(client)} was not finished", text))


def cpu_seconds(process):
    """Of the process and its threads so far."""
    fields = pathlib.Path(f"/proc/{process.pid}/stat").read_text().rpartition(")")[2].split()
    return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")


def servo_numbers(text):
    return {name: float(value) for name, value in re.findall(r"^info: stats (\S+) (\S+)$", text, re.M)}


def run(seconds, folder):
    port = free_port()
    (folder / "reed.pd").write_text(REED.replace("PORT", str(port)))
    (folder / "empty.pd").write_text(EMPTY)
    environment = dict(os.environ, JACK_DEFAULT_SERVER=SERVER, JACK_NO_AUDIO_RESERVATION="1",
                       JACK_NO_START_SERVER="1")
    texts = {name: folder / f"{name}.txt" for name in ("jack", "reed", "empty")}
    processes = {}

    def start(name, *command):
        """A process whose words all go to its file."""
        with texts[name].open("wb", buffering=0) as file:
            processes[name] = subprocess.Popen(command, stdin=subprocess.DEVNULL, stdout=file, stderr=file,
                                               env=environment)

    def ask(message):
        with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as door:
            door.sendto(f"{message};\n".encode(), ("127.0.0.1", port))

    try:
        start("jack", "jackd", "-v", "-n", SERVER, "-d", "dummy", "-r", str(RATE), "-p", str(PERIOD))
        wait_for(texts["jack"], "JackThreadedDriver::Init")
        pd = ["pd", "-nogui", "-noprefs", "-stderr", "-nomidi", "-jack", "-callback", "-r", str(RATE),
              "-blocksize", str(PERIOD), "-channels", "2", "-path", str(STAGE)]
        for name, files in (("empty", [folder / "empty.pd"]),
                            ("reed", [STAGE / "reed_haptic.pd", folder / "reed.pd"])):
            opened = [word for file in files for word in ("-open", str(file))]
            start(name, *pd, "-jackname", f"tactus_{name}", *opened)
            wait_for(texts["jack"], f"tactus_{name}")
        time.sleep(3)  # loading and tuning
        before = len(texts["jack"].read_text(errors="replace"))
        ask("stats reset")
        busy = {name: -cpu_seconds(processes[name]) for name in ("empty", "reed")}
        time.sleep(seconds)
        busy = {name: (used + cpu_seconds(processes[name])) / seconds for name, used in busy.items()}
        after = texts["jack"].read_text(errors="replace")[before:]
        ask("stats")
        time.sleep(0.5)
    finally:
        for process in reversed(processes.values()):
            stop(process)
    late = {name: late_periods(after, f"tactus_{name}") for name in ("reed", "empty")}
    late["clock"] = after.count("JackTimedDriver::Process XRun")
    return late, busy, servo_numbers(texts["reed"].read_text(errors="replace")), texts


def main():
    if lacking := [name for name in ("jackd", "pd") if not shutil.which(name)]:
        print(f"skipped: {lacking[0]} is missing; apt-get install jackd2 puredata-core")
        sys.exit(77)
    seconds = float(sys.argv[1]) if len(sys.argv) > 1 else 60
    periods = seconds * RATE / PERIOD
    with tempfile.TemporaryDirectory(prefix="tactus-") as name:
        late, busy, servo, texts = run(seconds, pathlib.Path(name))
        if "late_p99_ms" not in servo:
            print(texts["reed"].read_text(errors="replace")[-3000:])
            print(texts["jack"].read_text(errors="replace")[-2000:])
    print(f"{seconds:g} s at {RATE} Hz in periods of {PERIOD}: {periods:.0f} periods each")
    print(f"{'':24}{'five reeds':>14}{'empty patch':>14}")
    print(f"{'late periods (xruns)':24}{late['reed']:14d}{late['empty']:14d}")
    print(f"{'share':24}{late['reed'] / periods:14.2e}{late['empty'] / periods:14.2e}")
    print(f"{'clock of JACK late':24}{late['clock']:14d}{late['clock']:14d}")
    print(f"{'of one processor core':24}{busy['reed']:14.1%}{busy['empty']:14.1%}")
    for title, key, unit in (("servo ticks", "ticks", ""), ("begun late by > 1 ms", "overruns", ""),
                             ("ticks skipped", "skipped", ""), ("late, median", "late_p50_ms", "ms"),
                             ("late, 99 %", "late_p99_ms", "ms"), ("late, most", "late_max_ms", "ms"),
                             ("work a tick, mean", "work_mean_ms", "ms")):
        if key in servo:
            print(f"{title:24}{servo[key]:14g} {unit}")
    good = "ticks" in servo and late["reed"] <= late["empty"] + late["clock"] + ALLOWED * periods
    print("passed" if good else "FAILED")
    sys.exit(0 if good else 1)


if __name__ == "__main__":
    main()
