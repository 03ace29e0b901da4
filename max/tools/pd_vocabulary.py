"""Maps Pd objects and their words to Max objects. An object that is not in the tables is an error."""
import re

import max_objects
from pd_file import plain


class NoEquivalent(Exception):
    """A Pd object that no Max object of the table replaces."""


# Objects with the same behaviour, under another or the same name.
RENAMED = {
    "osc~": "cycle~", "lop~": "onepole~", "r": "r", "s": "s", "r~": "receive~", "s~": "send~",
    "receive": "r", "send": "s", "del": "delay", "delay": "delay", "mod": "%", "sel": "sel",
    "select": "sel", "min": "minimum", "max": "maximum", "vline~": "line~", "b": "t b", "bang": "t b",
    "f": "f", "float": "f", "symbol": "prepend set",
    **{same: same for same in ("*~", "+~", "-~", "abs~", "clip~", "cos~", "sig~", "line~", "loadbang",
                               "metro", "timer", "line", "print", "change", "clip", "mtof", "notein",
                               "stripnote", "int", "+", "-", "*", "/", "==", "pack", "unpack", "route")},
}
# Max calculates with integers if an argument is an integer, so the arguments of these objects get decimal points.
DECIMAL = {"+", "-", "*", "/", "minimum", "maximum", "clip", "f", "line", "pack", "unpack", "*~", "+~",
           "-~", "sig~", "clip~", "cycle~", "onepole~"}
COUNTERS = {"%"}  # objects for whole numbers in both Max and Pd
ELEMENTS = {"f": "0.", "float": "0.", "s": "s", "symbol": "s"}


def decimal(word):
    return word + "." if re.fullmatch(r"-?\d+", word) else word


LARGEST_INTEGER = 2**31 - 1  # C's long on Windows


def number_of(word):
    """A number as Max writes it: 1e+06 becomes 1000000, and 206000000000 a float, 206000000000."""
    try:
        value = float(word)
    except ValueError:
        return word
    if "e" in word.lower() and 1e-3 <= abs(value) < 1e15:
        word = f"{value:.10f}".rstrip("0").rstrip(".")
    return decimal(word) if abs(value) > LARGEST_INTEGER else word


def _argument_of_abstraction(word):
    return re.sub(r"^\$(\d+)", r"#\1", word)


def expression(text):
    """Pd's expr as Max's: if(c, a, b) as a sum, mtof as its formula, commas escaped as Max saves them."""
    text = re.sub(r"\bif\s+\(", "if(", text)
    text = re.sub(r"mtof\(([^()]*)\)", r"440*pow(2.,((\1)-69)/12.)", text)
    while (start := text.find("if(")) >= 0:
        parts, end = _call(text, start + 3)
        condition, yes, no = parts
        text = f"{text[:start]}(({condition})*({yes})+(1-({condition}))*({no})){text[end:]}"
    text = re.sub(r"\s*,\s*", ",", text)
    return "expr " + text.replace(",", "\\, ").strip()


def _call(text, position):
    """The arguments of a call, read from behind its bracket, and the position of its end."""
    parts, depth, start = [], 0, position
    while True:
        c = text[position]
        if c == "(":
            depth += 1
        elif c == ")" and depth == 0:
            return parts + [text[start:position].strip()], position + 1
        elif c == ")":
            depth -= 1
        elif c == "," and depth == 0:
            parts.append(text[start:position].strip())
            start = position + 1
        position += 1


def own_object(name, words):
    """The text of one of our objects: -flag value becomes @flag value if the flag is a parameter."""
    parameters = {p["name"] for p in max_objects.declaration(name)["parameters"]}
    return " ".join([name] + [f"@{w[1:]}" if w.startswith("-") and w[1:] in parameters else number_of(w)
                              for w in words])


def object_text(words, abstractions=()):
    """The Max text of a Pd object; raises NoEquivalent if there is none. The inlets stay in order, except for spigot."""
    words = [plain(w) for w in words]
    name, arguments = words[0], [_argument_of_abstraction(w) for w in words[1:]]
    if max_objects.declaration(name):
        return own_object(name, arguments)
    if name in abstractions:
        return " ".join([name] + arguments)
    if name in ("t", "trigger"):
        return " ".join(["t"] + [{"a": "l", "anything": "l"}.get(a, a) for a in arguments])
    if name == "expr":
        return expression(" ".join(arguments))
    if name == "spigot":
        return "gate 1 1" if arguments and float(arguments[0]) else "gate 1"
    if name == "list":
        return _list_object(arguments)
    if name not in RENAMED:
        raise NoEquivalent(name)
    renamed = RENAMED[name]
    if renamed in ("pack", "unpack"):
        arguments = [ELEMENTS.get(a, a) for a in arguments]
    if renamed in DECIMAL:
        arguments = [decimal(number_of(a)) for a in arguments]
        if not arguments and renamed in ("+", "-", "*", "/", "f"):
            arguments = ["0."]
    return " ".join([renamed] + arguments)


def _list_object(arguments):
    if arguments[:1] in ([], ["append"]):
        return " ".join(["zl.join"] + arguments[1:])
    if arguments[0] == "trim":
        return "t l"  # Max has no list selector to remove
    if arguments[0] == "prepend":
        return " ".join(["prepend"] + arguments[1:])
    raise NoEquivalent("list " + " ".join(arguments))


AUDIO = {"1": "dsp start", "0": "dsp stop"}


def message_text(words, to_vline=False):
    """The Max text of a Pd message: `; pd dsp 1` becomes `; dsp start`."""
    text = " ".join(number_of(plain(w)) if not w.startswith("\\") or len(w) > 2 else plain(w)
                    for w in words)
    text = re.sub(r";\s*pd dsp ([01])", lambda m: "; " + AUDIO[m.group(1)], text)
    if re.search(r";\s*pd ", text):
        raise NoEquivalent("message to Pd itself: " + text)
    text = re.sub(r"\s+,\s*", ", ", text)
    first, *addressed = re.split(r"\s*;\s*", text.strip())
    parts = []  # after a comma, the receiver stays the same
    for words_to in addressed:
        name = words_to.split(" ")[0]
        commands = words_to.split(", ")
        parts += [commands[0]] + [f"{name} {command}" for command in commands[1:]]
    text = ";\n".join([first] + parts) if addressed else first
    if to_vline and not addressed:
        text = ramps(text)
    return text


def ramps(text):
    """Converts vline~'s `value time delay` steps to one list for line~, in which ramps to the same value replace
    delays."""
    steps = [[float(w) for w in step.split()] for step in text.split(",")]
    if all(len(step) < 3 for step in steps):
        return text
    result, clock, value = [], 0.0, 0.0
    for step in steps:
        target, duration, delay = (step + [0.0, 0.0])[:3]
        if delay > clock:
            result += [value, delay - clock]
            clock = delay
        result += [target, duration]
        clock, value = clock + duration, target
    return " ".join(f"{v:g}" for v in result)
