"""Signed distances of a mesh on a regular grid, with the grid's volume by counting. Saves them where OUT.npz is given.

    python3 examples/signed_distances_on_a_grid.py [MESH [OUT.npz]]
"""
import sys

import numpy as np

import proxima

mesh = proxima.Mesh.read(sys.argv[1]) if len(sys.argv) > 1 else proxima.Mesh.sample("torus:100x50")
index = proxima.Index(mesh, signs=True)
field = index.distance_field(52)
distance, spacing = field.distance, field.spacing  # (nx, ny, nz), negative inside
print(f"{distance.shape} values from {distance.min():.4f} inside to {distance.max():.4f} outside")
slope = np.linalg.norm(np.gradient(distance, spacing), axis=0)
print(f"they change by {np.median(slope):.3f} per unit of length, {(distance < 0).sum() * spacing**3:.4f} of the volume is inside")

row = distance[:, :, distance.shape[2] // 2]
for line in row[::2, ::2]:
    print("".join("#" if value < 0 else "+" if value < 3 * spacing else "." for value in line))
if len(sys.argv) > 2:
    np.savez_compressed(sys.argv[2], distance=distance, origin=field.origin, spacing=spacing)
