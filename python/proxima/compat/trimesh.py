"""trimesh's queries of a mesh: ProximityQuery (`mesh.nearest`) and RayMeshIntersector (`mesh.ray`).

    from proxima.compat.trimesh import ProximityQuery, RayMeshIntersector

    nearest = ProximityQuery(mesh)                   # a trimesh.Trimesh, or anything with vertices and faces
    closest, distance, triangle = nearest.on_surface(points)
    ray = RayMeshIntersector(mesh)
    locations, index_ray, index_tri = ray.intersects_location(origins, directions)

As in trimesh, distances are positive inside and ids are int64. Triangles that share the closest vertex or edge, or all three
corners, are told apart by which of them faces the query, also where they have corners of their own at the same positions.
Unlike there, hits come in the order of the rays and along them, a direction that is zero is an error, and objects answer
for the mesh as it was when they were made. Inside is what an odd number of connected parts encloses, as the rays of
trimesh's contains_points have it, but told by winding numbers, for which triangles are turned to match their neighbours.
Pieces that meet at an edge of three or more triangles must face alike, and a part with one side, as a Klein bottle, has no
inside to speak of. signed_distance has the same inside, also where a mesh runs clockwise or has bodies in bodies: trimesh
takes the side of the closest triangle there, and its signs contradict its contains_points.
"""
from __future__ import annotations

from typing import TYPE_CHECKING, Any, Optional

import numpy as np

from .. import Closest, Index, Mesh, Topology
from . import mesh_of, normals, welded
from ._inside import Inside

if TYPE_CHECKING:
    from numpy.typing import ArrayLike, NDArray

MERGE = 1e-8  # trimesh.tol.merge: what is nearer is the same point


class ProximityQuery:
    """What is closest to points: trimesh.proximity.ProximityQuery."""

    def __init__(self, mesh: Any) -> None:
        self._mesh = mesh_of(mesh)
        self._welded = welded(self._mesh)
        self._index = Index(self._welded)
        self._inside: Optional[Inside] = None
        self._vertices: Optional[Index] = None
        self._topology: Optional[Topology] = None
        self._backs: Optional[NDArray[np.int64]] = None

    def on_surface(self, points: ArrayLike) -> tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.int64]]:
        """Closest points (m, 3), distances (m,) and triangles (m,) of points (m, 3)."""
        closest = self._index.closest(points)
        points = np.asarray(points, np.float64)
        triangle = closest.triangle.astype(np.int64)
        shared = np.flatnonzero((closest.feature_kind < 2) & (closest.distance > MERGE))
        if len(shared):
            if self._topology is None:
                self._topology = Topology(self._welded)
            several = self._topology.patch(Closest(*(np.asarray(column)[shared] for column in closest)), rings=0)
            towards = np.repeat(points[shared] - closest.point[shared], np.diff(several.first), axis=0)
            facing = self._facing(several.triangle, towards)
            best = np.maximum.reduceat(facing, several.first[:-1])
            is_best = np.flatnonzero(facing >= np.repeat(best, np.diff(several.first)))
            triangle[shared] = several.triangle[is_best[np.searchsorted(is_best, several.first[:-1])]]
        within = np.flatnonzero((closest.feature_kind == 2) & (closest.distance > MERGE))
        behind = within[self._facing(triangle[within], points[within] - closest.point[within]) < 0]
        if len(behind):
            if self._backs is None:
                self._backs = _backs(self._welded)
            back = self._backs[triangle[behind]]
            triangle[behind] = np.where(back < 0, triangle[behind], back)
        return closest.point, closest.distance, triangle

    def vertex(self, points: ArrayLike) -> tuple[NDArray[np.float64], NDArray[np.int64]]:
        """Distances (n,) and ids (n,) of the closest vertices, also of those without a triangle."""
        if self._vertices is None:
            ids = np.arange(len(self._mesh.vertices))
            self._vertices = Index(Mesh(self._mesh.vertices, np.column_stack((ids, ids, ids))))
        closest = self._vertices.closest(points, columns=("distance", "triangle"))
        return closest.distance, closest.triangle.astype(np.int64)

    def signed_distance(self, points: ArrayLike) -> NDArray[np.float64]:
        """Distances (n,), positive inside and within MERGE of the surface, negative outside."""
        if self._inside is None:
            self._inside = Inside(self._index, [self._welded])
        distance = -self._inside.signed_distance(points)
        near = np.abs(distance) <= MERGE
        distance[near] = np.abs(distance[near])
        return distance

    def _facing(self, triangles: NDArray[Any], towards: NDArray[np.float64]) -> NDArray[np.float64]:
        """How much each triangle faces a direction."""
        facing: NDArray[np.float64] = (normals(self._welded.vertices[self._welded.faces[triangles]]) * towards).sum(axis=1)
        return facing


