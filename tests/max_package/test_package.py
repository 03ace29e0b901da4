"""The finished package: complete against the declarations, without findings, the same bytes each time."""
import json
import os
import re
import xml.etree.ElementTree as xml
import zipfile

import pytest

import make_package
from help_patcher import ports_of


def tabs(package, name):
    root = json.loads((package / "help" / f"{name}.maxhelp").read_text(encoding="utf-8"))["patcher"]
    assert (root["showrootpatcherontab"], root["showontab"]) == (0, 0)
    found = {e["box"]["text"].removeprefix("p "): e["box"]["patcher"] for e in root["boxes"]}
    assert all(tab["showontab"] == 1 for tab in found.values())
    return found


def all_boxes(patcher):
    for entry in patcher["boxes"]:
        yield entry["box"]
        if "patcher" in entry["box"]:
            yield from all_boxes(entry["box"]["patcher"])


def test_the_guides_that_help_names_are_there_with_their_pictures(package, tmp_path):
    named = {guide for path in package.rglob("*.maxhelp") for guide in re.findall(r"docs/\w+\.md", path.read_text())}
    assert {"docs/phantom_safety.md", "docs/network.md"} <= named
    for guide in (package / "docs").rglob("*.md"):
        for picture in re.findall(r"!\[[^]]*\]\(([^):]+\.png)\)", guide.read_text(encoding="utf-8")):
            assert (guide.parent / picture).exists(), (guide.name, picture)
    (tmp_path / "some.maxhelp").write_text("see docs/nowhere.md")
    assert make_package.missing_guides(tmp_path) == ["some.maxhelp: docs/nowhere.md is not in the package"]


def test_every_object_has_help_and_a_reference_page(package, declarations):
    names = sorted(d["name"] for d in declarations)
    assert len(names) == len(set(names)) >= 14
    assert sorted(p.name.removesuffix(".maxhelp") for p in (package / "help").iterdir()) == names
    pages = (package / "docs" / "refpages").iterdir()
    assert sorted(p.name.removesuffix(".maxref.xml") for p in pages) == names


def test_help_shows_the_object_its_attributes_and_messages(package, declarations):
    for d in declarations:
        found = tabs(package, d["name"])
        example = list(all_boxes(found["example"]))
        assert any((b.get("text") or "").split(" ")[0] == d["name"] for b in example), d["name"]
        assert any(d["description"] == b.get("text") for b in example), d["name"]
        if d["signal"]:  # is started by one click, and heard
            assert any("dsp start" in b.get("text", "") for b in example), d["name"]
            assert any(b["maxclass"] == "ezdac~" for b in example), d["name"]
        if d["parameters"]:
            menus = [b["attr"] for b in all_boxes(found["attributes"]) if b["maxclass"] == "attrui"]
            assert menus == [p["name"] for p in d["parameters"]]
        texts = [b.get("text", "") for b in all_boxes(found["messages"])]
        for m in d["messages"]:
            assert m["name"] in {t.split(" ")[0] for t in texts} and m["text"] in texts, (d["name"], m["name"])
        texts = " ".join(b.get("text", "") for b in all_boxes(found["inlets outlets"]))
        assert all(p["text"] in texts for p in d["inlets"] + d["outlets"])


def test_nothing_sends_a_reader_to_what_only_pd_has(package):
    for path in sorted(package.rglob("*.max*")):
        texts = [path.read_text(encoding="utf-8")] if path.suffix == ".xml" else [
            b.get("text", "") for b in all_boxes(json.loads(path.read_text(encoding="utf-8"))["patcher"])]
        for text in texts:
            assert not re.search(r"Pd's (window|path|search)|\b(in|see) the log\b", text), (path.name, text)
    text = (package / "patchers" / "reed_haptic.maxpat").read_text(encoding="utf-8")
    assert "red square" not in text and "draw the map" not in text and "leads out of silence.\"" in text
    assert "while guide is on" not in text


