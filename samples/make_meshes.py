#!/usr/bin/env python3
"""Writes samples/meshes: the sample objects as OBJ files and the material file they share.

Standard library only; the same files on every run. Usage: samples/make_meshes.py [NAME...] (all without a name)."""

import sys
from pathlib import Path

sys.dont_write_bytecode = True  # the sources' folder stays clean

from generate import bust, cornell, effects, furniture, lamps, room, small_things

MESHES = Path(__file__).resolve().parent / "meshes"
MATERIALS = "materials.mtl"

OBJECTS = {
    "cornell_shell": (cornell.shell, "Cornell box: floor, ceiling, walls"),
    "cornell_short": (cornell.short_box, "Cornell box: short box"),
    "cornell_tall": (cornell.tall_box, "Cornell box: tall box"),
    "cornell_lamp": (cornell.lamp, "Cornell box: lamp"),
    "room": (room.shell, "room shell, 6 x 4.5 x 2.8 m, seen from inside"),
    "ceiling_panel": (room.ceiling_panel, "ceiling panel"),
    "table": (furniture.table, "table"),
    "chair": (furniture.chair, "chair"),
    "sofa": (furniture.sofa, "sofa"),
    "bookshelf": (furniture.bookshelf, "bookshelf"),
    "desk_lamp": (lamps.desk_lamp, "desk lamp"),
    "floor_lamp": (lamps.floor_lamp, "floor lamp"),
    "bust": (bust.bust, "bust on a plinth"),
    "telephone": (small_things.telephone, "telephone"),
    "ball": (small_things.beach_ball, "ball"),
    "vase": (small_things.vase, "vase"),
    "palm": (small_things.palm, "potted palm"),
    "closed_room": (effects.closed_room, "closed room, 4 x 2.5 x 4 m, seen from inside"),
    "window_room": (effects.window_room, "room with an open window, seen from inside"),
    "courtyard": (effects.courtyard, "courtyard, 8 x 8 m, seen from inside"),
    "long_hall": (effects.long_hall, "long hall, seen from inside"),
    "pillar": (effects.pillar, "pillar"),
    "pedestal": (effects.pedestal, "pedestal"),
    "paper_shade": (effects.paper_shade, "lamp shade of paper, without thickness"),
    "poster": (effects.Poster, "poster with a texture"),
}

REFLECTANCES = {  # linear RGB, as Kd
    # Cornell's measured spectra, as commonly reduced to RGB
    "white": (0.725, 0.71, 0.68), "green": (0.14, 0.45, 0.091), "red": (0.63, 0.065, 0.05), "lamp": (0.78, 0.78, 0.78),
    # the room
    "floor_a": (0.42, 0.27, 0.15), "floor_b": (0.39, 0.247, 0.135), "floor_c": (0.445, 0.29, 0.166),
    "ceiling": (0.84, 0.83, 0.80), "skirting": (0.80, 0.79, 0.75), "reveal": (0.80, 0.79, 0.75),
    "frame": (0.78, 0.77, 0.74), "window": (0.12, 0.13, 0.14), "wall_blue_green": (0.14, 0.40, 0.42),
    "wall_terracotta": (0.66, 0.25, 0.13), "wall_cream": (0.76, 0.70, 0.58),
    "panel": (0.78, 0.78, 0.78), "housing": (0.75, 0.75, 0.75),
    # furniture
    "oak": (0.52, 0.33, 0.17), "walnut": (0.20, 0.105, 0.055), "seat": (0.68, 0.60, 0.45), "sofa": (0.62, 0.58, 0.52),
    "cushion_rust": (0.58, 0.16, 0.06), "cushion_mustard": (0.66, 0.44, 0.07), "shelf": (0.50, 0.36, 0.22),
    "book_1": (0.45, 0.05, 0.04), "book_2": (0.05, 0.13, 0.30), "book_3": (0.06, 0.22, 0.10), "book_4": (0.70, 0.62, 0.45),
    "book_5": (0.62, 0.38, 0.05), "book_6": (0.10, 0.10, 0.11), "book_7": (0.30, 0.12, 0.22), "book_8": (0.12, 0.33, 0.38),
    "book_9": (0.55, 0.22, 0.08),
    # lamps and small things
    "brass": (0.55, 0.42, 0.18), "shade_metal": (0.62, 0.10, 0.05), "shade_fabric": (0.78, 0.70, 0.55),
    "bulb": (0.75, 0.75, 0.75), "marble": (0.80, 0.78, 0.74), "stone": (0.52, 0.50, 0.47),
    "telephone": (0.50, 0.045, 0.035), "buttons": (0.78, 0.76, 0.68), "ball_red": (0.66, 0.06, 0.04),
    "ball_white": (0.82, 0.82, 0.80), "ball_blue": (0.05, 0.16, 0.48), "vase": (0.08, 0.20, 0.45),
    "pot": (0.55, 0.23, 0.12), "earth": (0.09, 0.06, 0.04), "stem": (0.22, 0.33, 0.09), "leaf": (0.10, 0.30, 0.07),
}


def main(names):
    MESHES.mkdir(exist_ok=True)
    lines = []
    for name, kd in REFLECTANCES.items():
        lines += [f"newmtl {name}", "Kd " + " ".join(f"{c:g}" for c in kd)]
    (MESHES / MATERIALS).write_text("\n".join(lines) + "\n")
    for name in names or OBJECTS:
        build, title = OBJECTS[name]
        (MESHES / f"{name}.obj").write_text(build().obj_text(title, MATERIALS))
    effects.write_poster_files(MESHES)
    effects.write_downlight(MESHES.parent / "scenes")


if __name__ == "__main__":
    main(sys.argv[1:])
