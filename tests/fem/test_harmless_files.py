"""Foreign files run nothing, write nothing and crash nothing: scripts in every format and position."""
import os
import signal
import struct
import subprocess
import time
import zipfile
from functools import partial

import numpy as np
import pytest
from program import MODAL_FEM, processor_seconds, write_obj

slow = partial(pytest.param, marks=pytest.mark.slow)
SCRIPTS = ['SystemCall "touch canary";\n', '// a comment\nSystemCall "touch canary";\n',
           'NonBlockingSystemCall "touch canary";\n', 'Merge "evil.geo";\n', 'Include "evil.geo";\n',
           'Save "canary";\n', 'Printf("x") > "canary";\n', 'OnelabRun("x", "touch canary");\n',
           'General.ExecutableFileName = "canary";\nSystemCall Str("touch canary");\n', '`touch canary`\n',
           '$(touch canary)\n', '#!/bin/sh\ntouch canary\n', 'import os; os.system("touch canary")\n']
MSH_2 = ("$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$PhysicalNames\n1\n3 1 \"NAME\"\n$EndPhysicalNames\n$Nodes\n4\n1 0 0 0\n"
         "2 1 0 0\n3 0 1 0\n4 0 0 1\n$EndNodes\n$Elements\n1\n1 4 2 1 1 1 2 3 4\n$EndElements\n")
MSH_4 = ("$MeshFormat\n4.1 0 8\n$EndMeshFormat\n$PhysicalNames\n1\n3 1 \"NAME\"\n$EndPhysicalNames\n"
         "$Entities\n0 0 0 1\n1 0 0 0 1 1 1 1 1 0\n$EndEntities\n$Nodes\n1 4 1 4\n3 1 0 4\n1\n2\n3\n4\n"
         "0 0 0\n1 0 0\n0 1 0\n0 0 1\n$EndNodes\n$Elements\n1 1 1 1\n3 1 4 1\n1 1 2 3 4\n$EndElements\n")
STEP = ("ISO-10303-21;\nHEADER;\nFILE_DESCRIPTION(('NAME'),'2;1');\nFILE_NAME('NAME','',(''),(''),'','','');\n"
        "FILE_SCHEMA(('AUTOMOTIVE_DESIGN'));\nENDSEC;\nDATA;\n#1=CARTESIAN_POINT('NAME',(0.,0.,0.));\nENDSEC;\n"
        "END-ISO-10303-21;\n")
BREP = "DBRep_DrawableShape\n\nCASCADE Topology V1, (c) Matra-Datavision\nLocations 0\n"
OBJ = "o NAME\nv 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 2 3 4\nf 1 4 3\n"
STL = "solid NAME\n" + "".join(
    "facet normal 0 0 0\nouter loop\n" + "".join(f"vertex {p}\n" for p in face) + "endloop\nendfacet\n"
    for face in [("0 0 0", "0 1 0", "1 0 0"), ("0 0 0", "1 0 0", "0 0 1"), ("1 0 0", "0 1 0", "0 0 1"),
                 ("0 0 0", "0 0 1", "0 1 0")]) + "endsolid\n"
INP = "*NODE\n1,0,0,0\n2,1,0,0\n3,0,1,0\n4,0,0,1\n*ELEMENT,TYPE=C3D4,ELSET=NAME\n7,1,2,3,4\n*NSET,NSET=NAME\n1,2\n"
BODIES = {"msh2.msh": MSH_2, "msh4.msh": MSH_4, "a.step": STEP, "a.brep": BREP, "a.obj": OBJ, "a.stl": STL, "a.inp": INP}
ENDINGS = ["msh", "step", "stp", "brep", "brp", "stl", "obj", "inp", "geo", "pos", "opt", "iges", "unv", "MSH"]


def run(*words, folder, timeout=600, **extra):
    """The program's status and its last line; in every case its death by a signal is a fault."""
    done = subprocess.run([MODAL_FEM, *map(str, words)], cwd=folder, capture_output=True, text=True, errors="replace",
                          timeout=timeout, **extra)
    said = (done.stderr.strip().splitlines() or [""])[-1]
    assert done.returncode in (0, 1), done.stderr
    assert done.returncode == 0 or said.startswith("modal_fem: "), said
    return done.returncode, said


def try_file(folder, name, content, **extra):
    """Reads it; whatever becomes of it, no canary may appear and nothing else either."""
    (folder / "evil.geo").write_text('SystemCall "touch canary";\n')
    (folder / name).write_bytes(content if isinstance(content, bytes) else content.encode())
    before = set(os.listdir(folder))
    outcome = run(f"./{name}", "--modes", 1, "--tolerance", 30, "--multi", "--quiet", "--time-limit", 60, folder=folder, **extra)
    assert set(os.listdir(folder)) == before, (name, content)
    (folder / name).unlink()
    return outcome


