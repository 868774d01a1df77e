"""The Cornell box by its published corners (given in millimetres) and reflectances."""

from generate.shapes import Model, grid, join, steps

GAP = 0.001  # metres between touching surfaces, so that none coincide


def metres(corners):
    return [tuple(c / 1000 for c in corner) for corner in corners]


def quad(corners, nu, nv):
    """A bilinear grid over four corners in counter-clockwise order, in metres."""
    a, b, c, d = corners

    def point(u, v):
        return tuple((1 - u) * ((1 - v) * a[i] + v * d[i]) + u * ((1 - v) * b[i] + v * c[i]) for i in range(3))

    return grid(steps(0.0, 1.0, nu), steps(0.0, 1.0, nv), point)


def shell():
    model = Model()
    cells = 20
    walls = [
        ("white", [(552.8, 0, 0), (0, 0, 0), (0, 0, 559.2), (549.6, 0, 559.2)]),              # floor
        ("white", [(556, 548.8, 0), (556, 548.8, 559.2), (0, 548.8, 559.2), (0, 548.8, 0)]),  # ceiling
        ("white", [(549.6, 0, 559.2), (0, 0, 559.2), (0, 548.8, 559.2), (556, 548.8, 559.2)]),  # back
        ("green", [(0, 0, 559.2), (0, 0, 0), (0, 548.8, 0), (0, 548.8, 559.2)]),
        ("red", [(552.8, 0, 0), (549.6, 0, 559.2), (556, 548.8, 559.2), (556, 548.8, 0)]),
    ]
    for material, corners in walls:
        model.add(material, quad(metres(corners), cells, cells))
    return model


def standing_box(top, across, up):
    """A closed box below its four top corners, lifted off the floor by a gap.

    Fifths of its edges are whole tenths of a millimetre, so that five cells across stay exactly flat when written."""
    top = metres(top)
    bottom = [(x, GAP, z) for x, _, z in top]
    sides = []
    for k in range(4):
        m = (k + 1) % 4
        sides.append(quad([bottom[k], bottom[m], top[m], top[k]], across, up))
    model = Model()
    model.add("white", join(quad(top, across, across), quad(bottom[::-1], across, across), *sides))
    return model


def short_box():
    return standing_box([(130, 165, 65), (82, 165, 225), (240, 165, 272), (290, 165, 114)], 5, 5)


def tall_box():
    return standing_box([(423, 330, 247), (265, 330, 296), (314, 330, 456), (472, 330, 406)], 5, 10)


def lamp():
    """One-sided: it shines down, its back to the ceiling is black."""
    y = 548.8 - 1000 * GAP
    model = Model()
    model.add("lamp", quad(metres([(343, y, 227), (343, y, 332), (213, y, 332), (213, y, 227)]), 4, 4))
    return model
