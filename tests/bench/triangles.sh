#!/usr/bin/env bash
# What a solve costs against the triangles of its objects: one smooth object at several resolutions, placed six times in
# one room, everything else alike. Prints a Markdown table; solves take turns, the medians count.
#
#   tests/bench/triangles.sh RRO_COMPILE RRO_SOLVE WORK     WORK: a folder for meshes, archives and reports; kept
#
#   COUNTS="10000 100000" ACCURACY=0.1 RUNS=1 tests/bench/triangles.sh ...     other counts, accuracy (0.05), solves (3)
set -euo pipefail

if [ $# -ne 3 ]; then
    echo "usage: tests/bench/triangles.sh RRO_COMPILE RRO_SOLVE WORK" >&2
    exit 2
fi
compiler=$1 solver=$2 work=$3
counts=${COUNTS:-10000 30000 100000 300000 1000000}
accuracy=${ACCURACY:-0.05}
runs=${RUNS:-3}
here=$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)
mkdir -p "$work"

# The room, seen from inside, 4 x 2.6 x 4 m in squares of some 0.5 m, and a lamp below its ceiling.
python3 - "$work" <<'PY'
import sys
def grid(out, first, corner, u, v, n):
    for j in range(n + 1):
        for i in range(n + 1):
            out.write("v %g %g %g\n" % tuple(corner[c] + u[c] * i / n + v[c] * j / n for c in range(3)))
    for j in range(n):
        for i in range(n):
            a = first + j * (n + 1) + i
            out.write(f"f {a} {a + 1} {a + n + 2} {a + n + 1}\n")
    return first + (n + 1) ** 2
x, y, z = (4, 0, 0), (0, 2.6, 0), (0, 0, 4)
back = lambda a: tuple(-c for c in a)
o, c = (-2, 0, -2), (2, 2.6, 2)
with open(sys.argv[1] + "/room.obj", "w") as out:
    n = 1
    for corner, u, v in ((o, z, x), (o, x, y), (o, y, z), (c, back(x), back(z)), (c, back(y), back(x)), (c, back(z), back(y))):
        n = grid(out, n, corner, u, v, 8)
with open(sys.argv[1] + "/lamp.obj", "w") as out:
    grid(out, 1, (-0.4, 2.55, -0.4), (0.8, 0, 0), (0, 0, 0.8), 2)
PY
for name in room lamp; do "$compiler" build "$work/$name.obj" --out "$work/$name.rro" --two-sided no --quiet; done

for count in $counts; do
    if [ ! -f "$work/wavy_$count.rro" ]; then
        python3 "$here/wavy_sphere.py" "$count" "$work/wavy_$count.obj"
        "$compiler" build "$work/wavy_$count.obj" --out "$work/wavy_$count.rro" --quiet
    fi
    python3 - "$count" >"$work/scene_$count.json" <<'PY'
import json, sys
places = [(-1.1, 0.5, -1.0, 0), (0.9, 0.5, -1.2, 40), (-0.9, 0.5, 1.0, 80), (1.1, 0.5, 0.9, 120),
          (0, 1.4, -0.2, 160), (-0.1, 0.5, 0.1, 200)]
room = [{"name": "room", "archive": "room.rro", "materials": {"*": {"reflectance": [0.7, 0.6, 0.5]}}},
        {"name": "lamp", "archive": "lamp.rro", "materials": {"*": {"reflectance": [0, 0, 0], "exitance": [60, 58, 52]}}}]
objects = [{"name": f"object {k}", "archive": f"wavy_{sys.argv[1]}.rro", "materials": {"*": {"reflectance": [0.4, 0.5, 0.6]}},
            "transform": {"translate": [x, y, z], "rotate": {"axis": [0, 1, 0], "degrees": turn}}}
           for k, (x, y, z, turn) in enumerate(places)]
json.dump({"format": "rro-scene/1", "instances": room + objects}, sys.stdout)
PY
done

for run in $(seq "$runs"); do
    for count in $counts; do
        # Exit 1: the estimate stayed above the accuracy; the table says so.
        "$solver" run "$work/scene_$count.json" --accuracy "$accuracy" --report "$work/report_${count}_$run.json" --quiet || [ $? -eq 1 ]
    done
done

python3 - "$work" "$runs" $counts <<'PY'
import json, statistics, sys
print("| triangles per object | in the scene | links | elements | rays | links, s | iterate, s | links and iterate, s | load, s | estimate | peak, MB |")
print("|---:|---:|---:|---:|---:|---:|---:|---:|---:|---:|---:|")
for count in sys.argv[3:]:
    runs = [json.load(open(f"{sys.argv[1]}/report_{count}_{k}.json")) for k in range(1, int(sys.argv[2]) + 1)]
    r = runs[0]
    def median(*phases):
        return statistics.median(sum(run["seconds"][phase] for phase in phases) for run in runs)

    links, iterate, load = median("links", "visibility"), median("iterate"), median("load")
    both = median("links", "visibility", "iterate")
    print(f"| {int(count):,} | {r['triangles']:,} | {r['links']['total']:,} | {r['elements']:,} | {r['rays']:,} | {links:.2f} | {iterate:.2f} "
          f"| {both:.2f} | {load:.2f} | {r['estimated_error']:.3f}{'' if r['converged'] else ' (above)'} | {r['memory_peak_bytes'] / 1e6:.0f} |")
PY
