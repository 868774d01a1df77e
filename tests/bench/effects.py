#!/usr/bin/env python3
"""What scenes pay for: scenes by effects, as a Markdown table, and what `rro-solve explain` predicts against what a solve takes.

    tests/bench/effects.py RRO_SOLVE [RUNS]

Needs samples/library. Times are medians of RUNS (5) interleaved solves, each scene once per round; actual seconds are of links, visibility and iteration, as
processor seconds divided by threads, so that other work on the machine counts for little."""

import json
import os
import statistics
import subprocess
import sys
import tempfile
from pathlib import Path

SAMPLES = Path(__file__).resolve().parents[2] / "samples"
GREY = ["--without", "colour"]
SCENES = [  # name, manifest (None: a single convex box that shines), options
    ("bare box", None, ["--accuracy", "0.1"]),
    ("grey room", "cornell", ["--accuracy", "0.1", *GREY]),
    ("colour room", "cornell", ["--accuracy", "0.1"]),
    ("grey room", "cornell", ["--accuracy", "0.05", *GREY]),
    ("colour room", "cornell", ["--accuracy", "0.05"]),
    ("textures", "textures", ["--accuracy", "0.1"]),
    ("twelve objects", "twelve_object_room", ["--accuracy", "0.3"]),
    ("twelve objects", "twelve_object_room", ["--accuracy", "0.1"]),
    ("room with sky", "sky_room", []),
    ("courtyard with sun", "courtyard", []),
    ("lamp shade", "lamp_shade", []),
    ("foggy hall", "foggy_hall", []),
    ("spots", "spots", []),
    ("light groups", "groups", ["--without", "lights"]),
]


def box_scene(folder):
    scene = {"format": "rro-scene/1", "instances": [{
        "name": "box", "archive": str(SAMPLES / "library/pedestal.rro"),
        "materials": {"*": {"reflectance": [0.5, 0.5, 0.5], "exitance": [1, 1, 1]}}}]}
    path = folder / "box.json"
    path.write_text(json.dumps(scene))
    return path


def solve(program, manifest, options, report):
    run = subprocess.Popen([program, "run", manifest, "--report", report, "--quiet", *options], stderr=subprocess.DEVNULL)
    _, status, usage = os.wait4(run.pid, 0)
    run.returncode = os.waitstatus_to_exitcode(status)
    if run.returncode not in (0, 1):  # 1: less accurate than asked
        sys.exit(f"{manifest}: rro-solve ended with {run.returncode}")
    result = json.loads(report.read_text())
    phases = sum(result["seconds"][p] for p in ("links", "visibility", "iterate"))
    result["work"] = (usage.ru_utime + usage.ru_stime) * phases / result["seconds"]["total"]
    return result


def main(program, runs):
    rows = []
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        for scene, manifest, options in SCENES:
            path = SAMPLES / "scenes" / f"{manifest}.json" if manifest else box_scene(folder)
            told = json.loads(subprocess.run([program, "explain", path, "--json", "--quiet", *options], check=True,
                                             capture_output=True, text=True).stdout)
            rows.append({"scene": scene, "path": path, "options": options, "told": told, "reports": []})
        for _ in range(runs):
            for row in rows:
                row["reports"].append(solve(program, row["path"], row["options"], folder / "report.json"))
    print(f"Medians of {runs} interleaved runs.\n")
    print("| scene | asked | channels | effects on | links: predicted, actual | rays: predicted, actual | seconds: predicted, actual "
          "| ratio | seconds per effect |")
    print("|---|---:|---:|---|---|---|---|---:|---|")
    for row in rows:
        told, reports = row["told"], row["reports"]
        first, predicted = reports[0], told["predicted"]
        seconds = statistics.median(r["work"] for r in reports) / told["threads"]
        on = ", ".join(e["name"] for e in first["effects"] if e["on"])
        parts = ", ".join(f"{e['name']} {statistics.median(r['effects'][i]['seconds'] for r in reports):.2g}"
                          for i, e in enumerate(first["effects"]) if e["seconds"] > 0)
        ratio = f"{predicted['seconds'] / seconds:.2f}" if seconds > 1e-2 else ""
        print(f"| {row['scene']} | {told['accuracy']:g} | {told['channels']} | {on} | {predicted['links']:,}, {first['links']['total']:,} "
              f"| {predicted['rays']:,}, {first['rays']:,} | {predicted['seconds']:.2g}, {seconds:.2g} | {ratio} | {parts} |")


if __name__ == "__main__":
    if len(sys.argv) not in (2, 3):
        sys.exit("usage: tests/bench/effects.py RRO_SOLVE [RUNS]")
    main(sys.argv[1], int(sys.argv[2]) if len(sys.argv) == 3 else 5)
