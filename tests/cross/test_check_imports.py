"""check_imports.py finds each kind of fault in a module made with it, and none in the same module without it.
TACTUS_CC, TACTUS_DLLTOOL and TACTUS_OBJDUMP are the cross compiler's."""
import os
import pathlib
import subprocess
import sys

import pytest

FOLDER = pathlib.Path(__file__).resolve().parent
ROOT = FOLDER.parent.parent
CC, OBJDUMP = os.environ["TACTUS_CC"], os.environ["TACTUS_OBJDUMP"]
WINDOWS = "mingw" in CC
PD = "void pd_bind(void); EXPORT void greed_tilde_setup(void) { pd_bind(); }"
SILENT = "EXPORT void greed_tilde_setup(void) {}"
MAX = "void class_new(void); EXPORT void ext_main(void) { class_new(); }"

# fault: name of the module, source, (library, a function that it gives), what is said
RIGHT = {
    "pd": ("greed~.m_amd64", PD, [("pd.dll", "pd_bind")], []),
    "pd64": ("greed~.windows-amd64-64.dll", PD, [("pd64.dll", "pd_bind")], []),
    "max": ("greed~.mxe64", MAX, [("MaxAPI.dll", "class_new")], []),
} if WINDOWS else {"pd": ("greed~.l_arm64", PD, [], [])}
FAULTS = {
    "a compiler's library": ("greed~.m_amd64", "void foreign(void);" + PD.replace("{ pd_bind();", "{ pd_bind(); foreign();"),
                             [("pd.dll", "pd_bind"), ("libwinpthread-1.dll", "foreign")], ["needs libwinpthread-1.dll"]),
    "the same in Max": ("greed~.mxe64", "void foreign(void);" + MAX.replace("{ class_new();", "{ class_new(); foreign();"),
                        [("MaxAPI.dll", "class_new"), ("libstdc++-6.dll", "foreign")], ["needs libstdc++-6.dll"]),
    "another Pd's DLL": ("greed~.windows-amd64-64.dll", PD, [("pd.dll", "pd_bind")],
                         ["needs pd.dll", "does not load into pd64.dll"]),
    "a function of a newer Pd": ("greed~.m_amd64", PD.replace("pd_bind", "pd_queue_mess"), [("pd.dll", "pd_queue_mess")],
                                 ["takes pd_queue_mess of pd.dll, which no .def file lists"]),
    "no host": ("greed~.m_amd64", SILENT, [], ["does not load into pd.dll"]),
    "two functions given": ("greed~.m_amd64", PD + "EXPORT void second(void) {}", [("pd.dll", "pd_bind")],
                            ["gives ['greed_tilde_setup', 'second'], not greed_tilde_setup alone"]),
    "another set-up": ("reed~.m_amd64", PD, [("pd.dll", "pd_bind")],
                       ["gives ['greed_tilde_setup'], not reed_tilde_setup alone"]),
} if WINDOWS else {
    "a compiler's library": ("greed~.l_arm64", "void foreign(void);" + PD.replace("{ pd_bind();", "{ pd_bind(); foreign();"),
                             [("libforeign.so.1", "foreign")], ["needs libforeign.so.1"]),
    "two functions given": ("greed~.l_arm64", PD + "EXPORT void second(void) {}", [],
                            ["gives ['greed_tilde_setup', 'second'], not greed_tilde_setup alone"]),
    "another set-up": ("reed~.l_arm64", PD, [], ["gives ['greed_tilde_setup'], not reed_tilde_setup alone"]),
}


def library(folder, name, function):
    """What a module is linked with, so that it needs the library at run time."""
    if WINDOWS:
        definitions, made = folder / f"{name}.def", folder / f"lib{name}.a"
        definitions.write_text(f"LIBRARY {name}\nEXPORTS\n{function}\n")
        subprocess.run([os.environ["TACTUS_DLLTOOL"], "-d", definitions, "-D", name, "-l", made], check=True)
        return made
    source = folder / f"{name}.c"
    source.write_text(f"void {function}(void) {{}}\n")
    subprocess.run([CC, "-shared", "-fPIC", f"-Wl,-soname,{name}", source, "-o", folder / name], check=True)
    return folder / name


def check(folder, name, source, libraries):
    """(status, what is said of the module)"""
    stage, parts = folder / "stage", folder / "parts"
    stage.mkdir()
    parts.mkdir()
    export = "__declspec(dllexport)" if WINDOWS else '__attribute__((visibility("default")))'
    (parts / "module.c").write_text(source.replace("EXPORT", export) + "\n")
    subprocess.run([CC, "-shared", "-fPIC", "-fvisibility=hidden", parts / "module.c",
                    *(library(parts, *one) for one in libraries), "-static-libgcc", "-o", stage / name], check=True)
    if name.endswith(".mxe64"):
        definitions = [ROOT / "max" / "abi" / f"{dll}.def" for dll in ("MaxAPI", "MaxAudio")]
    else:
        definitions = [ROOT / "pd" / "pd.def"]
    done = subprocess.run([sys.executable, FOLDER / "check_imports.py", "--objdump", OBJDUMP,
                           *(word for one in definitions for word in ("--definitions", one)), stage],
                          capture_output=True, text=True)
    lines = done.stdout.splitlines()
    assert lines, done.stderr
    assert lines[-1] == f"1 modules, {len(lines) - 1} faults"
    return done.returncode, [line.removeprefix(name + " ") for line in lines[:-1]]


@pytest.mark.parametrize("kind", RIGHT)
def test_a_right_module_has_no_fault(kind, tmp_path):
    name, source, libraries, _ = RIGHT[kind]
    assert check(tmp_path, name, source, libraries) == (0, [])


@pytest.mark.parametrize("fault", FAULTS)
def test_a_fault_is_found(fault, tmp_path):
    name, source, libraries, said = FAULTS[fault]
    status, found = check(tmp_path, name, source, libraries)
    assert status == 1 and sorted(found) == sorted(said)


def test_a_folder_without_modules_is_a_fault(tmp_path):
    done = subprocess.run([sys.executable, FOLDER / "check_imports.py", "--objdump", OBJDUMP, "--definitions",
                           ROOT / "pd" / "pd.def", tmp_path])
    assert done.returncode == 1
