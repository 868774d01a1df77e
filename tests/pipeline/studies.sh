#!/usr/bin/env bash
# Studies as a user runs them: what accuracy costs (interrupted, resumed, with variants of the library), and the recipe that
# compares two versions of a library in continuous integration.
#
#   studies.sh RRO_COMPILE RRO_SOLVE SOURCE_DIR
source "$(dirname "${BASH_SOURCE[0]}")/prelude.sh"

# A box over a lamp in a room, small enough that every method takes milliseconds.
corners='v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 0 0 1\nv 1 0 1\nv 1 1 1\nv 0 1 1\n'
mkdir meshes scenes
{ printf "$corners"; printf 'f 4 3 2 1\nf 5 6 7 8\nf 1 2 6 5\nf 2 3 7 6\nf 3 4 8 7\nf 4 1 5 8\n'; } > meshes/box.obj
{ printf "$corners"; printf 'f 1 2 3 4\nf 8 7 6 5\nf 5 6 2 1\nf 6 7 3 2\nf 7 8 4 3\nf 8 5 1 4\n'; } > meshes/room.obj
library() { # library REFLECTANCE
    echo "{ \"format\": \"rro-library/1\", \"defaults\": { \"grid\": 6 }, \"objects\": [" \
         "{ \"name\": \"box\", \"mesh\": \"meshes/box.obj\", \"reflectance\": [$1, $1, $1] }," \
         "{ \"name\": \"room\", \"mesh\": \"meshes/room.obj\" } ] }"
}
library 0.5 > library.json
cat > scenes/scene.json <<'END'
{ "format": "rro-scene/1", "accuracy": 0.1, "instances": [
  { "name": "room", "archive": "../base/room.rro" },
  { "name": "box", "archive": "../base/box.rro", "transform": { "translate": [0.3, 0.2, 0.3], "scale": 0.2 } },
  { "name": "lamp", "archive": "../base/box.rro", "transform": { "translate": [0.4, 0.8, 0.4], "scale": 0.1 },
    "materials": { "*": { "exitance": [10, 10, 10] } } } ] }
END
"$compile" library library.json --out base --quiet

# Every method and knob; files that others read; run again it finds its runs, and writes the same.
sweep=("$solve" tradeoff --out cost --accuracy 0.4,0.2 scenes/scene.json --samples 64 --repeats 2)
"${sweep[@]}" > first.txt || fail "tradeoff: exit code $?"
for file in cost/tradeoff.csv cost/tradeoff.json cost/tradeoff.html; do [ -s $file ] || fail "no $file"; done
[ "$(grep -cE '^(reusable|hierarchical|reference) at 0\.[24] +[0-9]' first.txt)" -eq 6 ] || fail "not all ran: $(cat first.txt)"
grep -q '^not swept: grid 24' first.txt || fail "a knob without archives is not listed: $(cat first.txt)"
cp cost/tradeoff.csv first.csv
"${sweep[@]}" --quiet
cmp first.csv cost/tradeoff.csv || fail "finished runs were run again"
# A run that is missing, as after an interrupt, is made up for; the others stay.
kept=$(ls cost/runs/*.json | wc -l)
rm "$(ls cost/runs/*.0.json | head -1)"
"${sweep[@]}" --quiet
[ "$(ls cost/runs/*.json | wc -l)" -eq "$kept" ] || fail "a missing run was not made up for"
# Ctrl-C leaves whole files only, and what is finished stays.
status=0
timeout --preserve-status --signal INT 1 "$solve" tradeoff scenes/scene.json --out cut --samples 100000 --quiet || status=$?
[ "$status" -eq 130 ] || fail "interrupted: exit code $status, expected 130"
! compgen -G 'cut/*.csv' > /dev/null || fail "an interrupt left half a truth"

# Variants: named by their tables. A truth at hand: the CSV of `run`.
python3 "$source/samples/compile_variants.py" "$compile" library.json scenes/scene.json variants grid16 latlong > /dev/null
"$solve" run scenes/scene.json --method reference --samples 64 --radiosity truth.csv --quiet
"$solve" tradeoff scenes/scene.json --out other --accuracy 0.2 --methods reusable --repeats 1 --no-pictures \
    --variants variants --reference-file truth.csv > other.txt || fail "tradeoff with variants: exit code $?"
grep -q '^reusable at 0.2, grid 16 ' other.txt || fail "the variant of grid 16 is not swept: $(cat other.txt)"
# latlong differs from the library in its map alone.
grep -q '^reusable at 0.2, map latlong ' other.txt || fail "the variant of another map is not swept: $(cat other.txt)"
status=0
"$solve" tradeoff scenes/scene.json --out other --reference-file first.csv 2> stderr.txt || status=$?
[ "$status" -eq 3 ] || fail "a truth that is none: exit code $status, expected 3"
status=0
"$solve" tradeoff scenes/scene.json --out other --accuracy 0.1,7 2> stderr.txt || status=$?
[ "$status" -eq 2 ] || fail "an accuracy of 7: exit code $status, expected 2"

# The recipe: nothing to compare with; the same library; one that is darker.
recipe=("$source/samples/ci_compare.sh" "$(dirname "$solve")" library.json scenes/scene.json)
export RRO_RUNS=2 RRO_SLOWER=100 GITHUB_STEP_SUMMARY=$work/summary.md
"${recipe[@]}" none out > recipe.txt || fail "the recipe without a base: exit code $?"
grep -q 'nothing to compare with' recipe.txt || fail "the recipe does not say that there is no base"
[ ! -e summary.md ] || fail "the recipe posted without a base"
"${recipe[@]}" base out > recipe.txt || fail "the recipe with the same library: exit code $?"
grep -q '0 of 2 archives changed' summary.md || fail "the recipe posted: $(cat summary.md)"
library 0.1 > library.json
status=0
"${recipe[@]}" base out > recipe.txt 2> stderr.txt || status=$?
[ "$status" -eq 1 ] || fail "the recipe with a darker box: exit code $status, expected 1"
grep -q 'FAILED: difference of radiosity' summary.md || fail "the recipe posted: $(cat summary.md)"
grep -q '1 of 2 archives changed' summary.md || fail "the recipe posted: $(cat summary.md)"
echo "all of studies.sh passed"
