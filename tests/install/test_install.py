"""`cmake --install` into an empty prefix, then what its users do: a project that finds the package, and
a Pd that loads an installed external. Of TACTUS_BUILD, which is built; nothing is compiled but the
ten-line project in consumer/."""
import os
import pathlib
import subprocess
import sys

import pytest

HERE = pathlib.Path(__file__).resolve().parent
ROOT = HERE.parents[1]
sys.path.insert(0, str(ROOT / "packaging"))
import try_package  # noqa: E402

BUILD = pathlib.Path(os.environ["TACTUS_BUILD"])
CMAKE = os.environ["TACTUS_CMAKE"]


def run(*words, status=0, **options):
    """What a command printed; its status must be the expected one."""
    done = subprocess.run([str(word) for word in words], stdout=subprocess.PIPE,
                          stderr=subprocess.STDOUT, text=True, timeout=120, check=False, **options)
    assert done.returncode == status, done.stdout
    return done.stdout


def configured(folder, text, *words, status=0):
    """What CMake says of a project whose CMakeLists.txt ends with the text."""
    (folder / "CMakeLists.txt").write_text("cmake_minimum_required(VERSION 3.22)\nproject(p LANGUAGES CXX)\n" + text)
    return run(CMAKE, "-S", folder, "-B", folder / "build", *words, status=status)


@pytest.fixture(name="prefix", scope="module")
def installed_prefix(tmp_path_factory):
    folder = tmp_path_factory.mktemp("prefix")
    for component in ("pd", "development", "programs"):
        run(CMAKE, "--install", BUILD, "--prefix", folder, "--component", component)
    return folder


def test_a_project_finds_the_package_and_computes_with_it(prefix, tmp_path):
    run(CMAKE, "-S", HERE / "consumer", "-B", tmp_path, f"-DCMAKE_PREFIX_PATH={prefix}")
    run(CMAKE, "--build", tmp_path)
    assert "0.00314159265 s" in run(tmp_path / "consumer")


def test_the_package_refuses_another_version_and_a_room_that_is_not_there(prefix, tmp_path):
    for wanted, said in (("0.9 REQUIRED", "0.9"), ("REQUIRED COMPONENTS cellar", "cellar")):
        text = f"find_package(tactus {wanted})\n"
        assert said in configured(tmp_path, text, f"-DCMAKE_PREFIX_PATH={prefix}", status=1)


def test_every_header_that_is_installed_finds_those_it_includes(prefix):
    top = prefix / "include" / "tactus"
    headers = list(top.glob("**/*.hpp"))
    assert len(headers) > 100
    for header in headers:
        for line in header.read_text().splitlines():
            if line.startswith('#include "'):
                assert (top / line.split('"')[1]).is_file(), f"{header.relative_to(top)}: {line}"


@pytest.mark.skipif(os.environ["TACTUS_FLOAT_SIZES"] == "64", reason="Debian's Pd reads 32-bit modules")
def test_pd_makes_every_installed_object(prefix):
    library = next(prefix.glob("**/tactus/tactus-objects.txt")).parent
    assert try_package.load_every_object(library, ["pd"]) == {}


@pytest.mark.skipif(not (BUILD / "programs/modal_fem/modal_fem").exists(),
                    reason="modal_fem is not built")
def test_an_installed_program_finds_what_lies_beside_it(prefix, tmp_path):
    program = prefix / "bin" / "modal_fem"
    assert program.resolve().parent == prefix / "libexec" / "tactus"
    assert (program.resolve().parent / "modal_sheet.py").is_file()
    output = run(program, "disk", "--diameter", "100", "--thickness", "12", "--h", "12", "--modes", "2",
                 "--quiet", "-o", tmp_path / "disk.modal.npz")
    assert (tmp_path / "disk.modal.npz").is_file(), output


def test_a_folder_that_was_configured_without_tests_gets_modules_for_max_with_them(tmp_path):
    text = f"include({ROOT}/cmake/Options.cmake)\nmessage(STATUS \"Max: ${{TACTUS_MAX}}\")\n"
    assert "Max: OFF" in configured(tmp_path, text, "-DTACTUS_TESTS=OFF")
    assert "Max: ON" in configured(tmp_path, text, "-DTACTUS_TESTS=ON")
    assert "Max: OFF" in configured(tmp_path, text, "-DTACTUS_MAX=OFF")


def test_a_header_that_is_installed_after_the_first_configuration_is_found(tmp_path):
    """`./play` and then `./test`, which installs more packages."""
    text = (f"include({ROOT}/cmake/OptionalHeader.cmake)\nset(CMAKE_REQUIRED_INCLUDES {tmp_path}/include)\n"
            "optional_header(cellar.hpp HAS_CELLAR)\nmessage(STATUS \"cellar: '${HAS_CELLAR}'\")\n")
    assert "cellar: ''" in configured(tmp_path, text)
    (tmp_path / "include").mkdir()
    (tmp_path / "include" / "cellar.hpp").write_text("")
    assert "cellar: '1'" in configured(tmp_path, text)
    assert "cellar: '1'" in configured(tmp_path, text)
