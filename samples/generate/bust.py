"""A bust on a plinth: an implicit head of smoothly joined ellipsoids and capsules, meshed by surface nets.

The head looks towards +z; its local frame has the origin between the ears. The mesh is finer where the face is.
"""

from math import atan2, sqrt, sin

from generate.shapes import Model, is_closed, lathe, move, rounded_box

PLINTH_HEIGHT = 1.0
HEAD_HEIGHT = PLINTH_HEIGHT + 0.475  # of the local origin above the floor


# ---- distances (approximate where shapes are stretched; only the zero set and the gradient matter) ------------------


def ellipsoid(p, centre, radii):
    x, y, z = ((p[k] - centre[k]) / radii[k] for k in range(3))
    k0 = sqrt(x * x + y * y + z * z)
    x, y, z = x / radii[0], y / radii[1], z / radii[2]
    k1 = sqrt(x * x + y * y + z * z)
    return k0 * (k0 - 1) / k1 if k1 > 1e-12 else -min(radii)


def capsule(p, a, b, radius_a, radius_b):
    ab = (b[0] - a[0], b[1] - a[1], b[2] - a[2])
    ap = (p[0] - a[0], p[1] - a[1], p[2] - a[2])
    t = (ap[0] * ab[0] + ap[1] * ab[1] + ap[2] * ab[2]) / (ab[0] ** 2 + ab[1] ** 2 + ab[2] ** 2)
    t = max(0.0, min(1.0, t))
    d = (ap[0] - t * ab[0], ap[1] - t * ab[1], ap[2] - t * ab[2])
    return sqrt(d[0] * d[0] + d[1] * d[1] + d[2] * d[2]) - radius_a - t * (radius_b - radius_a)


def union(a, b, k):
    h = max(0.0, k - abs(a - b)) / k
    return min(a, b) - h * h * k / 4


def carve(a, b, k):
    """a without b, the edge rounded over k."""
    return -union(-a, b, k)


def common(a, b, k):
    return -union(-a, -b, k)


# ---- the head ----------------------------------------------------------------------------------------------------


def face(p):
    """Skull, jaw and features; x mirrored, so both halves are alike."""
    x, y, z = p
    q = (abs(x), y, z)
    d = ellipsoid(q, (0, 0.040, -0.018), (0.080, 0.092, 0.100))
    d = union(d, ellipsoid(q, (0, -0.038, 0.022), (0.062, 0.092, 0.070)), 0.05)
    d = union(d, ellipsoid(q, (0, -0.108, 0.066), (0.026, 0.020, 0.020)), 0.035)             # chin
    d = union(d, capsule(q, (0.060, -0.030, -0.005), (0.026, -0.102, 0.052), 0.020, 0.015), 0.03)  # jaw line
    d = union(d, ellipsoid(q, (0.040, -0.018, 0.062), (0.024, 0.018, 0.018)), 0.03)          # cheekbone
    d = carve(d, ellipsoid(q, (0.032, 0.012, 0.106), (0.024, 0.015, 0.021)), 0.022)          # eye socket
    d = union(d, capsule(q, (0.012, 0.029, 0.089), (0.047, 0.031, 0.073), 0.0065, 0.005), 0.016)  # brow
    d = union(d, ellipsoid(q, (0.031, 0.011, 0.0735), (0.0165, 0.0155, 0.0155)), 0.007)      # eyeball
    d = union(d, capsule(q, (0.018, 0.0175, 0.0885), (0.044, 0.0165, 0.0785), 0.0035, 0.003), 0.012)  # upper lid
    d = union(d, capsule(q, (0.019, 0.003, 0.087), (0.042, 0.003, 0.0785), 0.0028, 0.0025), 0.012)   # lower lid
    d = union(d, capsule(q, (0, 0.026, 0.091), (0, -0.026, 0.113), 0.0068, 0.0095), 0.016)   # nose
    d = union(d, ellipsoid(q, (0, -0.031, 0.1135), (0.0105, 0.009, 0.010)), 0.008)           # its tip
    d = union(d, ellipsoid(q, (0.0125, -0.034, 0.101), (0.0075, 0.0075, 0.0095)), 0.006)     # its wings
    d = union(d, ellipsoid(q, (0, -0.068, 0.083), (0.030, 0.022, 0.016)), 0.02)              # around the mouth
    d = union(d, capsule(q, (0.004, -0.0595, 0.0985), (0.024, -0.0675, 0.0875), 0.0052, 0.002), 0.006)  # upper lip
    d = union(d, capsule(q, (0, -0.0755, 0.0955), (0.019, -0.071, 0.0885), 0.0062, 0.003), 0.006)    # lower lip
    d = carve(d, capsule(q, (0, -0.067, 0.1035), (0.027, -0.0695, 0.0895), 0.0012, 0.0010), 0.005)   # between them
    d = carve(d, ellipsoid(q, (0, -0.087, 0.1005), (0.018, 0.0065, 0.008)), 0.012)           # under the lip
    return d


