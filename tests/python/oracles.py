"""Slow answers by NumPy alone: every query against every triangle."""
import numpy as np


def corners(mesh):
    """(F, 3, 3) float64."""
    return np.asarray(mesh.vertices)[np.asarray(mesh.faces)]


def dot(a, b):
    return np.einsum("...k,...k->...", a, b)


def segment_distances(p, a, b):
    """(n, F) distances of points (n, 3) from segments (F, 3)."""
    along = b - a
    length = dot(along, along)
    with np.errstate(invalid="ignore", divide="ignore"):
        t = dot(p[:, None] - a, along) / length
    t = np.clip(np.where(length > 0, t, 0), 0, 1)
    return np.linalg.norm(p[:, None] - (a + t[..., None] * along), axis=-1)


def triangle_distances(mesh, p):
    """(n, F) distances of points from triangles, degenerate ones too."""
    a, b, c = np.moveaxis(corners(mesh), 1, 0)
    best = np.minimum(segment_distances(p, a, b), np.minimum(segment_distances(p, b, c), segment_distances(p, c, a)))
    normal = np.cross(b - a, c - a)
    square = dot(normal, normal)
    q = p[:, None] - a
    with np.errstate(invalid="ignore", divide="ignore"):
        u = dot(np.cross(q, c - a), normal) / square
        v = dot(np.cross(b - a, q), normal) / square
        height = np.abs(dot(q, normal)) / np.sqrt(square)
    inside = (square > 0) & (u >= 0) & (v >= 0) & (u + v <= 1)
    return np.where(inside, height, best)


def winding_numbers(mesh, p):
    """(n,): sums of solid angles over 4 pi."""
    a, b, c = (x[None] - p[:, None] for x in np.moveaxis(corners(mesh), 1, 0))
    la, lb, lc = (np.linalg.norm(x, axis=-1) for x in (a, b, c))
    above = dot(a, np.cross(b, c))
    below = la * lb * lc + dot(a, b) * lc + dot(b, c) * la + dot(c, a) * lb
    return (2 * np.arctan2(above, below)).sum(axis=1) / (4 * np.pi)


def ray_hits(mesh, origins, directions):
    """(n, F) t of hits, NaN where a ray misses a triangle."""
    a, b, c = np.moveaxis(corners(mesh), 1, 0)
    e1, e2 = b - a, c - a
    h = np.cross(directions[:, None], e2)
    det = dot(h, e1)
    s = origins[:, None] - a
    with np.errstate(invalid="ignore", divide="ignore"):
        u = dot(s, h) / det
        q = np.cross(s, e1)
        v = dot(directions[:, None], q) / det
        t = dot(e2, q) / det
    return np.where((u >= 0) & (v >= 0) & (u + v <= 1) & (t >= 0), t, np.nan)
