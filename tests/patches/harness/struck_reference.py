"""What a struck body must sound like, from its table by other means than [modal_impact~]'s.

Modes, rigid motion and a ball are stepped together with exact propagators at many steps a sample;
pressure is Rayleigh's integral of the retarded normal acceleration over the surface, worked out in
Laplace's domain:  P(s) = rho F(s) [sum_k b_k G_k(s) s^2/((s - s_k)(s - s_k*)) + rigid],
G_k(s) = sum over triangles of phi_n A exp(-s d/c)/(2 pi d). Sounds are compared on the line
s = beta + j omega, that is under a window exp(-beta t), where nothing is cut off.
"""
import json

import numpy

AIR, SPEED_OF_SOUND = 1.184, 346.1
CONTACT_LIMIT = 60000  # Hz; higher modes take no part


def closed_form_bar(length=.3, width=.03, thickness=.012, young=2e11, density=7800, modes=12):
    """Table of a free steel bar by Euler and Bernoulli: bending across its thickness."""
    roots = [4.730040745, 7.853204624, 10.99560784]
    roots += [(n + .5) * numpy.pi for n in range(4, modes + 1)]
    mass = density * length * width * thickness
    f = numpy.array(roots) ** 2 / (2 * numpy.pi * length ** 2) * numpy.sqrt(
        young * thickness ** 2 / (12 * density))

    def shape(root, x):
        u = root * (x / length + .5)
        ratio = (numpy.cosh(root) - numpy.cos(root)) / (numpy.sinh(root) - numpy.sin(root))
        # cosh u - ratio sinh u without the difference of large numbers
        large = .5 * ((1 - ratio) * numpy.exp(u) + (1 + ratio) * numpy.exp(-u))
        return (large + numpy.cos(u) - ratio * numpy.sin(u)) / numpy.sqrt(mass)

    xyz, tri = box(length, width, thickness, 120, 6)
    phi = numpy.zeros((len(roots), len(xyz), 3))
    for k, root in enumerate(roots):
        phi[k, :, 2] = shape(root, xyz[:, 0])
    inertia = mass / 12 * numpy.diag([width ** 2 + thickness ** 2, length ** 2 + thickness ** 2,
                                      length ** 2 + width ** 2])
    return arrays("bar", "free", young, density, f, phi, xyz, tri, mass, numpy.zeros(3), inertia)


def closed_form_string(length=.33, side=.001, hz=196., density=3e-3, modes=40, loss=3.45):
    """Table of a string between fixed ends, of `density` kg/m, square across, that moves along y:
    harmonics of sin(n pi x/L), the decay rates `loss` (1 + n^2/100) 1/s."""
    x = numpy.linspace(-.5, .5, 201) * length
    across = side / 2 * numpy.array([[-1, 1], [1, 1], [1, -1], [-1, -1]])  # y, z around the string
    xyz = numpy.array([[p, *a] for a in across for p in x])
    tri = []
    for face in range(4):
        a, b = face * len(x), (face + 1) % 4 * len(x)
        for i in range(len(x) - 1):
            tri += [[a + i, b + i + 1, b + i], [a + i, a + i + 1, b + i + 1]]
    n = numpy.arange(1, modes + 1)
    phi = numpy.zeros((modes, len(xyz), 3))
    phi[:, :, 1] = numpy.sin(numpy.outer(n, numpy.pi * (xyz[:, 0] / length + .5))) * numpy.sqrt(
        2 / (density * length))
    mass = density * length
    table = arrays("string", "clamped", 2e11, 7800, hz * n, phi, xyz, numpy.array(tri), mass,
                   numpy.zeros(3), mass * length ** 2 / 12 * numpy.diag([1e-4, 1, 1]))
    table["eta"] = loss * (1 + n ** 2 / 100) / (numpy.pi * hz * n)
    return table


def closed_form_board(length=.5, width=.35, thickness=.008, young=1.1e10, density=450, columns=24, rows=18):
    """Table of a simply supported wooden plate by Kirchhoff, centred in the x-y plane."""
    nu, pi = .3, numpy.pi
    mass = density * length * width * thickness
    stiffness = young * thickness ** 3 / (12 * (1 - nu ** 2))
    numbers = [(m, n) for m in range(1, 7) for n in range(1, 6)]
    f = numpy.array([pi / 2 * numpy.sqrt(stiffness / (density * thickness)) * ((m / length) ** 2 + (n / width) ** 2)
                     for m, n in numbers])
    order = numpy.argsort(f)
    xyz, tri = box(length, width, thickness, columns, rows)
    phi = numpy.zeros((len(f), len(xyz), 3))
    for k, i in enumerate(order):
        m, n = numbers[i]
        phi[k, :, 2] = 2 / numpy.sqrt(mass) * (numpy.sin(m * pi * (xyz[:, 0] / length + .5))
                                               * numpy.sin(n * pi * (xyz[:, 1] / width + .5)))
    table = arrays("board", "simply supported", young, density, f[order], phi, xyz, tri, mass,
                   numpy.zeros(3), mass / 12 * numpy.eye(3))
    table["eta"] = numpy.full(len(f), .01)
    return table


