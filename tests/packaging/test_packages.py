"""Packages of the built library: what is in them, that a second making gives the same bytes, and that Pd
loads what comes out of them. Of TACTUS_BUILD, which is built."""
import hashlib
import os
import pathlib
import re
import subprocess
import sys
import zipfile

import pytest

ROOT = pathlib.Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "packaging"))
import make_packages  # noqa: E402
import try_package  # noqa: E402

BUILD = pathlib.Path(os.environ["TACTUS_BUILD"])
CMAKE = os.environ["TACTUS_CMAKE"]
VERSION = re.search(r"project\(tactus VERSION (\S+)", (ROOT / "CMakeLists.txt").read_text()).group(1)
# Pd's own expression for the name of a package (pd_deken.tcl).
DEKEN_NAME = re.compile(r"^([^\[\]()]+)((?:\[[^\[\]()]+\])*)((?:\([^\[\]()]+\))*)\.dek$")
# What every Debian has before Pd is installed.
WITH_THE_SYSTEM = {"libc.so.6", "libm.so.6", "ld-linux-x86-64.so.2", "ld-linux-aarch64.so.1"}


def run(*words):
    done = subprocess.run([str(word) for word in words], stdout=subprocess.PIPE, stderr=subprocess.STDOUT,
                          text=True, timeout=300, check=False)
    assert done.returncode == 0, done.stdout
    return done.stdout


def make(kind, folder):
    run(sys.executable, "-B", ROOT / "packaging" / "make_packages.py", "--source", ROOT, "--build", BUILD,
        "--cmake", CMAKE, "--version", VERSION, "--output", folder, kind)
    return folder


@pytest.fixture(name="made", scope="module")
def made_packages(tmp_path_factory):
    return make("deken", tmp_path_factory.mktemp("deken"))


@pytest.fixture(name="package", scope="module")
def library_package(made):
    return next(path for path in made.glob("*.dek") if "Linux" in path.name)


@pytest.fixture(name="library", scope="module")
def unpacked_library(package, tmp_path_factory):
    return try_package.unpack(package, tmp_path_factory.mktemp("unpacked"))


def modules(folder):
    return [path for pattern in ("*.l_*", "*.linux-*.so") for path in folder.glob(pattern)]


def test_deken_reads_the_name_and_the_files_beside_it(package):
    name, options, systems = DEKEN_NAME.match(package.name).groups()
    assert (name, options) == ("tactus", f"[v{VERSION}]")
    sizes = os.environ["TACTUS_FLOAT_SIZES"].split()
    assert re.findall(r"\(Linux-[a-z0-9]+-(\d+)\)", systems) == sizes
    digest = hashlib.sha256(package.read_bytes()).hexdigest()
    assert package.with_name(package.name + ".sha256").read_text().strip() == digest
    rows = package.with_name(package.name + ".txt").read_text().splitlines()
    assert all(re.fullmatch(r"\S+\t\S.*", row) for row in rows)
    assert {row.split("\t")[0] for row in rows} >= {"greed~", "footstep~", "modal_impact~", "phantom", "playability~"}


def test_a_package_names_the_systems_of_its_modules(tmp_path):
    for name in ("greed~.l_amd64", "greed~.linux-amd64-64.so", "greed~-help.pd", "tactus.m_amd64", "tactus.windows-amd64-64.dll",
                 "greed~.d_arm64", "greed~.darwin-arm64-64.so"):
        (tmp_path / name).touch()
    modules = make_packages.modules_in(tmp_path)
    assert modules["greed~", "darwin", "arm64", "64"] == tmp_path / "greed~.darwin-arm64-64.so"
    assert make_packages.systems_of(modules) == \
        "(Darwin-arm64-32)(Darwin-arm64-64)(Linux-amd64-32)(Linux-amd64-64)(Windows-amd64-32)(Windows-amd64-64)"
    (tmp_path / "tactus.d_amd64").touch()
    with pytest.raises(SystemExit, match="greed~: no module for amd64 with 32 bits"):
        make_packages.join_for_macos({key: path for key, path in make_packages.modules_in(tmp_path).items()
                                      if key[1] == "darwin"}, tmp_path)


