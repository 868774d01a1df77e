"""Shapes as (points, triangles), their arithmetic, and the OBJ writer. Metres, y up, fronts counter-clockwise.

Everything is one idea: a grid of points, welded where points coincide. A box is six grids, a lathe or a tube is one grid
whose seam and poles weld. So every closed shape is closed by construction and wound outward.
"""

from math import cos, pi, radians, sin, sqrt, tan

WELD = 1e-6  # metres; points closer than this are one point


def add(a, b):
    return (a[0] + b[0], a[1] + b[1], a[2] + b[2])


def sub(a, b):
    return (a[0] - b[0], a[1] - b[1], a[2] - b[2])


def scaled(a, s):
    return (a[0] * s, a[1] * s, a[2] * s)


def dot(a, b):
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


def cross(a, b):
    return (a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0])


def unit(a):
    return scaled(a, 1 / sqrt(dot(a, a)))


def mix(a, b, t):
    return tuple(p + (q - p) * t for p, q in zip(a, b))


def steps(lo, hi, count):
    """count + 1 evenly spaced numbers from lo to hi, both included exactly."""
    return [lo + (hi - lo) * i / count for i in range(count)] + [hi]


# ---- shapes -------------------------------------------------------------------------------------------------------


def weld(points, triangles):
    """Merges coincident points and drops the triangles that lose their area by it."""
    index_of, kept, renamed = {}, [], []
    for p in points:
        key = tuple(round(c / WELD) for c in p)
        if key not in index_of:
            index_of[key] = len(kept)
            kept.append(p)
        renamed.append(index_of[key])
    merged = [tuple(renamed[i] for i in t) for t in triangles]
    return kept, [t for t in merged if len(set(t)) == 3]


def join(*shapes):
    points, triangles = [], []
    for shape_points, shape_triangles in shapes:
        base = len(points)
        points += shape_points
        triangles += [(a + base, b + base, c + base) for a, b, c in shape_triangles]
    return weld(points, triangles)


def grid(us, vs, point):
    """Points point(u, v); the front is where (d/du) x (d/dv) points."""
    points = [point(u, v) for u in us for v in vs]
    triangles = []
    for i in range(len(us) - 1):
        for j in range(len(vs) - 1):
            a, b = i * len(vs) + j, (i + 1) * len(vs) + j
            triangles += [(a, b, b + 1), (a, b + 1, a + 1)]
    return weld(points, triangles)


def block(xs, ys, zs):
    """A closed box with the given grid lines along each axis."""
    x0, x1, y0, y1, z0, z1 = xs[0], xs[-1], ys[0], ys[-1], zs[0], zs[-1]
    return join(
        grid(ys, zs, lambda y, z: (x1, y, z)), grid(zs, ys, lambda z, y: (x0, y, z)),
        grid(zs, xs, lambda z, x: (x, y1, z)), grid(xs, zs, lambda x, z: (x, y0, z)),
        grid(xs, ys, lambda x, y: (x, y, z1)), grid(ys, xs, lambda y, x: (x, y, z0)))


def box(lo, hi, divisions=(1, 1, 1)):
    return block(*(steps(a, b, n) for a, b, n in zip(lo, hi, divisions)))


def rounded_box(lo, hi, radius, arc=3, divisions=(1, 1, 1)):
    """A closed box with all edges rounded: a divided cube whose rim is bent onto quarter circles."""
    def lines(n):
        return steps(-2, -1, arc)[:-1] + steps(-1, 1, n) + steps(1, 2, arc)[1:]

    def bend(p):
        core, rim = [], []
        for c, a, b in zip(p, lo, hi):
            inner = max(-1, min(1, c))
            core.append((a + b) / 2 + inner * ((b - a) / 2 - radius))
            rim.append(tan((c - inner) * pi / 4))
        return add(core, scaled(unit(rim), radius))

    return warp(block(*(lines(n) for n in divisions)), bend)


def lathe(profile, sides):
    """Turns (radius, height) points around the y axis. Runs up on the outside; from axis to axis, or a closed loop."""
    angles = range(sides + 1)

    def point(k, j):
        radius, y = profile[k]
        angle = 2 * pi * (j % sides) / sides
        return (radius * cos(angle), y, radius * sin(angle))

    return grid(range(len(profile)), angles, point)


def ball(radius, rings, sides):
    return lathe([(radius * sin(pi * k / rings) if 0 < k < rings else 0.0, -radius * cos(pi * k / rings))
                  for k in range(rings + 1)], sides)


