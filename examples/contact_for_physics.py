"""A body that flies into another one: when it first touches, how deep it is at the end, and where to push.

    python3 examples/contact_for_physics.py [CLOSED_MESH]
"""
import sys

import numpy as np

import proxima

mesh = proxima.Mesh.read(sys.argv[1]) if len(sys.argv) > 1 else proxima.Mesh.sample("torus:60x30")
fixed = proxima.Solid(proxima.Index(mesh, distances=True))
body = proxima.Solid(proxima.Mesh.sample("icosphere:3"))
lower, upper = mesh.bounds
start, end = np.eye(4), np.eye(4)
start[:3, 3] = upper + 3
end[:3, 3] = 0.7 * upper + 0.3 * lower

motion = proxima.motion_between(start, end, [0, 0, 0])
contact = fixed.index.time_of_contact(body.index, motion)
if contact is None:
    sys.exit("no contact on the way")
print(f"free until {contact.free_until:.6f}, {proxima.CONTACT_EVIDENCE[contact.evidence]} at {contact.touches_at:.6f}, "
      f"normal {np.round(contact.normal, 3)}")

depth = fixed.penetration_depth(body, end)
print(f"at the end {depth.lower:.4f} to {depth.upper:.4f} deep ({proxima.PENETRATION_METHODS[depth.method]})")
for i, (position, normal) in enumerate(zip(*fixed.contact_regions(body, end)[:2])):
    print(f"  region {i} at {np.round(position, 3)}, push along {np.round(normal, 3)}")
end[:3, 3] += depth.translation
print("moved out, they overlap:", fixed.overlaps(body, end))