def test_what_a_help_patcher_sends_by_name_arrives(package):
    for path in sorted((package / "help").iterdir()):
        sent, received = set(), {"dsp"}
        for b in all_boxes(json.loads(path.read_text(encoding="utf-8"))["patcher"]):
            words = b.get("text", "").split()
            if b["maxclass"] == "newobj" and words[0] in ("s", "send~", "r", "receive~"):
                (sent if words[0].startswith("s") else received).add(words[1])
            if b["maxclass"] == "message":
                sent |= set(re.findall(r";\s*([^\s;]+)", b["text"]))
        assert sent <= received, (path.name, sent - received)


def test_a_reference_page_lists_what_is_declared_in_its_order(package, declarations):
    for d in declarations:
        root = xml.parse(package / "docs" / "refpages" / f"{d['name']}.maxref.xml").getroot()
        assert root.get("name") == d["name"] and root.findtext("description") == d["description"]
        for side, tag in (("inlets", "inlet"), ("outlets", "outlet")):
            digests = [e.findtext("digest") for e in root.findall(f"{tag}list/{tag}")]
            assert [digest.split(" (")[0] for digest in digests] == [p["name"] for p in ports_of(d, side)]
        assert [e.get("name") for e in root.findall("objarglist/objarg")] == d["arguments"]
        messages = [m["name"] for m in d["messages"]]
        assert [e.get("name") for e in root.findall("methodlist/method")][:len(messages)] == messages
        attributes = root.findall("attributelist/attribute")
        assert [e.get("name") for e in attributes] == [p["name"] for p in d["parameters"]]
        for element, p in zip(attributes, d["parameters"]):
            words = p["choices"] or [f"{v:.10g}" for v in p["values"] or (p["lowest"], p["highest"])]
            assert all(word in element.findtext("description") for word in [*words, p["unit"]])
            assert [e.get("name") for e in element.findall("enumlist/enum")] == p["choices"]


def test_the_folder_holds_what_was_given_and_says_what_was_not_run(package):
    assert [p.name for p in (package / "externals").iterdir()] == ["greed~.mxe64"]
    assert (package / "media/disk.modal.npz").exists() and (package / "media/networks/drop.txt").exists()
    assert not list(package.rglob("*.pd"))
    readme = " ".join((package / "readme.md").read_text().split())
    assert "Nothing here has yet been run inside Max" in readme
    assert "a stub of Max alone" in readme
    info = json.loads((package / "package-info.json").read_text())
    assert info["name"] == "tactus" and info["version"] == "1.2.3" and set(info["os"]) == {"windows"}
    assert "never run inside Max" in info["description"]
    assert (package / "patchers" / info["homepatcher"]).exists()
    assert make_package.missing_files(package) == ["beam.stress.npz", "plank.modal.npz", "plate.modal.npz"]  # not given


def test_patchers_find_their_abstractions(package):
    for path in sorted((package / "patchers").glob("*.maxpat")):
        for box in all_boxes(json.loads(path.read_text())["patcher"]):
            name = (box.get("text") or " ").split(" ")[0]
            if name.startswith("reed_") and box["maxclass"] == "newobj":
                assert (package / "patchers" / f"{name}.maxpat").exists(), name


def test_the_zip_is_the_same_for_the_same_content(package, tmp_path):
    make_package.write_zip(package, tmp_path / "a.zip")
    for path in package.rglob("*.maxhelp"):
        os.utime(path, (1, 1))
    make_package.write_zip(package, tmp_path / "b.zip")
    assert (tmp_path / "a.zip").read_bytes() == (tmp_path / "b.zip").read_bytes()
    with zipfile.ZipFile(tmp_path / "a.zip") as archive:
        names = archive.namelist()
        assert archive.testzip() is None
    assert names == sorted(names) and all(n.startswith("tactus/") for n in names)
    assert set(names) == {f"tactus/{p.relative_to(package).as_posix()}" for p in package.rglob("*")
                          if p.is_file()}