@pytest.mark.slow
def test_the_same_build_gives_the_same_bytes(made, tmp_path):
    again = make("deken", tmp_path)
    names = sorted(path.name for path in made.iterdir())
    assert names == sorted(path.name for path in again.iterdir())
    for name in names:
        assert (made / name).read_bytes() == (again / name).read_bytes(), name


def test_one_folder_with_everything_that_a_user_reads(package, library):
    with zipfile.ZipFile(package) as archive:
        assert {name.split("/")[0] for name in archive.namelist()} == {"tactus"}
    for name in ("README.md", "LICENSE", "CHANGELOG.md", "third_party.md", "docs/greed.md", "docs/reference/greed~.md",
                 "greed~-help.pd", "reed_haptic.pd", "surfaces/snow.txt", "tactus-meta.pd"):
        assert (library / name).is_file(), name
    for link in re.findall(r"\]\(([^)#]+)\)", (library / "README.md").read_text()):
        assert (library / link).exists(), link
    for patch in re.findall(r"`([^`]+\.pd)`", (library / "README.md").read_text()):
        assert (library / patch).is_file(), patch
    for name in try_package.objects(library):
        assert (library / f"{name}-help.pd").is_file(), name
        assert len(list(library.glob(f"{name}.l*"))) == len(os.environ["TACTUS_FLOAT_SIZES"].split()), name


def test_externals_need_nothing_but_the_system_and_are_stripped(library):
    assert modules(library)
    for module in modules(library):
        needed = set(re.findall(r"NEEDED.*\[(.*)\]", run("readelf", "-d", module)))
        assert needed <= WITH_THE_SYSTEM, f"{module.name}: {needed - WITH_THE_SYSTEM}"
        assert ".symtab" not in run("readelf", "-S", "--wide", module), module.name
    programs = [path for path in library.rglob("*") if path.is_file() and path.read_bytes()[:4] == b"\x7fELF"]
    assert set(programs) == set(modules(library))


@pytest.mark.skipif(os.environ["TACTUS_FLOAT_SIZES"] == "64", reason="Debian's Pd reads 32-bit modules")
def test_pd_makes_every_object_of_the_package(library):
    assert try_package.load_every_object(library, ["pd"]) == {}


@pytest.mark.slow
@pytest.mark.skipif(os.environ["TACTUS_FLOAT_SIZES"] == "64", reason="Debian's Pd reads 32-bit modules")
def test_who_unpacks_it_makes_every_object_and_hears_every_help_patch(package, tmp_path):
    run(sys.executable, "-B", ROOT / "packaging" / "try_package.py", package, "--renders", tmp_path / "renders.tsv")


def test_a_broken_package_and_one_without_an_object_are_found(library, package, tmp_path):
    copy = tmp_path / package.name
    copy.write_bytes(package.read_bytes() + b" ")
    copy.with_name(copy.name + ".sha256").write_text("0" * 64)
    with pytest.raises(SystemExit, match="SHA-256"):
        try_package.unpack(copy, tmp_path / "unpacked")
    part = tmp_path / "tactus"
    part.mkdir()
    (part / "tactus-objects.txt").write_text("greed~\treed\n")
    assert list(try_package.load_every_object(part, ["pd"])) == ["greed~"]


@pytest.mark.slow
def test_debian_packages(tmp_path):
    made = {path.name.split("_")[0]: path for path in make("debian", tmp_path / "a").glob("*.deb")}
    for path in make("debian", tmp_path / "b").glob("*.deb"):
        assert path.read_bytes() == made[path.name.split("_")[0]].read_bytes(), path.name
    library = tmp_path / "root"
    run("dpkg-deb", "-x", made["pd-tactus"], library)
    assert (library / "usr/lib/pd/extra/tactus/greed~-help.pd").is_file()
    fields = run("dpkg-deb", "-f", made["pd-tactus"], "Depends", "Version", "Architecture")
    assert "puredata-core | puredata64-core | pd" in fields and VERSION in fields
    if "tactus-programs" in made:
        assert "libgmsh" in run("dpkg-deb", "-f", made["tactus-programs"], "Depends") or not (
            BUILD / "programs/modal_fem/modal_fem").exists()
        assert "usr/bin/" in run("dpkg-deb", "-c", made["tactus-programs"])
    if "32" in os.environ["TACTUS_FLOAT_SIZES"]:
        assert try_package.load_every_object(library / "usr/lib/pd/extra/tactus", ["pd"]) == {}
