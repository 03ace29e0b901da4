"""What holds for every object in Max, from its own declaration: its modules, loaded by the stub of Max,
which fails whoever breaks a rule of Max's interface, allocates or locks in the audio thread, or leaks."""
import math
import random
import re

import pytest

from max_host import RATE, declarations, load, run, word

OBJECTS = declarations()
every_object = pytest.mark.parametrize("name", sorted(OBJECTS))
every_signal_object = pytest.mark.parametrize("name", sorted(n for n, d in OBJECTS.items() if d["signal"]))
# Messages that reach for the world outside, of which these tests make nothing: tests/externals does.
# Boxes whose messages would compute for minutes otherwise; `fuzz` leaves these parameters alone.
CHEAP = {"playability_map": {"columns": 3, "rows": 3}}
OUTSIDE = {"open", "connect", "listen", "token", "backend", "firmware", "trace", "write", "devices", "solver"}


def middle(parameter):
    """A value within the range that is neither bound nor the initial one."""
    if parameter["choices"]:
        return parameter["choices"][-1]
    if parameter["values"]:
        return parameter["values"][-1]
    low, high = parameter["lowest"], parameter["highest"]
    if high - low == 1 or float(low).is_integer() and float(high).is_integer() and high - low > 50:
        return float(math.floor((low + high) / 2)) if high - low > 1 else high - parameter["initial"]
    return low + 0.5 * (high - low)


def shown(parameter, value):
    return parameter["choices"][int(value)] if parameter["choices"] and not isinstance(value, str) else value


def same(parameter, text, value):
    """Whether the text of an answer is the value; the sign of a rest angle follows the valve's type."""
    if parameter["choices"]:
        return text == value
    return math.isclose(abs(float(text)), abs(value), rel_tol=1e-12)


def connected(declaration, box="b"):
    """A box with a signal for each signal inlet, plausible for its unit."""
    name = declaration["name"]
    lines = [f"new {box} {name} " + " ".join(f"@{key} {value}" for key, value in CHEAP.get(name, {}).items())]
    for i, port in enumerate(declaration["inlets"]):
        if port["kind"] == "signal":
            wave = {"Pa": "constant 3000", "Hz": "constant 300"}.get(port["unit"], "sine 220 0.5")
            lines.append(f"signal {box} {i} {wave}")
    return lines


@every_object
def test_the_class_is_the_declaration(name):
    d = OBJECTS[name]
    result = run([load(name), f"class {name}", f"new b {name}", "describe b"])
    attributes = {line.split(" ")[1]: line for line in result.of("attribute")}
    assert list(attributes) == [p["name"] for p in d["parameters"]]
    for number, p in enumerate(d["parameters"], 1):
        line = attributes[p["name"]]
        assert ("symbol" if p["choices"] else "float64") == line.split(" ")[2]
        assert f" order={number} " in line + " " and ("save=1" in line) == p["stored"] and "category=" in line
        assert not p["unit"] or f"({p['unit']})" in line
        assert ("style=enum" in line) == bool(p["choices"] or p["values"])
        assert all(choice in line for choice in p["choices"])
    methods = {line.split(" ")[1] for line in result.of("method")}
    # Max's preset object calls a method of that name without arguments: such a message comes by anything.
    own = {m["name"] for m in d["messages"]} - {"preset"}
    assert own | {"get", "dump", "int", "float", "list", "anything"} <= methods and "preset" not in methods
    assert {"getvalueof", "setvalueof"} <= methods or not d["parameters"]
    inlets, outlets = result.of("inlet"), result.of("outlet")
    assert len(inlets) == max(len(d["inlets"]), 1)
    info = any(o["name"] == "info" for o in d["outlets"])
    assert len(outlets) == len(d["outlets"]) + (0 if info else 1)
    for ports, lines in ((d["inlets"], inlets), (d["outlets"], outlets)):
        for port, line in zip(ports, lines):
            unit = f", {port['unit']}" if port["unit"] else ""
            assert line.endswith(f"{port['name']}{unit}: {port['text']}")  # Max has room for 255 characters
            assert (line.split(" ")[2] == "signal") == (port["kind"] == "signal")


