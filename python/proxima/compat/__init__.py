"""Queries of other libraries by their own names and conventions, answered by Proxima.

    proxima.compat.trimesh   ProximityQuery, RayMeshIntersector
    proxima.compat.open3d    RaycastingScene
    proxima.compat.igl       point_mesh_squared_distance, signed_distance

None of them imports the other library.
"""
from __future__ import annotations

from typing import Any

from .. import Mesh


def mesh_of(mesh: Any) -> Mesh:
    """A Mesh of one, or of anything with `vertices` and `faces`."""
    return mesh if isinstance(mesh, Mesh) else Mesh(mesh.vertices, mesh.faces)
