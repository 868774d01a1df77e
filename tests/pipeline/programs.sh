#!/usr/bin/env bash
# Both programs as a user runs them: compile, solve, move an object, and answer bad input with exit code 3, one clear
# error and no output file.
#
#   programs.sh RRO_COMPILE RRO_SOLVE SOURCE_DIR
source "$(dirname "${BASH_SOURCE[0]}")/prelude.sh"
mkdir library

# refused WHAT PATTERN COMMAND...: exit code 3, a line that matches, no file named `output`.
refused() {
    local what=$1 pattern=$2 status=0
    shift 2
    "$@" > stdout.txt 2> stderr.txt || status=$?
    [ "$status" -eq 3 ] || fail "$what: exit code $status, expected 3: $(cat stderr.txt)"
    grep -qE "$pattern" stderr.txt || fail "$what: expected /$pattern/ in: $(cat stderr.txt)"
    ! compgen -G 'output*' > /dev/null || fail "$what: left a file behind"
}

cat > box.obj <<'END'
v 0 0 0
v 1 0 0
v 1 1 0
v 0 1 0
v 0 0 1
v 1 0 1
v 1 1 1
v 0 1 1
f 4 3 2 1
f 5 6 7 8
f 1 2 6 5
f 2 3 7 6
f 3 4 8 7
f 4 1 5 8
END
"$compile" build box.obj --out library/box.rro --quiet
"$compile" verify library/box.rro > /dev/null
"$compile" build "$source/samples/meshes/cornell_lamp.obj" --two-sided no --out library/lamp.rro --quiet

# differs STATUS PATTERN A.rro B.rro: what diff exits with and says.
differs() {
    local status=0
    "$compile" diff "$3" "$4" > stdout.txt || status=$?
    [ "$status" -eq "$1" ] || fail "diff $3 $4: exit code $status, expected $1: $(cat stdout.txt)"
    grep -qE "$2" stdout.txt || fail "diff $3 $4: expected /$2/ in: $(cat stdout.txt)"
}

# Versions of an object: the same file, the same content, another colour, another corner.
mkdir white red tall
printf 'newmtl paint\nKd 0.5 0.5 0.5\n' > white/paint.mtl
printf 'newmtl paint\nKd 0.5 0.25 0.25\n' > red/paint.mtl
cp white/paint.mtl tall/
for folder in white red; do { echo "mtllib paint.mtl"; echo "usemtl paint"; cat box.obj; } > $folder/box.obj; done
sed 's/^v 1 1 1$/v 1 1.5 1/' white/box.obj > tall/box.obj
for folder in white red tall; do "$compile" build $folder/box.obj --out $folder.rro --quiet; done
differs 0 "the same, byte for byte" white.rro white.rro
differs 1 '^materials +"paint": reflectance \(0.5, 0.5, 0.5\) -> \(0.5, 0.25, 0.25\)' white.rro red.rro
differs 1 'triangles? moved: .* by 0.5 m.*\(1, 1, 1\) -> \(1, 1.5, 1\)' white.rro tall.rro
status=0
"$compile" diff white.rro tall.rro --json > diff.json || status=$?
[ "$status" -eq 1 ] || fail "diff --json: exit code $status, expected 1"
grep -q '"kind": "triangles_moved"' diff.json || fail "diff --json has no triangles_moved"

scene() { # scene X: a box at height X, lit by a lamp from above
    cat <<END
{ "format": "rro-scene/1", "accuracy": 0.1, "instances": [
  { "name": "box", "archive": "library/box.rro", "transform": { "translate": [0, $1, 0], "scale": 0.2 } },
  { "name": "lamp", "archive": "library/lamp.rro", "materials": { "*": { "exitance": [10, 10, 10] } } } ] }
END
}

