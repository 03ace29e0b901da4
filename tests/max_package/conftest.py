"""Makes the package once, from the declarations of the build, in a temporary folder."""
import argparse
import os
import pathlib
import sys

import pytest

ROOT = pathlib.Path(__file__).resolve().parents[2]
BUILD = pathlib.Path(os.environ.get("TACTUS_BUILD", ROOT / "build"))
sys.path.insert(0, str(ROOT / "max" / "tools"))

import make_package  # noqa: E402
import max_objects  # noqa: E402


@pytest.fixture(scope="session")
def declarations():
    return max_objects.load_declarations(BUILD / "declarations.json")


@pytest.fixture(scope="session")
def package(tmp_path_factory, declarations):
    """The finished package folder, with two stand-ins for externals and one data file."""
    folder = tmp_path_factory.mktemp("package")
    externals, library = folder / "given", folder / "library"
    externals.mkdir()
    (externals / "greed~.mxe64").write_bytes(b"a stand-in")
    (externals / "notes.txt").write_text("not an external")
    (library / "networks").mkdir(parents=True)
    (library / "networks" / "drop.txt").write_text("string s 40\n")
    (library / "disk.modal.npz").write_bytes(b"a stand-in")
    (library / "greed~-help.pd").write_text("not for Max")
    arguments = argparse.Namespace(declarations=BUILD / "declarations.json", version="1.2.3",
                                   output=folder / "out", externals=externals, library=library)
    package, _, _, findings = make_package.make(arguments)
    assert findings == []
    return package
