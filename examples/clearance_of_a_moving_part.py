"""How near a part comes to another one on its way, and where they meet: one query for all poses.

    python3 examples/clearance_of_a_moving_part.py [MESH [PART]]
"""
import sys

import numpy as np

import proxima

def index_of(name):
    return proxima.Index(proxima.Mesh.read(name) if "." in name else proxima.Mesh.sample(name), distances=True)


names = sys.argv[1:] or ["torus:100x50", "icosphere:4"]
fixed, part = index_of(names[0]), index_of(names[-1])
size = np.linalg.norm(np.subtract(*fixed.mesh().bounds))
poses = np.tile(np.eye(4), (50, 1, 1))
poses[:, 0, 3] = np.linspace(2 * size, 0, len(poses))  # along x, to the middle

apart = fixed.distance_to(part, poses)
meets = fixed.intersect(part, poses, pairs=False)
for step in range(0, len(poses), 7):
    print(f"x = {poses[step, 0, 3]:6.3f}: {apart.distance[step]:.4f} apart" + (", they meet" if meets[step] else ""))
if meets.any():
    pairs = fixed.intersect(part, poses[meets.argmax()])
    print(f"first contact at x = {poses[meets.argmax(), 0, 3]:.3f}: {len(pairs.a)} pairs of triangles")
