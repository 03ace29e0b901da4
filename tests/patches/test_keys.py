"""keys_reed.pd, keys_body.pd and [tactus_keys]: a recorded keyboard stream in a headless Pd. Every note sounds at
its pitch and ends, the pedal holds, bend and wheel move the pitch, no voice is left over, the level is bounded."""
import math
import pathlib
import random

import numpy
import pytest

from harness import Patch

ROOT = pathlib.Path(__file__).resolve().parents[2]
LIVE = ROOT / "patches" / "live"
RATE = 48000
START_S = 0.1


def stream():
    """The recorded messages: [(s, words)]."""
    now, events = 0.0, []
    for line in (LIVE / "keys_demo.txt").read_text().splitlines():
        wait, *words = line.strip(";").split()
        now += float(wait) / 1000
        events.append((now, words))
    return events


def notes():
    """(key, velocity, from, to, bend at its middle in cents): what sounds, the pedal included."""
    sounding, ended, held, pedal, found = {}, set(), set(), False, []

    def end(key, now):
        velocity, begun = sounding.pop(key)
        found.append((key, velocity, begun, now))

    for now, words in stream():
        if words[0] == "note":
            key, velocity = int(words[1]), int(words[2])
            if velocity:
                sounding[key] = (velocity, now)
            elif pedal:
                held.add(key)
            else:
                end(key, now)
        if words[:2] == ["control", "64"]:
            pedal = int(words[2]) >= 64
            for key in sorted(held) if not pedal else ():
                end(key, now)
            held = held if pedal else set()
    assert not sounding and not ended
    return found


def frequency(key):
    return 440 * 2 ** ((key - 69) / 12)


def pitch(sound, start, end, near):
    """Frequency of the greatest autocorrelation within 80 cents of `near`, Hz, by a parabola."""
    stretch = sound[int((START_S + start) * RATE):int((START_S + end) * RATE)].astype(float)
    stretch = stretch - stretch.mean()
    size = 1 << (2 * len(stretch) - 1).bit_length()
    correlation = numpy.fft.irfft(numpy.abs(numpy.fft.rfft(stretch, size)) ** 2)[:len(stretch)]
    correlation = correlation / numpy.arange(len(stretch), 0, -1)
    low, high = int(RATE / near * 2 ** (-80 / 1200)), int(RATE / near * 2 ** (80 / 1200)) + 1
    lag = low + int(numpy.argmax(correlation[low:high + 1]))
    a, b, c = correlation[lag - 1:lag + 2]
    exact = lag + (a - c) / (2 * (a - 2 * b + c))
    return RATE / exact


def loudest(sound, start, end, near):
    """Frequency of the highest peak of the spectrum within 80 cents, Hz."""
    stretch = sound[int((START_S + start) * RATE):int((START_S + end) * RATE)].astype(float)
    size = 16 * len(stretch)
    spectrum = numpy.abs(numpy.fft.rfft(stretch * numpy.hanning(len(stretch)), size))
    first, last = (int(near * 2 ** (c / 1200) * size / RATE) for c in (-80, 80))
    return (first + int(numpy.argmax(spectrum[first:last + 1]))) * RATE / size


def pitch_of(instrument):
    """How its pitch is found: a plate's modes are no harmonics."""
    return loudest if instrument == "keys_body" else pitch


def peak(sound, start, end, near):
    """Level at `near` Hz (within 15 cents) beside the median level within a semitone around, in dB."""
    stretch = sound[int((START_S + start) * RATE):int((START_S + end) * RATE)].astype(float)
    size = 8 * len(stretch)
    spectrum = numpy.abs(numpy.fft.rfft(stretch * numpy.hanning(len(stretch)), size))
    cents = 1200 * numpy.abs(numpy.log2(numpy.maximum(numpy.fft.rfftfreq(size, 1 / RATE), 1) / near))
    return 20 * math.log10(spectrum[cents < 15].max() / numpy.median(spectrum[cents < 100]))


