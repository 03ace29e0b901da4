#!/usr/bin/python3
"""Makes one scene of ./play: runs scripts/scenes/NAME.py and stores its results in out/NAME/.

    make_scene.py NAME [FOLDER]     FOLDER instead of out

A scene has a docstring, a function make(scene), and lines that ./play reads: NEEDS, PATCH, LONG (scenes/README.md).
./play --list shows the docstring's first line; the rest appears on the page.
"""
import importlib.util
import json
import pathlib
import shutil
import sys
import time

import numpy
import scipy.io.wavfile

import sound_check

ROOT = pathlib.Path(__file__).resolve().parents[1]
sys.path.insert(0, str(ROOT / "tests" / "patches"))  # the harness that runs Pd without a screen


class Scene:
    """The output of a scene. Files are in scene.folder; items are shown in the order in which they were
    added."""

    def __init__(self, name, folder, title, description):
        self.name, self.folder = name, folder
        self.page = {"name": name, "title": title, "description": description, "parts": [],
                     "faults": []}
        self.begun = time.monotonic()

    def _add(self, kind, **what):
        self.page["parts"].append({"kind": kind, **what})

    def progress(self, text):
        """Prints a line on the terminal, for work that takes more than a few seconds."""
        text = text.removeprefix(f"{self.name}: ")
        print(f"  {self.name}: {text}", flush=True)

    def heading(self, text):
        self._add("heading", text=text)

    def text(self, text):
        """Adds a paragraph."""
        self._add("text", text=text)

    def sound(self, name, samples, rate, caption=""):
        """Adds a WAV of 32-bit floats; samples have the shape (n,) or (n, channels) and a magnitude of at most 1. The
        sound must begin and end in silence: end the gesture and let the sound decay, or use fade_out(). Faults that
        sound_check.py finds are reported."""
        samples = numpy.asarray(samples, dtype=numpy.float32)
        if not numpy.isfinite(samples).all() or abs(samples).max(initial=0) > 1:
            raise ValueError(f"{name}: expected a sound of finite samples in -1..1")
        scipy.io.wavfile.write(self.folder / f"{name}.wav", int(rate), samples)
        for fault in sound_check.faults(samples, rate):
            self.page["faults"].append(f"{name}.wav: {fault}")
            self.progress(f"{name}.wav: {fault}")
        self._add("sound", file=f"{name}.wav", caption=caption or name,
                  seconds=len(samples) / rate)

    def picture(self, name, figure, caption=""):
        """Adds a PNG of a matplotlib figure, and closes the figure."""
        import matplotlib.pyplot
        figure.savefig(self.folder / f"{name}.png", dpi=110, bbox_inches="tight")
        matplotlib.pyplot.close(figure)
        self._add("picture", file=f"{name}.png", caption=caption)

    def drawn(self, path, name, caption=""):
        """Copies a PNG that a program has drawn into the scene's folder and adds it."""
        shutil.copy(path, self.folder / f"{name}.png")
        self._add("picture", file=f"{name}.png", caption=caption)

    def file(self, name, caption=""):
        """Adds a link to a file that the scene has put into scene.folder."""
        if not (self.folder / name).is_file():
            raise ValueError(f"{name}: file not found in the scene's folder")
        self._add("file", file=name, caption=caption or name)

    def table(self, header, rows, caption=""):
        """Adds a table of numbers and words; cells are converted with str()."""
        self._add("table", header=list(map(str, header)), rows=[list(map(str, r)) for r in rows],
                  caption=caption)


def fade_out(samples, rate, seconds):
    """The recording with a raised-cosine fade over its last seconds, for sounds that have not decayed at its
    end.
    The last 20 ms are silent."""
    faded = numpy.array(samples)  # of the same type, so that earlier samples are bit-equal
    count, silent = round(seconds * rate), round(0.02 * rate)
    gain = numpy.concatenate([0.5 + 0.5 * numpy.cos(numpy.pi * numpy.arange(count) / count), numpy.zeros(silent)])
    gain = gain[-len(faded):]
    faded[-len(gain):] *= gain if faded.ndim == 1 else gain[:, None]
    return faded


def spectrogram(axes, samples, rate, top_hz=8000, floor_db=-90):
    """Draws a spectrogram in dB below the loudest bin, on a linear frequency axis."""
    import scipy.signal
    f, t, power = scipy.signal.spectrogram(numpy.asarray(samples, float), rate, "hann", nperseg=2048,
                                           noverlap=1536, mode="psd")
    level = 10 * numpy.log10(numpy.maximum(power / max(power.max(), 1e-30), 1e-30))
    shown = f <= top_hz
    mesh = axes.pcolormesh(t, f[shown] / 1000, level[shown], vmin=floor_db, vmax=0, cmap="magma",
                           shading="auto", rasterized=True)
    axes.set_xlabel("time, s")
    axes.set_ylabel("frequency, kHz")
    return mesh


def main():
    name = sys.argv[1]
    path = ROOT / "scripts" / "scenes" / f"{name.replace('-', '_')}.py"
    spec = importlib.util.spec_from_file_location("scene", path)
    module = importlib.util.module_from_spec(spec)
    sys.modules["make_scene"] = sys.modules["__main__"]  # scenes import spectrogram, fade_out
    spec.loader.exec_module(module)
    title, _, description = module.__doc__.partition("\n")
    folder = pathlib.Path(sys.argv[2] if len(sys.argv) > 2 else ROOT / "out") / name
    shutil.rmtree(folder, ignore_errors=True)
    folder.mkdir(parents=True)
    scene = Scene(name, folder, title, description.strip())
    module.make(scene)
    scene.page["took_seconds"] = round(time.monotonic() - scene.begun, 1)
    (folder / "scene.json").write_text(json.dumps(scene.page, indent=1))


if __name__ == "__main__":
    main()
