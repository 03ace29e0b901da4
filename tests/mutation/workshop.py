"""A copy of the sources with a build of its own, and the tests that answer for a room."""
import hashlib
import os
import shutil
import signal
import subprocess
import time
from pathlib import Path

from rooms import ROOMS

ROOT = Path(__file__).resolve().parents[2]
COUNTED = ("unit", "all", "missed")  # verdicts that enter the rate


def output(*command):
    return subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=True).stdout


def passes(command, limit, folder):
    """Whether a command ends well within `limit` seconds."""
    child = subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL, cwd=folder,
                             start_new_session=True)
    try:
        return child.wait(limit) == 0
    except subprocess.TimeoutExpired:
        return False
    finally:
        if child.returncode is None:
            os.killpg(child.pid, signal.SIGKILL)
            child.wait()


class Workshop:
    """The sources as they are in the work tree, copied to `folder`, and a release build of them."""

    def __init__(self, folder, jobs):
        self.source, self.build, self.jobs = folder / "source", folder / "build", str(jobs)
        self.source.mkdir(parents=True, exist_ok=True)
        for path in output("git", "ls-files", "--cached", "--others", "--exclude-standard").splitlines():
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
        command = ["ninja", "-C", str(self.build), "-j", self.jobs, *targets]
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


class Room:
    """A folder of sources with the tests that answer for it."""

    def __init__(self, name, workshop, everything):
        self.name, self.workshop = name, workshop
        self.units = [[u] if isinstance(u, str) else list(u) for u in ROOMS[name]["unit"]]
        self.targets = [u[0] for u in self.units]
        self.patterns = ROOMS[name]["all"] if everything else ""
        workshop.make([] if everything else [*self.targets, *(u[1] for u in self.units if len(u) > 1)])
        self.usual = []
        for unit in self.units:
            begin = time.monotonic()
            if not passes(self.command(unit), 1800, workshop.build):
                raise SystemExit(f"{' '.join(unit)} fails before any change")
            self.usual.append(time.monotonic() - begin)
        if self.patterns:
            begin = time.monotonic()
            if not passes(self.all_tests(), 3600, workshop.build):
                raise SystemExit(f"{self.patterns} fail before any change")
            self.usual_all = time.monotonic() - begin
        self.digests = workshop.digest(self.targets)

    def command(self, unit, *more):
        """A test program itself, or (program, double, arguments) on a double of its device."""
        target, *double = unit
        wrapped = ["umockdev-wrapper", str(self.workshop.program(double[0])), *double[1:]] if double else []
        return [*wrapped, str(self.workshop.program(target)), *more]

    def all_tests(self):
        return ["ctest", "--test-dir", str(self.workshop.build), "-j", self.workshop.jobs, "--stop-on-failure",
                "-R", self.patterns]

    def noticed_by_units(self, stem):
        """The tests whose file is named like the source come first: most changes end there.

        A test on a double runs in real time, so that it must fail twice on a busy machine.
        """
        near = f"--source-file=*{stem.split('_')[0]}*"
        for unit, usual in zip(self.units, self.usual):
            for filters in ([near], []) if len(unit) == 1 else ([],):
                command = self.command(unit, *filters, *([] if len(unit) > 1 else ["--abort-after=1"]))
                tries = 2 if len(unit) > 1 else 1
                if all(not passes(command, 10 * usual + 20, self.workshop.build) for _ in range(tries)):
                    return True
        return False

    def judge(self, change):
        """unit, all, missed, or why the change does not count: compiler, same (machine code)."""
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
