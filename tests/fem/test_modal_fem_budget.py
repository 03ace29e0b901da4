"""What modal_fem predicts and refuses before it works, and what it reports meanwhile."""
import json
import os
import re
import resource
import subprocess
import time

import numpy as np
import pytest

PROGRAM = os.environ["MODAL_FEM"]
sanitized = bool(os.environ.get("TACTUS_QUICK"))
slow = pytest.mark.skipif(sanitized, reason="slow")
DISK = ["disk", "--diameter", 100, "--thickness", 12]


def run(*words, folder, expect=0, timeout=300):
    done = subprocess.run([PROGRAM, *map(str, words)], cwd=folder, capture_output=True, text=True, timeout=timeout)
    assert done.returncode == expect, done.stderr
    return done


def refusal(*words, folder):
    said = run(*words, folder=folder, expect=1, timeout=300).stderr.strip().splitlines()
    assert said[-1].startswith("modal_fem: ")
    return said[-1]


def peak(*words, folder):
    """Bytes of memory the program took at most, and what it wrote to stderr."""
    with open(folder / "said", "w+") as said:
        child = subprocess.Popen([PROGRAM, *map(str, words)], cwd=folder, stdout=subprocess.DEVNULL, stderr=said)
        _, status, usage = os.wait4(child.pid, 0)
        said.seek(0)
        text = said.read()
    assert status == 0, text
    return 1024 * usage.ru_maxrss, text


BYTES = {"MB": 1e6, "GB": 1e9}


def processor_seconds(pid):
    """Of a running program's threads; 0 once it has ended."""
    fields = open(f"/proc/{pid}/stat").read().rpartition(")")[2].split()
    return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")


def foretold(text):
    value, unit = re.findall(r"about ([\d.]+) (MB|GB) and .* ahead \(factor", text)[-1]
    return float(value) * BYTES[unit]


@slow
@pytest.mark.parametrize("words", [
    DISK,
    [*DISK, "--h", 7],
    [*DISK, "--h", 8, "--modes", 200],
    ["plate", "--length", 300, "--width", 200, "--thickness", 5, "--modes", 15],
    ["sphere", "--diameter", 100, "--modes", 2, "--h", 8],
    ["bar", "--length", 400, "--width", 30, "--thickness", 10, "--h", 5],
    ["bowl", "--diameter", 200, "--thickness", 4, "--h", 8],
    ["hollow_sphere", "--diameter", 100, "--thickness", 5, "--h", 6, "--modes", 20, "--residual"],
    [*DISK, "--h", 12, "--modes", 2, "--radiation", "body", "--acoustic-triangles", 1000],
])
def test_the_memory_taken_is_the_memory_foretold(words, tmp_path):
    took, said = peak(*words, "-o", "body.modal.npz", folder=tmp_path)
    assert took / 1.25 < foretold(said) < 1.25 * took


@slow
def test_a_cad_bodys_memory_is_foretold_too(tmp_path):
    parts = "/usr/share/opencascade/data/stl/shape.stl"
    if not os.path.exists(parts):
        pytest.skip("Debian's occt-misc is not installed")
    took, said = peak(parts, "--h", 12, "-o", "body.modal.npz", folder=tmp_path)
    assert took / 1.4 < foretold(said) < 1.4 * took


def test_work_beyond_the_budget_is_refused_at_once_with_what_fits(tmp_path):
    said = refusal(*DISK, "--h", 0.001, "--memory", "10G", folder=tmp_path)
    assert "GB" in said and "expected at most 10 GB (--memory)" in said and "--engine slepc" in said
    assert 0.5 < float(re.search(r"--h ([\d.]+)", said)[1]) < 5
    said = refusal("sphere", "--diameter", 100, "--modes", 2, "--h", 5, "--memory", "500M", folder=tmp_path)
    h = float(re.search(r"--h ([\d.]+)", said)[1])
    assert 5 < h < 10
    if not sanitized:  # what is offered does fit
        took, _ = peak("sphere", "--diameter", 100, "--modes", 2, "--memory", "500M", "--h", h, folder=tmp_path)
        assert took < 1.1 * 500e6


