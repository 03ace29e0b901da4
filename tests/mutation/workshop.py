"""A copy of the sources with a build of its own, and the tests that answer for a room."""
import hashlib
import os
import re
import shutil
import signal
import subprocess
import time
from pathlib import Path

from rooms import ROOMS

ROOT = Path(__file__).resolve().parents[2]
COUNTED = ("unit", "all", "missed")  # verdicts that enter the rate
CASE_TIME = re.compile(r"^([0-9.]+) s: (.*)$", re.MULTILINE)  # what doctest prints of a test case
SLOW_CASE_S = 0.2
SLOW_S = 30  # all slow cases of a program, at most


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

    def names_of(self, start):
        """Object files of the build whose names begin so."""
        targets = subprocess.run(["ninja", "-C", str(self.build), "-t", "targets", "all"], capture_output=True,
                                 text=True, check=True).stdout
        names = [line.partition(":")[0] for line in targets.splitlines()]
        return sorted(name for name in names if name.startswith(start) and name.endswith(".o"))

    def link(self, objects, program):
        """Links objects before all of core, which gives what they leave out."""
        main = "tests/CMakeFiles/doctest_main.dir/doctest_main.cpp.o"
        self.run("c++", "-o", str(program), *(str(self.build / name) for name in [*objects, main]),
                 str(self.build / "core/libtactus_core.a"))

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
        self.quick = {}  # by target: objects, without what else is in core and includes the same headers
        workshop.make([] if everything else [*self.targets, *(u[1] for u in self.units if len(u) > 1)])
        core = [folder for folder in ROOMS[name]["sources"] if folder.startswith("core/")]
        for target in self.targets if core else []:
            own = [o for folder in core
                   for o in workshop.names_of(f"core/CMakeFiles/tactus_core.dir/{folder.removeprefix('core/')}/")]
            self.quick[target] = own + workshop.names_of(f"tests/CMakeFiles/{target}.dir/")
            workshop.link(self.quick[target], workshop.build / "tests" / f"mutant_{target}")
        self.programs = [f"mutant_{t}" if t in self.quick else t for t in self.targets]
        self.usual, self.slow_cases = [], []
        for unit in self.units:
            begin = time.monotonic()
            done = subprocess.run(self.command(unit, *(["--duration=true"] if len(unit) == 1 else [])), text=True,
                                  cwd=workshop.build, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, timeout=1800)
            if done.returncode:
                raise SystemExit(f"{' '.join(unit)} fails before any change")
            self.usual.append(time.monotonic() - begin)
            slow = [(float(s), name) for s, name in CASE_TIME.findall(done.stdout) if float(s) > SLOW_CASE_S]
            self.slow_cases.append([name for _, name in slow])
            self.usual[-1] -= sum(seconds for seconds, _ in slow)
        if self.patterns:
            begin = time.monotonic()
            if not passes(self.all_tests(), 3600, workshop.build):
                raise SystemExit(f"{self.patterns} fail before any change")
            self.usual_all = time.monotonic() - begin
        self.digests = workshop.digest(self.programs)

    def command(self, unit, *more):
        """A test program itself, or (program, double, arguments) on a double of its device."""
        target, *double = unit
        wrapped = ["umockdev-wrapper", str(self.workshop.program(double[0])), *double[1:]] if double else []
        program = f"mutant_{target}" if target in self.quick else target
        return [*wrapped, str(self.workshop.program(program)), *more]

    def make(self):
        """Builds the test programs; False if that fails."""
        for target, objects in self.quick.items():
            if not self.workshop.make(objects, check=False):
                return False
            self.workshop.link(objects, self.workshop.program(f"mutant_{target}"))
        rest = [t for t in self.targets if t not in self.quick]
        return not rest or self.workshop.make(rest, check=False)

    def all_tests(self):
        return ["ctest", "--test-dir", str(self.workshop.build), "-j", self.workshop.jobs, "--stop-on-failure",
                "-R", self.patterns]

    def noticed_by_units(self):
        """The quick cases of every program come first: most changes end there.

        A test on a double runs in real time, so that it must fail twice on a busy machine.
        """
        quick, slow = [], []
        for unit, usual, slow_cases in zip(self.units, self.usual, self.slow_cases):
            if len(unit) > 1:
                slow.append((self.command(unit), usual, 2))
                continue
            # A comma parts names, a question mark stands for any character.
            names = ",".join(re.sub(r"[,*\\]", "?", name) for name in slow_cases)
            stop = ["--abort-after=1", "--minimal=true"]
            quick.append((self.command(unit, *([f"--test-case-exclude={names}"] if names else []), *stop), usual, 1))
            if names:
                slow.append((self.command(unit, f"--test-case={names}", *stop), SLOW_S, 1))
        return any(all(not passes(command, 10 * usual + 20, self.workshop.build) for _ in range(tries))
                   for command, usual, tries in quick + slow)

    def verdict_of(self, change):
        """unit, all, missed, or why the change does not count: compiler, same (machine code)."""
        path = self.workshop.source / change.path
        text = path.read_text()
        path.write_text(change.apply(text))
        try:
            if not self.make():
                return "compiler"
            if self.workshop.digest(self.programs) == self.digests:
                return "same"
            if self.noticed_by_units():
                return "unit"
            if self.patterns:
                self.workshop.make([])
                if not passes(self.all_tests(), 10 * self.usual_all + 60, self.workshop.build):
                    return "all"
            return "missed"
        finally:
            path.write_text(text)
