#!/usr/bin/env python3
"""Checks samples/read_archive.py, which was written from the documents alone, against archives.

    small_reader.py RRO_COMPILE RRO_SOLVE SOURCE_DIR
"""
import json
import math
import os
import subprocess
import sys
import tempfile

COMPILE, SOURCE = sys.argv[1], sys.argv[3]
sys.dont_write_bytecode = True
sys.path.insert(0, os.path.join(SOURCE, "samples"))
import read_archive  # noqa: E402

READER = os.path.join(SOURCE, "samples", "read_archive.py")


def alike(a, b):
    """Whether two JSON values agree; flatc prints floats with 6 digits."""
    if isinstance(a, dict) and isinstance(b, dict):
        return a.keys() == b.keys() and all(alike(a[key], b[key]) for key in a)
    if isinstance(a, list) and isinstance(b, list):
        return len(a) == len(b) and all(alike(x, y) for x, y in zip(a, b))
    if isinstance(a, float) or isinstance(b, float):
        return math.isclose(a, b, rel_tol=1e-5, abs_tol=1e-6)
    return a == b


def golden_archives_hold_what_flatc_read():
    count = 0
    for folder, _, files in os.walk(os.path.join(SOURCE, "tests", "golden")):
        for name in (name for name in files if name.endswith(".rro")):
            path = os.path.join(folder, name)
            found = json.loads(subprocess.check_output([sys.executable, READER, path, "--json"]))
            with open(path.replace(".rro", ".json"), encoding="utf-8") as file:
                expected = json.load(file)
            for section, fields in expected.items():
                assert alike(fields, found[section]), f"{path}: section {section} differs from flatc's"
            count += 1
    assert count >= 3


def faults_of_container_and_wire_are_refused():
    count = 0
    folder = os.path.join(SOURCE, "tests", "corrupt")
    for name in sorted(os.listdir(folder)):
        if name.startswith(("header_", "directory_", "entry_", "section_", "padding", "tail", "zlib_", "wire_")):
            try:
                read_archive.read(os.path.join(folder, name))
            except read_archive.ArchiveError:
                count += 1
            else:
                raise AssertionError(f"{name} was read")
    assert count > 50


def effective_areas_of_a_box_are_its_projected_areas(work):
    """Two independent programs and a closed form meet: compiler, documents, geometry."""
    mesh = os.path.join(work, "box.obj")
    with open(mesh, "w", encoding="utf-8") as file:
        for i in range(8):
            file.write(f"v {2 * (i & 1)} {3 * (i >> 1 & 1)} {5 * (i >> 2)}\n")
        file.write("f 1 3 4 2\nf 5 6 8 7\nf 1 2 6 5\nf 3 7 8 4\nf 1 5 7 3\nf 2 4 8 6\n")
    for grid, grid_map in ((12, "octahedral"), (13, "octahedral"), (12, "latlong"), (13, "latlong")):
        path = os.path.join(work, f"{grid_map}{grid}.rro")
        subprocess.check_call([COMPILE, "build", mesh, "--out", path, "--grid", str(grid), "--map", grid_map, "--quiet"])
        archive = read_archive.read(path)
        difference = total = 0
        for k in range(400):
            y, turn = 1 - (2 * k + 1) / 400, math.pi * (1 + math.sqrt(5)) * k
            r = math.sqrt(1 - y * y)
            x, z = r * math.cos(turn), r * math.sin(turn)
            exact = 15 * abs(x) + 10 * abs(y) + 6 * abs(z)
            difference += (read_archive.effective_area(archive, (x, y, z)) - exact) ** 2
            total += exact ** 2
        error, stored = math.sqrt(difference / total), archive["errors"]["whole"][0]
        # 400 directions against the archive's own 24; both lie off the nodes.
        assert 0.4 * stored < error < 2 * stored, f"{grid_map} {grid}: error {error}, the archive says {stored}"
        # Across the seam of longitudes, the folds of the octahedron and its corners the area does not jump.
        for x, y, z in ((1, 0.3, 0), (-1, 0.2, 0), (-1, -0.7, 0), (0, -0.5, 1), (0, -0.1, -1), (0.6, 0, 0.8), (0, -1, 0)):
            if grid_map == "latlong" and x == z == 0:
                continue  # a pole has no longitude
            found = [read_archive.effective_area(archive, (x + dx * 1e-9, y + dy * 1e-9, z + dz * 1e-9))
                     for dx, dy, dz in ((1, 1, 1), (-1, -1, -1), (1, -1, -1), (-1, 1, -1))]
            assert max(found) - min(found) < 1e-5 * max(found), f"{grid_map} {grid}: a jump at {x, y, z}: {found}"


def main():
    golden_archives_hold_what_flatc_read()
    faults_of_container_and_wire_are_refused()
    with tempfile.TemporaryDirectory() as work:
        effective_areas_of_a_box_are_its_projected_areas(work)
    print("all of small_reader.py passed")


if __name__ == "__main__":
    main()
