"""What modal_fem predicts and refuses before it works, and what it reports meanwhile."""
import os
import re
import resource
import subprocess
import time
from functools import partial

import numpy as np
import program
import pytest
from program import MODAL_FEM, errors, write_obj, write_stl

run, refusal = partial(program.run, MODAL_FEM), partial(program.refusal, MODAL_FEM)
DISK = ["disk", "--diameter", 100, "--thickness", 12]
PLATE = ["plate", "--length", 300, "--width", 200, "--thickness", 5]
slow = partial(pytest.param, marks=pytest.mark.slow)


def peak(*words, folder):
    """Bytes of memory the program took at most, and what it wrote to stderr."""
    with open(folder / "said", "w+") as said:
        child = subprocess.Popen([MODAL_FEM, *map(str, words)], cwd=folder, stdout=subprocess.DEVNULL, stderr=said)
        _, status, usage = os.wait4(child.pid, 0)
        said.seek(0)
        text = said.read()
    assert status == 0, text
    return 1024 * usage.ru_maxrss, text


def foretold(text):
    value, unit = re.findall(r"about ([\d.]+) (MB|GB) and .* needed \(factor", text)[-1]
    return float(value) * {"MB": 1e6, "GB": 1e9}[unit]


def offered(text, option="h"):
    """The value that a refusal proposes."""
    return float(re.search(rf"--{option} ([\d.e-]+)", text)[1])


@pytest.mark.parametrize("words, share", [
    ([*DISK, "--h", 12, "--modes", 10], 1.25),
    slow([*DISK, "--h", 12, "--modes", 2, "--radiation", "body", "--acoustic-triangles", 1000], 1.25),
    slow(DISK, 1.25),
    slow([*DISK, "--h", 7], 1.25),
    slow([*DISK, "--h", 8, "--modes", 200], 1.25),
    slow([*PLATE, "--modes", 15], 1.25),
    slow(["sphere", "--diameter", 100, "--modes", 2, "--h", 8], 1.25),
    slow(["bar", "--length", 400, "--width", 30, "--thickness", 10, "--h", 5], 1.25),
    slow(["bowl", "--diameter", 200, "--thickness", 4, "--h", 8], 1.25),
    slow(["hollow_sphere", "--diameter", 100, "--thickness", 5, "--h", 6, "--modes", 20, "--residual"], 1.25),
    slow(["/usr/share/opencascade/data/stl/shape.stl", "--h", 12], 1.4),  # a CAD body's
])
def test_the_memory_taken_is_the_memory_foretold(words, share, tmp_path):
    if words[0].startswith("/") and not os.path.exists(words[0]):
        pytest.skip("Debian's occt-misc is not installed")
    took, said = peak(*words, "-o", "body.modal.npz", folder=tmp_path)
    assert took / share < foretold(said) < share * took


def test_work_beyond_the_budget_is_refused_at_once_with_what_fits(tmp_path):
    said = refusal(*DISK, "--h", 0.001, "--memory", "10G", folder=tmp_path)
    assert "GB" in said and "expected at most 10 GB (--memory)" in said and "--engine slepc" in said
    assert 0.5 < offered(said) < 5
    ball = ["sphere", "--diameter", 100, "--modes", 2, "--memory", "120M"]
    h = offered(refusal(*ball, "--h", 5, folder=tmp_path))
    assert 5 < h < 25 and peak(*ball, "--h", h, folder=tmp_path)[0] < 1.1 * 120e6
    said = refusal("disk", "--unit", "m", "--diameter", 0.1, "--thickness", 0.012, "--h", 1e-6, "--memory", "1G",
                   folder=tmp_path)
    assert 1e-3 < offered(said) < 1e-2  # in the user's unit
    said = refusal(*DISK, "--modes", 5000, "--memory", "1G", folder=tmp_path)
    assert "--h" not in said  # a coarser mesh would not hold as many modes
    assert 100 < offered(said, "modes") < 2000
    said = refusal(*DISK, "--radiation", "body", "--acoustic-triangles", 20000, "--memory", "1G", folder=tmp_path)
    assert 5000 < offered(said, "acoustic-triangles") < 20000 and "air" in said
    write_obj(tmp_path / "cube.obj", 60)
    for h in (1e-6, 0.05):  # a file's body is held to it before it is filled
        said = refusal("cube.obj", "--h", h, "--memory", "2G", folder=tmp_path)
        assert said.startswith("modal_fem: cube.obj: ") and 0.5 < offered(said) < 6


