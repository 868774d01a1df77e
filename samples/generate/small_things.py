"""Telephone, ball, vase, potted palm. They stand at y = 0 around the origin, fronts towards +z."""

from math import atan2, cos, pi, sin
from random import Random

from generate.shapes import (Model, add, ball, cross, curve, grid, lathe, mix, move, rounded_box, scaled, sub, tube, turn,
                             unit, warp)


def telephone():
    """0.2 m wide; twelve buttons on a slope, the handset across the back, a coiled cord."""
    model = Model()
    slope_front, slope_back = 0.035, 0.085

    def wedge(p):
        """Squeezes a 1 m high box below the sloping top."""
        x, y, z = p
        t = min(1.0, max(0.0, (z + 0.115) / 0.23))
        smooth = t * t * (3 - 2 * t)
        return (x * (1 - 0.06 * y), y * (slope_back + (slope_front - slope_back) * smooth), z)

    body = rounded_box((-0.1, 0.0, -0.115), (0.1, 1.0, 0.115), 0.02, 2, (5, 1, 9))
    model.add("telephone", warp(body, wedge))
    for row in range(4):
        for column in range(3):
            x, z = 0.028 * (column - 1), 0.005 + 0.026 * row
            y = wedge((0, 1.0, z))[1]
            button = rounded_box((-0.010, -0.006, -0.009), (0.010, 0.007, 0.009), 0.004, 1)
            model.add("buttons", move(turn(button, "x", 18), x, y, z))
    for x in (-0.062, 0.062):
        for z in (-0.098, -0.042):
            prong = rounded_box((x - 0.016, 0.05, z - 0.006), (x + 0.016, 0.107, z + 0.006), 0.005, 1)
            model.add("telephone", prong)
    handset(model)
    cord(model)
    return model


def handset(model):
    path = curve([(-0.105, 0.112, -0.07), (-0.06, 0.133, -0.07), (0, 0.14, -0.07), (0.06, 0.133, -0.07), (0.105, 0.112, -0.07)], 14)
    radii = [0.019 - 0.006 * sin(pi * k / 14) for k in range(15)]
    model.add("telephone", tube(path, radii, 12))
    cup = [(0, -0.022), (0.026, -0.022), (0.031, -0.016), (0.031, -0.004), (0.024, 0.012), (0.012, 0.019), (0, 0.02)]
    for side in (-1, 1):
        model.add("telephone", move(turn(lathe(cup, 16), "z", side * 12), side * 0.108, 0.112, -0.07))


def cord(model):
    """A helix around a curve from the handset's left end down to the table and back to the body."""
    turns, per_turn, radius = 26, 7, 0.0075
    spine = curve([(-0.125, 0.112, -0.07), (-0.16, 0.07, -0.05), (-0.175, 0.0135, 0.0), (-0.165, 0.0125, 0.06),
                   (-0.13, 0.0125, 0.075), (-0.092, 0.018, 0.05)], turns * per_turn)
    coil = []
    for k, centre in enumerate(spine):
        along = unit(sub(spine[min(k + 1, len(spine) - 1)], spine[max(k - 1, 0)]))
        side = unit(cross(along, (0.2, 1, 0.1)))
        up = cross(side, along)
        angle = 2 * pi * k / per_turn
        coil.append(add(centre, add(scaled(side, radius * cos(angle)), scaled(up, radius * sin(angle)))))
    model.add("telephone", tube(coil, 0.0024, 4))


def beach_ball():
    """Radius 0.17 m, six gores of three colours, two white caps."""
    radius, rings, sides = 0.17, 18, 30
    colours = ("ball_red", "ball_white", "ball_blue")

    def gore(centre):
        x, y, z = centre
        if abs(y) > 0.97 * radius:
            return "ball_white"
        return colours[int((atan2(z, x) / (2 * pi) + 1) * 6) % 3]

    model = Model()
    points, triangles = ball(radius, rings, sides)
    model.add_by(gore, (points, triangles))
    tilted = Model()
    shared = turn(turn((points, triangles), "z", 28), "x", 14)[0]
    raised = [add(p, (0, radius, 0)) for p in shared]
    tilted.pieces = [(material, raised, part) for material, _, part in model.pieces]
    return tilted


