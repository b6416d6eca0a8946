import copy
import gc
import os
import pickle
import signal
import subprocess
import sys
import threading
import time
import tracemalloc
import warnings
from fractions import Fraction

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra import numpy as arrays

import oracles
import proxima


def same(a, b):
    """Whether all columns of two answers have the same bits."""
    return all(np.array_equal(x.view("u1"), y.view("u1")) for x, y in zip(a, b))


def test_closest_equals_the_search_over_all_triangles(mesh, index, points):
    closest = index.closest(points)
    truth = oracles.triangle_distances(mesh, points).min(axis=1)
    assert np.allclose(closest.distance, truth, rtol=1e-12)
    assert np.allclose(np.linalg.norm(points - closest.point, axis=1), truth, rtol=1e-12)
    corners = oracles.corners(mesh)[closest.triangle]
    assert np.allclose((closest.barycentric[..., None] * corners).sum(axis=1), closest.point, atol=1e-12)
    assert set(closest.feature_kind) <= {0, 1, 2}
    faces = closest.feature_kind == 2
    assert np.array_equal(closest.feature[faces], closest.triangle[faces]) and faces.any()
    vertices = closest.feature_kind == 0
    assert np.array_equal(mesh.vertices[closest.feature[vertices]], closest.point[vertices]) and vertices.any()
    edges = closest.feature_kind == 1
    one, other = mesh.vertices[proxima.Topology(mesh).edges[closest.feature[edges]]].transpose(1, 0, 2)
    across = np.cross(closest.point[edges] - one, closest.point[edges] - other)
    assert np.allclose(across, 0, atol=1e-12) and edges.any()


def test_columns_out_and_threads_change_no_answer(index, points):
    whole = index.closest(points)
    some = index.closest(points, columns=("distance", "triangle"), threads=1)
    assert some.point is None and same(some[:1] + some[2:3], whole[:1] + whole[2:3])
    out = index.closest(np.zeros_like(points))
    assert index.closest(points, out=out) is out and same(out, whole)
    for name in whole._fields:
        assert same([getattr(index.closest(points, columns=[name]), name)], [getattr(whole, name)])


def test_out_must_fit(index, points):
    out = index.closest(points[:5])
    with pytest.raises(proxima.InvalidInput, match="out.distance"):
        index.closest(points, out=out)
    out.point.setflags(write=False)
    with pytest.raises(proxima.InvalidInput, match="out.point"):
        index.closest(points[:5], out=out)
    with pytest.raises(proxima.InvalidInput, match="no column \"colour\""):
        index.closest(points, columns=["colour"])


@pytest.mark.parametrize("make", [
    lambda p: p.astype("f4").astype("f8").astype("f4"), np.asfortranarray, lambda p: p[::-1][::-1],
    lambda p: np.repeat(p, 2, axis=0)[::2], lambda p: p.astype(">f8"), lambda p: p.tolist(),
    lambda p: np.frombuffer(b"x" + p.tobytes(), "f8", offset=1).reshape(-1, 3), lambda p: p.astype("f4")[::2],
])
def test_any_type_and_memory_order(index, points, make):
    given = make(points)
    assert same(index.closest(given), index.closest(np.array(given, "f8", order="C")))


def test_doubles_in_c_order_are_not_copied(index):
    points = np.zeros((200_000, 3))
    out = index.closest(points, columns=["triangle"])

    def allocated(given):
        tracemalloc.start()
        index.closest(given, out=out)
        peak = tracemalloc.get_traced_memory()[1]
        tracemalloc.stop()
        return peak

    assert allocated(points) < points.nbytes // 100
    assert allocated(np.asfortranarray(points)) >= points.nbytes


@pytest.mark.parametrize("bad, says", [
    (np.full((3, 3), np.nan), "point 0 is not finite"),
    ([[0, 0, 0], [0, np.inf, 0]], "point 1 is not finite"),
    (np.zeros(3), r"points: must have shape \(n, 3\), has \(3,\)"),
    (np.zeros((2, 4)), r"has \(2, 4\)"),
    (np.zeros((2, 3), "M8[s]"), "has dtype datetime64"),
    (np.array([[1, 2, None]], object), "has dtype object"),
    ([[1, 2], [3]], "points: "),
])
@pytest.mark.filterwarnings("ignore::numpy.VisibleDeprecationWarning")
def test_refuses_what_are_no_points(index, bad, says):
    for ask in (index.closest, index.signed_distance, lambda p: index.within(p, 1.0)):
        with pytest.raises(proxima.InvalidInput, match=says):
            ask(bad)


