"""Whether two parts meet, in which triangles, along which curves; or whether one is inside the other.

    python3 examples/where_two_parts_meet.py [MESH [PART]]
"""
import sys

import numpy as np

import proxima


def index_of(name):
    return proxima.Index(proxima.Mesh.read(name) if "." in name else proxima.Mesh.sample(name))


names = sys.argv[1:] or ["torus:100x50", "icosphere:4"]
fixed, part = index_of(names[0]), index_of(names[-1])
size = np.linalg.norm(np.subtract(*fixed.mesh().bounds))
for step in (0, 0.15, 0.3, 2):
    pose = np.eye(4)
    pose[0, 3] = step * size
    pairs = fixed.intersect(part, pose)
    if pairs.intersecting:
        contour = fixed.contour(part, pose)
        print(f"x + {pose[0, 3]:.3f}: {len(pairs.a)} pairs of triangles meet, {len(np.unique(pairs.a))} of the first part's, along "
              f"{len(contour.closed)} lines, {contour.closed.sum()} of them closed, of length {contour.length:.4f}")
    else:
        inside = proxima.CONTAINMENTS[fixed.containment(part, pose).containment]
        print(f"x + {pose[0, 3]:.3f}: apart by {fixed.distance_to(part, pose).distance:.4f}, contained: {inside}")