# Moving an object touches no archive and changes the light.
scene 0 > scene.json
before=$(stat -c '%n %Y' library/*; sha256sum library/*)
"$solve" run scene.json --radiosity low.csv --out low.glb --picture low.png --size 64x48 --report low.json --quiet
scene 0.2 > scene.json
"$solve" run scene.json --radiosity high.csv --quiet
[ "$before" = "$(stat -c '%n %Y' library/*; sha256sum library/*)" ] || fail "a solve touched an archive"
! cmp -s low.csv high.csv || fail "moving the box changed nothing"
[ "$(wc -l < low.csv)" -eq $((1 + 12 + $("$compile" inspect library/lamp.rro | sed -n 's/^mesh *\([0-9]*\) .*/\1/p'))) ] ||
    fail "the CSV must have a row for every triangle"
for file in low.glb low.png low.json; do [ -s "$file" ] || fail "$file is empty"; done
head -c 4 low.glb | grep -q glTF || fail "low.glb is no glTF"

# The same bits for any number of threads.
"$solve" run scene.json --radiosity one.csv --threads 1 --quiet
cmp high.csv one.csv || fail "--threads changed the result"
"$compile" build box.obj --out again.rro --threads 1 --quiet
cmp again.rro library/box.rro || fail "--threads changed an archive"

# The classic method ends with 0, whatever its estimate, and says its links.
"$solve" run scene.json --method hierarchical --report classic.json --quiet || fail "--method hierarchical: exit code $?"
grep -q '"near": [1-9]' classic.json || fail "--method hierarchical has no links"
status=0
"$solve" run scene.json --method hierarchical --transport plain --quiet 2> stderr.txt || status=$?
[ "$status" -eq 2 ] || fail "--method hierarchical --transport: exit code $status, expected 2"

# Two versions of a library: the same one passes any threshold, another colour does not, a missing archive is named.
mkdir versions versions/old versions/new versions/half
cp library/box.rro library/lamp.rro versions/old
cp red.rro versions/new/box.rro
cp library/lamp.rro versions/new
cp library/box.rro versions/half
"$solve" compare scene.json --base library --head versions/old --runs 1 --fail-if-differs 0 --json same.json > same.txt ||
    fail "compare: a copy of the library differs"
grep -q '"relative_rms": 0.0' same.json || fail "compare: a copy of the library differs: $(cat same.txt)"
status=0
"$solve" compare scene.json --base versions/old --head versions/new --runs 1 --fail-if-differs 0.01 --markdown change.md \
    > /dev/null 2> stderr.txt || status=$?
[ "$status" -eq 1 ] || fail "compare over a threshold: exit code $status, expected 1"
grep -q 'FAILED: difference of radiosity' change.md || fail "compare: the Markdown does not say why"
status=0
"$solve" compare scene.json --base versions/old --head versions/half 2> stderr.txt || status=$?
[ "$status" -eq 3 ] || fail "compare without an archive: exit code $status, expected 3"
grep -q 'lamp.rro' stderr.txt || fail "compare: the missing archive is not named: $(cat stderr.txt)"

# View factors: the box seen by a lid over it, exact, all pairs; groups; output by threshold; closing an open scene fails.
cat > lid.obj <<'END'
v -1 2 -1
v 2 2 -1
v 2 2 2
v -1 2 2
usemtl paint
f 1 2 3 4
END
"$compile" build lid.obj --two-sided no --out library/lid.rro --quiet
cat > factors.json <<'END'
{ "format": "rro-scene/1", "instances": [ { "name": "box", "archive": "library/box.rro" },
  { "name": "lid, above", "archive": "library/lid.rro" } ] }
END
"$solve" factors factors.json --out factors.csv --report factors.report.json > stdout.txt
head -1 factors.csv | grep -qx 'from,to,factor,area_from,standard_error' || fail "factors: another head of the CSV"
[ "$(wc -l < factors.csv)" -eq 5 ] || fail "factors: expected 4 ordered pairs"
grep -q '^"lid, above","lid, above",0,9,0$' factors.csv || fail "factors: a lid sees itself: $(cat factors.csv)"
head -1 stdout.txt | grep -q '^closure' || fail "factors: closure must be said first"
grep -q '"largest_defect"' factors.report.json || fail "factors: no closure in the report"
"$solve" factors factors.json --out sparse.csv --threshold 0.001 --quiet
[ "$(wc -l < sparse.csv)" -eq 3 ] || fail "factors: --threshold must leave two pairs"
"$solve" factors factors.json --out factors.out.json --by material --quiet
"$solve" factors factors.json --out again.json --by material --reuse factors.out.json --quiet
cmp -s factors.out.json again.json || fail "factors --reuse of a scene that has not changed must give the same file"
refused "factors of other options" 'factors.out.json: .*other options' "$solve" factors factors.json --out again.json --reuse factors.out.json
grep -q '"name":"lid, above/paint"' factors.out.json || fail "factors: --by material names instance/material"
"$source/samples/grey_body.py" factors.csv box=300 "lid, above=300" > heat.txt || fail "grey_body.py"
status=0
"$solve" factors factors.json --out output.csv --close > /dev/null 2> stderr.txt || status=$?
[ "$status" -eq 1 ] || fail "factors --close of an open scene: exit code $status, expected 1"
for thing in '"rom"' '"box/wood"'; do
    sed 's|"instances"|"groups": { "all": ['"$thing"'] }, "instances"|' factors.json > bad.json
    refused "a group's unknown member" "bad.json: /groups/all/0.*" "$solve" factors bad.json --out output.csv
done
sed 's|"instances"|"groups": { "all": [] }, "instances"|' factors.json > bad.json
refused "an empty group" '"all"' "$solve" factors bad.json --out output.csv
sed 's|"instances"|"groups": { "a": ["box"], "b": ["box/default"] }, "instances"|' factors.json > bad.json
refused "a surface in two groups" 'box/default' "$solve" factors bad.json --out output.csv
refused "no groups" 'groups' "$solve" factors factors.json --by group --out output.csv
for wrong in "--by colour" "--sides back" "--accuracy 0" "--threshold 2" "--out output.txt"; do
    status=0
    "$solve" factors factors.json --out output.csv $wrong > /dev/null 2> stderr.txt || status=$?
    [ "$status" -eq 2 ] || fail "factors $wrong: exit code $status, expected 2"
done
# Every way of finding what stands between, the same bits for any number of threads.
for how in rays atlas tables none; do
    "$solve" run scene.json --visibility $how --radiosity $how.csv --quiet
    "$solve" run scene.json --visibility $how --radiosity one.csv --threads 1 --quiet
    cmp $how.csv one.csv || fail "--visibility $how: --threads changed the result"
done
cmp high.csv rays.csv || fail "--visibility auto is rays"

# Edits: one value changes, the rest of the file stays; what cannot be done leaves it alone.
scene 0 > edit.json
"$solve" place edit.json "second box" library/box.rro --translate -.5,0,2 --scale 0.1
grep -q '"archive": "library/box.rro", "transform": { "translate": \[-0.5, 0, 2\], "scale": 0.1 }' edit.json || fail "place: $(cat edit.json)"
"$solve" move edit.json "second box" --translate 1,0,2
grep -q '"translate": \[1, 0, 2\], "scale": 0.1' edit.json || fail "move: $(cat edit.json)"
"$solve" run edit.json --radiosity placed.csv --quiet
cp edit.json before.json
refused "a name that is not there" 'did you mean "second box"' "$solve" move edit.json "secnd box" --scale 2
refused "a singular transform" 'singular' "$solve" move edit.json "second box" --scale 0
refused "no archive to place" 'none.rro' "$solve" place edit.json third none.rro
refused "no such manifest" 'none.json' "$solve" delete none.json third
cmp edit.json before.json || fail "a refused edit changed the manifest"
status=0
"$solve" move edit.json "second box" --translate 1,2 2> stderr.txt || status=$?
[ "$status" -eq 2 ] || fail "--translate 1,2: exit code $status, expected 2"
"$solve" delete edit.json "second box"
scene 0 | cmp - edit.json || fail "placing and deleting changed other bytes"

# Live: one reply a line, the same light as a run; the end of input ends it.
printf '%s\n' '{"op":"move","id":7,"name":"box","transform":{"translate":[0,0.5,0],"scale":0.2}}' 'nonsense' \
    '{"op":"save","file":"live.json"}' '{"op":"radiosity","name":"box","file":"live.csv"}' | "$solve" live scene.json > replies.txt
[ "$(wc -l < replies.txt)" -eq 5 ] || fail "live: $(cat replies.txt)"
head -1 replies.txt | grep -q '"event":"ready"' || fail "live: $(cat replies.txt)"
grep -q '"id":7.*"ok":true' replies.txt || fail "live: $(cat replies.txt)"
[ "$(grep -c '"ok":false' replies.txt)" -eq 1 ] || fail "live: $(cat replies.txt)"
"$solve" run live.json --radiosity run.csv --quiet
grep -v '^lamp,' run.csv | cmp - live.csv || fail "live and run differ"
refused "live without a manifest" 'none.json' "$solve" live none.json

# Bad input.
: > empty.obj
printf 'v nan 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n' > nan.obj
printf 'v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 9\n' > index.obj
refused "missing mesh" "none.obj" "$compile" build none.obj --out output.rro
refused "empty mesh" "empty.obj" "$compile" build empty.obj --out output.rro
refused "NaN vertices" "nan.obj" "$compile" build nan.obj --out output.rro
refused "an index out of range" "index.obj:4" "$compile" build index.obj --out output.rro
refused "not an archive" "box.obj" "$compile" verify box.obj
refused "no archive to compare with" "none.rro" "$compile" diff white.rro none.rro

sed 's/"accuracy"/"acuracy"/' scene.json > bad.json
refused "unknown key" "bad.json.*acuracy|acuracy" "$solve" run bad.json --radiosity output.csv
sed 's/"accuracy": 0.1/"accuracy": "high"/' scene.json > bad.json
refused "wrong type" "bad.json: /accuracy" "$solve" run bad.json --radiosity output.csv
sed 's/"scale": 0.2/"scale": 0/' scene.json > bad.json
refused "singular transform" "/instances/0/transform" "$solve" run bad.json --radiosity output.csv
sed 's/"\*"/"brass"/' scene.json > bad.json
refused "unknown material" "brass" "$solve" run bad.json --radiosity output.csv
sed 's/lamp.rro/none.rro/' scene.json > bad.json
refused "missing archive" "none.rro" "$solve" run bad.json --radiosity output.csv
head -c 1000 library/lamp.rro > library/cut.rro
sed 's/lamp.rro/cut.rro/' scene.json > bad.json
refused "truncated archive" "cut.rro" "$solve" run bad.json --radiosity output.csv
"$compile" build box.obj --out library/bare.rro --tables area,visibility --quiet
sed 's/box.rro/bare.rro/' scene.json > bad.json
"$solve" run bad.json --radiosity bare.csv --quiet
for how in atlas tables; do
    refused "no section for --visibility $how" "visibility $how needs" "$solve" run bad.json --visibility $how --radiosity output.csv
    grep -q -e "--tables default" stderr.txt || fail "--visibility $how: no hint: $(cat stderr.txt)"
done
echo "all of programs.sh passed"
