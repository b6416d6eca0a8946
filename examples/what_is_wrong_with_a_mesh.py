"""Whether a mesh is watertight, and if not, what is wrong, where, and what still works.

    python3 examples/what_is_wrong_with_a_mesh.py [MESH]
"""
import sys

import proxima


def broken():
    """A torus with a hole, and a triangle that faces the wrong way."""
    mesh = proxima.Mesh.sample("torus:40x20")
    faces = mesh.faces[4:].copy()
    faces[100] = faces[100, ::-1]
    return proxima.Mesh(mesh.vertices, faces)


mesh = proxima.Mesh.read(sys.argv[1]) if len(sys.argv) > 1 else broken()
report = mesh.report(max_ids=3)
print("watertight" if report.closed and report.consistently_oriented else "not watertight")
for finding in report.findings:
    print(f"{finding.severity}: {finding.number} {finding.kind.replace('_', ' ')}, the first at {finding.positions[:1].round(3)}")
for query, (outlook, reason) in report.outlook.items():
    if outlook != "works":
        print(f"{query}: {outlook.replace('_', ' ')}: {reason}")
if report.outlook["intersection"][0] != "refused":
    print(f"{len(proxima.Index(mesh).self_intersections().a)} pairs of triangles pass through each other")
