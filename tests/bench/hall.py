#!/usr/bin/env python3
"""A hall of furniture at constant density: how does the solver's work grow with the number of instances?

  hall.py LIBRARY_DIR COUNT OUT.json   writes the manifest and, beside it, the hall's shell as OUT.shell.obj
  hall.py plain DIR                    writes meshes of boxes by the names of the sample library's, and DIR/library.json

COUNT objects of the sample library (archives in LIBRARY_DIR) or the plain one stand in a square hall, each in a cell of its own, turned and
shifted by a fixed pseudo-random amount; small things stand on tables. Ceiling panels hang at regular spacing and come on top
of COUNT. The shell must be compiled before the manifest is solved: rro-compile build OUT.shell.obj --out OUT.shell.rro.
"""

import json
import os
import sys
from math import ceil, sqrt
from pathlib import Path

CELL = 1.8           # metres between objects
HEIGHT = 3.2         # metres
PANEL_CELLS = 2      # one panel over every 2 x 2 cells
TILE_CELLS = 2       # the shell's quads are as large
PANEL_BELOW = 0.4    # metres; close to the ceiling, half of the light would go into a gap
PANEL_EXITANCE = [120, 112, 98]
TABLE_TOP = 0.741
GAP = 0.001

# What stands in a cell, drawn by weight. Lists are put on a table.
CHOICES = [
    (12, ["chair"]), (3, ["table", "vase"]), (2, ["table", "telephone"]), (2, ["table", "desk_lamp"]), (4, ["ball"]),
    (1, ["sofa"]), (1, ["bookshelf"]), (1, ["palm"]), (1, ["bust"]), (3, ["vase"]),
]


class Random:
    """A small generator of its own, so that the scene is the same with every version of Python."""

    def __init__(self, seed):
        self.state = seed

    def next(self):
        self.state = (self.state * 6364136223846793005 + 1442695040888963407) % 2**64
        return (self.state >> 33) / 2**31