class RayMeshIntersector:
    """What rays hit: trimesh.ray.ray_triangle.RayMeshIntersector."""

    def __init__(self, mesh: Any) -> None:
        self._mesh = mesh_of(mesh)
        self._index = Index(self._mesh)
        self._inside: Optional[Inside] = None

    def intersects_any(self, ray_origins: ArrayLike, ray_directions: ArrayLike, **_: Any) -> NDArray[np.bool_]:
        """(m,) bool: whether each ray hits."""
        return self._index.cast(ray_origins, ray_directions, hits="any")

    def intersects_first(self, ray_origins: ArrayLike, ray_directions: ArrayLike, **_: Any) -> NDArray[np.int64]:
        """(m,) the first triangle of each ray, -1 for none."""
        return self._index.cast(ray_origins, ray_directions).triangle.astype(np.int64)

    def intersects_id(self, ray_origins: ArrayLike, ray_directions: ArrayLike, return_locations: bool = False,
                      multiple_hits: bool = True, **_: Any) -> tuple[NDArray[Any], ...]:
        """Triangles (h,) and rays (h,) of all hits, or of the first of each ray; with return_locations also where, (h, 3).

        As in trimesh a hit on an edge counts for each of its triangles, and once where locations are returned."""
        if multiple_hits:
            lists = self._index.cast(ray_origins, ray_directions, hits="all")
            ray = np.repeat(np.arange(len(lists.first) - 1), np.diff(lists.first))
            t, triangle = lists.t, lists.triangle
        else:
            hits = self._index.cast(ray_origins, ray_directions)
            ray = np.flatnonzero(hits.hit)
            t, triangle = hits.t[ray], hits.triangle[ray]
        triangle = triangle.astype(np.int64)
        if not return_locations:
            return triangle, ray
        origins, directions = np.broadcast_arrays(np.asarray(ray_origins, np.float64), np.asarray(ray_directions, np.float64))
        places = origins[ray] + t[:, None] * directions[ray]
        again = (ray[1:] == ray[:-1]) & (np.abs(places[1:] - places[:-1]).max(axis=1, initial=0) <= MERGE)
        first = np.concatenate((np.ones(min(len(ray), 1), bool), ~again))
        return triangle[first], ray[first], places[first]

    def intersects_location(self, ray_origins: ArrayLike, ray_directions: ArrayLike, multiple_hits: bool = True,
                            **_: Any) -> tuple[NDArray[Any], ...]:
        """Places (h, 3), rays (h,) and triangles (h,) of hits; hits at one place count once."""
        triangle, ray, places = self.intersects_id(ray_origins, ray_directions, True, multiple_hits)
        return places, ray, triangle

    def contains_points(self, points: ArrayLike) -> NDArray[np.bool_]:
        """(n,) bool: whether points (n, 3) are inside."""
        if self._inside is None:
            self._inside = Inside(self._index, [self._mesh])
        return self._inside.signed_distance(points) < 0


def _backs(mesh: Mesh) -> NDArray[np.int64]:
    """(F,) the lowest triangle with the same corners that faces the other way, -1 for none."""
    corners = np.sort(mesh.faces, axis=1)
    order = np.lexsort(corners.T)
    begins = (corners[order[1:]] != corners[order[:-1]]).any(axis=1)
    number = np.empty(len(order), np.int64)  # of the corners
    number[order] = np.concatenate(([0], np.cumsum(begins)))
    way = ((mesh.faces < np.roll(mesh.faces, -1, axis=1)).sum(axis=1) == 2).astype(np.int64)
    lowest = np.full((len(order), 2), -1)
    lowest[number[::-1], way[::-1]] = np.arange(len(order))[::-1]
    backs: NDArray[np.int64] = lowest[number, 1 - way]
    return backs
