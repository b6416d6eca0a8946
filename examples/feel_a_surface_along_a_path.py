"""What a hand would feel that strokes a mesh: force, friction and contacts, tick by tick, without a device.

    python3 examples/feel_a_surface_along_a_path.py [MESH]
"""
import sys

import numpy as np

import proxima

mesh = proxima.Mesh.read(sys.argv[1]) if len(sys.argv) > 1 else proxima.Mesh.sample("torus:100x50")
index = proxima.Index(mesh)
renderer = proxima.TouchRenderer(index, stiffness=300, static_friction=0.4, dynamic_friction=0.3)

# A second down onto the top of the model, 3 mm deep, and two seconds across, at 1,000 ticks a second; in metres of the device.
lower, upper = mesh.bounds
middle = (lower + upper) / 2
top = index.closest_one(*(middle + [0.3 * (upper - lower)[0], 0, (upper - lower)[2]])).point
start = (np.array(top) - renderer.center) / renderer.units_per_metre
down = np.linspace(start + [0, 0, 0.01], start - [0, 0, 0.003], 1000)
across = np.linspace(down[-1], down[-1] + [0, 0.02, 0], 2000)
path = np.concatenate([down, across])
touch = renderer.step(path, np.gradient(path, 1e-3, axis=0))

strength = np.linalg.norm(touch.force, axis=1)
for tick in range(0, len(path), 300):
    print(f"{tick:5} ms  {strength[tick]:6.3f} N  {proxima.HOLDS[touch.hold[tick]]}")
contacts = np.unique(touch.contacts.triangle)
print(f"at most {strength.max():.3f} N; {(touch.hold == 2).sum()} ms sticking, {(touch.hold == 1).sum()} ms sliding, "
      f"on {len(contacts)} triangles")
