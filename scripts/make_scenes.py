#!/usr/bin/env python3
"""The work of ./play: builds the scenes' dependencies and makes each scene as soon as these are built.

    make_scenes.py [--all] [--build FOLDER] [NAME...]

One thread builds, scene by scene; others make scenes, as many at a time as there are processors, at most four. After
each scene out/index.html is rewritten, and out/times.tsv lists start and duration of each step. Without names it makes
every scene except the long ones, which --all adds. Status 1 if a scene failed or a sound has a fault
(scripts/sound_check.py).
"""
import argparse
import json
import os
import pathlib
import re
import subprocess
import sys
import threading
import time

import contents
import report

ROOT = pathlib.Path(__file__).resolve().parents[1]
OUT = ROOT / "out"
MAX_AT_A_TIME = 4  # scenes; each takes up to a gigabyte


def target(need):
    """The build target of an external in single precision; other words are already targets."""
    if (ROOT / "externals" / need / "CMakeLists.txt").is_file() and need != "haptic_server":
        return f"{need.replace('~', '_tilde')}_f32"
    return need


def wait(process):
    """(status, processor seconds) of a process, including the processes that it started and waited for."""
    _, status, usage = os.wait4(process.pid, 0)
    process.returncode = os.waitstatus_to_exitcode(status)  # waited for above
    return process.returncode, usage.ru_utime + usage.ru_stime


class Work:
    """The scenes to be made and their progress. `changed` guards data shared by threads."""

    def __init__(self, names, build, begun, installer=None):
        self.waiting = contents.work_order(names)
        self.build_folder, self.begun = build, begun
        self.ready, self.running, self.made, self.failed, self.faults = set(), set(), [], [], []
        self.times = []
        self.changed = threading.Condition()
        self.count = len(names)
        self.installer = installer
        self.installed = threading.Event()

    def say(self, text):
        seconds = int(time.time() - self.begun)
        print(f"{seconds // 60}:{seconds % 60:02d}  {text}", flush=True)

    def note(self, what, began, processor_seconds):
        self.times.append(f"{what}\t{began - self.begun:.1f}\t{time.time() - began:.1f}\t{processor_seconds:.1f}")
        (OUT / "times.tsv").write_text("step\tbegan, s\ttook, s\tprocessor, s\n" + "\n".join(self.times) + "\n")

    def write_page(self):
        report.write(OUT, coming=[*self.waiting, *self.running], failed=self.failed)

    def run_ninja(self, targets, name):
        """(the compiler's output if it failed, else None; processor seconds)."""
        log = (self.build_folder / "build.log").open("a")
        command = ["nice", "ninja", "-j", str(os.cpu_count() or 1), "-C", self.build_folder, *targets]
        process = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True,
                                   errors="replace")
        said, shown = [], 0
        for line in process.stdout:
            log.write(line)
            said.append(line)
            step = re.match(r"\[(\d+)/(\d+)\]", line)
            tenth = 10 * int(step[1]) // int(step[2]) if step and int(step[2]) >= 10 else 0
            if tenth > shown:
                shown = tenth
                self.say(f"  built {10 * tenth} % of the targets of {name}")
        log.close()
        status, seconds = wait(process)
        if status == 0:
            return None, seconds
        text = "".join(said)
        return f"{text[max(text.find('FAILED'), 0):][:6000]}\nninja ended with status {status}", seconds

    def build(self):
        """Builds the dependencies of each scene in turn."""
        built = set()
        for name in list(self.waiting):
            if name in self.failed:  # its dependencies failed
                break
            began = time.time()
            wanted = [t for t in dict.fromkeys(map(target, contents.needs(name))) if t not in built]
            trouble, seconds = self.run_ninja(wanted, name) if wanted else (None, 0)
            with self.changed:
                if wanted:
                    self.note(f"build for {name}", began, seconds)
                if trouble and name not in self.failed:
                    print(trouble, file=sys.stderr)
                    self.waiting.remove(name)
                    self.failed.append(name)
                    self.say(f"{name}: its targets cannot be built")
                    self.write_page()
                else:
                    built.update(wanted)
                    self.ready.add(name)
                self.changed.notify_all()

    def install(self):
        """Waits for the process that installs the scenes' runtime packages. If that failed, makes no scenes; the
        process has printed the reason."""
        status = os.waitpid(self.installer, 0)[1] if self.installer else 0
        with self.changed:
            if status:
                self.failed += self.waiting
                self.waiting.clear()
        self.installed.set()

    def next_scene(self):
        self.installed.wait()
        with self.changed:
            while self.waiting:
                for name in self.waiting:
                    if name in self.ready:
                        self.waiting.remove(name)
                        self.running.add(name)
                        return name
                self.changed.wait()
        return None

    def make_scene(self, name):
        """(status, processor seconds) of make_scene.py."""
        # Limits OpenBLAS, since two solvers may run at once and its idle threads would wait by spinning.
        environment = dict(os.environ, TACTUS_STAGE=str(self.build_folder / "tactus"), MPLBACKEND="Agg",
                           PYTHONDONTWRITEBYTECODE="1", OPENBLAS_NUM_THREADS="1", OMP_NUM_THREADS="1")
        process = subprocess.Popen(["nice", sys.executable, ROOT / "scripts" / "make_scene.py", name, OUT], cwd=ROOT,
                                   env=environment)
        return wait(process)

    def make_scenes(self):
        while name := self.next_scene():
            self.say(f"{name}: {contents.title(name)}")
            began = time.time()
            status, processor_seconds = self.make_scene(name)
            with self.changed:
                self.running.remove(name)
                self.note(name, began, processor_seconds)
                if status:
                    self.failed.append(name)
                    self.say(f"{name}: FAILED")
                else:
                    self.made.append(name)
                    scene = json.loads((OUT / name / "scene.json").read_text())
                    self.faults += [f"{name}/{fault}" for fault in scene["faults"]]
                    self.say(f"{name} is on the page, {len(self.made)} of {self.count}"
                             + (f": {OUT / 'index.html'}" if len(self.made) == 1 else ""))
                self.write_page()


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("names", nargs="*")
    parser.add_argument("--all", action="store_true", help="also the scenes that take minutes each")
    parser.add_argument("--build", type=pathlib.Path, default=ROOT / "build")
    parser.add_argument("--begun", type=float, default=time.time(), help="when ./play was called: seconds since 1970")
    parser.add_argument("--installer", type=int, help="process id of a child that installs the packages of the scenes")
    arguments = parser.parse_args()
    names = arguments.names or [n for n in contents.names() if arguments.all or not contents.is_long(n)]
    OUT.mkdir(exist_ok=True)
    work = Work(names, arguments.build.resolve(), arguments.begun, arguments.installer)
    work.write_page()
    threads = [threading.Thread(target=work.make_scenes, daemon=True)  # daemons, so that an interrupt ends them too
               for _ in range(min(os.cpu_count() or 1, MOST_AT_A_TIME, len(names)))]
    threads += [threading.Thread(target=run, daemon=True) for run in (work.install, work.build)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    work.write_page()
    if work.faults:
        print("Sounds with faults:", *work.faults, sep="\n  ")
    if work.failed:
        print(f"./play: these scenes failed: {' '.join(work.failed)}", file=sys.stderr)
    else:
        work.say(f"All sounds and pictures: {OUT / 'index.html'}")
    return 1 if work.failed or work.faults else 0


if __name__ == "__main__":
    try:
        sys.exit(main())
    except KeyboardInterrupt:
        sys.exit("./play: interrupted; the page has the finished scenes")
