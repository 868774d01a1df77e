#!/usr/bin/env python3
"""Compiles every mesh under a folder, one after the other, and prints a Markdown table for README.md here.

    models.py RRO_COMPILE FOLDER [OPTION...]    options go to `rro-compile build`

Table errors are root mean squares between the directions of the tables, relative, as `rro-compile inspect` has them: the
median over the clusters that have tables. A mesh that fails has a row that says so, and the exit code is 1.
"""
import json
import subprocess
import sys
import tempfile
from pathlib import Path

ENDINGS = {".obj", ".ply", ".off", ".stl", ".gltf", ".glb"}
COLUMNS = ["model", "triangles", "patches", "clusters", "seconds", "MB", "bytes per triangle", "whole area error",
           "own area error", "visibility error"]


def row(compiler, mesh, options, work):
    """The cells of one mesh after its name, or the reason why there are none."""
    archive, report = work / "model.rro", work / "report.json"
    built = subprocess.run([compiler, "build", mesh, "--out", archive, "--report", report, "--quiet", *options],
                           stderr=subprocess.PIPE, text=True)
    if built.returncode != 0:
        return [built.stderr.strip().split("\n")[0] or f"exit code {built.returncode}"]
    seconds = json.loads(report.read_text())["archives"][0]["seconds"]
    facts = json.loads(subprocess.check_output([compiler, "inspect", archive, "--json"]))
    counts, size, errors = facts["counts"], facts["bytes"], facts.get("table_errors", {})
    medians = [errors.get(table, {}).get("median") for table in ("whole_area", "intrinsic_area", "patch_visibility")]
    return [f"{counts['triangles']:,}", f"{counts['patches']:,}", f"{counts['clusters']:,}", f"{seconds:.1f}",
            f"{size / 1e6:.2f}", f"{size / counts['triangles']:.0f}",
            *("" if median is None else f"{median:.3f}" for median in medians)]


def main(compiler, folder, *options):
    meshes = sorted(path for path in Path(folder).rglob("*") if path.suffix.lower() in ENDINGS)
    print("| " + " | ".join(COLUMNS) + " |")
    print("|---|" + "---:|" * (len(COLUMNS) - 1))
    failed = False
    with tempfile.TemporaryDirectory() as work:
        for mesh in meshes:
            cells = row(compiler, mesh, options, Path(work))
            failed = failed or len(cells) == 1
            print("| " + " | ".join([str(mesh.relative_to(folder)), *cells]) + " |", flush=True)
    return 1 if failed else 0


if __name__ == "__main__":
    if len(sys.argv) < 3:
        sys.exit(__doc__)
    sys.exit(main(*sys.argv[1:]))
