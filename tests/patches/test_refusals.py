"""Messages that an object refuses: each costs one sentence that names the value, and changes nothing. Ranges of
parameters, counts of arguments and unknown words are tested for every object by its declaration (tests/pd)."""
import json
import os
import pathlib

import pytest

from harness import Patch, stage_folder

BUILD = pathlib.Path(os.environ.get("TACTUS_BUILD", stage_folder().parent))
DECLARED = {d["name"]: d for d in json.loads((BUILD / "declarations.json").read_text())}

# By box: what it is told first, then rows of `message => how the sentence begins`, or the sentence alone where it begins
# with the message.
REFUSED = {
    "footstep~": ("", """
        step middle: expected left or right
        scuff middle: expected left or right
        calibrate toe 1 2: expected heel or ball
        calibrate heel 0 0 1 1: expected 5 to 32 ascending pairs
        equalise 100: expected up to 16 pairs
        turn 0: expected 1..180 degrees
        turn round: expected 1..180 degrees
        jump 2: expected a height in 0.01..1 m
        jump left: expected a height in 0.01..1 m
        drag left 0 1: expected left or right, then 0.01..20 m and 0.02..5 m/s
        drag 1 9: expected left or right, then 0.01..20 m and 0.02..5 m/s
        drag 1 1 left: expected left or right, then 0.01..20 m and 0.02..5 m/s
        surface wood sand 2: expected a mix in 0..1
        surface 3: expected one or two names
        surface left: expected one or two names
        surface wood sand 0 1: expected one or two names
        surface nowhere: file not found beside the patch or in the search path; or use carpet concrete"""),
    "particle~ ice": ("", """
        preset moon: expected maraca
        preset 3: expected maraca
        shake -1: expected an energy in 0..1000
        shake much: expected an energy in 0..1000
        modes 100 1 => modes: 2 numbers: expected three for each mode, a frequency in 20..20000 Hz
        modes 100 1 1 5 1 1 => modes: frequency 5 Hz of mode 2: expected 20..20000
        modes 100 0 1 => modes: time 0 s of mode 1: expected 0.001..60
        modes 100 1 tin => modes: gain tin of mode 1: expected 0..100"""),
    "contact_impact~": ("", f"""
        strike 2000: expected a velocity in -1000..1000 m/s
        strike hard: expected a velocity
        drop -1: expected a height in 0..100000 mm
        pickup 1 loud: expected gains in -100..100
        modes 412 6 => modes: 2 numbers: expected three for each mode, a frequency in 1..20000 Hz, a time in 0.001..1000 s
        modes 412 6 1 825 0 1 => modes: time 0 s of mode 2: expected 0.001..1000
        modes 412 6 1 825 2 1000 => modes: gain 1000 of mode 2: expected -100..100
        modes 412 6 1 high 2 1 => modes: frequency high Hz of mode 2: expected 1..20000
        pickup {"1 " * 60}1000 => pickup 1 1 1 1 1 1 1 1 ...: expected gains
        pickup {"w" * 200} => pickup {"w" * 120}...: expected gains"""),
    "contact_friction~": ("", "bang => no message 'bang'; there are modes, pickup and reset"),
    "greed~ clarinet": ("os 2", """
        preset kazoo: expected clarinet
        os 3: expected 0, 1, 2 or 4
        gian 2 => no message 'gian'; did you mean 'gain'
        embuchrue 1 => no message 'embuchrue'; did you mean 'embouchure'
        note 60 => no message 'note'; 'get' lists the parameters"""),  # two letters from bore
    "greed_gradient~ trumpet": ("os 2", """
        range 5 5 80 900: expected p_lo < p_hi
        preset kazoo: expected clarinet
        os 2.5: expected 0, 1, 2 or 4"""),
    "phantom sim -hand rigid": ("", """
        backend sim 3 => backend sim: expected no arguments
        hand soft: expected free, rigid, spring or person
        hand spring 1 => hand spring: 1 number: expected none, or K (N/m) and B (N s/m)
        hand spring -1 2 => hand: K -1 N/m: expected 0..20000 N/m
        hand rigid 3 => hand rigid: 1 number: expected none
        path nix.txt: file not found beside the patch or in the search path; or use line, circle, lissajous or array
        path line 1 2 => path line: z1 needs a value: expected -10000..10000 mm
        path array a b c => path array: no array named a
        path circle 0 0 0 10 1000 xw => path circle: plane xw: expected xy, yz or xz
        target 1 2 99999 => target: z 99999 mm: expected -10000..10000 mm
        watchdog 0 1 => watchdog: hold 0 ms: expected 1..10000 ms
        map xxy: expected the letters x, y and z in any order, then three signs 1 or -1
        map xyz 1 2 1: expected the letters x, y and z in any order, then three signs 1 or -1
        interp 2000: expected auto, off or 0.25..1000 ms
        workspace 5 0 0 1 1 1: expected xmin ymin zmin xmax ymax zmax in mm, no minimum above its maximum
        workspace 1 2: expected device, learn 0|1 or xmin ymin zmin xmax ymax zmax in mm
        report x 1 => report x: expected mm, vel, force, button, status, jitter, error, hit, contact, release, rot, torque or
        list 1 2 => list: expected 3 arguments (fx fy fz), got 2
        list 1 two 3 => list two: expected three numbers, fx fy fz
        open falcon: expected nothing or 0, the only simulated device; choose another driver with backend
        button 40 1 => button: number 40: expected 0..31
        clock sundial: expected auto, logical or wall
        stats now: expected reset
        trace /nowhere/x.csv: cannot be written: No such file or directory
        firmware f.bin => firmware: only for a real device; first choose one with backend evdev, falcon, dhd, haply
        sedd 3 => no message 'sedd'; did you mean 'seed'?
        scene paint 1 => scene paint: expected add, mat, move, del, tool, k or load
        scene add 1 => scene add: expected a name and a shape
        scene add 1 cube 1 1 1 => scene add: cube: expected plane, sphere, box, disk or mesh
        scene add 1 sphere 0 0 0 => scene add: sphere: radius needs a value: expected 0.01..10000 mm
        scene add 1 sphere 0 0 0 -3 => scene add: sphere: radius -3 mm: expected 0.01..10000 mm
        scene add 1 plane 0 0 0 1 => scene add: plane: the normal nx ny nz is zero
        scene add 1 mesh nix.obj => scene add: mesh: nix.obj: file not found
        scene add b box 0 0 0 1 1 1 0 0 0 0 => scene add: box: the quaternion qw qx qy qz is 0 0 0 0: expected a rotation
        scene mat 3 500 => scene mat: 3: no such body
        scene move 3 0 0 0 => scene move: 3: no such body
        scene del 3 => scene del: 3: no such body
        scene tool -1 => scene tool: radius -1 mm: expected 0..50 mm
        scene tool wide => scene tool: radius wide: expected 0..50 mm
        scene tool 0.001 => scene tool: radius 0.001 mm: expected 0 (a point) or 0.01..50 mm
        scene k -1 => scene k: k -1 N/m: expected 0..100000 N/m
        scene load nix.txt => scene load: nix.txt: file not found
        effect glue 1 => effect glue: expected constant, spring, viscous, inertia, friction, texture, relief or off
        effect spring 100 => effect spring: x needs a value: expected -10000..10000 mm
        effect spring -1 0 0 0 => effect spring: k -1 N/m: expected 0..5000 N/m
        effect spring soft 0 0 0 => effect spring: k soft: expected 0..5000 N/m
        effect viscous 1e9 => effect viscous: b 1e+09 N s/m: expected 0..50 N s/m
        effect viscous 1 2 => effect viscous: expected at most 1 number
        effect inertia 0 => effect inertia: mass 0 kg: expected 0.001..20 kg
        effect texture 1 2 0 0 0 => effect texture: direction 0 0 0: expected a nonzero vector
        effect texture 1 2 1 => effect texture: expected amplitude and wavelength
        effect relief 1 2 => effect relief: depth 1 mm: expected at most a quarter of the wavelength, 0.5 mm"""),
    "phantom": ("network string s 19 -50 0 0 50 0 0 0.001 10 0.0005", """
        network: expected
        network fly: expected mass, anchor
        network mass m => network mass: mass needs a value: expected 1e-07..10 kg
        network mass m -1 0 0 0 => network mass: mass -1 kg: expected 1e-07..10 kg
        network mass m 1 0 0 2000 => network mass: z 2000 mm: expected -1000..1000 mm
        network anchor q => network anchor: q: no such mass
        network link s-1 q 3 => network link: q: no such mass
        network link s-1 s-1 3 => network link: s-1: expected two different masses
        network link s-1 s-2 3 0 0 twist => network link: twist: expected pull or push
        network link s-1 s-2 1e9 => network link: k 1e+09 N/m: expected 0..1000000 N/m
        network string t 0 0 0 0 1 1 1 => network string: n 0: expected 1..200
        network string t 5 0 0 0 0 0 0 => network string: the ends are 0 mm apart
        network string t 5 0 0 0 50 0 0 0.001 10 0 100 => network string: stiffness 100 N/m: expected 0 or at
        network string t 190 0 0 0 50 0 0 => network string: 209 movable masses: expected at most 200
        network membrane t 5 5 0 0 0 50 50 50 => network membrane: expected two corners
        network membrane t 20 20 0 0 0 50 50 0 => network membrane: 400 masses: expected at most 200
        network load nowhere.txt => network load: nowhere.txt: file not found
        network del q => network del: q: no such mass, string or membrane
        network listen s-3 w => network listen: axis w: expected x, y or z
        network listen s-3 z 3 => network listen: outlet 3: expected 1..2
        network listen s-3 z colour => network listen: quantity colour: expected velocity, displacement or force
        network pluck s-0 0 0 1 1 => network pluck: s-0: an anchor does not move
        network pluck s-3 0 0 1 => network pluck: expected a mass, fx fy fz in N and ms
        network pluck s-3 0 0 1000 1 => network pluck: fz 1000 N: expected -100..100 N
        network grab q => network grab: q: no such mass
        network rate 1 => network rate: rate 1 Hz: expected 1000..200000 Hz
        network drag -1 => network drag: drag -1 1/s: expected 0..10000 1/s"""),
    "phantom haply": ("", """
        driver rate 9: haply: rate 9: expected 50..4000 Hz
        driver rat 90: haply: setting rat: expected device INDEX or ID"""),
    "phantom net": ("", """
        driver rat 90: net: setting rat: expected host HOST PORT
        driver device 5: net: device 5: expected 0, HOST or HOST:PORT
        driver host here y: net: port y: expected 1..65535"""),
    "modal_impact~ plate -sync 1": ("", """
        hit 30 40 0 -1 => hit: v -1 m/s: expected 1e-06..50
        hit 30 40 0 nan: expected numbers
        hit 1 2 => hit: expected v, or x y z v
        hitv 99999 1 => hitv: vertex 99999: expected 0..
        hitf 0 0.7 0.7 1 => hitf: v 0.7: expected 0..0.3
        load nowhere.npz: file not found
        preset jelly: expected aluminium
        listener 5 0 0 0 => listener: i 5: expected 1..4
        losscurve 100 0.1 50 0.1 => losscurve: f 50
        striker 0 0 0 0 => striker: mass 0 kg
        drop 1 2 => drop: expected h, or x y z h
        drop -5 => drop: h -5 mm: expected
        drop 0 0 0 high: expected numbers
        rub 1 2 3 4 => rub: expected x y z, x y z dx dy dz, or nothing
        damping loss 3 => loss: eta 3: expected 0..2
        damping loss 1 2: expected table | rayleigh a b | loss eta
        rub 0 0 2.5 0 0 0 => rub: direction 0 0 0: expected one along the surface
        rub 0 0 2.5 0 0 1 => rub: direction 0 0 1: expected one along the surface, whose normal is 0 0 1
        friction 11 => friction: static 11: expected 0.001..10
        friction 1 1 1 2 => friction: breakaway 2: expected 0.01..0.99
        friction a: expected numbers
        board nowhere.npz: file not found
        board 3: expected the name of a file
        board plate 1 2: expected the name of a file
        listener 1 2 3 4 5 => listener: expected i x y z, or
        rest 1 2 => rest: 2 numbers: expected x y z for each point
        shape 1 => shape: 1 numbers: expected
        cp 99 0 0 0 => cp: control point 99: expected 0..
        cp 0.5 0 0 0 => cp: control point 0.5: expected 0.."""),
    "stress_haptic beam": ("", """
        load /etc/passwd: not an .npz file
        load 5: expected the name of a file
        load missing.stress.npz: file not found
        cp 99 0 0 0 => cp: control point 99: expected 0..
        cp 0.5 0 0 0 => cp: control point 0.5: expected 0..
        cp 0 left 0 0 => cp: 'left': expected numbers
        cp 0 1e30 0 0 => cp: '1e+30': expected numbers in
        list 1 2 => list: 2 numbers: expected
        list a b c => list: 'a': expected numbers
        grab 77 => grab: control point 77: expected 0..
        grab 0 5 => grab: 5: expected 1 to grab the control point or 0
        range wide: expected current, initial, or fixed a b
        range fixed 2 1: expected current, initial, or fixed a b
        range initial 3: expected
        gains 1 -2 0 0 => gains: -2: expected kmin kmax bmin bmax
        anchor up: expected here, or x y z
        anchor a b c => anchor: 'a': expected numbers
        solver 5: expected the path of part_stress
        solver /etc/passwd: no executable file found
        draw 3: expected nothing or all"""),
    "playability_map trumpet": ("", """
        read nowhere.txt: file not found
        draw: no map is computed"""),
}