@every_object
def test_every_attribute_holds_its_range_and_refuses_what_is_outside(name):
    lines, cases = [load(name)], []
    for box, p in enumerate(OBJECTS[name]["parameters"]):
        good = [p["choices"][0], p["choices"][-1]] if p["choices"] else [p["lowest"], p["highest"], middle(p)]
        bad = ["no-such-word"] if p["choices"] else \
            [p["lowest"] - 1.0, p["highest"] * 1.01 + 1.0, math.nan, math.inf, "word"]
        cases.append((box, p, good, bad))
        lines += [f"new {box} {name}", f"get {box} {p['name']}"]
        for value in good + bad:
            lines += [f"send {box} 0 {p['name']} {word(value)}", f"get {box} {p['name']}"]
        lines += [f"send {box} 0 get {p['name']}", f"send {box} 0 get{p['name']}", f"free {box}"]
    result = run(lines)
    errors = iter(result.of("error"))
    for box, p, good, bad in cases:
        values = [line.split(" ", 2)[2] for line in result.of("value") if line.startswith(f"{box} ")]
        expected = [shown(p, p["initial"]), *good, *[good[-1]] * len(bad)]  # the old value stays
        assert len(values) == len(expected)
        assert all(same(p, text, value) for text, value in zip(values, expected)), (p["name"], values)
        for _ in bad:
            error = next(errors)
            assert p["name"] in error and "expected" in error, error
        one, other = (words for _, _, words in result.sent(str(box)) if words[0] == p["name"])
        assert one == other and same(p, one[1], good[-1]), (one, other)
    assert not list(errors)


@every_object
def test_attributes_flags_and_integers_set_parameters_in_the_box(name):
    parameters = OBJECTS[name]["parameters"]
    for sign in "@-" if parameters else "":
        arguments = " ".join(f"{sign}{p['name']} {word(middle(p))}" for p in parameters)
        result = run([load(name), f"new b {name} {arguments}", *(f"get b {p['name']}" for p in parameters)])
        assert not result.of("error")
        for p in parameters:
            # Some set others: a type the angle's sign, run the gait.
            if p["name"] not in ("theta0", "run", "gait"):
                assert same(p, result.values("b")[p["name"]], middle(p)), p["name"]
    for p in [p for p in parameters if not p["choices"] and p["highest"] >= 1 >= p["lowest"]][:1]:
        assert same(p, run([load(name), f"new b {name} @{p['name']} 1", f"get b {p['name']}"]).values("b")[p["name"]], 1)
    refused = run([load(name), f"new b {name} -no-such-flag 1"])
    assert len(refused.of("error")) == 2 and "could not be made" in refused.of("error")[1]
    unknown = run([load(name), f"new b {name} @no-such-attribute 1", "describe b"])
    assert len(unknown.of("error")) == 1 and unknown.of("inlet")


@every_object
def test_the_value_of_the_box_is_that_of_all_parameters(name):
    """As pattr stores and recalls it, by boxes that have a name, while audio runs or not."""
    parameters = [p for p in OBJECTS[name]["parameters"] if p["stored"]]
    arguments = " ".join(f"@{p['name']} {word(middle(p))}" for p in parameters)
    made = run([load(name), f"new a {name} {arguments}", *(f"get a {p['name']}" for p in parameters), "value a"])
    stored, values = made.of("whole")[0].removeprefix("a "), made.values("a")
    assert stored.split() == [values[p["name"]] for p in parameters]
    if not parameters:
        return
    for audio in ("on", "off"):
        recalled = run([load(name), f"new b {name}", f"dsp {audio}", f"value b {stored}", "value b", "run 2", "value b"])
        assert recalled.of("whole") == ["b " + stored] * 2 and not recalled.of("error")
    long = run([load(name), f"new b {name}", "value b", f"value b {stored} 1.", "value b"])
    assert len(set(long.of("whole"))) == 1
    assert f"expected at most {len(parameters)}, one for each parameter" in long.of("error")[0]


@every_object
def test_a_wrong_number_of_arguments_is_one_error(name):
    d = OBJECTS[name]
    lines, expected = [load(name), f"new b {name}"], 0
    for m in d["messages"]:
        for count in (m["fewest"] - 1, m["most"] + 1):
            if 0 <= count <= 70 and m["name"] not in ("bang", "list"):
                lines.append(f"send b 0 {m['name']} " + " ".join(["1."] * count))
                expected += 1
    lines += ["send b 0 no-such-message", "send b 0 get no-such-parameter"]
    errors = run(lines).of("error")
    assert len(errors) == expected + 2, errors


