"""Table, chair, sofa, bookshelf. They stand at y = 0 around the origin, fronts towards +z."""

from math import cos, pi, sin
from random import Random

from generate.shapes import Model, box, curve, lathe, move, rounded_box, tube, turn, warp

SUNK = 0.004  # metres that joined parts reach into one another


def table():
    """1.6 x 0.9 m, 0.74 m high: a rounded top, an apron, four turned legs."""
    model = Model()
    model.add("oak", rounded_box((-0.8, 0.705, -0.45), (0.8, 0.74, 0.45), 0.012, 1, (16, 1, 9)))
    apron_top, apron_bottom = 0.705 + SUNK, 0.62
    for z in (-0.375, 0.355):
        model.add("oak", box((-0.70, apron_bottom, z), (0.70, apron_top, z + 0.02), (8, 1, 1)))
    for x in (-0.725, 0.705):
        model.add("oak", box((x, apron_bottom, -0.33), (x + 0.02, apron_top, 0.33), (1, 1, 4)))
    leg = [(0, 0), (0.018, 0), (0.02, 0.02), (0.024, 0.10), (0.028, 0.30), (0.033, 0.50), (0.036, 0.56), (0.028, 0.575),
           (0.028, 0.585), (0.036, 0.60), (0.036, 0.705 + SUNK), (0, 0.705 + SUNK)]
    for x in (-0.71, 0.71):
        for z in (-0.36, 0.36):
            model.add("oak", move(lathe(leg, 12), x, 0, z))
    return model


def chair():
    """0.44 m wide, seat at 0.46 m, a bowed back with three slats."""
    model = Model()
    seat = rounded_box((-0.215, 0.425, -0.205), (0.215, 0.468, 0.215), 0.018, 2, (5, 1, 5))
    model.add("seat", warp(seat, cushion(0.215, 0.21, 0.012)))
    model.add("walnut", rounded_box((-0.20, 0.395, -0.19), (0.20, 0.425 + SUNK, 0.20), 0.006, 1, (4, 1, 4)))
    for x in (-0.175, 0.175):
        model.add("walnut", on_floor(tube([(x * 1.12, 0, 0.195), (x, 0.2, 0.175), (x, 0.40, 0.17)], [0.012, 0.016, 0.019], 8)))
        post = curve([(x * 1.1, 0, -0.25), (x, 0.25, -0.185), (x, 0.45, -0.175), (x, 0.70, -0.215), (x, 0.94, -0.285)], 8)
        model.add("walnut", on_floor(tube(post, [0.012 + 0.006 * sin(pi * k / 8) for k in range(9)], 8)))
        model.add("walnut", tube([(x * 1.06, 0.15, 0.18), (x * 1.05, 0.15, -0.205)], 0.008, 6))
    model.add("walnut", tube([(-0.186, 0.15, -0.01), (0.186, 0.15, -0.01)], 0.008, 6))
    for y, z, height in ((0.56, -0.190, 0.045), (0.70, -0.215, 0.045), (0.855, -0.257, 0.085)):
        model.add("walnut", back_slat(y, z, height))
    return model


def on_floor(shape):
    """Flattens what a slanted end pushes below the floor."""
    return warp(shape, lambda p: (p[0], max(0.0, p[1]), p[2]))


def back_slat(y, z, height):
    """Bowed backwards by 3 cm between the posts and leaning with them."""
    slat = rounded_box((-0.18, -height / 2, -0.008), (0.18, height / 2, 0.008), 0.006, 1, (8, 1, 1))
    bowed = warp(slat, lambda p: (p[0], p[1], p[2] - 0.03 * cos(p[0] / 0.18 * pi / 2)))
    return move(turn(bowed, "x", -16), 0, y, z)


def cushion(half_x, half_z, rise):
    """A warp that raises the middle of what lies above y = 0.44 m: upholstery."""
    def raise_middle(p):
        x, y, z = p
        lift = rise * max(0.0, 1 - (x / half_x) ** 2) * max(0.0, 1 - (z / half_z) ** 2) if y > 0.44 else 0.0
        return (x, y + lift, z)

    return raise_middle


def pillow(lo, hi, radius, bulge, divisions):
    """A rounded box whose faces swell by `bulge` metres in their middle."""
    middle = [(a + b) / 2 for a, b in zip(lo, hi)]
    half = [(b - a) / 2 for a, b in zip(lo, hi)]

    def swell(p):
        s = [(c - m) / h for c, m, h in zip(p, middle, half)]
        grown = []
        for axis in range(3):
            others = [max(0.0, 1 - s[k] ** 2) for k in range(3) if k != axis]
            grown.append(p[axis] + bulge * s[axis] * others[0] * others[1])
        return tuple(grown)

    return warp(rounded_box(lo, hi, radius, 2, divisions), swell)


