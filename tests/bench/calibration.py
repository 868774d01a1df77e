#!/usr/bin/env python3
"""Does --accuracy mean what it says? Small scenes of many kinds, solved at several accuracies and judged by the reference: the
solver's estimate over the true error, and the true error over what was asked, as a Markdown table.

    tests/bench/calibration.py RRO_SOLVE FOLDER [--samples 256] [--accuracy 0.2,0.1,0.05] [SCENE...]

Needs samples/library. FOLDER keeps references and finished runs: called again, it does what is missing. Scenes marked "tuned"
were before people's eyes when constants were chosen; those marked "held out" were made for this table and never were.
"""

import argparse
import json
import subprocess
import sys
from pathlib import Path

LIBRARY = Path(__file__).resolve().parents[2] / "samples/library"
NOISY = 1.0   # times the error: a truth with a larger standard error does not judge
SMALL = 0.1   # of what is asked: a true error below that is better than anyone needs, and its estimate is not judged


def place(name, archive, at=(0, 0, 0), scale=1, degrees=0, **materials):
    transform = {"translate": list(at), "scale": scale, "rotate": {"axis": [0, 1, 0], "degrees": degrees}}
    return {"name": name, "archive": str(LIBRARY / f"{archive}.rro"), "transform": transform, "materials": materials}


def reflecting(share):
    return {"*": {"reflectance": [share] * 3}}


def shining(*exitance):
    return {"exitance": list(exitance)}


def scene(*instances, **more):
    return {"format": "rro-scene/1", "instances": list(instances), **more}


ROOM = place("room", "closed_room")
PANEL = place("panel", "ceiling_panel", (2, 2.45, 1.8), panel=shining(30, 29, 26))


def cornell():
    return scene(place("shell", "cornell_shell"), place("short_box", "cornell_short"), place("tall_box", "cornell_tall"),
                 place("lamp", "cornell_lamp", lamp=shining(53, 38, 13)))


def closed():
    return scene(ROOM, PANEL, place("pedestal", "pedestal", (1.3, 0.001, 2.4)), place("ball", "ball", (2.7, 0.001, 1.5), 1.4))


def open_air():
    """No walls: what is not hit at once is lost."""
    return scene(place("panel", "ceiling_panel", (0, 2.6, 0), panel=shining(40, 40, 36)), place("pillar", "pillar", (0.7, 0, 0.2), 0.8),
                 place("ball", "ball", (-0.5, 0.001, 0.3), 2), place("pedestal", "pedestal", (0.1, 0, -0.6)))


def small_light():
    """A ball of 4 cm lights a room: hard shadows."""
    return scene(ROOM, place("bulb", "ball", (2.9, 1.9, 1.2), 0.06, **{"*": shining(9000, 8600, 8000)}),
                 place("pedestal", "pedestal", (1.7, 0.001, 2.0)), place("block", "cornell_short", (2.2, 0.001, 2.2), 2))


def lamp_shade():
    """A bulb deep in a metal shade."""
    return scene(ROOM, place("lamp", "desk_lamp", (1.8, 0.91, 1.8), bulb=shining(900, 740, 480)),
                 place("pedestal", "pedestal", (1.8, 0.001, 1.8), 1))


def point_light():
    return scene(ROOM, place("pillar", "pillar", (1.5, 0.001, 1.5), 0.8), place("ball", "ball", (2.6, 0.001, 2.4), 1.5),
                 lights=[{"name": "bulb", "type": "point", "position": [3.1, 2.1, 2.9], "intensity": [20, 18, 15]}])


def sky_only():
    return scene(place("court", "courtyard"), place("pillar_1", "pillar", (2, 0.001, 2)), place("pillar_2", "pillar", (6, 0.001, 6)),
                 place("pedestal", "pedestal", (4, 0.001, 4)), sky={"cie_overcast": [60, 62, 66], "ground": True})


def window():
    return scene(place("room", "window_room"), place("pedestal", "pedestal", (1.6, 0.001, 1.4)), sky={"radiance": [50, 55, 65]})


def dark_reflecting():
    """A dim panel in a room that reflects nine tenths: almost all light has been reflected many times."""
    return scene(place("room", "closed_room", **reflecting(0.9)), place("pillar", "pillar", (1.2, 0.001, 2.8), 0.8, **reflecting(0.9)),
                 place("panel", "ceiling_panel", (2, 1.2, 1.8), 0.5, panel=shining(0.5, 0.5, 0.5), housing={"reflectance": [0.9] * 3}))


def white_room():
    """Furniture in a room, all of which reflect 0.85: between that and rooms as they are."""
    return scene(place("room", "closed_room", **reflecting(0.85)), PANEL, place("pedestal", "pedestal", (1.3, 0.001, 2.4), **reflecting(0.85)),
                 place("ball", "ball", (2.7, 0.001, 1.5), 1.4, **reflecting(0.85)), place("block", "cornell_short", (1.6, 0.001, 1.2), 2, **reflecting(0.85)))


