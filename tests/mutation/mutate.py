#!/usr/bin/python3
"""Do the tests notice? Small wrong changes, all compiled in at once, of which each run makes one; how many are noticed.

    tests/mutation/mutate.py [FOLDER...] [--count 30] [--seed 1] [--jobs 2] [--at-least PERCENT] [--resume]
                             [--full] [--targets PROGRAM...] [--folder build-mutation] [--record docs/results/mutation.md]

--count changes are drawn with a fixed seed, evenly over the folders. In a copy of the sources each becomes a switch
between what was and what is wrong (switches.hpp), and the copy is built once. The quick tests of ./test run once
unchanged and tell which switches they pass: a program of doctest cases by the case, others as a whole. Each change is
then made, by the environment, in the tests that pass its switch, programs first, until one fails.

  noticed     a test failed, crashed, or took longer than ten times its usual time and 10 s
  missed      every test passed; or none passes the switch
  not counted what does not compile, what the compiler decides already (no test passes a switch in a member's default
              value or a constexpr function), or what is listed with the reason why no test can notice it (equivalent.toml)

No switch can stand in a constant expression, a bound, a template's argument, the preprocessor or a file with vectors of
numbers: these are not drawn.
The same seed and sources give the same changes. Prints a line for each and a table; FOLDER/SEED.json keeps the verdicts,
with which --resume goes on. Ctrl-C ends it with the table of what it has by then. --at-least: status 1 where fewer are
noticed. --record puts the rows into a page's table. --targets: only these are built, and what is no program is not run:
minutes for a folder and its own unit tests. --full: what the quick cases miss is tried against the slow ones too.
"""
import argparse
import json
import os
import random
import re
import shutil
import signal
import subprocess
import tempfile
import threading
import time
import tomllib
from concurrent.futures import ThreadPoolExecutor
from contextlib import ExitStack
from datetime import date
from pathlib import Path

from changes import changes_of

HERE = Path(__file__).resolve().parent
ROOT = HERE.parents[1]
FOLDERS = ["core", "core/contact", "core/footstep", "core/haptic", "core/modal", "core/particle", "core/reed", "devices",
           "externals", "fem", "files", "max", "net", "pd", "programs"]  # a file is of the longest that it is in
HEAD = "| folder | seed | changes | noticed by ./test | equivalent | date |"
NUMBERS = 4096  # as in switches.hpp
VECTORS = re.compile(r"core/dsp/(vector|simd)\.hpp|vector_size")  # g++ 12 crashes over a switch in such a file


def output(*command, **more):
    return subprocess.run(command, cwd=ROOT, capture_output=True, text=True, **more).stdout


def drawn(folder, seed):
    """The changes of a folder, at most one a line, in the order of the draw."""
    randomness, found = random.Random(f"{seed} {folder}"), {}
    for path in sorted((ROOT / folder).rglob("*.[ch]pp")):
        name = str(path.relative_to(ROOT))
        text = path.read_text()
        if max((f for f in FOLDERS if name.startswith(f + "/")), key=len) == folder and not VECTORS.search(text):
            changes = changes_of(name, text, randomness)
            randomness.shuffle(changes)
            found.update({(c.path, c.line): c for c in changes})
    order = list(found.values())
    randomness.shuffle(order)
    return order


class Equivalents:
    """Changes that no test can notice, each with its reason (equivalent.toml)."""

    def __init__(self):
        self.entries = tomllib.loads((HERE / "equivalent.toml").read_text())["change"]
        for entry in self.entries:
            path = ROOT / entry["path"]
            times = [line.strip() for line in path.read_text().split("\n")].count(entry["line"]) if path.exists() else 0
            if times == 0 or times > 1 and not entry.get("every"):
                raise SystemExit(f"equivalent.toml: {entry['path']} has the line `{entry['line']}` {times} times; "
                                 "expected once: write the entry anew, drop it, or say `every = true`")

    def __contains__(self, change):
        line = (ROOT / change.path).read_text().split("\n")[change.line - 1]
        words = (change.path, line.strip(), change.old, change.new, line[:change.column].count(change.old))
        return any(words == (e["path"], e["line"], e["old"], e["new"], e.get("nth", 0)) for e in self.entries)


