#!/usr/bin/env bash
# How the solver's work grows with the number of instances: halls of COUNT objects (tests/bench/hall.py), solved at one
# accuracy, as a Markdown table. Slopes are of log seconds (links and iterations) over log instances, against the row above.
#
#   tests/bench/instances.sh RRO_COMPILE RRO_SOLVE WORK_DIR COUNT...
#
# The library is compiled into WORK_DIR/library unless it is there: the sample objects, or with PLAIN=1 in the environment
# objects of the same names made of boxes. ACCURACY in the environment replaces 0.1.
set -euo pipefail

if [ $# -lt 4 ]; then
    echo "usage: tests/bench/instances.sh RRO_COMPILE RRO_SOLVE WORK_DIR COUNT..." >&2
    exit 2
fi
compiler=$1 solver=$2 work=$3
shift 3
here=$(cd "$(dirname "$0")" && pwd)
mkdir -p "$work"
if [ ! -e "$work/library" ]; then
    list=$here/../../samples/library.json
    if [ -n "${PLAIN:-}" ]; then
        python3 "$here/hall.py" plain "$work/plain"
        list=$work/plain/library.json
    fi
    "$compiler" library "$list" --out "$work/library" --quiet
fi

echo "| objects | instances | triangles | links | links per instance | rays | load s | links s | iterate s | total s | peak GB | error estimate | slope |"
echo "|---:|---:|---:|---:|---:|---:|---:|---:|---:|---:|---:|---:|---:|"
last=
for count in "$@"; do
    scene=$work/hall_$count.json
    python3 "$here/hall.py" "$work/library" "$count" "$scene"
    "$compiler" build "${scene%.json}.shell.obj" --out "${scene%.json}.shell.rro" --two-sided no --quiet
    report=${scene%.json}.report.json
    # Code 1: solved, but the estimate is above the accuracy asked.
    "$solver" run "$scene" --accuracy "${ACCURACY:-0.1}" --report "$report" --quiet || [ $? -eq 1 ]
    last=$(python3 - "$report" "$count" "$scene" "$last" <<'PYTHON'
import json, math, sys
report, count, scene, last = sys.argv[1:]
report = json.load(open(report))
instances = len(json.load(open(scene))["instances"])
seconds, links = report["seconds"], report["links"]
work = seconds["links"] + seconds["iterate"]
total = links["total"]
slope = ""
if last:
    n, t = (float(x) for x in last.split())
    slope = "%.2f" % (math.log(work / t) / math.log(instances / n))
print("| %s | %d | %d | %d | %d | %d | %.1f | %.1f | %.1f | %.1f | %.2f | %.3f | %s |" % (
    count, instances, report["triangles"], total, total / instances, report["rays"], seconds["load"],
    seconds["links"], seconds["iterate"], seconds["total"], report["memory_peak_bytes"] / 2**30, report["estimated_error"],
    slope), file=sys.stderr)
print(instances, work)
PYTHON
)
done
