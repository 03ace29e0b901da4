"""The contents of ./play: the scenes, their order, and the declarations in their first lines."""
import pathlib
import re

SCENES = pathlib.Path(__file__).resolve().parent / "scenes"

# The page's sections. Scenes in no section come last, so that a new one needs no line here.
SECTIONS = (
    ("Blown", ("fanfare", "reed", "greed", "finger", "map")),
    ("Struck and rubbed", ("bodies", "rubbing", "board", "disk", "disk-hollow")),
    ("Walked and shaken", ("walking", "particles", "footsteps", "walk-on-plate")),
    ("Touched", ("audiohaptics", "spring", "strike", "design")),
    ("Studied", ("reed-study",)),
)
# Sounds at the top of the page: (scene, sound, description).
HIGHLIGHTS = (
    ("fanfare", "fanfare", "Four players of lip reeds: two trumpets and two trombones"),
    ("walking", "tour", "One walker in one take: gravel, wood, concrete; turns, runs, jumps, sneaks, climbs"),
    ("bodies", "piece", "A piece for nine bodies that were never built: bowl, glass, bell, wood, tube, metal"),
    ("reed", "adagio_room", "The clarinet of Mozart's Adagio, played by a simulated hand on a haptic device"),
    ("fanfare", "dawn", "A thrush, a warbler and a dove: [greed~] with the swinging valve of a syrinx"),
    ("rubbing", "glass", "A wet finger rubs the rim of a glass"),
    ("particles", "piece", "Maraca, cabasa, tambourine and coins over rain and bubbles"),
    ("audiohaptics", "taps_chair", "A hand taps a disk, feels it push back, and hears it"),
)
# The order of the work. The scenes at the top of the page that need few build targets come first. Long scenes come
# before short ones of their kind, so that no processor is idle at the end.
WORK = ("fanfare", "walking", "particles", "bodies", "reed", "rubbing", "audiohaptics", "footsteps", "design",
        "walk-on-plate", "map", "greed", "finger", "board", "spring", "strike", "disk", "disk-hollow", "reed-study")


def file(name):
    return SCENES / f"{name.replace('-', '_')}.py"


def names():
    """Every scene, in the page's order."""
    found = {path.stem.replace("_", "-") for path in SCENES.glob("[a-z]*.py")}
    listed = [name for _, section in SECTIONS for name in section if name in found]
    return listed + sorted(found - set(listed))


def work_order(wanted):
    return sorted(wanted, key=lambda name: WORK.index(name) if name in WORK else len(WORK))


def declared(name, word):
    """The value of a line WORD = "..." of a scene, "" if there is none."""
    found = re.search(rf'^{word} = "(.*)"$', file(name).read_text(), re.MULTILINE)
    return found.group(1) if found else ""


def needs(name):
    """Build targets that a scene needs: externals by their names in Pd, and other targets."""
    return declared(name, "NEEDS").split()


def is_long(name):
    """Whether only ./play --all makes the scene."""
    return bool(re.search(r"^LONG = True$", file(name).read_text(), re.MULTILINE))


def title(name):
    return file(name).read_text().split('"""')[1].partition("\n")[0]
