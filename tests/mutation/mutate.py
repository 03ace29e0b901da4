#!/usr/bin/python3
"""Do the tests notice? Small wrong changes, one at a time, built and tested; how many were noticed.

    tests/mutation/mutate.py [ROOM...] [--count 40] [--seed 1] [--everything] [--changed REVISION]
                             [--only PATH[:LINE]] [--folder build-mutation] [-o TABLE.md]

A room is a folder of `rooms.py`. --count changes are drawn from each room with a fixed seed. Each is
made in a copy of the sources, only what depends on it is built, and the room's unit tests run, from the
one that is named like the changed file on. --everything gives what they miss to the tests of the objects
that use the room. --changed draws only from lines that differ from REVISION.

  noticed     a test failed, crashed, or took longer than ten times its usual time
  missed      every test passed: the line is printed with its change
  not counted the change does not compile, or the machine code stays the same

The same seed and sources give the same changes. Prints progress, one line a change, and a table by room.
"""
import argparse
import hashlib
import os
import random
import shutil
import subprocess
import sys
import time
from pathlib import Path

from changes import changes_of
from rooms import ROOMS

ROOT = Path(__file__).resolve().parents[2]
NAMES = {"unit": "noticed by unit tests", "all": "noticed by tests of objects", "missed": "MISSED",
         "compiler": "does not compile", "same": "same machine code"}


def output(*command):
    return subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=True).stdout


def lines_changed(revision):
    """{path: set of line numbers} added since a revision."""
    found, path = {}, None
    for line in output("git", "diff", "-U0", revision, "--", "*.cpp", "*.hpp").splitlines():
        if line.startswith("+++ "):
            path = line[6:]
        elif line.startswith("@@"):
            begin, _, count = line.split("+")[1].split()[0].partition(",")
            found.setdefault(path, set()).update(range(int(begin), int(begin) + int(count or 1)))
    return found


class Workshop:
    """A copy of the sources with a build of its own."""

    def __init__(self, folder):
        self.source, self.build = folder / "source", folder / "build"
        self.source.mkdir(parents=True, exist_ok=True)
        for path in output("git", "ls-files").splitlines():
            here, there = ROOT / path, self.source / path
            if not here.exists():
                continue
            if not there.exists() or there.read_bytes() != here.read_bytes():  # else ninja would build it again
                there.parent.mkdir(parents=True, exist_ok=True)
                shutil.copy2(here, there)
                there.touch()
        for path in self.source.rglob("*"):
            if path.is_file() and not (ROOT / path.relative_to(self.source)).exists():
                path.unlink()
        self.run("cmake", "-S", str(self.source), "-B", str(self.build), "-G", "Ninja",
                 "-DCMAKE_BUILD_TYPE=Release", "-DTACTUS_TESTS=ON")

    def run(self, *command):
        done = subprocess.run(command, capture_output=True, text=True)
        if done.returncode:
            raise SystemExit(f"{' '.join(command)} failed:\n{done.stdout[-3000:]}{done.stderr[-3000:]}")

    def make(self, targets, check=True):
        command = ["ninja", "-C", str(self.build), *targets]
        if check:
            return self.run(*command)
        return subprocess.run(command, capture_output=True).returncode == 0

    def program(self, target):
        found = [p for p in self.build.joinpath("tests").rglob(target) if p.is_file()]
        if not found:
            raise SystemExit(f"no program {target} was built")
        return found[0]

    def digest(self, targets):
        return [hashlib.sha256(self.program(t).read_bytes()).hexdigest() for t in targets]


def passes(command, limit, folder):
    """Whether a command ends well within `limit` seconds."""
    child = subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL, cwd=folder,
                             start_new_session=True)
    try:
        return child.wait(limit) == 0
    except subprocess.TimeoutExpired:
        os.killpg(child.pid, 9)
        child.wait()
        return False