def foliage():
    return scene(ROOM, PANEL, place("palm", "palm", (1.8, 0.001, 2.2), 1, 20))


def near_contact():
    """Boxes and balls a millimetre apart."""
    return scene(ROOM, PANEL, place("lower", "cornell_short", (1.4, 0.001, 1.8), 2), place("upper", "cornell_short", (1.4, 0.332, 1.8), 2),
                 place("ball_1", "ball", (2.6, 0.001, 1.8), 1), place("ball_2", "ball", (2.94, 0.001, 1.8), 1))


def many():
    """64 instances under one panel."""
    things = [place(f"{name}_{i}_{k}", name, (0.3 + 0.48 * i, 0.001, 0.3 + 0.48 * k), 0.4, 37 * (8 * i + k))
              for i in range(8) for k in range(8) for name in [("pedestal", "cornell_short")[(i + k) % 2]]]
    return scene(ROOM, PANEL, *things)


NOISIER = {"lamp_shade": 4, "small_light": 4, "window": 8}  # times the samples: light comes by rare paths
SCENES = {  # kind, and whether constants were chosen with the scene in view
    "cornell": (cornell, "open in front, one lamp", "tuned"),
    "lamp_shade": (lamp_shade, "bulb in a shade, as in the twelve-object room", "tuned"),
    "closed": (closed, "closed", "held out"),
    "open_air": (open_air, "open", "held out"),
    "small_light": (small_light, "one small bright light", "held out"),
    "point_light": (point_light, "one point light", "held out"),
    "sky_only": (sky_only, "sky only", "held out"),
    "window": (window, "sky through a window", "held out"),
    "dark_reflecting": (dark_reflecting, "dark, reflectance 0.9", "tuned"),
    "white_room": (white_room, "bright, reflectance 0.85", "held out"),
    "foliage": (foliage, "foliage", "held out"),
    "near_contact": (near_contact, "near contact", "held out"),
    "many": (many, "many instances", "held out"),
}


def measure(program, folder, name, options):
    path = folder / f"{name}.json"
    path.write_text(json.dumps(SCENES[name][0](), indent=1))
    subprocess.run([program, "tradeoff", path, "--out", folder / name, "--methods", "reusable", "--no-knobs", "--no-pictures",
                    "--repeats", "1", "--quiet", "--accuracy", options.accuracy,
                    "--samples", str(options.samples * NOISIER.get(name, 1))], check=True)
    return json.loads((folder / name / "tradeoff.json").read_text())


def verdict(point, noise):
    """In words; empty: as it should be. Two standard errors of doubt count for the solver where the truth is noisy."""
    error, estimate, asked = point["error"], point["estimated_error"], point["accuracy"]
    if error["high"] < SMALL * asked:
        return "better than a tenth of what was asked"
    noisy = noise > NOISY * error["value"]
    low, high = (error["low"], error["high"]) if noisy else (error["value"], error["value"])
    told = low / 2 <= estimate <= 2 * high
    met = low <= 1.5 * asked
    if noisy and told and met:
        return "the truth is too noisy to tell"
    return ", ".join(word for word, fine in (("**estimate**", told), ("**asked**", met)) if not fine)


def main(options):
    print("| scene | kind | | triangles | truth's standard error | asked | error | estimate / error | error / asked | seconds | outside |")
    print("|---|---|---|---:|---:|---:|---:|---:|---:|---:|---|")
    judged = told = met = 0
    for name in options.scenes or SCENES:
        result = measure(options.program, options.folder, name, options)
        noise = result["truth"]["standard_error"]
        head = f"| {name} | {SCENES[name][1]} | {SCENES[name][2]} | {result['triangles']:,} | {noise:.3f} "
        for point in result["points"]:
            if point["not_run"]:
                print(f"{head}| {point['accuracy']:g} | | | | | {point['not_run']} |")
                continue
            error, words = point["error"]["value"], verdict(point, noise)
            if not words.startswith(("better", "the truth")):
                judged += 1
                told += "estimate" not in words
                met += "asked" not in words
            ratio = f"{point['estimated_error'] / error:.2f}" if error > 0 else ""
            print(f"{head}| {point['accuracy']:g} | {error:.4f} | {ratio} | {error / point['accuracy']:.2f} "
                  f"| {point['seconds']['median']:.2f} | {words} |")
            head = "| | | | | "
        sys.stdout.flush()
    print(f"\nOf {judged} judged: estimate over error between 1/2 and 2 in {told}, error at most 1.5 of what was asked in {met}.")


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("program")
    parser.add_argument("folder", type=Path)
    parser.add_argument("scenes", nargs="*", metavar="SCENE", choices=[*SCENES, []], help=", ".join(SCENES))
    parser.add_argument("--samples", type=int, default=256)
    parser.add_argument("--accuracy", default="0.2,0.1,0.05")
    options = parser.parse_args()
    options.folder.mkdir(parents=True, exist_ok=True)
    main(options)
