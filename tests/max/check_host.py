#!/usr/bin/env python3
"""Does the stub host behave as its README says: signals, time, inlets, attributes, files?

    check_host.py MODULE FOLDER -- HOST...

MODULE is small~: its outlet is inlet 0 times inlet 1 (or the last float there) times gain."""
import math
import pathlib
import struct
import subprocess
import sys

from warm_host import warm

RATE = 48000
FAILURES = []


def expect(holds, what):
    if not holds:
        FAILURES.append(what)


class Host:
    def __init__(self, command, module, folder):
        self.command, self.module, self.folder = command, module, folder

    def play(self, script, status=0):
        """Lines of a script's run with small~ loaded."""
        run = subprocess.run(self.command, input=f'load "{self.module}"\n' + script, capture_output=True,
                             text=True, errors="replace", timeout=120, cwd=self.folder)
        if run.returncode != status:
            FAILURES.append(f"status {run.returncode}, expected {status}: {script}{run.stdout}{run.stderr}")
        return run.stdout.splitlines()

    def render(self, script, vectors, status=0):
        """Samples of box a's outlet."""
        file = self.folder / "out.f64"
        self.play(f"{script}\nrecord a out.f64\ndsp on\nrun {vectors}\n", status)
        return list(struct.unpack(f"{file.stat().st_size // 8}d", file.read_bytes()))


def noise(seed, count):
    """The README's noise."""
    mask, samples = 2**64 - 1, []
    for n in range(count):
        x = (seed + n + 0x9E3779B97F4A7C15) & mask
        x = ((x ^ (x >> 30)) * 0xBF58476D1CE4E5B9) & mask
        x = ((x ^ (x >> 27)) * 0x94D049BB133111EB) & mask
        x ^= x >> 31
        samples.append(2 * (x >> 11) * 2.0**-53 - 1)
    return samples


