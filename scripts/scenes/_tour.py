"""The bodies of ./play bodies, their strikers, and a piece for them."""
import gzip
import pathlib
import subprocess
import tempfile

import _bodies
import numpy
from _bodies import RATE
from harness import stage_folder

SHAPES = pathlib.Path(__file__).resolve().parents[2] / "data" / "bodies"
LEVER = ("gmsh-doc", "usr/share/doc/gmsh-doc/converters/stl_to_cartesian/lever.stl.gz")
LISTENERS = ("listener 1 -90 60 350", "listener 2 90 60 350")  # ears, mm
# The air around each mode. With 450 triangles the directivity is inexact above about 4 kHz.
AIR = ("--radiation", "body", "--acoustic-triangles", 450)
STRIKERS = {"steel ball": _bodies.ball(),
            "wooden ball": _bodies.ball(0.012, 1.1e10, 0.3, 700),
            "rubber ball": _bodies.ball(0.016, 2e7, 0.48, 1100),
            "hard rubber ball": _bodies.ball(0.012, 2e8, 0.48, 1200)}
# name: (modal_fem's words, striker, speed in m/s, points). A point is -1 to 1 along each axis of the box around the
# body; the vertex nearest to it is struck. Disks, ring and lever have all audible modes. Edges are as long as possible
# while the modes stay within 0.2 % of a finer mesh, the lever's within 1 %.
BODIES = {
    "brass bowl": (("bowl", "--diameter", 160, "--thickness", 3, "--angle", 80, "--material", "brass",
                    "--h", 12), "rubber ball", 1.5, ((1, 0, 1), (0.6, 0.4, -0.3), (0, 0, -1))),
    "drinking glass": (("bell", "--profile", SHAPES / "tumbler.txt", "--material", "glass", "--h", 8),
                       "wooden ball", 0.4, ((1, 0, 1), (0.95, 0, 0), (0, 0, -1))),
    "bronze bell": (("bell", "--profile", SHAPES / "handbell.txt", "--material", "bronze", "--h", 8),
                    "steel ball", 1.0, ((1, 0, -0.95), (0.7, 0, 0), (0.3, 0, 1))),
    "rosewood bar": (("bar", "--length", 320, "--width", 45, "--thickness", 20, "--material",
                      "rosewood", "--h", 10), "hard rubber ball", 1.5, ((0, 0, 1), (0.55, 0, 1), (1, 0, 1))),
    "spruce board": (("board", "--length", 300, "--width", 200, "--thickness", 4, "--h", 15),
                     "rubber ball", 1.5, ((0.1, 0.1, 1), (0.9, 0.9, 1), (0.5, 0, 1))),
    "steel tube": (("tube", "--outer-diameter", 25, "--inner-diameter", 21, "--length", 400,
                    "--material", "steel", "--h", 16), "hard rubber ball", 1.5,
                   ((1, 0, 0), (1, 0, 0.55), (1, 0, 1))),
    "steel ring": (("ring", "--outer-diameter", 130, "--inner-diameter", 104, "--thickness", 13,
                    "--material", "steel", "--h", 8, "--modes", 25), "steel ball", 0.7, ((0.9, 0, 1), (1, 0, 0), (0.64, 0.64, 1))),
    "hollow steel ball": (("hollow_sphere", "--diameter", 110, "--thickness", 3, "--material", "steel",
                           "--h", 12), "steel ball", 0.7, ((0, 0, 1), (0.7, 0, 0.7), (0, 1, 0))),
    "solid disk": (("disk", "--diameter", 100, "--thickness", 25, "--material", "aluminium",
                    "--h", 12, "--modes", 4), "steel ball", 1.4, ((0.5, 0, 1), (0, 0, 1), (0.9, 0, 1))),
    "hollow disk": (("hollow_disk", "--diameter", 100, "--thickness", 25, "--cavity-diameter", 80,
                     "--cavity-thickness", 13, "--material", "aluminium", "--h", 12, "--modes", 13),
                    "steel ball", 1.4, ((0.5, 0, 1), (0, 0, 1), (0.9, 0, 1))),
    "steel lever (STL)": (("LEVER", "--material", "steel", "--tolerance", 5, "--modes", 24), "steel ball", 1.0,
                          ((1, 0, 0), (-1, 0.5, 0), (0, 0, 1))),
}
TIMES = (0.05, 1.0, 1.95)  # s, times of a body's three strikes
SECONDS = 4.0


