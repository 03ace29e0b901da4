"""Mozart's Adagio for clarinet, played and felt through the five-reed patch

The solo clarinet's first sixteen bars of the Adagio of K. 622, an octave below the score so that all
of it lies in the model's first register, the chalumeau. A simulated hand holds the device: its
height is the breath, its distance the lip, as patches/reed/reed_haptic.pd maps them. The notes come
as MIDI notes and `tune 1` chooses the bore for each. The force that the hand would
feel while it plays, along the slope of the playability, is measured and drawn.

The gesture is derived from the score: tongued attacks, swells, arches over the phrases, delayed vibrato, breaths in the
rests, and a little human unsteadiness from a seed. The player practises first: each note is blown on a single [greed~]
at several pressures. The player keeps the pressure that is best in tune and the one that makes all notes equally loud.
"""
import csv
import io
import pathlib
import subprocess
import sys

import matplotlib.pyplot as plt
import numpy
from harness import stage_folder
from make_scene import spectrogram

import gesture as gestures
import listening
import score

sys.path.insert(0, str(pathlib.Path(__file__).parent))
import _reed_patch  # noqa: E402
import _room  # noqa: E402
from _reed_patch import PRESET, RATE, SIGMA  # noqa: E402

PATCH = "patches/reed/reed_haptic.pd"
NEEDS = "stage_patches greed~ greed_gradient~ playability~ playability_map phantom tactus_reed_map"
SPRING = "spring 2000 20"  # a firm grip, N/m and N s/m
PLAYS = 0.3                # f_p above which a reed counts as playing


def playable(pitch, sigma, lip=None, columns=61, rows=41):
    """tactus_reed_map's table for one bore, as arrays (rows, columns); lip: only near that f_r."""
    low, high, slow, fast = sigma
    if lip:
        rows, slow, fast = 2, 0.999 * lip, 1.001 * lip
    program = stage_folder().parent / "programs" / "reed_map" / "tactus_reed_map"
    words = [program, PRESET, "--bore", score.frequency(pitch), "--range", low, high, slow, fast,
             "--nodes", columns, rows]
    text = subprocess.run(list(map(str, words)), check=True, capture_output=True, text=True).stdout
    table = list(csv.DictReader(io.StringIO(text)))
    return {k: numpy.array([float(r[k]) for r in table]).reshape(rows, columns) for k in table[0]}


def breath_that_plays(note, gesture):
    """Lowest and highest pressure, Pa, at which the note starts by linear theory with its lip and at which the
    instrument plays."""
    lip = gesture.reed[int(0.5 * (note.onset + note.end) * gestures.RATE)]
    table = playable(note.pitch, gestures.fitting_sigma(gesture, SIGMA), lip)
    plays = table["f_p"][0] > PLAYS
    starts = (table["growth_per_s"][0] > 0) & (table["free"][0] > 0)
    both = table["pressure_pa"][0][plays & starts]
    return both.min(), table["pressure_pa"][0][plays].max()


def at(result, name, t):
    return result[name][numpy.minimum((t * result.rate).astype(int), len(result[name]) - 1)]


