"""Each rule finds a planted fault, and leaves alone the nearest thing that is right."""
import pytest
import rules
from pd_canvas import Drawing, Stage, pd_file

WINDOW = "#N canvas 0 0 400 300 12;\n"


@pytest.fixture
def stage(tmp_path):
    (tmp_path / "declarations.json").write_text("[]")
    return Stage(tmp_path, tmp_path / "declarations.json")


def found(stage, text, window=WINDOW):
    path = stage.folder / "drawn.pd"
    path.write_text(window + text)
    return [fault.rule for fault in rules.faults(Drawing(pd_file.read(path), stage))]


def panel(x, y, width, height, label="empty"):
    return f"#X obj {x} {y} cnv 4 {width} {height} empty empty {label} 8 11 0 12 #e0e0e0 #000000 0;\n"


def array(name, x, y, width=100, height=60, hidden=1):
    """The graph of an array with its name above."""
    return (f"#N canvas 0 0 100 100 (subpatch) 0;\n#X array {name} 100 float 2;\n"
            f"#X coords 0 1 99 -1 {width} {height} {hidden} 0 0;\n#X restore {x} {y} graph;\n")


def button(label, x, y, at, size=15):
    return f"#X obj {x} {y} bng {size} 250 50 0 empty empty {label} {at} 8 0 12 #fcfcfc #000000 #000000;\n"


# Boxes of one column are 20 high; [f] is 7 * 3 + 4 = 25 wide, a cord leaves 3 pixels from its left edge.
DOWN = "#X obj 50 20 f;\n#X obj 50 200 print;\n#X connect 0 0 1 0;\n"
CORD = "#X connect 0 0 1 0;\n"
COMMENT = "#X text 20 100 five\\, six and seven, f 14;\n"  # "five, six and" / "seven": 35 pixels
MESSAGE = "#X msg 20 20 one two three four five six, f 14;\n"  # two lines: 35 pixels
METRO = "#X obj 20 20 metro 50;\n"  # ends at 80, 40
SLIDER = "#X obj 50 60 hsl 100 15 0 1 0 0 empty empty volume {} 0 12 #fcfcfc #000000 #000000 0 1;\n#X obj 170 58 f;\n"
SHOWN = "#X coords 0 1 100 -1 100 60 2 20 20;\n"
SPLITS = "#X obj 20 60 list split 1;\n#X obj 20 100 list split 1;\n#X connect 0 1 1 0;\n"
COUNTER = "#X obj 20 60 f;\n#X obj {} 84 + 1;\n#X connect 0 0 1 0;\n#X connect 1 0 0 1;\n"


def web(count):
    """Every cord crosses every other."""
    boxes = [f"#X obj {20 + 40 * (i % count)} {20 + 200 * (i // count)} f;\n" for i in range(2 * count)]
    return "".join(boxes + [f"#X connect {i} 0 {2 * count - 1 - i} 0;\n" for i in range(count)])


@pytest.mark.parametrize("rule, fault, right", [
    ("crossed", DOWN + "#X obj 45 100 metro 100;\n", DOWN + "#X obj 56 100 metro 100;\n"),
    ("crossed", DOWN + "#X text 30 100 a comment;\n", DOWN + "#X text 54 100 a comment;\n"),
    ("crossed", DOWN + button("strike", 100, 100, -60), DOWN + button("strike", 100, 100, 20)),
    ("crossed", DOWN + panel(20, 90, 100, 60, "under\\ it"), DOWN + panel(20, 90, 100, 60)),
    ("crossed", DOWN + array("level", 30, 110), DOWN + array("level", 60, 110)),
    ("crossed", DOWN + array("level", 30, 110, 20, 30), DOWN + array("l", 30, 110, 20, 30)),  # its name
    # Beside the short last line of a comment a cord is free.
    ("crossed", "#X obj 100 20 f;\n#X obj 80 200 print;\n" + CORD + COMMENT,
     "#X obj 70 118 f;\n#X obj 70 200 print;\n" + CORD + COMMENT.replace("20 100", "20 90")),
    ("overlap", METRO + "#X obj 78 20 f;\n", METRO + "#X obj 79 20 f;\n"),
    ("overlap", METRO + "#X obj 20 38 f;\n", METRO + "#X obj 20 39 f;\n"),
    ("overlap", MESSAGE + "#X obj 20 52 f;\n", MESSAGE + "#X obj 20 56 f;\n"),
    ("overlap", array("level", 30, 110) + "#X obj 40 80 f;\n", array("level", 30, 110) + "#X obj 40 74 f;\n"),
    ("overlap", array("level", 30, 110) + "#X obj 40 80 f;\n", array("level", 30, 110, hidden=3) + "#X obj 40 80 f;\n"),
    ("overlap", SLIDER.format("120 8"), SLIDER.format("-2 -10")),
    ("cut", "#X obj 376 20 f;\n", "#X obj 374 20 f;\n"), ("cut", "#X obj 20 281 f;\n", "#X obj 20 280 f;\n"),
    ("cut", "#X text 330 20 of the window;\n", "#X text 300 20 of the window;\n"),
    ("cut", panel(300, 20, 101, 30), panel(300, 20, 100, 30)),
    ("cut", button("empty", 110, 30, 0, 18) + SHOWN, button("empty", 100, 30, 0, 18) + SHOWN),
    ("cut", button("go", 90, 30, 20, 18) + SHOWN, "#X obj 110 30 metro 100;\n" + SHOWN),  # the parent shows no boxes
    ("up", "#X obj 20 100 f;\n#X obj 100 119 f;\n" + CORD, "#X obj 20 100 f;\n#X obj 100 121 f;\n" + CORD),
    ("up", SPLITS + "#X connect 1 1 0 0;\n", SPLITS + "#X connect 0 1 0 0;\n"),  # a box may hear itself
    ("up", COUNTER.format(152), COUNTER.format(52)),
    ("hidden", "#X obj 40 40 f;\n" + panel(20, 20, 100, 60), panel(20, 20, 100, 60) + "#X obj 40 40 f;\n"),
    ("hidden", "#X obj 40 40 f;\n" + panel(20, 58, 100, 60), "#X obj 40 40 f;\n" + panel(20, 62, 100, 60)),
    ("astride", panel(20, 20, 100, 60) + "#X obj 110 40 f;\n", panel(20, 20, 100, 60) + "#X obj 95 40 f;\n"),
    ("astride", panel(20, 20, 100, 60) + "#X obj 110 40 f;\n", panel(20, 20, 100, 20) + "#X obj 110 30 f;\n"),  # a heading
    ("web", web(4), web(3))])  # 6 crossings, and 3
def test_a_rule_finds_its_fault_and_leaves_alone_what_is_right(stage, rule, fault, right):
    assert set(found(stage, fault)) == {rule}
    assert found(stage, right) == []


def test_an_object_that_nobody_knows_is_an_error(stage):
    with pytest.raises(ValueError, match="no object nonesuch"):
        found(stage, "#X obj 20 20 nonesuch;\n#X obj 20 60 print;\n" + CORD)
