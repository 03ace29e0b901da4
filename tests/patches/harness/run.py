"""Runs Pd without a screen or sound card and checks what it prints.

Pd leaves with status 0 whatever went wrong and runs for ever when a patch is missing, so every
line it prints is read, a time limit set and each recording demanded. Recording goes through
[tabwrite~] and [soundfiler]: [writesf~] loses blocks in batch mode when the machine is busy.
"""
import csv
import dataclasses
import os
import pathlib
import re
import signal
import subprocess
import tempfile
import time

import numpy
import scipy.io.wavfile

ROOT = pathlib.Path(__file__).resolve().parents[3]
BAD_LINE = re.compile(r"error|couldn't create|no method|no such|can't|multiply defined|failed"
                      r"|too many|stack overflow|assert", re.IGNORECASE)
LOG_LINE = re.compile(r"^harness-log\.(\S+): ?(.*)$")
LOG_CAPACITY = 1 << 18
BEYOND = 1e18  # stands in a recording for what is not finite


class PdFailure(AssertionError):
    """Pd did not do what was asked; the text says what it printed."""


@dataclasses.dataclass
class Render:
    """recordings by label (also render["label"]) as float32 arrays of seconds * rate samples;
    logs by label, a list of (ms, [atoms]); arrays by name; the errors that were expected; output,
    what Pd printed besides; wall_seconds, what it took."""
    rate: int
    recordings: dict
    logs: dict
    arrays: dict
    errors: list
    output: str
    wall_seconds: float

    def __getitem__(self, label):
        return self.recordings[label]


def stage_folder():
    """The library folder under test."""
    return pathlib.Path(os.environ.get("TACTUS_STAGE", ROOT / "build" / "tactus")).resolve()


def processor_seconds(pid):
    """User and system time of a process and its threads, 0 when it has ended."""
    try:
        fields = pathlib.Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()
    except OSError:
        return 0.0
    return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")


def printed(output, errors):
    """What a process printed: its lines of the standard error, then those of the standard output."""
    return (errors + output).decode(errors="replace")


def run_pd(patches, rate=48000, timeout=60, path=(), preload="", environment=None, arguments=()):
    """Runs `pd -batch` on the patches until one sends `; pd quit`; returns what Pd printed.

    Raises PdFailure on a time-out or an exit status other than 0. timeout: seconds of processor
    time, so that a busy machine fails no test; or ten times as long by the clock, for a Pd that
    waits for ever. preload names a library to load into Pd, TACTUS_PD_SLOW multiplies the time
    limit (for runs under sanitizers)."""
    # -nrt: no watchdog, which writes into the middle of a line when an object makes Pd wait.
    command = ["pd", "-nogui", "-batch", "-nosound", "-noprefs", "-nrt",
               "-stderr", "-r", str(rate)]
    for folder in path:
        command += ["-path", str(folder)]
    command += [str(a) for a in arguments]
    for patch in patches:
        if not pathlib.Path(patch).is_file():
            raise PdFailure(f"no patch {patch}")
        command += ["-open", str(patch)]
    variables = dict(os.environ, **(environment or {}))
    if preload:
        variables["LD_PRELOAD"] = str(preload)
    limit = timeout * float(os.environ.get("TACTUS_PD_SLOW", "1"))
    # Two pipes: what libraries write to the standard output in blocks would cut Pd's lines in two.
    process = subprocess.Popen(command, stdin=subprocess.DEVNULL, stdout=subprocess.PIPE,
                               stderr=subprocess.PIPE, env=variables, start_new_session=True)
    begun, said = time.monotonic(), None
    while said is None:
        try:
            left = max(limit - processor_seconds(process.pid), 0.1)
            said = printed(*process.communicate(timeout=left))
        except subprocess.TimeoutExpired:
            if (processor_seconds(process.pid) < limit
                    and time.monotonic() - begun < 10 * limit):
                continue
            os.killpg(process.pid, signal.SIGKILL)
            said = printed(*process.communicate())
            raise PdFailure(f"Pd did not finish within {limit:g} s\n{said[-4000:]}") from None
    if process.returncode:
        raise PdFailure(f"Pd ended with status {process.returncode}\n{said[-8000:]}")
    return said


