"""Two functions of libigl's Python bindings, as versions 2.4 and 2.5 have them.

    from proxima.compat.igl import point_mesh_squared_distance, signed_distance

    squared, triangles, closest = point_mesh_squared_distance(P, V, F)
    distances, triangles, closest = signed_distance(P, V, F)           # negative inside

Each call builds an index, as libigl builds its tree: to ask several times, make a proxima.Index. Among triangles that
share the closest point the lowest is named. Lengths have the dtype of P, float32 or float64, ids that of F, int32 or int64.
Other integers, as uint32 or int8, are answered by int64.
"""
from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from .. import Closest, Index, Mesh, Topology
from . import normals, refusal, unit

if TYPE_CHECKING:
    from numpy.typing import ArrayLike, NDArray

SIGNED_DISTANCE_TYPE_PSEUDONORMAL = 0
SIGNED_DISTANCE_TYPE_WINDING_NUMBER = 1
SIGNED_DISTANCE_TYPE_DEFAULT = 2
SIGNED_DISTANCE_TYPE_UNSIGNED = 3
SIGNED_DISTANCE_TYPE_FAST_WINDING_NUMBER = 4


def point_mesh_squared_distance(P: ArrayLike, V: ArrayLike, F: ArrayLike) -> tuple[NDArray[Any], NDArray[Any], NDArray[Any]]:
    """Squared distances (n,), triangles (n,) and closest points (n, 3) of points P (n, 3) and the mesh of V and F.

    One point of shape (3,) is taken as (1, 3)."""
    points, lengths, ids = _arrays(P, F)
    closest = Index(Mesh(V, F)).closest(points, columns=("distance", "point", "triangle"))
    return (closest.distance ** 2).astype(lengths), closest.triangle.astype(ids), closest.point.astype(lengths)


def signed_distance(P: ArrayLike, V: ArrayLike, F: ArrayLike, sign_type: int = SIGNED_DISTANCE_TYPE_DEFAULT,
                    return_normals: bool = False) -> tuple[NDArray[Any], ...]:
    """Signed distances (n,), triangles (n,) and closest points (n, 3); with return_normals also pseudonormals (n, 3).

    Negative inside. SIGNED_DISTANCE_TYPE_PSEUDONORMAL takes the side of the pseudonormal, and so does the default with
    return_normals, as in libigl: where the mesh runs clockwise, it is positive inside and negative outside. The other types
    take the sign of 1 - 2w, w the winding number, which libigl multiplies the distance by: a clockwise mesh has no inside.
    SIGNED_DISTANCE_TYPE_UNSIGNED gives distances."""
    if sign_type not in range(5):
        raise refusal("sign_type: must be one of SIGNED_DISTANCE_TYPE_...")
    if return_normals and sign_type not in (SIGNED_DISTANCE_TYPE_PSEUDONORMAL, SIGNED_DISTANCE_TYPE_DEFAULT):
        raise refusal("return_normals: needs the sign type SIGNED_DISTANCE_TYPE_PSEUDONORMAL")
    points, lengths, ids = _arrays(P, F)
    mesh = Mesh(V, F)
    by_normals = return_normals or sign_type == SIGNED_DISTANCE_TYPE_PSEUDONORMAL
    by_winding = not by_normals and sign_type != SIGNED_DISTANCE_TYPE_UNSIGNED
    index = Index(mesh, signs=by_winding)
    closest = index.closest(points)
    distances = index.signed_distance(points) if by_winding else closest.distance
    if by_normals:
        normal = _pseudonormals(mesh, closest)
        distances = np.where(((points - closest.point) * normal).sum(axis=1) < 0, -distances, distances)
    answer = (distances.astype(lengths), closest.triangle.astype(ids), closest.point.astype(lengths))
    return (*answer, normal.astype(lengths)) if return_normals else answer


def _arrays(P: ArrayLike, F: ArrayLike) -> tuple[NDArray[Any], Any, Any]:
    """P as rows, and the dtypes of answers."""
    points, faces = np.asanyarray(P), np.asanyarray(F)
    lengths = np.float32 if points.dtype == np.float32 else np.float64
    ids = np.int32 if faces.dtype == np.int32 else np.int64  # smaller ones may not hold a triangle's id
    return points.reshape(1, 3) if points.shape == (3,) else points, lengths, ids


def _pseudonormals(mesh: Mesh, closest: Closest) -> NDArray[np.float64]:
    """Of length 1: a face's normal, the sum of those at an edge, and those at a vertex by their angles."""
    around = Topology(mesh).patch(closest, rings=0)
    query = np.repeat(np.arange(len(closest.feature)), np.diff(around.first))
    faces = mesh.faces[around.triangle]
    corners = mesh.vertices[faces]
    corner = np.argmax(faces == closest.feature[query, None], axis=1)
    at, left, right = (corners[np.arange(len(faces)), (corner + k) % 3] for k in range(3))
    angle = np.arccos(np.clip((unit(left - at) * unit(right - at)).sum(axis=1), -1, 1))
    weight = np.where(closest.feature_kind[query] == 0, angle, 1.0)
    total = np.zeros((len(closest.feature), 3))
    np.add.at(total, query, weight[:, None] * normals(corners))
    return unit(total)