class Workshop:
    """A copy of the sources as they are in the work tree, with switches, and its build."""

    def __init__(self, folder, jobs, changes):
        self.source, self.build, self.jobs = folder / "source", folder / "build", jobs
        self.changes = dict(changes)  # by number; without those that do not compile
        self.files = output("git", "ls-files", "--cached", "--others", "--exclude-standard", check=True).splitlines()

    def write(self):
        by_path = {}
        for number, change in self.changes.items():
            by_path.setdefault(change.path, []).append((number, change))
        for path in filter(lambda path: (ROOT / path).is_file(), self.files):
            here, there = ROOT / path, self.source / path
            content = here.read_bytes()
            if path in by_path:
                lines = content.decode().split("\n")
                for number, change in by_path[path]:
                    lines[change.line - 1] = change.switched(lines[change.line - 1], number)
                content = "\n".join([f'#include "{HERE}/switches.hpp"', *lines]).encode()
            if not there.exists() or there.read_bytes() != content:  # else ninja would build it again
                there.parent.mkdir(parents=True, exist_ok=True)
                there.write_bytes(content)
                shutil.copymode(here, there)
        for path in self.source.rglob("*"):
            if path.is_file() and not (ROOT / path.relative_to(self.source)).exists():
                path.unlink()

    def make(self, *targets):
        """Builds; leaves out the changes at whose lines the compiler stops."""
        while True:
            self.write()
            configured = output("cmake", "-S", self.source, "-B", self.build, "-G", "Ninja", "-DCMAKE_BUILD_TYPE=Release",
                                "-DTACTUS_TESTS=ON", "-DCMAKE_CXX_FLAGS=-w -Wno-narrowing")
            done = subprocess.run(["ninja", "-C", self.build, "-j", str(self.jobs), "-k", "0", *targets],
                                  capture_output=True, text=True)
            if done.returncode == 0:
                break
            said = {(path, int(line) - 1) for path, line in re.findall(rf"{self.source}/([^\s:]+):(\d+)", done.stdout)}
            wrong = [n for n, c in self.changes.items() if (c.path, c.line) in said]
            if not wrong:
                raise SystemExit(f"the build fails:\n{configured[-1000:]}{done.stdout[-5000:]}{done.stderr}")
            for number in wrong:
                print(f"no switch can stand here: {self.changes.pop(number)}", flush=True)
        read = output("ninja", "-C", self.build, "-t", "deps")
        self.changes = {n: c for n, c in self.changes.items() if f"{self.source}/{c.path}\n" in read}

    def entries(self, slow=False):
        """What `./test` runs of it; slow: what `./test --full` adds."""
        tests = json.loads(output("ctest", "--test-dir", self.build, "--show-only=json-v1"))["tests"]
        made = [test for test in tests if "command" in test]  # not the programs of the thread sanitizer
        return [e for e in map(Entry, made) if not e.labels & {"threads", "night"} and e.name != "bodies"
                and ("slow" in e.labels) == slow]


