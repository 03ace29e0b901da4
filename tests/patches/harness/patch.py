"""Patches drawn from Python."""
import itertools
import math
import pathlib

from . import run

START = "harness-start"  # banged when the sound has been switched on, at logical time 0
END = "harness-end"      # a bang ends the render
INFINITY = "1e39"        # beyond the range of Pd's 32-bit number, so it reads as infinity


class Node:
    """A box of a canvas; node[i] is its outlet or inlet i, node alone the first."""

    def __init__(self, canvas, index, port=0):
        self.canvas, self.index, self.port = canvas, index, port

    def __getitem__(self, port):
        return Node(self.canvas, self.index, port)

    def __rshift__(self, other):
        """a >> b[1] draws a cord from a's first outlet to b's second inlet; returns b for chains."""
        self.canvas.connect(self, other)
        return Node(other.canvas, other.index)


def atom(value):
    """A number or word as a Pd file holds it; every 32-bit float survives."""
    if isinstance(value, str):
        return value
    value = float(value)
    if math.isinf(value):
        return INFINITY if value > 0 else "-" + INFINITY
    return f"{value:.9g}"


def escape(text):
    for symbol in (",", ";"):
        text = text.replace(symbol, f" \\{symbol} ")
    return text.replace("$", "\\$")


class Canvas:
    """Boxes and cords of one window. Boxes are placed left to right in the order they are made,
    which is also the order of the inlets and outlets of a sub-patch."""

    def __init__(self, name, patch):
        self.name, self.patch = name, patch
        self.boxes, self.cords = [], []
        self._start = None

    def _add(self, line):
        self.boxes.append(line)
        return Node(self, len(self.boxes) - 1)

    def _coordinates(self):
        return f"{20 + 30 * len(self.boxes)} {20 + 24 * (len(self.boxes) % 24)}"

    def obj(self, *words):
        """A box: obj("greed~", "-f_r", 2800) or obj("greed~ -f_r 2800")."""
        return self._add(f"#X obj {self._coordinates()} {escape(' '.join(atom(w) for w in words))};")

    def msg(self, text):
        """A message box; commas, semicolons and $1 mean what they mean in Pd."""
        return self._add(f"#X msg {self._coordinates()} {escape(text)};")

    def sub(self, name, block=None):
        """A sub-patch, drawn into the canvas returned; its .node is the box here.
        block, a number or "1024 4 1", adds a [block~]."""
        inner = Canvas(name, self.patch)
        if block is not None:
            inner.obj("block~", *str(block).split())
        inner.node = self._add(inner)
        return inner

    def connect(self, source, target):
        if source.canvas is not self or target.canvas is not self:
            raise ValueError("a cord joins two boxes of one canvas")
        self.cords.append((source.index, source.port, target.index, target.port))

    @property
    def start(self):
        """Bangs at logical time 0, when the sound has just been switched on."""
        if self._start is None:
            receive = self.obj("r", START)
            self._start = self.obj("bang")
            receive >> self._start
        return self._start

    def at(self, ms, target, message):
        """Sends a message (text, a number, or a list of atoms, NaN and infinity included) to a box
        at a logical time; Pd acts on it at the beginning of the audio block of that time."""
        delay = self.obj("delay", ms)
        self.start >> delay
        self._message(delay, message) >> target

    def send(self, ms, receiver, message):
        """The same to a named receiver, such as "pd" or one of a patch being tested."""
        self.at(ms, self.obj("s", receiver), message)

    def end_on(self, source, word):
        """Ends the render when a box sends a message that begins with the word: for what comes from
        another thread, of whose time Pd's logical time says nothing."""
        source >> self.obj("route", word) >> self.obj("t", "b") >> self.obj("s", END)

    def _message(self, trigger, message):
        if isinstance(message, str):
            return trigger >> self.msg(message)
        atoms = list(message) if isinstance(message, (list, tuple)) else [message]
        if not any(isinstance(a, float) and math.isnan(a) for a in atoms):
            return trigger >> self.msg(" ".join(atom(a) for a in atoms))
        text = " ".join("$1" if not isinstance(a, str) and math.isnan(a) else atom(a) for a in atoms)
        nan = trigger >> self.msg(INFINITY) >> self.obj("* 0")
        return nan >> self.msg(text)

    def signal(self, samples):
        """Plays the samples (float32, NaN included) from logical time 0."""
        table = self.patch.add_input(samples)
        player = self.obj("tabplay~", table)
        self.start >> player
        return player

    def record(self, label, source):
        """Records a signal outlet from logical time 0; render()[label] is the array.

        [tabwrite~] turns NaN, infinity and all beyond 1e19 silently into 0, so such samples are
        first made +-1e18, which render() reports. It also turns all below 1e-19 into 0."""
        writer = self.obj("tabwrite~", self.patch.add_recording(label))
        source >> self.obj("max~", -run.BEYOND) >> self.obj("min~", run.BEYOND) >> writer
        self.start >> writer

    def log(self, label, source):
        """Keeps every message of a control outlet: render().logs[label] lists (ms, atoms)."""
        table = self.patch.add_log(label)
        message, timer, line = self.obj("t a b"), self.obj("timer"), self.obj("list prepend 0")
        source >> self.obj("list") >> message
        self.start >> timer
        message[1] >> timer[1]
        timer >> line[1]
        message >> line
        # Printed for the words, and written into an array, as length, time and atoms, for exact
        # numbers: Pd prints six digits.
        fork, length = self.obj("t b a a a"), self.obj("t f f")
        packed, write = self.obj("list prepend 0"), self.obj("array set", table)
        start, advance, here = self.obj("f"), self.obj("+"), self.obj("t f f")
        line >> fork
        fork[3] >> self.obj("print", f"harness-log.{label}")
        fork[2] >> self.obj("list length") >> length
        length[1] >> packed[1]
        length >> advance
        advance >> self.obj("+ 1") >> start[1]
        fork[1] >> packed >> write
        fork >> start >> here
        here[1] >> advance[1]
        here >> write[1]

    def lines(self):
        for box in self.boxes:
            if isinstance(box, Canvas):
                yield f"#N canvas 0 0 600 400 {box.name} 0;"
                yield from box.lines()
                yield f"#X restore 20 20 pd {box.name};"
            else:
                yield box
        for cord in self.cords:
            yield "#X connect " + " ".join(str(n) for n in cord) + ";"


