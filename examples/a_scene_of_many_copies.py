"""A thousand copies of a mesh: what a ray hits, what is near a point, which copies meet, and the same after they moved.

    python3 examples/a_scene_of_many_copies.py [MESH]
"""
import sys

import numpy as np

import proxima

mesh = proxima.Mesh.read(sys.argv[1]) if len(sys.argv) > 1 else proxima.Mesh.sample("torus:60x30")
index = proxima.Index(mesh)  # once, for all copies
size = np.ptp(mesh.bounds, axis=0).max()
random = np.random.default_rng(1)
count, edge = 1000, 15 * size


def turned(angles):
    """Poses (n, 3, 4) about z, anywhere in a cube."""
    cos, sin, zero, one = np.cos(angles), np.sin(angles), np.zeros(count), np.ones(count)
    rotations = np.stack([cos, -sin, zero, sin, cos, zero, zero, zero, one], axis=1).reshape(-1, 3, 3)
    return np.dstack([rotations, random.uniform(0, edge, (count, 3))])


poses = turned(random.uniform(0, 2 * np.pi, count))
scene = proxima.Scene(index, poses, layers=1 + np.arange(count) % 2)  # two layers: bits 1 and 2
print(scene)
hits = scene.cast(random.uniform(0, edge, (10_000, 3)), random.normal(size=(10_000, 3)))
print(f"{hits.hit.mean():.0%} of the rays hit; the first hits copy {hits.instance[hits.hit][0]}")
near = scene.closest([[edge / 2] * 3], layers=2)
print(f"nearest to the middle on layer 2: copy {near.instance[0]}, {near.distance[0] / size:.2f} sizes away")
print(f"{len(scene.in_contact().a)} pairs meet, {len(scene.within(0.1 * size).a)} are within a tenth of the size")
poses[:, 2, 3] += 0.5 * size * np.sin(poses[:, 0, 3])
print(f"after all have moved {len(scene.move(poses).in_contact().a)} pairs meet")