def test_no_points_have_no_answers(index):
    none = np.zeros((0, 3))
    assert index.closest(none).point.shape == (0, 3)
    assert index.signed_distance(none).shape == (0,)
    assert index.cast(none, none).t.shape == (0,)
    assert index.within(none, 1.0).first.tolist() == [0]


def test_one_point(index, points):
    many = index.closest(points)
    for i in range(50):
        for one in (index.closest_one(*points[i]), index.closest_one(points[i]), index.closest_one(points[i].tolist()),
                    index.closest_one(np.asfortranarray(points)[i])):
            assert one.distance == many.distance[i] and one.point == tuple(many.point[i])
            assert (one.triangle, one.feature_kind, one.feature) == (
                many.triangle[i], many.feature_kind[i], many.feature[i])
            assert one.barycentric == tuple(many.barycentric[i])
    assert "distance" in repr(one)


@pytest.mark.parametrize("arguments, error", [
    ((), TypeError), ((1, 2), TypeError), (("a", 2, 3), TypeError), ((np.zeros(4),), ValueError),
    ((float("nan"), 0, 0), proxima.InvalidInput), ((np.array([0, 0, np.inf]),), proxima.InvalidInput),
    ((np.ma.array([0.0, 0, 5], mask=[0, 0, 1]),), proxima.InvalidInput), ((1j, 2, 3), TypeError), ((1, 2, None), TypeError),
])
def test_one_point_is_checked(index, arguments, error):
    with pytest.raises(error):
        index.closest_one(*arguments)
    with pytest.raises(TypeError):
        proxima.Index.closest_one(None, 1, 2, 3)


@pytest.mark.parametrize("wrong, says", [
    *(pytest.param(wrong, "is beyond the largest double", id=name)
      for name, wrong in {"huge": 10**400, "-huge": -10**400, "fraction": Fraction(10**400)}.items()),
    *((kind(1 + 5j), "must be a real number, is complex") for kind in (np.complex64, np.complex128, np.clongdouble, np.array))])
def test_coordinates_are_checked(index, wrong, says):
    for k, name in enumerate("xyz"):
        given = [0.5, 2, np.float32(3)]
        given[k] = wrong
        with pytest.raises(proxima.InvalidInput, match=f"^{name}: {says}") as error:
            index.closest_one(*given)
        assert error.value.code == "invalid_argument"
    for number in (1, True, np.float32(1), np.int8(1), np.array(1), Fraction(1)):  # real ones of any type
        expected = index.closest_one(float(number), 2.0, 3.0)
        assert index.closest_one(number, np.uint8(2), np.longdouble(3)).point == expected.point


def test_signs_are_those_of_winding_numbers(mesh, index, points):
    distances, methods = index.signed_distance(points, method=True)
    assert same([distances], [index.signed_distance(points)])
    assert np.array_equal(distances < 0, oracles.winding_numbers(mesh, points) > 0.5)
    assert (distances < 0).any() and set(methods) <= {0, 1, 2}
    assert np.array_equal(np.abs(distances), index.closest(points).distance)


def test_signs_must_be_there(mesh, points):
    plain = proxima.Index(mesh)
    with pytest.raises(proxima.InvalidInput, match="signs=True"):
        plain.signed_distance(points)
    assert same([plain.with_signs().signed_distance(points)], [proxima.Index(mesh, signs=True).signed_distance(points)])


