"""reed_multichannel.pd: four notes at once in one [greed~] where Pd carries many signals in a cord (0.54 and newer);
in an older Pd one sentence and silence."""
import re
import subprocess

import numpy
import test_keys as keys

from harness import Patch

FOUND = re.search(r"Pd-0\.(\d+)", subprocess.run(["pd", "-version"], capture_output=True, text=True).stderr)
MANY = FOUND and int(FOUND.group(1)) >= 54


def test_every_note_sounds_in_a_channel_of_its_own_or_an_older_pd_says_what_is_missing():
    patch = Patch(opens=keys.LIVE / "reed_multichannel.pd")
    patch.send(1000 * keys.START_S, "help-play", "bang")
    patch.record("left", patch.dac(1))
    patch.record("right", patch.dac(2))
    errors = [] if MANY else ["snake~ out 1", "couldn.t create", "older than 0.54 and has no multichannel signals"]
    result = patch.render(keys.START_S + keys.stream()[-1][0] + 1.5 if MANY else 3, timeout=300, path=[keys.LIVE],
                          expect_errors=errors)
    assert len(result.errors) == len(errors)
    # The stream begins 0.2 s after the click, when the channels are there.
    sound = (result["left"] + result["right"])[round(0.2 * keys.RATE):]
    if not MANY:
        assert not sound.any()
        return
    for key, _, begin, end in keys.NOTES:
        bent = key == 69 and end - begin > 1  # which this patch does not do
        if not bent and key != 57:  # the oldest of five, whose channel the fifth takes
            last = min(end - 0.05, begin + 1.2)
            assert keys.above_noise(sound, max(begin + 0.1, last - 0.5), last, keys.frequency(key)) > 12, key
    end = keys.stream()[-1][0]
    loud, quiet = (keys.level(keys.stretch(sound, end + a, end + a + 0.2)) for a in (-0.8, 0.9))
    assert quiet < loud - 60
    assert 0.1 < numpy.abs(sound).max() <= 2