def lever():
    """The path of a machine part's surface, 5000 triangles, from Debian's gmsh-doc; fetched from that package if the
    system leaves out /usr/share/doc."""
    folder = stage_folder().parent / "bodies"
    folder.mkdir(exist_ok=True)
    model = folder / "lever.stl"
    if not model.is_file():
        package, name = LEVER
        packed = pathlib.Path("/") / name
        with tempfile.TemporaryDirectory(prefix="tactus-") as temporary:
            if not packed.is_file():
                subprocess.run(["apt-get", "download", "-q", package], cwd=temporary, check=True,
                               capture_output=True)
                archive = next(pathlib.Path(temporary).glob("*.deb"))
                subprocess.run(["dpkg", "-x", archive, temporary], check=True)
                packed = pathlib.Path(temporary) / name
            model.write_bytes(gzip.decompress(packed.read_bytes()))
    return model


def table(name):
    words = BODIES[name][0]
    return _bodies.table(*(lever() if w == "LEVER" else w for w in words), *AIR, sheet=True)


def vertices(path, points):
    """The vertex nearest to each point; -1 to 1 spans the body's box."""
    xyz = numpy.load(path)["xyz"].astype(float)
    low, high = xyz.min(0), xyz.max(0)
    return [int(((xyz - ((low + high) / 2 + numpy.array(p) * (high - low) / 2)) ** 2).sum(1).argmin())
            for p in points]


def ring(name, strikes, seconds):
    """Stereo sound in Pa of one body under strikes [(s, index of the point, share of its speed)]."""
    _, striker, speed, points = BODIES[name]
    path = table(name)
    struck = vertices(path, points)
    render = _bodies.strike(path, [(t, f"hitv {struck[point]} {speed * part:.5g}")
                                   for t, point, part in strikes],
                            seconds, [STRIKERS[striker], "radiation body", *LISTENERS], gain=1)
    return numpy.stack([render["left"], render["right"]], axis=1)


def visit(name):
    """The three points of a body, one after the other."""
    return ring(name, [(t, i, 1.0) for i, t in enumerate(TIMES)], SECONDS)


# A piece of eight bars. Sixteenths of a bar: "1" to "3" names the point, "." is a rest; an accent on each quarter.
STEP_S = 0.15
PIECE = {
    "spruce board":      ("................", "................", "1.....1...2.....", "1.....1...2...1.") ,
    "brass bowl":        ("1...............", "........2.......", "1...............", "1.......2......."),
    "rosewood bar":      ("................", "1..1..1...1..1..", "1..2..1...1..2..", "1..2..1.3.1..2.3"),
    "steel tube":        ("................", "..1.....2.......", "..1.....2.....3.", "..1...2...1...2."),
    "bronze bell":       ("................", "................", "............1...", "1...........1..."),
    "drinking glass":    ("....1.......2...", "....1.......2...", "....1.......2...", "....1...1...2..."),
    "steel lever (STL)": ("................", "................", "1...2...1...2.2.", "1.1.2...1.1.2.2."),
    "hollow disk":       ("................", "..........1...1.", "..1...1...1...1.", "..1...1...1...11"),
    "solid disk":        ("................", "......1.........", "....1.......1...", "....1..1....1..1"),
}
LEVEL = {"spruce board": 0.8, "brass bowl": 1.0, "rosewood bar": 0.9, "steel tube": 0.5,
         "bronze bell": 0.5, "drinking glass": 0.35, "steel lever (STL)": 0.35, "hollow disk": 0.2,
         "solid disk": 0.2}
ORDER = (0, 1, 1, 2, 2, 3, 3, 0)


def perform():
    """{body: stereo} of the piece, each scaled to a peak of 1, times its level in the mix."""
    generator = numpy.random.default_rng(1)
    seconds = len(ORDER) * 16 * STEP_S + 4
    parts = {}
    for name, bars in PIECE.items():
        strikes = []
        for bar, which in enumerate(ORDER):
            for step, sign in enumerate(bars[which]):
                if sign != ".":
                    when = 0.05 + (16 * bar + step) * STEP_S + 0.004 * generator.random()
                    force = (1.0 if step % 4 == 0 else 0.7) * (0.85 + 0.3 * generator.random())
                    strikes.append((when, int(sign) - 1, force))
        sound = ring(name, strikes, seconds)
        parts[name] = LEVEL[name] * sound / abs(sound).max()
    return parts


def in_numbers(name, sound):
    body = numpy.load(table(name))
    found = _bodies.peaks(sound[int(TIMES[0] * RATE):int(TIMES[1] * RATE)].sum(1), low_hz=40, count=3)
    f, metal = body["freq"], numpy.pi * body["freq"] * body["eta"]
    t60 = 3 * numpy.log(10) / numpy.array([metal[0], metal[0] + body["alpha_rad"][0]])
    return [name, f"{float(body['mass']):.3g}", f"{f[0]:.1f}", f"{t60[0]:.2g}", f"{t60[1]:.2g}", BODIES[name][1],
            ", ".join(f"{hz:.0f}" for hz, _ in found), f"{abs(sound).max():.2g}"]