def test_additions_change_no_answer(mesh, points):
    plain = proxima.Index(mesh)
    rich = proxima.Index(mesh, lists=True, distances=True, signs=True, threads=1)
    assert (rich.has_lists, rich.has_distances, rich.has_signs) == (True, True, True)
    assert same(plain.closest(points), rich.closest(points))
    assert same(plain.closest(points), plain.with_lists(100_000).with_distances().closest(points))
    assert rich.nbytes > plain.nbytes and "lists, distances, signs" in repr(rich)
    for bad in (0, -5, "many", 1.5):
        with pytest.raises(proxima.InvalidInput, match="lists: "):
            proxima.Index(mesh, lists=bad)


def test_rays_equal_the_search_over_all_triangles(mesh, index, points):
    directions = np.random.default_rng(8).normal(size=points.shape)
    truth = oracles.ray_hits(mesh, points, directions)
    hits = index.cast(points, directions)
    first = np.where(np.isnan(truth), np.inf, truth).min(axis=1)
    assert np.array_equal(hits.hit, np.isfinite(first)) and hits.hit.any() and not hits.hit.all()
    assert np.allclose(hits.t, first)
    assert (hits.triangle[~hits.hit] == -1).all() and np.isnan(hits.u[~hits.hit]).all()
    corners = oracles.corners(mesh)[hits.triangle[hits.hit]]
    u, v = hits.u[hits.hit, None], hits.v[hits.hit, None]
    at = (1 - u - v) * corners[:, 0] + u * corners[:, 1] + v * corners[:, 2]
    assert np.allclose(at, (points + hits.t[:, None] * directions)[hits.hit])
    assert np.array_equal(index.cast(points, directions, hits="any"), hits.hit)
    every = index.cast(points, directions, hits="all")
    assert np.array_equal(np.diff(every.first), np.isfinite(truth).sum(axis=1))
    assert np.array_equal(every.t[every.first[:-1][hits.hit]], hits.t[hits.hit])


def test_ray_arguments(index):
    directions = np.array([[0, 0, -1.0], [0, 0, 2.0]])
    one = index.cast([1, 0, 5], directions)
    assert one.hit.tolist() == [True, False]
    assert same(one, index.cast([[1, 0, 5]] * 2, directions))
    assert index.cast([1, 0, 5], directions, t_max=1).hit.tolist() == [False, False]
    assert index.cast([1, 0, 5], directions, t_min=[0, -9]).hit.tolist() == [True, True]
    assert index.cast([1, 0, 5], directions, faces="back").t[0] > one.t[0]
    for arguments, says in ((dict(hits="some"), "hits: "), (dict(faces="left"), "faces: "), (dict(t_min=[1, 2, 3]), "t_min: ")):
        with pytest.raises(proxima.InvalidInput, match=says):
            index.cast([1, 0, 5], directions, **arguments)
    with pytest.raises(proxima.InvalidInput, match="origins: are 3, directions are 2"):
        index.cast(np.zeros((3, 3)), directions)
    with pytest.raises(proxima.InvalidInput, match="ray 1"):
        index.cast([0, 0, 0], [[1, 0, 0], [0, 0, 0]])


def test_visible_triangles(mesh, index):
    corners = oracles.corners(mesh)
    ids = index.visible([[1, 0, 0, -0.5]])
    outside = (corners[..., 0] < 0.5).all(axis=1)
    assert np.array_equal(ids, np.flatnonzero(~outside))
    view = proxima.perspective([0, 0, 5], [0, 0, -1])
    assert view.shape == (5, 4) and proxima.orthographic([0, 0, 5], [0, 0, -1], far=9).shape == (6, 4)
    assert np.isin(index.visible(view, exact=True), index.visible(view)).all()
    assert len(index.visible(proxima.perspective([0, 0, 5], [0, 0, 1]))) == 0
    with pytest.raises(proxima.InvalidInput, match="planes: must have shape"):
        index.visible(np.zeros((3, 3)))
    with pytest.raises(proxima.InvalidInput):
        index.visible([[0, 0, np.nan, 1]])


@pytest.fixture(scope="module")
def tiles():
    """Small triangles in z = 0 around points whose x and y are odd multiples of 1/8, and these points."""
    middles = np.stack(np.meshgrid(*[np.arange(-3.875, 4, 0.25)] * 2), axis=-1).reshape(-1, 2)
    corners = middles[:, None] + [[0.1, 0], [-0.05, 0.08], [-0.05, -0.08]]
    vertices = np.pad(corners.reshape(-1, 2), ((0, 0), (0, 1)))
    return proxima.Index(proxima.Mesh(vertices, np.arange(len(vertices)).reshape(-1, 3))), middles


