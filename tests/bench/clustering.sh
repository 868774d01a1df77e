#!/usr/bin/env bash
# What the five factors of clustering are worth: each object is compiled with several weights, lit by one small lamp over a
# black floor, and solved; error against the same Monte Carlo reference, and links. Prints a Markdown table.
#
#   tests/bench/clustering.sh RRO_COMPILE ACCURACY_BENCH SAMPLES ACCURACY MESH...
set -euo pipefail

if [ $# -lt 5 ]; then
    echo "usage: tests/bench/clustering.sh RRO_COMPILE ACCURACY_BENCH SAMPLES ACCURACY MESH..." >&2
    exit 2
fi
compiler=$1 bench=$2 samples=$3 accuracy=$4
shift 4
work=$(mktemp --directory)
trap 'rm -rf "$work"' EXIT

# proximity, orientation, reflectivity, aspect ratio, size
declare -A weights=(
    [1 the defaults]=1,10,0.5,0.25,0.25
    [2 proximity alone]=1,0,0,0,0
    [3 no orientation]=1,0,0.5,0.25,0.25
    [4 orientation 1]=1,1,0.5,0.25,0.25
    [5 orientation 4]=1,4,0.5,0.25,0.25
    [6 no reflectivity]=1,10,0,0.25,0.25
    [7 no aspect]=1,10,0.5,0,0.25
    [8 no size]=1,10,0.5,0.25,0
    [9 the last three x 10]=1,10,5,2.5,2.5
)

cat >"$work/stage.obj" <<'OBJ'
v -2 0 -2
v -2 0 2
v 2 0 2
v 2 0 -2
f 1 2 3 4
OBJ
cat >"$work/lamp.obj" <<'OBJ'
v -0.1 0 -0.1
v 0.1 0 -0.1
v 0.1 0 0.1
v -0.1 0 0.1
f 1 2 3 4
OBJ
for name in stage lamp; do "$compiler" build "$work/$name.obj" --out "$work/$name.rro" --two-sided no --quiet; done

echo "| object | weights | error | links | seconds |"
echo "|---|---|---|---|---|"
for mesh in "$@"; do
    name=$(basename "${mesh%.*}")
    for key in "${!weights[@]}"; do
        "$compiler" build "$mesh" --out "$work/object.rro" --cluster-weights "${weights[$key]}" --quiet
        # The object, as large as it is, on a floor as large, under a lamp to one side.
        read -r size x y z < <("$compiler" inspect "$work/object.rro" --json | python3 -c '
import json, sys
bounds = json.load(sys.stdin)["bounds"]
low, high = bounds["lo"], bounds["hi"]
size = max(h - l for l, h in zip(low, high))
print(size, -(low[0] + high[0]) / 2, -low[1], -(low[2] + high[2]) / 2)')
        cat >"$work/scene.json" <<JSON
{"format": "rro-scene/1", "instances": [
  {"name": "object", "archive": "object.rro", "transform": {"translate": [$x, $y, $z]},
   "materials": {"*": {"exitance": [0, 0, 0]}}},
  {"name": "stage", "archive": "stage.rro", "transform": {"scale": $size}, "materials": {"*": {"reflectance": [0, 0, 0]}}},
  {"name": "lamp", "archive": "lamp.rro",
   "transform": {"scale": $size, "translate": [$size, $(python3 -c "print(1.8 * $size)"), $size]},
   "materials": {"*": {"exitance": [100, 100, 100]}}}]}
JSON
        "$bench" "$work/scene.json" "$samples" "$accuracy" |
            awk -v name="$name" -v key="${key#* }" -v order="${key%% *}" \
                'NR == 3 { printf "%s| %s | %s | %s | %s | %s |\n", order, name, key, $2, $9, $6 }'
    done | sort | cut -c2-
done
