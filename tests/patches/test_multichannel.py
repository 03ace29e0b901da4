"""reed_multichannel.pd: four notes at once in one [greed~] where Pd carries many signals in a cord (0.54 and newer);
in an older Pd one sentence and silence."""
import re
import subprocess

import numpy
import pytest
import test_keys as keys

from harness import Patch

FOUND = re.search(r"Pd-0\.(\d+)", subprocess.run(["pd", "-version"], capture_output=True, text=True).stderr)
MANY = FOUND and int(FOUND.group(1)) >= 54


def played(errors=()):
    patch = Patch(opens=keys.LIVE / "reed_multichannel.pd")
    patch.send(1000 * keys.START_S, "help-play", "bang")
    patch.record("left", patch.dac(1))
    patch.record("right", patch.dac(2))
    result = patch.render(keys.START_S + keys.stream()[-1][0] + 1.5, keys.RATE, timeout=300, path=[keys.LIVE],
                          expect_errors=errors)
    # The stream begins 0.2 s after the click, when the channels are there.
    return result, (result["left"] + result["right"])[round(0.2 * keys.RATE):]


@pytest.mark.skipif(MANY, reason="this Pd carries many signals in a cord")
def test_an_older_pd_says_what_is_missing_and_is_silent():
    result, sound = played(["snake~ out 1", "couldn.t create", "older than 0.54 and has no multichannel signals"])
    assert len(result.errors) == 3 and not sound.any()


@pytest.mark.skipif(not MANY, reason="needs Pd 0.54 or newer")
def test_every_note_sounds_in_a_channel_of_its_own_and_ends():
    _, sound = played()
    for key, _, begin, end in keys.NOTES:
        bent = key == 69 and end - begin > 1  # which this patch does not do
        if not bent and key != 57:  # the oldest of five, whose channel the fifth takes
            last = min(end - 0.05, begin + 1.2)
            assert keys.peak(sound, max(begin + 0.1, last - 0.5), last, keys.frequency(key)) > 12, key
    end = keys.stream()[-1][0]
    assert keys.level(sound, end + 0.9, end + 1.1) < keys.level(sound, end - 0.8, end - 0.6) - 60
    assert 0.1 < numpy.abs(sound).max() <= 2
