"""Open3D's RaycastingScene.

    from proxima.compat.open3d import RaycastingScene

    scene = RaycastingScene()
    scene.add_triangles(mesh)                        # an open3d.t.geometry.TriangleMesh, or vertices and triangles
    answer = scene.cast_rays(rays)                   # t_hit, geometry_ids, primitive_ids, primitive_uvs, primitive_normals
    distance = scene.compute_signed_distance(points)

As in Open3D, answers are float32 and uint32 in the shape of the queries, misses have t_hit inf and INVALID_ID, and
distances are negative inside. Open3D's tensors are answered by such tensors, all else by arrays; float64 in is not rounded
before it is used. As in Open3D, inside is what an odd number of closed surfaces encloses, clockwise or not: a body in a
body is a cavity, in one geometry or two. Unlike there, the winding number of each connected part tells whether it encloses
a point, not a ray, which may run along an edge. Open parts count together, and a part that overlaps itself is inside there
too. NaN, rays whose direction is zero, and scenes without triangles are errors. A hit on an edge counts for each of its
triangles. nsamples, an argument of later versions of Open3D, is not taken.
"""
from __future__ import annotations

from typing import TYPE_CHECKING, Any, Callable, Optional, overload

import numpy as np

from .. import Closest, Index, Mesh
from . import mesh_of, normals, refusal
from ._inside import Inside

if TYPE_CHECKING:
    from numpy.typing import NDArray

_MESHES = "an open3d.t.geometry.TriangleMesh, a mesh with vertices and faces, or vertices and triangles"
_LEGACY = " (of a legacy mesh: open3d.t.geometry.TriangleMesh.from_legacy(mesh))"


