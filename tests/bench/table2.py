#!/usr/bin/env python3
"""The paper's Table 2: seconds, triangles and links of three methods at equal true error, as a Markdown table.

    table2.py RRO_COMPILE ACCURACY_BENCH FOLDER [RUNS [SCENE ...]]

Scenes: reading (a room of boxes: table, chairs, bookshelf with books, lamps; at most 1,500 triangles) and twelve (the
samples' room of twelve objects, its meshes decimated to at most 6,000 triangles together). Scenes and their references are made once
and kept in FOLDER. The classic method is asked for a fixed accuracy; what the others are asked for is searched until
their true error is the same, or as near as it gets. Then all three run RUNS (5) times by turns; seconds are medians."""

import json
import statistics
import subprocess
import sys
from pathlib import Path

sys.dont_write_bytecode = True  # the sources' folder stays clean

import decimate
import hall

HERE = Path(__file__).resolve().parent
SAMPLES = HERE.parents[1] / "samples"
METHODS = {"hierarchical": ["--method", "hierarchical"], "the paper's own": ["--transport", "plain"], "reusable": []}
REFERENCE_PATHS = {"reading": 8192, "twelve": 2048}  # per triangle
ASKED = {"reading": 0.1, "twelve": 0.3}  # of the classic method
TWELVE_TRIANGLES = 6000
NEAR = 1.05  # ratio of errors that count as equal
FLAT = 0.03  # change of the error that is none: asking for more does not help
MOST_TRIES = 7
COLUMNS = 12  # of accuracy_bench that are numbers

BOOKS = [((-0.5 + 0.095 * k, y + 0.13 + 0.01 * (k % 3), 0.02), (0.04 + 0.01 * (k % 4), 0.2 + 0.02 * (k % 3), 0.18))
         for y in (0.115, 0.515, 0.915, 1.315) for k in range(11)]


def reading_meshes(folder):
    """Boxes as in hall.py; a shell in tiles of about 1 m, seen from inside."""
    (folder / "reading.mtl").write_text("newmtl plain\nKd 0.5 0.5 0.5\nnewmtl panel\nKd 0.8 0.8 0.8\n")
    things = {name: hall.PLAIN[name] for name in ("chair", "table", "sofa", "desk_lamp", "ceiling_panel", "vase")}
    things["bookshelf"] = hall.PLAIN["bookshelf"] + BOOKS
    for name, boxes in things.items():
        with open(folder / f"{name}.obj", "w") as out:
            out.write(f"mtllib reading.mtl\nusemtl {'panel' if name == 'ceiling_panel' else 'plain'}\n")
            for k, (centre, size) in enumerate(boxes):
                hall.box(out, 8 * k + 1, centre, size)
    hall.shell(folder / "shell.obj", 2 * 2, 2 * 2)  # 7.2 m x 7.2 m
    return [*things, "shell"]


def reading_scene():
    def at(name, archive, x, y, z, degrees=0, reflectance=(0.5, 0.5, 0.5), exitance=None):
        material = {"reflectance": list(reflectance)} | ({"exitance": exitance} if exitance else {})
        return {"name": name, "archive": f"{archive}.rro", "materials": {"*": material},
                "transform": {"translate": [x, y, z], "rotate": {"axis": [0, 1, 0], "degrees": degrees}}}
    wood, cloth = (0.5, 0.35, 0.2), (0.55, 0.2, 0.15)
    return [
        at("shell", "shell", 0, 0, 0, reflectance=(0.65, 0.62, 0.55)),
        at("table", "table", 3.5, 0.001, 3.4, 8, wood),
        *(at(f"chair_{k}", "chair", x, 0.001, z, degrees, wood)
          for k, (x, z, degrees) in enumerate([(3.0, 4.1, 186), (4.0, 4.05, 174), (3.1, 2.7, -4), (4.1, 2.65, 10)])),
        at("bookshelf", "bookshelf", 3.4, 0.001, 0.3, 0, wood),
        at("sofa", "sofa", 6.4, 0.001, 3.6, -90, cloth),
        at("desk_lamp", "desk_lamp", 3.3, 0.743, 3.3, 30, (0.3, 0.3, 0.3)),
        at("vase", "vase", 3.9, 0.743, 3.5, 0, (0.1, 0.2, 0.45)),
        at("panel_1", "ceiling_panel", 3.5, 2.8, 3.4, 0, (0.8, 0.8, 0.8), [120, 112, 98]),
        at("panel_2", "ceiling_panel", 3.4, 2.8, 1.2, 0, (0.8, 0.8, 0.8), [60, 56, 49]),
    ]


