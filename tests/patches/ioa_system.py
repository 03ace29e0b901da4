"""The seven modules of patches/audiohaptics/ioa on one bus, drawn for the tests."""
import numpy

from harness import Patch, stage_folder

SCENE = stage_folder() / "disk_scene.txt"  # the disk: 50 mm radius, 12 mm thick, facing z
NEEDS_DISK = not (stage_folder() / "disk.modal.npz").is_file()
SERVERS = ("ioa_is", "ioa_is_pd")
TOPICS = ("hit", "contact", "release", "excite", "force", "listener", "mark", "button", "grip")


def rows(path, *points):
    """Writes a script of (ms, x, y, z[, buttons]) and returns its path as text."""
    path.write_text("".join(" ".join(f"{c:g}" for c in point) + "\n" for point in points))
    return str(path)


def taps(path, *targets, speed=0.25, start=0.0, high=20.1, deep=3.0):
    """A script that taps straight down at each (x, y), mm, with that speed in m/s."""
    points, ms = [], start
    for x, y in targets:
        down = (high - deep) / speed
        points += [(ms, x, y, high), (ms + down, x, y, deep), (ms + 2 * down, x, y, high)]
        ms += 2 * down + 50
    return rows(path, *points)


BODIES_APART = ("add disk disk 0 0 0 0 0 1 40 12\nadd 7 sphere 90 10 -5 20\n"
                "add box box -90 0 0 30 20 8\n")


def wandering(path, seed, start=0.0):
    """A hand that taps twelve times anywhere over three bodies, some of the times beside them."""
    draw = numpy.random.default_rng(seed)
    points, ms = [(start, 0, 0, 40)], start
    for _ in range(12):
        x, y = draw.uniform((-120, -25), (110, 25))
        speed, deep = draw.uniform(0.1, 0.6), draw.uniform(0, 7)  # mm/ms, mm
        ms += 60
        points.append((ms, x, y, 40))
        ms += (40 - deep) / speed
        points.append((ms, x, y, deep))
        ms += (40 - deep) / speed
        points.append((ms, x, y, 40))
    return rows(path, *points), ms / 1000


class System:
    """One system of modules on the bus `name` in a patch; every module can be exchanged.

    modules: {"sdd": "ioa_sdd_script ...", ...}: the words of each box after the name of the bus come
    behind the module's own name; None leaves it out. Logs are kept under name and topic.
    """

    BOXES = {"sdd": "ioa_sdd_script", "re": "ioa_re", "is": "ioa_is", "cs": "ioa_cs_modal",
             "mm_haptic": "ioa_mm_haptic", "mm_sound": "ioa_mm_sound", "mm_screen": "ioa_mm_screen",
             "r_spring": "ioa_r_spring", "r_modal": "ioa_r_modal", "ddd": "ioa_ddd_phantom"}
    ARGUMENTS = {"re": [1], "cs": ["disk", "disk.modal.npz"], "mm_haptic": [str(SCENE)],
                 "r_modal": ["disk"]}

    def __init__(self, patch, name="lab", **modules):
        self.patch, self.name, self.box = patch, name, {}
        for role, module in self.BOXES.items():
            words = modules.get(role, [module, *self.ARGUMENTS.get(role, [])])
            if words is None:
                continue
            words = [words] if isinstance(words, str) else list(words)
            if len(words) == 1:
                words += self.ARGUMENTS.get(role, [])
            self.box[role] = patch.obj(words[0], name, *words[1:])
        self.bus = patch.obj("ioa_bus", name)
        heard = patch.obj("ioa_bus", name, *TOPICS)
        sort = heard >> patch.obj("route", *TOPICS)
        for i, topic in enumerate(TOPICS):
            patch.log(f"{name}.{topic}", sort[i])
        if "r_modal" in self.box:
            for i, label in enumerate(("left", "right", "contact_force")):
                patch.record(f"{name}.{label}", self.box["r_modal"][i])


def of(result, name, topic):
    """Fields of a topic's messages, in order."""
    return [atoms for _, atoms in result.logs[f"{name}.{topic}"]]


def render(seconds, path, play=True, rate=48000, messages=(), scene=None, **modules):
    """One system fed by a script from 0 ms on; messages: (ms, role, text)."""
    patch = Patch()
    if scene:
        modules.setdefault("mm_haptic", ["ioa_mm_haptic", scene])
    modules.setdefault("sdd", ["ioa_sdd_script", path])
    system = System(patch, **modules)
    if play:
        patch.at(0, system.box["sdd"], "bang")
    for ms, role, text in messages:
        patch.at(ms, system.bus if role == "bus" else system.box[role], text)
    return patch.render(seconds, rate)


def hits(result, name="lab"):
    """[(t, id)] of a system."""
    return [(atoms[0], atoms[1]) for atoms in of(result, name, "hit")]