@pytest.mark.slow
def test_a_refinement_beyond_the_budget_stops_at_the_last_mesh_and_says_its_errors(tmp_path):
    took, said = peak(*PLATE, "--modes", 20, "--tolerance", 0.01, "--memory", "120M", "-o", "small.modal.npz", folder=tmp_path)
    stop = re.search(r"warning: (\d+) of 20 modes have estimated errors above 0.01 %, up to ([\d.]+) % "
                     r"\(mode (\d+)\): a finer mesh of \d+ unknowns would take .* expected at most 120 MB "
                     r"\(--memory\)", said)
    found = errors(np.load(tmp_path / "small.modal.npz"))
    assert stop and took < 1.1 * 120e6
    assert (found > 1e-4).sum() == int(stop[1]) and found.argmax() + 1 == int(stop[3])
    assert 100 * found.max() == pytest.approx(float(stop[2]), rel=0.06)


@pytest.mark.slow
def test_few_modes_of_a_thick_body_take_little(tmp_path):
    took, said = peak("sphere", "--diameter", 100, "--modes", 2, "--memory", "500M", "-o", "s.modal.npz", folder=tmp_path)
    assert took < 500e6 and "estimated errors above" not in said


def test_absurd_numbers_are_refused_or_harmless_and_sizes_are_read_as_people_write_them(tmp_path):
    run(*DISK, "--h", "1e9", "--modes", 3, folder=tmp_path)
    for words, expected in [(["--h", "1e-9"], "expected at most"), (["--layers", "1e9"], "1..200"),
                            (["--modes", "1e9"], "1..20000"),
                            *((["--memory", size], "of 1M or more") for size in ("12", "4Q", "nan")),
                            *((["--memory", size], "expected at most 2 MB (--memory)")
                              for size in ("2m", "2000k", "0.002GB", "1.5Mi"))]:
        assert expected in refusal(*DISK, *words, folder=tmp_path), words


@pytest.mark.parametrize("option, name, expected", [
    ("-o", "none/x.modal.npz", "there is no folder none"),
    ("-o", "folder", "is a folder"),
    ("-o", "/dev/full", "device"),
    ("--csv", "/dev/full", "device"),
    ("--vtu", "none/x.vtu", "there is no folder none"),
    ("--sheet", "none/x.png", "there is no folder none"),
    ("--export-inp", "folder", "is a folder"),
    ("--export-petsc", "none/km", "there is no folder none"),
    ("-o", "a" * 300, "cannot write"),
    ("--csv", "same", "name the same file"),
    ("--material", "unobtainium", "unobtainium"),
    ("--material", "body=unobtainium", "unob"),
    ("--material", "spruce --young 1e9", "orthotropic"),
    ("--material", "spruce --residual", "orthotropic"),
    ("--import-modes", "none.bin none.bin", "none.bin"),
])
def test_what_cannot_be_written_or_is_not_known_is_refused_before_any_work(option, name, expected, tmp_path):
    (tmp_path / "folder").mkdir()
    rest = ["-o", "./same"] if name == "same" else ["-o", "table.modal.npz"] if option == "--sheet" else []
    # A body that takes minutes, of which none may be begun.
    said = run(*PLATE, "--h", 3.5, "--memory", "20G", *rest, option, *name.split(), folder=tmp_path, expect=1).stderr
    last = said.strip().splitlines()[-1]
    assert expected in last and (option in last or option not in ("-o", "--csv", "--vtu", "--sheet")), last
    assert "meshing" not in said
    assert not list(tmp_path.glob("*.partial"))


def test_the_body_is_not_overwritten_and_old_files_are_kept(tmp_path):
    write_stl(tmp_path / "cube.stl", [])
    assert "body's own file" in refusal("cube.stl", "-o", "./cube.stl", folder=tmp_path)
    old = tmp_path / "old.modal.npz"
    old.write_bytes(b"precious")
    refusal(*DISK, "--h", "1e-9", "-o", "old.modal.npz", folder=tmp_path)
    refusal(*DISK, "--fix", "500,0,0,1", "--h", 20, "-o", "old.modal.npz", folder=tmp_path)
    assert old.read_bytes() == b"precious"
    if os.geteuid() != 0:
        old.chmod(0o444)
        assert "old.modal.npz" in refusal(*DISK, "-o", "old.modal.npz", folder=tmp_path)
        old.chmod(0o644)
    # Where writing fails only at the end:
    small_files = lambda: resource.setrlimit(resource.RLIMIT_FSIZE, (1000, 1000))
    for option, name in [("-o", "old.modal.npz"), ("--csv", "old.csv"), ("--vtu", "old.vtu")]:
        (tmp_path / name).write_bytes(b"precious")
        said = refusal(*DISK, "--h", 25, "--modes", 40, option, name, folder=tmp_path, preexec_fn=small_files)
        assert f"cannot write {name}" in said
        assert (tmp_path / name).read_bytes() == b"precious" and not list(tmp_path.glob("*.p*artial"))