class RaycastingScene:
    """Rays and closest points of one or several meshes: open3d.t.geometry.RaycastingScene."""

    INVALID_ID = 0xFFFFFFFF

    def __init__(self, nthreads: int = 0) -> None:
        self._threads = nthreads
        self._vertices: list[NDArray[np.float64]] = []
        self._faces: list[NDArray[np.int64]] = []
        self._built: Optional[Index] = None
        self._inside: Optional[Inside] = None

    def add_triangles(self, mesh: Any = None, triangle_indices: Any = None, *, vertex_positions: Any = None) -> int:
        """Adds a mesh, or vertex_positions (N, 3) and triangle_indices (M, 3). Returns the geometry's id: 0, 1, 2 and so on."""
        positions = mesh if vertex_positions is None else vertex_positions
        if triangle_indices is not None:
            own = Mesh(_array(positions), _array(triangle_indices))
        elif vertex_positions is None and hasattr(mesh, "triangle"):
            own = Mesh(_array(mesh.vertex["positions"]), _array(mesh.triangle["indices"]))
        else:
            own = mesh_of(mesh, _MESHES + (_LEGACY if hasattr(mesh, "triangles") else ""))
        self._vertices.append(np.asarray(own.vertices))
        self._faces.append(np.asarray(own.faces, np.int64))
        self._built = self._inside = None
        return len(self._faces) - 1

    @overload
    @staticmethod
    def create_rays_pinhole(intrinsic_matrix: Any, extrinsic_matrix: Any, width_px: int, height_px: int) -> Any: ...
    @overload
    @staticmethod
    def create_rays_pinhole(fov_deg: float, center: Any, eye: Any, up: Any, width_px: int, height_px: int) -> Any: ...
    @staticmethod
    def create_rays_pinhole(*args: Any, **kwargs: Any) -> Any:
        """Rays {height_px, width_px, 6} float32 through the middles of a camera's pixels.

        Of an intrinsic matrix (3, 3), upper triangular, and an extrinsic one (4, 4), from the world to the camera; or of the
        horizontal angle of view, the point that is looked at, the camera's and the direction up. As in Open3D, up points
        down the picture: the first row is the lowest."""
        return _rays_of_matrices(*args, **kwargs) if len(args) + len(kwargs) <= 4 else _rays_of_view(*args, **kwargs)

    def cast_rays(self, rays: Any, nthreads: int = 0) -> dict[str, Any]:
        """The first hits of rays {.., 6}: ox, oy, oz, dx, dy, dz."""
        shape, origins, directions = _rays(rays)
        hits = self._index().cast(origins, directions, threads=nthreads)
        return self._answer(_like(rays, shape), hits, t_hit=hits.t)

    def test_occlusions(self, rays: Any, tnear: float = 0.0, tfar: float = float("inf"), nthreads: int = 0) -> Any:
        """{..} bool: whether rays hit between tnear and tfar."""
        shape, origins, directions = _rays(rays)
        if tfar < tnear:
            return _like(rays, shape)(np.zeros(len(origins), bool))
        hit = self._index().cast(origins, directions, t_min=tnear, t_max=tfar, hits="any", threads=nthreads)
        return _like(rays, shape)(hit)

    def count_intersections(self, rays: Any, nthreads: int = 0) -> Any:
        """{..} int32: how many triangles rays hit."""
        shape, origins, directions = _rays(rays)
        lists = self._index().cast(origins, directions, hits="all", threads=nthreads)
        return _like(rays, shape)(np.diff(lists.first).astype(np.int32))

    def compute_closest_points(self, query_points: Any, nthreads: int = 0) -> dict[str, Any]:
        """The closest points of points {.., 3}: points, geometry_ids, primitive_ids, primitive_uvs, primitive_normals."""
        shape, points = _rows(query_points, 3, "query_points")
        closest = self._index().closest(points, columns=("point", "triangle", "barycentric"), threads=nthreads)
        return self._answer(_like(query_points, shape), closest, points=closest.point)

    def compute_distance(self, query_points: Any, nthreads: int = 0) -> Any:
        """{..} float32: distances of points {.., 3}."""
        shape, points = _rows(query_points, 3, "query_points")
        closest = self._index().closest(points, columns=("distance",), threads=nthreads)
        return _like(query_points, shape)(closest.distance.astype(np.float32))

    def compute_signed_distance(self, query_points: Any, nthreads: int = 0) -> Any:
        """{..} float32: distances of points {.., 3}, negative inside."""
        shape, points = _rows(query_points, 3, "query_points")
        return _like(query_points, shape)(self._signs().signed_distance(points, nthreads).astype(np.float32))

    def compute_occupancy(self, query_points: Any, nthreads: int = 0) -> Any:
        """{..} float32: 1 where points {.., 3} are inside, else 0."""
        shape, points = _rows(query_points, 3, "query_points")
        inside = self._signs().signed_distance(points, nthreads) < 0
        return _like(query_points, shape)(inside.astype(np.float32))

    def _index(self) -> Index:
        if self._built is None:
            if not any(map(len, self._faces)):
                raise refusal("the scene has no triangles: call add_triangles() first")
            begins = np.cumsum([0] + [len(vertices) for vertices in self._vertices])
            faces = np.concatenate([own + begin for own, begin in zip(self._faces, begins)])
            self._built = Index(Mesh(np.concatenate(self._vertices), faces), threads=self._threads)
        return self._built

    def _signs(self) -> Inside:
        if self._inside is None:
            self._inside = Inside(self._index(), [Mesh(*own) for own in zip(self._vertices, self._faces)], self._threads)
        return self._inside

    def _answer(self, like: Callable[[NDArray[Any]], Any], found: Any, **first: NDArray[np.float64]) -> dict[str, Any]:
        """The dictionary of an answer: ids within each geometry, u and v, and normals of length 1."""
        triangle = found.triangle.astype(np.int64)
        hit = triangle >= 0
        begins = np.cumsum([0] + [len(faces) for faces in self._faces])
        geometry = np.searchsorted(begins, triangle, side="right") - 1
        columns = found.barycentric[:, 1:] if isinstance(found, Closest) else np.column_stack((found.u, found.v))
        corners = np.empty((len(triangle), 3, 3))
        for number, (vertices, faces) in enumerate(zip(self._vertices, self._faces)):
            own = hit & (geometry == number)
            corners[own] = vertices[faces[triangle[own] - begins[number]]]
        corners[~hit] = 0
        answer = {name: like(column.astype(np.float32)) for name, column in first.items()}
        answer["geometry_ids"] = like(np.where(hit, geometry, self.INVALID_ID).astype(np.uint32))
        answer["primitive_ids"] = like(np.where(hit, triangle - begins[geometry], self.INVALID_ID).astype(np.uint32))
        answer["primitive_uvs"] = like(np.where(hit[:, None], columns, 0).astype(np.float32))
        answer["primitive_normals"] = like(normals(corners).astype(np.float32))
        return answer