def rows_of(text):
    for line in filter(None, map(str.strip, text.splitlines())):
        message, arrow, sentence = line.partition(" => ")
        yield (message, sentence) if arrow else (line.partition(": ")[0], line)


@pytest.mark.parametrize("box", REFUSED)
def test_a_refused_message_is_one_sentence_and_changes_nothing(box):
    setup, text = REFUSED[box]
    name, rows = box.split()[0], list(rows_of(text))
    outlets = [outlet["name"] for outlet in DECLARED[name]["outlets"]]
    patch = Patch()
    made = patch.obj(*box.split())
    patch.log("info", made[outlets.index("info") if "info" in outlets else len(outlets)])
    if setup:
        patch.at(1, made, setup)
    for i, (message, _) in enumerate(rows):
        patch.at(100 + 5 * i, made, message)
    end = 100 + 5 * len(rows)
    for ms in (50, end):
        patch.at(ms, made, "dump")
    result = patch.render(end / 1000 + 0.02, expect_errors=[f"{name}: "])
    said = [line.partition(f"{name}: ")[2] for line in result.errors]
    for sentence, (message, expected) in zip(said, rows):
        assert sentence.startswith(expected), message
    assert len(said) == len(rows), said
    before, after = ([atoms for ms, atoms in result.logs["info"] if start <= ms < start + 1 and atoms[0] != "ms"]
                     for start in (50, end))  # ms: a measured time
    assert before == after and (before or name == "contact_friction~")