def sofa():
    """2.1 m wide, 0.9 m deep, three seats, two throw cushions."""
    model = Model()
    model.add("sofa", rounded_box((-1.0, 0.10, -0.40), (1.0, 0.30, 0.43), 0.03, 1, (10, 1, 4)))
    back = rounded_box((-1.0, 0.10 + SUNK, -0.45), (1.0, 0.80, -0.27), 0.06, 2, (10, 4, 1))
    model.add("sofa", warp(back, lambda p: (p[0], p[1], p[2] - 0.12 * (p[1] - 0.1))))
    for side in (-1, 1):
        arm = rounded_box((-0.11, 0.10 + 2 * SUNK, -0.43), (0.11, 0.58, 0.45), 0.07, 2, (1, 3, 5))
        model.add("sofa", move(arm, side * 0.96, 0, 0))
        for z in (-0.36, 0.36):
            foot = lathe([(0, 0), (0.018, 0), (0.028, 0.10 + 2 * SUNK), (0, 0.10 + 2 * SUNK)], 10)
            model.add("walnut", move(foot, side * 0.92, 0, z))
    for k in range(3):
        x = -0.845 + k * 0.5645
        model.add("sofa", pillow((x, 0.285, -0.27), (x + 0.559, 0.44, 0.445), 0.045, 0.022, (4, 1, 5)))
        behind = pillow((x + 0.004, -0.20, -0.075), (x + 0.555, 0.20, 0.075), 0.06, 0.03, (4, 3, 1))
        model.add("sofa", move(turn(behind, "x", -14), 0, 0.64, -0.225))
    throw = pillow((-0.21, -0.21, -0.04), (0.21, 0.21, 0.04), 0.035, 0.045, (4, 4, 1))
    model.add("cushion_rust", move(turn(turn(throw, "x", -24), "y", 22), -0.66, 0.65, -0.02))
    model.add("cushion_mustard", move(turn(turn(turn(throw, "z", 12), "x", -22), "y", -18), 0.64, 0.65, -0.02))
    return model


# ---- bookshelf ----------------------------------------------------------------------------------------------------

SHELF_WIDTH, SHELF_DEPTH, SHELF_HEIGHT, BOARD = 1.2, 0.30, 1.95, 0.022
SHELVES = (0.08, 0.47, 0.83, 1.17, 1.49)  # undersides of the boards that carry books
BOOK_COLOURS = 9


def bookshelf():
    model = Model()
    half, depth = SHELF_WIDTH / 2, SHELF_DEPTH / 2
    for x in (-half, half - BOARD):
        model.add("shelf", box((x, 0, -depth), (x + BOARD, SHELF_HEIGHT, depth), (1, 10, 2)))
    inner, sunk = half - BOARD, 0.002
    for y in SHELVES + (SHELF_HEIGHT - BOARD - 0.01,):
        model.add("shelf", box((-inner - sunk, y, -depth + 0.01), (inner + sunk, y + BOARD, depth - 0.006), (6, 1, 2)))
    model.add("shelf", box((-inner - sunk, 0.02, -depth + 0.004), (inner + sunk, SHELF_HEIGHT - 0.02, -depth + 0.012), (6, 10, 1)))
    random = Random(12)
    tops = SHELVES[1:] + (SHELF_HEIGHT - BOARD - 0.01,)
    for level, (shelf, top) in enumerate(zip(SHELVES, tops)):
        fill_shelf(model, random, level, shelf + BOARD + 0.001, top, inner - 0.012)
    return model


def fill_shelf(model, random, level, floor, ceiling, half_width):
    """Books from left to right, now and then a gap with a leaning book or a lying pile."""
    x = -half_width
    tallest = min(ceiling - floor - 0.03, 0.31)
    while True:
        kind = random.random()
        if kind < 0.05 and x + 0.26 < half_width:
            x = lying_pile(model, random, x, floor, tallest)
            continue
        thickness = 0.018 + 0.034 * random.random()
        if x + thickness > half_width:
            return
        height = tallest * (0.68 + 0.32 * random.random())
        if kind > 0.94 and x + thickness + 0.12 < half_width:
            leaning_book(model, random, x, floor, thickness, height)
            x += 0.11 + thickness
            continue
        upright_book(model, random, x, floor, thickness, height)
        x += thickness + 0.0012
        if level == 3 and x > 0.12:  # room for a gap at the end of one shelf
            return


def book_colour(random):
    return f"book_{random.randrange(1, BOOK_COLOURS + 1)}"


def book(thickness, height, depth):
    return box((0, 0, 0), (thickness, height, depth), (1, 3, 1))


def upright_book(model, random, x, floor, thickness, height):
    depth = 0.16 + 0.05 * random.random()
    front = SHELF_DEPTH / 2 - 0.025 - 0.03 * random.random()
    model.add(book_colour(random), move(book(thickness, height, depth), x, floor, front - depth))


def leaning_book(model, random, x, floor, thickness, height):
    """Leans to the left against its neighbour; stands on its lower left edge."""
    leaning = turn(book(thickness, height, 0.17), "z", 14)
    model.add(book_colour(random), move(leaning, x + 0.27 * height * 0.97, floor + 0.001, SHELF_DEPTH / 2 - 0.21))


def lying_pile(model, random, x, floor, tallest):
    y = floor
    for _ in range(3 + random.randrange(3)):
        thickness = 0.02 + 0.025 * random.random()
        if y + thickness > floor + tallest:
            break
        length, depth = 0.20 + 0.03 * random.random(), 0.15 + 0.03 * random.random()
        lying = box((0, 0, 0), (length, thickness, depth), (3, 1, 2))
        model.add(book_colour(random), move(lying, x + 0.004 + 0.01 * random.random(), y, SHELF_DEPTH / 2 - 0.04 - depth))
        y += thickness + 0.0012
    return x + 0.25
