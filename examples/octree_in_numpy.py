"""The octree of a mesh as arrays, and as files for ParaView (.htg, .vtu) where a folder is given.

    python3 examples/octree_in_numpy.py [MESH [FOLDER]]
"""
import sys
from pathlib import Path

import numpy as np

import proxima

mesh = proxima.Mesh.read(sys.argv[1]) if len(sys.argv) > 1 else proxima.Mesh.sample("torus:100x50")
octree = proxima.Octree(mesh, max_depth=6, threshold=8)
leaves = octree.leaves()
volume = np.prod(leaves.upper - leaves.lower, axis=1)
for kind, name in enumerate(proxima.CELL_KINDS[:3]):
    of_kind = leaves.kind == kind
    print(f"{name}: {of_kind.sum()} leaves, {volume[of_kind].sum():.4f} of the volume, depths {np.unique(leaves.depth[of_kind])}")
full = np.diff(leaves.first)
print(f"{full.max()} triangles in the fullest leaf, {full[full > 0].mean():.2f} on average")
i = full.argmax()
print(f"those of the fullest: {leaves.triangle[leaves.first[i]:leaves.first[i + 1]]}")

lower, upper = mesh.bounds
ray = octree.along_rays([[lower[0] - 1, *(lower + upper)[1:] / 2]], [[1, 0, 0]])
inner = leaves.kind[ray.leaf] == 1
print(f"a ray along x goes through {len(ray.leaf)} leaves, {ray.chord[inner].sum():.4f} of it inside")
if len(sys.argv) > 2:
    for name in ("octree.htg", "octree.vtu"):
        octree.export(mesh, Path(sys.argv[2]) / name)