def ear(p):
    q = (abs(p[0]), p[1], p[2])
    d = ellipsoid(q, (0.083, -0.006, -0.012), (0.0085, 0.032, 0.019))
    return carve(d, ellipsoid(q, (0.093, -0.002, -0.009), (0.007, 0.020, 0.010)), 0.006)


def hair(p):
    """Combed back from the brow into a knot; the strands are ripples along the combing."""
    x, y, z = p
    strand = 0.0036 * sin(24 * atan2(abs(x), 0.02 + y - 0.25 * z + 0.06))
    cap = ellipsoid(p, (0, 0.048, -0.027), (0.095, 0.104, 0.115)) - strand
    hairline = 0.82 * (z - 0.050) - 0.57 * (y - 0.056) + 2.5 * x * x   # > 0 in front of it
    below = -(y + 0.052) - 0.35 * z                                      # > 0 below the nape
    cap = common(common(cap, hairline, 0.008), below, 0.02)
    kx, ky, kz = x, y - 0.062, z + 0.150
    swirl = 0.003 * sin(3 * atan2(kx, ky) + 240 * sqrt(kx * kx + ky * ky))
    knot = ellipsoid(p, (0, 0.062, -0.150), (0.046, 0.044, 0.036)) - swirl
    return union(cap, knot, 0.012)


def chest(p):
    """Neck, shoulders cut like an antique bust."""
    q = (abs(p[0]), p[1] - 0.035, p[2])
    d = capsule(q, (0, -0.10, -0.036), (0, -0.235, -0.046), 0.047, 0.055)
    d = union(d, capsule(q, (0.040, -0.110, -0.020), (0.010, -0.236, 0.014), 0.009, 0.010), 0.03)  # neck muscles
    body = ellipsoid(q, (0, -0.345, -0.045), (0.185, 0.095, 0.085))
    body = union(body, ellipsoid(q, (0.150, -0.300, -0.045), (0.062, 0.056, 0.060)), 0.06)          # shoulders
    body = union(body, ellipsoid(q, (0.065, -0.385, 0.010), (0.080, 0.080, 0.062)), 0.06)           # breast
    body = union(body, capsule(q, (0.018, -0.262, 0.022), (0.130, -0.254, 0.000), 0.009, 0.008), 0.03)  # collar bones
    d = union(d, body, 0.075)
    return common(d, ellipsoid(q, (0, -0.255, -0.030), (0.192, 0.190, 0.20)), 0.02)


def turned(p):
    """The head looks a little to its left and down."""
    x, y, z = p
    y += 0.10
    c, s = 0.9563, 0.2924   # 17 degrees
    x, z = c * x - s * z, s * x + c * z
    c, s = 0.9976, 0.0698   # 4 degrees
    y, z = c * y + s * z, -s * y + c * z
    return (x, y - 0.10, z)


def distance(p):
    """Metres, negative inside."""
    if p[1] < -0.30:
        return chest(p)
    h = turned(p)
    head = union(face(h), ear(h), 0.006)
    head = union(head, hair(h), 0.004)
    return union(head, chest(p), 0.018)


# ---- surface nets ------------------------------------------------------------------------------------------------


def graded(stops):
    """Grid lines from (position, cell size) stops; the size changes linearly between stops."""
    lines = [stops[0][0]]
    for (a, size_a), (b, size_b) in zip(stops, stops[1:]):
        at = [a]
        while at[-1] < b:
            t = (at[-1] - a) / (b - a)
            at.append(at[-1] + size_a + (size_b - size_a) * t)
        lines += [a + (v - a) * (b - a) / (at[-1] - a) for v in at[1:]]
    return lines


FINE, COARSE = 0.0062, 0.0140
XS = graded([(-0.215, COARSE), (-0.10, FINE * 1.4), (-0.05, FINE), (0.09, FINE), (0.12, FINE * 1.4), (0.215, COARSE)])
YS = graded([(-0.47, COARSE), (-0.20, COARSE), (-0.13, FINE), (0.05, FINE), (0.165, FINE * 1.5)])
ZS = graded([(-0.215, FINE * 1.7), (0.0, FINE * 1.7), (0.05, FINE), (0.145, FINE)])
BLOCK = 4           # cells; a block is sampled only where its middle is near the surface
SLACK = 1.6         # the distances are approximate: near means within this many block radii


def sample_near_surface():
    """{(i, j, k): distance} at all corners of the blocks that the surface may cross."""
    values = {}
    for i in range(0, len(XS) - 1, BLOCK):
        for j in range(0, len(YS) - 1, BLOCK):
            for k in range(0, len(ZS) - 1, BLOCK):
                ends = [(axis[m], axis[min(m + BLOCK, len(axis) - 1)]) for axis, m in ((XS, i), (YS, j), (ZS, k))]
                middle = tuple((a + b) / 2 for a, b in ends)
                radius = sqrt(sum((b - a) ** 2 for a, b in ends)) / 2
                if abs(distance(middle)) > SLACK * radius:
                    continue
                for a in range(i, min(i + BLOCK, len(XS) - 1) + 1):
                    for b in range(j, min(j + BLOCK, len(YS) - 1) + 1):
                        for c in range(k, min(k + BLOCK, len(ZS) - 1) + 1):
                            if (a, b, c) not in values:
                                values[a, b, c] = distance((XS[a], YS[b], ZS[c]))
    return values


