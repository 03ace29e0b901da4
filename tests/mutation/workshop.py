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
COUNTED = ("quick", "slow", "missed")  # verdicts that enter the rate
QUICK, SLOW = ["-LE", "^(slow|threads|night)$"], ["-L", "^slow$"]


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
    """The sources as they are in the work tree, copied to `folder`, and a build of them."""

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
        self.run("cmake", "-S", str(self.source), "-B", str(self.build), "-G", "Ninja", "-DCMAKE_BUILD_TYPE=Release",
                 "-DTACTUS_TESTS=ON")

    def run(self, *command):
        done = subprocess.run(command, capture_output=True, text=True)
        if done.returncode:
            raise SystemExit(f"{' '.join(command)} failed:\n{done.stdout[-3000:]}{done.stderr[-3000:]}")

    def make(self, targets=(), check=True):
        command = ["ninja", "-C", str(self.build), "-j", self.jobs, *targets]
        if check:
            return self.run(*command)
        return subprocess.run(command, capture_output=True).returncode == 0

    def program(self, target):
        found = [p for p in self.build.joinpath("tests").rglob(target) if p.is_file()]
        if not found:
            raise SystemExit(f"no program {target} was built")
        return found[0]


class Room:
    """A folder of sources with the tests that answer for it: ./test alone, or with full ./test --full."""

    def __init__(self, name, workshop, full):
        self.name, self.workshop, self.full = name, workshop, full
        self.units = [[u] if isinstance(u, str) else list(u) for u in ROOMS[name]["unit"]]
        # Modules are no part of the programs that load them: then everything is built.
        self.targets = [] if "modules" in ROOMS[name] else sorted({target for u in self.units for target in u[:2]})
        workshop.make(self.targets)
        self.objects = {path: self.stamp(path) for path in workshop.build.rglob("*.o")}
        self.usual = {}  # by command: s
        for unit in self.units:
            self.time(self.command(unit, "--test-suite-exclude=slow"))

    @staticmethod
    def stamp(path):
        """(when, what) an object file was compiled to."""
        return path.stat().st_mtime_ns, hashlib.sha256(path.read_bytes()).hexdigest()

    def same_code(self):
        """Whether each object file that was compiled again is what it was; they count as those of before from now on."""
        changed = False
        for path, (when, what) in self.objects.items():
            if path.stat().st_mtime_ns != when:
                self.objects[path] = path.stat().st_mtime_ns, what
                changed = changed or self.stamp(path)[1] != what
        return not changed

    def time(self, command):
        """The time limit of a command that passed before any change."""
        key = tuple(command)
        if key not in self.usual:
            begin = time.monotonic()
            if not passes(command, 3600, self.workshop.build):
                raise SystemExit(f"{' '.join(command)} fails before any change")
            self.usual[key] = time.monotonic() - begin
        return 10 * self.usual[key] + 20

    def command(self, unit, *more):
        """A test program itself, or (program, double, arguments) on a double of its device."""
        target, *double = unit
        wrapped = ["umockdev-wrapper", str(self.workshop.program(double[0])), *double[1:]] if double else []
        return [*wrapped, str(self.workshop.program(target)), "--abort-after=1", "--minimal=true", *more]

    def notices(self, suite, labels):
        """Whether a unit program or a test of the room fails. What runs on a double, in real time, must fail twice."""
        for unit in self.units:
            command = self.command(unit, suite)
            limit = 10 * self.usual.get(tuple(command), 60) + 20
            if all(not passes(command, limit, self.workshop.build) for _ in range(len(unit) > 1 and 2 or 1)):
                return True
        self.workshop.make()
        return not passes(["ctest", "--test-dir", str(self.workshop.build), "-j", self.workshop.jobs,
                           "--stop-on-failure", "-R", ROOMS[self.name]["tests"], *labels], 3600, self.workshop.build)

    def verdict_of(self, change):
        """quick, slow, missed, or why the change does not count: compiler, same (machine code)."""
        path = self.workshop.source / change.path
        text = path.read_text()
        path.write_text(change.apply(text))
        try:
            if not self.workshop.make(self.targets, check=False):
                return "compiler"
            if self.same_code():
                return "same"
            if self.notices("--test-suite-exclude=slow", QUICK):
                return "quick"
            if self.full and self.notices("--test-suite=slow", SLOW):
                return "slow"
            return "missed"
        finally:
            path.write_text(text)