def draw_gesture(gesture, result):
    figure, axes = plt.subplots(8, 1, figsize=(12, 15), sharex=True,
                                gridspec_kw={"height_ratios": [1.5, 1, 1.6, 1, 1, 1, 1, 1]})
    t = numpy.arange(0, gesture.seconds, 0.002)
    times, off = listening.track(result["sound"], RATE, gesture.notes, score.frequency)
    for note in gesture.notes:
        axes[0].plot([note.onset, note.end], [note.pitch] * 2, color="#c9d3d8", linewidth=7,
                     solid_capstyle="butt")
    which = numpy.searchsorted([n.onset for n in gesture.notes], times) - 1
    axes[0].plot(times, numpy.array([n.pitch for n in gesture.notes])[which] + off / 100,
                 color="#b2432f", linewidth=1)
    pitches = sorted({n.pitch for n in gesture.notes})
    axes[0].set_yticks(pitches, [score.name(p) for p in pitches])
    axes[0].set_ylabel("score and pitch")
    axes[1].axhspan(-10, 10, color="#e8eef0")
    axes[1].plot(times, off, color="#b2432f", linewidth=0.8)
    axes[1].set_ylim(-25, 25)
    axes[1].set_ylabel("cents from\nthe score")
    low, high, slow, fast = gestures.fitting_sigma(gesture, SIGMA)
    y, z = at(result, "reed-y", t), at(result, "reed-z", t)
    for note in gesture.notes:
        least, most = breath_that_plays(note, gesture)
        axes[2].fill_between([note.onset, note.end], least / 1000, most / 1000, color="#cfe3d4",
                             linewidth=0)
    axes[2].plot(t, (low + y * (high - low)) / 1000, color="#2f4f5f", linewidth=1)
    axes[2].set_ylabel("mouth\npressure, kPa")
    axes[2].text(0.005, 0.95, "green: pressures at which the note starts and plays", transform=axes[2].transAxes,
                 va="top", color="#4a7a56")
    axes[3].plot(t, slow * (fast / slow) ** z, color="#2f4f5f", linewidth=1)
    axes[3].set_ylabel("reed\nfrequency, Hz")
    axes[4].plot(t, at(result, "reed-fp", t), color="#2f4f5f", linewidth=1)
    axes[4].axhline(PLAYS, color="#c9d3d8")
    axes[4].set_ylabel("playability\nf_p")
    for axis, label in (("y", "breath"), ("z", "lip")):
        axes[5].plot(t, at(result, f"reed-gradient-{axis}", t), linewidth=0.8, label=f"{axis}: {label}")
        axes[6].plot(t, at(result, f"reed-force-{axis}", t), linewidth=0.8)
        axes[7].plot(t, 100 * at(result, f"reed-{axis}", t) - 50, linewidth=0.8)
    axes[5].set_ylim(numpy.clip(axes[5].get_ylim(), -6, 6))
    axes[5].legend(loc="upper right", ncols=2)
    axes[5].set_ylabel("slope of f_p\nper unit")
    axes[6].set_ylabel("force, N")
    axes[7].set_ylabel("hand, mm")
    axes[7].set_xlabel("time, s")
    for a in axes:
        a.grid(color="#eef1f2")
        a.set_axisbelow(True)
    axes[0].set_xlim(0, gesture.seconds)
    figure.align_ylabels(axes)
    return figure


def draw_plane(gesture, result):
    """The hand's path over the map of where the clarinet plays the tune's middle note."""
    pitch = int(numpy.median([n.pitch for n in gesture.notes]))
    table = playable(pitch, gestures.fitting_sigma(gesture, SIGMA))
    figure, axes = plt.subplots(figsize=(7.5, 5))
    shown = axes.pcolormesh(table["pressure_pa"] / 1000, table["reed_hz"], table["f_p"],
                            cmap="viridis", vmin=0, shading="gouraud")
    figure.colorbar(shown, label="playability f_p")
    low, high, slow, fast = gestures.fitting_sigma(gesture, SIGMA)
    t = numpy.arange(0.5, gesture.seconds, 0.002)
    axes.plot((low + at(result, "reed-y", t) * (high - low)) / 1000,
              slow * (fast / slow) ** at(result, "reed-z", t), color="white", linewidth=0.6)
    axes.set_yscale("log")
    axes.set_yticks([1000, 1500, 2000, 2500, 3000, 3500], [1000, 1500, 2000, 2500, 3000, 3500])
    axes.minorticks_off()
    axes.set_xlabel("mouth pressure, kPa")
    axes.set_ylabel("reed frequency, Hz")
    axes.set_title(f"the hand's path over the map of {score.name(pitch)}", loc="left")
    return figure


