"""Conversion of Pd patches: the netlist is kept, and what has no equivalent is named."""
import math

import pytest

import max_objects
import pd_file
import pd_to_max
import pd_vocabulary

pytestmark = pytest.mark.usefixtures("declarations")


def convert(tmp_path, *lines, without=None):
    path = tmp_path / "drawn.pd"
    path.write_text("#N canvas 0 0 400 300 12;\n" + "".join(f"#X {line};\n" for line in lines))
    names = pd_to_max.Names([pd_file.read(path)])
    return pd_to_max.convert_file(path, names, without=without)[0]


def box(patcher, text):
    return next(b for b in patcher.boxes if b.text == text or b.maxclass == text)


@pytest.mark.parametrize("drawn, expected", [
    ("osc~ 440", "cycle~ 440."), ("*~ 2", "*~ 2."), ("+ 1", "+ 1."), ("lop~ 30", "onepole~ 30."),
    ("clip 0 1", "clip 0. 1."), ("pack f 5", "pack 0. 5."), ("unpack f s f", "unpack 0. s 0."),
    ("mod 8", "% 8"), ("t b a", "t b l"), ("min 20", "minimum 20."), ("spigot 1", "gate 1 1"),
    ("f \\$1", "f #1"), ("greed~ -type open", "greed~ @type open"), ("del 100", "delay 100"),
    ("list append", "zl.join"), ("b", "t b"), ("s~ here", "send~ here")])
def test_an_object_becomes_its_equivalent(drawn, expected):
    assert pd_vocabulary.object_text(drawn.split(" ")) == expected


def test_an_object_without_equivalent_is_named_with_its_position(tmp_path):
    with pytest.raises(ValueError, match=r"drawn.pd: \[netsend\] at 30 40"):
        convert(tmp_path, "obj 30 40 netsend")


def test_an_object_that_is_listed_with_a_reason_is_left_out_with_its_cords(tmp_path):
    patcher = convert(tmp_path, "obj 30 40 netsend", "obj 30 10 mtof", "connect 1 0 0 0",
                      without={"netsend": "why"})
    assert [b.text for b in patcher.boxes] == ["mtof"] and not patcher.cords


def test_pd_fires_the_first_cord_first_and_so_does_the_trigger(tmp_path):
    patcher = convert(tmp_path, "obj 100 10 r here", "obj 10 80 print first", "obj 200 80 print second",
                      "connect 0 0 1 0", "connect 0 0 2 0", "obj 300 10 s here")
    trigger = box(patcher, "t l l")
    ends = {c[1]: c[2].text for c in patcher.cords if c[0] is trigger}
    assert ends == {1: "print first", 0: "print second"}  # Max fires from right to left


def test_a_signal_may_branch_without_a_trigger(tmp_path):
    patcher = convert(tmp_path, "obj 10 10 osc~ 440", "obj 10 80 dac~", "connect 0 0 1 0", "connect 0 0 1 1")
    assert sorted(b.maxclass for b in patcher.boxes) == ["ezdac~", "newobj"]
    assert len(patcher.cords) == 2


def test_the_inlets_of_a_spigot_change_over(tmp_path):
    patcher = convert(tmp_path, "obj 10 80 spigot", "obj 10 10 r data", "obj 90 10 r switch",
                      "connect 1 0 0 0", "connect 2 0 0 1", "obj 200 10 s data", "obj 200 60 s switch")
    inlets = {c[0].text: c[3] for c in patcher.cords}
    assert inlets == {"r data": 1, "r switch": 0}


SLIDER = "empty 0 0 0 12 #ffffff #000000 #000000 0 1"


def test_a_slider_with_one_name_for_both_ways_is_set_and_not_triggered(tmp_path):
    patcher = convert(tmp_path, f"obj 10 10 hsl 100 15 0 8000 0 0 p p {SLIDER}", "obj 10 60 r p")
    slider = box(patcher, "slider")
    assert (slider.extra["min"], slider.extra["size"]) == (0, 8000)
    into = [c[0] for c in patcher.cords if c[2] is slider]
    assert [b.text for b in into] == ["prepend set"] and into[0].hidden
    assert [c[2].text for c in patcher.cords if c[0] is slider] == ["s p"]
    upright = box(convert(tmp_path, f"obj 10 10 vsl 15 100 -50 30 0 0 empty empty {SLIDER}"), "slider")
    assert [upright.extra[key] for key in ("min", "size", "floatoutput", "orientation")] == [-50, 80, 1, 2]
    assert upright.height > upright.width


