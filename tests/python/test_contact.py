"""Self-intersections, insides, contours and refits against NumPy alone, circles and new indexes."""
import pickle

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import oracles
import proxima


def at(*translation):
    return np.hstack([np.eye(3), np.array(translation, float)[:, None]])


def edges_through(a, b):
    """(F, G): whether an edge of a triangle of `a` passes through a triangle of `b`."""
    corners = oracles.corners(a)
    starts = corners.reshape(-1, 3)
    t = oracles.ray_hits(b, starts, np.roll(corners, -1, axis=1).reshape(-1, 3) - starts)
    return (t <= 1).reshape(len(a.faces), 3, -1).any(axis=1)


def union(*meshes):
    first = np.cumsum([0] + [len(mesh.vertices) for mesh in meshes])
    return proxima.Mesh(np.concatenate([mesh.vertices for mesh in meshes]),
                        np.concatenate([mesh.faces + start for mesh, start in zip(meshes, first)]))


@given(st.integers(0, 1000))
def test_self_intersections_of_triangles_at_random(seed):
    mesh = proxima.Mesh(np.random.default_rng(seed).uniform(-1, 1, (36, 3)), np.arange(36).reshape(-1, 3))
    through = edges_through(mesh, mesh)
    found = proxima.Index(mesh).self_intersections()
    assert list(zip(found.a, found.b)) == list(zip(*np.nonzero(np.triu(through | through.T, 1)))) and found.complete is True


def test_self_intersections_of_two_parts():
    cube, ball = proxima.Mesh.sample("cube"), proxima.Mesh.sample("icosphere:2")
    ball = proxima.Mesh(ball.vertices + [0.9, 0.1, 0.2], ball.faces)
    pairs = proxima.Index(cube).intersect(proxima.Index(ball))
    index = proxima.Index(union(cube, ball))
    found = index.self_intersections()
    assert len(pairs.a) and np.array_equal(found.a, pairs.a) and np.array_equal(found.b, pairs.b + len(cube.faces))
    some = index.self_intersections(max_pairs=3)
    assert some.complete is False and len(some.a) == 3
    assert len(proxima.Index(cube).self_intersections().a) == 0


def test_contour_of_two_balls_is_a_circle():
    mesh = proxima.Mesh.sample("icosphere:5")
    a, b = proxima.Index(mesh), proxima.Index(mesh)
    contour = a.contour(b, at(1, 0.01, 0.02))
    assert contour.closed.tolist() == [True] and contour.first.tolist() == [0, len(contour.point)]
    radius = np.sqrt(1 - np.linalg.norm([1, 0.01, 0.02]) ** 2 / 4)
    steps = np.linalg.norm(contour.point - np.roll(contour.point, 1, axis=0), axis=1)
    assert contour.length == pytest.approx(steps.sum(), rel=1e-12) == pytest.approx(2 * np.pi * radius, rel=2e-3)
    for index, points, kinds, ids in ((a, contour.point, contour.kind_a, contour.ids_a),
                                      (b, contour.point - [1, 0.01, 0.02], contour.kind_b, contour.ids_b)):
        assert np.abs(index.closest(points).distance).max() < 1e-15
        edge = kinds == 1
        p, q = mesh.vertices[ids[edge, 0]], mesh.vertices[ids[edge, 1]]
        assert edge.any() and np.abs(np.cross(points[edge] - p, q - p)).max() < 1e-15
        assert (ids[kinds == 2, 0] == ids[kinds == 2, 1]).all()
    assert len(a.contour(b, at(5, 0, 0)).closed) == 0 and a.contour(b, at(5, 0, 0)).length == 0


def test_contours_tell_their_progress_and_can_be_stopped():
    fine = proxima.Index(proxima.Mesh.sample("icosphere:6"))
    stages = []
    lines = fine.contour(fine, at(1e-3, 0, 0), progress=lambda stage, part: stages.append((stage, part)))
    assert lines.length > 0 and "finding the intersection contour" in {stage for stage, _ in stages}
    with pytest.raises(proxima.Cancelled):
        fine.contour(fine, at(1e-3, 0, 0), progress=lambda stage, part: False)


