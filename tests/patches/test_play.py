"""./play: what the scenes need, the order of the work, the page, and quick scenes from what they say they need."""
import html
import json
import os
import pathlib
import re
import subprocess
import sys
import threading

import contents
import make_scene
import make_scenes
import numpy
import pytest
import report
import scipy.io.wavfile
import sound_check
from harness import stage_folder
from harness.run import ROOT

RATE = 48000
QUICK = ("board", "finger", "spring")
BUILD = pathlib.Path(os.environ.get("TACTUS_BUILD", stage_folder().parent))


def test_every_need_of_a_scene_is_a_target_of_the_build():
    said = subprocess.run(["ninja", "-C", BUILD, "-t", "targets", "all"], capture_output=True, text=True).stdout
    targets = {line.rpartition(":")[0] for line in said.splitlines()}
    for name in contents.names():
        assert contents.needs(name), name
        for need in contents.needs(name):
            if need in ("modal_fem", "part_stress") or need.startswith("stage_"):
                if not (BUILD / "programs" / "modal_fem" / "modal_fem").is_file():
                    continue  # built without finite elements
            assert make_scenes.target(need) in targets, f"{name}: {need}"


def externals_of(patch, seen=None):
    """The externals that a patch makes, also within its abstractions."""
    seen = set() if seen is None else seen
    found = set()
    for name in re.findall(r"^#X obj -?\d+ -?\d+ (?:tactus/)?([^ ;,]+)", patch.read_text(), re.MULTILINE):
        if (ROOT / "externals" / name / "CMakeLists.txt").is_file():
            found.add(name)
        abstraction = stage_folder() / f"{name}.pd"
        if abstraction.is_file() and name not in seen:
            seen.add(name)
            found |= externals_of(abstraction, seen)
    return found


def test_a_scene_needs_every_external_that_its_patch_makes():
    checked = 0
    for name in contents.names():
        patch = ROOT / contents.declared(name, "PATCH")
        if patch.suffix == ".pd" and patch.is_relative_to(ROOT / "patches") and "stage_patches" in contents.needs(name):
            assert externals_of(patch) <= set(contents.needs(name)), name
            checked += 1
    assert checked >= 6


def test_the_scenes_that_are_named_exist_and_the_page_names_every_scene():
    names = set(contents.names())
    assert {name for _, section in contents.SECTIONS for name in section} <= names
    assert set(contents.WORK) == names
    assert {name for name, *_ in contents.HIGHLIGHTS} <= set(contents.WORK)
    listed = subprocess.run([ROOT / "play", "--list"], capture_output=True, text=True, check=True).stdout
    assert {line.split()[0] for line in listed.splitlines()} == names
    assert {line.split()[0] for line in listed.splitlines() if line.endswith("(long: ./play --all)")} \
        == {name for name in names if contents.is_long(name)}


def test_greed_s_scene_plays_every_preset_that_the_object_declares():
    sys.modules.setdefault("make_scene", make_scene)
    import greed
    messages = next(d for d in json.loads((BUILD / "declarations.json").read_text()) if d["name"] == "greed~")["messages"]
    assert next(m for m in messages if m["name"] == "preset")["arguments"].split("|") == list(greed.TOP_PRESSURE)


@pytest.mark.parametrize("name", [name if name == "spring" else pytest.param(name, marks=pytest.mark.slow)
                                  for name in QUICK])
def test_a_scene_made_from_what_it_says_it_needs_has_sounds_without_faults(name, tmp_path):
    """They begin and end in silence, without clipping and clicks."""
    stage = tmp_path / "tactus"
    stage.mkdir()
    for path in stage_folder().iterdir():
        external = path.name.partition(".")[0] in contents.needs(name) and path.suffix.startswith(".l_")
        abstraction = path.suffix in (".pd", ".txt") and "stage_patches" in contents.needs(name)
        if external or abstraction:
            (stage / path.name).symlink_to(path)
    subprocess.run(["/usr/bin/python3", ROOT / "scripts" / "make_scene.py", name, tmp_path / "out"], check=True, cwd=ROOT,
                   env=dict(os.environ, TACTUS_STAGE=str(stage), MPLBACKEND="Agg"), timeout=300)
    sounds = sorted((tmp_path / "out" / name).glob("*.wav"))
    assert sounds
    for path in sounds:
        rate, samples = scipy.io.wavfile.read(path)
        assert abs(samples).max() > 0.05
        assert sound_check.faults(samples, rate) == [], path.name
    assert json.loads((tmp_path / "out" / name / "scene.json").read_text())["faults"] == []


