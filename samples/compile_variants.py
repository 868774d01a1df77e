#!/usr/bin/env python3
"""Compiles the objects of a scene several times, with other tables each time, for `rro-solve tradeoff --variants OUT`.

    samples/compile_variants.py RRO_COMPILE LIBRARY.json SCENE.json OUT [VARIANT...]

OUT gets one folder of archives for each variant below, or for those named; what has not changed is left alone. Objects are
looked up in LIBRARY.json by the names of the archives that the scene refers to."""

import json
import subprocess
import sys
from pathlib import Path

VARIANTS = {
    "grid6": {"grid": 6},
    "grid16": {"grid": 16},
    "grid24": {"grid": 24},
    "latlong": {"map": "latlong"},
    "all_tables": {"tables": "all"},
}


def archives_of(scene):
    for instance in json.loads(scene.read_text())["instances"]:
        archive = instance["archive"]
        yield Path(archive if isinstance(archive, str) else archive["path"]).stem


def main(compiler, library, scene, out, names):
    described = json.loads(library.read_text())
    wanted = set(archives_of(scene))
    objects = [dict(o, mesh=str((library.parent / o["mesh"]).resolve())) for o in described["objects"] if o["name"] in wanted]
    if missing := wanted - {o["name"] for o in objects}:
        sys.exit(f"{library} has no objects for {', '.join(sorted(missing))}")
    if unknown := set(names) - VARIANTS.keys():
        sys.exit(f"no variant {', '.join(sorted(unknown))}; there are {', '.join(VARIANTS)}")
    for name in names or VARIANTS:
        folder = out / name
        folder.mkdir(parents=True, exist_ok=True)
        defaults = {**described.get("defaults", {}), **VARIANTS[name]}
        variant = folder / "library.json"
        variant.write_text(json.dumps({"format": described["format"], "defaults": defaults, "objects": objects}, indent=2))
        subprocess.run([compiler, "library", variant, "--out", folder], check=True)


if __name__ == "__main__":
    if len(sys.argv) < 5:
        sys.exit(__doc__)
    main(sys.argv[1], *(Path(a) for a in sys.argv[2:5]), sys.argv[5:])
