"""Recorded instruments: notes of a General MIDI sound font, rendered dry by fluidsynth."""

import subprocess
import tempfile
from pathlib import Path

import mido
import numpy as np
import soundfile

SOUND_FONT = Path("/usr/share/sounds/sf2/FluidR3_GM.sf2")
RATE = 48000
PROGRAMS = {"clarinet": 71, "tenor sax": 66, "oboe": 68, "trumpet": 56, "trombone": 57}


def recorded(instrument: str, key: int, velocity: int = 110, seconds: float = 2.0) -> np.ndarray:
    """One note, without reverberation and chorus, as fluidsynth plays it; mono, RATE."""
    track = mido.MidiTrack([
        mido.Message("program_change", program=PROGRAMS[instrument]),
        mido.Message("note_on", note=key, velocity=velocity),
        mido.Message("note_off", note=key, velocity=0, time=int(960 * seconds)),  # 120 per minute
    ])
    song = mido.MidiFile(ticks_per_beat=480, tracks=[track])
    with tempfile.TemporaryDirectory() as folder:
        midi, wave = Path(folder, "note.mid"), Path(folder, "note.wav")
        song.save(midi)
        subprocess.run(["fluidsynth", "-ni", "-q", "-R", "0", "-C", "0", "-g", "0.5", "-r", str(RATE),
                        "-O", "float", "-F", wave, SOUND_FONT, midi], check=True,
                       stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL, timeout=60)
        sound, rate = soundfile.read(wave)
    assert rate == RATE
    return sound.mean(axis=1) if sound.ndim > 1 else sound


def key_frequency(key: int) -> float:
    return 440.0 * 2 ** ((key - 69) / 12)
