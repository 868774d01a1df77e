#!/usr/bin/env bash
# What a grey scene costs against the same with three channels, and what effects cost that it does not call for, in
# callgrind's instructions: of the sweeps of light, of the plan, and of the code of effects that are off.
#
#   tests/bench/channels.sh RRO_SOLVE FOLDER
#
# Needs valgrind and samples/library. The scene is the Cornell box in grey, asked for 0.1.
set -euo pipefail

solve=$1 folder=$2
mkdir -p "$folder"
"$(dirname "${BASH_SOURCE[0]}")/grey_cornell.py" > "$folder/grey.json"
for channels in 1 3; do
    with=(); [ "$channels" = 1 ] || with=(--with colour)
    valgrind --tool=callgrind --callgrind-out-file="$folder/$channels.callgrind" "$solve" run "$folder/grey.json" --accuracy 0.1 \
        --threads 1 --radiosity "$folder/$channels.csv" --quiet "${with[@]}" 2> /dev/null
    callgrind_annotate --inclusive=yes --threshold=100 "$folder/$channels.callgrind" > "$folder/$channels.txt"
    of() { { grep -E "cpp:rro::$1" "$folder/$channels.txt" || true; } | tr -d ',' | awk '{ sum += $1 } END { printf "%.1f", sum / 1e6 }'; }
    echo "$channels channels, million instructions: all $(awk '/PROGRAM TOTALS/ { gsub(",", ""); print $1 / 1e6 }' "$folder/$channels.txt")," \
        "sweeps $(of "LightField<$channels>::sweep\\(\\) \\["), plan $(of 'plan_effects\(.*\['), leaving out $(of 'leave_out\(.*\[')," \
        "transmission $(of "LightField<$channels>::transmit.*\\["), sky, sun and lamps $(of 'OutsideLight::.*\[')"
done
differ=$(cmp -s "$folder/1.csv" "$folder/3.csv" || diff "$folder/1.csv" "$folder/3.csv" | grep -c '^<')
echo "triangles whose numbers differ: ${differ:-0} of $(($(wc -l < "$folder/1.csv") - 1))"
