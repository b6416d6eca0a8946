import copy
import gc
import pickle

import numpy as np
import pytest

import proxima


def edges_of(faces):
    """The edges by first appearance, as sorted pairs."""
    seen = {}
    for a, b, c in faces:
        for edge in ((a, b), (b, c), (c, a)):
            if edge[0] != edge[1]:
                seen.setdefault(tuple(sorted(edge)), len(seen))
    return np.array(list(seen), "i8").reshape(-1, 2)


def rings_of(faces, begin, rings):
    """Triangles with their rings, by a search over all triangles."""
    found = {triangle: 0 for triangle in begin}
    for ring in range(1, rings + 1):
        vertices = set(faces[list(found)].ravel())
        for triangle in range(len(faces)):
            if triangle not in found and vertices & set(faces[triangle]):
                found[triangle] = ring
    return sorted(found.items(), key=lambda item: (item[1], item[0]))


OPEN = proxima.Mesh(np.random.default_rng(3).normal(size=(7, 3)),  # three triangles at an edge, a boundary, a twice used corner
                    [[0, 1, 2], [1, 0, 3], [0, 1, 4], [2, 3, 5], [6, 6, 5]])
MESHES = [proxima.Mesh.sample("torus:24x12"), proxima.Mesh.sample("sphere:6x8"), OPEN]


@pytest.mark.parametrize("mesh", MESHES, ids=["torus", "sphere", "open"])
def test_edges_and_neighbours(mesh):
    faces = np.asarray(mesh.faces, "i8")
    topology = proxima.Topology(mesh)
    edges = edges_of(faces)
    assert topology.edges.dtype == np.int32 and np.array_equal(topology.edges, edges)
    assert f"{len(edges)} edges" in repr(topology)
    for triangle, around in enumerate(topology.neighbours):
        for side, neighbour in enumerate(around):
            edge = {faces[triangle][side], faces[triangle][(side + 1) % 3]}
            others = [t for t in range(len(faces)) if t != triangle and edge <= set(faces[t])]
            assert neighbour == (others[0] if len(edge) == 2 and len(others) == 1 else -1)


@pytest.mark.parametrize("mesh", MESHES, ids=["torus", "sphere", "open"])
@pytest.mark.parametrize("rings", [0, 1, 3])
def test_patches(mesh, rings):
    faces = np.asarray(mesh.faces, "i8")
    topology = proxima.Topology(mesh)
    closest = proxima.Index(mesh).closest(np.random.default_rng(5).uniform(-2, 2, (40, 3)), columns=("feature_kind", "feature"))
    patches = topology.patch(closest, rings)
    assert patches.first[0] == 0 and patches.first[-1] == len(patches.triangle) == len(patches.ring)
    for i, (kind, feature) in enumerate(zip(closest.feature_kind, closest.feature)):
        corners = [{feature}, set(topology.edges[feature]) if kind == 1 else None, None][kind]
        begin = [feature] if kind == 2 else [t for t in range(len(faces)) if corners <= set(faces[t])]
        rows = slice(patches.first[i], patches.first[i + 1])
        assert list(zip(patches.triangle[rows], patches.ring[rows])) == rings_of(faces, begin, rings)


def test_a_patch_can_be_the_whole_mesh(mesh, index):
    topology = proxima.Topology(mesh, threads=1)
    one = index.closest_one(3, 0.1, 0.2)
    patch = topology.patch(one, rings=10**6)
    assert sorted(patch.triangle) == list(range(len(mesh.faces))) and len(patch.first) == 2
    large = proxima.Mesh.sample("torus:100x50")  # more triangles than the search begins with room for
    assert len(proxima.Topology(large).patch(proxima.Index(large).closest_one(3, 0, 0), 200).triangle) == 10_000


def test_topology_keeps_its_mesh_and_can_be_copied(points):
    mesh = proxima.Mesh.sample("torus:24x12")
    closest = proxima.Index(mesh).closest(points)
    topology = proxima.Topology(mesh)
    expected = topology.patch(closest, 2)
    del mesh
    gc.collect()
    for other in (topology, copy.deepcopy(topology), pickle.loads(pickle.dumps(topology))):
        assert all(np.array_equal(a, b) for a, b in zip(other.patch(closest, 2), expected))


def test_refuses_features_of_other_meshes(mesh, index, points):
    topology = proxima.Topology(proxima.Mesh.sample("cube"))
    with pytest.raises(proxima.InvalidInput, match=r"closest.feature: row \d+ must be below"):
        topology.patch(index.closest(points))
    closest = index.closest(points)
    for wrong, says in ((closest._replace(feature=closest.feature - 10**6), "must be below"),
                        (closest._replace(feature_kind=closest.feature_kind + np.uint8(3)), "must be 0, 1 or 2, is"),
                        (closest._replace(feature=closest.feature[:3]), "different lengths"),
                        (closest._replace(feature=None), "must be integers"),
                        (closest._replace(feature=closest.distance), "must be integers")):
        with pytest.raises(proxima.InvalidInput, match=says):
            proxima.Topology(mesh).patch(wrong)
    with pytest.raises(proxima.InvalidInput, match="rings: "):
        topology.patch(index.closest(points), -1)
    for wrong, kind in ((None, "NoneType"), ("x", "str")):
        with pytest.raises(TypeError, match=f"mesh: must be a proxima.Mesh, is a {kind}"):
            proxima.Topology(wrong)
        with pytest.raises(TypeError, match=f"closest: must be a proxima.Closest or ClosestOne, is a {kind}"):
            topology.patch(wrong)
    with pytest.raises(proxima.Cancelled):
        large = proxima.Mesh.sample("torus:400x200")
        proxima.Topology(large).patch(proxima.Index(large).closest(np.tile(points, (300, 1))), 20, progress=lambda *_: False)