def vase():
    """0.34 m high, open at the top, with an inside."""
    outside = curve([(0.055, 0.0, 0), (0.07, 0.02, 0), (0.108, 0.12, 0), (0.085, 0.22, 0), (0.042, 0.285, 0), (0.05, 0.325, 0), (0.062, 0.34, 0)], 16)
    profile = [(r, y) for r, y, _ in outside]
    wall = 0.005
    inside = [(max(0.02, r - wall), y) for r, y in profile[:0:-1] if y > 0.012]
    model = Model()
    model.add("vase", lathe([(0, 0)] + profile + [(profile[-1][0] - wall / 2, 0.3415)] + inside + [(0, inside[-1][1])], 32))
    return model


# ---- palm ---------------------------------------------------------------------------------------------------------


def palm():
    """1.6 m high: a pot with earth, and arching fronds of leaflets. Leaflets are cards, lit on both sides."""
    model = Model()
    pot = [(0, 0), (0.12, 0), (0.125, 0.01), (0.165, 0.27), (0.18, 0.275), (0.185, 0.32), (0.168, 0.32), (0.155, 0.27), (0.15, 0.255), (0, 0.255)]
    model.add("pot", lathe(pot, 36))
    model.add("earth", lathe([(0, 0.245), (0.151, 0.245), (0.149, 0.272), (0.07, 0.284), (0, 0.288)], 24))
    random = Random(5)
    fronds = 12
    for k in range(fronds):
        angle = 2.399963 * k + 0.3 * random.random()  # the golden angle, as leaves grow
        rise = 1 - (k + 0.5) / fronds                 # inner fronds stand, outer ones hang over
        frond(model, random, angle, 0.62 + 0.62 * rise, 0.30 + 0.34 * (1 - rise))
    return model


def frond(model, random, angle, height, reach):
    out = (cos(angle), 0, sin(angle))

    def at(distance, y):
        return add(scaled(out, distance), (0, y, 0))

    top = 0.27 + height
    stem = curve([at(0.03, 0.27), at(0.05 + 0.12 * reach, 0.27 + 0.55 * height), at(0.05 + 0.45 * reach, top),
                  at(0.05 + 1.0 * reach, top + 0.02), at(0.06 + 1.45 * reach, top - 0.22 * reach - 0.08)], 20)
    model.add("stem", tube(stem, [0.008 - 0.0065 * j / 20 for j in range(21)], 5))
    across = cross(out, (0, 1, 0))
    pairs = 12
    for j in range(pairs):
        t = 0.36 + 0.63 * j / (pairs - 1)
        base = along(stem, t)
        forward = unit(sub(along(stem, min(1, t + 0.02)), along(stem, t - 0.02)))
        length = 0.27 * sin(pi * (0.12 + 0.80 * (t - 0.36) / 0.64)) ** 0.7
        for side in (-1, 1):
            spread = 0.85 - 0.35 * (t - 0.36) / 0.64 + 0.1 * (random.random() - 0.5)
            direction = unit(add(scaled(across, side * spread), add(scaled(forward, 0.75), (0, 0.22, 0))))
            model.add("leaf", leaflet(base, direction, length, 0.021 * length / 0.27 + 0.006))


def along(path, t):
    s = t * (len(path) - 1)
    i = min(int(s), len(path) - 2)
    return mix(path[i], path[i + 1], s - i)


def leaflet(base, direction, length, half_width):
    """A pointed card of eight triangles, folded along its rib and drooping at the tip."""
    across = unit(cross(direction, (0, 1, 0)))

    def point(u, v):
        width = half_width * (4 * u * (1 - u)) ** 0.6 if 0 < u < 1 else 0.0
        droop = -0.45 * length * u * u
        fold = -0.35 * width * (1 - abs(v))
        return add(base, add(scaled(direction, length * u), add(scaled(across, v * width), (0, droop + fold, 0))))

    return grid([0.0, 0.3, 0.65, 1.0], [-1, 0, 1], point)