class Room:
    """A folder of sources with the tests that answer for it."""

    def __init__(self, name, workshop, everything):
        self.name, self.workshop = name, workshop
        self.targets, self.patterns = ROOMS[name]["unit"], ROOMS[name]["all"] if everything else ""
        workshop.make(self.targets if not everything else [])
        self.usual = {}
        for target in self.targets:
            begin = time.monotonic()
            if not passes([str(workshop.program(target))], 1800, workshop.build):
                raise SystemExit(f"{target} fails before any change")
            self.usual[target] = time.monotonic() - begin
        if self.patterns:
            begin = time.monotonic()
            if not passes(self.all_tests(), 3600, workshop.build):
                raise SystemExit(f"{self.patterns} fail before any change")
            self.usual_all = time.monotonic() - begin
        self.digests = workshop.digest(self.targets)

    def all_tests(self):
        return ["ctest", "--test-dir", str(self.workshop.build), "-j2", "--stop-on-failure", "-R", self.patterns]

    def noticed_by_units(self, stem):
        """The tests whose file is named like the source come first: most changes end there."""
        for target in self.targets:
            program = str(self.workshop.program(target))
            limit = 10 * self.usual[target] + 20
            near = f"--source-file=*{stem.split('_')[0]}*"
            if not passes([program, "--abort-after=1", near], limit, self.workshop.build):
                return True
            if not passes([program, "--abort-after=1"], limit, self.workshop.build):
                return True
        return False

    def judge(self, change):
        path = self.workshop.source / change.path
        text = path.read_text()
        path.write_text(change.apply(text))
        try:
            if not self.workshop.make(self.targets, check=False):
                return "compiler"
            if self.workshop.digest(self.targets) == self.digests:
                return "same"
            if self.noticed_by_units(path.stem):
                return "unit"
            if self.patterns:
                self.workshop.make([])
                if not passes(self.all_tests(), 10 * self.usual_all + 60, self.workshop.build):
                    return "all"
            return "missed"
        finally:
            path.write_text(text)


def drawn(room, seed, count, changed, only):
    """So many changes of a room, at most one a line, in a fixed order."""
    randomness = random.Random(f"{seed} {room}")
    found = []
    for folder in ROOMS[room]["sources"]:
        for path in sorted([ROOT / folder] if (ROOT / folder).is_file() else (ROOT / folder).rglob("*.[ch]pp")):
            name = str(path.relative_to(ROOT))
            if any(name.startswith(other) for other in ROOMS[room].get("without", [])):
                continue
            found += changes_of(name, path.read_text(), randomness)
    if changed is not None:
        found = [c for c in found if c.line in changed.get(c.path, ())]
    if only:
        path, _, line = only.partition(":")
        found = [c for c in found if c.path == path and (not line or c.line == int(line))]
    randomness.shuffle(found)
    if only:
        return found[:count]
    seen, kept = set(), []
    for change in found:
        if (change.path, change.line) not in seen:
            seen.add((change.path, change.line))
            kept.append(change)
    return kept  # the caller stops at `count` that count


def table(results, everything):
    lines = ["| room | changes | noticed by unit tests |" + (" by all |" if everything else ""),
             "|---|---|---|" + ("---|" if everything else "")]
    for room, judged in results.items():
        verdicts = [v for _, v in judged if v not in ("compiler", "same")]
        total, unit = len(verdicts), verdicts.count("unit")
        share = lambda n: f"{n} ({100 * n / max(total, 1):.0f} %)"
        lines.append(f"| {room} | {total} | {share(unit)} |"
                     + (f" {share(unit + verdicts.count('all'))} |" if everything else ""))
    missed = [str(c) for judged in results.values() for c, v in judged if v == "missed"]
    return "\n".join(lines + ["", "Missed:", ""] + [f"- {m}" for m in missed]) + "\n"


def main():
    words = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    words.add_argument("room", nargs="*", help=f"of {', '.join(ROOMS)}; all if none is named")
    words.add_argument("--count", type=int, default=40)
    words.add_argument("--seed", type=int, default=1)
    words.add_argument("--everything", action="store_true")
    words.add_argument("--changed", metavar="REVISION")
    words.add_argument("--only", metavar="PATH[:LINE]")
    words.add_argument("--folder", type=Path, default=ROOT / "build-mutation")
    words.add_argument("-o", metavar="TABLE.md", dest="table", type=Path)
    order = words.parse_args()
    unknown = [r for r in order.room if r not in ROOMS]
    if unknown:
        raise SystemExit(f"no room is called {unknown[0]}; expected one of {', '.join(ROOMS)}")
    changed = lines_changed(order.changed) if order.changed else None
    workshop, results = Workshop(order.folder.resolve()), {}
    for name in order.room or ROOMS:
        changes = drawn(name, order.seed, order.count, changed, order.only)
        if not changes:
            continue
        print(f"{name}: building and running its tests unchanged", file=sys.stderr)
        room, judged, counted = Room(name, workshop, order.everything), [], 0
        for change in changes:
            if counted == order.count:
                break
            begin = time.monotonic()
            verdict = room.judge(change)
            judged.append((change, verdict))
            counted += verdict not in ("compiler", "same")
            print(f"{counted}/{order.count} {NAMES[verdict]}: {change} ({time.monotonic() - begin:.0f} s)", flush=True)
        results[name] = judged
        workshop.make(room.targets)
    text = table(results, order.everything)
    print("\n" + text)
    if order.table:
        order.table.write_text(text)


if __name__ == "__main__":
    main()