def python_of(expression):
    text = expression.removeprefix("expr ").replace("\\,", ",").replace("$f", "x")
    return lambda **values: eval(text, {"pow": math.pow, "log": math.log, "max": max}, values)  # noqa: S307


@pytest.mark.parametrize("low, high", [(0.001, 1.0), (100, 12000)])
def test_a_logarithmic_slider_is_its_own_inverse(tmp_path, low, high):
    patcher = convert(tmp_path, f"obj 10 60 hsl 100 15 {low} {high} 1 0 p p {SLIDER}", "obj 10 160 r p")
    there, back = sorted((b.text for b in patcher.boxes if (b.text or "").startswith("expr")),
                         key=lambda t: "log" in t)
    for position in (0.0, 0.3, 1.0):
        value = python_of(there)(x1=position)
        assert value == pytest.approx(low * (high / low) ** position, rel=1e-5)
        assert python_of(back)(x1=value) == pytest.approx(position, abs=1e-5)


def test_a_sel_of_whole_numbers_gets_integers_and_one_of_results_compares_floats(tmp_path):
    patcher = convert(tmp_path, "obj 10 10 r here", "obj 10 60 sel 0 1", "obj 10 110 print", "connect 0 0 1 0",
                      "connect 1 1 2 0", "obj 90 10 expr \\$f1/2", "obj 90 60 sel 0", "connect 3 0 4 0",
                      "obj 300 10 s here")
    cords = {(c[0].text, c[1], c[2].text, c[3]) for c in patcher.cords}
    assert cords == {("r here", 0, "i", 0), ("i", 0, "sel 0 1", 0), ("sel 0 1", 1, "print", 0),
                     ("expr $f1/2", 0, "sel 0. @matchfloat 1", 0)}


def test_what_only_drove_a_left_out_object_goes_with_it(tmp_path):
    patcher = convert(tmp_path, "obj 30 40 switch~", "obj 30 10 r here", "connect 1 0 0 0", "obj 90 10 s here",
                      without={"switch~": "why"})
    assert [b.text for b in patcher.boxes] == ["s here"]


def test_a_metro_that_only_drew_a_graph_is_not_needed(tmp_path):
    patcher = convert(tmp_path, "obj 10 90 tabwrite~ seen", "obj 10 10 loadbang", "obj 10 40 metro 100",
                      "obj 90 40 osc~ 3", "connect 1 0 2 0", "connect 2 0 0 0", "connect 3 0 0 0")
    assert sorted(b.text for b in patcher.boxes) == ["cycle~ 3.", "send~ seen"]


@pytest.mark.parametrize("expression, values", [
    ("if ($f1 > 0, mtof($f1), 0)", {0.0: 0, 1.0: 440 * 2 ** (-68 / 12), 60.0: 440 * 2 ** (-9 / 12), 69.0: 440}),
    ("if ($f1 > 2, max($f1, 3), if($f1 < 0, 5, 7))", {-1.0: 5, 1.0: 7, 2.5: 3, 4.0: 4})])
def test_if_and_mtof_keep_their_values(expression, values):
    value = python_of(pd_vocabulary.expression(expression))
    assert [value(x1=x) for x in values] == pytest.approx(list(values.values()))


def test_vline_delays_become_ramps_that_hold():
    """To 5 in 300 ms, held until 2500 ms, then to 0 in 200 ms."""
    assert [float(word) for word in pd_vocabulary.ramps("5 300, 0 200 2500").split()] == [5, 300, 5, 2200, 0, 200]


def test_a_comma_behind_a_receiver_names_it_again():
    words = pd_file.words_of("\\; hand spring 300 \\, path line \\; pd dsp 1")[0]
    assert pd_vocabulary.message_text(words) == ";\nhand spring 300;\nhand path line;\ndsp start"
    assert pd_vocabulary.message_text(["2.06e+11", "206000000000", "-2147483648", "2147483647", "1e+06"]) == (
        "206000000000. 206000000000. -2147483648. 2147483647 1000000")


def test_unknown_objects_are_no_guess():
    with pytest.raises(KeyError):
        max_objects.ports("newobj", "no_such_object~ 1")