def tube(path, radii, sides):
    """A closed tube of flat ends along the points of a path; one radius for all or one per point."""
    if not isinstance(radii, (list, tuple)):
        radii = [radii] * len(path)
    frames = []
    normal = None
    for k in range(len(path)):
        tangent = unit(sub(path[min(k + 1, len(path) - 1)], path[max(k - 1, 0)]))
        if normal is None:
            normal = (1, 0, 0) if abs(tangent[0]) < 0.7 else (0, 1, 0)
        normal = unit(sub(normal, scaled(tangent, dot(tangent, normal))))
        frames.append((normal, cross(normal, tangent)))
    rings = [(path[0], 0.0, frames[0])] + list(zip(path, radii, frames)) + [(path[-1], 0.0, frames[-1])]

    def point(k, j):
        centre, radius, (n, b) = rings[k]
        angle = 2 * pi * (j % sides) / sides
        return add(centre, add(scaled(n, radius * cos(angle)), scaled(b, radius * sin(angle))))

    return grid(range(len(rings)), range(sides + 1), point)


def curve(control, count):
    """count + 1 points on the Catmull-Rom curve through the control points."""
    padded = [sub(scaled(control[0], 2), control[1])] + list(control) + [sub(scaled(control[-1], 2), control[-2])]
    spans = len(control) - 1
    points = []
    for k in range(count + 1):
        s = k * spans / count
        i = min(int(s), spans - 1)
        t = s - i
        weights = (-t + 2 * t * t - t ** 3, 2 - 5 * t * t + 3 * t ** 3, t + 4 * t * t - 3 * t ** 3, t ** 3 - t * t)
        points.append(tuple(sum(w * padded[i + m][c] for m, w in enumerate(weights)) / 2 for c in range(3)))
    return points


def is_closed(shape):
    """Every edge is run once in each direction: closed, manifold, consistently wound."""
    edges = [(t[k], t[(k + 1) % 3]) for t in shape[1] for k in range(3)]
    present = set(edges)
    return len(present) == len(edges) and all((b, a) in present for a, b in edges)


# ---- placing ------------------------------------------------------------------------------------------------------


def warp(shape, function):
    return [function(p) for p in shape[0]], shape[1]


def move(shape, x, y, z):
    return warp(shape, lambda p: (p[0] + x, p[1] + y, p[2] + z))


def stretch(shape, x, y, z):
    return warp(shape, lambda p: (p[0] * x, p[1] * y, p[2] * z))


def turn(shape, axis, degrees):
    """Right-handed rotation about the axis 'x', 'y' or 'z' through the origin."""
    c, s = cos(radians(degrees)), sin(radians(degrees))
    return warp(shape, {
        "x": lambda p: (p[0], c * p[1] - s * p[2], s * p[1] + c * p[2]),
        "y": lambda p: (c * p[0] + s * p[2], p[1], c * p[2] - s * p[0]),
        "z": lambda p: (c * p[0] - s * p[1], s * p[0] + c * p[1], p[2]),
    }[axis])


# ---- models -------------------------------------------------------------------------------------------------------


class Model:
    """Shapes with their materials, in the order added."""

    def __init__(self):
        self.pieces = []  # (material, points, triangles)

    def add(self, material, *shapes):
        for points, triangles in shapes:
            self.pieces.append((material, points, triangles))

    def add_by(self, material_of, shape):
        """One shape of several materials; material_of(centre of a triangle) names each triangle's."""
        points, triangles = shape
        by_material = {}
        for t in triangles:
            centre = scaled(add(points[t[0]], add(points[t[1]], points[t[2]])), 1 / 3)
            by_material.setdefault(material_of(centre), []).append(t)
        shared = points
        for material in sorted(by_material):
            self.pieces.append((material, shared, by_material[material]))

    def obj_text(self, title, material_file):
        """Points that pieces share (the same list) are written once, so that materials meet without a crack."""
        lines = [f"# {title}", f"mtllib {material_file}"]
        base_of, written, material_now = {}, 0, None
        for material, points, triangles in self.pieces:
            if id(points) not in base_of:
                base_of[id(points)] = written + 1
                written += len(points)
                lines += ["v " + " ".join(f"{c + 0.0:.5f}" for c in p) for p in points]
            if material != material_now:
                lines.append(f"usemtl {material}")
                material_now = material
            base = base_of[id(points)]
            lines += [f"f {a + base} {b + base} {c + base}" for a, b, c in triangles]
        return "\n".join(lines).replace("-0.00000", "0.00000") + "\n"
