"""Parts of ./play design: tables of part_stress, shapes made from them, and a program that solves the shapes again."""
import struct
import subprocess

import numpy
from harness import stage_folder

MAGIC, SOLVE, READY, STRESS = 0x31525354, 1, 16, 17  # docs/formats/serve.md
PCG, NEW_FACTOR = 1, 2


class Part:
    """A table and its shapes. Parameters are displacements of coordinates of control points, m. A handle is the set of
    control points of all layers at one x and y, which patches/design drags together."""

    def __init__(self, name, layer):
        self.path = stage_folder() / f"{name}.stress.npz"
        if not self.path.is_file():
            raise RuntimeError(f"{self.path}: file not found: build the finite-element programs first")
        table = numpy.load(self.path)
        self.stress, self.slope = table["s0"].astype(float), table["S"].astype(float)
        self.weights = table["weights"] / table["weights"].sum()
        self.points = table["control_points"]
        self.nodes, self.triangles = table["surface_nodes"], table["surface_triangles"]
        self.node_element, self.node_weights = table["surface_node_element"], table["surface_weights"].astype(float)
        rows = table["parameters"]
        self.control, self.axis = rows[:, 0].astype(int), rows[:, 1].astype(int)
        self.layer = layer
        self.coordinates = sorted({(c % layer, a) for c, a in zip(self.control, self.axis)})
        self.handles = sorted({c for c, _ in self.coordinates})
        # parameters = spread @ coordinates of handles
        self.spread = numpy.array([[(c % layer, a) == one for one in self.coordinates]
                                   for c, a in zip(self.control, self.axis)], float)

    def displaced(self, handle, by):
        """Parameters with one handle displaced by x, y."""
        return numpy.array([by[a] if c % self.layer == handle and a < 2 else 0.0
                            for c, a in zip(self.control, self.axis)])

    def taylor(self, parameters):
        return self.stress + parameters @ self.slope

    def skin(self, parameters):
        nodes = self.nodes.copy()
        for c, a, d in zip(self.control, self.axis, parameters):
            nodes[:, a] += self.node_weights[:, c] * d
        return nodes

    def volume(self, parameters):
        """Volume of the drawn skin, by the divergence theorem."""
        a, b, c = (self.skin(parameters)[self.triangles[:, k]] for k in range(3))
        return float((a * numpy.cross(b, c)).sum() / 6)

    def seen(self):
        """Triangles of the side view that the patches show, the farthest first."""
        first = self.nodes[self.triangles]
        normals = numpy.cross(first[:, 1] - first[:, 0], first[:, 2] - first[:, 0])
        seen = numpy.flatnonzero(normals[:, 2] > 1e-3 * numpy.linalg.norm(normals, axis=1))
        return self.triangles[seen[numpy.argsort(first[seen, :, 2].sum(1), kind="stable")]]

    def face_stress(self, stress):
        """Stress of the visible faces, Pa: means of their corners."""
        return stress[self.node_element[self.seen()]].mean(1)

    def outline(self):
        """Outline of the first shape in the side view: edges of faces, (n, 2, 2) mm, with no face on the
        other side."""
        corners = 1000 * self.nodes[self.seen()][:, :, :2]
        begin, end = corners.reshape(-1, 2), numpy.roll(corners, -1, axis=1).reshape(-1, 2)
        along = (end - begin) / numpy.linalg.norm(end - begin, axis=1)[:, None]
        beyond = (begin + end) / 2 + 0.2 * along[:, ::-1] * (1, -1)  # faces lie to the left of their sides
        inside = numpy.ones((len(beyond), len(corners)), bool)
        for k in range(3):
            a, b = corners[:, k], corners[:, (k + 1) % 3]
            inside &= (b - a)[:, 0] * (beyond[:, None, 1] - a[:, 1]) > (b - a)[:, 1] * (beyond[:, None, 0] - a[:, 0])
        return numpy.stack([begin, end], axis=1)[~inside.any(1)]

    def draw(self, axes, parameters, stress, scale):
        """Draws the side view, in mm and MPa, with the outline of the first shape. Returns the collection of its faces,
        for a colour bar."""
        from matplotlib.collections import LineCollection, PolyCollection
        seen = self.seen()
        colours = PolyCollection(1000 * self.skin(parameters)[seen][:, :, :2], cmap="turbo", edgecolors="face",
                                 linewidths=0.3, array=1e-6 * self.face_stress(stress), clim=(0, 1e-6 * scale))
        axes.add_collection(colours)
        axes.add_collection(LineCollection(self.outline(), colors="black", linewidths=0.6))
        axes.set_aspect("equal")
        axes.autoscale()
        return colours

    def solver(self):
        return Solver(self)


class Solver:
    """part_stress serve: von Mises stress of the elements at other shapes, by PCG to 1e-8."""

    def __init__(self, part):
        program = stage_folder().parent / "programs" / "part_stress" / "part_stress"
        self.part = part
        self.process = subprocess.Popen([program, "serve", part.path], stdin=subprocess.PIPE, stdout=subprocess.PIPE)

    def __enter__(self):
        self._read(READY)
        return self

    def __exit__(self, *_):
        self.process.stdin.close()
        self.process.wait(60)

    def _read(self, wanted):
        magic, kind, size = struct.unpack("<IIQ", self.process.stdout.read(16))
        payload = self.process.stdout.read(size)
        if magic != MAGIC or kind != wanted:
            raise RuntimeError(f"part_stress serve: {payload[:200]!r}")
        return payload

    def _ask(self, method, flags, parameters):
        """Payload of the answer, or None if the mesh cannot have that shape, and the duration in seconds."""
        request = struct.pack("<II", method, flags) + numpy.asarray(parameters, "<f8").tobytes()
        self.process.stdin.write(struct.pack("<IIQ", MAGIC, SOLVE, len(request)) + request)
        self.process.stdin.flush()
        payload = self._read(STRESS)
        _, _, seconds, fraction, _ = struct.unpack_from("<IIddd", payload)
        return (payload if fraction == 1 else None), seconds

    def _floats(self, payload, begin, *shape):
        """Arrays of the answer; `begin` counts arrays of elements' stresses."""
        count = len(self.part.stress)
        offset = 32 + 8 * len(self.part.control) + 4 * count * begin
        return numpy.frombuffer(payload, "<f4", int(numpy.prod(shape)), offset).reshape(shape).astype(float)

    def solve(self, parameters):
        """(stress in Pa, seconds) by conjugate gradients. Raises an error if the mesh cannot have that shape."""
        payload, seconds = self._ask(PCG, 0, parameters)
        if payload is None:
            raise RuntimeError("the mesh would be too distorted in this shape")
        return self._floats(payload, 0, len(self.part.stress)), seconds

    def linearised(self, parameters):
        """(stress in Pa, its derivatives in Pa/m of shape (parameters, elements)) at a shape, by a new factor; None if
        the mesh cannot reach it."""
        payload, _ = self._ask(NEW_FACTOR, 1, parameters)
        if payload is None:
            return None
        count = len(self.part.stress)
        return self._floats(payload, 0, count), self._floats(payload, 2, len(parameters), count)
