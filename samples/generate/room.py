"""The room of the twelve objects: its shell, seen from inside."""

from generate.shapes import Model, box, grid, join, steps

WIDTH, HEIGHT, DEPTH = 6.0, 2.8, 4.5  # metres along x, y, z
CELL = 0.25                           # metres; cells no larger than this start soft shadows well
SKIRTING_HEIGHT, SKIRTING_DEPTH = 0.09, 0.014
WINDOW_Z, WINDOW_Y, WINDOW_DEPTH = (1.5, 3.0), (0.95, 2.3), 0.22
BOARDS = 18                           # floor boards side by side; the grid lines along z fall between them


def lines(*stops):
    """Grid lines through all stops, at most a cell apart."""
    result = [stops[0]]
    for lo, hi in zip(stops, stops[1:]):
        count = max(1, -int(-(hi - lo - 1e-9) // CELL))
        result += steps(lo, hi, count)[1:]
    return result


def shell():
    """Closed and facing inward. The skirting is part of the walls' profile, the window a recess in the wall x = WIDTH."""
    xs, zs = lines(0.0, WIDTH), lines(0.0, *WINDOW_Z, DEPTH)
    ys = lines(SKIRTING_HEIGHT + SKIRTING_DEPTH, *WINDOW_Y, HEIGHT)
    profile = [(SKIRTING_DEPTH, 0.0), (SKIRTING_DEPTH, SKIRTING_HEIGHT)] + [(0.0, y) for y in ys]  # (inset, height)
    rows = range(len(profile))

    def inside(value, size, inset):
        return max(inset, min(size - inset, value))

    def on_wall(k, x, z):
        inset, y = profile[k]
        return (inside(x, WIDTH, inset), y, inside(z, DEPTH, inset))

    floor = grid(zs, xs, lambda z, x: on_wall(0, x, z))
    ceiling = grid(xs, zs, lambda x, z: (x, HEIGHT, z))
    wall_z0 = grid(xs, rows, lambda x, k: on_wall(k, x, 0.0))
    wall_z1 = grid(rows, xs, lambda k, x: on_wall(k, x, DEPTH))
    wall_x0 = grid(rows, zs, lambda k, z: on_wall(k, 0.0, z))
    wall_x1 = without_window(grid(zs, rows, lambda z, k: on_wall(k, WIDTH, z)))
    points, triangles = join(floor, ceiling, wall_z0, wall_z1, wall_x0, wall_x1, window_recess(ys, zs))

    model = Model()
    model.add_by(surface_name, (points, triangles))
    model.add("frame", *window_frame())
    return model


def in_window(y, z):
    return WINDOW_Y[0] < y < WINDOW_Y[1] and WINDOW_Z[0] < z < WINDOW_Z[1]


def without_window(wall):
    points, triangles = wall

    def centre(t, axis):
        return sum(points[i][axis] for i in t) / 3

    return points, [t for t in triangles if not in_window(centre(t, 1), centre(t, 2))]


def window_recess(ys, zs):
    y0, y1 = WINDOW_Y
    z0, z1 = WINDOW_Z
    ys = [y for y in ys if y0 <= y <= y1]
    zs = [z for z in zs if z0 <= z <= z1]
    xs = steps(WIDTH, WIDTH + WINDOW_DEPTH, 2)
    pane = xs[-1]
    return join(
        grid(zs, ys, lambda z, y: (pane, y, z)),
        grid(zs, xs, lambda z, x: (x, y0, z)), grid(xs, zs, lambda x, z: (x, y1, z)),
        grid(xs, ys, lambda x, y: (x, y, z0)), grid(ys, xs, lambda y, x: (x, y, z1)))


def window_frame():
    """Bars in front of the pane; their ends stand 2 mm deep in the reveal."""
    y0, y1 = WINDOW_Y
    z0, z1 = WINDOW_Z
    front, back, sunk = WIDTH + WINDOW_DEPTH - 0.06, WIDTH + WINDOW_DEPTH - 0.015, 0.002
    rim, bar = 0.05, 0.014
    middle_z, middle_y = (z0 + z1) / 2, y0 + 0.62 * (y1 - y0)
    upright = (1, 10, 1)
    level = (1, 1, 10)
    return [
        box((front, y0 - sunk, z0 - sunk), (back, y1 + sunk, z0 + rim), upright),
        box((front, y0 - sunk, z1 - rim), (back, y1 + sunk, z1 + sunk), upright),
        box((front + 0.001, y0 - sunk, z0 + rim - sunk), (back - 0.001, y0 + rim, z1 - rim + sunk), level),
        box((front + 0.001, y1 - rim, z0 + rim - sunk), (back - 0.001, y1 + sunk, z1 - rim + sunk), level),
        box((front + 0.004, y0 + rim - sunk, middle_z - bar), (back - 0.004, y1 - rim + sunk, middle_z + bar), upright),
        box((front + 0.008, middle_y - bar, z0 + rim - sunk), (back - 0.008, middle_y + bar, z1 - rim + sunk), level),
    ]


def surface_name(centre):
    x, y, z = centre
    if y < 1e-6:
        return floor_board(x, z)
    if y > HEIGHT - 1e-6:
        return "ceiling"
    if x > WIDTH + 1e-6:
        return "window" if x > WIDTH + WINDOW_DEPTH - 1e-6 else "reveal"
    if y < SKIRTING_HEIGHT + SKIRTING_DEPTH:
        return "skirting"
    if z < 1e-6:
        return "wall_blue_green"
    if x > WIDTH - 1e-6:
        return "wall_terracotta"
    return "wall_cream"


def floor_board(x, z):
    """Boards one cell wide along x, five cells long, each row shifted against the last; three tones of oak."""
    row = int(z * BOARDS / DEPTH)
    board = int((x / CELL + 2 * (row % 3)) / 5)
    return "floor_" + "abc"[(5 * row + 7 * board + row * board) % 3]


def ceiling_panel():
    """A flat luminaire, 1.2 x 0.6 m, centred at the origin; its lower face shines. Hangs just below a ceiling."""
    model = Model()
    model.add_by(lambda c: "panel" if c[1] < -0.03 + 1e-6 else "housing", box((-0.6, -0.03, -0.3), (0.6, 0.0, 0.3), (12, 1, 6)))
    return model