def test_contour_takes_one_pose(index):
    with pytest.raises(proxima.InvalidInput, match=r"pose: must be one pose, of shape \(3, 4\) or \(4, 4\)"):
        index.contour(index, np.tile(np.eye(4), (2, 1, 1)))


def test_containment(mesh, index):
    small = proxima.Index(proxima.Mesh(mesh.vertices * 0.05, mesh.faces))
    radius = np.linalg.norm(mesh.vertices, axis=1).mean()
    poses = np.stack([at(radius, 0, 0), at(0, 0, 0), at(9, 0, 0)])
    found = index.containment(small, poses)
    assert [proxima.CONTAINMENTS[which] for which in found.containment] == ["b_in_a", "none", "none"]
    assert {proxima.INSIDE_METHODS[method] for method in found.method} == {"crossings"}
    back = small.containment(index, at(-radius, 0, 0))
    assert proxima.CONTAINMENTS[back.containment] == "a_in_b" and not small.intersect(index, at(-radius, 0, 0), pairs=False)
    holed = proxima.Index(mesh.part(np.arange(5, len(mesh.faces))))
    assert proxima.INSIDE_METHODS[holed.containment(small, at(-radius, 0, 0)).method] == "winding_number"


@pytest.mark.parametrize("turned", [False, True])
def test_contains(mesh, points, turned):
    turned = proxima.Mesh(mesh.vertices, mesh.faces[:, ::-1] if turned else mesh.faces)
    inside = proxima.Index(turned).contains(points)
    assert inside.dtype == bool and np.array_equal(inside, np.abs(oracles.winding_numbers(mesh, points)) > 0.5)
    assert 0 < inside.sum() < len(points)


def test_contains_of_an_open_mesh(mesh, points):
    holed = mesh.part(np.arange(40, len(mesh.faces)))
    assert np.array_equal(proxima.Index(holed).contains(points), np.abs(oracles.winding_numbers(holed, points)) >= 0.5)
    with pytest.raises(proxima.InvalidInput, match="point 1 is not finite"):
        proxima.Index(holed).contains([[0, 0, 0], [0, np.nan, 0]])


@pytest.mark.parametrize("lists", [False, True])
def test_refit_answers_as_a_new_index(tmp_path, mesh, points, lists):
    index = proxima.Index(mesh, lists=lists, signs=True)
    bent = mesh.vertices + 0.05 * np.sin(7 * mesh.vertices[:, [1, 2, 0]])
    before = index.closest(points)
    expected = proxima.Index(proxima.Mesh(bent, mesh.faces))
    for topology in (None, proxima.Topology(mesh)):
        refit = index.refit(bent, topology=topology)
        assert refit.has_lists == lists and not refit.has_signs and refit.fingerprint == expected.fingerprint
        for mine, other in zip(refit.closest(points), expected.closest(points)):
            assert np.array_equal(mine, other)
        for mine, other in zip(refit.cast(points, -points), expected.cast(points, -points)):
            assert np.array_equal(mine, other, equal_nan=True)
    for mine, other in zip(index.closest(points), before):
        assert np.array_equal(mine, other)
    if lists:
        with pytest.raises(proxima.InvalidInput, match="lists"):
            refit.save(tmp_path / "a.pxi")
    else:
        assert pickle.loads(pickle.dumps(refit)).fingerprint == expected.fingerprint


def test_refit_refuses(mesh, index):
    other = proxima.Topology(proxima.Mesh(mesh.vertices, mesh.faces[::-1]))
    for vertices, topology, says in ((mesh.vertices[1:], None, "vertices: must be as many as the index has, 288, are 287"),
                                     (mesh.vertices * np.nan, None, "NaN|finite"),
                                     (mesh.vertices, other, "the index is of other triangles")):
        with pytest.raises(proxima.InvalidInput, match=says):
            index.refit(vertices, topology=topology)
