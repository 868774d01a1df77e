#!/usr/bin/env python3
"""View factors at the sizes of other programs' benchmarks: user seconds, error, memory.

    factors.py RRO_COMPILE RRO_SOLVE FOLDER [CASE ...]

Cases: cube3456 (a unit cube of 3,456 faces, a group each), obstructed696 (600 faces of a cube and 96 of a box in it, a
group each), far26m (two spheres of 5,120 triangles side by side: 26 million pairs of triangles, nothing between),
obstructed15k (three spheres of 5,120 triangles, the middle one hides part of the others), hall (128 tiles of floor and
ceiling and 25 boxes between them), hall_moved (one of the boxes moved, what has not changed taken from the case before).
Only if named: cube10000 (faces of a cube, a group each, nothing between), obstructed10000 (9,600 faces of a cube and 384 of
four boxes in it), which write factors of 1e-5 and more, and obstructed60k (as obstructed15k, of 20,480 triangles). One thread.
"""
import csv, json, math, os, re, resource, subprocess, sys

compile_, solve, folder = sys.argv[1:4]
os.makedirs(folder, exist_ok=True)


def path(name):
    return os.path.join(folder, name)


def write_obj(name, corners, faces):
    with open(path(name + ".obj"), "w") as f:
        f.writelines("v %.9g %.9g %.9g\n" % tuple(v) for v in corners)
        f.writelines("f %s\n" % " ".join(str(i + 1) for i in face) for face in faces)
    subprocess.check_call([compile_, "build", path(name + ".obj"), "--two-sided", "no", "--out", path(name + ".rro"), "--quiet"])


def sphere(level):
    """A unit icosahedron quartered `level` times."""
    g = (1 + 5 ** .5) / 2
    V = [(-1, g, 0), (1, g, 0), (-1, -g, 0), (1, -g, 0), (0, -1, g), (0, 1, g), (0, -1, -g), (0, 1, -g), (g, 0, -1), (g, 0, 1), (-g, 0, -1), (-g, 0, 1)]
    F = [(0, 11, 5), (0, 5, 1), (0, 1, 7), (0, 7, 10), (0, 10, 11), (1, 5, 9), (5, 11, 4), (11, 10, 2), (10, 7, 6), (7, 1, 8),
         (3, 9, 4), (3, 4, 2), (3, 2, 6), (3, 6, 8), (3, 8, 9), (4, 9, 5), (2, 4, 11), (6, 2, 10), (8, 6, 7), (9, 8, 1)]
    unit = lambda v: tuple(x / math.sqrt(sum(y * y for y in v)) for x in v)
    V = [unit(v) for v in V]
    for _ in range(level):
        known, finer = {}, []
        def middle(a, b):
            key = (min(a, b), max(a, b))
            if key not in known:
                known[key] = len(V)
                V.append(unit([x + y for x, y in zip(V[a], V[b])]))
            return known[key]
        for a, b, c in F:
            x, y, z = middle(a, b), middle(b, c), middle(c, a)
            finer += [(a, x, z), (x, b, y), (z, y, c), (x, y, z)]
        F = finer
    return V, F