def within(middles, x, y):
    """The triangles around points with |x| and |y| below these."""
    return np.flatnonzero((np.abs(middles) < [x, y]).all(axis=1))


def test_an_orthographic_camera_sees_a_box(tiles):
    index, middles = tiles

    def seen(up=(0, 1, 0), **options):
        return index.visible(proxima.orthographic([0, 0, 5], [0, 0, -1], up, **options)).tolist()

    wide = within(middles, 2, 0.5).tolist()
    assert len(wide) == 16 * 4 and seen(width=4, height=1) == wide == seen(width=4, height=1, near=4, far=6)
    assert seen((1, 0, 0), width=4, height=1) == within(middles, 0.5, 2).tolist()
    assert seen(width=4, height=1, near=6) == seen(width=4, height=1, far=4) == []
    assert seen() == within(middles, 1, 1).tolist()


def test_a_perspective_camera_sees_a_pyramid(tiles):
    index, middles = tiles

    def seen(up=(0, 1, 0), **options):  # 90 degrees from 1 above: from -1 to 1
        return index.visible(proxima.perspective([0, 0, 1], [0, 0, -1], up, field_of_view=np.pi / 2, **options)).tolist()

    wide = within(middles, 2, 1).tolist()
    assert len(wide) == 16 * 8 and seen(aspect=2) == wide == seen(aspect=2, near=0.5, far=2)
    assert seen((1, 0, 0), aspect=2) == within(middles, 1, 2).tolist()
    assert seen(near=1.5) == seen(far=0.5) == []
    assert seen() == within(middles, 1, 1).tolist()


def shift(*by):
    pose = np.eye(4)
    pose[:3, 3] = by
    return pose


def test_two_meshes(mesh, index):
    other = proxima.Index(proxima.Mesh.sample("icosphere:2"))
    poses = np.array([shift(0, 0, 0), shift(1, 0, 0), shift(5, 0, 0)])
    answers = index.intersect(other, poses, pairs=False)
    assert answers.tolist() == [True, True, False]
    lists = index.intersect(other, poses[:, :3])
    assert np.array_equal(lists.intersecting, answers) and lists.first[-1] == len(lists.a) == len(lists.b)
    one = index.intersect(other, poses[1])
    assert np.array_equal(one.a, lists.a[lists.first[1]:lists.first[2]]) and one.intersecting
    assert index.intersect(other, pairs=False) is True
    apart = index.distance_to(other, poses)
    assert apart.distance[0] == 0 and apart.distance[2] > 0
    vertices = other.mesh().vertices + [5, 0, 0]
    assert apart.distance[2] == pytest.approx(oracles.triangle_distances(mesh, vertices).min(), rel=0.05)
    single = index.distance_to(other, poses[2])
    assert single.distance == apart.distance[2] and single.point_a.shape == (3,)
    assert np.linalg.norm(single.point_a - single.point_b) == pytest.approx(single.distance)
    none = index.distance_to(other, poses[2], farthest=0.1)
    assert none.distance == np.inf and none.triangle_a == -1 and np.isnan(none.point_a).all()


@pytest.mark.parametrize("poses, says", [
    (np.eye(3), "poses: must have shape"), (2 * np.eye(4), "poses: the last row"),
    (np.diag([2.0, 1, 1, 1]), "poses: "), ([np.eye(4), np.full((4, 4), np.nan)], "pose 1: "),
    (np.diag([-1.0, 1, 1, 1]), "poses: "),
])
def test_poses_are_checked(index, poses, says):
    for ask in (index.intersect, index.distance_to):
        with pytest.raises(proxima.InvalidInput, match=says):
            ask(index, poses)


