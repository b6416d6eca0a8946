import gc
import os
import pickle
import tempfile
import warnings

import numpy as np
import pytest

import oracles
import proxima


def boxes_meet(mesh, lower, upper):
    """(n, F): whether boxes of triangles and leaves have a common point."""
    corners = oracles.corners(mesh)
    return ((corners.min(1) <= upper[:, None]) & (corners.max(1) >= lower[:, None])).all(axis=2)


def test_leaves(mesh):
    octree = proxima.Octree(mesh, max_depth=4, threshold=3)
    leaves = octree.leaves()
    assert np.prod(leaves.upper - leaves.lower, axis=1).sum() == pytest.approx(
        (leaves.upper.max(0) - leaves.lower.min(0)).prod())
    assert np.array_equal(np.diff(leaves.first) > 0, leaves.kind == 2)
    leaf = np.repeat(np.arange(len(leaves.kind)), np.diff(leaves.first))
    assert boxes_meet(mesh, leaves.lower, leaves.upper)[leaf, leaves.triangle].all()
    assert set(leaves.triangle) == set(range(len(mesh.faces)))
    centres = (leaves.lower + leaves.upper) / 2
    inside = oracles.winding_numbers(mesh, centres) > 0.5
    empty = leaves.kind != 2
    assert np.array_equal(leaves.kind[empty] == 1, inside[empty]) and (leaves.kind == 1).any()
    assert (leaves.key >> (3 * leaves.depth.astype("u8")) == 1).all()


def test_statistics_count_the_leaves(mesh):
    octree = proxima.Octree(mesh, max_depth=4, threshold=3, root="box")
    leaves, counts = octree.leaves(), octree.statistics
    assert counts["leaves"] == len(leaves.kind) and counts["references"] == len(leaves.triangle)
    assert counts["boundary"] == (leaves.kind == 2).sum() and counts["inner"] == (leaves.kind == 1).sum()
    assert counts["depth_reached"] == leaves.depth.max() and f"{len(leaves.kind)} leaves" in repr(octree)
    assert counts["outer"] == (leaves.kind == 0).sum() and counts["unclassified"] == 0
    lists = np.diff(leaves.first)
    occupied = lists[lists > 0]
    assert (counts["min_triangles"], counts["max_triangles"]) == (occupied.min(), occupied.max())
    assert counts["occupied_leaves"] == len(occupied) and counts["occupied_percent"] == pytest.approx(100 * len(occupied) / len(lists))
    for name, lengths in (("triangles", occupied), ("all_leaves", lists)):
        assert counts[f"mean_{name}"] == pytest.approx(lengths.mean()) and counts[f"std_{name}"] == pytest.approx(lengths.std()), name
    cells = {key >> 3 * up for key, depth in zip(leaves.key.tolist(), leaves.depth.tolist()) for up in range(depth + 1)}
    assert counts["total"] == len(cells)
    assert counts["bytes"] == 8 * (len(cells) - (lists == 0).sum()) + 4 * len(leaves.triangle)  # empty leaves take none
    plain = proxima.Octree(mesh, uniform=True, max_depth=2, classify=False, threads=1)
    assert plain.statistics["leaves"] == 64 and (plain.leaves().kind >= 2).all()
    assert plain.statistics["unclassified"] == (plain.leaves().kind == 3).sum() > 0


def test_files(tmp_path, mesh):
    octree = proxima.Octree(mesh)
    octree.save(tmp_path / "a.pxo")
    other = proxima.Octree.load(tmp_path / "a.pxo")
    expected = octree.leaves()
    octree.export(mesh, tmp_path / "a.vtu")
    assert (tmp_path / "a.vtu").stat().st_size > 1000
    del octree
    gc.collect()
    assert all(np.array_equal(a, b) for a, b in zip(other.leaves(), expected))
    with pytest.raises(proxima.FileMissing):
        proxima.Octree.load(tmp_path / "none.pxo")


def test_pickles(mesh):
    octree = proxima.Octree(mesh, max_depth=4)
    other = pickle.loads(pickle.dumps(octree))
    assert all(np.array_equal(a, b) for a, b in zip(other.leaves(), octree.leaves()))
    assert other.statistics == octree.statistics and pickle.dumps(other) == pickle.dumps(octree)
    for protocol in range(pickle.HIGHEST_PROTOCOL + 1):
        assert pickle.loads(pickle.dumps(octree, protocol)).statistics == octree.statistics
    call, arguments, state = octree.__reduce_ex__(2)[:3]
    damaged = call(*arguments)
    with pytest.raises(proxima.InvalidInput, match="pickled octree"):
        damaged.__setstate__(state[:-40])