def box(length, width, thickness, columns, rows):
    """The two large faces of a board, outward; its edges hardly radiate."""
    x, y = numpy.meshgrid(numpy.linspace(-.5, .5, columns + 1) * length,
                          numpy.linspace(-.5, .5, rows + 1) * width)
    faces, tri = [], []
    for side in (1, -1):
        first = len(faces) * x.size
        faces.append(numpy.stack([x.ravel(), y.ravel(), 0 * x.ravel() + side * thickness / 2], 1))
        for k in range(rows):
            for i in range(columns):
                p = first + k * (columns + 1) + i
                quad = [[p, p + 1, p + columns + 2], [p, p + columns + 2, p + columns + 1]]
                tri += quad if side > 0 else [q[::-1] for q in quad]
    return numpy.concatenate(faces), numpy.array(tri)


def arrays(name, boundary, young, density, freq, phi, xyz, tri, mass, com, inertia):
    meta = {"format": "modal-table", "version": "1.0", "body_name": name, "bc": boundary,
            "material": {"name": "", "E": young, "nu": .3, "rho": density},
            "air": {"rho": AIR, "c": SPEED_OF_SOUND}}
    return {"meta": numpy.frombuffer(json.dumps(meta).encode(), dtype=numpy.uint8), "freq": freq,
            "eta": numpy.full(len(freq), 2e-3), "phi": phi.astype("f4"), "xyz": xyz.astype("f4"),
            "tri": tri.astype("i4"), "mass": numpy.array(mass), "com": com, "inertia": inertia}


