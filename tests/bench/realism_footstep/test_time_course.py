"""Energy by time and band, contacts and decays of signals whose answers are known by hand."""
import numpy
import pytest
from features import RATE
from recorded_steps import BAND_EDGES_HZ, ENERGY_DB, LEVELS_DB, TWO_CONTACTS, WINDOW_EDGES_S
from targets import MATERIALS
from time_course import FLOOR, bursts, summary_of_contacts, time_course

TIME = numpy.arange(RATE) / RATE
FLOOR_OF_ALL = 10 * numpy.log10(20 * FLOOR)


def burst(at, decay_s, hz, strength=1.0):
    t = TIME - at
    return strength * (t >= 0) * numpy.exp(-numpy.clip(t, 0, None) / decay_s) * numpy.sin(2 * numpy.pi * hz * t)


def test_every_ground_has_its_three_tables():
    for table in (TWO_CONTACTS, ENERGY_DB, LEVELS_DB):
        assert list(table) == MATERIALS
    for label in MATERIALS:
        low, median, high = numpy.array(ENERGY_DB[label])
        assert (low <= median).all() and (median <= high).all()
        # Both tables tell the energy of a window: within what medians of sums and of parts differ by.
        summed = 10 * numpy.log10((10 ** (LEVELS_DB[label] / 10)).sum(axis=1))
        assert summed == pytest.approx(median, abs=9)


def test_band_edges_are_those_of_the_tables_centres():
    # Even on the mel scale: log(700 + f).
    centres = numpy.sqrt((BAND_EDGES_HZ[1:] + 700) * (BAND_EDGES_HZ[:-1] + 700)) - 700
    known = [127, 241, 371, 520, 689, 881, 1100, 1349, 1633, 1956, 2324, 2742, 3219, 3762, 4379, 5082, 5883,
             6794, 7832, 9013]
    assert centres == pytest.approx(known, abs=0.7)


def test_a_steady_noise_puts_half_its_energy_into_the_windows_by_their_length():
    noise = numpy.random.RandomState(2).randn(RATE) * (TIME > 0.1) * (TIME < 0.9)
    course = time_course([noise])
    length = numpy.diff(WINDOW_EDGES_S)
    # Triangular bands from 75 to 9660 Hz hold half of a white noise's 11025 Hz up to there.
    expected = 10 * numpy.log10(0.5 * length / 0.8 * (9660 - 75) / 11025)
    assert course.energy_db[0, 2:] == pytest.approx(expected[2:], abs=1.2)
    assert course.energy_db[0, :2] == pytest.approx(expected[:2], abs=2.5)  # few frames


def test_a_tone_lies_in_its_band_and_a_later_one_in_its_window():
    middle = (BAND_EDGES_HZ[1:] + BAND_EDGES_HZ[:-1]) / 2
    sound = burst(0.1, 0.004, middle[6]) + burst(0.4, 0.004, middle[12])
    levels = time_course([sound]).levels_db[0]
    assert levels[0].argmax() == 6
    assert levels[5].argmax() == 12
    assert levels[3].max() < levels[0].max() - 30  # nothing between


def test_two_contacts_are_found_with_their_interval_level_and_dip():
    sound = burst(0.1, 0.006, 800) + burst(0.17, 0.006, 800, 10 ** (-9 / 20))
    course = time_course([sound] * 3)
    assert course.share_of_two == 100
    interval, second, dip, first = course.contacts[0]
    assert interval == pytest.approx(70, abs=1)
    assert second == pytest.approx(-9, abs=0.3)
    assert dip < -40
    assert 0 <= first < 8
    summary = summary_of_contacts(course)
    assert summary[1] == pytest.approx((70, 70, 70), abs=1)
    assert summary[2] == pytest.approx((second,) * 3) and summary[3] == pytest.approx(dip)
    assert summary[4] == pytest.approx((first, first))