def box_faces(lo, size, n, inward, name):
    """Instances of the unit square that make up a box, n x n on each side."""
    sides = [((0, 0, 0), (1, 0, 0), (0, 1, 0)), ((0, 0, 1), (0, 1, 0), (1, 0, 0)), ((0, 0, 0), (0, 1, 0), (0, 0, 1)),
             ((1, 0, 0), (0, 0, 1), (0, 1, 0)), ((0, 0, 0), (0, 0, 1), (1, 0, 0)), ((0, 1, 0), (1, 0, 0), (0, 0, 1))]
    out = []
    for s, (o, u, v) in enumerate(sides):
        if not inward:
            u, v = v, u
        a, b = [size * x / n for x in u], [size * x / n for x in v]
        w = [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
        for i in range(n):
            for j in range(n):
                p = [lo + size * o[k] + a[k] * i + b[k] * j for k in range(3)]
                rows = [[a[k], b[k], w[k], p[k]] for k in range(3)]
                out.append({"name": "%s%d.%d.%d" % (name, s, i, j), "archive": "square.rro", "transform": {"matrix": sum(rows, []) + [0, 0, 0, 1]}})
    return out


def hall(moved):
    """Tiles of floor and ceiling of a hall of 8 m, and boxes in between, one of which may have been moved."""
    def tile(name, x, y, z, u, v):
        w = [u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]]
        rows = [[u[k], v[k], w[k], (x, y, z)[k]] for k in range(3)]
        return {"name": name, "archive": "square.rro", "transform": {"matrix": sum(rows, []) + [0, 0, 0, 1]}}
    out = []
    for i in range(8):
        for j in range(8):
            out.append(tile("floor%d.%d" % (i, j), i, 0, j, (0, 0, 1), (1, 0, 0)))
            out.append(tile("ceiling%d.%d" % (i, j), i, 3, j, (1, 0, 0), (0, 0, 1)))
    for i in range(5):
        for j in range(5):
            x = 1.5 * i + (.4 if moved and (i, j) == (2, 3) else 0)
            out.append({"name": "box%d.%d" % (i, j), "archive": "box.rro", "transform": {"translate": [x + .8, .7, 1.5 * j + .8], "scale": .5}})
    return out


def ball(name, level, **transform):
    return {"name": name, "archive": "sphere%d.rro" % level, "transform": transform}


def three_balls(level):
    return [ball("a", level), ball("b", level, translate=[4, 0, 0]), ball("between", level, translate=[2, .3, 0], scale=.4)]


CASES = {
    "cube3456": lambda: box_faces(0, 1, 24, True, "wall"),
    "obstructed696": lambda: box_faces(0, 1, 10, True, "wall") + box_faces(.35, .3, 4, False, "box"),
    "far26m": lambda: [ball("a", 4), ball("b", 4, translate=[4, 0, 0])],
    "hall": lambda: hall(False),
    "hall_moved": lambda: hall(True),
    "obstructed15k": lambda: three_balls(4),
}
LARGE = {
    "obstructed60k": lambda: three_balls(5),
    "cube10000": lambda: box_faces(0, 1, 41, True, "wall")[:10000],
    "obstructed10000": lambda: box_faces(0, 1, 40, True, "wall") + sum((box_faces(at, .15, 4, False, "box%g" % at) for at in (.1, .35, .6, .8)), []),
}
OPTIONS = {"hall_moved": ["--reuse", path("hall.json.out.json")]} | {case: ["--threshold", "1e-5"] for case in LARGE}

write_obj("square", [(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0)], [(0, 1, 2, 3)])
write_obj("box", [(x, y, z) for x in (0, 1) for y in (0, 1) for z in (0, 1)],
          [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)])
for level in (4, 5):
    write_obj("sphere%d" % level, *sphere(level))
for case in sys.argv[4:] or CASES:
    with open(path(case + ".json"), "w") as f:
        json.dump({"format": "rro-scene/1", "instances": (CASES | LARGE)[case]()}, f)
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    out = path(case + (".json.out.json" if case == "hall" else ".csv"))
    text = subprocess.run([solve, "factors", path(case + ".json"), "--out", out, "--report", path(case + ".report.json"),
                           "--threads", "1"] + OPTIONS.get(case, []), check=True, capture_output=True, text=True).stdout
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    report = json.load(open(path(case + ".report.json")))
    print("%s: %.1f s user, %.0f MB; closure %.2g, reciprocity %.2g of the smaller area; pairs %s, rays %d" % (
        case, after.ru_utime - before.ru_utime, report["memory_peak_bytes"] / 1e6, report["closure"]["largest_defect"],
        report["reciprocity"]["largest_defect"], report["pairs"], report["rays"]))
    if len(report["rows"]) < 10:
        for row in csv.DictReader(open(path(case + ".csv"))):
            if float(row["factor"]):
                print("    %(from)s -> %(to)s: %(factor)s +- %(standard_error)s" % row)
