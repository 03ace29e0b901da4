"""The library folder in Pd: how objects and files are found, which bodies it holds and how loud they are."""
import json
import shutil

import numpy
import pytest
from harness import Patch, run, stage_folder

BODIES = ("bar", "bell", "board", "bowl", "glass", "plate", "tube")  # what README promises
with_bodies = pytest.mark.skipif(not (stage_folder() / "bowl.modal.npz").is_file(),
                                 reason="this build does not make the bodies of finite elements")


def body_name(path):
    return json.loads(bytes(numpy.load(path)["meta"]))["body_name"]


@pytest.fixture
def parent(tmp_path, monkeypatch):
    """A folder whose tactus/ is the library, which is not in Pd's path by itself."""
    stage = stage_folder()
    empty = tmp_path / "empty"
    folder = tmp_path / "a folder, with + and blanks"
    empty.mkdir()
    folder.mkdir()
    (folder / "tactus").symlink_to(stage)
    monkeypatch.setenv("TACTUS_STAGE", str(empty))
    return folder


def boxes(folder, names, declare="", **options):
    """What Pd prints when a patch with these boxes is opened."""
    lines = ["#N canvas 0 0 400 300 12;"] + ([f"#X declare {declare};"] if declare else [])
    lines += [f"#X obj 10 10 {name};" for name in names]
    lines += ["#X obj 10 40 loadbang;", "#X obj 10 60 delay 20;", "#X msg 10 80 \\; pd quit;"]
    lines += [f"#X connect {i} 0 {i + 1} 0;" for i in (len(names), len(names) + 1)]
    (folder / "boxes.pd").write_text("\n".join(lines) + "\n")
    return run.run_pd([folder / "boxes.pd"], **options)


@pytest.mark.parametrize("form", ["declare", "declare_slash", "flag", "flag_slash", "flag_in_the_folder", "declare_path"])
def test_the_library_is_loaded_by_its_name(tmp_path, parent, form):
    names = [line.split("\t")[0] for line in (parent / "tactus" / "tactus-objects.txt").read_text().splitlines()]
    assert len(names) == len(list((run.ROOT / "externals").glob("*/CMakeLists.txt")))
    names.append("mass_spring")  # and an abstraction
    home = tmp_path / "home"  # where every Pd looks by itself
    (home / ".local/lib/pd").mkdir(parents=True)
    (home / ".local/lib/pd/extra").symlink_to(parent)
    options = {"declare": dict(declare="-lib tactus", path=[parent]),
               "declare_slash": dict(declare="-lib tactus/tactus", path=[parent]),
               "flag": dict(path=[parent], arguments=["-lib", "tactus"]),
               "flag_slash": dict(path=[parent], arguments=["-lib", "tactus/tactus"]),
               "flag_in_the_folder": dict(path=[parent / "tactus"], arguments=["-lib", "tactus"]),
               "declare_path": dict(declare="-stdpath tactus", environment={"HOME": str(home)})}[form]
    said = boxes(tmp_path, names, **options)
    assert "couldn't create" not in said and "error" not in said and "can't load" not in said, said
    if form.startswith("declare"):
        alone = boxes(tmp_path, names, path=[parent])
        assert alone.count("couldn't create") == len(names)  # nothing else finds them


def load(words, path, **options):
    """What [modal_impact~] has loaded, by its info outlet."""
    patch = Patch()
    box = patch.obj(*words, "-sync", 1)
    patch.log("info", box[3])
    patch.at(0, box, "get body")  # before the first block of audio
    lines = patch.render(0.1, path=path, **options).logs["info"]
    return next(atoms[1] for _, atoms in lines if atoms[0] == "body")


@with_bodies
def test_a_table_is_found_beside_the_patch_in_the_path_beside_the_object_and_in_the_library(tmp_path, parent):
    bowl, glass = (body_name(parent / "tactus" / f"{name}.modal.npz") for name in ("bowl", "glass"))
    for name in ("bowl", "bowl.modal.npz"):  # beside the object
        assert load(["tactus/modal_impact~", name], [parent]) == bowl
    own = tmp_path / "own"  # the object alone, elsewhere: then the library's table
    own.mkdir()
    for module in (parent / "tactus").glob("modal_impact~.l_*"):
        shutil.copy(module, own)
    assert load(["modal_impact~", "bowl"], [own, parent]) == bowl
    assert load(["modal_impact~", "bowl"], [own], expect_errors=[
        "load bowl: file not found beside the patch, in the search path or beside the object"]) == "none"
    other = tmp_path / "other"  # Pd's path comes before both
    other.mkdir()
    shutil.copy(parent / "tactus" / "glass.modal.npz", other / "bowl.modal.npz")
    assert load(["tactus/modal_impact~", "bowl"], [parent, other]) == glass
    here = tmp_path / "here"  # and the patch's folder before that
    here.mkdir()
    shutil.copy(parent / "tactus" / "bell.modal.npz", here / "bowl.modal.npz")
    assert load(["tactus/modal_impact~", "bowl"], [parent, other], keep=here) == body_name(here / "bowl.modal.npz")
    assert load(["tactus/modal_impact~", str(other / "bowl")], [parent]) == glass  # an absolute name


