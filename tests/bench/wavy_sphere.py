#!/usr/bin/env python3
"""A smooth closed object at any number of triangles: a sphere with waves, as OBJ.

    tests/bench/wavy_sphere.py TRIANGLES FILE.obj

The same surface whatever the count, so that what a solver does with it should not depend on the count either.
"""

import sys
from math import cos, pi, sin, sqrt


def point(u, v):
    """u around the axis, v from pole to pole, both in radians; the radius waves between 0.32 and 0.48 m."""
    x, y, z = sin(v) * cos(u), cos(v), sin(v) * sin(u)
    radius = 0.4 * (1 + 0.2 * sin(4 * x + 1) * sin(5 * y) * sin(4 * z + 2))
    return radius * x, radius * y, radius * z


def main(count, path):
    rows = round(sqrt(count / 4)) + 1        # 2 columns (rows - 1) triangles, twice as many columns as rows
    columns = round(count / 2 / (rows - 1))
    with open(path, "w", encoding="ascii") as out:
        out.write("v %.9g %.9g %.9g\n" % point(0, 0))
        for i in range(1, rows):
            out.writelines("v %.9g %.9g %.9g\n" % point(2 * pi * j / columns, pi * i / rows) for j in range(columns))
        out.write("v %.9g %.9g %.9g\n" % point(0, pi))
        last = 2 + columns * (rows - 1)
        for j in range(columns):
            k = (j + 1) % columns
            out.write(f"f 1 {2 + k} {2 + j}\n")
            out.write(f"f {last} {last - columns + j} {last - columns + k}\n")
        for i in range(rows - 2):
            a = 2 + columns * i
            for j in range(columns):
                k = (j + 1) % columns
                out.write(f"f {a + j} {a + k} {a + columns + k}\nf {a + j} {a + columns + k} {a + columns + j}\n")


if len(sys.argv) != 3:
    sys.exit(__doc__)
main(int(sys.argv[1]), sys.argv[2])
