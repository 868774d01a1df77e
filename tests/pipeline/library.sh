#!/usr/bin/env bash
# Object libraries: what has changed is compiled, and nothing else; one bad mesh, several processes and Ctrl-C spoil
# nothing; the installed CMake package builds a library with ninja.
#
#   library.sh RRO_COMPILE RRO_SOLVE SOURCE_DIR
source "$(dirname "${BASH_SOURCE[0]}")/prelude.sh"

# library EXPECTED_STATUS [FILE [OPTION...]]: compiles a library into out/, output in stdout.txt and stderr.txt.
library() {
    local expected=$1 file=${2:-library.json} status=0
    shift; [ $# -eq 0 ] || shift
    "$compile" library "$file" --out out "$@" > stdout.txt 2> stderr.txt || status=$?
    [ "$status" -eq "$expected" ] || fail "$file: exit code $status, expected $expected: $(cat stdout.txt stderr.txt)"
}
# rebuilt NAME...: the last run wrote these archives, and left the others as they were.
rebuilt() {
    local wanted="$*" found
    found=$(sed -n '/: unchanged/!s|^out/\(.*\)\.rro: .*|\1|p' stdout.txt | paste -sd' ')
    [ "$found" = "$wanted" ] || fail "expected to rebuild '$wanted', not '$found'"
    [ "$(grep -c . stdout.txt)" -eq 4 ] || fail "expected one line per object: $(cat stdout.txt)"
    for file in out/*.rro; do
        case " $wanted " in
            *" $(basename "$file" .rro) "*) ;;
            *) grep -qxF "$(stat -c '%n %i %y' "$file")" before.txt || fail "$file was touched" ;;
        esac
    done
    stat -c '%n %i %y' out/*.rro > before.txt
}

cp -r "$source/tests/golden/sources" meshes
printf 'v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n' > meshes/tetrahedron.obj
cat > library.json <<'END'
{ "format": "rro-library/1", "defaults": { "grid": 3 }, "objects": [
  { "name": "lamp", "mesh": "meshes/lamp.obj", "unit": "cm" },
  { "name": "leaf", "mesh": "meshes/leaf.obj", "two_sided": "yes" },
  { "name": "white", "mesh": "meshes/tetrahedron.obj", "materials": { "*": { "reflectance": [0.8, 0.8, 0.8] } } },
  { "name": "plain", "mesh": "meshes/tetrahedron.obj" } ] }
END

# Only what has changed.
library 0
touch before.txt
rebuilt lamp leaf white plain
"$compile" verify out/*.rro --quiet
library 0
rebuilt
touch meshes/*
library 0
rebuilt
echo "# changed" >> meshes/lamp.obj
library 0
rebuilt lamp
echo "# changed" >> meshes/tetrahedron.obj
library 0
rebuilt white plain
echo "# changed" >> meshes/lamp.mtl
library 0
rebuilt lamp
printf 'more' >> meshes/leaf.png  # behind its end, where no reader looks
library 0
rebuilt leaf
sed -i 's/"yes"/"auto"/' library.json
library 0
rebuilt leaf
sed -i 's/0.8, 0.8, 0.8/0.8, 0.8, 0.7/' library.json
library 0
rebuilt white
sed -i 's/"grid": 3/"grid": 4/' library.json
library 0 library.json --report report.json --depfile library.d
rebuilt lamp leaf white plain
[ "$(grep -c '"state": "written"' report.json)" -eq 4 ] || fail "the report has no four archives"
grep -A5 '^out/lamp.rro:' library.d | grep -q 'meshes/lamp.mtl' || fail "the depfile lacks a material file"
rm out/plain.rro
library 0
rebuilt plain

# The same bytes for any number of threads, in one process and in two at once.
for threads in 1 8; do "$compile" library library.json --out "threads$threads" --threads $threads --quiet; done
mkdir both
"$compile" library library.json --out both --quiet & first=$!
"$compile" library library.json --out both --quiet & second=$!
wait $first || fail "the first of two processes"
wait $second || fail "the second of two processes"
for folder in threads1 threads8 both; do
    for archive in out/*.rro; do cmp "$archive" "$folder/$(basename "$archive")"; done
    [ -z "$(find "$folder" -name '*.part')" ] || fail "$folder: a temporary file is left"
done

# One mesh that cannot be used: exit code 1, it is named, the others are written and no part of it.
echo "f 1 2 9999" > meshes/broken.obj
sed 's|meshes/leaf.obj|meshes/broken.obj|' library.json > broken.json
rm -r out
library 1 broken.json
grep -q 'error: meshes/broken.obj' stderr.txt || fail "the broken mesh is not named: $(cat stderr.txt)"
[ "$(ls out)" = "$(printf 'lamp.rro\nplain.rro\nwhite.rro')" ] || fail "expected three archives: $(ls out)"

# Bad libraries: exit code 3, the place, nothing written.
rm -r out
refused() { # refused SED PATTERN
    sed "$1" library.json > bad.json
    library 3 bad.json
    grep -qE "error: bad.json: $2" stderr.txt || fail "expected /$2/ in: $(cat stderr.txt)"
    ! compgen -G 'out/*.rro' > /dev/null || fail "$1: something was written"
}
refused 's/"unit"/"units"/' '/objects/0/units: unknown key'
refused 's/"cm"/"km"/' '/objects/0/unit: found "km", expected .*"cm"'
refused 's/"plain"/"lamp"/' '/objects/3/name: .*/objects/0'
refused 's/"plain"/"a\/b"/' '/objects/3/name'
refused 's/0.7\]/1]/' '/objects/2/materials/\*/reflectance/2: .*below 1'
refused 's/"objects"/"things"/' '/things: unknown key'
refused 's/{ "format"/{{ "format"/' 'line 1'
# A name that only the mesh could know: its object fails, the others are written.
sed 's/"\*"/"brass"/' library.json > bad.json
library 3 bad.json
grep -qE 'error: bad.json: /objects/2/materials/brass: .*default' stderr.txt || fail "brass: $(cat stderr.txt)"
[ "$(ls out)" = "$(printf 'lamp.rro\nleaf.rro\nplain.rro')" ] || fail "expected three archives: $(ls out)"
rm -r out

# Ctrl-C at any time: exit code 130, whole archives, nothing else; the next run completes them.
begin=$(date +%s%N)
"$compile" library library.json --out out --quiet
whole=$((($(date +%s%N) - begin) / 1000000))
interrupted=0
for step in 1 2 3 4 5 6 7 8; do
    rm -rf out
    status=0
    timeout --preserve-status -s INT "$(awk "BEGIN { print $whole * $step / 9000 }")" \
        "$compile" library library.json --out out --quiet || status=$?
    [ $status -eq 0 ] || [ $status -eq 130 ] || fail "interrupted: exit code $status, expected 130"
    [ $status -eq 0 ] || interrupted=$((interrupted + 1))
    [ -z "$(find out -type f ! -name '*.rro' ! -name '.*.rro.inputs' 2> /dev/null)" ] || fail "left behind: $(ls -A out)"
    for archive in out/*.rro; do
        [ ! -e "$archive" ] || "$compile" verify "$archive" --quiet || fail "$archive is half a file"
    done
done
[ $interrupted -gt 0 ] || fail "nothing was interrupted"
library 0
for archive in out/*.rro; do cmp "$archive" "threads1/$(basename "$archive")"; done

# The installed package: ninja compiles what has changed.
cmake --install "$build_tree" --prefix "$work/installed" > install.txt
[ -x installed/bin/rro-compile ] && [ -x installed/bin/rro-solve ] || fail "the programs are not installed"
mkdir -p samples/meshes
cp -r "$source/samples/asset_build" samples/
for mesh in table chair vase cornell_lamp cornell_tall ball; do cp meshes/tetrahedron.obj samples/meshes/$mesh.obj; done
cp meshes/lamp.obj meshes/lamp.mtl samples/meshes/
mv samples/meshes/lamp.obj samples/meshes/table.obj
cmake -S samples/asset_build -B assets -G Ninja -DCMAKE_PREFIX_PATH="$work/installed" > configure.txt
# ninja_compiles PATTERN...: the lines of archives that the next build writes.
ninja_compiles() {
    local found
    found=$(ninja -C assets | sed -n "/: unchanged/!s|^$work/assets/\(.*\)\.rro: .*|\1|p" | sort | paste -sd' ')
    [ "$found" = "$*" ] || fail "ninja: expected to compile '$*', not '$found'"
    ninja -C assets | grep -q "no work to do" || fail "ninja: a second build has work to do"
}
ninja_compiles cornell/lamp cornell/tall_box cornell/white_ball living_room/chair living_room/table living_room/vase
echo "# changed" >> samples/meshes/chair.obj
ninja_compiles living_room/chair
echo "# changed" >> samples/meshes/lamp.mtl
ninja_compiles living_room/table
echo "# changed" >> samples/meshes/ball.obj
ninja_compiles cornell/white_ball
sed -i 's/53.4071/53.5/' samples/asset_build/cornell.json
ninja_compiles cornell/lamp
sed -i 's/"tall_box"/"box"/' samples/asset_build/cornell.json
ninja_compiles cornell/box
sed -i 's/--grid 8/--grid 6/' samples/asset_build/CMakeLists.txt
ninja_compiles living_room/chair living_room/table living_room/vase

echo "all of library.sh passed"
