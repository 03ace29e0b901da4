#!/usr/bin/env python3
"""Does the host name each mistake of small~, and nothing of the right one?

    check_mistakes.py MODULE [--windows] [--sanitized] -- HOST...
"""
import argparse
import os
import pathlib
import re
import subprocess
import sys

FOLDER = pathlib.Path(__file__).resolve().parent
sys.path.insert(0, str(FOLDER.parent))
from warm_host import warm  # noqa: E402
BREACH, CRASH = 3, 4


def mistakes():
    """(name, what the host must say, where) of each line."""
    for line in (FOLDER / "mistakes.txt").read_text().splitlines():
        if line and not line.startswith("#"):
            name, expected, *where = [word.strip() for word in line.split("|")]
            yield name, expected, where[0] if where else ""


def play(host, module, name):
    """Status, lines and errors of the host's run of the module with a mistake, or none."""
    script = f'searchpath "{FOLDER}"\nload "{module}"\n' + (FOLDER / "play.txt").read_text()
    environment = {**os.environ, "MISTAKE": name}
    run = subprocess.run(host, input=script, capture_output=True, text=True, errors="replace", timeout=120, env=environment)
    return run.returncode, run.stdout.splitlines(), run.stderr


def unlisted():
    """Mistakes that small~ can make and mistakes.txt does not list; "race" is check_threads.py's."""
    known = set(re.findall(r'wrong\("([^"]+)"\)', (FOLDER / "small~.cpp").read_text()))
    return known.symmetric_difference({name for name, _, _ in mistakes()} | {"race"})


def check(host, module, name, expected):
    """What is wrong with the host's report, or None."""
    status, lines, stderr = play(host, module, name)
    violations = [line for line in lines if line.startswith("violation: ")]
    if expected is None:
        if status != 0 or violations or stderr.strip():
            return f"the right one: status {status}: {violations} {stderr}"
        return None
    if "AddressSanitizer: use-after-poison" in stderr:  # it ends the run at a write into a guard zone
        return None
    if not any(expected in line for line in violations):
        return f"{name}: status {status}: no violation with: {expected}; but {violations} {stderr}"
    if status not in (BREACH, CRASH) and "LeakSanitizer" not in stderr:
        return f"{name}: status {status}, expected {BREACH}"
    return None


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("module", type=pathlib.Path)
    parser.add_argument("--windows", action="store_true", help="the host runs under wine")
    parser.add_argument("--sanitized", action="store_true", help="locks are not watched")
    parser.add_argument("host", nargs="+")
    arguments = parser.parse_args()
    failures = [f"{name}: in one of small~.cpp and mistakes.txt only" for name in unlisted()]
    checked, skipped = 0, []
    with warm(arguments.host):
        for name, expected, where in [("none", None, "")] + list(mistakes()):
            if where == "locks" and (arguments.windows or arguments.sanitized):
                skipped.append(name)
                continue
            checked += 1
            failure = check(arguments.host, arguments.module.resolve(), name, expected)
            if failure:
                failures.append(failure)
    for failure in failures:
        print(failure)
    print(f"{checked - 1} mistakes and the right one played, {len(failures)} failures"
          + (f"; not here: {', '.join(skipped)}" if skipped else ""))
    return 1 if failures else 0


if __name__ == "__main__":
    sys.exit(main())