def read_trace(file):
    """Columns of a servo's trace, by name, each an array."""
    with open(file, encoding="utf-8") as rows:
        table = list(csv.DictReader(rows))
    return {name: numpy.array([float(row[name]) for row in table]) for name in table[0]}


def sort_lines(said, expect_errors):
    """Splits what Pd printed into log lines by label, expected errors and the rest; raises
    PdFailure for an error that nobody expected or an expected one that did not come."""
    logs, errors, rest = {}, [], []
    missing = dict.fromkeys(expect_errors)
    for line in said.splitlines():
        log = LOG_LINE.match(line)
        if log:
            logs.setdefault(log.group(1), []).append(log.group(2))
            continue
        wanted = [e for e in expect_errors if re.search(e, line)]
        for e in wanted:
            missing.pop(e, None)
        if wanted:
            errors.append(line)
        elif BAD_LINE.search(line):
            raise PdFailure(f"Pd says: {line}\n--- all it said:\n{said[-8000:]}")
        else:
            rest.append(line)
    if missing:
        raise PdFailure(f"Pd did not say {', '.join(missing)}\n--- it said:\n{said[-8000:]}")
    return logs, errors, "\n".join(rest)


def hear_dac(source):
    """A patch text whose [dac~] boxes feed the harness instead of the sound card."""
    return re.sub(r"(#X obj -?\d+ -?\d+) dac~((?: [\d.e+]+)*)((?:, f \d+)?;)", r"\1 harness-dac~\2\3",
                  source)


DAC = """#N canvas 0 0 400 200 12;
#X obj 20 20 inlet~;
#X obj 120 20 inlet~;
#X obj 20 60 throw~ harness-dac-1;
#X obj 180 60 throw~ harness-dac-2;
#X connect 0 0 2 0;
#X connect 1 0 3 0;
"""


def write_patch(patch, folder, samples, rate, dsp):
    """The patch file: the drawn canvas, and around it what starts, ends and saves the run."""
    control = ["#N canvas 0 0 800 600 12;"]
    control += ["#N canvas 0 0 600 400 graph 0;", *patch.lines(), "#X restore 20 20 pd graph;"]
    boxes, cords = 1, []

    def box(line):
        nonlocal boxes
        control.append(line)
        boxes += 1
        return boxes - 1

    def chain(outlet, *lines):
        previous, port = outlet
        for line in lines:
            index = box(line)
            cords.append((previous, port, index, 0))
            previous, port = index, 0

    for name in patch.recordings.values():
        box(f"#X obj 20 60 table {name} {samples};")
    for name in patch.log_tables.values():
        box(f"#X obj 20 60 table {name} {LOG_CAPACITY};")
    for name in patch.inputs:
        box(f"#X obj 20 60 table {name} 100;")
    load = box("#X obj 20 100 loadbang;")
    order = box("#X obj 20 120 t b b b b;")
    cords.append((load, 0, order, 0))
    for name in patch.inputs:
        chain((order, 3), f"#X msg 20 140 read -resize -maxsize 2e+08 {name}.wav {name};",
              "#X obj 20 160 soundfiler;")
    chain((order, 2), f"#X msg 20 180 \\; pd dsp {int(dsp)};")
    chain((order, 1), "#X obj 20 200 s harness-start;")
    # Block sizes up to 4096 record in steps of that size; the surplus is cut off.
    ms = 1000.0 * (samples + 2 * 4096) / rate
    end = box(f"#X obj 20 220 delay {ms:.9g};")
    cords.append((order, 0, end, 0))
    done = box("#X obj 20 240 t b b;")
    cords.append((end, 0, done, 0))
    cords.append((box("#X obj 100 220 r harness-end;"), 0, done, 0))
    saved = {**{n: n for n in patch.recordings.values()}, **{n: n for n in patch.log_tables.values()},
             **{n: f"array-{i}" for i, n in enumerate(patch.arrays)}}
    for name, file in saved.items():
        chain((done, 1), f"#X msg 20 260 write -wave -bytes 4 -rate {rate} {file}.wav {name};",
              "#X obj 20 280 soundfiler;")
    chain((done, 0), "#X msg 20 300 \\; pd quit;")
    control += ["#X connect " + " ".join(map(str, c)) + ";" for c in cords]
    path = folder / "harness.pd"
    path.write_text("\n".join(control) + "\n")
    return path


