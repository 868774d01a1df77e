"""Small places that each show one kind of light: a room with an open window, a courtyard, a closed room, a lamp shade, a
hall with pillars, a gallery wall with a textured poster."""

import struct
import zlib
from math import cos, pi, sin

from generate.shapes import Model, box, grid, lathe, steps

FLOOR, CEILING, WALL = "floor_a", "ceiling", "wall_cream"


def inward(size, floor, walls, ceiling, cell=0.25):
    """Grids of a room from (0, 0, 0) to size, facing inward, by name; the ceiling only where it has a material."""
    x1, y1, z1 = size
    xs, ys, zs = (steps(0.0, s, max(1, round(s / cell))) for s in size)
    sides = {
        "floor": (floor, grid(zs, xs, lambda z, x: (x, 0.0, z))),
        "back": (walls, grid(xs, ys, lambda x, y: (x, y, 0.0))),
        "front": (walls, grid(ys, xs, lambda y, x: (x, y, z1))),
        "left": (walls, grid(ys, zs, lambda y, z: (0.0, y, z))),
        "right": (walls, grid(zs, ys, lambda z, y: (x1, y, z))),
    }
    if ceiling:
        sides["ceiling"] = (ceiling, grid(xs, zs, lambda x, z: (x, y1, z)))
    return sides


def model_of(sides):
    model = Model()
    for material, shape in sides.values():
        model.add(material, shape)
    return model


def closed_room():
    """4 x 2.5 x 4 m; the left wall blue-green, the right one terracotta."""
    sides = inward((4.0, 2.5, 4.0), FLOOR, WALL, CEILING)
    sides["left"] = ("wall_blue_green", sides["left"][1])
    sides["right"] = ("wall_terracotta", sides["right"][1])
    return model_of(sides)


def window_room():
    """The same room with a hole of 1.5 x 1.25 m in the right wall."""
    sides = inward((4.0, 2.5, 4.0), FLOOR, WALL, CEILING)
    points, triangles = sides["right"][1]

    def in_window(t):
        y, z = (sum(points[i][k] for i in t) / 3 for k in (1, 2))
        return 0.75 < y < 2.0 and 1.25 < z < 2.75

    sides["right"] = (WALL, (points, [t for t in triangles if not in_window(t)]))
    sides["left"] = ("wall_terracotta", sides["left"][1])
    return model_of(sides)


def courtyard():
    """Four walls of 4 m around 8 x 8 m of floor, nothing above."""
    return model_of(inward((8.0, 4.0, 8.0), "stone", WALL, None))


def long_hall():
    """4 x 3 x 12 m, closed."""
    return model_of(inward((4.0, 3.0, 12.0), "stone", WALL, CEILING, 0.4))


def pillar():
    """2.9 m high, closed."""
    model = Model()
    profile = [(0.0, 0.0), (0.22, 0.0), (0.22, 0.12), (0.16, 0.2)] + [(0.15, 0.2 + 0.5 * k) for k in range(1, 5)]
    model.add("marble", lathe(profile + [(0.16, 2.6), (0.22, 2.72), (0.22, 2.9), (0.0, 2.9)], 20))
    return model


def paper_shade():
    """A shade without thickness, 0.5 m high and 0.3 to 0.5 m across, open above and below: compile it two-sided."""
    rows, sides = 8, 32
    model = Model()
    profile = [(0.25 - 0.1 * k / rows, 0.5 * k / rows) for k in range(rows + 1)]
    model.add("shade_fabric", lathe(profile, sides))
    return model


def pedestal():
    model = Model()
    model.add("marble", box((-0.2, 0.0, -0.2), (0.2, 0.9, 0.2), (2, 4, 2)))
    return model


# ---- the poster ---------------------------------------------------------------------------------------------------

POSTER = "poster"
POSTER_PIXELS = 96
POSTER_CELLS = 48


def poster_colour(u, v):
    """A sun over waves, 8-bit sRGB."""
    if (u - 0.68) ** 2 + (v - 0.7) ** 2 < 0.16 ** 2:
        return (250, 214, 60)
    for k, colour in enumerate([(20, 60, 120), (30, 100, 160), (60, 150, 190), (130, 195, 210)]):
        if v < 0.12 + 0.11 * k + 0.035 * sin(2 * pi * (1.5 * u + 0.3 * k)):
            return colour
    return (238, 130, 90) if int(12 * v) % 2 else (245, 175, 120)


def png(width, height, colour):
    rows = b"".join(b"\0" + b"".join(bytes(colour((x + 0.5) / width, 1 - (y + 0.5) / height)) for x in range(width))
                    for y in range(height))

    def chunk(kind, data):
        return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))

    header = struct.pack(">IIBBBBB", width, height, 8, 2, 0, 0, 0)
    return b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", header) + chunk(b"IDAT", zlib.compress(rows, 9)) + chunk(b"IEND", b"")


class Poster:
    """1.2 x 1.2 m in the plane z = 0, facing +z, with texture coordinates and a material file of its own."""

    def obj_text(self, title, _):
        n = POSTER_CELLS
        text = [f"# {title}", f"mtllib {POSTER}.mtl", f"usemtl {POSTER}"]
        places = [(i / n, j / n) for j in range(n + 1) for i in range(n + 1)]
        text += [f"v {1.2 * u:.5f} {1.2 * v:.5f} 0" for u, v in places]
        text += [f"vt {u:.6f} {v:.6f}" for u, v in places]
        for j in range(n):
            for i in range(n):
                a = j * (n + 1) + i + 1
                b, c, d = a + 1, a + n + 2, a + n + 1
                text += [f"f {a}/{a} {b}/{b} {c}/{c}", f"f {a}/{a} {c}/{c} {d}/{d}"]
        return "\n".join(text) + "\n"


def write_poster_files(folder):
    (folder / f"{POSTER}.mtl").write_text(f"newmtl {POSTER}\nKd 0.9 0.9 0.9\nmap_Kd {POSTER}.png\n")
    (folder / f"{POSTER}.png").write_bytes(png(POSTER_PIXELS, POSTER_PIXELS, poster_colour))


# ---- a photometric file -------------------------------------------------------------------------------------------


def ies_text():
    """A downlight made up for the sample: most of its light within 35 degrees, in LM-63 of 2002."""
    angles = [5 * k for k in range(19)]
    candela = [1200 * cos(min(a / 90, 1) * pi / 2) ** 4 + 40 * sin(pi * a / 90) for a in angles]
    return "\n".join([
        "IESNA:LM-63-2002", "[TEST] none: computed", "[MANUFAC] samples/make_meshes.py", "[LUMINAIRE] downlight", "TILT=NONE",
        f"1 -1 1 {len(angles)} 1 1 2 -0.1 0 0", "1 1 12", " ".join(str(a) for a in angles), "0",
        " ".join(f"{max(0.0, c):.1f}" for c in candela)]) + "\n"


def write_downlight(folder):
    (folder / "downlight.ies").write_text(ies_text())
