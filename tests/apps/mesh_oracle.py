"""Meshes of a few triangles, with searches of all their features, and vectors as tuples."""
import math

from bad_input_test import off


def sub(a, b):
    return tuple(x - y for x, y in zip(a, b))


def dot(a, b):
    return sum(x * y for x, y in zip(a, b))


def cross(a, b):
    return (a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0])


def along(a, direction, t):
    return tuple(x + t * d for x, d in zip(a, direction))


class Mesh:
    """Points, triangles, and edges numbered in order of first appearance."""

    def __init__(self, points, triangles):
        self.points, self.triangles, self.edges = points, triangles, {}
        for triangle in triangles:
            for i in range(3):
                self.edges.setdefault(frozenset((triangle[i], triangle[(i + 1) % 3])), len(self.edges))

    def features(self, p):
        """(squared distance, kind, id, point) of all features whose inside holds their closest point."""
        for id, point in enumerate(self.points):
            yield dot(sub(p, point), sub(p, point)), 0, id, point
        for edge, id in self.edges.items():
            a, b = (self.points[v] for v in sorted(edge))
            side = sub(b, a)
            t = dot(sub(p, a), side) / dot(side, side)
            if 0 < t < 1:
                point = along(a, side, t)
                yield dot(sub(p, point), sub(p, point)), 1, id, point
        for id, triangle in enumerate(self.triangles):
            a, b, c = (self.points[v] for v in triangle)
            normal = cross(sub(b, a), sub(c, a))
            point = along(p, normal, -dot(sub(p, a), normal) / dot(normal, normal))
            if all(dot(cross(sub(v, u), sub(point, u)), normal) > 0 for u, v in ((a, b), (b, c), (c, a))):
                yield dot(sub(p, point), sub(p, point)), 2, id, point

    def triangle_of(self, kind, id):
        if kind == 2:
            return id
        edges = {number: edge for edge, number in self.edges.items()}
        wanted = {id} if kind == 0 else edges[id]
        return next(i for i, triangle in enumerate(self.triangles) if wanted <= set(triangle))

    def solid_angle(self, p):
        total = 0
        for triangle in self.triangles:
            a, b, c = (sub(self.points[v], p) for v in triangle)
            la, lb, lc = (math.sqrt(dot(x, x)) for x in (a, b, c))
            total += 2 * math.atan2(dot(a, cross(b, c)),
                                    la * lb * lc + dot(a, b) * lc + dot(b, c) * la + dot(c, a) * lb)
        return total

    def text(self):
        return off(self.points, self.triangles)


def bumpy_ball(rng):
    """An octahedron split twice, its corners pushed in and out: closed, not convex."""
    points = [(1.0, 0, 0), (-1.0, 0, 0), (0, 1.0, 0), (0, -1.0, 0), (0, 0, 1.0), (0, 0, -1.0)]
    triangles = [(0, 2, 4), (2, 1, 4), (1, 3, 4), (3, 0, 4), (2, 0, 5), (1, 2, 5), (3, 1, 5), (0, 3, 5)]
    for _ in range(2):
        middles, smaller = {}, []

        def middle(a, b):
            key = frozenset((a, b))
            if key not in middles:
                point = along(points[a], sub(points[b], points[a]), 0.5)
                length = math.sqrt(dot(point, point))
                points.append(tuple(x / length for x in point))
                middles[key] = len(points) - 1
            return middles[key]
        for a, b, c in triangles:
            ab, bc, ca = middle(a, b), middle(b, c), middle(c, a)
            smaller += [(a, ab, ca), (b, bc, ab), (c, ca, bc), (ab, bc, ca)]
        triangles = smaller
    return Mesh([tuple(rng.uniform(0.7, 1.1) * x for x in point) for point in points], triangles)


def soup(rng, count):
    points = [tuple(rng.uniform(-1, 1) for _ in range(3)) for _ in range(3 * count)]
    return Mesh(points, [(3 * i, 3 * i + 1, 3 * i + 2) for i in range(count)])