def twelve_meshes(folder, instances):
    """Every mesh keeps the same share of its triangles."""
    names = [Path(i["archive"]).stem for i in instances]
    faces = {name: sum(line.startswith("f ") for line in open(SAMPLES / f"meshes/{name}.obj")) for name in names}
    share = TWELVE_TRIANGLES / sum(faces[name] for name in names)
    (folder / "materials.mtl").write_text((SAMPLES / "meshes/materials.mtl").read_text())
    while True:  # parts that cannot get smaller are made up for by the others
        left = {name: decimate.decimate(SAMPLES / f"meshes/{name}.obj", int(share * faces[name]), folder / f"{name}.obj")[1]
                for name in faces}
        if sum(left[name] for name in names) <= TWELVE_TRIANGLES:
            return list(faces)
        share *= 0.9


def make(scene, program, folder):
    """returns  the path of the manifest; what a run before has made is taken"""
    path = folder / "scene.json"
    if path.exists():
        return path
    if scene == "reading":
        names, instances = reading_meshes(folder), reading_scene()
    else:
        instances = json.loads((SAMPLES / "scenes/twelve_object_room.json").read_text())["instances"]
        names = twelve_meshes(folder, instances)
        instances = [i | {"archive": Path(i["archive"]).name} for i in instances]
    library = {"format": "rro-library/1", "objects": [{"name": name, "mesh": f"{name}.obj"} for name in names]}
    (folder / "library.json").write_text(json.dumps(library, indent=1))
    subprocess.run([program, "library", folder / "library.json", "--out", folder, "--quiet"], check=True)
    path.write_text(json.dumps({"format": "rro-scene/1", "instances": instances}, indent=1))
    return path


class Bench:
    def __init__(self, program, manifest, paths):
        self.program, self.manifest, self.paths = program, manifest, paths

    def run(self, method, asked):
        """returns  one solve: error, seconds, elements, links; prints where the reference stands at the first"""
        text = subprocess.run([self.program, self.manifest, str(self.paths), f"{asked:.5g}", "--reference-file",
                               self.manifest.with_suffix(".reference.csv"), *METHODS[method]],
                              check=True, capture_output=True, text=True).stdout
        first, names, values = text.splitlines()
        columns = names.replace("links s", "links_s").replace("iter. s", "iter_s").split()[:COLUMNS]
        row = dict(zip(columns, map(float, values.split()[:COLUMNS])))
        return row | {"asked": asked, "about": first}

    def search(self, method, error):
        """The solve whose error is nearest to this one."""
        asked, tried = error, []
        for _ in range(MOST_TRIES):
            tried.append(self.run(method, asked))
            last = tried[-1]["error"]
            if error / NEAR <= last <= error * NEAR:
                break
            if len(tried) > 1 and last > error and abs(last / tried[-2]["error"] - 1) < FLAT:
                break
            above = [t["asked"] for t in tried if t["error"] > error]
            below = [t["asked"] for t in tried if t["error"] <= error]
            if above and below:
                asked = (min(above) * max(below)) ** 0.5
            else:
                asked *= min(4, max(0.25, error / last))
            if not 0.002 <= asked <= 1:
                break
        def off(t):
            return max(t["error"] / error, error / t["error"]) if t["error"] > 0 else float("inf")
        nearest = min(map(off, tried))
        return min((t for t in tried if off(t) <= nearest * NEAR), key=lambda t: t["links"])


def main(compiler, program, folder, runs, scenes):
    print("| scene | method | asked | true error | triangles (elements) | links | rays | seconds | times faster | times fewer links |")
    print("|---|---|---:|---:|---:|---:|---:|---:|---:|---:|")
    for scene in scenes:
        (folder / scene).mkdir(parents=True, exist_ok=True)
        bench = Bench(program, make(scene, compiler, folder / scene), REFERENCE_PATHS[scene])
        classic = bench.run("hierarchical", ASKED[scene])
        rows = {method: classic if method == "hierarchical" else bench.search(method, classic["error"]) for method in METHODS}
        seconds = {method: [] for method in METHODS}
        for _ in range(runs):
            for method, row in rows.items():
                seconds[method].append(bench.run(method, row["asked"])["seconds"])
        slowest = statistics.median(seconds["hierarchical"])
        for method, row in rows.items():
            median = statistics.median(seconds[method])
            print(f"| {scene if method == 'hierarchical' else ''} | {method} | {row['asked']:.3g} | {row['error']:.4f} "
                  f"| {row['elements']:,.0f} | {row['links']:,.0f} | {row['rays']:,.0f} | {median:.3g} "
                  f"| {slowest / median:.2g} | {classic['links'] / row['links']:.2g} |", flush=True)
        print(f"{scene}: {classic['about'].split(': ', 1)[1]}", file=sys.stderr)


if __name__ == "__main__":
    if len(sys.argv) < 4:
        sys.exit("usage: table2.py RRO_COMPILE ACCURACY_BENCH FOLDER [RUNS [SCENE ...]]")
    main(sys.argv[1], sys.argv[2], Path(sys.argv[3]), int(sys.argv[4]) if len(sys.argv) > 4 else 5, sys.argv[5:] or list(ASKED))