def test_rounded_rotations_are_replaced_and_said(index):
    turn = np.eye(4)
    turn[:2, :2] = [[0.8, -0.6], [0.6, 0.8]]
    rounded = turn.astype("f4")
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        assert index.distance_to(index, rounded).distance == index.distance_to(index, turn).distance
    stretched = np.diag([1.0003, 1, 1, 1])
    stretched[0, 3] = 3
    with pytest.warns(UserWarning, match="nearest rotations"):
        found = index.distance_to(index, [np.eye(4), stretched])
    stretched[0, 0] = 1
    assert found.distance[1] == pytest.approx(index.distance_to(index, stretched).distance, rel=1e-12)
    with pytest.warns(UserWarning, match="nearest rotations"):
        index.contour(index, np.diag([1.0003, 1, 1, 1]))


def test_within(mesh, index, points):
    found = index.within(points, 0.4)
    truth = oracles.triangle_distances(mesh, points) <= 0.4
    assert np.array_equal(np.diff(found.first), truth.sum(axis=1))
    assert np.array_equal(found.triangle, np.nonzero(truth)[1])
    everything = index.within(points[:1], 100)
    assert np.array_equal(everything.triangle, np.arange(len(mesh.faces)))
    with pytest.raises(proxima.InvalidInput, match="radius"):
        index.within(points, -1)


def test_nearest(mesh, index, points):
    truth = oracles.triangle_distances(mesh, points)
    found = index.nearest(points, 9)
    assert found.distance.shape == found.triangle.shape == (len(points), 9)
    assert np.allclose(found.distance, np.sort(truth, axis=1)[:, :9], rtol=1e-12)
    assert np.allclose(np.take_along_axis(truth, found.triangle.astype(int), axis=1), found.distance, rtol=1e-12)
    assert all(len(set(row)) == 9 for row in found.triangle.tolist())
    assert np.array_equal(found.distance[:, 0], index.closest(points).distance)
    few = index.nearest(points, len(mesh.faces) + 2, radius=0.4)
    counts = np.diff(index.within(points, 0.4).first)
    assert np.array_equal((few.triangle >= 0).sum(axis=1), counts) and np.array_equal(np.isfinite(few.distance), few.triangle >= 0)
    assert index.nearest(np.empty((0, 3)), 2).triangle.shape == (0, 2)
    for bad, says in ((dict(count=0), "count"), (dict(count=1, radius=np.nan), "radius")):
        with pytest.raises(proxima.InvalidInput, match=says):
            index.nearest(points, **bad)
    with pytest.raises(proxima.InvalidInput, match="point 1"):
        index.nearest([[0, 0, 0], [np.inf, 0, 0]], 1)


def test_triangles_in_a_box(mesh, index):
    corners = oracles.corners(mesh)
    inside = index.in_box([-10, -10, -10], [10, 10, 10])
    assert np.array_equal(inside, np.arange(len(mesh.faces)))
    lower, upper = np.array([-0.1, -0.2, -2.0]), np.array([0.3, 0.4, 2.0])
    found = index.in_box(lower, upper)
    boxes_meet = ((corners.min(axis=1) <= upper) & (corners.max(axis=1) >= lower)).all(axis=1)
    with_corner = ((corners >= lower) & (corners <= upper)).all(axis=2).any(axis=1)
    assert set(np.nonzero(with_corner)[0]) <= set(found.tolist()) <= set(np.nonzero(boxes_meet)[0])
    assert 0 < len(found) < len(mesh.faces)
    with pytest.raises(proxima.InvalidInput, match="lower"):
        index.in_box([1, 0, 0], [0, 0, 0])