@slow
def test_a_refinement_beyond_the_budget_stops_at_the_last_mesh_and_says_its_errors(tmp_path):
    plate = ["plate", "--length", 300, "--width", 200, "--thickness", 5, "--modes", 20]
    took, said = peak(*plate, "--tolerance", 0.01, "--memory", "120M", "-o", "small.modal.npz", folder=tmp_path)
    stop = re.search(r"warning: (\d+) of 20 modes have estimated errors above 0.01 %, up to ([\d.]+) % "
                     r"\(mode (\d+)\): a finer mesh of \d+ unknowns would take .* expected at most 120 MB "
                     r"\(--memory\)", said)
    table = np.load(tmp_path / "small.modal.npz")
    errors = np.array(json.loads(bytes(table["meta"]))["accuracy"]["est_rel_error"])
    assert stop and took < 1.1 * 120e6
    assert (errors > 1e-4).sum() == int(stop[1]) and errors.argmax() + 1 == int(stop[3])
    assert 100 * errors.max() == pytest.approx(float(stop[2]), rel=0.06)


@slow
def test_few_modes_of_a_thick_body_take_little(tmp_path):
    took, said = peak("sphere", "--diameter", 100, "--modes", 2, "--memory", "500M", "-o", "s.modal.npz", folder=tmp_path)
    assert took < 500e6 and "estimated errors above" not in said


def test_the_element_size_that_fits_counts_in_the_users_unit(tmp_path):
    said = refusal("disk", "--unit", "m", "--diameter", 0.1, "--thickness", 0.012, "--h", 1e-6, "--memory", "1G",
                   folder=tmp_path)
    assert 1e-3 < float(re.search(r"--h ([\d.e-]+)", said)[1]) < 1e-2


def test_fewer_modes_or_acoustic_triangles_are_offered_when_they_are_what_is_large(tmp_path):
    said = refusal(*DISK, "--modes", 5000, "--memory", "1G", folder=tmp_path)
    assert "--h" not in said  # a coarser mesh would not hold as many modes
    assert 100 < int(re.search(r"--modes (\d+)", said)[1]) < 2000
    said = refusal(*DISK, "--radiation", "body", "--acoustic-triangles", 20000, "--memory", "1G", folder=tmp_path)
    assert 5000 < int(re.search(r"--acoustic-triangles (\d+)", said)[1]) < 20000 and "air" in said


@pytest.mark.parametrize("words", [["--h", "1e-9"], ["--h", "1e-6"], ["--h", "1e-9", "--no-grade"]])
@pytest.mark.parametrize("body", [
    DISK, ["sphere", "--diameter", 100], ["bowl", "--diameter", 200, "--thickness", 4],
    ["plate", "--length", 300, "--width", 200, "--thickness", 5],
    ["hollow_disk", "--diameter", 100, "--thickness", 25, "--cavity-diameter", 80, "--cavity-thickness", 13],
])
def test_an_absurdly_small_element_size_takes_no_memory_to_refuse(body, words, tmp_path):
    assert "expected at most" in refusal(*body, *words, folder=tmp_path)


def test_other_absurd_numbers_are_refused_or_harmless(tmp_path):
    run(*DISK, "--h", "1e9", "--modes", 3, folder=tmp_path)
    for words, expected in [(["--layers", "1e9"], "1 to 200"), (["--modes", "1e9"], "1 to 20000"),
                            (["--memory", "12"], "from 1M"), (["--memory", "4Q"], "from 1M"),
                            (["--memory", "-4G"], "from 1M"), (["--memory", "nan"], "from 1M")]:
        assert expected in refusal(*DISK, *words, folder=tmp_path)


