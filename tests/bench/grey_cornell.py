#!/usr/bin/env python3
"""The Cornell box of the samples in grey, as a manifest on standard output."""

import json
from pathlib import Path

scenes = Path(__file__).resolve().parents[2] / "samples/scenes"
scene = json.loads((scenes / "cornell.json").read_text())
for instance in scene["instances"]:
    instance["archive"] = str(scenes / instance["archive"])
    instance["materials"] = {"*": {"reflectance": [0.6] * 3} | ({"exitance": [50] * 3} if instance["name"] == "lamp" else {})}
print(json.dumps(scene))