@pytest.mark.parametrize("box, message", [
    ("phantom sim", "path"), ("phantom sim", "scene add m mesh"), ("phantom sim", "scene load"),
    ("modal_impact~", "load"), ("footstep~", "surface"), ("stress_haptic", "load"), ("playability_map", "read"),
    ("ioa_link", "token"), ("haptic_server", "token")])
def test_a_fifo_is_refused_and_not_waited_for(box, message, tmp_path):
    os.mkfifo(tmp_path / "fifo")
    patch = Patch()
    patch.at(10, patch.obj(*box.split()), f"{message} {tmp_path / 'fifo'}")
    assert patch.render(0.1, expect_errors=[box.split()[0]]).errors


def test_a_fifo_in_a_folder_of_pds_path_gives_way_to_a_file_in_a_later_one(tmp_path):
    for folder in ("first", "second"):
        (tmp_path / folder).mkdir()
    os.mkfifo(tmp_path / "first" / "hand.txt")
    (tmp_path / "second" / "hand.txt").write_text("0 1 2 3\n")
    patch = Patch()
    device = patch.obj("phantom", "sim")
    patch.at(10, device, "path hand.txt")
    patch.at(20, device, "path nowhere.txt")
    assert len(patch.render(0.1, path=[tmp_path / "first", tmp_path / "second"], expect_errors=["nowhere.txt"]).errors) == 1


def test_a_name_with_a_tilde_is_in_the_users_home(tmp_path):
    (tmp_path / "hand.txt").write_text("0 1 2 3\n")
    patch = Patch()
    patch.at(10, patch.obj("phantom", "sim"), "path ~/hand.txt")
    patch.at(10, patch.obj("playability_map"), "write ~/maps.txt")
    patch.render(0.1, environment={"HOME": str(tmp_path)})
    assert (tmp_path / "maps.txt").is_file()


def test_a_path_longer_than_memory_is_refused_by_its_size(tmp_path):
    with open(tmp_path / "long.txt", "w") as sparse:
        sparse.truncate(1 << 40)
    patch = Patch()
    patch.at(10, patch.obj("phantom", "sim"), f"path {tmp_path / 'long.txt'}")
    assert "1099511627776 bytes: expected at most 268435456" in patch.render(0.1, expect_errors=["phantom"]).errors[0]