def test_other_objects_find_their_files_beside_themselves(parent):
    patch = Patch()
    part = patch.obj("tactus/stress_haptic", "beam")
    patch.log("info", part[2])
    patch.at(50, part, "get table")
    walker = patch.obj("tactus/footstep~", "gravel")
    patch.log("surface", walker[8])
    patch.at(50, walker, "get surface")
    result = patch.render(0.2, path=[parent])
    assert [atoms[0] for _, atoms in result.logs["info"]].count("table") >= 1
    assert [atoms for _, atoms in result.logs["surface"]] == [["surface", "gravel", "gravel", 0]]


@with_bodies
def test_what_the_two_default_listeners_hear_sums_to_one_signal():
    """10 lg of the power of (left + right)/2 over their mean power: 0 for equals, -3 for unrelated sounds."""
    patch = Patch()
    strikes = ("hit 1", "hitv 7 1", "hitv 101 1", "hitv 333 1")
    bodies = sorted(path.name.split(".")[0] for path in stage_folder().glob("*.modal.npz"))
    for body in bodies:
        box = patch.obj("modal_impact~", body, "-gain", .001)
        for i, strike in enumerate(strikes):
            patch.at(500 * i + 10, box, strike)
            patch.at(500 * i + 490, box, "reset")
        for i, side in enumerate(("left", "right")):
            patch.record(f"{body} {side}", box[i])
    result = patch.render(len(strikes) / 2, timeout=120)
    for body in bodies:
        left, right = (result[f"{body} {side}"].astype(float).reshape(len(strikes), -1)[:, :24000 * 98 // 100]
                       for side in ("left", "right"))
        fold = 10 * numpy.log10(numpy.mean((left + right) ** 2, 1) / 2 / numpy.mean(left ** 2 + right ** 2, 1))
        assert fold[0] > -3 and fold.mean() > -3 and fold.min() > -3.6, (body, fold)


def strikes(*messages, sync=0, ms=0):
    """What the plate sounds in a render, and its levels in dB 50 ms after the messages."""
    patch = Patch()
    box = patch.obj("modal_impact~", "plate", "-sync", sync)
    for message in messages:
        patch.at(ms, box, message)
    patch.log("info", box[3])
    patch.record("left", box[0])
    patch.at(ms + 50, box, "ring")
    result = patch.render(ms / 1000 + 0.1)
    return result["left"], numpy.array(next(atoms[1:] for _, atoms in result.logs["info"] if atoms[0] == "ring"))


def test_a_render_waits_for_the_first_table_and_for_changes_and_repeats():
    one, other = "hit 40 30 0 1", "hit -60 20 0 1"
    first, level = strikes(one)
    assert level.max() > -60
    for messages in ((one,), ("size 2", "listener 1 30 0 400", one), ("load tube", one)):
        sound = strikes(*messages, ms=50)[0]
        assert sound.any()
        for sync in (0, 1, 2):
            assert (strikes(*messages, ms=50, sync=sync)[0] == sound).all()
    assert abs(strikes(one, other)[1] - level).max() > 3  # the second is heard, too
    assert strikes(one, other, "reset")[1].max() <= -119
    assert (strikes("point 40 30 0", "reset", "hit 1")[0] == first).all()  # a reset leaves the point where it is


def test_of_a_table_that_cannot_be_read_only_that_is_said(tmp_path):
    (tmp_path / "bad.modal.npz").write_bytes(b"no table")
    patch = Patch()
    patch.at(1, patch.obj("modal_impact~", "bad"), "hit 0.1")
    errors = ["load bad: .*", "no body is loaded: send load NAME first"]
    assert len(patch.render(0.1, path=[tmp_path], expect_errors=errors).errors) == 2


@pytest.mark.parametrize("messages, name", [
    (["hit 40 30 0 1", "rub 40 30 2.5 1 0 0"], "rub"), (["normal 1 0 0", "hit 40 30 0 1", "hit 160 0 0 1"], "hit")])
def test_a_plate_that_moves_along_its_normal_alone_says_so_once(messages, name):
    patch = Patch()
    box = patch.obj("modal_impact~", "plate")
    for message in messages:
        patch.at(1, box, message)
    output = patch.render(0.05).output
    assert output.count(f"{name}: no mode of this table moves the surface along this direction") == output.count("no mode") == 1


def soft_clip(x):
    size = numpy.maximum(abs(x), 0.5)
    return numpy.where(abs(x) <= 0.5, x, numpy.sign(x) * (1 - 0.25 / size))


def struck(name, hits, *flags):
    """Both sides of the body under `hits`, messages 100 ms apart, from rest each."""
    patch = Patch()
    box = patch.obj("modal_impact~", name, "-sync", 1, *flags)
    for i, hit in enumerate(hits):
        patch.at(100 * i + 1, box, "reset")
        patch.at(100 * i + 30, box, hit)
    for side in (0, 1):
        patch.record(str(side), box[side])
    result = patch.render(0.1 * len(hits) + 0.05)
    return numpy.stack([result["0"], result["1"]])


@with_bodies
@pytest.mark.parametrize("name", (*BODIES, "disk", "disk_hollow", "disk_solid", "plank"))
def test_no_body_of_the_library_leaves_the_linear_range_at_1_m_per_s_and_all_share_one_gain(name):
    table = numpy.load(stage_folder() / f"{name}.modal.npz")
    # Where some mode moves most, where all together do, and anywhere.
    motion = (table["phi"].astype(float) ** 2).sum(2)
    spots = [*motion.argmax(1)[:12], (motion / motion.max(1, keepdims=True)).sum(0).argmax(),
             *numpy.random.default_rng(1).integers(0, len(table["xyz"]), 27)]
    hits = ["hit 1", *(f"hitv {v} 1" for v in spots)]
    ours, pascal = struck(name, hits), struck(name, hits, "-gain", 1)
    assert 0.005 < abs(ours).max() < 0.5  # heard, and not bent by the soft limit
    assert abs(100 * ours - pascal).max() < 1e-5 * abs(pascal).max()


def test_the_soft_limit_keeps_listening_levels_within_1_and_measuring_levels_exact():
    hits = ["hit 0 0 2.5 1", "hit 40 30 2.5 8", "hit 80 50 2.5 50"]
    pascal = struck("plate", hits, "-gain", 1)
    assert abs(pascal).max() > 300
    for flags, expected in [((), soft_clip(0.01 * pascal)), (("-gain", 0.05), soft_clip(0.05 * pascal)),
                            (("-gain", 0.1), 0.1 * pascal), (("-gain", 0.05, "-limit", "off"), 0.05 * pascal),
                            (("-gain", 1, "-limit", "on"), soft_clip(pascal))]:
        assert struck("plate", hits, *flags) == pytest.approx(expected, abs=1e-4 * abs(expected).max()), flags


WINDS = {"clarinet": (60, 2500), "sax": (60, 3000), "oboe": (70, 5000), "trumpet": (60, 3000), "trombone": (50, 4000),
         "voice": (0, 900), "syrinx": (0, 900)}  # key, Pa: below the soft limit, which makes a mean of its own
PARTICLES = "maraca sekere cabasa tambourine gravel ice coins rain sand leaves bubbles".split()
GROUNDS = ("wood creak underbrush snow frozensnow sand gravel metal highgrass dryleaves concrete dirt puddle water "
           "carpet").split()


def test_no_sound_and_no_drive_of_any_preset_has_a_mean():
    """A source's pressure is the rate of its volume flow, which begins and ends at rest. Below -60 dB of the rms."""
    patch, seconds = Patch(), 10
    names = []

    def record(name, outlet):
        names.append(name)
        patch.record(name, outlet)

    def steady(value):
        return patch.signal(numpy.full(seconds * 48000, float(value)))

    for preset in PARTICLES:
        box = patch.obj("particle~", preset)
        steady(2) >> box[0]
        record(f"particle~ {preset}", box[0])
    for ground in GROUNDS:
        box = patch.obj("footstep~", ground)
        patch.at(10, box, "walk 1")
        for i, name in enumerate(("sound", "heel", "ball")):
            record(f"footstep~ {ground} {name}", box[i])
    for preset, (key, pressure) in WINDS.items():
        box = patch.obj("greed~", "-preset", preset, "-tune", int(key > 0))
        steady(pressure) >> box[0]
        steady(440 * 2 ** ((key - 69) / 12) if key else 0) >> box[2]
        record(f"greed~ {preset}", box[0])
    strikes = [("contact_impact~", "strike 1")]
    strikes += [(f"modal_impact~ {path.name.split('.')[0]}", "hit 1") for path in stage_folder().glob("*.modal.npz")]
    for name, strike in strikes:
        box = patch.obj(*name.split())
        for i in range(20):
            patch.at(20 + 450 * i, box, strike)
        record(name, box[0])
    box = patch.obj("contact_friction~")
    steady(.1) >> box[0]
    steady(1) >> box[1]
    record("contact_friction~", box[0])
    result = patch.render(seconds, timeout=300)
    level = {name: 20 * numpy.log10(abs(x.mean()) / numpy.sqrt((x ** 2).mean()))
             for name, x in ((name, result[name].astype(float)) for name in names)}
    assert max(level.values()) < -60, sorted(level.items(), key=lambda pair: -pair[1])[:5]
