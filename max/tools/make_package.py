#!/usr/bin/env python3
"""Makes the Max package: one folder, and a zip of it. Equal content gives an equal zip.

    make_package.py --declarations declarations.json --version 0.1.0 --output FOLDER
                    [--externals FOLDER] [--library FOLDER] [--zip FILE]

FOLDER/tactus/ gets package-info.json, externals/ (every .mxe64 and .mxo of --externals), help/, docs/refpages/, docs/
(the guides with their pictures), patchers/, init/ (the list of objects) and media/. media/, in which Max looks for
files, contains the bodies and networks that patchers load, from the staged Pd library (--library). The script reports
missing files and leaves them out. If check_patcher.py finds a mistake, no zip is written.
"""
import argparse
import json
import pathlib
import re
import shutil
import sys
import zipfile

import check_patcher
import help_patcher
import max_objects
import pd_to_max
import reference_page

ROOT = pathlib.Path(__file__).resolve().parents[2]
OWN = ROOT / "max" / "package"
NAME = "tactus"
ZIP_TIME = (1980, 1, 1, 0, 0, 0)

# The patches in patchers/; each one follows the patches that it uses.
ABSTRACTIONS = ("reed_sigma", "reed_point", "reed_difference", "reed_force", "reed_choice", "reed_guide")
PATCHES = [ROOT / "patches" / "reed" / f"{name}.pd" for name in (*ABSTRACTIONS, "reed_haptic")] + [
    ROOT / "patches" / "haptic" / "struck_disk.pd"]
DRAWN = "Pd draws its cells by data structures"
# The parts of Pd patches that have no equivalent in Max: {patch: {object, label, or beginning of a text or sentence:
# reason}}.
WITHOUT = {
    "reed_guide": {"switch~": "in Pd it stops the computation while guide is off"},
    "reed_haptic": {"reed_map": "the map of playability; " + DRAWN, "A note plays in bright areas": "",
                    "draw the map again": ""},
    "playability_map-help": {"reed_map": DRAWN, "reed_map draws": "", "quantity growth": "",
                             "quantity f_p": "", "s playability_map-map": ""},
}


def package_info(version, systems):
    return {"name": NAME, "displayname": "tactus", "version": version,
            "author": reference_page.AUTHOR,
            "description": "Physical models that you can hear and feel: "
                           "experimental, never run inside Max.",
            "tags": ["physical modelling", "haptics", "wind instruments", "footsteps", "modal synthesis"],
            "website": "", "extensible": 1, "max_version_min": "8.3", "max_version_max": "none",
            "homepatcher": "reed_haptic.maxpat", "os": systems,
            "package_extra": {"reverse_domain": "org.tactus", "copyright": "GPL-3.0-or-later"}}


def systems_of(externals):
    systems = {"windows": {"platform": ["x64"], "min_version": "none"}}
    if any(path.suffix == ".mxo" for path in externals):
        systems["macintosh"] = {"platform": ["x64", "aarch64"], "min_version": "none"}
    return systems


def help_source(name):
    """The Pd help patch, or the patch drawn for Max if Pd's uses objects that Max lacks."""
    own = OWN / "sources" / f"{name}-help.pd"
    return own if own.exists() else ROOT / "help" / f"{name}-help.pd"


def patchers(declarations):
    """A dictionary from file name to patcher, for patchers/ and help/."""
    sources = {d["name"]: help_source(d["name"]) for d in declarations}
    names = pd_to_max.Names([pd_to_max.read(path, ABSTRACTIONS) for path in [*sources.values(), *PATCHES]])
    made = {}
    for path in PATCHES:
        patcher, left_out = pd_to_max.convert_file(path, names, ABSTRACTIONS, WITHOUT.get(path.stem))
        y = patcher.height
        for what, reason in left_out:
            if reason:
                y = help_patcher.paragraph(patcher, f"In Pd only: {what}: {reason}", 16, y, 700) + 4
        if path.stem in ABSTRACTIONS:
            max_objects.declare_patcher(path.stem, patcher.ports())
        made[f"patchers/{path.stem}.maxpat"] = patcher.fit()
    for d in declarations:
        source = sources[d["name"]]
        made[f"help/{d['name']}.maxhelp"] = help_patcher.help_patcher(source, d, names, ABSTRACTIONS,
                                                                     WITHOUT.get(source.stem))
    return made


def copy_externals(folder, source):
    found = sorted(p for p in source.iterdir() if p.suffix in (".mxe64", ".mxo")) if source else []
    for path in found:
        (shutil.copytree if path.is_dir() else shutil.copyfile)(path, folder / path.name)
    return found


