"""How many inlets and outlets a box has: of Pd's own objects, of the library's, of sub-patches and abstractions."""
import re

FIXED = {  # name: inlets, outlets; with arguments that do not matter
    "array define": (1, 1), "b": (1, 1), "bang": (1, 1), "bang~": (0, 1), "bendin": (0, 2), "change": (1, 2),
    "clip": (3, 1), "clip~": (3, 1), "clone": (1, 0), "cos~": (1, 1), "declare": (0, 0), "delay": (2, 1), "del": (2, 1),
    "drawcurve": (1, 0), "drawpolygon": (1, 0), "env~": (1, 1), "f": (2, 1), "file define": (1, 1),
    "filledcurve": (1, 0), "filledpolygon": (1, 0), "float": (2, 1), "hip~": (2, 1), "i": (2, 1), "int": (2, 1),
    "key": (0, 1), "keyup": (0, 1), "fudiformat": (1, 1), "fudiparse": (1, 1),
    "line": (3, 1), "line~": (2, 1), "list": (2, 1), "list append": (2, 1), "list fromsymbol": (1, 1),
    "list length": (1, 1), "list prepend": (2, 1), "list split": (2, 3), "list store": (2, 2), "list trim": (1, 1),
    "list tosymbol": (1, 1), "loadbang": (0, 1), "lop~": (2, 1), "makefilename": (1, 1), "metro": (2, 1),
    "midiin": (0, 2), "midiparse": (1, 7), "mod": (2, 1), "moses": (2, 2), "mtof": (1, 1), "ftom": (1, 1),
    "netsend": (1, 2), "noise~": (0, 1), "notein": (0, 3), "oscformat": (1, 1), "oscparse": (1, 1), "osc~": (2, 1),
    "pdcontrol": (1, 1), "phasor~": (2, 1), "pipe": (2, 1), "pointer": (2, 2), "print": (1, 0), "qlist": (1, 2),
    "r": (0, 1), "receive": (0, 1), "random": (2, 1), "r~": (1, 1), "receive~": (1, 1), "samplerate~": (1, 1),
    "send~": (1, 0), "s~": (1, 0), "sig~": (1, 1), "slop~": (5, 1), "snapshot~": (1, 1), "soundfiler": (1, 2),
    "spigot": (2, 1), "stripnote": (2, 2), "struct": (0, 1), "swap": (2, 2), "symbol": (2, 1), "tabread": (1, 1),
    "tabread4~": (2, 1), "tabwrite": (2, 1), "tabwrite~": (1, 0), "table": (0, 0), "text define": (1, 2),
    "text delete": (2, 0), "text fromlist": (2, 0), "text get": (4, 2), "text insert": (2, 0), "text search": (2, 1),
    "text sequence": (2, 2), "text set": (4, 0), "text size": (2, 1), "text tolist": (2, 1),
    "textfile": (1, 2), "threshold~": (2, 2), "throw~": (1, 0),
    "catch~": (0, 1), "timer": (2, 1), "until": (2, 1), "v": (1, 1), "value": (1, 1),
    "vline~": (3, 1), "abs": (1, 1), "abs~": (1, 1), "sqrt": (1, 1), "wrap": (1, 1), "array get": (3, 1),
    "array set": (3, 0), "array size": (2, 1), "file handle": (1, 2), "file isfile": (1, 2), "file which": (1, 2),
    "inlet": (0, 1), "inlet~": (0, 1), "outlet": (1, 0), "outlet~": (1, 0), "bag": (2, 1), "poly": (2, 3),
    "sin": (1, 1), "cos": (1, 1), "exp": (1, 1), "log": (2, 1), "dbtorms": (1, 1), "rmstodb": (1, 1),
    "block~": (1, 1), "switch~": (1, 1), "bp~": (3, 1), "savestate": (1, 2), "namecanvas": (0, 0), "midiout": (2, 0),
    "touchin": (0, 2), "pgmin": (0, 2), "netreceive": (1, 2), "rsqrt~": (1, 1), "sqrt~": (1, 1), "array": (1, 1),
}
ONE_OUTLET = {"+", "-", "*", "/", "==", "!=", "<", ">", "<=", ">=", "&&", "||", "%", "min", "max", "pow", "div", "mod",
              "&", "|", "<<", ">>", "+~", "-~", "*~", "/~", "min~", "max~", "pow~"}
