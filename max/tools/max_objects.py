"""What this package's patchers use of Max: each object's inlets and outlets, and those of our own.

An inlet is "control", or "both" where it takes a signal as well. An outlet is "signal", or the type of
message as a saved patcher's `outlettype` names it: "bang", "int", "float", "list" or "" for any.
Learned from patchers that Max saved, as committed facts: an object that is not here is an error, never a guess.
"""
import itertools
import json
import re

C, S = "control", "both"

# Interface objects by maxclass: (inlets, outlets).
INTERFACE = {
    "comment": ([C], []),
    "message": ([C, C], [""]),
    "button": ([C], ["bang"]),
    "toggle": ([C], ["int"]),
    "slider": ([C], [""]),
    "flonum": ([C], ["float", "bang"]),
    "number": ([C], ["int", "bang"]),
    "umenu": ([C], ["int", "", ""]),
    "panel": ([C], []),
    "scope~": ([S, S], []),
    "multislider": ([C], ["", ""]),
    "ezdac~": ([S, S], []),
    "attrui": ([C], [""]),
    "inlet": ([], [""]),
    "outlet": ([C], []),
}

# Objects with the same ports whatever their arguments.
FIXED = {
    "*~": ([S, S], ["signal"]), "+~": ([S, S], ["signal"]), "-~": ([S, S], ["signal"]),
    "abs~": ([S], ["signal"]), "clip~": ([S, S, S], ["signal"]), "cos~": ([S], ["signal"]),
    "cycle~": ([S, S], ["signal"]), "sig~": ([S], ["signal"]), "onepole~": ([S, S], ["signal"]),
    "line~": ([C, C], ["signal", "bang"]), "send~": ([S], []), "receive~": ([C], ["signal"]),
    "adstatus": ([C, C], ["", "int"]),
    "loadbang": ([C], ["bang"]), "loadmess": ([C], [""]), "metro": ([C, C], ["bang"]),
    "delay": ([C, C], ["bang"]), "timer": ([C, C], ["float", ""]), "line": ([C, C, C], ["", "bang"]),
    "send": ([C], []), "receive": ([], [""]), "print": ([C], []), "prepend": ([C], [""]),
    "gate": ([C, C], [""]), "zl.join": ([C, C], ["", ""]),
    "change": ([C], ["", "int", "int"]), "clip": ([C, C, C], [""]), "mtof": ([C], [""]),
    "notein": ([C], ["int", "int", "int"]), "stripnote": ([C, C], ["int", "int"]),
    "int": ([C, C], ["int"]), "float": ([C, C], ["float"]), "tosymbol": ([C], [""]),
}
ALIASES = {"s": "send", "r": "receive", "f": "float", "i": "int", "t": "trigger", "sel": "select"}
ARITHMETIC = ("+", "-", "*", "/", "%", "==", "minimum", "maximum")
TRIGGER_TYPES = {"b": "bang", "i": "int", "f": "float", "l": "", "s": ""}

_declared = {}  # name: declaration
_patchers = {}  # an abstraction of the package: (inlets, outlets)


def declare(declarations):
    """Makes our objects known: the list that tactus_describe prints."""
    _declared.clear()
    _declared.update({d["name"]: d for d in declarations})


def declaration(name):
    return _declared.get(name)


# What every object takes beside its declared messages.
COMMON_MESSAGES = [
    {"name": "get", "arguments": "[name ...]", "fewest": 0, "most": 64,
     "text": "send the named lines of dump, or all parameters, to the info outlet"},
    {"name": "dump", "arguments": "", "fewest": 0, "most": 0,
     "text": "send all parameters and derived values to the info outlet"}]


def messages(d):
    """Of a declared object, with those of every object."""
    own = {m["name"] for m in d["messages"]}
    return d["messages"] + [m for m in COMMON_MESSAGES if m["name"] not in own]


def declare_patcher(name, ports):
    """Makes an abstraction known by the ports of its patcher."""
    _patchers[name] = ports


def own_ports(d):
    """A declared object: at least one inlet for messages; an info outlet at the right end. The first
    inlet of an object that processes audio takes signals and messages, as all signal inlets do."""
    inlets = [S if p["kind"] == "signal" else C for p in d["inlets"]] or [C]
    outlets = ["signal" if p["kind"] == "signal" else "" for p in d["outlets"]]
    if "info" not in (p["name"] for p in d["outlets"]):
        outlets.append("")
    return inlets, outlets


def words(text):
    return text.replace("\\,", " , ").split()


def ports(maxclass, text=None):
    """(inlets, outlets) of a box; KeyError with the name if it is none of ours and not in the table."""
    if maxclass != "newobj":
        return INTERFACE[maxclass]
    arguments = words(text)
    if not arguments:
        raise KeyError("an object without a name")
    name = ALIASES.get(arguments[0], arguments[0])
    arguments = list(itertools.takewhile(lambda word: not word.startswith("@"), arguments[1:]))
    if name in _declared:
        return own_ports(_declared[name])
    if name in _patchers:
        return _patchers[name]
    if name in FIXED:
        inlets, outlets = FIXED[name]
        if name == "gate":
            outlets = [""] * int(float(arguments[0]) if arguments else 1)
        return inlets, outlets
    return _ports_by_arguments(name, arguments)


def _ports_by_arguments(name, arguments):
    count = len(arguments)
    if name in ARITHMETIC:
        whole = not any("." in a for a in arguments)
        if name in ("minimum", "maximum"):
            return [C, C], ["int" if whole else "float", "int"]
        return [C, C], ["int" if whole or name == "==" else "float"]
    if name == "trigger":
        return [C], [TRIGGER_TYPES.get(a, "") for a in arguments] or ["int", "int"]
    if name == "select":
        return [C] * (max(count, 1) + 1), ["bang"] * max(count, 1) + [""]
    if name == "route":
        return [C] + [C] * count, [""] * (max(count, 1) + 1)
    if name == "pack":
        return [C] * max(count, 2), [""]
    if name == "unpack":
        return [C], [_element_type(a) for a in arguments] or ["int", "int"]
    if name == "expr":
        used = [int(n) for n in re.findall(r"\$[fis](\d+)", " ".join(arguments))]
        return [C] * max(used, default=1), [""]
    raise KeyError(name)


def _element_type(argument):
    if argument == "s" or re.match(r"[A-Za-z]", argument) and argument not in ("f", "i"):
        return ""
    return "float" if "." in argument or argument == "f" else "int"


def load_declarations(path):
    declarations = json.loads(path.read_text())
    declare(declarations)
    return declarations
