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


# Boxes of one column are 20 high; [f] is 7 * 3 + 4 = 25 wide, a cord leaves 3 pixels from its left edge.
DOWN = "#X obj 50 20 f;\n#X obj 50 200 print;\n#X connect 0 0 1 0;\n"


@pytest.mark.parametrize("fault,right", [
    (DOWN + "#X obj 45 100 metro 100;\n", DOWN + "#X obj 56 100 metro 100;\n"),
    (DOWN + "#X text 30 100 a comment;\n", DOWN + "#X text 54 100 a comment;\n"),
    (DOWN + "#X obj 100 100 bng 15 250 50 0 empty empty strike -60 8 0 12 #fcfcfc #000000 #000000;\n",
     DOWN + "#X obj 100 100 bng 15 250 50 0 empty empty strike 20 8 0 12 #fcfcfc #000000 #000000;\n"),
    (DOWN + panel(20, 90, 100, 60, "under\\ it"), DOWN + panel(20, 90, 100, 60)),
    (DOWN + "#N canvas 0 0 100 100 (subpatch) 0;\n#X array level 100 float 2;\n#X coords 0 1 99 -1 100 60 1 0 0;\n"
     "#X restore 30 110 graph;\n", DOWN + "#N canvas 0 0 100 100 (subpatch) 0;\n#X array level 100 float 2;\n"
     "#X coords 0 1 99 -1 100 60 1 0 0;\n#X restore 60 110 graph;\n"),
], ids=["box", "comment", "label", "panel's label", "graph"])
def test_a_cord_through_something(stage, fault, right):
    assert set(found(stage, fault)) == {"crossed"}
    assert found(stage, right) == []


def test_a_cord_through_the_name_of_a_graph(stage):
    graph = ("#N canvas 0 0 100 100 (subpatch) 0;\n#X array {} 100 float 2;\n#X coords 0 1 99 -1 20 30 1 0 0;\n"
             "#X restore 30 110 graph;\n")
    assert found(stage, DOWN + graph.format("level")) == ["crossed"]
    assert found(stage, DOWN + graph.format("l")) == []


def test_a_cord_beside_the_short_last_line_of_a_comment_is_free(stage):
    comment = "#X text 20 {} five\\, six and seven, f 14;\n"  # "five, six and" / "seven": 35 pixels
    slanted = "#X obj 100 20 f;\n#X obj 80 {} print;\n#X connect 0 0 1 0;\n"
    assert found(stage, slanted.format(200) + comment.format(100)) == ["crossed"]
    below = "#X obj 70 118 f;\n#X obj 70 200 print;\n#X connect 0 0 1 0;\n"
    assert "crossed" not in found(stage, below + comment.format(100))


@pytest.mark.parametrize("x,y,wrong", [(78, 20, True), (79, 20, False), (20, 38, True), (20, 39, False)])
def test_boxes_that_share_more_than_an_edge(stage, x, y, wrong):
    first = "#X obj 20 20 metro 50;\n"  # ends at 80, 40
    assert found(stage, first + f"#X obj {x} {y} f;\n") == (["overlap"] if wrong else [])


def test_a_wrapped_message_is_as_high_as_its_lines(stage):
    message = "#X msg 20 20 one two three four five six, f 14;\n"  # two lines: 35 pixels
    assert found(stage, message + "#X obj 20 56 f;\n") == []
    assert found(stage, message + "#X obj 20 52 f;\n") == ["overlap"]


def test_a_box_over_the_name_of_a_graph(stage):
    graph = ("#N canvas 0 0 100 100 (subpatch) 0;\n#X array level 100 float 2;\n#X coords 0 1 99 -1 100 60 1 0 0;\n"
             "#X restore 30 110 graph;\n")
    assert found(stage, graph + "#X obj 40 80 f;\n") == ["overlap"]
    assert found(stage, graph + "#X obj 40 74 f;\n") == []
    hidden = graph.replace("100 60 1 0 0", "100 60 3 0 0")
    assert found(stage, hidden + "#X obj 40 80 f;\n") == []


