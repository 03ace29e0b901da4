"""scripts/sound_check.py, which ./play holds every WAV against: planted faults are found, sounds pass."""
import sys

import numpy
import pytest
import scipy.io.wavfile
import sound_check

RATE = 48000
T = numpy.arange(RATE) / RATE
SWELL = numpy.sin(numpy.pi * T) ** 4


def tone(hz, level=0.5):
    return level * SWELL * numpy.sin(2 * numpy.pi * hz * T)


def struck(begin=0.1, hz=(400, 1130, 2210, 5400, 9700), t60=0.5):
    """A body from one sample to the next: every mode at its full level."""
    sound = numpy.zeros(RATE)
    t = numpy.arange(RATE - int(begin * RATE)) / RATE
    sound[-len(t):] = 0.15 * sum(numpy.sin(2 * numpy.pi * f * t) for f in hz) * 10 ** (-3 * t / t60)
    return sound


def crackle(seed=3, count=200):
    """Grains: short impulses through a resonance, at random times and strengths."""
    generator = numpy.random.default_rng(seed)
    impulses = numpy.zeros(RATE)
    impulses[generator.integers(RATE // 10, 9 * RATE // 10, count)] = generator.exponential(0.1, count)
    t = numpy.arange(960) / RATE
    return numpy.convolve(impulses, numpy.sin(2 * numpy.pi * 3100 * t) * numpy.exp(-t / 0.002))[:RATE]


def square(hz=80, level=0.8):
    """A beating reed at its steepest: it jumps twice a period."""
    return level * SWELL * numpy.sign(numpy.sin(2 * numpy.pi * hz * T))


def shock_waves(hz=207, level=0.6):
    """A loud trumpet: each period the wave steepens within three samples, and sometimes within one."""
    sound = square(hz, level)
    edges = numpy.flatnonzero(numpy.diff(numpy.sign(sound)))
    smooth = numpy.convolve(sound, numpy.ones(3) / 3, "same")
    for edge in edges[::40]:
        smooth[edge - 3:edge + 5] = sound[edge - 3:edge + 5]
    return smooth


SOUNDS = {"silence": numpy.zeros(RATE), "a low tone": tone(60), "a tone": tone(440), "a high tone": tone(11000),
          "noise": 0.2 * SWELL * numpy.random.default_rng(1).standard_normal(RATE).clip(-4, 4),
          "a square wave": square(), "shock waves": shock_waves(),
          "a struck body": struck(), "grains": crackle(), "a bubble": numpy.where(T > 0.4, 0.5, 0) * numpy.exp(
              -numpy.maximum(T - 0.4, 0) / 0.02) * numpy.sin(2 * numpy.pi * 1300 * (T - 0.4))}


@pytest.mark.parametrize("name", SOUNDS)
def test_a_sound_that_begins_and_ends_in_silence_has_no_fault(name):
    assert sound_check.faults(SOUNDS[name], RATE) == []
    assert sound_check.faults(numpy.stack([SOUNDS[name], tone(200)], axis=1), RATE) == []


@pytest.mark.parametrize("name", ["silence", "a low tone", "a tone", "a struck body"])
@pytest.mark.parametrize("height", (-0.02, 0.02))
def test_a_jump_of_a_fiftieth_is_a_click_wherever_it_falls(name, height):
    for index in range(28003, 28003 + 7 * 12, 7):
        cut = SOUNDS[name].copy()
        cut[index:index + 9000] += height
        found = sound_check.clicks(cut, RATE)
        assert any(abs(time - index / RATE) < 3 / RATE and 0.015 < size < 0.03 for time, size in found), index


def test_a_wrong_sample_a_jump_smeared_over_two_and_a_dropped_block_are_clicks():
    wrong, smeared, sound = tone(440), tone(110, 0.3), tone(440)
    wrong[30000] += 0.05
    smeared += numpy.interp(numpy.arange(RATE), (30000, 30002, 31000, 45000), (0, 0.05, 0.05, 0))
    for clicking in (wrong, smeared):
        assert [time for time, _ in sound_check.clicks(clicking, RATE)] == [pytest.approx(30001 / RATE, abs=2 / RATE)]
    dropped = numpy.concatenate([sound[:20000], sound[20064:], numpy.zeros(64)])
    assert any("click" in fault for fault in sound_check.faults(dropped, RATE))


def test_a_jump_among_jumps_of_its_own_size_is_the_sound_s_own():
    sound = square()
    sound[20000:29000] += 0.3
    assert sound_check.clicks(sound, RATE) == []


def test_a_recording_that_begins_or_stops_in_mid_sound_is_named_with_its_level_and_channel():
    cut = tone(440)[:RATE // 2]

    def said(sound):
        return " ".join(sound_check.faults(sound, RATE))
    assert "ends at -6 dB" in said(cut)
    assert "ends" not in said(1e-3 * cut)
    assert "ends at -" in said(numpy.concatenate([cut, 0.002 * numpy.ones(RATE)]))
    assert "starts at -" in said(tone(440)[RATE // 3:])
    late = tone(440)
    late[-1000:] = 0.1
    found = sound_check.faults(numpy.stack([tone(300), late], axis=1), RATE)
    assert found and all(fault.startswith("channel 2: ") for fault in found)


@pytest.mark.parametrize("limit", (0.2, 0.9, 1.0))
def test_a_clipped_sound_is_named_at_any_limit_and_a_softly_limited_one_is_not(limit):
    loud = tone(220, 1.4 * limit)
    assert any("clips" in f for f in sound_check.faults(numpy.clip(loud, -limit, limit), RATE))
    assert any("clips" in f for f in sound_check.faults(numpy.maximum(loud, -limit).clip(-1, 1), RATE))
    assert sound_check.faults(0.99 * limit * numpy.tanh(loud / limit), RATE) == []


def test_beyond_full_scale_and_not_finite_are_faults():
    loud, broken = tone(440, 1.01), tone(440)
    broken[500] = numpy.nan
    assert any("clips" in f for f in sound_check.faults(loud, RATE))
    assert sound_check.faults(broken, RATE) == ["not finite at 0.010 s"]


def test_the_program_names_the_file_and_says_so_by_its_status(tmp_path, monkeypatch, capsys):
    for name, sound in (("good", tone(440)), ("bad", tone(440)[:20000])):
        scipy.io.wavfile.write(tmp_path / f"{name}.wav", RATE, numpy.int16(32767 * sound))
    for names, status in ((["good"], 0), (["good", "bad"], 1)):
        monkeypatch.setattr(sys, "argv", ["sound_check.py", *(str(tmp_path / f"{n}.wav") for n in names)])
        assert sound_check.main() == status
    said = capsys.readouterr().out
    assert "bad.wav: ends at" in said and "good.wav" not in said
