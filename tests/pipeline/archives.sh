#!/usr/bin/env bash
# Archives as files: the same bytes for any number of threads, the old file or the new one whatever ends the program,
# pins in manifests, and the small reader in Python.
#
#   archives.sh RRO_COMPILE RRO_SOLVE SOURCE_DIR
source "$(dirname "${BASH_SOURCE[0]}")/prelude.sh"
sum() { sha256sum "$1" | cut -d' ' -f1; }
mesh=$source/samples/meshes/chair.obj

# The same bytes for any number of threads.
for threads in 1 2 8; do "$compile" build "$mesh" --out "$threads.rro" --threads "$threads" --quiet; done
cmp 1.rro 2.rro && cmp 1.rro 8.rro || fail "--threads changed an archive"
new=$(sum 1.rro)

# Killed at any time, the file is the old one or the new one.
"$compile" build "$mesh" --out chair.rro --grid 4 --quiet
cp chair.rro old.rro
old=$(sum chair.rro)
[ "$old" != "$new" ] || fail "another grid must give another archive"
killed=0 finished=0
begin=$(date +%s%N)
"$compile" build "$mesh" --out chair.rro --quiet
whole=$((($(date +%s%N) - begin) / 1000000))
[ "$(sum chair.rro)" = "$new" ] || fail "an archive that replaces another differs from one that does not"
for step in 1 2 3 4 5 6 7 8 9 10; do
    cp old.rro chair.rro
    # The last steps fall where the file is written and renamed.
    after=$(awk "BEGIN { print $whole * ($step < 6 ? $step * 0.16 : 0.8 + $step * 0.02) / 1000 }")
    status=0
    timeout -s KILL "$after" "$compile" build "$mesh" --out chair.rro --quiet || status=$?
    [ $status -eq 0 ] && finished=$((finished + 1)) || killed=$((killed + 1))
    now=$(sum chair.rro)
    [ "$now" = "$old" ] || [ "$now" = "$new" ] || fail "killed after $after s: chair.rro is neither the old nor the new file"
    "$compile" verify chair.rro --quiet || fail "killed after $after s: chair.rro is refused"
done
[ $killed -gt 0 ] || fail "nothing was killed"

# A full disk: exit code 1, the old file, nothing beside it.
cp old.rro chair.rro
rm -f .chair* chair.rro.*
files=$(ls -A | wc -l)
status=0
(trap '' XFSZ; ulimit -f 8; exec "$compile" build "$mesh" --out chair.rro --quiet) 2> stderr.txt || status=$?
[ $status -eq 1 ] || fail "a full disk: exit code $status, expected 1"
grep -q "chair.rro" stderr.txt || fail "a full disk: the file must be named: $(cat stderr.txt)"
[ "$(sum chair.rro)" = "$old" ] || fail "a full disk: the old archive is lost"
rm stderr.txt
[ "$(ls -A | wc -l)" -eq "$files" ] || fail "a full disk: something was left behind: $(ls -A)"

# Pins: the first digits of what sha256sum prints.
scene() { # scene PIN
    printf '{"format":"rro-scene/1","instances":[{"name":"chair","archive":{"path":"chair.rro","content":"%s"}}]}' "$1"
}
scene "${old:0:8}" > pinned.json
"$solve" explain pinned.json > /dev/null || fail "an archive with the right pin is refused"
scene "${new:0:8}" > pinned.json
status=0
"$solve" explain pinned.json > /dev/null 2> stderr.txt || status=$?
[ $status -eq 3 ] || fail "a wrong pin: exit code $status, expected 3"
grep -q "/instances/0/archive/content" stderr.txt && grep -q "$old" stderr.txt || fail "a wrong pin: $(cat stderr.txt)"
"$compile" inspect chair.rro --json > inspected.json
grep -q "\"content\": \"$old\"" inspected.json || fail "inspect shows another SHA-256"

# Several archives: all are checked, one that is refused does not hide the others.
status=0
"$compile" verify 1.rro "$source/tests/corrupt/zlib_bomb.rro" old.rro > stdout.txt 2> stderr.txt || status=$?
[ $status -eq 3 ] && [ "$(grep -c good stdout.txt)" -eq 2 ] || fail "verify must check all files"

echo "all of archives.sh passed"
