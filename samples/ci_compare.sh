#!/usr/bin/env bash
# A recipe for continuous integration: what does a change of meshes, options or compiler do to a scene? Compiles the library
# as it is now, solves the scene with it and with the one of the main branch, and posts the difference as Markdown. Fails
# where a solve became slower or the light changed more than allowed.
#
#   samples/ci_compare.sh PROGRAMS LIBRARY.json SCENE.json BASE OUT
#
# PROGRAMS  folder of rro-compile and rro-solve
# BASE      the library of the main branch: a folder that CI keeps from its last run there. Empty or missing: there is
#           nothing to compare with yet, which is no fault
# OUT       gets library/ (CI keeps it as the next BASE, and as a cache: only what changed is compiled), change.md, change.json
#
# From the environment: RRO_SLOWER (1.15: total time of head over that of base), RRO_DIFFERS (0.02: relative difference of
# reflected radiosity; no less than the accuracy that the scene asks for makes sense), RRO_RUNS (9).
# The Markdown goes to the job's summary where GitHub names a file for it (GITHUB_STEP_SUMMARY), to the merge request where
# GitLab runs and RRO_COMMENT_TOKEN may write comments, and to the log.
set -euo pipefail

[ $# -eq 5 ] || { sed -n 's/^# \{0,1\}//; 2,/^$/p' "$0" >&2; exit 2; }
programs=$1 library=$2 scene=$3 base=$4 out=$5

post() {
    cat "$1"
    if [ -n "${GITHUB_STEP_SUMMARY:-}" ]; then cat "$1" >> "$GITHUB_STEP_SUMMARY"; fi
    if [ -n "${CI_MERGE_REQUEST_IID:-}" ] && [ -n "${RRO_COMMENT_TOKEN:-}" ]; then
        curl --fail --silent --show-error --header "PRIVATE-TOKEN: $RRO_COMMENT_TOKEN" --form "body=<$1" --output /dev/null \
            "$CI_API_V4_URL/projects/$CI_PROJECT_ID/merge_requests/$CI_MERGE_REQUEST_IID/notes"
    fi
}

mkdir -p "$out/library"
rm -f "$out/change.md"
"$programs/rro-compile" library "$library" --out "$out/library"
if ! compgen -G "$base/*.rro" > /dev/null; then
    echo "$base holds no archives: nothing to compare with. Keep $out/library as the next base."
    exit 0
fi
status=0
"$programs/rro-solve" compare "$scene" --base "$base" --head "$out/library" --runs "${RRO_RUNS:-9}" --quiet \
    --fail-if-slower "${RRO_SLOWER:-1.15}" --fail-if-differs "${RRO_DIFFERS:-0.02}" \
    --markdown "$out/change.md" --json "$out/change.json" || status=$?
if [ -f "$out/change.md" ]; then post "$out/change.md"; fi  # not there where a solve failed
exit "$status"
