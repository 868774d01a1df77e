#!/usr/bin/env bash
# Fuzzes every parser of untrusted input: builds the preset fuzz, runs each target in turn on one core, reports how often
# each ran. Exits 1 where one of them found something, with the path of what reproduces it.
#
#   tests/fuzz/run.sh [check | SECONDS_PER_TARGET] [TARGET...]
#
#   tests/fuzz/run.sh                        the seeds, then a fixed number of runs that are the same every time
#   tests/fuzz/run.sh 3600                   an hour each, with what earlier hours have learnt
#   tests/fuzz/run.sh 600 mesh_fuzz          ten minutes of one
set -euo pipefail

extent=${1:-check}
shift || true
if ! [[ $extent =~ ^([0-9]+|check)$ ]]; then
    echo "usage: tests/fuzz/run.sh [check | SECONDS_PER_TARGET] [TARGET...]" >&2
    exit 2
fi
targets=("$@")
if [ ${#targets[@]} -eq 0 ]; then targets=(archive_fuzz section_fuzz mesh_fuzz manifest_fuzz lights_fuzz); fi

cd "$(dirname "${BASH_SOURCE[0]}")/../.."
source .ci/packages.sh
install_missing "${RRO_PACKAGES[@]}" "${RRO_FUZZ_PACKAGES[@]}"
cmake --preset fuzz >/dev/null
cmake --build --preset fuzz -- -j2

here=tests/fuzz
work=build/fuzz/fuzzing
mkdir -p "$work/findings"
rm -rf "$work/seeds"
build/fuzz/bin/write_seeds tests "$work/seeds"

# Files that targets write for a parser live in memory.
TMPDIR=$(mktemp --directory --tmpdir="$([ -d /dev/shm ] && echo /dev/shm || echo "${TMPDIR:-/tmp}")" rro-fuzz-XXXXXX)
export TMPDIR
trap 'rm -rf "$TMPDIR"' EXIT

# Shorter stacks of allocations and fewer freed bytes kept: half as many runs again.
export ASAN_OPTIONS=malloc_context_size=4:quarantine_size_mb=16
# The largest file: what each format can say in it, and no more, as short inputs run faster.
declare -A most_bytes=([archive_fuzz]=16384 [section_fuzz]=4096 [mesh_fuzz]=8192 [manifest_fuzz]=4096 [lights_fuzz]=1024)
# Of a check: ten seconds or less on an idle core.
declare -A check_runs=([archive_fuzz]=15000 [section_fuzz]=200000 [mesh_fuzz]=15000 [manifest_fuzz]=15000 [lights_fuzz]=100000)
# libFuzzer keeps what it learns by addresses: the same ones every time, where the system lets a program ask for that.
same_addresses=()
if [ "$extent" = check ] && setarch --addr-no-randomize true 2>/dev/null; then
    same_addresses=(setarch --addr-no-randomize)
fi
status=0
summary=()
for target in "${targets[@]}"; do
    log=$work/$target.log
    options=(-entropic=0 -rss_limit_mb=2048 -timeout=10 -max_len="${most_bytes[$target]:-4096}" -print_final_stats=1
             -artifact_prefix="$work/findings/$target-")
    if [ "$extent" = check ]; then  # starts from nothing but the seeds, and looks at no clock
        corpus=$TMPDIR/corpus/$target
        options+=(-seed=1 -runs="${check_runs[$target]:-10000}" -reload=0)
        echo "$target: ${check_runs[$target]:-10000} runs"
    else
        corpus=$work/corpus/$target
        options+=(-max_total_time="$extent")
        echo "$target: $extent s"
    fi
    mkdir -p "$corpus"
    dictionary=$here/${target%_fuzz}.dict
    if [ -f "$dictionary" ]; then options+=(-dict="$dictionary"); fi
    found=no
    if ! "${same_addresses[@]}" "build/fuzz/bin/$target" "${options[@]}" "$corpus" "$work/seeds/$target" >"$log" 2>&1; then
        found=yes
        status=1
        grep -E 'ERROR: |runtime error: |Assertion|does not hold|SUMMARY: ' "$log" | head -5 >&2 || true
        echo "$target: found something: $(grep -oE 'Test unit written to .*' "$log" | tail -1 | cut -d' ' -f5)" >&2
        echo "  the whole report: $log" >&2
    fi
    runs=$(sed -nE 's/^stat::number_of_executed_units: *//p' "$log" | tail -1)
    summary+=("$(printf '%-14s %12s runs   findings: %s' "$target" "${runs:-?}" "$found")")
done
printf '%s\n' "${summary[@]}"
exit $status