def _array(given: Any) -> NDArray[Any]:
    """The array of a tensor or of what NumPy takes; a masked one stays masked, which is refused."""
    return np.asanyarray(given.numpy() if hasattr(given, "numpy") else given)


def _rows(given: Any, columns: int, name: str) -> tuple[tuple[int, ...], NDArray[Any]]:
    """The shape before the last dimension, and all as rows."""
    array = _array(given)
    if array.ndim < 2 or array.shape[-1] != columns:
        raise refusal(f"{name}: must have shape (.., {columns}), has {array.shape}")
    return array.shape[:-1], array.reshape(-1, columns)


def _rays(rays: Any) -> tuple[tuple[int, ...], NDArray[Any], NDArray[Any]]:
    shape, rows = _rows(rays, 6, "rays")
    return shape, rows[:, :3], rows[:, 3:]


def _like(given: Any, shape: tuple[int, ...]) -> Callable[[NDArray[Any]], Any]:
    """Makes rows the answer to `given`: in its shape, a tensor if it is one of Open3D."""
    def answer(rows: NDArray[Any]) -> Any:
        array = rows.reshape(shape + rows.shape[1:])
        return type(given).from_numpy(array) if hasattr(type(given), "from_numpy") else array
    return answer


def _rays_of_matrices(intrinsic_matrix: Any, extrinsic_matrix: Any, width_px: int, height_px: int) -> Any:
    intrinsic = _float64(intrinsic_matrix, (3, 3), "intrinsic_matrix")
    extrinsic = _float64(extrinsic_matrix, (4, 4), "extrinsic_matrix")
    if np.linalg.det(intrinsic) == 0:
        raise refusal("intrinsic_matrix: must have an inverse")
    back = extrinsic[:3, :3].T  # from the camera to the world
    x, y = np.meshgrid(np.arange(width_px) + 0.5, np.arange(height_px) + 0.5)
    directions = np.stack((x, y, np.ones_like(x)), axis=-1) @ (back @ np.linalg.inv(intrinsic)).T
    origins = np.broadcast_to(-back @ extrinsic[:3, 3], directions.shape)
    rays = np.concatenate((origins, directions), axis=-1).astype(np.float32)
    return _like(intrinsic_matrix, rays.shape[:-1])(rays.reshape(-1, 6))


def _rays_of_view(fov_deg: float, center: Any, eye: Any, up: Any, width_px: int, height_px: int) -> Any:
    at = _float64(eye, (3,), "eye")
    forward, upwards = _float64(center, (3,), "center") - at, _float64(up, (3,), "up")
    sideways = np.cross(upwards, forward)
    if not sideways.any() or not 0 < fov_deg < 180:
        raise refusal("center: must not be at eye, nor up from it; fov_deg must be between 0 and 180")
    rows = np.stack((sideways, np.cross(forward, sideways), forward))
    rows /= np.linalg.norm(rows, axis=1, keepdims=True)
    extrinsic = np.eye(4)
    extrinsic[:3] = np.column_stack((rows, -rows @ at))
    focal = width_px / 2 / np.tan(np.radians(fov_deg) / 2)
    rays = _rays_of_matrices([[focal, 0, width_px / 2], [0, focal, height_px / 2], [0, 0, 1]], extrinsic, width_px, height_px)
    return _like(center, rays.shape[:-1])(rays.reshape(-1, 6))


def _float64(given: Any, shape: tuple[int, ...], name: str) -> NDArray[np.float64]:
    array = _array(given)
    if array.shape != shape or array.dtype.kind not in "fiu" or not np.isfinite(array).all():
        raise refusal(f"{name}: must be finite numbers of shape {shape}, has shape {array.shape}")
    return array.astype(np.float64)