def test_distance_fields(mesh):
    index = proxima.Index(mesh, signs=True)
    field = index.distance_field(23, gradient=True, method=True)
    assert max(field.distance.shape) == 23 and field.gradient.shape == field.distance.shape + (3,)
    places = np.stack(np.meshgrid(*map(np.arange, field.distance.shape), indexing="ij"), axis=-1)
    points = (field.origin + field.spacing * places).reshape(-1, 3)
    distances, methods = index.signed_distance(points, method=True)
    assert np.array_equal(field.distance.ravel(), distances) and np.array_equal(field.method.ravel(), methods)
    assert field.distance.flags.f_contiguous
    closest = index.closest(points).point
    assert np.allclose(points - distances[:, None] * field.gradient.reshape(-1, 3), closest, atol=1e-12)
    assert (points.min(axis=0) < mesh.bounds[0]).all() and (points.max(axis=0) > mesh.bounds[1]).all()

    banded = index.distance_field(23, band=0.2, threads=1)
    assert banded.gradient is None and banded.method is None
    assert np.array_equal(banded.distance, np.clip(field.distance, -0.2, 0.2))
    part = index.distance_field(spacing=0.25, margin=0, box=[[-1, 0, 0], [1, 0.5, 1]])
    assert part.distance.shape == (9, 3, 5) and np.array_equal(part.origin, [-1, 0, 0]) and part.spacing == 0.25
    for bad, says in ((dict(resolution=1), "resolution"), (dict(spacing=-1), "spacing"), (dict(band=0), "band"),
                      (dict(margin=np.nan), "margin"), (dict(box=[[0, 0, 0]]), "box"), (dict(spacing=1e-9), "spacing")):
        with pytest.raises(proxima.InvalidInput, match=says):
            index.distance_field(**bad)
    with pytest.raises(proxima.InvalidInput, match="signs"):
        proxima.Index(mesh).distance_field(4)


def test_memory_of_answers(mesh, index, points):
    """As docs/python.md says: new arrays in C order, but for fields, and views of the mesh."""
    field = index.distance_field(9, gradient=True, method=True)
    answers = [*index.closest(points), *index.cast(points, points), *index.within(points, 1), *index.nearest(points, 2),
               index.signed_distance(points), index.contains(points), field.origin, proxima.Topology(mesh).edges, mesh.bounds]
    assert all(column.flags.c_contiguous and column.flags.writeable for column in answers)
    assert field.distance.flags.f_contiguous and field.method.flags.f_contiguous and field.distance.flags.writeable
    size = field.distance.shape
    assert field.gradient.strides == (24, 24 * size[0], 24 * size[0] * size[1], 8)
    for name in ("vertices", "faces"):
        view, again = getattr(mesh, name), getattr(mesh, name)
        assert np.shares_memory(view, again) and view.flags.c_contiguous and not view.flags.writeable


def test_an_index_of_several_bound_classes(mesh):
    class Both(proxima.Index, proxima.Mesh):
        def __init__(self):
            proxima.Index.__init__(self, mesh)
            proxima.Mesh.__init__(self, np.eye(3), [[0, 1, 2]])

    both = Both()
    assert both.closest_one(3, 0, 0).distance == both.closest([[3, 0, 0]]).distance[0]
    with pytest.raises(TypeError, match="made by __new__ alone"):
        Both.__new__(Both).closest_one(3, 0, 0)


def test_files_and_pickles(tmp_path, mesh, points):
    index = proxima.Index(mesh, lists=True, distances=True, signs=True)
    index.save(tmp_path / "a.pxi")
    for other in (proxima.Index.load(tmp_path / "a.pxi"), proxima.Index.load(str(tmp_path / "a.pxi"), map=True),
                  *(pickle.loads(pickle.dumps(index, protocol)) for protocol in range(pickle.HIGHEST_PROTOCOL + 1))):
        assert same(other.closest(points), index.closest(points)) and repr(other) == repr(index)
        assert same([other.signed_distance(points)], [index.signed_distance(points)])
    assert np.array_equal(index.mesh().vertices, mesh.vertices)
    with pytest.raises(proxima.FileMissing):
        proxima.Index.load(tmp_path / "none.pxi")
    (tmp_path / "bad.pxi").write_bytes((tmp_path / "a.pxi").read_bytes()[:5000])
    with pytest.raises(proxima.InvalidInput, match="bad.pxi"):
        proxima.Index.load(tmp_path / "bad.pxi")
    assert copy.copy(index) is index and copy.deepcopy([index])[0] is index


