"""Queries of other libraries by their own names and conventions, answered by Proxima.

    proxima.compat.trimesh   ProximityQuery, RayMeshIntersector
    proxima.compat.open3d    RaycastingScene
    proxima.compat.igl       point_mesh_squared_distance, signed_distance

None of them imports the other library.
"""
from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from .. import InvalidInput, Mesh

if TYPE_CHECKING:
    from numpy.typing import NDArray


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


def scaled(vectors: NDArray[np.float64]) -> NDArray[np.float64]:
    """Vectors (.., 3) by powers of two, so that products of their coordinates neither overflow nor vanish."""
    _, exponent = np.frexp(np.abs(vectors).max(axis=-1, keepdims=True, initial=0))
    within: NDArray[np.float64] = np.ldexp(vectors, -exponent)
    return within


def unit(vectors: NDArray[np.float64]) -> NDArray[np.float64]:
    """Vectors (n, 3) of any size with length 1; 0 stays 0."""
    vectors = scaled(vectors)
    length = np.linalg.norm(vectors, axis=1, keepdims=True)
    of_length_1: NDArray[np.float64] = np.divide(vectors, length, out=np.zeros_like(vectors), where=length > 0)
    return of_length_1


def normals(corners: NDArray[np.float64]) -> NDArray[np.float64]:
    """Normals (n, 3) of length 1 of triangles (n, 3, 3) of any size, 0 for those without an area."""
    return unit(np.cross(scaled(corners[:, 1] - corners[:, 0]), scaled(corners[:, 2] - corners[:, 0])))


def refusal(message: str) -> InvalidInput:
    """The error of an argument that is refused."""
    error = InvalidInput(message)
    error.code = "invalid_argument"
    return error


def a_type(given: Any) -> str:
    """Names the type of what was given."""
    kind = type(given)
    return "None" if given is None else kind.__qualname__ if kind.__module__ == "builtins" else f"{kind.__module__}.{kind.__qualname__}"
