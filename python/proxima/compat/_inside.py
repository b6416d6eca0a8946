"""Inside and outside by the parity of closed parts, as libraries have it that count the crossings of a ray."""
from __future__ import annotations

from typing import Any, Sequence

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .. import Index, Mesh, Topology
from . import welded


class Inside:
    """Signed distances of meshes: inside is what an odd number of their parts encloses.

    A part is what triangles connect across edges, after vertices at one position were joined. Triangles are turned to match
    their neighbours, and parts that then run clockwise are turned, too. Whether a part encloses a point its winding number
    tells. Parts that are open, or have edges of three or more triangles, count as one part for each mesh."""

    def __init__(self, whole: Index, meshes: Sequence[Mesh], threads: int = 0) -> None:
        """`whole` is the index of all meshes: their triangles in this order."""
        self._whole = whole
        begins = np.cumsum([0] + [len(mesh.vertices) for mesh in meshes])
        faces = np.concatenate([mesh.faces + begin for mesh, begin in zip(meshes, begins)])
        vertices = np.concatenate([mesh.vertices for mesh in meshes])
        part, turned = np.zeros(len(faces), np.int64), np.zeros(len(faces), bool)
        is_open = np.zeros(0, bool)
        at = 0
        for mesh in meshes:
            own, own_open, turned[at:at + len(own)] = _parts(mesh)
            part[at:at + len(own)] = own + len(is_open)
            is_open = np.concatenate((is_open, own_open))
            at += len(own)
        faces[turned] = faces[turned, ::-1]
        group, clockwise = _groups(vertices[faces], part, is_open)
        if not (turned ^ clockwise).any() and not group.any():
            self._indexes = [whole.with_signs(threads=threads)]
            return
        faces[clockwise] = faces[clockwise, ::-1]
        self._indexes = [Index(Mesh(vertices, faces[group == number]), signs=True, threads=threads)
                         for number in range(group.max() + 1)]

    def signed_distance(self, points: ArrayLike, threads: int = 0) -> NDArray[np.float64]:
        """(n,) distances of points (n, 3), negative inside."""
        if len(self._indexes) == 1:
            return self._indexes[0].signed_distance(points, threads=threads)
        distance = self._whole.closest(points, columns=("distance",), threads=threads).distance
        inside = np.zeros(len(distance), bool)
        for index in self._indexes:
            inside ^= index.signed_distance(points, threads=threads) < 0
        return np.where(inside, -distance, distance)


def _parts(mesh: Mesh) -> tuple[NDArray[np.int64], NDArray[np.bool_], NDArray[np.bool_]]:
    """The part of each triangle (F,), whether each part is open, and whether each triangle (F,) must be turned."""
    faces = np.asarray(welded(mesh).faces, np.int64)
    turned = np.zeros(len(faces), bool)
    if not len(faces):
        return np.zeros(0, np.int64), np.zeros(0, bool), turned
    # A triangle that has a vertex twice joins its two neighbours: without it they are each other's.
    sound = np.flatnonzero((faces != np.roll(faces, 1, axis=1)).all(axis=1))
    surface = Mesh(np.zeros((faces.max() + 1, 3)), faces[sound])
    turned[sound] = surface.repair(weld=False, drop_duplicates=False, turn_outward=False).turned
    neighbours = Topology(surface).neighbours
    label = _connected(neighbours)
    open_labels = np.zeros(len(sound), bool)
    open_labels[label[(neighbours < 0).any(axis=1)]] = True
    joined = np.full(len(faces), -1)
    joined[sound] = np.where(open_labels[label], -1, label)
    labels, part = np.unique(joined, return_inverse=True)
    return part.reshape(-1), labels < 0, turned


def _connected(neighbours: NDArray[np.int32]) -> NDArray[np.int64]:
    """The lowest triangle of those that each triangle is connected with."""
    label = np.arange(len(neighbours))
    across = np.where(neighbours < 0, label[:, None], neighbours)
    while True:
        lowest = label[across].min(axis=1, initial=len(label))
        lower = np.flatnonzero(lowest < label)
        if not len(lower):
            return label
        np.minimum.at(label, label[lower], lowest[lower])
        while (label[label] != label).any():
            label = label[label]


def _groups(corners: NDArray[np.float64], part: NDArray[np.int64],
            is_open: NDArray[np.bool_]) -> tuple[NDArray[np.int64], NDArray[np.bool_]]:
    """The group of each triangle (F,), within which no boxes of parts overlap, and whether its part runs clockwise."""
    order = np.argsort(part, kind="stable")
    first = np.searchsorted(part[order], np.arange(len(is_open)))
    lower = np.minimum.reduceat(corners.min(axis=1)[order], first)
    upper = np.maximum.reduceat(corners.max(axis=1)[order], first)
    size = np.where(upper > lower, upper - lower, 1.0)  # of a part along each axis: it becomes 1, and volumes are numbers
    a, b, c = np.moveaxis((corners - lower[part][:, None]) / size[part][:, None], 1, 0)
    clockwise = np.bincount(part, np.einsum("ij,ij->i", a, np.cross(b, c))) < 0
    # The winding number of an open part reaches beyond its box.
    lower[is_open], upper[is_open] = -np.inf, np.inf
    group = np.zeros(len(is_open), np.int64)
    before = np.zeros(0, np.int64)
    for number in np.argsort(lower[:, 0], kind="stable"):
        before = before[upper[before, 0] >= lower[number, 0]]
        meeting = ((lower[before] <= upper[number]) & (upper[before] >= lower[number])).all(axis=1)
        taken: set[Any] = set(group[before[meeting]])
        group[number] = next(free for free in range(len(taken) + 1) if free not in taken)
        before = np.append(before, number)
    return group[part], clockwise[part]
