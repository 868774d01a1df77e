#!/bin/sh
# What edits cost, on the twelve-object room and on a hall of a hundred objects.
#   edits.sh BUILD_DIR LIBRARY_DIR ROOM.json [ACCURACY] [REPEATS] [room|hall]
# LIBRARY_DIR holds the sample library compiled (samples/README.md); ROOM.json is samples/scenes/twelve_object_room.json
# beside it. Build the target edits_bench first.
set -eu
build=$1 library=$(cd "$2" && pwd) room=$3 accuracy=${4:-0.05} repeats=${5:-2} only=${6:-}
here=$(cd "$(dirname "$0")" && pwd)
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT

if [ "$only" != hall ]; then
# The desk lamp gets a light group.
python3 - "$room" "$library" "$work/room.json" <<'EOF'
import json, os, sys
scene = json.load(open(sys.argv[1]))
for i in scene["instances"]:
    i["archive"] = os.path.join(sys.argv[2], os.path.basename(i["archive"]))
    if i["name"] == "desk_lamp":
        i["materials"]["bulb"]["group"] = "desk"
json.dump(scene, open(sys.argv[3], "w"))
EOF
echo "## Room, accuracy $accuracy"
"$build/bin/edits_bench" "$work/room.json" "$here/room_edits.txt" "$accuracy" "$repeats"
fi
if [ "$only" = room ]; then exit; fi

python3 "$here/hall.py" "$library" 100 "$work/hall.json"
"$build/bin/rro-compile" build "$work/hall.shell.obj" --out "$work/hall.shell.rro" --quiet
python3 - "$work/hall.json" "$work/hall_edits.txt" <<'EOF'
import json, sys
names = {}
for i in json.load(open(sys.argv[1]))["instances"]:
    names.setdefault(i["archive"].split("/")[-1].split(".")[0], i["name"])
with open(sys.argv[2], "w") as out:
    for kind in ("chair", "ball", "telephone", "desk_lamp"):
        if kind in names:
            print("move", names[kind], "0.3 0 0", file=out)
    print("place extra", names["ball"], "0.5 0 0.5", file=out)
    print("material", names["chair"], "0.2 0.3 0.5", file=out)
    print("delete extra", file=out)
EOF
echo "## Hall, accuracy $accuracy"
"$build/bin/edits_bench" "$work/hall.json" "$work/hall_edits.txt" "$accuracy" "$repeats"