def test_a_label_over_a_box(stage):
    slider = "#X obj 50 60 hsl 100 15 0 1 0 0 empty empty volume {} 0 12 #fcfcfc #000000 #000000 0 1;\n"
    box = "#X obj 170 58 f;\n"
    assert found(stage, slider.format("120 8") + box) == ["overlap"]
    assert found(stage, slider.format("-2 -10") + box) == []


@pytest.mark.parametrize("fault,right", [("#X obj 376 20 f;\n", "#X obj 374 20 f;\n"),
                                         ("#X obj 20 281 f;\n", "#X obj 20 280 f;\n"),
                                         ("#X text 330 20 of the window;\n", "#X text 300 20 of the window;\n"),
                                         (panel(300, 20, 101, 30), panel(300, 20, 100, 30))])
def test_something_beyond_the_window(stage, fault, right):
    assert found(stage, fault) == ["cut"]
    assert found(stage, right) == []


def test_something_beyond_what_the_parent_shows(stage):
    coords = "#X coords 0 1 100 -1 100 60 2 20 20;\n"
    assert found(stage, "#X obj 100 30 bng 18 250 50 0 empty empty empty 0 0 0 12 #fcfcfc #000000 #000000;\n"
                 + coords) == []
    assert found(stage, "#X obj 110 30 bng 18 250 50 0 empty empty empty 0 0 0 12 #fcfcfc #000000 #000000;\n"
                 + coords) == ["cut"]
    assert found(stage, "#X obj 90 30 bng 18 250 50 0 empty empty go 20 8 0 12 #fcfcfc #000000 #000000;\n"
                 + coords) == ["cut"]
    assert found(stage, "#X obj 110 30 metro 100;\n" + coords) == [], "the parent does not show boxes"


def test_a_cord_that_goes_up(stage):
    cord = "#X connect 0 0 1 0;\n"
    assert found(stage, "#X obj 20 100 f;\n#X obj 100 121 f;\n" + cord) == []
    assert found(stage, "#X obj 20 100 f;\n#X obj 100 119 f;\n" + cord) == ["up"]


def test_a_box_that_hears_itself_may_go_up(stage):
    boxes = "#X obj 20 60 list split 1;\n#X obj 20 100 list split 1;\n#X connect 0 1 1 0;\n"
    assert found(stage, boxes + "#X connect 0 1 0 0;\n") == []
    assert found(stage, boxes + "#X connect 1 1 0 0;\n") == ["up"]


def test_a_counter_may_go_up_and_a_longer_loop_may_not(stage):
    counter = "#X obj 20 60 f;\n#X obj {} 84 + 1;\n#X connect 0 0 1 0;\n#X connect 1 0 0 1;\n"
    assert found(stage, counter.format(52)) == []
    assert found(stage, counter.format(152)) == ["up"]


def test_a_panel_over_something(stage):
    box = "#X obj 40 40 f;\n"
    assert found(stage, panel(20, 20, 100, 60) + box) == []
    assert found(stage, box + panel(20, 20, 100, 60)) == ["hidden"]
    assert found(stage, box + panel(20, 62, 100, 60)) == []


def test_something_half_on_a_panel(stage):
    assert found(stage, panel(20, 20, 100, 60) + "#X obj 110 40 f;\n") == ["astride"]
    assert found(stage, panel(20, 20, 100, 60) + "#X obj 95 40 f;\n") == []
    assert found(stage, panel(20, 20, 100, 20) + "#X obj 110 30 f;\n") == [], "a heading is no area"


def test_a_web_of_cords(stage):
    def patch(count):  # every cord crosses every other
        boxes = "".join(f"#X obj {20 + 40 * i} 20 f;\n" for i in range(count))
        boxes += "".join(f"#X obj {20 + 40 * i} 220 f;\n" for i in range(count))
        return boxes + "".join(f"#X connect {i} 0 {2 * count - 1 - i} 0;\n" for i in range(count))
    assert found(stage, patch(3)) == []  # 3 crossings
    assert found(stage, patch(4)) == ["web"]  # 6


def test_an_object_that_nobody_knows_is_an_error(stage):
    with pytest.raises(ValueError, match="no object nonesuch"):
        found(stage, "#X obj 20 20 nonesuch;\n#X obj 20 60 print;\n#X connect 0 0 1 0;\n")