class StruckReference:
    def __init__(self, table, loss):
        """table: arrays by name; loss: the same loss factor for all modes."""
        keep = table["freq"] < CONTACT_LIMIT
        omega = 2 * numpy.pi * table["freq"][keep]
        decay = numpy.minimum(omega * loss / 2, .999 * omega)
        self.rate = -decay + 1j * numpy.sqrt(omega ** 2 - decay ** 2)
        self.phi = table["phi"][keep].astype(float)
        self.xyz, self.tri = table["xyz"].astype(float), table["tri"]
        meta = json.loads(bytes(table["meta"]))
        self.material, self.free = meta["material"], meta["bc"].startswith("free")
        self.mass, self.com, self.inertia = float(table["mass"]), table["com"], table["inertia"]
        corner = self.xyz[self.tri]
        cross = numpy.cross(corner[:, 1] - corner[:, 0], corner[:, 2] - corner[:, 0])
        self.area = numpy.linalg.norm(cross, axis=1) / 2
        self.normal = cross / (2 * self.area[:, None])
        self.centre = corner.mean(1)

    def excite_at(self, triangle):
        """Takes the middle of a triangle as the point of an inward force; returns it in mm."""
        self.at, self.out = self.centre[triangle], self.normal[triangle]
        self.b = -numpy.einsum("kvd,d->k", self.phi[:, self.tri[triangle]], self.out) / 3
        self.linear = -self.out / self.mass * self.free
        self.angular = numpy.linalg.solve(self.inertia, numpy.cross(self.at - self.com, -self.out)) \
            * self.free
        return self.at * 1000

    def radiating(self, listener):
        """Triangles that a listener hears in front of the baffle, and their distances."""
        facing = (numpy.abs(self.normal) * self.area[:, None]).sum(0)
        axis = facing.argmax()
        if facing[axis] > .6 * self.area.sum():
            middle = (self.centre * self.area[:, None]).sum(0) / self.area.sum()
            seen = numpy.sign((listener - middle)[axis]) * self.normal[:, axis] > .5
        else:
            seen = ((listener - self.centre) * self.normal).sum(1) > 0
        return seen, numpy.linalg.norm(listener - self.centre[seen], axis=1)

    def pressure_per_force(self, listener, s):
        """[Pa/N] at complex rates s, the shortest path's delay taken out."""
        seen, distance = self.radiating(listener)
        share = AIR * self.area[seen] / (2 * numpy.pi * distance)
        shapes = numpy.einsum("ktvd,td->kt", self.phi[:, self.tri[seen]], self.normal[seen]) / 3
        motion = self.linear + numpy.cross(self.angular, self.centre[seen] - self.com)
        sources = numpy.vstack([shapes, (motion * self.normal[seen]).sum(1)]) * share
        # Delays in 64ths of a microsecond-sized cell: far finer than any wave.
        cell = 1 / (48000 * 64)
        late = (distance - distance.min()) / SPEED_OF_SOUND / cell
        left = late.astype(int)
        binned = numpy.array([numpy.bincount(left, row * (1 - late + left), left.max() + 2)
                              + numpy.bincount(left + 1, row * (late - left), left.max() + 2)
                              for row in sources])
        time = numpy.arange(binned.shape[1]) * cell
        out = numpy.zeros(len(s), complex)
        for i in range(0, len(s), 1024):
            part = s[i:i + 1024]
            arrived = binned @ numpy.exp(-numpy.outer(time, part))
            swing = part ** 2 / ((part - self.rate[:, None]) * (part - self.rate.conj()[:, None]))
            out[i:i + 1024] = (self.b[:, None] * arrived[:-1] * swing).sum(0) + arrived[-1]
        return out

    def strike(self, mass, radius, young, poisson, speed, rate, steps):
        """Force of a ball's contact in steps of 1/(rate steps) s (Hertz, trapezoidal rule)."""
        modulus = 1 / ((1 - poisson ** 2) / young
                       + (1 - self.material["nu"] ** 2) / self.material["E"])
        stiffness = 4 / 3 * modulus * radius ** .5
        h, omega = 1 / (rate * steps), self.rate.imag
        pole = numpy.exp(self.rate * h)
        push = self.b * (pole - 1) / self.rate
        mobility = -(self.linear + numpy.cross(self.angular, self.at - self.com)) @ self.out
        yields = (self.b * push.imag / omega).sum() + (mobility + 1 / mass) * h * h / 2
        z, rigid, rigid_speed, ball, forces, apart = 0 * pole, 0., 0., 0., [], 0
        while apart < 96 * steps and len(forces) < .2 / h:
            before = ball - rigid - (self.b * z.imag / omega).sum()
            z *= pole
            free = ball + h * speed - rigid - h * rigid_speed - (self.b * z.imag / omega).sum()
            force = 0.
            for _ in range(6):
                force = stiffness * max((free - yields * force + before) / 2, 0.) ** 1.5
            z += push * force
            rigid += h * rigid_speed + mobility * force * h * h / 2
            rigid_speed += mobility * force * h
            ball += h * speed - force * h * h / 2 / mass
            speed -= force * h / mass
            forces.append(force)
            apart = apart + 1 if force < 1e-9 else 0
        return numpy.array(forces[:numpy.flatnonzero(forces)[-1] + 1]), h


def transform(values, step, s):
    """Laplace transform of values that hold for a step each, at the rates of line(): their
    spacing is a whole part of 2 pi / step, so that a long FFT has them all."""
    spacing = (s[1] - s[0]).imag
    size, first = round(2 * numpy.pi / (spacing * step)), round(s[0].imag / spacing)
    assert abs(size * spacing * step / (2 * numpy.pi) - 1) < 1e-9 and len(values) <= size
    window = numpy.exp(-s[0].real * (numpy.arange(len(values)) + .5) * step)
    found = numpy.fft.rfft(values * window, size)[first:first + len(s)]
    return found * numpy.exp(-.5j * s.imag * step) * numpy.sinh(s * step / 2) / (s / 2)


def line(samples, rate, beta):
    """Rates s from 17.5 Hz to 20 kHz on the line of the window, and what numpy's FFT gives there."""
    size = 1 << (samples - 1).bit_length()
    f = numpy.arange(size // 2 + 1) * rate / size
    chosen = (f >= 17.5) & (f <= 20000)
    return beta + 2j * numpy.pi * f[chosen], chosen, size


def spectrum(sound, rate, beta):
    """Laplace transform of a sound on the line, its first sample at time 0."""
    _, chosen, size = line(len(sound), rate, beta)
    window = numpy.exp(-beta * numpy.arange(len(sound)) / rate)
    return numpy.fft.rfft(sound * window, size)[chosen] / rate


def third_octaves(f, values):
    """Levels in dB of the bands around 20 Hz 2^(n/3), and their middles."""
    middles = 20 * 2 ** (numpy.arange(30) / 3)
    return numpy.array([10 * numpy.log10((abs(values[(f >= m * 2 ** (-1 / 6))
                                                     & (f < m * 2 ** (1 / 6))]) ** 2).sum())
                        for m in middles])