def test_the_mesh_of_an_index_has_vertices_without_a_triangle_at_its_centre(mesh):
    vertices = np.concatenate((mesh.vertices[:100], [[9, 9, 9]], mesh.vertices[100:]))
    faces = np.array(mesh.faces) + (mesh.faces >= 100)
    given = proxima.Mesh(vertices, faces)
    index = proxima.Index(given)
    again = index.mesh()
    vertices[100] = mesh.bounds.mean(axis=0)
    assert np.array_equal(again.vertices, vertices) and np.array_equal(again.faces, faces)
    assert index.fingerprint == given.fingerprint != again.fingerprint
    assert proxima.Index(mesh).mesh().fingerprint == mesh.fingerprint


def test_objects_own_what_they_need(tmp_path, points):
    mesh = proxima.Mesh.sample("sphere:40x40")
    expected = proxima.Index(mesh, signs=True).signed_distance(points)
    proxima.Index(mesh, signs=True).save(tmp_path / "a.pxi")
    index = proxima.Index(mesh)
    rich = index.with_signs()
    mapped = proxima.Index.load(tmp_path / "a.pxi", map=True)
    closest = index.closest(points)
    distance = closest.distance
    del mesh, index, closest
    (tmp_path / "a.pxi").unlink()
    gc.collect()
    trash = [np.random.rand(1000) for _ in range(1000)]
    assert same([rich.signed_distance(points)], [expected]) and same([mapped.signed_distance(points)], [expected])
    assert np.array_equal(distance, np.abs(expected)) and trash


def test_broken_meshes_are_refused():
    for vertices, faces in ((np.zeros((0, 3)), np.zeros((0, 3), int)), (np.full((3, 3), np.nan), [[0, 1, 2]])):
        with pytest.raises(proxima.InvalidInput) as caught:
            proxima.Index(proxima.Mesh(vertices, faces))
        assert caught.value.code == "invalid_mesh"


def test_threads_must_be_a_count(index, points):
    with pytest.raises(proxima.InvalidInput, match="threads: "):
        index.closest(points, threads=-1)


def test_progress_is_told_and_can_cancel():
    mesh = proxima.Mesh.sample("spaceship:60000")
    seen = []
    proxima.Index(mesh, signs=True, progress=lambda stage, fraction: seen.append((stage, fraction)))
    assert seen and all(isinstance(stage, str) and 0 <= fraction <= 1 for stage, fraction in seen)
    with pytest.raises(proxima.Cancelled) as caught:
        proxima.Index(mesh, lists=True, progress=lambda stage, fraction: False)
    assert caught.value.code == "cancelled"

    def breaks(stage, fraction):
        raise KeyError("mine")

    with pytest.raises(KeyError, match="mine"):
        proxima.Index(mesh, lists=True, progress=breaks)


def test_ctrl_c_stops_long_work():
    mesh = proxima.Mesh.sample("spaceship:200000")
    timer = threading.Timer(0.3, lambda: signal.raise_signal(signal.SIGINT))
    begin = time.monotonic()
    timer.start()
    with pytest.raises(KeyboardInterrupt):
        proxima.Index(mesh, lists=True, threads=1)  # takes minutes
    assert time.monotonic() - begin < 30


def test_ctrl_c_stops_a_batch():
    ball = proxima.Index(proxima.Mesh.sample("icosphere:7"))
    points = np.random.default_rng(1).normal(0, 1e-9, (4096, 3))  # as far from all triangles, so a few milliseconds each
    begin = time.process_time()
    threading.Timer(0.2, lambda: signal.raise_signal(signal.SIGINT)).start()
    with pytest.raises(KeyboardInterrupt):
        ball.closest(points, threads=1)
    assert time.process_time() - begin < 3  # the whole batch takes 20


def test_short_work_tells_that_it_is_done(index, points):
    told = []
    index.closest(points[:3], progress=lambda *step: told.append(step))
    assert told[-1] == ("closest features", 1)


def test_other_threads_run_meanwhile(index):
    points = np.random.default_rng(1).uniform(-2, 2, (400_000, 3))
    done = threading.Event()
    worker = threading.Thread(target=lambda: (index.closest(points, threads=1), done.set()))
    turns = 0
    worker.start()
    while not done.is_set():
        turns += 1
        time.sleep(1e-4)
    worker.join()
    assert turns > 20


@pytest.mark.parametrize("work", ["index.closest(points, threads=1)", "index.closest(points[:9])", "proxima.Index(mesh, lists=True)",
                                  "index.cast(points, -points)"])
