#!/usr/bin/env python3
"""Decimates an OBJ file: edges collapse in the order of their quadric error, closed parts stay closed, materials stay.

    decimate.py IN.obj TRIANGLES OUT.obj

Parts end as tetrahedra at the least, so that OUT may have more triangles than asked. [GH 97] M. Garland, P. Heckbert,
"Surface simplification using quadric error metrics", SIGGRAPH 1997."""

import heapq
import sys
from itertools import combinations
from math import sqrt

BORDER_WEIGHT = 10  # of planes that hold open edges and edges between materials where they are, against faces'


def read(path):
    points, faces, material, header = [], [], None, []
    for line in open(path):
        words = line.split()
        if not words:
            continue
        if words[0] == "v":
            points.append(tuple(map(float, words[1:4])))
        elif words[0] == "usemtl":
            material = words[1]
        elif words[0] == "mtllib":
            header.append(line)
        elif words[0] == "f":
            corners = [int(w.split("/")[0]) - 1 for w in words[1:]]
            faces += [(corners[0], corners[k], corners[k + 1], material) for k in range(1, len(corners) - 1)]
    return points, faces, header


def sub(a, b):
    return (a[0] - b[0], a[1] - b[1], a[2] - b[2])


def cross(a, b):
    return (a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0])


def dot(a, b):
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


def plane_quadric(normal, through, weight):
    """Upper triangle of w p p^T, p = (n, -n . x)."""
    size = sqrt(dot(normal, normal))
    if size == 0:
        return [0.0] * 10
    n = [c / size for c in normal]
    p = (*n, -dot(n, through))
    return [weight * p[i] * p[j] for i in range(4) for j in range(i, 4)]


def error(q, p):
    x, y, z = p
    return (q[0] * x * x + 2 * q[1] * x * y + 2 * q[2] * x * z + 2 * q[3] * x + q[4] * y * y + 2 * q[5] * y * z + 2 * q[6] * y +
            q[7] * z * z + 2 * q[8] * z + q[9])


class Mesh:
    def __init__(self, points, faces):
        self.points, self.faces = list(points), dict(enumerate(faces))
        self.around = [set() for _ in points]  # faces
        for f, (a, b, c, _) in self.faces.items():
            for v in (a, b, c):
                self.around[v].add(f)
        self.quadric = [[0.0] * 10 for _ in points]
        self.stamp = [0] * len(points)
        for f in self.faces:
            self.add_quadrics(f)
        self.heap = []
        for a, b in {tuple(sorted(e)) for f in self.faces.values() for e in combinations(f[:3], 2)}:
            self.offer(a, b)

    def add_quadrics(self, f):
        a, b, c, material = self.faces[f]
        normal = cross(sub(self.points[b], self.points[a]), sub(self.points[c], self.points[a]))
        size = sqrt(dot(normal, normal))
        self.add(plane_quadric(normal, self.points[a], size), (a, b, c))
        for u, v in ((a, b), (b, c), (c, a)):
            others = [g for g in self.around[u] & self.around[v] if g != f]
            if len(others) != 1 or self.faces[others[0]][3] != material:
                side = cross(sub(self.points[v], self.points[u]), normal)
                self.add(plane_quadric(side, self.points[u], BORDER_WEIGHT * size), (u, v))

    def add(self, quadric, vertices):
        for v in vertices:
            self.quadric[v] = [x + y for x, y in zip(self.quadric[v], quadric)]

    def offer(self, a, b):
        """The best of both ends and the middle."""
        q = [x + y for x, y in zip(self.quadric[a], self.quadric[b])]
        pa, pb = self.points[a], self.points[b]
        at = min(((error(q, p), k, p) for k, p in enumerate((pa, pb, tuple((x + y) / 2 for x, y in zip(pa, pb))))))
        heapq.heappush(self.heap, (at[0], a, b, self.stamp[a], self.stamp[b], at[2]))

    def neighbours(self, v):
        return {u for f in self.around[v] for u in self.faces[f][:3]} - {v}

    def may_collapse(self, a, b, at):
        shared = self.around[a] & self.around[b]
        if not shared or len(self.neighbours(a) & self.neighbours(b)) != len(shared):
            return False  # two sheets would touch
        if len(self.around[a] | self.around[b]) <= 4:
            return False  # a tetrahedron
        for v, other in ((a, b), (b, a)):
            for f in self.around[v] - shared:
                before = [self.points[u] for u in self.faces[f][:3]]
                after = [at if u == v else self.points[u] for u in self.faces[f][:3]]
                n0 = cross(sub(before[1], before[0]), sub(before[2], before[0]))
                n1 = cross(sub(after[1], after[0]), sub(after[2], after[0]))
                if dot(n0, n1) <= 0.2 * sqrt(dot(n0, n0) * dot(n1, n1)):
                    return False  # folded over, or without area
        return True

    def collapse(self, a, b, at):
        for f in self.around[a] & self.around[b]:
            for v in self.faces[f][:3]:
                self.around[v].discard(f)
            del self.faces[f]
        for f in self.around[b]:
            *corners, material = self.faces[f]
            self.faces[f] = (*(a if v == b else v for v in corners), material)
        self.around[a] |= self.around[b]
        self.around[b] = set()
        self.points[a] = at
        self.quadric[a] = [x + y for x, y in zip(self.quadric[a], self.quadric[b])]
        self.stamp[a] += 1
        self.stamp[b] += 1
        for u in sorted(self.neighbours(a)):
            self.offer(min(a, u), max(a, u))

    def decimate(self, triangles):
        while self.heap and len(self.faces) > triangles:
            _, a, b, at_a, at_b, at = heapq.heappop(self.heap)
            if (at_a, at_b) == (self.stamp[a], self.stamp[b]) and self.may_collapse(a, b, at):
                self.collapse(a, b, at)


def write(path, mesh, header):
    number, lines, material = {}, [], None
    for a, b, c, name in mesh.faces.values():
        if name and name != material:
            lines.append(f"usemtl {name}")
            material = name
        lines.append("f " + " ".join(str(number.setdefault(v, len(number) + 1)) for v in (a, b, c)))
    vertices = ["v %.9g %.9g %.9g" % mesh.points[v] for v in number]
    with open(path, "w") as out:
        out.write("".join(header) + "\n".join(vertices + lines) + "\n")


def decimate(source, triangles, target):
    """returns  triangles before and after"""
    points, faces, header = read(source)
    mesh = Mesh(points, faces)
    mesh.decimate(triangles)
    write(target, mesh, header)
    return len(faces), len(mesh.faces)


if __name__ == "__main__":
    if len(sys.argv) != 4:
        sys.exit("usage: decimate.py IN.obj TRIANGLES OUT.obj")
    print("%d -> %d triangles" % decimate(sys.argv[1], int(sys.argv[2]), sys.argv[3]))