def read_wav(path):
    if not path.is_file():
        raise PdFailure(f"Pd left no {path.name}")
    return scipy.io.wavfile.read(path)[1]


def mark_not_finite(label, samples, allowed):
    """Puts NaN where the recorder met NaN, infinity or a number too large to keep."""
    bad = numpy.abs(samples) >= numpy.float32(BEYOND)
    if bad.any():
        if not allowed:
            raise PdFailure(f"{label} is not finite at {bad.sum()} samples, first {bad.argmax()}")
        samples = numpy.where(bad, numpy.float32("nan"), samples)
    return samples


def words_and_numbers(lines, exact):
    """Joins the printed words of a log with the exact numbers of its array."""
    entries, position = [], 0
    for line in lines:
        words = line.split()
        length = int(exact[position]) if position < len(exact) else 0
        numbers = exact[position + 1:position + 1 + length]
        position += 1 + length
        atoms = []
        for i, word in enumerate(words):
            try:
                value = float(word)
            except ValueError:
                atoms.append(word)
                continue
            atoms.append(float(numbers[i]) if i < len(numbers) and length == len(words) else value)
        if not atoms or isinstance(atoms[0], str):
            raise PdFailure(f"a log has a line without its time: {line!r} after {lines[:len(entries)][-2:]}")
        entries.append((atoms[0], atoms[1:]))
    return entries


def render(patch, seconds, rate=48000, expect_errors=(), timeout=60, keep=None, path=(),
           environment=None, preload="", allow_not_finite=False, dsp=True):
    """See Patch.render.

    expect_errors  regular expressions: lines that Pd must print and that are then no failure
    timeout        seconds of processor time; see run_pd
    keep           a folder to leave the patch and all files in, to be looked at
    path           folders to search for abstractions besides the library
    allow_not_finite  else a recording with NaN or infinity is a failure; they come back as NaN
    dsp            False: the sound stays off until a patch switches it on; recordings start then
    """
    samples = round(seconds * rate)
    with tempfile.TemporaryDirectory(prefix="tactus-") as temporary:
        folder = pathlib.Path(keep or temporary).resolve()
        folder.mkdir(parents=True, exist_ok=True)
        for name, values in patch.inputs.items():
            scipy.io.wavfile.write(folder / f"{name}.wav", int(rate),
                                   numpy.asarray(values, dtype=numpy.float32))
        opened = []
        stage = stage_folder()
        if not stage.is_dir():
            raise PdFailure(f"no library folder {stage}: build first")
        if patch.opens:
            (folder / "harness-dac~.pd").write_text(DAC)
            own = {p.name for p in patch.opens}
            for source in [*patch.opens, *(p for p in stage.glob("*.pd") if p.name not in own)]:
                text = source.read_text()
                if patch.own and source in patch.opens:
                    text = text.replace("\\$0", patch.own)
                if source in patch.opens or "dac~" in text:
                    (folder / source.name).write_text(hear_dac(text))
            opened = [folder / p.name for p in patch.opens]
        siblings = {p.resolve().parent for p in patch.opens} - {stage}
        main = write_patch(patch, folder, samples, rate, dsp)
        begun = time.monotonic()
        said = run_pd([*opened, main], rate, timeout,
                      [folder, *path, *sorted(siblings), stage], preload, environment)
        wall_seconds = time.monotonic() - begun
        logs, errors, rest = sort_lines(said, expect_errors)
        recordings = {label: mark_not_finite(label, read_wav(folder / f"{name}.wav")[:samples],
                                             allow_not_finite)
                      for label, name in patch.recordings.items()}
        arrays = {name: read_wav(folder / f"array-{i}.wav") for i, name in enumerate(patch.arrays)}
        joined = {label: words_and_numbers(logs.get(label, []), read_wav(folder / f"{name}.wav"))
                  for label, name in patch.log_tables.items()}
    return Render(int(rate), recordings, joined, arrays, errors, rest, wall_seconds)