def test_sizes_of_memory_are_read_as_people_write_them(tmp_path):
    for word, expected in [("2M", "2 MB"), ("2m", "2 MB"), ("2000k", "2 MB"), ("2000000", "2 MB"), ("0.002GB", "2 MB"),
                           ("2MiB", "2 MB"), ("1.5Mi", "2 MB")]:
        assert f"expected at most {expected} (--memory)" in refusal(*DISK, "--memory", word, folder=tmp_path), word


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
])
def test_an_output_that_cannot_be_written_is_refused_before_any_work(option, name, expected, tmp_path):
    (tmp_path / "folder").mkdir()
    rest = ["-o", "./same"] if name == "same" else ["-o", "table.modal.npz"] if option == "--sheet" else []
    # A body that takes minutes, of which none may be begun.
    done = run("plate", "--length", 300, "--width", 200, "--thickness", 5, "--h", 3.5, "--memory", "20G", *rest, option,
               name, folder=tmp_path, expect=1)
    last = done.stderr.strip().splitlines()[-1]
    assert expected in last and option in last, last
    assert "meshing" not in done.stderr
    assert not list(tmp_path.glob("*.partial"))


def test_the_body_is_not_overwritten_and_old_tables_are_kept(tmp_path):
    body = tmp_path / "cube.stl"
    body.write_text("solid\nendsolid\n")
    assert "body's own file" in refusal("cube.stl", "-o", "./cube.stl", folder=tmp_path)
    old = tmp_path / "old.modal.npz"
    old.write_bytes(b"precious")
    refusal(*DISK, "--h", "1e-9", "-o", "old.modal.npz", folder=tmp_path)
    refusal(*DISK, "--fix", "500,0,0,1", "--h", 20, "-o", "old.modal.npz", folder=tmp_path)
    assert old.read_bytes() == b"precious"
    if os.geteuid() != 0:
        old.chmod(0o444)
        assert "old.modal.npz" in refusal(*DISK, "-o", "old.modal.npz", folder=tmp_path)


def test_an_output_that_fails_at_the_end_leaves_the_old_file(tmp_path):
    def small_files():
        resource.setrlimit(resource.RLIMIT_FSIZE, (2000, 2000))
    for option, name in [("-o", "old.modal.npz"), ("--csv", "old.csv"), ("--vtu", "old.vtu")]:
        old = tmp_path / name
        old.write_bytes(b"precious")
        done = subprocess.run([PROGRAM, *map(str, DISK), "--h", "20", "--modes", "80", option, name], cwd=tmp_path,
                              capture_output=True, text=True, timeout=300, preexec_fn=small_files)
        assert done.returncode == 1 and f"cannot write {name}" in done.stderr, done.stderr
        assert old.read_bytes() == b"precious" and not list(tmp_path.glob("*.p*artial"))


def test_raw_checks_its_output_first_and_trials_leave_nothing(tmp_path):
    (tmp_path / "x.modal.npz.partial").write_text("another run's")
    run(*DISK, "--h", 25, "--modes", 2, "--csv", "x.csv", "-o", "y.modal.npz", folder=tmp_path)
    done = run("raw", "y.modal.npz", "--hit", "25,0,6", "-o", "/dev/full", folder=tmp_path, expect=1)
    assert "device" in done.stderr
    assert sorted(p.name for p in tmp_path.iterdir()) == ["x.csv", "x.modal.npz.partial", "y.modal.npz"]


def test_a_file_is_held_to_the_budget_before_it_is_filled(tmp_path):
    corners = [(x, y, z) for z in (0, 60) for y in (0, 60) for x in (0, 60)]
    faces = [(0, 2, 3), (0, 3, 1), (4, 5, 7), (4, 7, 6), (0, 1, 5), (0, 5, 4),
             (2, 6, 7), (2, 7, 3), (0, 4, 6), (0, 6, 2), (1, 3, 7), (1, 7, 5)]
    with open(tmp_path / "cube.obj", "w") as file:
        file.writelines("v %g %g %g\n" % c for c in corners)
        file.writelines("f %d %d %d\n" % tuple(i + 1 for i in f) for f in faces)
    for h in (1e-6, 0.05):
        said = refusal("cube.obj", "--h", h, "--memory", "2G", folder=tmp_path)
        assert said.startswith("modal_fem: cube.obj: ") and 0.5 < float(re.search(r"--h ([\d.]+)", said)[1]) < 6