def check_signals(host):
    """Test signals are what they say; the product is the external's; nothing depends on the vector."""
    box = "new a small~ @gain 0.5\n"
    got = host.render(box + "signal a 0 noise 7 1\nsignal a 1 constant 3", 4)
    expect(got == [v * 3 * 0.5 for v in noise(7, 256)], "noise times a constant")
    got = host.render(box + "signal a 0 sine 440 0.25\nsend a 1 float 2", 4)
    theory = [0.25 * math.sin(2 * math.pi * 440 * n / RATE) for n in range(256)]
    expect(len(got) == 256 and all(abs(g - t) < 1e-13 for g, t in zip(got, theory)), "a sine times the last float")
    expect(host.render(box + "signal a 0 sine 440 1\nsend a 0 float 2", 1) == [0.0] * 64, "a float in inlet 0 is not inlet 1's")
    whole = host.render(box + "vector 2048\nsignal a 0 noise 1 1\nsignal a 1 noise 2 1", 1)
    for vector in (1, 2, 64, 512):
        for inplace in ("off", "same", "crossed"):
            part = host.render(f"{box}vector {vector}\ninplace {inplace}\nsignal a 0 noise 1 1\nsignal a 1 noise 2 1",
                               2048 // vector)
            expect(part == whole, f"vectors of {vector}, in place {inplace}")
    chained = host.render("new b small~ @gain 3.\nsignal b 0 noise 1 1\nsend b 1 float 1\nnew a small~\n"
                          "signal a 0 box b 0\nsend a 1 float 1", 2)
    expect(chained == [3 * v for v in noise(1, 128)], "a box's signal into another box")
    lines = host.play(box + "signal a 0 nan\nsend a 1 float 1\ndsp on\nrun 1\nlevels a\n")
    expect("level: a 0 0.0 0.0 64" in lines, "levels count what is not finite")


def check_files(host):
    """float64 and WAV files as signals, the search path, the patcher's path, buffer~."""
    samples = noise(3, 64)
    (host.folder / "in.f64").write_bytes(struct.pack("64d", *samples))
    got = host.render('new a small~\nsend a 1 float 1\nsignal a 0 file in.f64', 2)
    expect(got == samples + [0.0] * 64, "a float64 file, then silence")
    whole = [-32768, 32767, 1, 0, -1, 12345]
    frames = struct.pack("<12h", *[v for w in whole for v in (0, w)])
    header = b"RIFF" + struct.pack("<I", 36 + len(frames)) + b"WAVEfmt " + struct.pack(
        "<IHHIIHH", 16, 1, 2, RATE, RATE * 4, 4, 16) + b"data" + struct.pack("<I", len(frames))
    (host.folder / "in.wav").write_bytes(header + frames)
    got = host.render('new a small~\nsend a 1 float 1\nsignal a 0 wav in.wav 1', 1)
    expect(got[:6] == [w / 32768 for w in whole], "channel 1 of a WAV file")
    (host.folder / "sub").mkdir(exist_ok=True)
    (host.folder / "sub" / "known.txt").write_text("")
    lines = host.play('searchpath sub\npatcher sub/some.maxpat\nbuffer samples 2 100 constant 0.25\nnew a small~\n'
                      'send a 0 find known.txt\nsend a 0 find unknown.txt\nsend a 0 patcher\nsend a 0 sum\n'
                      'patcher sub/some.maxpat subpatcher\nnew b small~\nsend b 0 patcher\n')
    expect(any(l.endswith("/sub/known.txt") and " found " in l for l in lines), "a file of the search path")
    expect("error: small~ a: unknown.txt: no such file" in lines, "a file that is nowhere")
    paths = [(l.split()[2], l.endswith("/sub/some.maxpat")) for l in lines if l.startswith("out: ") and l.split()[3] == "1"
             and ("some.maxpat" in l or l.split()[4:] in ([], ['""']))]
    expect(paths == [("a", True), ("a", True), ("b", False), ("b", True)],
           f"the path of the patcher, and of the one around a subpatcher, which has none: {paths}")
    expect("out: 0.0 a 1 float 50.0" in lines, "the sum of a buffer~")


def check_time(host):
    """Clocks run at their logical time, whatever the vector; low priority when it is served."""
    for vector in (16, 512):
        lines = host.play(f"vector {vector}\nnew a small~\nsend a 0 bang\ndsp on\nrun {4096 // vector}\nsend a 0 bang\nadvance 6\n")
        times = [float(l.split()[1]) for l in lines if l.startswith("out: ")]
        expect(len(times) == 2 and times[0] == 5 and abs(times[1] - (4096 * 1000 / RATE + 5)) < 1e-9,
               f"clocks with vectors of {vector}: {times}")
    host.play("overdrive off\nnew a small~\nthread scheduler\nsend a 0 bang\nthread main\nadvance 6\n")
    host.play("new a small~\nrepeat 300\nnew b small~ @gain 2\nsend b 0 bang\nfree b\nend\n")


def check_messages(host):
    """Which method gets what, and what is refused."""
    lines = host.play("new a small~ 1 2.5 word @gain 0.5 @nothing 3\nnew a2 nothing~\ndescribe a\nsend a 0 int 3\n"
                      "send a 0 list 4.\nsend a 0 list 4. 5 x\nsend a 0 float\nsend a 0 float word\nsend a 7 bang\n"
                      "send a 0 dsp64\nsend a 0 gain word\nsend a 0 getgain\nsend a 0 float #nan\n")
    for line in ('error: small~: "nothing" is not a valid attribute argument', "error: max: nothing~: no such object",
                 "inlet: a 1 signal (signal/float) factor", "inlet: a 2 message (message) words",
                 "outlet: a 0 signal (signal) product", "out: 0.0 a 1 float 3.0", "out: 0.0 a 1 list 4.0",
                 "out: 0.0 a 1 list 4.0 5 x", 'error: small~ a: bad arguments for message "float"',
                 "error: small~ a: has no inlet 7", 'error: small~ a: doesn\'t understand "dsp64"',
                 "error: small~ a: gain: expected a number", "out: 0.0 a 2 gain 0.5", "out: 0.0 a 1 float nan"):
        expect(line in lines, f"{line} in {lines}")
    lines = host.play("new a small~\nnew b small~\ncord a 1 b 0\ncord b 1 a 0\nsend a 0 float 1\n")
    expect(any("stack overflow" in l for l in lines), "messages in a circle end")
    lines = host.play("new a small~ @gain 4\nsave state.txt\nset a gain 5\nget a gain\nrestore state.txt\nget a gain\n")
    expect(lines == ["value: a gain 5.0", "value: a gain 4.0"], f"saved and restored: {lines}")
    host.play("new a small~\nsend nobody 0 bang\n", status=2)
    host.play("nonsense\n", status=2)
    host.play("new a small~\nexpect a outlets signal\n", status=3)


def main(module, folder, _, *command):
    folder = pathlib.Path(folder).resolve() / "host"
    folder.mkdir(parents=True, exist_ok=True)
    host = Host(command, pathlib.Path(module).resolve(), folder)
    with warm(command):
        for check in (check_signals, check_files, check_time, check_messages):
            check(host)
    for failure in FAILURES:
        print("not so:", failure)
    print(f"{len(FAILURES)} failures")
    return 1 if FAILURES else 0


if __name__ == "__main__":
    sys.exit(main(*sys.argv[1:]))
