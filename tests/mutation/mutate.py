#!/usr/bin/python3
"""Do the tests notice? Small wrong changes, one at a time, built and tested; how many were noticed.

    tests/mutation/mutate.py [ROOM...] [--count 40] [--seed 1] [--full] [--changed REVISION]
                             [--only PATH[:LINE]] [--folder build-mutation] [--jobs 2] [--at-least PERCENT]
                             [--resume | --again | --read RESULTS.json...] [--record docs/results/mutation.md]

A room is a folder of `rooms.py`. --count changes are drawn from each room with a fixed seed. Each is made in a copy of
the sources, only what depends on it is built, and what ./test runs for the room runs up to the first that fails: its
unit tests, then tests of the objects and programs that use it. --full gives what they miss to the slow cases.
--changed draws only from lines that differ from REVISION. --at-least: status 1 where fewer of all are noticed.

  noticed     a test failed, crashed, or took longer than ten times its usual time
  missed      every test passed: the line is printed with its change
  not counted the change does not compile, the machine code stays the same, or it is listed with the
              reason why no test can notice it (equivalent.toml)

The same seed and sources give the same changes. Prints progress, one line a change, and a table by room.
Results are kept in FOLDER/ROOM-SEED.json. --resume goes on with a run that was stopped. --again runs
only what was missed by those files, after tests were written for it, and brings the files
up to date; --read runs nothing. --record puts the rows into the table of a page.
"""
import argparse
import random
import sys
import time
from pathlib import Path

from changes import changes_of
from records import Equivalents, load, record, report, save
from rooms import ROOMS
from workshop import COUNTED, ROOT, Room, Workshop, output

NAMES = {"quick": "noticed", "slow": "noticed by slow cases", "missed": "MISSED", "compiler": "does not compile",
         "same": "same machine code", "equivalent": "equivalent"}


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


def run(room, changes, count, equivalents, keep=lambda tested: None, known=()):
    """[(change, verdict)] until `count` count; kept after each, so that a run can be stopped.

    `known`: {change: verdict} of a run before that was stopped.
    """
    known = dict(known)
    tested, counted = [], 0
    for change in changes:
        if counted == count:
            break
        begin = time.monotonic()
        verdict = "equivalent" if equivalents.reason(change) else known.get(change) or room.verdict_of(change)
        tested.append((change, verdict))
        keep(tested)
        counted += verdict in COUNTED
        print(f"{room.name} {counted}/{count} {NAMES[verdict]}: {change} ({time.monotonic() - begin:.0f} s)", flush=True)
    room.workshop.make(room.targets)
    return tested


def main():
    words = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    words.add_argument("room", nargs="*", help=f"of {', '.join(ROOMS)}; all if none is named")
    words.add_argument("--count", type=int, default=40)
    words.add_argument("--seed", default="1")
    words.add_argument("--full", action="store_true")
    words.add_argument("--changed", metavar="REVISION")
    words.add_argument("--only", metavar="PATH[:LINE]")
    words.add_argument("--folder", type=Path, default=ROOT / "build-mutation")
    words.add_argument("--jobs", type=int, default=2)
    words.add_argument("--at-least", metavar="PERCENT", type=float, default=0)
    words.add_argument("--resume", action="store_true")
    words.add_argument("--again", metavar="RESULTS.json", nargs="+", type=Path)
    words.add_argument("--read", metavar="RESULTS.json", nargs="+", type=Path)
    words.add_argument("--record", metavar="PAGE.md", type=Path)
    order = words.parse_args()
    unknown = [r for r in order.room if r not in ROOMS]
    if unknown:
        raise SystemExit(f"no room is called {unknown[0]}; expected one of {', '.join(ROOMS)}")
    equivalents, results = Equivalents(), []
    workshop = None if order.read else Workshop(order.folder.resolve(), order.jobs)

    def room_of(name):
        print(f"{name}: building and running its tests unchanged", file=sys.stderr)
        return Room(name, workshop, order.full)

    if order.read:
        for path in order.read:
            name, seed, full, former = load(path)
            tested = [(c, "equivalent" if v == "missed" and equivalents.reason(c) else v) for c, v in former]
            results.append((name, seed, full, tested))
    elif order.again:
        for path in order.again:
            name, seed, full, former = load(path)
            open_ones = [c for c, v in former if v in ("missed", "slow", "equivalent")]
            now = dict(run(room_of(name), open_ones, len(open_ones), equivalents))
            if not order.full:  # what slow cases noticed, they notice still
                now.update({c: v for c, v in former if v == "slow" and now[c] == "missed"})
            tested = [(c, now.get(c, v)) for c, v in former]
            results.append((name, seed, full or order.full, tested))
            save(path, *results[-1])
    else:
        changed = lines_changed(order.changed) if order.changed else None
        for name in order.room or ROOMS:
            changes = drawn(name, order.seed, order.count, changed, order.only)
            if changes:
                path = None if order.changed or order.only else order.folder / f"{name}-{order.seed}.json"
                keep = lambda tested: path and save(path, name, order.seed, order.full, tested)
                known = load(path)[3] if order.resume and path and path.exists() else ()
                tested = run(room_of(name), changes, order.count, equivalents, keep, known)
                results.append((name, order.seed, order.full, tested))
    print("\n" + report(results))
    if order.record:
        record(order.record, results)
    verdicts = [v for *_, tested in results for _, v in tested if v in COUNTED]
    if verdicts and 100 * (1 - verdicts.count("missed") / len(verdicts)) < order.at_least:
        raise SystemExit(f"fewer than {order.at_least:g} % of {len(verdicts)} changes were noticed")


if __name__ == "__main__":
    main()