class Entry:
    """One entry of ctest, and which switches it passes."""
    locks = {}

    def __init__(self, test):
        said = {p["name"]: p["value"] for p in test["properties"]}
        self.name, self.command, self.folder = test["name"], test["command"], said["WORKING_DIRECTORY"]
        self.environment = dict(line.split("=", 1) for line in said.get("ENVIRONMENT", []))
        self.labels = set(said.get("LABELS", []))
        self.fine = {0, said.get("SKIP_RETURN_CODE", 0)}
        self.resources = sorted({self.name, *said.get("RESOURCE_LOCK", [])})
        for resource in self.resources:
            self.locks.setdefault(resource, threading.Lock())
        self.is_program = len(self.command) == 2 and self.command[1].startswith("--test-suite")  # of doctest cases
        self.parts = {}  # by case, or "" for the whole: seconds, and the switches that it passes

    def cases(self):
        listed = output(*self.command, "--list-test-cases").split("=" * 79 + "\n") if self.is_program else []
        return listed[1].splitlines() if len(listed) > 2 else [""]

    def run(self, parts=("",), limit=3600, words=(), **environment):
        """Whether it ends well within `limit` seconds."""
        if parts[0]:
            words = ["--test-case=" + ",".join(re.sub(r"[\\,]", "?", part) for part in parts), *words]
        with ExitStack() as held:
            for resource in self.resources:
                held.enter_context(self.locks[resource])
            child = subprocess.Popen([*self.command, *words], stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL,
                                     cwd=self.folder, start_new_session=True,
                                     env={**os.environ, **self.environment, **environment})
            try:
                return child.wait(limit) in self.fine
            except subprocess.TimeoutExpired:
                return False
            finally:
                if child.returncode is None:
                    os.killpg(child.pid, signal.SIGKILL)
                    child.wait()

    def measure(self):
        """Runs it unchanged."""
        for part in self.cases():
            with tempfile.NamedTemporaryFile() as file:
                file.truncate(NUMBERS)
                for _ in range(2):
                    begin = time.monotonic()
                    if self.run([part], TACTUS_MUTANTS_REACHED=file.name):
                        reached = {n for n, byte in enumerate(Path(file.name).read_bytes()) if byte}
                        self.parts[part] = time.monotonic() - begin, reached
                        break
                else:
                    print(f"left out, fails before any change: {self.name} {part}", flush=True)

    def try_of(self, number):
        """(Whether it is no program, usual seconds, it, its parts that pass a switch): in the order of trying."""
        parts = [part for part, (_, reached) in self.parts.items() if number in reached]
        return not self.is_program, sum(self.parts[part][0] for part in parts), self, parts

    def notices(self, number, seconds, parts):
        """What is more than a program may fail for another reason: it must fail twice."""
        words = ["--abort-after=1"] if self.is_program else []
        return not any(self.run(parts, 10 * seconds + 10, words, TACTUS_MUTANT=str(number))
                       for _ in range(1 if self.is_program else 2))


def verdict_of(number, entries):
    """The name of the entry that notices a change, or that it is missed."""
    tries = sorted((e.try_of(number) for e in entries), key=lambda one: one[:2])
    missed = "missed" if any(parts for *_, parts in tries) else "missed, not reached"
    return next((e.name for _, seconds, e, parts in tries if parts and e.notices(number, seconds, parts)), missed)


def row(folder, seed, noticed, total, equivalent):
    return f"| {folder} | {seed} | {total} | {noticed} ({100 * noticed / max(total, 1):.0f} %) | {equivalent} | {date.today()} |"


def record(path, rows):
    """Puts rows into the table of a page, in the place of older ones of the same folder and seed."""
    lines = path.read_text().split("\n")
    begin = lines.index(HEAD) + 2
    end = next(i for i in range(begin, len(lines) + 1) if i == len(lines) or not lines[i].startswith("|"))
    table = {tuple(line.split("|")[1:3]): line for line in [*lines[begin:end], *rows]}
    path.write_text("\n".join([*lines[:begin], *table.values(), *lines[end:]]))


