#!/usr/bin/env bash
# Runs one family of the stability suite, and checks that the page names the same cases, laws and bounds.
#
#   check_page.sh STABILITY_TESTS PAGE FAMILY
set -euo pipefail
tests=$1 page=$2 family=$3

fresh=$(mktemp)
trap 'rm -f "$fresh"' EXIT
RRO_STABILITY_PAGE=$fresh "$tests" "[$family]"

# cases FILE: the rows of the family without what was measured
cases() {
    awk -F' [|] ' -v tag="\`[$family]\`" '/^## / { inside = index($0, tag) > 0 }
        inside && /^[|] / { print $1 " | " $2 " | " $3 }' "$1"
}
if ! diff <(cases "$page") <(cases "$fresh"); then
    echo "$page does not name these cases, laws and bounds: write it anew as it says in its head" >&2
    exit 1
fi
