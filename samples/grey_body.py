#!/usr/bin/env python3
"""Net heat exchange of grey surfaces from the CSV of `rro-solve factors`.

    grey_body.py FACTORS.csv NAME=KELVIN[,EMISSIVITY] ...     emissivity 0.9 where not given

Prints W for each surface, positive where it loses heat. What rows lack to 1 is open to a space at 0 K.
"""
import csv, sys

SIGMA = 5.670374419e-8  # W / (m^2 K^4)
rows = list(csv.DictReader(open(sys.argv[1], newline="")))
area = {r["from"]: float(r["area_from"]) for r in rows}
given = dict(a.rsplit("=", 1) for a in sys.argv[2:])
missing = area.keys() - given.keys()
if missing:
    sys.exit("no temperature for: " + ", ".join(sorted(missing)))
state = {n: [float(x) for x in (given[n] + ",0.9").split(",")[:2]] for n in area}
black = {n: SIGMA * t ** 4 for n, (t, _) in state.items()}
seen = {n: [] for n in area}
for r in rows:
    seen[r["from"]].append((r["to"], float(r["factor"])))
B = dict(black)  # radiosity: emission, and what is reflected of the others' radiosity
for _ in range(200):
    E = {n: sum(F * B[to] for to, F in seen[n]) for n in area}
    B = {n: e * black[n] + (1 - e) * E[n] for n, (_, e) in state.items()}
for n in area:
    print("%-24s %12.3f W" % (n, area[n] * (B[n] - E[n])))