def test_one_contact_is_one_also_with_another_nearer_than_30_ms_or_20_db_lower_and_silence_has_none():
    near = burst(0.1, 0.003, 800) + burst(0.12, 0.003, 800)
    low = burst(0.1, 0.006, 800) + burst(0.2, 0.006, 800, 10 ** (-26 / 20))
    course = time_course([burst(0.1, 0.02, 300), near, low, numpy.zeros(RATE)])
    assert course.share_of_two == 0
    assert not numpy.isfinite(course.contacts[0, :3]).any()
    assert numpy.isnan(summary_of_contacts(course)[2]).all()
    assert course.energy_db[3] == pytest.approx(FLOOR_OF_ALL, abs=0.1)


def test_a_band_decays_by_20_db_in_its_own_time():
    course = time_course([burst(0.1, 0.03, 200) + burst(0.1, 0.01, 5000)])
    low, middle, high = course.decays_ms[0]
    assert low == pytest.approx(1000 * 0.03 * numpy.log(10), rel=0.1)
    assert high == pytest.approx(1000 * 0.01 * numpy.log(10), rel=0.2)


def test_level_and_what_comes_before_do_not_count():
    sound = burst(0.1, 0.01, 700) + burst(0.18, 0.01, 2000)
    later = numpy.roll(sound, 2000)
    # The frames' grid is 2.9 ms.
    a, b = (time_course([s]).energy_db[0] for s in (sound, 0.01 * later))
    assert a == pytest.approx(b, abs=0.5)


def test_the_onset_is_26_db_below_the_loudest_moment():
    # Rises by 0.6 dB a millisecond until 0.3 s, then falls at once.
    rising = numpy.sin(2 * numpy.pi * 900 * TIME) * (TIME < 0.3) * 10 ** ((TIME - 0.3) * 600 / 20)
    course = time_course([rising])
    assert course.contacts[0, 3] == pytest.approx(26 / 0.6, abs=4)


def test_the_second_contact_is_the_highest_of_those_that_follow():
    sound = (burst(0.1, 0.006, 800) + burst(0.15, 0.006, 800, 10 ** (-12 / 20))
             + burst(0.22, 0.006, 800, 10 ** (-3 / 20)))
    interval, second, _, _ = time_course([sound]).contacts[0]
    assert interval == pytest.approx(120, abs=1)
    assert second == pytest.approx(-3, abs=0.3)


def test_a_dip_lies_under_the_higher_contact_whichever_it_is():
    tone = 0.03 * numpy.sin(2 * numpy.pi * 500 * TIME) * (TIME > 0.05) * (TIME < 0.3)
    falling = tone + burst(0.1, 0.006, 800, 2) + burst(0.19, 0.006, 800)
    growing = tone + burst(0.1, 0.006, 800) + burst(0.19, 0.006, 800, 2)
    dips = [time_course([sound]).contacts[0, 2] for sound in (falling, growing)]
    assert dips[0] == pytest.approx(dips[1], abs=0.5)
    # A decaying burst has 2^2 / 4 * 6 ms of energy, all or most of it under the window's peak, 2 / 8 ms.
    lowest = 10 * numpy.log10((0.03 ** 2 / 2) / (0.006 * 2 / 0.008))
    assert lowest < dips[0] < lowest + 4


def test_bursts_are_counted_in_their_band_and_time():
    step = burst(0.1, 0.01, 300, 3) + burst(0.1, 0.005, 2000)
    creak = sum(burst(0.1 + t, 0.005, 2000, 10 ** (-9 / 20)) for t in (0.2, 0.24, 0.28, 0.32))
    early = burst(0.17, 0.005, 2000)
    low = sum(burst(0.1 + t, 0.02, 300, 0.7) for t in (0.2, 0.24, 0.28))
    steady = step + 0.3 * numpy.sin(2 * numpy.pi * 2000 * TIME) * (TIME > 0.1) * (TIME < 0.8)
    numbers, highest, late = bursts([step, step + creak, step + early, step + low, steady]).T
    assert list(numbers) == [0, 4, 0, 0, 0]
    assert highest[1] == pytest.approx(-9, abs=0.5)
    assert late[1] == pytest.approx(10 * numpy.log10(4) - 9, abs=0.7)
    assert late[0] < -20 and late[2] < -20
