"""The check of words itself, on small samples: every rule hits, and plain text passes."""
import pathlib
import sys

import pytest

ROOT = pathlib.Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "scripts"))
import check_words  # noqa: E402

RULES = check_words.read_rules(check_words.RULES.read_text())

# One or more samples a rule, in the order of the list: a word of code, or a sentence.
SAMPLES = [
    ["kMostContacts", "kLeastGain", "kMostEars"], ["most_steps_", "most_hz"], ["least_level_"],
    ["blows_", "PulseBlow", "the_blow"], ["renew_point", "Renewed"], ["tidy"],
    ["Ear", "ears_", "ear_count_"], ["judge_", "Judge", "all_judges", "judged_j"],
    ["way", "way_by_flow", "way_s_", "velocity_way_by_force"], ["place", "place_of", "set_place", "places"],
    ["led", "led_slot"], ["hearing", "hearings"], ["offers_", "OfferBook"], ["fetter_"],
    ["wish_", "wishes", "WishList"],
    ["The sound of a blow.", "each blow"], ["It is renewed by the worker."],
    ["The object judges a reed."], ["a posted wish"], ["master and slaves"],
    ["that which fades", "what is led"], ["the push gain"],
    ["The clock of who sends.", "the setup for who is in control"], ["A stranger's text."],
    ["It is shown out."], ["and the way there and back"], ["Empty if it cannot be told."],
    ["Foretold from the mesh.", "it foretells"], ["told", "told_"],
]

CLEAN_CPP = r'''
#include "core/contact/impact.hpp" // at most 8 contacts, at least one
/// The reed is blown; the player blows harder. In place of a table. \emplace
constexpr int kMaxContacts = 8'000; // placement 'x'
const char* text = "place x y z: the judge's blow"; // a public message
std::optional<int> value{std::in_place, 3};
auto path = R"(kMostText place)"; auto half_way_mark = emplace(displacement_m, 'p');
'''
CLEAN_PYTHON = '''
"""Counts words; the most common first."""
import collections
most = collections.Counter(words).most_common(3)
answer = least_squares(f, "place")  # a place to stand, said in English
print(f"way {answer:.3f} place {{most_}} led {{}} by {answer!r}")
'''
CLEAN_CMAKE = 'string(REPLACE "place" "x" name ${name}) # in this place\nset(led_colour 3)\n'


def found(name, text):
    return [word for _, word, _ in check_words.hits(name, text, RULES)]


def test_every_rule_hits_its_samples():
    assert len(SAMPLES) == len(RULES)
    for rule, samples in zip(RULES, SAMPLES):
        for sample in samples:
            text = f"// {sample}\n" if rule.where == "text" else f"int {sample} = 0;\n"
            assert check_words.hits("core/some.cpp", text, [rule]), (rule, sample)


@pytest.mark.parametrize("name, text", [("core/a.cpp", CLEAN_CPP), ("scripts/a.py", CLEAN_PYTHON),
                                        ("core/CMakeLists.txt", CLEAN_CMAKE),
                                        ("docs/a.md", "At most three places; tuned by ear; tidy up")])
def test_a_clean_text_passes(name, text):
    assert found(name, text) == []


def test_lines_are_counted_through_comments_and_strings():
    text = '/* one\ntwo */ auto s = R"(x\ny)";\nint place = 0; // that which\n'
    assert [(line, word) for line, word, _ in check_words.hits("a.cpp", text, RULES)] == \
        [(4, "place"), (4, "that which")]


def test_identifiers_of_comments_and_documents_count_but_not_their_sentences():
    assert found("docs/a.md", "`kMostContacts` in this place, `place_of`") == ["kMostContacts", "place_of"]
    assert found("a.py", '"""Uses way_by_force."""\nx = "way_by_force"\n') == ["way_by_force"]


def test_a_file_name_counts_and_an_exempt_path_does_not():
    assert found("core/reed/ear.cpp", "") == ["ear"]
    assert found("core/a.cpp", "int led = 1;") == ["led"]
    assert found("devices/falcon/link.cpp", "int led = 1;") == []
