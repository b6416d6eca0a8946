"""What a camera sees of a mesh: the triangles in its view, and an image by one ray for each pixel.

    python3 examples/what_a_camera_sees.py [MESH]
"""
import sys

import numpy as np

import proxima

mesh = proxima.Mesh.read(sys.argv[1]) if len(sys.argv) > 1 else proxima.Mesh.sample("torus:100x50")
index = proxima.Index(mesh)
lower, upper = mesh.bounds
size = np.linalg.norm(upper - lower)
eye = (lower + upper) / 2 + size * np.array([0.2, -0.75, 0.55])
forward = (lower + upper) / 2 - eye
forward /= np.linalg.norm(forward)
right = np.cross(forward, [0, 0, 1])
right /= np.linalg.norm(right)
up = np.cross(right, forward)

angle = np.radians(45)
planes = proxima.perspective(eye, forward, up, field_of_view=angle, aspect=2)
seen = index.visible(planes, exact=True)
print(f"{len(seen)} of {len(mesh.faces)} triangles are in view")

rows, columns = 24, 96
y, x = np.meshgrid(np.linspace(1, -1, rows), np.linspace(-2, 2, columns), indexing="ij")
rays = forward + np.tan(angle / 2) * (x[..., None] * right + y[..., None] * up)
hits = index.cast(eye, rays.reshape(-1, 3))
a, b, c = np.moveaxis(mesh.vertices[mesh.faces[hits.triangle]], 1, 0)  # -1 is some triangle, masked below
normal = np.cross(b - a, c - a)
light = np.abs(normal @ [0.5, -0.5, 0.7]) / np.maximum(np.linalg.norm(normal, axis=1), 1e-300)
shade = np.where(hits.hit, 1 + np.minimum(light * 8, 7).astype(int), 0).reshape(rows, columns)
print("\n".join("".join(" .:-=+*#@"[value] for value in row) for row in shade))