def test_a_scene_names_the_sound_that_stops_in_mid_sound(tmp_path, capsys):
    scene = make_scene.Scene("cut", tmp_path, "", "")
    hum = 0.5 * numpy.sin(numpy.arange(RATE) / 30) * numpy.minimum(numpy.arange(RATE) / RATE, 0.1) ** 2 * 100
    scene.sound("hum", hum, RATE)
    scene.sound("good", make_scene.fade_out(hum, RATE, 0.2), RATE)
    assert scene.page["faults"][0].startswith("hum.wav: ends at -")
    assert all(fault.startswith("hum.wav: ") for fault in scene.page["faults"])
    assert "cut: hum.wav: ends at" in capsys.readouterr().out


def test_fade_out_leaves_what_comes_before_as_it_was_and_ends_in_silence():
    sound = numpy.random.default_rng(1).standard_normal((RATE, 2))
    faded = make_scene.fade_out(sound, RATE, 0.25)
    begin = RATE - round(0.27 * RATE)
    assert (faded[:begin] == sound[:begin]).all() and not faded[-round(0.02 * RATE):].any()
    gain = faded[begin:-960] / sound[begin:-960]
    assert (numpy.diff(gain[:, 0]) <= 0).all() and gain[len(gain) // 2, 0] == pytest.approx(0.5, abs=1e-3)
    whole = numpy.concatenate([numpy.ones(3), gain[:, 0], numpy.zeros(3)])
    assert abs(numpy.diff(whole, 2)).max() < 1e-6  # no bend at either end: nothing to be heard
    assert (make_scene.fade_out(sound[:, 0], RATE, 0.25) == faded[:, 0]).all()
    assert make_scene.fade_out(sound.astype(numpy.float32), RATE, 0.25).dtype == numpy.float32
    assert not make_scene.fade_out(sound[:100], RATE, 0.25).any()  # shorter than its fade


def scene(name, sounds=("tune",)):
    return {"name": name, "title": f"what {name} is", "description": "First `-sync`.\n\nSecond & last.",
            "took_seconds": 3.2, "faults": [],
            "parts": [*({"kind": "sound", "file": f"{s}.wav", "caption": s, "seconds": 2.0} for s in sounds),
                      {"kind": "table", "header": ["a"], "rows": [["<1>"]], "caption": ""},
                      {"kind": "picture", "file": "look.png", "caption": "a picture"}]}


def test_the_page_shows_what_is_made_in_its_sections_and_names_what_is_to_come():
    page = report.page({"board": scene("board"), "fanfare": scene("fanfare", ("fanfare", "dawn", "dove"))},
                       coming=["reed", "bodies"], failed=["greed"])
    order = [m[1] for m in re.finditer(r'<section id="([a-z-]+)"', page)]
    assert order == ["fanfare", "reed", "greed", "bodies", "board"]
    assert "2 of 4 scenes are still to come" in page
    first = page[page.index("<section id=first>"):page.index("<h2>Blown")]
    assert re.findall(r'src="([^"]+)"', first) == ["fanfare/fanfare.wav", "fanfare/dawn.wav"]
    assert first.count("still to come") == 2  # of the bodies and the reed
    assert page.count('src="fanfare/dove.wav"') == 1
    assert page.index("fanfare/dove.wav") > page.index("More: 1 sound, 1 table")
    assert page.index('src="fanfare/look.png"') < page.index("More: 1 sound")  # a picture without a click
    assert "<code>-sync</code>" in page and "Second &amp; last." in page and "&lt;1&gt;" in page
    assert "could not be made" in page[page.index('<section id="greed"'):page.index("<h2>Struck")]
    assert "still to come" not in report.page({"board": scene("board")})


def test_links_of_the_page_lead_to_files_of_the_checkout():
    page = report.page({name: scene(name) for name in contents.names()})
    links = [html.unescape(link) for link in re.findall(r'href="\.\./([^"#]+)"', page)]
    assert len(links) > 15
    for link in links:
        assert (ROOT / link).exists(), link
    for link in re.findall(r'href="#([^"]+)"', page):
        assert f'id="{link}"' in page or f"id={link}>" in page, link


def test_a_scene_that_was_made_before_shows_as_to_come_while_it_is_made_again(tmp_path):
    (tmp_path / "board").mkdir()
    (tmp_path / "board" / "scene.json").write_text(json.dumps(scene("board")))
    report.write(tmp_path, coming=["board"])
    assert 'src="board/tune.wav"' not in (tmp_path / "index.html").read_text()
    report.write(tmp_path)
    assert 'src="board/tune.wav"' in (tmp_path / "index.html").read_text()


SCENES = ["fanfare", "greed", "particles", "walking"]


class RecordedWork(make_scenes.Work):
    """Builds and makes nothing: the second need is built only when the first scene has been made."""

    def __init__(self, out, broken=(), installer=None):
        super().__init__(["fanfare", "walking", "particles", "greed"], out, 0.0, installer)
        self.out, self.broken, self.order, self.first_made = out, broken, [], threading.Event()

    def run_ninja(self, targets, name):
        self.order.append(("built", *targets))
        if len(self.order) > 1 and not self.broken:
            assert self.first_made.wait(20), "nothing is made while the rest is built"
        return ("FAILED: greed" if name in self.broken else None), 2.5

    def make_scene(self, name):
        folder = self.out / name
        folder.mkdir()
        (folder / "scene.json").write_text(json.dumps(scene(name)))
        self.order.append(("made", name))
        self.first_made.set()
        return 0, 1.5

    def run(self):
        threads = [threading.Thread(target=run) for run in (self.install, self.build, self.make_scenes, self.make_scenes)]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join(30)
            assert not thread.is_alive()


@pytest.fixture
def out(tmp_path, monkeypatch):
    monkeypatch.setattr(make_scenes, "OUT", tmp_path)
    return tmp_path


def installer(command):
    return os.spawnlp(os.P_NOWAIT, "sh", "sh", "-c", command)


def test_a_scene_is_made_and_on_the_page_while_the_rest_is_built(out):
    work = RecordedWork(out)
    work.run()
    first = work.order.index(("made", "fanfare"))
    assert work.order[0] == ("built", "greed_tilde_f32") and first <= 2
    assert sorted(work.made) == SCENES and not work.failed
    assert (out / "times.tsv").read_text().count("\n") == 1 + 3 + 4  # what two scenes need is built once
    assert "still to come" not in (out / "index.html").read_text()


def test_a_need_that_cannot_be_built_fails_its_scene_alone(out, capsys):
    work = RecordedWork(out, broken=("fanfare",))
    work.run()
    assert work.failed == ["fanfare"] and sorted(work.made) == SCENES[1:]
    assert "could not be made" in (out / "index.html").read_text()
    assert "FAILED: greed" in capsys.readouterr().err


def test_no_scene_is_made_before_what_it_runs_is_installed(out):
    (out / "wait").touch()
    work = RecordedWork(out, installer=installer(f"while [ -e {out}/wait ]; do sleep 0.05; done; touch {out}/installed"))
    make_there, build_there, early = work.make_scene, work.run_ninja, []

    def make(name):
        early.append(not (out / "installed").exists())
        return make_there(name)

    def build(targets, name):
        (out / "wait").unlink(missing_ok=True)  # the packages come while it is built
        return build_there(targets, name)
    work.make_scene, work.run_ninja = make, build
    work.run()
    assert not any(early) and work.order[0] == ("built", "greed_tilde_f32") and len(work.made) == 4


@pytest.mark.parametrize("while_built", [False, True])
def test_nothing_is_built_and_made_once_packages_could_not_be_installed(out, while_built):
    work = RecordedWork(out, broken=("fanfare",), installer=installer("exit 1"))
    built = work.run_ninja

    def run_ninja(targets, name):
        work.install()
        return built(targets, name)
    work.run_ninja = run_ninja
    for run in ([] if while_built else [work.install]) + [work.build, work.make_scenes]:
        run()
    assert sorted(work.failed) == SCENES and len(work.order) == while_built
