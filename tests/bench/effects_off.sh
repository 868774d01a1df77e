#!/usr/bin/env bash
# What effects cost a scene that does not call for them: instructions (callgrind) and allocations (DHAT) of one solve, by
# a build with all effects and by one without those.
#
#   tests/bench/effects_off.sh RRO_SOLVE RRO_SOLVE_WITHOUT FOLDER
#
# Needs valgrind and samples/library. The scene is the Cornell box in grey, asked for 0.1; the second program comes from
#   cmake -S . -B build/lean -DCMAKE_BUILD_TYPE=Release "-DRRO_EFFECTS=emitters;interreflection;occlusion;self"
#   cmake --build build/lean --target rro-solve
set -euo pipefail

folder=$3
mkdir -p "$folder"
"$(dirname "${BASH_SOURCE[0]}")/grey_cornell.py" > "$folder/grey.json"
run() { # run TOOL PROGRAM OPTION...
    valgrind --tool="$1" "${@:3}" "$2" run "$folder/grey.json" --accuracy 0.1 --threads 1 --radiosity "$folder/light.csv" --quiet \
        2>&1 || [ $? -eq 1 ]
}
measure() { # measure PROGRAM
    run callgrind "$1" --callgrind-out-file="$folder/callgrind" | awk '/Collected/ { print $NF }'
    run dhat "$1" --dhat-out-file="$folder/dhat" | awk '/Total:/ { gsub(",", ""); print $6 }'
}
with=($(measure "$1")) without=($(measure "$2"))
for k in 0 1; do
    what=(instructions allocations)
    awk -v name="${what[$k]}" -v a="${with[$k]}" -v b="${without[$k]}" \
        'BEGIN { printf "%s: %d with all effects, %d without, %+.3f %%\n", name, a, b, 100 * (a / b - 1) }'
done
