"""Desk lamp and floor lamp: metal, a shade of two walls, a bulb that shines (its exitance is given in the scene)."""

from math import cos, pi, sin

from generate.shapes import Model, add, ball, curve, lathe, move, tube, turn


def desk_lamp():
    """0.5 m high, the shade bent over towards +x."""
    model = Model()
    base = [(0, 0), (0.085, 0), (0.09, 0.006), (0.088, 0.016), (0.06, 0.026), (0.022, 0.032), (0.016, 0.05), (0, 0.05)]
    model.add("brass", lathe(base, 32))
    foot, elbow, neck = (0, 0.045, 0), (-0.13, 0.27, 0), (0.075, 0.44, 0)
    for start, end, apart in ((foot, elbow, 0.006), (elbow, neck, 0.016)):
        model.add("brass", *(tube([add(p, (0, 0, z)) for p in (start, end)], 0.005, 8) for z in (-apart, apart)))
    for joint in (elbow, neck):
        axle = tube([(0, 0, -0.022), (0, 0, 0.022)], 0.012, 12)
        model.add("brass", move(axle, *joint))

    outside = [(0.030, 0.07), (0.034, 0.035), (0.040, 0.02), (0.055, -0.01), (0.072, -0.05), (0.085, -0.09)]
    wall = 0.002
    inside = [(r - wall, y - wall / 2) for r, y in outside]
    shell = outside[::-1] + [(0.0, 0.075), (0.0, 0.07)] + inside  # rim, up the outside, over the top, down the inside
    shade = lathe(shell + [shell[0]], 32)
    bulb = move(ball(0.026, 10, 16), 0, -0.03, 0)
    socket = lathe([(0, -0.01), (0.015, -0.01), (0.015, 0.071), (0, 0.071)], 12)
    for material, part in (("shade_metal", shade), ("bulb", bulb), ("brass", socket)):
        model.add(material, move(turn(part, "z", 32), 0.095, 0.405, 0))
    return model


def floor_lamp():
    """1.62 m high; the shade is open above and below, so it lights ceiling and floor."""
    model = Model()
    base = [(0, 0), (0.15, 0), (0.155, 0.008), (0.15, 0.018), (0.09, 0.03), (0.03, 0.038), (0.014, 0.055), (0, 0.055)]
    model.add("brass", lathe(base, 36))
    model.add("brass", tube([(0, y / 10, 0) for y in (0.5, 3, 6, 9, 12, 14)], 0.0105, 12))
    model.add("brass", lathe([(0, 1.385), (0.024, 1.385), (0.024, 1.43), (0, 1.43)], 16))
    bottom, top, wall = (0.235, 1.27), (0.155, 1.60), 0.003
    rows = 5
    outside = [(bottom[0] + (top[0] - bottom[0]) * k / rows, bottom[1] + (top[1] - bottom[1]) * k / rows) for k in range(rows + 1)]
    inside = [(r - wall, y) for r, y in outside[::-1]]
    model.add("shade_fabric", lathe(outside + inside + [outside[0]], 36))
    model.add("bulb", move(ball(0.05, 12, 20), 0, 1.475, 0))
    for k in range(3):  # the wires that hold the shade
        angle = 2 * pi * k / 3 + 0.4
        wire = [(0.018 * cos(angle), 1.40, 0.018 * sin(angle)), (0.2175 * cos(angle), 1.345, 0.2175 * sin(angle))]
        model.add("brass", tube(curve(wire, 3), 0.0025, 6))
    return model
