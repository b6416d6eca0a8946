"""An X-ray picture of a closed mesh: how much of each of many parallel rays is inside, by all hits of each.

    python3 examples/x_ray_of_a_mesh.py [MESH]
"""
import sys

import numpy as np

import proxima

mesh = proxima.Mesh.read(sys.argv[1]) if len(sys.argv) > 1 else proxima.Mesh.sample("torus:100x50")
index = proxima.Index(mesh)
lower, upper = mesh.bounds
rows, columns = 200, 200
# Rays along x. Pixels lie between edges of models made of round numbers.
y, z = (low + (np.arange(n) + 0.4871) * (high - low) / n for low, high, n in zip(lower[1:], upper[1:], (columns, rows)))
origins = np.stack([np.full((rows, columns), lower[0] - 1), *np.meshgrid(y, z[::-1])], axis=-1).reshape(-1, 3)
hits = index.cast(origins, [[1, 0, 0]] * len(origins), hits="all")

# Rays leave where they entered a closed mesh: the odd hits less the even ones.
place = np.arange(len(hits.t)) - np.repeat(hits.first[:-1], np.diff(hits.first))
ray = np.repeat(np.arange(len(origins)), np.diff(hits.first))
inside = np.bincount(ray, np.where(place % 2 == 1, hits.t, -hits.t), len(origins)).reshape(rows, columns)
pixel = (upper - lower)[1] / columns * (upper - lower)[2] / rows
print(f"{len(hits.t)} hits; at most {inside.max():.4f} inside; volume {inside.sum() * pixel:.4f}")
for row in inside[::10, ::4]:
    print("".join(" .:-=+*#@"[int(8 * max(value, 0) / inside.max())] for value in row))
