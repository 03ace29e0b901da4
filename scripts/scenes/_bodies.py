"""Struck bodies for scenes: tables from modal_fem, kept between runs, and strikes in headless Pd."""
import fcntl
import hashlib
import pathlib
import subprocess
import tempfile

import numpy
from harness import Patch, stage_folder

RATE = 48000
# The paper's ball: steel, radius 6 mm, 7850 kg/m^3, dropped from 100 mm.
BALL = {"radius": 0.006, "E": 2.06e11, "nu": 0.29, "density": 7850.0}
DROP_SPEED = (2 * 9.81 * 0.1) ** 0.5


def program():
    return stage_folder().parent / "programs" / "modal_fem" / "modal_fem"


def table(*words, sheet=False):
    """The path of modal_fem's table for these words of its command line. The table is computed once and stored in the
    build folder, under a name derived from the words, the program, and the files read. With `sheet`, its picture is
    beside it with the same name and the ending .png."""
    words = [str(w) for w in words]
    key = hashlib.sha256(program().read_bytes())
    for word in words:
        key.update(b"\0" + word.encode())
        if pathlib.Path(word).is_file():
            key.update(pathlib.Path(word).read_bytes())
    folder = stage_folder().parent / "bodies"
    folder.mkdir(exist_ok=True)
    path = folder / f"{pathlib.Path(words[0]).stem}-{key.hexdigest()[:16]}.modal.npz"
    picture = path.with_suffix("").with_suffix(".png")
    with open(path.with_suffix(".lock"), "w") as lock:  # locked, because scenes that run at the same time share tables
        fcntl.flock(lock, fcntl.LOCK_EX)
        if not path.is_file() or (sheet and not picture.is_file()):
            drawn = ["--sheet", picture] if sheet else []
            done = subprocess.run([program(), *words, "--quiet", "-o", path, *drawn],
                                  capture_output=True, text=True)
            if done.returncode or not path.is_file():
                raise RuntimeError(f"modal_fem {' '.join(words)}: {(done.stderr + done.stdout).strip()}")
    return path


def picture_of(path):
    return path.with_suffix("").with_suffix(".png")


def ball(radius=BALL["radius"], E=BALL["E"], nu=BALL["nu"], density=BALL["density"]):
    """The words of the message `striker` for a solid ball."""
    return f"striker {4 / 3 * numpy.pi * radius ** 3 * density:.9g} {radius:g} {E:g} {nu:g}"


def strike(path, strikes, seconds, settings=(), gain=0.1, rate=RATE, flags=()):
    """Render of [modal_impact~] playing the table: "left", "right" in Pa times gain and "contact" in N. strikes is [(s,
    message or messages)], such as (0.1, "hit 25 0 6 1.4"); settings are messages at time 0."""
    with tempfile.TemporaryDirectory(prefix="tactus-") as folder:
        (pathlib.Path(folder) / "body.modal.npz").symlink_to(path)
        patch = Patch()
        body = patch.obj("modal_impact~", "body.modal.npz", "-sync", 1, "-gain", gain, *flags)
        for index, name in enumerate(("left", "right", "contact")):
            patch.record(name, body[index])
        for message in settings:
            patch.at(0, body, message)
        for time, messages in strikes:
            for message in [messages] if isinstance(messages, str) else messages:
                patch.at(1000 * time, body, message)
        return patch.render(seconds, rate, path=[folder], timeout=300)


def spectrum(samples, rate=RATE, size=1 << 19):
    """(frequencies, amplitudes) under a Hann window, padded to bins of at most 0.1 Hz."""
    x = numpy.asarray(samples, float)
    return (numpy.arange(size // 2 + 1) * rate / size,
            abs(numpy.fft.rfft(x * numpy.hanning(len(x)), size)) * 2 / max(len(x) / 2, 1))


def peaks(samples, rate=RATE, low_hz=500, high_hz=20000, below_db=60, apart_hz=40, count=12):
    """[(Hz, dB below the loudest)] of the spectrum's peaks, the loudest first; the frequency is that of a parabola
    through the top of each peak, in dB. A peak is the highest value within apart_hz on both sides, so a ripple on the
    skirt of another peak does not count."""
    f, a = spectrum(samples, rate)
    level = 20 * numpy.log10(numpy.maximum(a, 1e-30))
    tops = numpy.flatnonzero((a[1:-1] > a[:-2]) & (a[1:-1] >= a[2:])) + 1
    tops = tops[(f[tops] >= low_hz) & (f[tops] <= high_hz)]
    tops = tops[numpy.argsort(-level[tops])]
    found, width = [], max(1, int(apart_hz / f[1]))
    for k in tops:
        if level[k] < level[tops[0]] - below_db or len(found) == count:
            break
        left, middle, right = level[k - 1:k + 2]
        if middle >= level[max(0, k - width):k + width + 1].max():
            found.append((f[k] + 0.5 * (left - right) / (left - 2 * middle + right) * f[1], middle - level[tops[0]]))
    return found


def nodal_diameters(path, rim_m, face_m):
    """Number of nodal diameters of each mode of a round body: the strongest angular harmonic of the axial motion along
    the rim of the face at height face_m (of the radial motion if the mode is in the plane)."""
    body = numpy.load(path)
    xyz, phi = body["xyz"].astype(float), body["phi"].astype(float)
    radius = numpy.hypot(xyz[:, 0], xyz[:, 1])
    rim = (abs(xyz[:, 2] - face_m) < 1e-6) & (abs(radius - rim_m) < 1e-5)
    angle = numpy.arctan2(xyz[rim, 1], xyz[rim, 0])
    turns = numpy.exp(1j * numpy.outer(numpy.arange(8), angle))
    turns[0] *= 0.5 ** 0.5
    axial = abs(numpy.einsum("na,ka->kn", turns, phi[:, rim, 2]))
    radial = abs(numpy.einsum("na,ka->kn", turns, phi[:, rim, 0] * numpy.cos(angle)
                              + phi[:, rim, 1] * numpy.sin(angle)))
    flat = radial.max(1) > 3 * axial.max(1)
    return numpy.where(flat, radial.argmax(1), axial.argmax(1)), flat
