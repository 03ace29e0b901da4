#!/usr/bin/python3
"""How old the positions of a remote device are, over TCP and over UDP, on lines between two computers.

    bench/position_age.py [--build build] [--seconds 20] [--line DELAY_MS,LOSS ...]

A haptic_server in one network namespace moves its handle along x at 4 mm/s, so that each position tells
when it was taken; a remote device in another one reads at 1 kHz (bench_position_age). A row a line and
transport: the age of the newest position at each tick of the reader, in ms, and the share of ticks
without force, since the position was older than 100 ms. Both clocks are this machine's. Needs root.
"""
import argparse
import csv
import pathlib
import re
import subprocess
import sys
import tempfile

import numpy

ROOT = pathlib.Path(__file__).resolve().parents[1]
sys.path.insert(0, str(ROOT / "scripts"))
from emulated_network import EmulatedNetwork, NoNamespaces  # noqa: E402

SPEED_MM_PER_S, REACH_MM = 4.0, 40.0
STALE_MS = 100  # as net/remote_device.cpp has it


def ages_ms(build, transport, seconds, delay_ms, loss, folder):
    """The age of the position at every tick of the reader."""
    token, path, trace = folder / "token", folder / "path", folder / "trace.csv"
    token.write_text("sixteen bytes ok\n")
    token.chmod(0o600)
    path.write_text(f"0 {-REACH_MM} 0 0\n{2e3 * REACH_MM / SPEED_MM_PER_S} {REACH_MM} 0 0\n")
    with EmulatedNetwork(["device", "reader"], delay_ms=delay_ms, loss=loss, nice=-10) as network:
        server = network.start(
            "device", [build / "programs/haptic_server/haptic_server", "--listen",
                       network.address("device"), "--port", 0, "--token", token, "--hand", "rigid",
                       "--path", path, "--trace", trace, "--udp"],
            stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, text=True)
        port = re.search(r"on \S+:(\d+)", server.stdout.readline())[1]
        read = subprocess.run(
            [*network.inside("reader"), build / "bench/haptic_network/bench_position_age",
             network.address("device"), port, transport, str(seconds), token],
            capture_output=True, text=True)
        server.terminate()
        server.wait()
    if read.returncode != 0 or not read.stdout:
        sys.exit(f"position_age: {read.stderr.strip()}")
    if read.stderr:
        print(f"  {transport}: {read.stderr.strip()}", file=sys.stderr)
    rows = numpy.loadtxt(read.stdout.splitlines())
    with open(trace, newline="") as file:
        ticks = [(float(row["x_mm"]), float(row["ms"])) for row in csv.DictReader(file)]
    x_mm, at_ms = numpy.array(ticks).T
    moving = numpy.flatnonzero(numpy.diff(x_mm) > 0)
    if rows[-1, 1] > x_mm[moving[-1]]:
        sys.exit("position_age: the path has ended before the reader: fewer --seconds")
    return rows[:, 0] * 1e3 - numpy.interp(rows[:, 1], x_mm[moving], at_ms[moving])


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--build", type=pathlib.Path, default=ROOT / "build")
    parser.add_argument("--seconds", type=float, default=16)
    parser.add_argument("--line", nargs="+", default=["0,0", "10,0", "10,0.05"],
                        help="one-way delay in ms and share of packets lost")
    words = parser.parse_args()
    if not 0 < words.seconds <= 18:
        parser.error("--seconds is more than 0 and at most 18: then the path ends")
    congestion = pathlib.Path("/proc/sys/net/ipv4/tcp_congestion_control").read_text().strip()
    print(f"age of the position at each of {words.seconds:g} s of 1 kHz ticks, ms; TCP with {congestion}\n"
          "| delay each way | loss | transport | median | 99 % | max | older than 100 ms |\n"
          "|---|---|---|---|---|---|---|")
    for line in words.line:
        delay_ms, loss = map(float, line.split(","))
        for transport in ("TCP", "UDP"):
            with tempfile.TemporaryDirectory() as folder:
                try:
                    ages = ages_ms(words.build, transport, words.seconds, delay_ms, loss,
                                   pathlib.Path(folder))
                except NoNamespaces as missing:
                    sys.exit(f"position_age: {missing}")
            print(f"| {delay_ms:g} ms | {loss:.0%} | {transport} | {numpy.median(ages):.1f} | "
                  f"{numpy.quantile(ages, 0.99):.1f} | {ages.max():.1f} | "
                  f"{numpy.mean(ages > STALE_MS):.2%} |", flush=True)


if __name__ == "__main__":
    main()