def test_names_are_checked_before_meshing(tmp_path):
    for words, expected in [(["--material", "unobtainium"], "unobtainium"), (["--material", "body=unobtainium"], "unob"),
                            (["--material", "spruce", "--young", "1e9"], "orthotropic"),
                            (["--material", "spruce", "--residual"], "orthotropic"),
                            (["--import-modes", "none.bin", "none.bin"], "none.bin")]:
        done = run(*DISK, "--h", 0.7, "--memory", "900G", *words, folder=tmp_path, expect=1)
        assert expected in done.stderr and "meshing" not in done.stderr
    assert "cannot read none.stl" in refusal("none.stl", "-o", "t.npz", folder=tmp_path)


@pytest.mark.parametrize("words, said", [
    (["plate", "--length", 1.7, "--width", 1, "--thickness", 0.3, "--h", 1], "no mode is audible"),
    (["plate", "--length", 40000, "--width", 30000, "--thickness", 100, "--h", 10000, "--modes", 4], "no mode is audible"),
    (["plate", "--length", 40000, "--width", 10000, "--thickness", 3000, "--h", 10000, "--modes", 40], "--unit"),
])
def test_a_body_of_an_odd_size_is_questioned_before_meshing_and_after(words, said, tmp_path):
    text = run(*words, folder=tmp_path).stderr
    first = text.splitlines()[next(i for i, line in enumerate(text.splitlines()) if "warning" in line)]
    assert said in first and "--unit" in text
    assert text.index("warning") < text.index("elements (")
    if said != "--unit":
        assert text.count("no mode is audible") == 2


def test_a_body_of_a_usual_size_is_not_questioned(tmp_path):
    said = run(*DISK, "--h", 20, "--modes", 3, folder=tmp_path).stderr
    assert "audible" not in said and "--unit" not in said


@slow
def test_no_stage_of_a_larger_body_is_silent_for_long_nor_takes_more_than_foretold(tmp_path):
    words = ["plate", "--length", 300, "--width", 200, "--thickness", 5, "--h", 7, "--modes", 6, "--residual",
             "--radiation", "body", "--acoustic-triangles", 400, "-o", "p.modal.npz"]
    child = subprocess.Popen([PROGRAM, *map(str, words)], cwd=tmp_path, stderr=subprocess.PIPE, text=True,
                             stdout=subprocess.DEVNULL)
    begin, worked, lines = time.monotonic(), [0.0], []
    for line in child.stderr:
        worked.append(processor_seconds(child.pid) or worked[-1])
        lines.append(line)
    _, child.returncode, usage = os.wait4(child.pid, 0)
    assert child.returncode == 0
    assert 1024 * usage.ru_maxrss / 1.25 < foretold("".join(lines)) < 1.25 * 1024 * usage.ru_maxrss
    assert np.diff(worked).max() < 10  # a line every 5 s of the clock, of which it works a part
    assert any(re.search(r"assembling 100 %", x) for x in lines) and any("ahead" in x for x in lines)
    # Not chatty either: a line when a stage begins and ends, and one every 5 s.
    stages = {re.sub(r"[\d.]+ s\s+|\s\d+ %.*|, .*", "", x).strip() for x in lines}
    assert len(lines) < 3 * len(stages) + (time.monotonic() - begin) / 4


def test_progress_on_a_terminal_rewrites_its_line(tmp_path):
    import pty
    leader, follower = pty.openpty()
    child = subprocess.Popen([PROGRAM, *map(str, DISK), "--h", "8", "--modes", "100", "-o", "d.modal.npz"], cwd=tmp_path,
                             stdout=subprocess.DEVNULL, stderr=follower)
    os.close(follower)
    text = b""
    while True:
        try:
            piece = os.read(leader, 4096)
        except OSError:
            break
        if not piece:
            break
        text += piece
    assert child.wait() == 0 and b"\r" in text and b"\x1b[K" in text and b"finding modes 100 %" in text
    assert np.load(tmp_path / "d.modal.npz")["freq"].size == 100
