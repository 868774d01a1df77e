#!/usr/bin/env bash
# Effects as a user meets them: called for by the manifest, explained, solved by closed forms, refused where they make no
# sense.
#
#   effects.sh RRO_COMPILE RRO_SOLVE SOURCE_DIR
source "$(dirname "${BASH_SOURCE[0]}")/prelude.sh"

# ends WHAT STATUS PATTERN COMMAND...: the exit code, and a line on standard error that matches.
ends() {
    local what=$1 expected=$2 pattern=$3 status=0
    shift 3
    "$@" > stdout.txt 2> stderr.txt || status=$?
    [ "$status" -eq "$expected" ] || fail "$what: exit code $status, expected $expected: $(cat stderr.txt)"
    grep -qE "$pattern" stderr.txt || fail "$what: expected /$pattern/ in: $(cat stderr.txt)"
}

# A plate of two sides, and a room seen from inside.
printf 'v 0 0 0\nv 0 0 1\nv 1 0 1\nv 1 0 0\nf 1 2 3 4\n' > plate.obj
printf 'v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 0 0 1\nv 1 0 1\nv 1 1 1\nv 0 1 1\nf 1 2 3 4\nf 8 7 6 5\nf 5 6 2 1\nf 6 7 3 2\nf 7 8 4 3\nf 8 5 1 4\n' > room.obj
"$compile" build plate.obj room.obj --out . --quiet

scene() { # scene ARCHIVE MATERIAL MORE
    echo "{ \"format\": \"rro-scene/1\", \"instances\": [ { \"name\": \"it\", \"archive\": \"$1.rro\"," \
         "\"materials\": { \"*\": { $2 } } } ] $3 }"
}

# close FILE COLUMN VALUE: every row of a CSV.
close() {
    awk -F, -v column="$2" -v value="$3" 'NR > 1 && ($column - value) ^ 2 > 1e-8 * (1 + value ^ 2) { bad = 1 } END { exit bad || NR < 2 }' "$1" ||
        fail "$1: column $2 is not $3: $(tail -1 "$1")"
}

# A uniform sky over a plate: E = pi L on both sides; what is let through adds to the other side.
reference=(--method reference --samples 16 --quiet --radiosity out.csv)
reusable=(--accuracy 0.02 --quiet --radiosity out.csv)
scene plate '"reflectance": [0.3, 0.3, 0.3], "transmittance": [0.5, 0, 0]' ', "sky": { "radiance": [1, 1, 1], "ground": true }' > sky.json
"$solve" run sky.json "${reference[@]}"
close out.csv 3 0.942478   # front: 0.3 pi
close out.csv 9 1.570796   # back: 0.5 pi
close out.csv 10 0
"$solve" run sky.json "${reusable[@]}"
close out.csv 3 0.942478
close out.csv 9 1.570796
# The sun at 60 degrees: half of its irradiance.
scene plate '"reflectance": [0.5, 0.5, 0.5]' ', "sun": { "direction": [0.8660254037844386, -0.5, 0], "irradiance": [100, 80, 60], "angular_diameter": 0 }' > sun.json
"$solve" run sun.json "${reference[@]}"
close out.csv 6 50
close out.csv 7 40
"$solve" run sun.json "${reusable[@]}"
close out.csv 6 50
# A closed room gets exactly nothing, and neither does anything behind an endless medium.
scene room '"reflectance": [0.5, 0.5, 0.5]' ', "sky": { "radiance": [1, 1, 1] }, "sun": { "direction": [0.1, -1, 0.2], "irradiance": [9, 9, 9] }' > closed.json
"$solve" run closed.json "${reference[@]}"
awk -F, 'NR > 1 && ($3 != 0 || $6 != 0) { exit 1 }' out.csv || fail "a closed room has light: $(tail -1 out.csv)"
"$solve" run closed.json "${reusable[@]}"
awk -F, 'NR > 1 && ($3 != 0 || $6 != 0) { exit 1 }' out.csv || fail "a closed room has light: $(tail -1 out.csv)"
sed 's/}$/, "medium": { "absorption": [0.1, 0.1, 0] } }/' sky.json > fog.json
"$solve" run fog.json "${reference[@]}"
close out.csv 3 0
close out.csv 5 0.942478
"$solve" run fog.json "${reusable[@]}"
close out.csv 3 0
close out.csv 5 0.942478

# Explained: every effect, with a reason; work is predicted for those that are on.
"$solve" explain sky.json --json > plan.json
python3 - <<'END' || fail "explain --json: $(cat plan.json)"
import json
plan = json.load(open("plan.json"))
effects = {e["name"]: e for e in plan["effects"]}
assert len(effects) == 12 and all(e["reason"] for e in effects.values())
assert [n for n, e in effects.items() if e["on"]] == ["colour", "sky", "transmission"], effects
assert plan["predicted"]["seconds"] == 0 and plan["channels"] == 3
END
"$solve" explain closed.json | grep -qE '^  sun +on .* irradiance 9 W/m\^2$' || fail "explain has no row of the sun"

# No light is exactly nothing, at once, and is said.
scene room '"reflectance": [0.5, 0.5, 0.5]' '' > dark.json
ends "no light" 0 "nothing gives light" "$solve" run dark.json --radiosity out.csv
close out.csv 3 0

# What cannot be.
ends "an effect that the method lacks" 2 "sky: --method hierarchical does not support it" "$solve" run sky.json --method hierarchical
ends "a transport that lacks it" 2 "sky: --transport plain does not support it" "$solve" run sky.json --transport plain
scene room '"transmittance": [0.1, 0.1, 0.1]' '' > bad.json
ends "transmittance of one side" 3 'bad.json: /instances/0/materials: material "default" of room.rro has a transmittance' "$solve" run bad.json
scene plate '"reflectance": [0.6, 0.5, 0.5], "transmittance": [0.4, 0, 0]' '' > bad.json
ends "more light than comes" 3 "/transmittance/0: found 0.4 beside a reflectance of 0.6" "$solve" run bad.json
scene plate '' ', "sky": { "image": "plate.obj" }' > bad.json
ends "no picture" 3 "bad.json: /sky/image: plate.obj: is neither a Radiance picture" "$solve" run bad.json
scene plate '' ', "lights": [ { "name": "a", "type": "ies", "position": [0, 1, 0], "file": "plate.obj" } ]' > bad.json
ends "no photometric file" 3 "bad.json: /lights/0/file: plate.obj: has no line \"TILT=" "$solve" run bad.json
echo "all of effects.sh passed"