def fuzz(d, generator, box):
    """One message: mostly of the declaration, with mostly plausible atoms."""
    words = {"word", "no-such-file", "%n%s", "left", "auto", "all", "none"}
    for m in d["messages"]:
        words |= {w for w in re.split(r"[| \[\]]", m["arguments"]) if w.isalnum()}
    words = sorted(words - OUTSIDE - {"load"})

    def atom():
        kind = generator.random()
        if kind < 0.1:
            return generator.choice([math.nan, math.inf, -1e300, 0.0, 1e-320])
        if kind < 0.3:
            return generator.randint(-3, 20)
        return generator.choice(words) if kind < 0.45 else generator.uniform(-2, 5) * 10 ** generator.uniform(-2, 2)

    inlet = generator.randrange(max(len(d["inlets"]), 1))
    selectors = [m for m in d["messages"] if m["name"] not in OUTSIDE]
    kind = generator.random()
    if kind < 0.45 and selectors:
        m = generator.choice(selectors)
        selector, count = m["name"], generator.randint(max(m["fewest"] - 1, 0), min(m["most"] + 1, 12))
        atoms = [atom() for _ in range(0 if selector == "bang" else count)]
    elif kind < 0.8 and d["parameters"]:
        p = generator.choice([p for p in d["parameters"] if p["name"] not in CHEAP.get(d["name"], ())])
        selector = p["name"]
        atoms = [generator.choice(p["choices"] or [generator.uniform(p["lowest"], p["highest"])])]
    else:
        selector, atoms = generator.choice([
            ("float", [generator.uniform(-1, 1)]), ("int", [3]), ("list", [atom(), atom(), atom()]), ("get", []),
            ("dump", []), ("bang", []), ("symbol", [generator.choice(words)])])
    return f"send {box} {inlet} {selector} " + " ".join(map(word, atoms))


@every_object
@pytest.mark.parametrize("count", [60, pytest.param(300, marks=pytest.mark.slow)])
def test_any_message_while_audio_runs(name, count):
    """Vectors of all sizes, rates and kinds of memory, while anything is sent from the main thread and from the
    scheduler's; then freed while audio runs."""
    d, generator = OBJECTS[name], random.Random(f"{name} {count}")
    lines = [load(name), *connected(d)]
    for size, rate, memory in ((64, 48000, "off"), (1, 44100, "same"), (16, 96000, "crossed"), (512, 48000, "off"),
                               (2048, 48000, "same"), (64, 192000, "crossed")):
        lines += ["dsp off", f"rate {rate}", f"vector {size}", f"inplace {memory}", "dsp on"]
        for _ in range(count):
            lines += [f"thread {generator.choice(['main', 'scheduler'])}", fuzz(d, generator, "b"), "thread main",
                      f"run {max(1, 256 // size)}"]
    result = run([*lines, "run 64", "free b"])
    assert not [e for e in result.of("error") if "lost" in e]


@every_signal_object
def test_realtime_messages_run_in_the_audio_thread(name):
    """Each, with good and bad arguments, is carried out at the start of the next vector: the stub fails an
    object that allocates there."""
    d = OBJECTS[name]
    lines = [load(name), *connected(d), f"rate {RATE}", "vector 64", "dsp on", "run 4"]
    arguments = ["", "1.", "0.5 1.", "left", "right 0.3 0.4", "-7e9 1. 2.", "word", "1. 2. 3. 4.", "90.", "0. 0.",
                 "0. 0.2 0.3 1.", "1e9 1. 1. 1."]
    for m in d["messages"]:
        if m["realtime"]:
            for given in arguments:
                if m["fewest"] <= len(given.split()) <= m["most"]:
                    lines += [f"send b 0 {m['name']} {given}", "run 3"]
    for p in d["parameters"]:
        if p["realtime"]:
            for value in (middle(p), shown(p, p["initial"])):
                lines += [f"send b 0 {p['name']} {word(value)}", "run 3"]
    run([*lines, "free b"])
