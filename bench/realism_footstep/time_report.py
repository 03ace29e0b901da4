"""Steps in time beside recordings: two tables, and a picture for each ground."""
import numpy as np

from features import RATE, trim
from recorded_steps import (BAND_EDGES_HZ, ENERGY_DB, LEVELS_DB, TWO_CONTACTS, WINDOW_EDGES_S)
from time_course import summary_of_contacts

WINDOWS = [f"{a:.0f}-{b:.0f}" for a, b in zip(1000 * WINDOW_EDGES_S, 1000 * WINDOW_EDGES_S[1:])]


def joined(values, digits=0):
    return " / ".join("" if np.isnan(v) else f"{v:.{digits}f}" for v in values)


def contact_row(label, whose, contacts):
    share, interval, second, dip, first, decays = contacts
    return (f"| {label} | {whose} | {share:.0f} | {joined(interval)} | {joined(second, 1)} "
            f"| {joined([dip])} | {joined(first)} | {joined(decays)} |")


def contact_lines(courses):
    """Two contacts: courses as {label: TimeCourse}."""
    lines = ["| material | | two, % | interval ms, 10/50/90 % | second over first dB | dip dB "
             "| first peak ms, 50/90 % | decay by 20 dB ms, low/mid/high |", "|---" * 8 + "|"]
    for label, course in courses.items():
        lines += [contact_row(label, "theirs", TWO_CONTACTS[label]),
                  contact_row("", "ours", summary_of_contacts(course))]
    return lines


def energy_lines(courses):
    """Energy of each window, dB of the whole: median (10, 90 %)."""
    lines = ["| material | | " + " | ".join(f"{w} ms" for w in WINDOWS) + " |",
             "|---" * (len(WINDOWS) + 2) + "|"]
    for label, course in courses.items():
        ours = np.percentile(course.energy_db, [10, 50, 90], axis=0)
        for name, whose, (low, median, high) in ((label, "theirs", np.array(ENERGY_DB[label], float)),
                                                 ("", "ours", ours)):
            cells = (f"{m:.0f} ({a:.0f}, {b:.0f})" for a, m, b in zip(low, median, high))
            lines.append(f"| {name} | {whose} | " + " | ".join(cells) + " |")
    return lines


def picture(label, course, steps, path):
    """Time by band: theirs, ours and the difference, dB; below the spectra of three of our steps."""
    import matplotlib
    matplotlib.use("Agg")
    import matplotlib.pyplot as plt
    theirs, ours = LEVELS_DB[label], np.median(course.levels_db, axis=0)
    audible = np.maximum(theirs, ours) > -45
    figure, axes = plt.subplots(2, 3, figsize=(13, 8), gridspec_kw={"height_ratios": [3, 2]})
    centres = np.sqrt(BAND_EDGES_HZ[1:] * BAND_EDGES_HZ[:-1])
    panels = ((theirs, "recordings", "magma", (-60, -8)), (ours, "footstep~", "magma", (-60, -8)),
              (np.where(audible, ours - theirs, np.nan), "ours - theirs (blank: both below -45 dB)",
               "RdBu_r", (-15, 15)))
    for axis, (levels, title, colours, (low, high)) in zip(axes[0], panels):
        image = axis.imshow(levels.T, origin="lower", aspect="auto", cmap=colours, vmin=low, vmax=high)
        for (column, row), level in np.ndenumerate(levels):
            if not np.isnan(level):
                axis.text(column, row, f"{level:.0f}", ha="center", va="center", fontsize=6,
                          color="white" if colours == "magma" and level < -30 else "black")
        axis.set_xticks(range(len(WINDOWS)), WINDOWS, fontsize=7)
        axis.set_yticks(range(0, 20, 3), [f"{hz:.0f}" for hz in centres[::3]], fontsize=7)
        axis.set_title(f"{label}: {title}", fontsize=9)
        axis.set_xlabel("ms after the onset", fontsize=8)
        figure.colorbar(image, ax=axis, label="dB")
    for axis, step in zip(axes[1], steps):
        x = np.pad(trim(step), (0, RATE // 8))
        axis.set_facecolor("black")
        axis.specgram(x + 1e-9, NFFT=256, noverlap=224, Fs=RATE, vmin=-150, vmax=-60, cmap="magma")
        axis.set_xlim(0, 0.5)
        axis.set_xlabel("s")
        axis.set_ylabel("Hz")
    figure.tight_layout()
    figure.savefig(path, dpi=90)
    plt.close(figure)