def summary(gesture, sound, measured):
    sustained = [j for j in measured if j["sustained"]]
    off = numpy.array([j["cents"] for j in sustained])
    uneven = numpy.array([j["level_db"] - d for j, d in zip(measured, gesture.intended_db)
                          if j["sustained"]])
    uneven -= numpy.median(uneven)
    speaks = numpy.array([j["speaks_ms"] for j in measured if j["speaks_ms"] is not None])
    levels = [j["level_db"] for j in sustained]
    times, track = listening.track(sound, RATE, gesture.notes, score.frequency)
    firsts = [track[i] for i in numpy.searchsorted(times, [n.onset for n in gesture.notes])]
    firsts = numpy.array([c for c in firsts if c == c])
    lost = sum(not abs(j["cents"]) < 50 or j["fundamental_db"] < -30
               or j["level_db"] < numpy.median(levels) - 20 for j in measured)
    return [["sustained notes (0.3 s or more)", f"{len(sustained)} of {len(measured)}"],
            ["largest deviation from the score", f"{abs(off).max():.1f} cents"],
            ["rms of all sustained notes", f"{numpy.sqrt((off ** 2).mean()):.1f} cents"],
            ["beginnings of all notes (0.03 to 0.11 s): rms, largest",
             f"{numpy.sqrt((firsts ** 2).mean()):.1f}, {abs(firsts).max():.1f} cents"],
            ["notes lost, or in another register", f"{lost}"],
            ["largest deviation of the level from the score's", f"{abs(uneven).max():.1f} dB"],
            ["softest to loudest sustained note", f"{max(levels) - min(levels):.1f} dB"],
            ["tongued notes speak after", f"{speaks.min():.0f} to {speaks.max():.0f} ms"],
            ["clicks", f"{len(listening.clicks(sound, RATE))}"],
            ["peak of [greed~]'s sound (linear to 0.5)", f"{abs(sound).max():.2f}"]]


def note_table(gesture, measured):
    rows = []
    for note, j, asked in zip(gesture.notes, measured, gesture.intended_db):
        rows.append([f"{note.onset:.2f}", score.name(note.pitch), f"{note.duration:.2f}",
                     "slurred" if note.slurred else "breath" if note.first else "tongue",
                     f"{j['hz']:.1f}", f"{j['cents']:+.1f}", f"{j['level_db']:.1f}", f"{asked:+.1f}",
                     "" if j["speaks_ms"] is None else f"{j['speaks_ms']:.0f}"])
    return rows


def make(scene):
    gesture = _reed_patch.gesture()
    result = _reed_patch.render(gesture)
    sound = result["sound"]
    scene.progress(f"{gesture.seconds:.0f} s of the patch in {result.wall_seconds:.1f} s")
    measured = listening.measure_notes(sound, RATE, gesture.notes, score.frequency)
    scene.sound("adagio", _room.full_scale(sound), RATE, "dry, as the patch renders it, scaled to full level; measured below")
    scene.sound("adagio_room", _room.full_scale(_room.reverberate(sound, RATE)), RATE, "in a small room")
    figure, axes = plt.subplots(figsize=(12, 4))
    spectrogram(axes, sound, RATE)
    scene.picture("spectrogram", figure, "spectrogram of the dry sound")
    scene.progress("computing where each note plays")
    scene.picture("gesture", draw_gesture(gesture, result),
                  "score, sound and force of the hand, all recorded in the patch")
    scene.picture("plane", draw_plane(gesture, result), "path of the hand over the map of playability")
    scene.table(["", ""], summary(gesture, sound, measured), "measurements of the performance")
    scene.table(["s", "note", "length", "begins", "Hz", "cents", "dB", "score dB", "speaks ms"],
                note_table(gesture, measured), "every note; speaks: from the onset to half its level")
    felt = _reed_patch.render(gesture, SPRING)
    during = numpy.concatenate([numpy.arange(*(int(x * RATE) for x in listening.steady(n)))
                                for n in gesture.notes if n.duration >= 0.3])
    away = [100 * numpy.percentile(abs(felt[k] - result[k])[during], 99) for k in ("reed-y", "reed-z")]
    springy = listening.measure_notes(felt["sound"], RATE, gesture.notes, score.frequency)
    off = [abs(j["cents"]) for j in springy if j["sustained"]]
    scene.heading("The same gesture with a compliant hand")
    scene.sound("adagio_spring", _room.full_scale(felt["sound"]), RATE,
                f"hand {SPRING}: attacks are slower, and the force moves the hand")
    scene.text(f"Held by a spring of 2000 N/m and 20 N s/m, the handle of 100 g stayed, for 99 % "
               f"of the sustained notes, within {away[0]:.1f} mm of the intended breath and "
               f"{away[1]:.1f} mm of the intended lip; {sum(o <= 10 for o in off)} of {len(off)} "
               f"notes were within 10 cents, the furthest {max(off):.1f} cents off.")