def onto_surface(p, cell):
    """Two Newton steps along the gradient, kept well inside the cell so that no two points meet."""
    step = 1e-4
    for _ in range(2):
        d = distance(p)
        gradient = [(distance(tuple(c + step * (m == axis) for m, c in enumerate(p))) - d) / step for axis in range(3)]
        size = sum(g * g for g in gradient)
        if size > 1e-6:
            p = tuple(c - d * g / size for c, g in zip(p, gradient))
    kept = []
    for c, lines, m in zip(p, (XS, YS, ZS), cell):
        margin = 0.05 * (lines[m + 1] - lines[m])
        kept.append(max(lines[m] + margin, min(lines[m + 1] - margin, c)))
    return tuple(kept)


CORNERS = [(a, b, c) for a in (0, 1) for b in (0, 1) for c in (0, 1)]
CELL_EDGES = [(p, q) for p in CORNERS for q in CORNERS if p < q and sum(a != b for a, b in zip(p, q)) == 1]


def sheets_of(cell, values):
    """{inside corner: sheet}: inside corners that cell edges connect are behind the same sheet of the surface."""
    inside = [c for c in CORNERS if values[tuple(a + b for a, b in zip(cell, c))] < 0]
    sheet = {c: c for c in inside}
    for _ in inside:
        for p, q in CELL_EDGES:
            if p in sheet and q in sheet:
                sheet[p] = sheet[q] = min(sheet[p], sheet[q])
    return sheet


def surface_net():
    """One point per cell and sheet of the surface in it, one quad per grid edge that the surface crosses."""
    values = sample_near_surface()
    points, triangles, cells = [], [], {}

    def corner(grid_corner):
        return tuple(lines[m] for lines, m in zip((XS, YS, ZS), grid_corner))

    def make_points(cell):
        sheet = sheets_of(cell, values)
        crossings = {}
        for p, q in CELL_EDGES:
            if (p in sheet) == (q in sheet):
                continue
            a, b = (tuple(m + n for m, n in zip(cell, c)) for c in (p, q))
            t = values[a] / (values[a] - values[b])
            crossings.setdefault(sheet[p if p in sheet else q], []).append(
                tuple(u + (v - u) * t for u, v in zip(corner(a), corner(b))))
        index = {}
        for name, met in sorted(crossings.items()):
            index[name] = len(points)
            points.append(onto_surface(tuple(sum(c) / len(met) for c in zip(*met)), cell))
        return {c: index[s] for c, s in sheet.items()}

    def point_of(cell, inside_corner):
        if cell not in cells:
            cells[cell] = make_points(cell)
        return cells[cell][tuple(a - b for a, b in zip(inside_corner, cell))]

    for (i, j, k), here in sorted(values.items()):
        for axis in range(3):
            end = tuple(c + (m == axis) for m, c in enumerate((i, j, k)))
            there = values.get(end)
            if there is None or (here < 0) == (there < 0):
                continue
            quad = []
            for u, v in ((-1, -1), (0, -1), (0, 0), (-1, 0)):
                cell = [i, j, k]
                cell[(axis + 1) % 3] += u
                cell[(axis + 2) % 3] += v
                quad.append(point_of(tuple(cell), (i, j, k) if here < 0 else end))
            if here >= 0:
                quad.reverse()
            triangles += split(points, quad)
    return points, triangles


def split(points, quad):
    """Along the shorter diagonal."""
    a, b, c, d = quad

    def length(m, n):
        return sum((p - q) ** 2 for p, q in zip(points[m], points[n]))

    return [(a, b, c), (a, c, d)] if length(a, c) <= length(b, d) else [(a, b, d), (b, c, d)]


# ---- the object --------------------------------------------------------------------------------------------------


def bust():
    model = Model()
    head = surface_net()
    assert is_closed(head), "the net has a pinch: change FINE a little"
    model.add("marble", move(head, 0, HEAD_HEIGHT, 0.03))
    socle = [(0, 0), (0.085, 0), (0.088, 0.012), (0.07, 0.022), (0.052, 0.045), (0.05, 0.06), (0.07, 0.078), (0.07, 0.10), (0, 0.10)]
    model.add("marble", move(lathe(socle, 36), 0, PLINTH_HEIGHT - 0.004, -0.005))
    model.add("stone", rounded_box((-0.15, 0.06 - 0.004, -0.15), (0.15, PLINTH_HEIGHT - 0.04, 0.15), 0.006, 1, (4, 12, 4)))
    model.add("stone", rounded_box((-0.18, 0.0, -0.18), (0.18, 0.06, 0.18), 0.010, 2, (4, 1, 4)))
    model.add("stone", rounded_box((-0.175, PLINTH_HEIGHT - 0.044, -0.175), (0.175, PLINTH_HEIGHT, 0.175), 0.010, 2, (4, 1, 4)))
    return model