def furniture(count):
    """(archive, x, y, z, degrees), the cells' columns and rows from the hall's corner."""
    random = Random(1)
    total = sum(weight for weight, _ in CHOICES)
    things, cell = [], 0
    places = []
    while len(things) < count:
        draw = random.next() * total
        for weight, names in CHOICES:
            draw -= weight
            if draw < 0:
                break
        dx, dz, degrees = random.next(), random.next(), 360 * random.next()
        for name in names[:count - len(things)]:
            y = GAP if name == names[0] else TABLE_TOP + GAP
            things.append((name, y, degrees))
            places.append((cell, 0.3 * (dx - 0.5), 0.3 * (dz - 0.5)))
        cell += 1
    columns = ceil(sqrt(cell) / TILE_CELLS) * TILE_CELLS
    rows = ceil(cell / columns / TILE_CELLS) * TILE_CELLS
    placed = []
    for (name, y, degrees), (cell, dx, dz) in zip(things, places):
        x, z = CELL * (cell % columns + 0.5 + dx), CELL * (cell // columns + 0.5 + dz)
        placed.append((name, x, y, z, degrees))
    return placed, columns, rows


def shell(path, columns, rows):
    """Floor, ceiling and four walls, seen from inside, in quads of TILE_CELLS."""
    step = CELL * TILE_CELLS
    nx, nz = columns // TILE_CELLS, rows // TILE_CELLS
    width, depth = nx * step, nz * step
    with open(path, "w") as out:
        vertices = {}

        def vertex(p):
            if p not in vertices:
                vertices[p] = len(vertices) + 1
                out.write("v %.9g %.9g %.9g\n" % p)
            return vertices[p]

        def quad(*points):
            numbers = [vertex(p) for p in points]
            out.write("f %d %d %d %d\n" % tuple(numbers))

        xs, zs = [k * step for k in range(nx + 1)], [k * step for k in range(nz + 1)]
        for x0, x1 in zip(xs, xs[1:]):
            for z0, z1 in zip(zs, zs[1:]):
                quad((x0, 0, z0), (x0, 0, z1), (x1, 0, z1), (x1, 0, z0))
                quad((x0, HEIGHT, z0), (x1, HEIGHT, z0), (x1, HEIGHT, z1), (x0, HEIGHT, z1))
            quad((x0, 0, 0), (x1, 0, 0), (x1, HEIGHT, 0), (x0, HEIGHT, 0))
            quad((x0, 0, depth), (x0, HEIGHT, depth), (x1, HEIGHT, depth), (x1, 0, depth))
        for z0, z1 in zip(zs, zs[1:]):
            quad((0, 0, z0), (0, HEIGHT, z0), (0, HEIGHT, z1), (0, 0, z1))
            quad((width, 0, z0), (width, 0, z1), (width, HEIGHT, z1), (width, HEIGHT, z0))


LEGS = [(x, z) for x in (-1, 1) for z in (-1, 1)]
PLAIN = {  # boxes: centre and size, metres
    "chair": [((0, 0.45, 0), (0.43, 0.04, 0.43)), ((0, 0.72, -0.2), (0.43, 0.46, 0.03))] +
             [((0.19 * x, 0.215, 0.19 * z), (0.04, 0.428, 0.04)) for x, z in LEGS],
    "table": [((0, 0.72, 0), (1.6, 0.04, 0.9))] + [((0.75 * x, 0.349, 0.4 * z), (0.06, 0.698, 0.06)) for x, z in LEGS],
    "sofa": [((0, 0.25, 0), (1.7, 0.4, 0.8)), ((0, 0.65, -0.3), (1.7, 0.38, 0.2)),
             ((-0.96, 0.35, 0), (0.2, 0.6, 0.8)), ((0.96, 0.35, 0), (0.2, 0.6, 0.8))],
    "bookshelf": [((0, y, 0), (1.16, 0.03, 0.28)) for y in (0.1, 0.5, 0.9, 1.3, 1.7)] +
                 [((x, 0.97, 0), (0.03, 1.9, 0.3)) for x in (-0.6, 0.6)] + [((0, 0.97, -0.16), (1.2, 1.9, 0.01))],
    "bust": [((0, 0.5, 0), (0.36, 1.0, 0.36)), ((0, 1.18, 0), (0.34, 0.3, 0.2)), ((0, 1.47, 0), (0.16, 0.24, 0.2))],
    "palm": [((0, 0.2, 0), (0.35, 0.4, 0.35)), ((0, 0.8, 0), (0.06, 0.78, 0.06))] +
            [((0.35 * x, 1.3, 0.35 * z), (0.6, 0.02, 0.6)) for x, z in LEGS],
    "ball": [((0, 0.17, 0), (0.28, 0.28, 0.28))],
    "telephone": [((0, 0.05, 0), (0.2, 0.1, 0.2)), ((0, 0.13, 0), (0.3, 0.04, 0.05))],
    "vase": [((0, 0.17, 0), (0.18, 0.34, 0.18))],
    "desk_lamp": [((0, 0.01, 0), (0.18, 0.02, 0.18)), ((0, 0.22, 0), (0.03, 0.38, 0.03)), ((0.05, 0.43, 0), (0.2, 0.02, 0.12))],
    "ceiling_panel": [((0, -0.015, 0), (1.2, 0.03, 0.6))],
}


def box(out, first, centre, size):
    """One closed box; `first` is the number of its first vertex."""
    for k in range(8):
        out.write("v %.6g %.6g %.6g\n" % tuple(c + (0.5 if k >> i & 1 else -0.5) * s
                                              for i, (c, s) in enumerate(zip(centre, size))))
    for quad in ((0, 4, 6, 2), (1, 3, 7, 5), (0, 1, 5, 4), (2, 6, 7, 3), (0, 2, 3, 1), (4, 5, 7, 6)):
        out.write("f %d %d %d %d\n" % tuple(first + k for k in quad))


def plain(folder):
    folder.mkdir(parents=True, exist_ok=True)
    (folder / "plain.mtl").write_text("newmtl plain\nKd 0.5 0.5 0.5\nnewmtl panel\nKd 0.8 0.8 0.8\n")
    for name, boxes in PLAIN.items():
        with open(folder / (name + ".obj"), "w") as out:
            out.write("mtllib plain.mtl\nusemtl %s\n" % ("panel" if name == "ceiling_panel" else "plain"))
            for k, (centre, size) in enumerate(boxes):
                box(out, 8 * k + 1, centre, size)
    objects = [{"name": name, "mesh": name + ".obj"} for name in PLAIN]
    (folder / "library.json").write_text(json.dumps({"format": "rro-library/1", "objects": objects}, indent=1))


def main():
    if len(sys.argv) == 3 and sys.argv[1] == "plain":
        return plain(Path(sys.argv[2]))
    if len(sys.argv) != 4:
        print(__doc__, file=sys.stderr)
        sys.exit(2)
    library, count, out = Path(sys.argv[1]), int(sys.argv[2]), Path(sys.argv[3])
    placed, columns, rows = furniture(count)
    shell(out.with_suffix(".shell.obj"), columns, rows)

    def archive(name):
        return os.path.relpath(library.resolve() / (name + ".rro"), out.resolve().parent)

    instances = [{"name": "shell", "archive": out.with_suffix(".shell.rro").name,
                  "materials": {"*": {"reflectance": [0.6, 0.58, 0.55]}}}]
    for number, (name, x, y, z, degrees) in enumerate(placed):
        instances.append({"name": "%s_%d" % (name, number), "archive": archive(name),
                          "transform": {"translate": [round(x, 4), y, round(z, 4)],
                                        "rotate": {"axis": [0, 1, 0], "degrees": round(degrees, 2)}}})
    spacing = CELL * PANEL_CELLS
    for column in range(columns // PANEL_CELLS):
        for row in range(rows // PANEL_CELLS):
            instances.append({"name": "panel_%d_%d" % (column, row), "archive": archive("ceiling_panel"),
                              "transform": {"translate": [spacing * (column + 0.5), HEIGHT - PANEL_BELOW, spacing * (row + 0.5)]},
                              "materials": {"panel": {"exitance": PANEL_EXITANCE}}})
    with open(out, "w") as file:
        json.dump({"format": "rro-scene/1", "instances": instances}, file, indent=1)


if __name__ == "__main__":
    main()