def main():
    words = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    words.add_argument("folder_of_sources", metavar="FOLDER", nargs="*", help=f"of {', '.join(FOLDERS)}; all if none is named")
    words.add_argument("--count", type=int, default=30)
    words.add_argument("--seed", default="1")
    words.add_argument("--jobs", type=int, default=2)
    words.add_argument("--at-least", metavar="PERCENT", type=float, default=0)
    words.add_argument("--resume", action="store_true")
    words.add_argument("--folder", type=Path, default=ROOT / "build-mutation")
    words.add_argument("--targets", metavar="PROGRAM", nargs="+", default=[])
    words.add_argument("--full", action="store_true")
    words.add_argument("--record", metavar="PAGE.md", type=Path)
    order = words.parse_args()
    folders = order.folder_of_sources or FOLDERS
    if not set(folders) <= set(FOLDERS):
        raise SystemExit(f"no folder is called {(set(folders) - set(FOLDERS)).pop()}; expected one of {', '.join(FOLDERS)}")
    share, equivalents = -(-order.count // len(folders)), Equivalents()
    draws = {folder: drawn(folder, order.seed)[:2 * share + 2] for folder in folders}
    all_drawn = [change for changes in draws.values() for change in changes]
    path = order.folder / f"{order.seed}.json"
    verdicts = json.loads(path.read_text()) if order.resume and path.exists() else {}
    shop = Workshop(order.folder.resolve(), order.jobs,
                    [(n, c) for n, c in enumerate(all_drawn, 1) if verdicts.get(str(c)) != "no switch"])
    shop.make(*order.targets or ["all", "bodies"])
    verdicts.update((str(c), "no switch") for n, c in enumerate(all_drawn, 1) if n not in shop.changes)
    entries = [e for e in shop.entries() if not order.targets or Path(e.command[0]).is_relative_to(shop.build)]
    with ThreadPoolExecutor(order.jobs) as pool:
        list(pool.map(Entry.measure, entries))
    reached = {n for entry in entries for _, numbers in entry.parts.values() for n in numbers}
    number_of = {change: n for n, change in shop.changes.items() if n in reached or not change.early}
    chosen = {folder: [c for c in changes if c in number_of and c not in equivalents][:share]
              for folder, changes in draws.items()}
    keeping, stopped = threading.Lock(), threading.Event()
    signal.signal(signal.SIGINT, lambda *_: stopped.set())

    def decide(change):
        begin, known = time.monotonic(), verdicts.get(str(change))
        if stopped.is_set():
            return
        verdict = known or verdict_of(number_of[change], entries)
        with keeping:
            verdicts[str(change)] = verdict
            path.write_text(json.dumps(verdicts, indent=1))
        print(f"{verdict}: {change} ({time.monotonic() - begin:.0f} s)", flush=True)

    in_turn = [chosen[folder][i] for i in range(share) for folder in folders if i < len(chosen[folder])]
    with ThreadPoolExecutor(order.jobs) as pool:
        list(pool.map(decide, in_turn))
    rows, noticed, total = [], 0, 0
    for folder, changes in chosen.items():
        found = [verdicts[str(c)] for c in changes if str(c) in verdicts]
        before = draws[folder][:draws[folder].index(changes[-1])] if changes else []
        fine = sum(not verdict.startswith("missed") for verdict in found)
        rows.append(row(folder, order.seed, fine, len(found), sum(c in equivalents for c in before)))
        noticed, total = noticed + fine, total + len(found)
    print("\n".join(["", HEAD, re.sub("[^|]+", "---", HEAD), *rows]))
    if order.full:
        slow = [e for e in shop.entries(slow=True) if not order.targets or Path(e.command[0]).is_relative_to(shop.build)]
        with ThreadPoolExecutor(order.jobs) as pool:
            list(pool.map(Entry.measure, slow))
        missed = [c for c in in_turn if verdicts.get(str(c), "").startswith("missed")]

        def slow_verdict(change):
            verdict = "not tried" if stopped.is_set() else verdict_of(number_of[change], slow)
            print(f"slow cases: {verdict}: {change}", flush=True)
            return verdict.startswith(("missed", "not"))
        with ThreadPoolExecutor(order.jobs) as pool:
            more = list(pool.map(slow_verdict, missed)).count(False)
        print(f"the slow cases notice {more} of the {len(missed)} that the quick ones miss, of {total}")
    if order.record:
        record(order.record, rows)
    if 100 * noticed < order.at_least * total:
        raise SystemExit(f"{noticed} of {total} changes were noticed: fewer than {order.at_least:g} %")


if __name__ == "__main__":
    main()
