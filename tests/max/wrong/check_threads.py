#!/usr/bin/env python3
"""Does the thread sanitizer find no race in the right small~ and the host, and the one that is planted?

    check_threads.py MODULE -- HOST...
"""
import os
import pathlib
import subprocess
import sys

FOLDER = pathlib.Path(__file__).resolve().parent


def play(host, module, mistake):
    """Status and all output of the threads script with a mistake."""
    script = f'load "{module}"\n' + (FOLDER / "threads.txt").read_text()
    environment = {**os.environ, "MISTAKE": mistake,
                   "TSAN_OPTIONS": "report_signal_unsafe=0"}  # the host reports faults from their handler
    run = subprocess.run(host, input=script, capture_output=True, text=True, errors="replace", timeout=250, env=environment)
    return run.returncode, run.stdout + run.stderr


def main(module, _, *host):
    module = pathlib.Path(module).resolve()
    status, output = play(host, module, "none")
    right = status == 0 and "ThreadSanitizer" not in output and "violation" not in output
    if not right:
        print(f"the right one: status {status}\n{output[-6000:]}")
    status, output = play(host, module, "race")
    found = "data race" in output and status != 0
    if not found:
        print(f"the planted race was not found: status {status}\n{output[-2000:]}")
    sent = output.count("out: ")
    print(f"right: {right}; race found: {found}; {sent} messages came out")
    return 0 if right and found and sent else 1


if __name__ == "__main__":
    sys.exit(main(*sys.argv[1:]))