def test_a_process_ends_while_a_daemon_thread_works(work):
    program = f"""if True:
        import threading, time
        import numpy as np
        import proxima
        mesh = proxima.Mesh.sample("icosphere:4")
        index = proxima.Index(mesh)
        points = np.random.default_rng(1).normal(size=(20_000, 3))
        def ask():
            while True:
                {work}
        threading.Thread(target=ask, daemon=True).start()
        time.sleep(0.3)
    """
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, timeout=120)
    assert (done.returncode, done.stderr) == (0, "")


def test_queries_from_many_threads(index, points):
    expected = index.closest(points)
    wrong = []

    def ask():
        for _ in range(30):
            if not same(index.closest(points, threads=1), expected):
                wrong.append(1)

    workers = [threading.Thread(target=ask) for _ in range(6)]
    for worker in workers:
        worker.start()
    for worker in workers:
        worker.join()
    assert not wrong


def test_forked_processes_can_query(index, points):
    expected = index.closest(points)
    many = np.tile(points, (40, 1))
    child = os.fork()
    if child == 0:
        fine = same(index.closest(points), expected) and len(index.closest(many).distance) == len(many)
        os._exit(0 if fine else 1)
    assert os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]) == 0


def test_no_reference_is_lost(mesh, index, points):
    def ask():
        index.closest(points)
        index.closest_one(points[0]).point
        index.cast(points, points, hits="all")
        mesh.vertices
        for bad in (np.zeros(3), np.full((1, 3), np.nan)):
            with pytest.raises(proxima.InvalidInput):
                index.closest(bad)
        with pytest.raises(proxima.InvalidInput):
            index.closest_one(float("nan"), 0, 0)

    ask()
    counted = (mesh, index, points, proxima.InvalidInput, proxima.Closest, proxima.ClosestOne)
    before = [sys.getrefcount(each) for each in counted]
    for _ in range(20):
        ask()
    gc.collect()
    assert [abs(sys.getrefcount(each) - count) < 10 for each, count in zip(counted, before)] == [True] * len(counted)


NASTY = st.one_of(st.integers(-3, 3).map(float), st.floats(-4, 4), st.sampled_from([0.0, -0.0, 1e-300, 1e-9, 1e9, 0.1]))


@given(arrays.arrays("f8", (6, 3), elements=NASTY), arrays.arrays("i8", (5, 3), elements=st.integers(0, 5)),
       arrays.arrays("f8", (4, 3), elements=NASTY))
def test_nasty_meshes(vertices, faces, points):
    mesh = proxima.Mesh(vertices, faces)
    index = proxima.Index(mesh)
    closest = index.closest(points)
    size = max(1.0, np.abs(vertices).max(), np.abs(points).max())
    truth = oracles.triangle_distances(mesh, points).min(axis=1)
    assert np.all(closest.distance <= truth + 1e-9 * size)
    on_mesh = (closest.barycentric[..., None] * oracles.corners(mesh)[closest.triangle]).sum(axis=1)
    assert np.allclose(on_mesh, closest.point, rtol=0, atol=1e-9 * size)
    assert np.allclose(np.linalg.norm(points - closest.point, axis=1), closest.distance, rtol=0, atol=1e-9 * size)
    assert [index.closest_one(p).triangle for p in points] == closest.triangle.tolist()


@given(st.one_of(arrays.arrays(st.one_of(arrays.floating_dtypes(), arrays.integer_dtypes(), arrays.complex_number_dtypes(),
                                         arrays.unicode_string_dtypes(), arrays.boolean_dtypes()),
                               arrays.array_shapes(min_dims=0, max_dims=3, max_side=4)),
                 st.none(), st.text(), st.lists(st.lists(st.floats(), max_size=4), max_size=3)))
@pytest.mark.filterwarnings("ignore::numpy.VisibleDeprecationWarning")
def test_any_object_is_answered_or_refused(index, thing):
    try:
        closest = index.closest(thing)
    except proxima.InvalidInput:
        return
    assert len(closest.distance) == len(thing) and np.isfinite(closest.point).all()