WIDGETS = {"cnv": (0, 0), "vu": (2, 2), **dict.fromkeys(("bng", "tgl", "hsl", "vsl", "nbx", "hradio", "vradio"), (1, 1))}
NUMBER = re.compile(r"[-+]?(\d+\.?\d*|\.\d+)(e[-+]?\d+)?$")


class Unknown(ValueError):
    """An object that is none of Pd's, of the library's and of the stage's."""


def of_words(words):
    """Of Pd's own objects; None where the name is none of them."""
    name, arguments = words[0], words[1:]
    n = len(arguments)
    by_count = {
        ("t", "trigger", "unpack", "adc~"): (1, n or 2), ("pack",): (n or 2, 1), ("s", "send"): (1 if n else 2, 0),
        ("route", "sel", "select"): (2 if n <= 1 else 1, (n or 1) + 1), ("dac~",): (n or 2, 0),
        ("pipe",): (max(n, 2), max(n - 1, 1)), ("set",): (max(n, 2), 0), ("get",): (1, max(n - 1, 1)),
        ("append",): (max(n, 2), 1), ("element",): (2, 1), ("getsize",): (1, 1), ("notein",): (0, 2 if n else 3),
        ("ctlin",): (0, 1 if n > 1 else 2 if n else 3), ("bendin", "pgmin", "touchin"): (0, 1 if n else 2)}
    for names, ports in by_count.items():
        if name in names:
            return ports
    if name in ("expr", "expr~", "fexpr~"):
        text = " ".join(arguments)
        return max([int(i) for i in re.findall(r"\$[fisvx](\d+)", text)] + [1]), len(
            [part for part in text.split(";") if part.strip()])
    if name in ONE_OUTLET:
        return 2, 1
    return FIXED.get(" ".join(words[:2]), FIXED.get(name))


class Ports:
    """Of any box. `abstractions(name)`: the canvas of a file of the stage, or None. `declarations`: the library's."""

    def __init__(self, declarations, abstractions):
        self.declared, self.abstractions = {d["name"]: d for d in declarations}, abstractions

    def inner(self, canvas):
        names = [b.name for b in canvas.boxes if b.kind == "obj"]
        return (sum(n in ("inlet", "inlet~") for n in names), sum(n in ("outlet", "outlet~") for n in names))

    def library_object(self, words):
        declared = self.declared[words[0]]
        outlets = [p["name"] for p in declared["outlets"]]
        return len(declared["inlets"]), len(outlets) + ("info" not in outlets)

    def of(self, box):
        if box.kind == "canvas":
            return self.inner(box.canvas)
        if box.kind in ("text", "array", "scalar"):
            return 0, 0
        if box.kind != "obj":
            return 1, 1
        words = box.plain_words()
        if not words:
            return 0, 0
        if words[0] in WIDGETS:
            return WIDGETS[words[0]]
        if words[0].startswith("tactus/"):
            words[0] = words[0].removeprefix("tactus/")
        if words[0] == "clone":
            named = [w for w in words[1:] if not NUMBER.match(w) and not w.startswith(("-", "$"))]
            inside = self.abstractions(named[0]) if named else None
            if inside:
                return self.inner(inside)
        if words[0] in self.declared:
            return self.library_object(words)
        inside = self.abstractions(words[0])
        if inside:
            return self.inner(inside)
        found = of_words(words)
        if found is None:
            raise Unknown(f"no object {words[0]} in Pd, the library or the stage")
        return found