def copy_data(folder, library):
    """Copies bodies, stress tables and networks under the names that patchers use."""
    copied = 0
    for path in sorted(library.rglob("*")) if library else []:
        if path.suffix == ".npz" or path.suffix == ".txt" and path.parent != library:
            target = folder / path.relative_to(library)
            target.parent.mkdir(parents=True, exist_ok=True)
            shutil.copyfile(path, target)
            copied += 1
    return copied


def copy_guides(package):
    """Copies the guides and their pictures to the paths by which help patchers and guides refer to them."""
    for path in sorted((ROOT / "docs").rglob("*")):
        if path.suffix in (".md", ".png", ".svg"):
            target = package / path.relative_to(ROOT)
            target.parent.mkdir(parents=True, exist_ok=True)
            shutil.copyfile(path, target)


def missing_guides(package):
    """Guides that a patcher's text or a reference page names but the package lacks."""
    findings = []
    for path in sorted(p for p in package.rglob("*") if p.suffix in (".maxhelp", ".maxpat", ".xml")):
        for guide in set(re.findall(r"docs/[\w/]+\.md", path.read_text(encoding="utf-8"))):
            if not (package / guide).exists():
                findings.append(f"{path.name}: {guide} is not in the package")
    return findings


def missing_files(package):
    """Tables and texts that a patcher loads but the package lacks."""
    named = set()
    for path in list(package.rglob("*.maxhelp")) + list(package.rglob("*.maxpat")):
        named |= set(re.findall(r"[a-z_]+\.(?:modal|stress)\.npz|networks/\w+\.txt", path.read_text(encoding="utf-8")))
    return sorted(name for name in named if not (package / "media" / name).exists())


def write_zip(package, path):
    """Writes the zip with sorted names, one time and one mode, so that the same folder gives the same bytes."""
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED, compresslevel=9) as archive:
        for file in sorted(p for p in package.rglob("*") if p.is_file()):
            entry = zipfile.ZipInfo((pathlib.Path(NAME) / file.relative_to(package)).as_posix(), ZIP_TIME)
            entry.compress_type = zipfile.ZIP_DEFLATED
            entry.create_system = 3
            entry.external_attr = 0o100644 << 16
            archive.writestr(entry, file.read_bytes())


def make(arguments):
    declarations = max_objects.load_declarations(arguments.declarations)
    package = arguments.output / NAME
    shutil.rmtree(package, ignore_errors=True)
    folders = {name: package / name for name in ("externals", "help", "docs/refpages", "patchers", "init",
                                                 "media")}
    for folder in folders.values():
        folder.mkdir(parents=True)
    made = patchers(declarations)
    for name, patcher in made.items():
        (package / name).write_text(patcher.text(), encoding="utf-8")
    for d in declarations:
        page = folders["docs/refpages"] / f"{d['name']}.maxref.xml"
        page.write_text(reference_page.page_text(d), encoding="utf-8")
    externals = copy_externals(folders["externals"], arguments.externals)
    bodies = copy_data(folders["media"], arguments.library)
    (folders["init"] / f"{NAME}-objectlist.txt").write_text(
        "".join(f'max oblist "{NAME}" {d["name"]};\n' for d in declarations))
    copy_guides(package)
    shutil.copyfile(ROOT / "LICENSE", package / "license.txt")
    shutil.copyfile(OWN / "readme.md", package / "readme.md")
    info = package_info(arguments.version, systems_of(externals))
    (package / "package-info.json").write_text(json.dumps(info, indent="\t") + "\n")
    findings = [f"{name}: {finding}" for name, patcher in made.items() for finding in check_patcher.check(patcher)]
    return package, externals, bodies, findings + missing_guides(package)


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    for name in ("declarations", "output", "externals", "library", "zip"):
        parser.add_argument(f"--{name}", type=pathlib.Path, required=name in ("declarations", "output"))
    parser.add_argument("--version", required=True)
    arguments = parser.parse_args()
    package, externals, bodies, findings = make(arguments)
    for finding in findings:
        print(finding, file=sys.stderr)
    if arguments.zip and not findings:
        write_zip(package, arguments.zip)
    for name in missing_files(package):
        print(f"{name}: loaded by a patcher, but not in the package: give its folder by --library")
    print(f"{package}: {len(list((package / 'help').iterdir()))} objects, {len(externals)} externals, {bodies} data files"
          + ("" if externals else "; no externals: give their folder by --externals"))
    return 1 if findings else 0


if __name__ == "__main__":
    sys.exit(main())
