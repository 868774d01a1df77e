#!/usr/bin/env bash
# The installed package: the sample programs are built against it, and nothing of this repository, and work.
#
#   package.sh RRO_COMPILE RRO_SOLVE SOURCE_DIR
source "$(dirname "${BASH_SOURCE[0]}")/prelude.sh"

cmake --install "$build_tree" --prefix "$work/installed" > install.txt
# Sources elsewhere, so that no include can reach the repository.
cp -r "$source/samples/programs" programs
cxx=$(sed -n 's/^CMAKE_CXX_COMPILER:[A-Z]*=//p' "$build_tree/CMakeCache.txt")
cmake -S programs -B built -DCMAKE_PREFIX_PATH="$work/installed" -DCMAKE_CXX_COMPILER="$cxx" -DCMAKE_CXX_FLAGS="-Wall -Wextra -Werror" \
    -DCMAKE_BUILD_TYPE=Debug > configure.txt || fail "configure: $(cat configure.txt)"
cmake --build built > build.txt || fail "build: $(cat build.txt)"
! grep -rqF "$source" installed/lib*/cmake || fail "the package refers to the repository: $(grep -rF "$source" installed/lib*/cmake)"

# The package and both programs are of one version.
version=$(sed -n 's/^set(PACKAGE_VERSION "\(.*\)")$/\1/p' installed/lib*/cmake/rro/rroConfigVersion.cmake)
for program in rro-compile rro-solve; do
    told=$(installed/bin/$program --version)
    [ "$told" = "$program $version" ] || fail "$program --version: found $told, the package is $version"
done

# The corner of a cube: seen along an axis, half a square metre.
printf 'v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n' > corner.obj
"$compile" build corner.obj --out corner.rro --quiet
built/object_facts corner.rro > facts.txt
grep -q '^corner.obj: 1.00 x 1.00 x 1.00 m, 4 triangles' facts.txt || fail "object_facts: $(cat facts.txt)"
# Between directions of the grid, tables are off by some percent.
awk '/^seen from/ { n++; if ($4 < 0.45 || $4 > 0.6) exit 1 } END { if (n != 6) exit 1 }' facts.txt || fail "areas: $(cat facts.txt)"

# A lamp moves towards a wall.
cat > scene.json <<'JSON'
{ "format": "rro-scene/1", "accuracy": 0.2, "instances": [
  { "name": "lamp", "archive": "corner.rro", "transform": { "translate": [-2, 0, 0] }, "materials": { "*": { "exitance": [9, 9, 9] } } },
  { "name": "wall", "archive": "corner.rro" } ] }
JSON
built/edit_scene scene.json lamp > lines.txt || fail "edit_scene: exit code $?"
[ "$(grep -c '^x = ' lines.txt)" -eq 4 ] || fail "edit_scene: $(cat lines.txt)"

# Without components the package asks for no library.
mkdir plain
cat > plain/CMakeLists.txt <<'LISTS'
cmake_minimum_required(VERSION 3.25)
project(plain LANGUAGES NONE)
find_package(rro REQUIRED)
if(TARGET rro::solver OR NOT TARGET rro::rro-solve)
  message(FATAL_ERROR "expected programs and no libraries")
endif()
LISTS
cmake -S plain -B plain/build -DCMAKE_PREFIX_PATH="$work/installed" > plain.txt || fail "plain: $(cat plain.txt)"

echo "all of package.sh passed"
