"""Repairs a mesh: welds vertices, drops flawed triangles, turns all to face outward. Writes it where OUT is given.

    python3 examples/repair_a_mesh.py [MESH [OUT]]
"""
import sys

import numpy as np

import proxima


def broken():
    """A torus whose triangles have corners of their own, a little moved, and face either way."""
    mesh, random = proxima.Mesh.sample("torus:40x20"), np.random.default_rng(1)
    corners = mesh.vertices[mesh.faces] + random.uniform(-1e-7, 1e-7, (len(mesh.faces), 3, 3))
    turned = random.random(len(corners)) < 0.3
    corners[turned] = corners[turned][:, ::-1]
    return proxima.Mesh(corners.reshape(-1, 3), np.arange(3 * len(corners)).reshape(-1, 3))


mesh = proxima.Mesh.read(sys.argv[1]) if len(sys.argv) > 1 else broken()
size = np.linalg.norm(np.subtract(*mesh.bounds))
repair = mesh.repair(weld_distance=1e-6 * size)
for step, count in repair.steps.items():
    if count:
        print(f"{step.replace('_', ' ')}: {count}")
before, after = mesh.report(), repair.mesh.report()
print(f"closed: {before.closed} before, {after.closed} after" + ("" if after.volume is None else f"; volume {after.volume:.4f}"))
for finding in after.findings:
    print(f"left: {finding.number} {finding.kind.replace('_', ' ')}")
if len(sys.argv) > 2:
    repair.mesh.write(sys.argv[2])
