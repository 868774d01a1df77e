#!/usr/bin/env python3
"""A living room of ready-made furniture (Debian's sweethome3d-furniture). Used by furniture_room.sh.

  furniture_room.py extract CATALOGUES DIR   takes the models out of the .sh3f files (zips) into DIR/meshes/NAME/
  furniture_room.py library DIR              writes DIR/library.json, the list of the models for rro-compile library
  furniture_room.py manifest DIR             writes DIR/scene.json; archives are in DIR/library and samples/library

The models are in centimetres, y up, fronts towards +z, and lie anywhere: their bounds decide where they are put.
"""

import json
import os
import sys
import zipfile
from math import cos, radians, sin
from pathlib import Path

CENTIMETRE = 0.01
GAP = 0.001  # metres between a piece and what it stands on
SAMPLES = Path(__file__).resolve().parent

MODELS = {  # name: (catalogue, mesh in it)
    "oak_table": ("BlendSwap-CC-0.sh3f", "blendswap-cc-0/oakTable/oakTable.obj"),
    "oak_chair": ("BlendSwap-CC-0.sh3f", "blendswap-cc-0/oakChair/oakChair.obj"),
    "thonet_chair": ("BlendSwap-CC-0.sh3f", "blendswap-cc-0/thonet/thonet.obj"),
    "sofa": ("BlendSwap-CC-0.sh3f", "blendswap-cc-0/winchesterSofa/winchesterSofa.obj"),
    "bookcase": ("BlendSwap-CC-0.sh3f", "blendswap-cc-0/bookcase/bookcase.obj"),
    "lamp": ("BlendSwap-CC-0.sh3f", "blendswap-cc-0/desklamp/desklamp.obj"),
    "plant": ("BlendSwap-CC-0.sh3f", "blendswap-cc-0/decorativePlant/decorativePlant.obj"),
    "basketball": ("BlendSwap-CC-0.sh3f", "blendswap-cc-0/basketball/basketball.obj"),
    "phone": ("Scopia.sh3f", "scopia/phone/phone.obj"),
}

TABLE_TOP = 0.7414  # metres
PLACES = [  # instance, model, centre x and z, height of what it stands on (metres), degrees about y, size
    ("table", "oak_table", 3.25, 2.30, 0.0, 8, 1.0),
    ("chair_1", "oak_chair", 3.10, 3.14, 0.0, 186, 0.9),
    ("chair_2", "thonet_chair", 4.05, 2.15, 0.0, -84, 1.0),
    ("chair_3", "oak_chair", 3.35, 1.47, 0.0, 4, 0.9),
    ("chair_4", "thonet_chair", 2.35, 2.42, 0.0, 100, 1.0),
    ("reading_chair", "thonet_chair", 5.25, 1.05, 0.0, -50, 1.0),
    ("sofa", "sofa", 1.75, 0.60, 0.0, 0, 1.0),
    ("bookcase", "bookcase", 3.70, 0.24, 0.0, 0, 1.0),
    ("second_bookcase", "bookcase", 4.66, 0.24, 0.0, 0, 1.0),
    ("lamp", "lamp", 3.50, 2.05, TABLE_TOP, 0, 1.0),
    ("phone", "phone", 3.02, 2.35, TABLE_TOP, -30, 1.0),
    ("plant", "plant", 5.30, 3.45, 0.0, 0, 1.35),
    ("ball", "basketball", 1.75, 2.05, 0.0, 0, 1.0),
]


def extract(catalogues, target):
    """Only the models' own folders: mesh, materials, textures, licence."""
    for name, (catalogue, mesh) in MODELS.items():
        folder = target / "meshes" / name
        folder.mkdir(parents=True, exist_ok=True)
        inside = mesh.rsplit("/", 1)[0] + "/"
        with zipfile.ZipFile(catalogues / catalogue) as archive:
            for entry in archive.namelist():
                if entry.startswith(inside) and not entry.endswith("/"):
                    (folder / Path(entry).name).write_bytes(archive.read(entry))


def bounds(path):
    """Smallest and largest corner of an OBJ's vertices that faces use, in metres."""
    vertices, used = [], set()
    with open(path, encoding="utf-8", errors="replace") as lines:
        for line in lines:
            words = line.split()
            if words[:1] == ["v"]:
                vertices.append([CENTIMETRE * float(word) for word in words[1:4]])
            elif words[:1] == ["f"]:
                for word in words[1:]:
                    index = int(word.split("/")[0])
                    used.add(index - 1 if index > 0 else len(vertices) + index)
    columns = list(zip(*(vertices[index] for index in used)))
    return [min(c) for c in columns], [max(c) for c in columns]


def transform(low, high, x, z, floor, degrees, size):
    """Puts the middle of the underside at (x, floor + GAP, z), turned about y and scaled."""
    middle_x, middle_z = size * (low[0] + high[0]) / 2, size * (low[2] + high[2]) / 2
    c, s = cos(radians(degrees)), sin(radians(degrees))
    translate = [x - (c * middle_x + s * middle_z), floor + GAP - size * low[1], z - (c * middle_z - s * middle_x)]
    return {"translate": [round(t, 5) for t in translate], "rotate": {"axis": [0, 1, 0], "degrees": degrees}, "scale": size}


def library(target):
    objects = [{"name": name, "mesh": f"meshes/{name}/{Path(mesh).name}"} for name, (_, mesh) in MODELS.items()]
    document = {"format": "rro-library/1", "defaults": {"unit": "cm"}, "objects": objects}
    (target / "library.json").write_text(json.dumps(document, indent=2) + "\n")


def manifest(target):
    own = os.path.relpath(SAMPLES / "library", target)
    box = {name: bounds(target / "meshes" / name / Path(mesh).name) for name, (_, mesh) in MODELS.items()}
    instances = [
        {"name": "room", "archive": f"{own}/room.rro", "materials": {"window": {"exitance": [7, 9, 12]}}},
        {"name": "ceiling_panel", "archive": f"{own}/ceiling_panel.rro", "transform": {"translate": [3.1, 2.79, 2.2]},
         "materials": {"panel": {"exitance": [120, 112, 98]}}},
    ]
    for name, model, x, z, floor, degrees, size in PLACES:
        instance = {"name": name, "archive": f"library/{model}.rro",
                    "transform": transform(*box[model], x, z, floor, degrees, size)}
        if model == "lamp":
            instance["materials"] = {"Material.002": {"exitance": [60, 50, 34]}}  # its shade
        instances.append(instance)
    scene = {
        "format": "rro-scene/1",
        "instances": instances,
        "camera": {"position": [0.3, 1.72, 4.3], "target": [3.2, 0.86, 1.5], "up": [0, 1, 0], "vertical_fov": 49},
        "accuracy": 0.1,
    }
    (target / "scene.json").write_text(json.dumps(scene, indent=2) + "\n")


def main(arguments):
    if len(arguments) == 3 and arguments[0] == "extract":
        extract(Path(arguments[1]), Path(arguments[2]))
    elif len(arguments) == 2 and arguments[0] == "library":
        library(Path(arguments[1]))
    elif len(arguments) == 2 and arguments[0] == "manifest":
        manifest(Path(arguments[1]).resolve())
    else:
        sys.exit(__doc__)


if __name__ == "__main__":
    main(sys.argv[1:])