def level(sound, start, end):
    stretch = sound[int((START_S + start) * RATE):int((START_S + end) * RATE)].astype(float)
    return 20 * math.log10(max(stretch.std(), 1e-9))


@pytest.fixture(scope="module", params=["keys_reed", "keys_body"])
def performance(request):
    patch = Patch(opens=LIVE / f"{request.param}.pd")
    patch.send(1000 * START_S, "help-play", "bang")
    patch.record("sound", patch.dac(1))
    seconds = START_S + stream()[-1][0] + 1.5
    return request.param, patch.render(seconds, RATE, timeout=300, path=[LIVE])["sound"]


NOTES = notes()
ALONE = [n for n in NOTES if not any(o != n and o[2] < n[3] and n[2] < o[3] + 0.05 for o in NOTES)]
TOGETHER = [n for n in NOTES if n not in ALONE]


@pytest.mark.parametrize("note", [pytest.param(n, id=f"key{n[0]}") for n in ALONE if n[3] - n[2] < 0.6])
def test_a_note_alone_has_its_pitch(performance, note):
    name, sound = performance
    key, _, begin, end = note
    found = pitch_of(name)(sound, begin + 0.2, end - 0.02, frequency(key))
    assert abs(1200 * math.log2(found / frequency(key))) < 10
    assert peak(sound, begin + 0.2, end - 0.02, frequency(key)) > 20


@pytest.mark.parametrize("note", [pytest.param(n, id=f"{n[2]:.1f}s-key{n[0]}") for n in TOGETHER])
def test_every_note_of_a_chord_sounds_until_it_ends(performance, note):
    _, sound = performance
    key, _, begin, end = note
    last = end - 0.05
    assert peak(sound, last - 0.5, last, frequency(key)) > 12


def test_the_pedal_holds_what_the_keys_let_go(performance):
    _, sound = performance
    events = stream()
    let_go = max(s for s, w in events if w[0] == "note" and w[2] == "0" and any(
        n[0] == int(w[1]) and n[2] < s < n[3] - 0.3 for n in TOGETHER))
    up = next(s for s, w in events if w == ["control", "64", "0"])
    assert up - let_go > 0.5
    assert level(sound, up - 0.2, up) > level(sound, let_go - 0.1, let_go) - 25
    assert level(sound, up + 0.42, up + 0.5) < level(sound, up - 0.1, up) - 40


def test_bend_moves_the_pitch_in_cents(performance):
    name, sound = performance
    bent = next(s for s, w in stream() if w == ["bend", "4096"])
    for start, cents in ((bent - 0.3, 0), (bent + 0.15, 100), (bent + 0.65, 0)):
        wanted = frequency(69 + cents / 100)
        found = pitch_of(name)(sound, start, start + 0.3, wanted)
        assert abs(1200 * math.log2(found / wanted)) < 10, (name, start)


def test_a_harder_key_is_louder(performance):
    name, sound = performance
    levels = [level(sound, n[2] + 0.1, n[3]) for n in ALONE[:4]]
    assert [n[1] for n in ALONE[:4]] == sorted(n[1] for n in ALONE[:4])
    assert levels[-1] > levels[0] + 6, name


def test_nothing_is_left_over_and_the_level_is_bounded(performance):
    _, sound = performance
    end = stream()[-1][0]
    loudest = max(level(sound, s / 10, s / 10 + 0.1) for s in range(int(10 * end)))
    assert level(sound, end + 1.2, end + 1.35) < loudest - 90
    assert 0.1 < numpy.abs(sound).max() <= 1


def test_the_keyboard_s_wheel_makes_a_vibrato_on_a_reed():
    patch = Patch(opens=LIVE / "keys_reed.pd")
    patch.send(1000 * START_S, "help-play", "bang")
    patch.record("sound", patch.dac(1))
    on = next(s for s, w in stream() if w == ["control", "1", "127"])
    sound = patch.render(START_S + on + 0.8, RATE, timeout=300, path=[LIVE])["sound"]

    def spread(start, length):
        at = numpy.arange(start, start + length, 0.02)
        found = [pitch(sound, t, t + 0.04, frequency(69)) for t in at]
        return numpy.ptp(1200 * numpy.log2(found))
    assert spread(on - 0.25, 0.2) < 15 and 60 < spread(on + 0.15, 0.4) < 130  # 100 cents from bottom to top