@pytest.mark.parametrize("ending, scripts", [
    *((ending, SCRIPTS[:1]) for ending in ("msh", "step", "stl", "geo", "pos")),
    *(slow(ending, SCRIPTS) for ending in ENDINGS)])
def test_a_script_under_any_ending_runs_nothing(ending, scripts, tmp_path):
    for script in scripts:
        status, said = try_file(tmp_path, f"script.{ending}", script)
        assert status == 1 and f"script.{ending}" in said, said


@pytest.mark.parametrize("name, scripts", [("msh4.msh", SCRIPTS[:1]), ("a.step", SCRIPTS[:1]),
                                           *(slow(name, SCRIPTS[:2]) for name in BODIES)])
def test_a_script_inside_a_body_runs_nothing(name, scripts, tmp_path):
    body = BODIES[name]
    lines = body.splitlines(keepends=True)
    for script in scripts:
        flat = script.replace("\n", " ").replace('"', "'")
        for content in [script + body, body + script, body.replace("NAME", flat), body.replace("NAME", script.strip()),
                        *("".join(lines[:i]) + script + "".join(lines[i:]) for i in (1, len(lines) // 2))]:
            try_file(tmp_path, name, content)


@pytest.mark.parametrize("section, body", [("Comments", MSH_2), ("Unknown", MSH_4), ("NodeData", MSH_4)])
def test_sections_that_carry_no_mesh_run_nothing_and_change_nothing(section, body, tmp_path):
    hidden = f'${section}\nSystemCall "touch canary";\n$End{section}\n'
    assert try_file(tmp_path, "body.msh", body + hidden)[0] == 0


@pytest.mark.parametrize("name", ["a;touch canary;.msh", "a$(touch canary).step", "a\ntouch canary\n.msh", "-rf.msh",
                                  "\x1b[2J.stl", *map(slow, ["`touch canary`.stl", "a'b\"c.brep", "a|touch canary|.obj",
                                                             "a&touch canary&.inp", "../{}/a.msh", "%s%n%x.msh"])])
def test_a_file_name_runs_nothing_and_no_sentence_carries_control_characters(name, tmp_path):
    _, said = try_file(tmp_path, name.format(tmp_path.name), STEP if name.endswith("step") else SCRIPTS[0])
    assert "\x1b" not in said


def test_configuration_files_of_gmsh_are_not_read(tmp_path):
    home = tmp_path / "home"
    home.mkdir()
    for name in (".gmshrc", ".gmsh-options", ".gmsh-errors", "matplotlibrc"):
        (home / name).write_text('SystemCall "touch canary";\nGeneral.Terminal = 1;\n')
    for name in (".gmshrc", ".gmsh-options", "default.opt", *(f"a.{ending}.opt" for ending in ("stl", "step", "msh"))):
        (tmp_path / name).write_text('SystemCall "touch canary";\n')
    before = sorted(os.listdir(home))
    environment = {**os.environ, "HOME": str(home), "GMSH_HOME": str(home), "PYTHONPATH": str(home)}
    for name, content in (("a.stl", STL), ("a.step", STEP), ("a.msh", MSH_2)):
        try_file(tmp_path, name, content, env=environment)
    assert sorted(os.listdir(home)) == before


def test_the_picture_sheet_imports_nothing_from_the_folder_or_the_environment(tmp_path):
    evil = 'open("%s/canary", "w")\n' % tmp_path
    for name in ("numpy.py", "matplotlib.py", "json.py", "sitecustomize.py", "usercustomize.py", "evil.py"):
        (tmp_path / name).write_text(evil)
    (tmp_path / "matplotlibrc").write_text("backend: module://evil\nno.such.key: 1\n")  # which is complained of if read
    environment = {**os.environ, "PYTHONPATH": str(tmp_path), "PYTHONSTARTUP": str(tmp_path / "evil.py")}
    done = subprocess.run([MODAL_FEM, *"disk --diameter 100 --thickness 12 --h 20 --modes 3 --quiet -o -d.modal.npz".split(),
                           "--sheet", "-d.png"], cwd=tmp_path, env=environment, capture_output=True, text=True)
    assert done.returncode == 0 and "matplotlibrc" not in done.stderr, done.stderr
    assert not (tmp_path / "canary").exists()
    assert (tmp_path / "-d.png").read_bytes().startswith(b"\x89PNG")


@pytest.mark.parametrize("script", [SCRIPTS[-1], slow(SCRIPTS[-2])])
def test_a_script_as_a_profile_a_table_or_modes_runs_nothing(script, tmp_path):
    class Evil:
        def __reduce__(self):
            return os.system, ("touch canary",)

    for name in ("p.txt", "t.modal.npz", "values.bin", "vectors.bin"):
        (tmp_path / name).write_text(script)
    with zipfile.ZipFile(tmp_path / "u.modal.npz", "w") as archive:
        archive.writestr("meta.npy", script)
        archive.writestr("../canary", script)
    np.savez(tmp_path / "pickle.modal.npz", meta=np.array([Evil()], dtype=object))
    before = sorted(os.listdir(tmp_path))
    disk = ["disk", "--diameter", 100, "--thickness", 12, "--h", 25]
    for words in (["bell", "--profile", "p.txt"], [*disk, "--import-modes", "values.bin", "vectors.bin"],
                  *(["raw", f"{name}.modal.npz", "--hit", "0,0,6"] for name in ("t", "u", "pickle"))):
        status, said = run(*words, "-o", "r.modal.npz", folder=tmp_path)
        assert status == 1, said
    assert sorted(os.listdir(tmp_path)) == before


@pytest.mark.parametrize("name", ["p.msh", "p.step", slow("p.stl"), slow("p.inp")])
def test_a_pipe_or_a_device_is_refused_at_once(name, tmp_path):
    os.mkfifo(tmp_path / name)
    assert run(name, folder=tmp_path, timeout=120)[0] == 1
    (tmp_path / name).unlink()
    (tmp_path / name).symlink_to("/dev/zero")
    assert run(name, folder=tmp_path, timeout=120)[0] == 1


def test_claims_of_sizes_cost_nothing(tmp_path):
    began = processor_seconds()
    for name, content in [("h.stl", b"\0" * 80 + struct.pack("<I", 2**32 - 1) + b"\0" * 100),
                          ("n.msh", MSH_2.replace("$Nodes\n4", "$Nodes\n4000000000")),
                          ("e.msh", MSH_2.replace("$Elements\n1", "$Elements\n4000000000")),
                          ("b.msh", MSH_4.replace("$Nodes\n1 4", "$Nodes\n1000000000000 4"))]:
        assert try_file(tmp_path, name, content)[0] == 1
    status, said = try_file(tmp_path, "s.inp", INP + "*NSET,NSET=A,GENERATE\n" + "1,4,1\n" * 200000)
    assert status == 1 and "entries in sets" in said
    numbers = INP.replace("4,0,0,1", "2147483647,0,0,1").replace("2,3,4", "2,3,2147483647")
    assert try_file(tmp_path, "i.inp", numbers + "*NSET,NSET=A,GENERATE\n2147483647,2147483647,1\n")[0] == 0
    assert processor_seconds() - began < 20


def is_alive(process):
    return os.path.exists(f"/proc/{process}") and open(f"/proc/{process}/stat").read().rpartition(")")[2].split()[0] != "Z"


@pytest.mark.parametrize("signal_number, status", [(signal.SIGINT, 130), (signal.SIGTERM, 130), (signal.SIGKILL, -9)])
def test_the_reading_process_ends_with_the_program(signal_number, status, tmp_path):
    write_obj(tmp_path / "block.obj", 100)  # fine tetrahedra of a large block: minutes of work
    program = subprocess.Popen([MODAL_FEM, "block.obj", "--h", "0.8", "--memory", "9000G", "-o", "b.modal.npz"], cwd=tmp_path,
                               stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    while not (children := open(f"/proc/{program.pid}/task/{program.pid}/children").read().split()):
        assert program.poll() is None
        time.sleep(0.01)
    program.send_signal(signal_number)
    assert program.wait(120) == status
    until = time.monotonic() + 60  # the child alone would go on for longer
    while any(is_alive(child) for child in children):
        assert time.monotonic() < until
        time.sleep(0.01)
    assert os.listdir(tmp_path) == ["block.obj"]


def test_a_file_that_takes_too_long_is_stopped_with_a_sentence(tmp_path):
    write_obj(tmp_path / "block.obj", 100)
    began = processor_seconds()
    status, said = run("block.obj", "--h", 0.7, "--memory", "9000G", "--time-limit", 1, "--quiet", folder=tmp_path)
    assert status == 1 and "block.obj" in said and "--time-limit" in said and processor_seconds() - began < 20, said
