"""A [phantom] with its simulated device in a headless Pd, told messages at given times."""
import dataclasses
import math

from harness import Patch, Render, read_trace


@dataclasses.dataclass
class Answer:
    result: Render
    folder: object
    end: float  # ms; Pd goes on a little longer

    @property
    def info(self):
        return [atoms for ms, atoms in self.result.logs["info"] if ms <= self.end]

    @property
    def errors(self):
        return self.result.errors

    def told(self, *words):
        """What follows these words in each line of the info outlet."""
        return [atoms[len(words):] for atoms in self.info if atoms[:len(words)] == list(words)]

    @property
    def force(self):
        return self.told("force")[-1]

    @property
    def trace(self):
        return read_trace(self.folder / "ticks.csv")

    @property
    def positions(self):
        x, y, z = (self.result.logs[axis] for axis in "xyz")
        return [(a[0], b[0], c[0]) for (_, a), (_, b), (_, c) in zip(x, y, z, strict=True)]


def play(folder, messages, arguments="", ms=None, block=64, traced=False, draw=None, errors=()):
    """(ms, message[, inlet]) to the left inlet, or another, of [phantom ARGUMENTS]; ends 20 ms after the last. `traced`
    writes each tick into folder/ticks.csv. draw(patch, box) draws more."""
    end = ms or messages[-1][0] + 20
    patch = Patch(block=block)
    box = patch.obj("phantom", *arguments.split())
    if draw:
        draw(patch, box)
    if traced:
        patch.at(0, box, f"trace {folder}/ticks.csv")
        patch.at(math.ceil(end) - 1, box, "trace stop")
    for time, message, *inlet in messages:
        patch.at(time, box[inlet[0]] if inlet else box, message)
    for outlet, name in enumerate(("x", "y", "z", "info")):
        patch.log(name, box[outlet])
    return Answer(patch.render(end / 1000, keep=folder, expect_errors=errors), folder, end)


def still(folder, at, *messages, arguments="", errors=(), ms=250):
    """The answer of a rigid hand that rests at "x y z" mm, asked at the end, after those messages."""
    told = [(2 + n, message) for n, message in enumerate(messages)]
    return play(folder, [*told, (ms - 10, "bang")], f"-hand rigid -path line {at} {at} 1000 {arguments}", ms,
                errors=errors)


def moved(folder, rows, *messages, arguments="-hand rigid"):
    """The same of a hand that follows rows of ms x y z, traced."""
    (folder / "hand.txt").write_text("\n".join(" ".join(map(str, row)) for row in rows) + "\n")
    return play(folder, [*((0, message) for message in messages), (rows[-1][0], "bang")],
                f"-path hand.txt {arguments}", rows[-1][0] + 20, traced=True)
