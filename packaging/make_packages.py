#!/usr/bin/env python3
"""Makes packages of a build of tactus: the same commit gives the same bytes.

    make_packages.py --source FOLDER --build FOLDER --cmake PROGRAM --version 0.1.0 --output FOLDER deken|debian

deken: `tactus[v0.1.0](Linux-amd64-32)(Linux-amd64-64).dek`, a zip with one folder `tactus/` of what
`cmake --install --component pd` installs, stripped; beside it its SHA-256 as Pd's package manager compares
it (the digest alone) and the list of objects (`NAME TAB TITLE`), and `tactus[v0.1.0](Sources).dek`.
The names are deken's: github.com/pure-data/deken, developer/README.md.
With `--modules FOLDER` the package is of the same library for macOS: in place of this machine's modules it has those of
the folders, one for each processor, joined to one file for both (`.d_fat`, `.darwin-fat-64.so`; llvm-lipo).

debian: pd-tactus and tactus-programs, by CPack.
"""
import argparse
import hashlib
import os
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile
import time
import zipfile

NAME = "tactus"
LEGACY_SYSTEMS = {"l": "linux", "m": "windows", "d": "darwin"}
MODULE = re.compile(r"(.+)\.(?:([lmd])_(\w+)|(linux|windows|darwin)-(\w+)-(64)\.(?:so|dll))")


def fail(sentence):
    sys.exit(f"make_packages: {sentence}")


def run(*words, **options):
    done = subprocess.run([str(word) for word in words], stdout=subprocess.PIPE, stderr=subprocess.STDOUT,
                          text=True, check=False, **options)
    if done.returncode != 0:
        fail(f"{' '.join(map(str, words))}: status {done.returncode}:\n{done.stdout}")
    return done.stdout


def has_history(source):
    return (source / ".git").exists() and shutil.which("git") is not None


def commit_time(source):
    """Seconds since 1970 of the commit; of SOURCE_DATE_EPOCH if it is set (reproducible-builds.org)."""
    if "SOURCE_DATE_EPOCH" in os.environ:
        return int(os.environ["SOURCE_DATE_EPOCH"])
    if not has_history(source):
        return int((source / "CHANGELOG.md").stat().st_mtime)
    return int(run("git", "-C", source, "log", "-1", "--format=%ct"))


def install(arguments, component, folder):
    run(arguments.cmake, "--install", arguments.build, "--strip", "--prefix", folder, "--component", component)
    return folder


def modules_in(folder):
    """{(object, system, processor, bits of Pd's numbers): Path}"""
    found = {}
    for path in folder.iterdir():
        if match := MODULE.fullmatch(path.name):
            name, letter, processor, system, processor_64, bits = match.groups()
            found[name, system or LEGACY_SYSTEMS[letter], processor_64 or processor, bits or "32"] = path
    if not found:
        fail(f"{folder}: no external is in it")
    return found


def systems_of(modules):
    """As deken names them: (Linux-amd64-32)(Linux-amd64-64)"""
    return "".join(sorted({f"({system.capitalize()}-{processor}-{bits})" for _, system, processor, bits in modules}))


def join_for_macos(modules, library):
    """Writes the modules for all processors of macOS into the library, stripped of the names of what stays inside."""
    processors = {processor for _, _, processor, _ in modules}
    for name, bits in sorted({(name, bits) for name, _, _, bits in modules}):
        parts = {processor: modules.get((name, "darwin", processor, bits)) for processor in sorted(processors)}
        if None in parts.values():
            fail(f"{name}: no module for {' and '.join(key for key, part in parts.items() if not part)} with {bits} bits")
        joined = library / (f"{name}.d_fat" if bits == "32" else f"{name}.darwin-fat-64.so")
        with tempfile.TemporaryDirectory() as folder:
            stripped = [pathlib.Path(folder) / processor for processor in parts]
            for part, file in zip(parts.values(), stripped):
                run("llvm-strip-14", "-x", part, "-o", file)
            run("llvm-lipo-14", "-create", *stripped, "-output", joined)


def write_zip(path, top, files, seconds):
    """A zip whose bytes follow from the names and contents of files, {name in it: Path}, alone."""
    moment = time.gmtime(max(seconds, 315532800))[:6]  # a zip knows no time before 1980
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED, compresslevel=9) as archive:
        for name in sorted(files):
            entry = zipfile.ZipInfo(f"{top}/{name}", moment)
            entry.compress_type = zipfile.ZIP_DEFLATED
            entry.create_system = 3  # Unix: the mode below
            runnable = os.access(files[name], os.X_OK)
            entry.external_attr = (0o100755 if runnable else 0o100644) << 16
            archive.writestr(entry, files[name].read_bytes())


def write_digest(path):
    digest = hashlib.sha256(path.read_bytes()).hexdigest()
    path.with_name(path.name + ".sha256").write_text(digest + "\n")
    return digest


def files_below(folder):
    return {path.relative_to(folder).as_posix(): path for path in folder.rglob("*") if path.is_file()}


def make_deken(arguments, seconds):
    with tempfile.TemporaryDirectory() as prefix:
        install(arguments, "pd", pathlib.Path(prefix))
        library = next(pathlib.Path(prefix).glob(f"**/{NAME}/{NAME}-objects.txt")).parent
        modules = modules_in(library)
        if arguments.modules:
            for path in modules.values():
                path.unlink()
            modules = {key: path for folder in arguments.modules for key, path in modules_in(folder).items()}
            join_for_macos(modules, library)
        package = arguments.output / f"{NAME}[v{arguments.version}]{systems_of(modules)}.dek"
        write_zip(package, NAME, files_below(library), seconds)
        shutil.copyfile(library / f"{NAME}-objects.txt", f"{package}.txt")
    made = [package]
    if has_history(arguments.source) and not arguments.modules:
        sources = arguments.output / f"{NAME}[v{arguments.version}](Sources).dek"
        run("git", "-C", arguments.source, "archive", "--format=zip", f"--prefix={NAME}/", "-o", sources, "HEAD")
        made.append(sources)
    return made


def make_debian(arguments, seconds):
    for old in arguments.output.glob("*.deb"):
        old.unlink()
    run(arguments.cmake.with_name("cpack"), "-G", "DEB", "-B", arguments.output, cwd=arguments.build,
        env={**os.environ, "SOURCE_DATE_EPOCH": str(seconds)})
    shutil.rmtree(arguments.output / "_CPack_Packages", ignore_errors=True)
    return sorted(arguments.output.glob("*.deb"))


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    for name in ("--source", "--build", "--cmake", "--output"):
        parser.add_argument(name, type=pathlib.Path, required=True)
    parser.add_argument("--version", required=True)
    parser.add_argument("--modules", type=pathlib.Path, action="append", default=[], metavar="FOLDER")
    parser.add_argument("kind", choices=("deken", "debian"))
    arguments = parser.parse_args()
    arguments.output.mkdir(parents=True, exist_ok=True)
    make = make_deken if arguments.kind == "deken" else make_debian
    for package in make(arguments, commit_time(arguments.source)):
        digest = write_digest(package)
        print(f"{package}\n  {package.stat().st_size / 1e6:.1f} MB, sha256 {digest}", flush=True)


if __name__ == "__main__":
    main()