def test_raw_checks_its_output_first_and_trials_leave_nothing(tmp_path):
    (tmp_path / "x.modal.npz.partial").write_text("another run's")
    run(*DISK, "--h", 25, "--modes", 2, "--csv", "x.csv", "-o", "y.modal.npz", folder=tmp_path)
    assert "device" in refusal("raw", "y.modal.npz", "--hit", "25,0,6", "-o", "/dev/full", folder=tmp_path)
    assert sorted(p.name for p in tmp_path.iterdir()) == ["x.csv", "x.modal.npz.partial", "y.modal.npz"]


@pytest.mark.parametrize("sizes, words, questions", [
    ((1.7, 1, 0.3), ["--h", 1], "no mode is audible"),
    ((40000, 30000, 100), ["--h", 10000, "--modes", 4], "no mode is audible"),
    ((40000, 10000, 3000), ["--h", 10000, "--modes", 40], "--unit"),
    ((100, 60, 12), ["--h", 20, "--modes", 3], None),
])
def test_a_body_of_an_odd_size_is_questioned_before_meshing_and_after_a_usual_one_is_not(sizes, words, questions, tmp_path):
    length, width, thickness = sizes
    said = run("plate", "--length", length, "--width", width, "--thickness", thickness, *words, folder=tmp_path).stderr
    if questions is None:
        assert "audible" not in said and "--unit" not in said
        return
    assert questions in next(line for line in said.splitlines() if "warning" in line) and "--unit" in said
    assert said.index("warning") < said.index("elements (")
    assert "audible" not in questions or said.count("no mode is audible") == 2


@pytest.mark.slow
def test_no_stage_of_a_larger_body_is_silent_for_long_nor_takes_more_than_foretold(tmp_path):
    words = [*PLATE, "--h", 7, "--modes", 6, "--residual", "--radiation", "body", "--acoustic-triangles", 400, "-o",
             "p.modal.npz"]
    child = subprocess.Popen([MODAL_FEM, *map(str, words)], cwd=tmp_path, stderr=subprocess.PIPE, text=True,
                             stdout=subprocess.DEVNULL)
    begin, worked, lines = time.monotonic(), [0.0], []
    for line in child.stderr:
        fields = open(f"/proc/{child.pid}/stat").read().rpartition(")")[2].split()
        worked.append((int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK") or worked[-1])
        lines.append(line)
    _, child.returncode, usage = os.wait4(child.pid, 0)
    assert child.returncode == 0
    assert 1024 * usage.ru_maxrss / 1.25 < foretold("".join(lines)) < 1.25 * 1024 * usage.ru_maxrss
    assert np.diff(worked).max() < 10  # a line every 5 s of the clock, of which it works a part
    assert any(re.search(r"assembling 100 %", x) for x in lines) and any("needed" in x for x in lines)
    # Not chatty either: a line when a stage begins and ends, and one every 5 s.
    stages = {re.sub(r"[\d.]+ s\s+|\s\d+ %.*|, .*", "", x).strip() for x in lines}
    assert len(lines) < 3 * len(stages) + (time.monotonic() - begin) / 4


def test_progress_on_a_terminal_rewrites_its_line(tmp_path):
    import pty
    leader, follower = pty.openpty()
    child = subprocess.Popen([MODAL_FEM, *map(str, DISK), "--h", "14", "--modes", "40"], cwd=tmp_path,
                             stdout=subprocess.DEVNULL, stderr=follower)
    os.close(follower)
    text = b""
    try:
        while piece := os.read(leader, 4096):
            text += piece
    except OSError:  # the other end is closed
        pass
    assert child.wait() == 0 and b"\r" in text and b"\x1b[K" in text and b"finding modes 100 %" in text