class Patch(Canvas):
    """A whole patch.

    opens   patches to open beside it, for instance one that is being tested: their [dac~] is
            replaced, so that dac() hears them
    own     what stands for $0 in these patches: with own="walk" the name $0-speed is walk-speed
    block   block size of everything drawn here, 1 to 4096, or block~'s arguments "1024 2 1"
    """

    def __init__(self, opens=(), block=None, own=None):
        super().__init__("graph", self)
        self.opens = [pathlib.Path(p) for p in ([opens] if isinstance(opens, (str, pathlib.Path))
                                                else opens)]
        self.block, self.own = block, own
        self.inputs, self.recordings, self.log_tables, self.arrays = {}, {}, {}, []
        self._names = (f"harness-{i}" for i in itertools.count())
        if block is not None:
            self.obj("block~", *str(block).split())

    def add_input(self, samples):
        name = next(self._names)
        self.inputs[name] = samples
        return name

    def add_recording(self, label):
        return self._new_table(self.recordings, label)

    def add_log(self, label):
        return self._new_table(self.log_tables, label)

    def _new_table(self, tables, label):
        if label in self.recordings or label in self.log_tables:
            raise ValueError(f"{label} is recorded twice")
        tables[label] = next(self._names)
        return tables[label]

    def dac(self, channel=1):
        """The signal that the opened patches send to output channel 1, 2, ..."""
        if self.block not in (None, 64):
            raise ValueError("Pd's own output has blocks of 64")
        return self.obj("catch~", f"harness-dac-{channel}")

    def array(self, name):
        """Reads a named array at the end: render().arrays[name]."""
        self.arrays.append(name)

    def rebuild_dsp(self, ms):
        """Makes Pd sort its graph anew at that time, as every edit of a patch does."""
        self.at(ms, self.obj("s", "pd"), "dsp 0, dsp 1")

    def render(self, seconds, rate=48000, **options):
        """Runs the patch in Pd for that much logical time. Raises PdFailure, with what Pd said,
        when Pd prints an error, cannot make an object, stops early, hangs, or leaves a recording
        out. Options are those of run.render."""
        return run.render(self, seconds, rate, **options)
