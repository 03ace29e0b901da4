"""The objects of Max that this package's patchers use, and our own, with their inlets and outlets.

An inlet is "control", or "both" if it also takes a signal. An outlet is "signal", or the type of message as a saved
patcher's `outlettype` names it: "bang", "int", "float", "list" or "" for any. The tables come from patchers that Max
saved. An object that is not in them is an error, never a guess.
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

_declared = {}  # declaration by name
_patchers = {}  # (inlets, outlets) by name of the package's abstraction


def declare(declarations):
    """Registers our objects from the list that tactus_describe prints."""
    _declared.clear()
    _declared.update({d["name"]: d for d in declarations})


def declaration(name):
    return _declared.get(name)


# Messages that every object takes besides its declared ones.
COMMON_MESSAGES = [
    {"name": "get", "arguments": "[name ...]", "fewest": 0, "most": 64,
     "text": "send the named lines of dump, or all parameters, to the info outlet"},
    {"name": "dump", "arguments": "", "fewest": 0, "most": 0,
     "text": "send all parameters and derived values to the info outlet"}]


def messages(d):
    """The messages of a declared object, with the common ones."""
    own = {m["name"] for m in d["messages"]}
    return d["messages"] + [m for m in COMMON_MESSAGES if m["name"] not in own]


def declare_patcher(name, ports):
    """Registers an abstraction with the ports of its patcher."""
    _patchers[name] = ports


def own_ports(d):
    """The ports of a declared object, with at least one inlet for messages and an info outlet at the right end. The
    first inlet of an object that processes audio takes signals and messages, as all signal inlets do."""
    inlets = [S if p["kind"] == "signal" else C for p in d["inlets"]] or [C]
    outlets = ["signal" if p["kind"] == "signal" else "" for p in d["outlets"]]
    if "info" not in (p["name"] for p in d["outlets"]):
        outlets.append("")
    return inlets, outlets


def words(text):
    return text.replace("\\,", " , ").split()


def ports(maxclass, text=None):
    """(inlets, outlets) of a box; KeyError with its name if it is neither ours nor in the tables."""
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
