#!/usr/bin/env bash
# How the solver's work grows with the number of instances: halls of COUNT objects (tests/bench/hall.py), solved at one
# accuracy, as a Markdown table. Slopes are of log processor seconds over log instances, against the row above; processor
# seconds, so that other work on the machine counts for little.
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

echo "| objects | instances | triangles | links | links per instance | rays | load s | links s | iterate s | total s | processor s | peak GB | error estimate | slope |"
echo "|---:|---:|---:|---:|---:|---:|---:|---:|---:|---:|---:|---:|---:|---:|"
rm -f "$work/last"
for count in "$@"; do
    scene=$work/hall_$count.json
    python3 "$here/hall.py" "$work/library" "$count" "$scene"
    "$compiler" build "${scene%.json}.shell.obj" --out "${scene%.json}.shell.rro" --two-sided no --quiet
    report=${scene%.json}.report.json
    # Code 1: solved, but the estimate is above the accuracy asked.
    TIMEFORMAT='%U %S'
    { time "$solver" run "$scene" --accuracy "${ACCURACY:-0.1}" --report "$report" --quiet 2>&3 || [ $? -eq 1 ]; } \
        3>&2 2>"$work/seconds"
    python3 - "$report" "$count" "$scene" "$work/seconds" "$work/last" <<'PYTHON'
import json, math, os, sys
report_path, count, scene, seconds_path, last_path = sys.argv[1:]
processor = sum(float(x) for x in open(seconds_path).read().split()[-2:])
report = json.load(open(report_path))
instances = len(json.load(open(scene))["instances"])
seconds, links = report["seconds"], report["links"]["total"]
slope = ""
if os.path.exists(last_path):
    n, s = (float(x) for x in open(last_path).read().split())
    slope = "%.2f" % (math.log(processor / s) / math.log(instances / n))
open(last_path, "w").write("%d %f" % (instances, processor))
print("| %s | %d | %d | %d | %d | %d | %.1f | %.1f | %.1f | %.1f | %.1f | %.2f | %.3f | %s |" % (
    count, instances, report["triangles"], links, links / instances, report["rays"], seconds["load"], seconds["links"] + seconds["visibility"],
    seconds["iterate"], seconds["total"], processor, report["memory_peak_bytes"] / 2**30, report["estimated_error"],
    slope))
PYTHON
done