def test_refuses_wrong_options(mesh):
    for options, says in ((dict(max_depth=20), "19"), (dict(root="ball"), "root: "), (dict(threads=-2), "threads: ")):
        with pytest.raises(proxima.InvalidInput, match=says):
            proxima.Octree(mesh, **options)
    with pytest.raises(proxima.Cancelled):
        proxima.Octree(proxima.Mesh.sample("spaceship:100000"), max_depth=9, threads=1, progress=lambda *_: False)


def test_pickling_leaves_no_files(mesh, tmp_path, monkeypatch):
    class Folder(tempfile.TemporaryDirectory):
        """One in which the file cannot be written."""

        def __init__(self):
            super().__init__(dir=tmp_path)
            os.mkdir(os.path.join(self.name, "pickled"))

    octree = proxima.Octree(mesh)
    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path))
    pickle.dumps(octree)
    monkeypatch.setattr(tempfile, "TemporaryDirectory", Folder)
    with warnings.catch_warnings(record=True) as warned:  # a folder that only its finaliser removes warns
        warnings.simplefilter("always")
        with pytest.raises(proxima.Error):
            pickle.dumps(octree)
    assert not os.listdir(tmp_path) and not warned


def test_a_root_of_one_s_own(mesh):
    leaves = proxima.Octree(mesh, root=[[-4, -4, -4], [4, 4, 4]], max_depth=5).leaves()
    assert np.array_equal(leaves.lower.min(0), [-4] * 3) and np.array_equal(leaves.upper.max(0), [4] * 3)
    assert np.array_equal(leaves.upper - leaves.lower, np.repeat(8 / 2.0 ** leaves.depth, 3).reshape(-1, 3))
    for root, says in (([[0, 0, 0]], "root: must be"), ([[0, 0, 0], [9, 9, 9]], "root"), (np.eye(2), "root: must have shape")):
        with pytest.raises(proxima.InvalidInput, match=says):
            proxima.Octree(mesh, root=root)


@pytest.mark.parametrize("exact", [False, True])
def test_visible_leaves(mesh, exact):
    octree = proxima.Octree(mesh, max_depth=5, uniform=True)
    leaves = octree.leaves()
    planes = np.array([[0.2, -1, 0, 0.03 - 0.2], [0.2, 1, 0, -0.03 - 0.2]])  # a wedge that opens along x from x = 1
    highest = np.where(planes[:, None, :3] > 0, leaves.upper, leaves.lower)
    seen = ((highest * planes[:, None, :3]).sum(axis=2) + planes[:, 3:] >= 0).all(axis=0)
    behind = leaves.upper[:, 0] < 1
    assert (seen & behind).any() and (seen & ~behind).any()
    assert np.array_equal(octree.visible(planes, exact=exact), np.flatnonzero(seen & ~behind if exact else seen))
    all_planes = proxima.perspective((0, -5, 0), (0, 1, 0), (0, 0, 1))
    assert len(octree.visible(all_planes, exact=exact)) == len(leaves.kind)


def test_leaves_along_rays(mesh):
    octree = proxima.Octree(mesh, max_depth=4)
    leaves = octree.leaves()
    random = np.random.default_rng(3)
    origins, directions = random.uniform(-1, 1, (40, 3)), random.normal(size=(40, 3))
    found = octree.along_rays(origins, directions)
    ends = np.sort([(leaves.lower - origins[:, None]) / directions[:, None], (leaves.upper - origins[:, None]) / directions[:, None]],
                   axis=0)
    enter, exit = np.maximum(ends[0].max(axis=2), 0), ends[1].min(axis=2)
    assert len(found.leaf) > 100
    for i in range(len(origins)):
        rows = slice(found.first[i], found.first[i + 1])
        assert set(found.leaf[rows]) == set(np.flatnonzero(enter[i] < exit[i]))
        assert np.allclose(found.enter[rows], enter[i, found.leaf[rows]]) and np.allclose(found.exit[rows], exit[i, found.leaf[rows]])
        assert np.array_equal(found.enter[rows][1:], found.exit[rows][:-1])
    ray = np.repeat(np.arange(len(origins)), np.diff(found.first))
    assert np.allclose(found.chord, (found.exit - found.enter) * np.linalg.norm(directions, axis=1)[ray])
    assert (found.penetration >= 0).all() and (found.penetration <= 1).all()
    for ask, says in (((origins, directions[1:]), "directions: must be as many as origins, 40, are 39"),
                      ((origins[:2], [[1, 0, 0], [0, 0, 0]]), "ray 1 is not finite or has no direction")):
        with pytest.raises(proxima.InvalidInput, match=says):
            octree.along_rays(*ask)
    with pytest.raises(proxima.InvalidInput, match="origins: ray 0 is so far from the octree"):
        proxima.Octree(mesh, root=[[-1e308] * 3, [1e307] * 3]).along_rays([[1e308, 0, 0]], [[-1, 0, 0]])
