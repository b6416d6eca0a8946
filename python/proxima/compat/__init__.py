"""Queries of other libraries by their own names and conventions, answered by Proxima.

    proxima.compat.trimesh   ProximityQuery, RayMeshIntersector
    proxima.compat.open3d    RaycastingScene
    proxima.compat.igl       point_mesh_squared_distance, signed_distance

None of them imports the other library.
"""
from __future__ import annotations

from typing import Any

import numpy as np

from .. import InvalidInput, Mesh


def mesh_of(mesh: Any, wanted: str = "a proxima.Mesh, or a mesh with vertices and faces as a trimesh.Trimesh has") -> Mesh:
    """A Mesh of one, or of anything with `vertices` and `faces`."""
    if isinstance(mesh, Mesh):
        return mesh
    if hasattr(mesh, "vertices") and hasattr(mesh, "faces"):
        return Mesh(mesh.vertices, mesh.faces)
    raise refusal(f"mesh: must be {wanted}, is {a_type(mesh)}")


def welded(mesh: Mesh) -> Mesh:
    """The mesh with vertices at the same position joined; faces keep their order."""
    # Adding 0 makes -0 and 0 the same.
    vertices, ids = np.unique(mesh.vertices + 0.0, axis=0, return_inverse=True)
    return mesh if len(vertices) == len(mesh.vertices) else Mesh(vertices, ids.reshape(-1)[mesh.faces])


def refusal(message: str) -> InvalidInput:
    """The error of an argument that is refused."""
    error = InvalidInput(message)
    error.code = "invalid_argument"
    return error


def a_type(given: Any) -> str:
    """Names the type of what was given."""
    kind = type(given)
    return "None" if given is None else kind.__qualname__ if kind.__module__ == "builtins" else f"{kind.__module__}.{kind.__qualname__}"