def voices(events, count):
    """[tactus_keys COUNT 0] fed (ms, message): its logged messages."""
    patch = Patch()
    keys = patch.obj("tactus_keys", count, 0)
    for ms, message in events:
        patch.at(ms, keys, message)
    patch.log("out", keys)
    return patch.render((events[-1][0] + 50) / 1000, RATE, path=[LIVE]).logs["out"]


@pytest.mark.parametrize("seed", range(4))
def test_of_a_thousand_random_messages_no_voice_is_left_over(seed):
    generator = random.Random(seed)
    events, now = [], 10
    for _ in range(1000):
        now += generator.choice((0, 0, 1, 3))
        kind = generator.random()
        if kind < 0.8:
            events.append((now, f"note {generator.randrange(48, 60)} {generator.choice((0, 1, 64, 127))}"))
        elif kind < 0.95:
            events.append((now, f"control 64 {generator.choice((0, 63, 64, 127))}"))
        else:
            events.append((now, f"bend {generator.randrange(-8192, 8192)}"))
    events.append((now + 10, "silence"))
    sounding = {}
    for ms, atoms in voices(events, 5):
        if atoms[0] == "all":
            continue
        voice, word, key, velocity = atoms
        assert word == "note" and 1 <= voice <= 5
        if velocity:
            assert voice not in sounding, ms  # a stolen voice is ended first
            sounding[voice] = key
        else:
            assert sounding.pop(voice) == key
    assert not sounding


def test_impossible_keys_do_nothing():
    assert not voices([(10, "note -1 90"), (20, "note 128 90"), (30, "note 500 90"), (40, "note 60 0")], 4)


def test_a_struck_voice_is_in_tune_from_its_first_note_on_and_a_reed_too():
    for name, arguments in (("keys_body_voice", ("1", "own", "plate.modal.npz")), ("keys_reed_voice", ("1", "own"))):
        patch = Patch()
        voice = patch.obj(name, *arguments)
        for value, pa in (("own-low", 800.0), ("own-high", 5000.0)):
            patch.at(5, patch.obj("v", value), pa)
        patch.at(1000 * START_S, voice, "note 62 100")
        patch.at(1000 * START_S + 700, voice, "note 62 0")
        patch.record("sound", voice)
        sound = patch.render(2.5, RATE, path=[LIVE])["sound"]
        found = loudest(sound, 0.2, 0.68, frequency(62))
        assert abs(1200 * math.log2(found / frequency(62))) < 10
        assert numpy.abs(sound[:int(START_S * RATE) - 64]).max() < 1e-6 and not sound[-RATE // 4:].any()


def test_a_bend_does_not_tune_a_struck_voice_that_has_not_played():
    """It has no key: the body was made for 8 Hz, a plate of 16 m, for which memory was missing."""
    patch = Patch()
    voice = patch.obj("keys_body_voice", "1", "own", "plate.modal.npz")
    told = patch.obj("list")
    for instance in range(1000, 1030):  # one of them is the voice's $0
        patch.connect(patch.obj("r", f"{instance}-to-body"), told)
    patch.log("body", told)
    patch.at(1000 * START_S, voice, "bend 200")
    patch.at(1000 * START_S + 100, voice, "note 62 100")
    patch.record("sound", voice)
    sizes = [(ms, words[1]) for ms, words in patch.render(0.5, RATE, path=[LIVE]).logs["body"] if words[0] == "size"]
    assert len(sizes) == 1 and sizes[0][0] >= 1000 * START_S + 99
    assert 0.1 < sizes[0][1] < 10
