"""The adapters: against brute force, and Open3D's against Open3D, live where it is installed and as recorded elsewhere."""
import importlib.util
import subprocess
import sys
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

import open3d_answers
import oracles
import proxima
from proxima.compat import igl, open3d, trimesh

RECORDED = Path(__file__).with_name("open3d.json")  # by open3d_answers.py


@pytest.fixture(scope="module")
def lookalike(mesh):
    """What the adapter needs of a trimesh.Trimesh."""
    return SimpleNamespace(vertices=np.array(mesh.vertices), faces=np.array(mesh.faces, "i8"))


def normals(mesh):
    a, b, c = np.moveaxis(oracles.corners(mesh), 1, 0)
    normal = np.cross(b - a, c - a)
    return normal / np.linalg.norm(normal, axis=1, keepdims=True)


def rays_at(mesh, count):
    """Origins around the mesh, and directions to points in its box; some miss."""
    random = np.random.default_rng(11)
    origins = 4 * random.normal(size=(count, 3))
    return origins, random.uniform(*mesh.bounds, (count, 3)) - origins


# ---- trimesh


def test_trimesh_closest(mesh, lookalike, points):
    closest, distance, triangle = trimesh.ProximityQuery(lookalike).on_surface(points)
    truth = oracles.triangle_distances(mesh, points)
    assert np.allclose(distance, truth.min(axis=1), rtol=1e-12) and triangle.dtype == np.int64
    assert np.allclose(np.linalg.norm(points - closest, axis=1), distance, rtol=1e-12)
    # Of the triangles that share the closest point, the one that faces the query most.
    facing = np.einsum("nk,fk->nf", points, normals(mesh)) - np.einsum("nk,fk->nf", closest, normals(mesh))
    shared = truth <= truth.min(axis=1, keepdims=True) * (1 + 1e-12)
    assert (shared.sum(axis=1) > 1).any() and shared[np.arange(len(points)), triangle].all()
    best = np.where(shared, facing, -np.inf).max(axis=1)
    assert np.allclose(facing[np.arange(len(points)), triangle], best, rtol=0, atol=1e-9)


def test_trimesh_closest_of_triangles_with_corners_of_their_own(mesh, lookalike, points):
    soup = SimpleNamespace(vertices=oracles.corners(mesh).reshape(-1, 3), faces=np.arange(3 * len(mesh.faces)).reshape(-1, 3))
    closest, distance, triangle = trimesh.ProximityQuery(soup).on_surface(points)
    joined = trimesh.ProximityQuery(lookalike).on_surface(points)
    assert np.allclose(closest, joined[0], rtol=0, atol=1e-14) and np.allclose(distance, joined[1], rtol=1e-14)
    assert np.array_equal(triangle, joined[2])


def test_trimesh_inside_of_clockwise_and_nested_meshes(mesh, points):
    inside = oracles.winding_numbers(mesh, points) > 0.5
    turned = SimpleNamespace(vertices=mesh.vertices, faces=np.array(mesh.faces)[:, ::-1])
    small = mesh.vertices * [1, 1, 0.5] + [0.01, 0.02, 0.03]  # reaches out a little
    twice = SimpleNamespace(vertices=np.concatenate((mesh.vertices, small)),
                            faces=np.concatenate((mesh.faces, np.array(mesh.faces) + len(small))))
    of_small = oracles.winding_numbers(proxima.Mesh(small, mesh.faces), points) > 0.5
    for given, expected in ((turned, inside), (twice, inside ^ of_small)):
        assert np.array_equal(trimesh.RayMeshIntersector(given).contains_points(points), expected)
        assert np.array_equal(trimesh.ProximityQuery(given).signed_distance(points) > 0, expected) and expected.any()


def flipped(mesh, triangles):
    """The mesh with some triangles reversed."""
    faces = np.array(mesh.faces)
    faces[triangles] = faces[triangles, ::-1]
    return SimpleNamespace(vertices=mesh.vertices, faces=faces)


def insides(given, points):
    """Whether points are inside, in three ways of both libraries."""
    scene = open3d.RaycastingScene()
    scene.add_triangles(given.vertices, given.faces)
    return (trimesh.RayMeshIntersector(given).contains_points(points), trimesh.ProximityQuery(given).signed_distance(points) > 0,
            scene.compute_occupancy(points) == 1)


def test_inside_of_meshes_with_triangles_that_face_the_other_way(mesh, points):
    """As rays that count crossings have it, which ask no triangle where it faces."""
    cube, height = proxima.Mesh.sample("cube"), np.array([0.05, 0.5, 0.95])[:, None]
    for triangle in range(12):
        centroid = cube.vertices[cube.faces[triangle]].mean(axis=0)
        for found in insides(flipped(cube, [triangle]), np.concatenate((centroid * (1 - height), centroid * (1 + height)))):
            assert found.tolist() == [True] * 3 + [False] * 3, triangle
    inside = oracles.winding_numbers(mesh, points) > 0.5
    some = np.random.default_rng(5).permutation(len(mesh.faces))
    for count in (1, 20, 200, 400):
        for found in insides(flipped(mesh, some[:count]), points):
            assert np.array_equal(found, inside) and found.any()
    # A ball in a ball, a tenth of the triangles of both reversed: a shell. Then without the triangles about its upper pole: open.
    ball = proxima.Mesh.sample("icosphere:3")
    two = proxima.Mesh(np.concatenate((ball.vertices, ball.vertices / 2)), np.concatenate((ball.faces, ball.faces + len(ball.vertices))))
    radius = np.linalg.norm(points, axis=1)
    sure = np.minimum(np.abs(radius - 1), np.abs(radius - 0.5)) > 0.02
    for found in insides(flipped(two, np.arange(0, len(two.faces), 10)), points[sure]):
        assert np.array_equal(found, ((radius < 1) & (radius > 0.5))[sure]) and found.any()
    cut = proxima.Mesh(ball.vertices, ball.faces[oracles.corners(ball).mean(axis=1)[:, 2] < 0.95])
    low = points[sure & (points[:, 2] < 0)]
    for found in insides(flipped(cut, np.arange(0, len(cut.faces), 10)), low):
        assert np.array_equal(found, np.linalg.norm(low, axis=1) < 1) and found.any()


@pytest.mark.parametrize("size", [1e-150, 1e-110, 1e-30, 1, 1e100, 1e103, 1e150])
def test_inside_of_clockwise_meshes_of_any_size(size):
    ball = proxima.Mesh.sample("icosphere:2")
    turned = SimpleNamespace(vertices=ball.vertices * size, faces=np.array(ball.faces)[:, ::-1])
    points = np.array([[0.1, 0, 0], [0.9, 0, 0], [1.1, 0, 0], [0, 0, -5]]) * size
    assert trimesh.RayMeshIntersector(turned).contains_points(points).tolist() == [True, True, False, False]
    scene = open3d.RaycastingScene()
    scene.add_triangles(turned)
    assert scene.compute_occupancy(points).tolist() == [1, 1, 0, 0]


def test_trimesh_tells_both_sides_of_a_sheet():
    corners = np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 9], [1, 0, 9], [0, 1, 9]])
    points = [[0.2, 0.2, 1], [0.2, 0.2, -1], [-1, -1, 1], [-1, -1, -1]]  # beside a face, and a corner
    for faces, expected in (([[0, 1, 2], [0, 2, 1]], [0, 1, 0, 1]), ([[0, 2, 1], [2, 0, 1]], [1, 0, 1, 0]),
                            ([[3, 4, 5], [5, 4, 3], [2, 1, 0], [1, 2, 0]], [3, 2, 3, 2]), ([[0, 1, 2]], [0, 0, 0, 0])):
        sheet = SimpleNamespace(vertices=corners, faces=np.array(faces))
        closest, distance, triangle = trimesh.ProximityQuery(sheet).on_surface(points)
        assert triangle.tolist() == expected and triangle.dtype == np.int64
        assert np.allclose(closest, [[0.2, 0.2, 0]] * 2 + [[0, 0, 0]] * 2) and np.allclose(distance, [1, 1, 3 ** 0.5, 3 ** 0.5])
    soup = SimpleNamespace(vertices=np.concatenate((corners[:3], corners[2::-1])), faces=np.arange(6).reshape(2, 3))
    assert trimesh.ProximityQuery(soup).on_surface(points)[2].tolist() == [0, 1, 0, 1]


def test_trimesh_tells_triangles_at_an_edge_of_a_huge_mesh():
    cube = proxima.Mesh.sample("cube")
    at = np.array([[1, 3, 0.1], [3, 1, 0.1], [2, -3, 0.1], [-3, -2, 0.1]]) * cube.bounds[1]  # beyond edges along z
    for size in (1.0, 1e80, 1e150):
        _, _, triangle = trimesh.ProximityQuery(SimpleNamespace(vertices=cube.vertices * size, faces=cube.faces)).on_surface(at * size)
        assert normals(cube)[triangle].tolist() == [[0, 1, 0], [1, 0, 0], [0, -1, 0], [-1, 0, 0]]


def test_trimesh_signs_are_positive_inside(mesh, lookalike, points):
    query = trimesh.ProximityQuery(lookalike)
    distance = query.signed_distance(points)
    inside = oracles.winding_numbers(mesh, points) > 0.5
    assert np.array_equal(distance > 0, inside) and inside.any()
    assert np.allclose(np.abs(distance), oracles.triangle_distances(mesh, points).min(axis=1), rtol=1e-12)
    near = mesh.vertices[:40] * (1 + 1e-10)
    assert (query.signed_distance(near) >= 0).all() and (query.signed_distance(near * (1 + 1e-6)) < 0).any()
    assert np.array_equal(trimesh.RayMeshIntersector(lookalike).contains_points(points), inside)


def test_trimesh_vertices(lookalike, points):
    lookalike = SimpleNamespace(vertices=np.vstack((lookalike.vertices, [[2, 2, 2]])), faces=lookalike.faces)
    distance, vertex = trimesh.ProximityQuery(lookalike).vertex(points)
    truth = np.linalg.norm(points[:, None] - lookalike.vertices, axis=2)
    assert np.array_equal(vertex, truth.argmin(axis=1)) and np.allclose(distance, truth.min(axis=1), rtol=1e-12)
    assert len(lookalike.vertices) - 1 in vertex and vertex.dtype == np.int64


def test_trimesh_rays(mesh, lookalike):
    origins, directions = rays_at(mesh, 300)
    ray = trimesh.RayMeshIntersector(lookalike)
    truth = oracles.ray_hits(mesh, origins, directions)
    hit = ~np.isnan(truth)
    assert np.array_equal(ray.intersects_any(origins, directions), hit.any(axis=1)) and 0 < hit.any(axis=1).sum() < 300
    first = np.where(hit, truth, np.inf).argmin(axis=1)
    assert np.array_equal(ray.intersects_first(origins, directions), np.where(hit.any(axis=1), first, -1))
    triangles, rays = ray.intersects_id(origins, directions)
    assert set(zip(rays, triangles)) == set(zip(*np.nonzero(hit))) and triangles.dtype == rays.dtype == np.int64
    places, rays, triangles = ray.intersects_location(origins, directions)
    assert np.allclose(places, origins[rays] + truth[rays, triangles][:, None] * directions[rays], rtol=0, atol=1e-12)
    triangles, rays = ray.intersects_id(origins, directions, multiple_hits=False)
    assert np.array_equal(rays, np.flatnonzero(hit.any(axis=1))) and np.array_equal(triangles, first[rays])
    with_places = ray.intersects_id(origins, directions, return_locations=True, multiple_hits=False)
    assert np.array_equal(with_places[0], triangles) and with_places[2].shape == (len(rays), 3)


def test_trimesh_rays_from_one_origin(lookalike):
    ray = trimesh.RayMeshIntersector(lookalike)
    directions = np.random.default_rng(7).normal(size=(50, 3))
    one, many = np.array([0.1, 0.2, 0.3]), np.tile([0.1, 0.2, 0.3], (50, 1))
    for several in (True, False):
        for mine, theirs in zip(ray.intersects_location(one, directions, several), ray.intersects_location(many, directions, several)):
            assert np.array_equal(mine, theirs) and len(mine) > 5
    with pytest.raises(proxima.Error):
        ray.intersects_id([["0", "0.1", "5"]], [[0, 0, -1]])
    for given in (np.ma.masked_array([[0.0, 0, 9]], mask=[[1, 0, 0]]), [["0", "0", "9"]], [0.0, 0, 9]):
        with pytest.raises(proxima.Error):
            trimesh.ProximityQuery(lookalike).on_surface(given)


def test_trimesh_counts_a_hit_on_an_edge_once_where_it_says_the_place():
    """As trimesh's own test_on_vertex: rays from the middle of a box to its corners."""
    cube = proxima.Mesh.sample("cube")
    ray = trimesh.RayMeshIntersector(cube)
    middle = np.zeros((8, 3)) + cube.bounds.mean(axis=0)
    directions = cube.vertices - middle
    _, rays, _ = ray.intersects_location(middle, directions)
    assert np.array_equal(rays, np.arange(8))
    assert len(ray.intersects_id(middle, directions)[1]) > 8


def test_trimesh_without_hits(lookalike):
    ray = trimesh.RayMeshIntersector(lookalike)
    away = np.full((5, 3), 9.0)
    assert not ray.intersects_any(away, away).any() and (ray.intersects_first(away, away) == -1).all()
    for answer in (ray.intersects_id(away, away, return_locations=True), ray.intersects_location(away, away)):
        assert [len(column) for column in answer] == [0, 0, 0]
    none = np.zeros((0, 3))
    assert trimesh.ProximityQuery(lookalike).on_surface(none)[0].shape == (0, 3)
    assert ray.intersects_location(none, none)[0].shape == (0, 3)


# ---- libigl


def test_igl_squared_distances(mesh, points):
    squared, triangles, closest = igl.point_mesh_squared_distance(points, mesh.vertices, np.array(mesh.faces, "i4"))
    truth = oracles.triangle_distances(mesh, points)
    assert np.allclose(squared, truth.min(axis=1) ** 2, rtol=1e-12)
    assert np.allclose(((points - closest) ** 2).sum(axis=1), squared, rtol=1e-11)
    assert np.allclose(truth[np.arange(len(points)), triangles], truth.min(axis=1), rtol=1e-12)
    assert (squared.dtype, triangles.dtype, closest.dtype) == ("f8", "i4", "f8")
    small = igl.point_mesh_squared_distance(points.astype("f4"), mesh.vertices, np.array(mesh.faces, "i8"))
    assert [column.dtype for column in small] == ["f4", "i8", "f4"]
    assert igl.point_mesh_squared_distance(points[0], mesh.vertices, mesh.faces)[2].shape == (1, 3)


@pytest.mark.parametrize("kind", ["i1", "u1", "i2", "u4", "u8"])
def test_igl_ids_do_not_wrap(kind):
    small, points = proxima.Mesh.sample("torus:10x10"), np.random.default_rng(2).uniform(-1.5, 1.5, (400, 3))
    faces = np.array(small.faces).astype(kind)  # of 100 vertices; it has 200 triangles
    expected = proxima.Index(small).closest(points).triangle
    for _, triangles, _ in (igl.point_mesh_squared_distance(points, small.vertices, faces), igl.signed_distance(points, small.vertices, faces)):
        assert np.array_equal(triangles, expected) and triangles.max() > 127 and triangles.dtype == np.int64


@pytest.mark.parametrize("size", [1e-150, 1e-82, 1, 1e80, 1e150])
def test_normals_of_meshes_of_any_size(size):
    vertices, faces = cube_arrays()
    half = proxima.Mesh.sample("cube").bounds[1, 0]
    points = np.array([[0.5, 0.1, 0.2], [1.5, 0.1, 0.2], [1.5, 1.5, 0.2], [1.5, 1.5, 1.5], [0, -0.5, 0]]) * half
    expected = np.array([[1, 0, 0], [1, 0, 0], [0.5 ** 0.5, 0.5 ** 0.5, 0], [3 ** -0.5] * 3, [0, -1, 0]])
    lengths = np.array([-0.5, 0.5, 0.5 ** 0.5, 0.75 ** 0.5, -0.5]) * half
    distance, _, _, normal = igl.signed_distance(points * size, vertices * size, faces, igl.SIGNED_DISTANCE_TYPE_PSEUDONORMAL, True)
    assert np.allclose(distance / size, lengths, rtol=1e-12) and np.allclose(normal, expected, rtol=0, atol=1e-12)
    scene = open3d.RaycastingScene()
    scene.add_triangles(vertices * size, faces)
    rays = np.array([[3, 0.1, 0.2, -1, 0, 0], [0.1, -3, 0.2, 0, 1, 0]]) * half
    rays[:, :3] *= size
    with np.errstate(over="ignore"):  # t_hit and points are float32
        found = [scene.cast_rays(rays), scene.compute_closest_points(points[[0, 4]] * size)]
    for answer in found:
        assert answer["primitive_normals"].tolist() == [[1, 0, 0], [0, -1, 0]]


def test_igl_signs_are_negative_inside(mesh, points):
    distances, triangles, closest = igl.signed_distance(points, mesh.vertices, mesh.faces)
    assert np.array_equal(distances < 0, oracles.winding_numbers(mesh, points) > 0.5) and (distances < 0).any()
    squared, same_triangles, same_closest = igl.point_mesh_squared_distance(points, mesh.vertices, mesh.faces)
    assert np.allclose(distances ** 2, squared) and np.array_equal(triangles, same_triangles)
    assert np.array_equal(closest, same_closest)
    unsigned = igl.signed_distance(points, mesh.vertices, mesh.faces, sign_type=igl.SIGNED_DISTANCE_TYPE_UNSIGNED)[0]
    assert np.array_equal(unsigned, np.abs(distances))


def test_igl_pseudonormals(mesh, points):
    distances, triangles, closest, normal = igl.signed_distance(points, mesh.vertices, mesh.faces, return_normals=True)
    assert np.allclose(np.linalg.norm(normal, axis=1), 1)
    assert np.array_equal(np.sign(((points - closest) * normal).sum(axis=1)), np.sign(distances))  # what they are for
    found = proxima.Index(mesh).closest(points)
    corners, faces, unit = oracles.corners(mesh), np.asarray(mesh.faces), normals(mesh)
    edges = proxima.Topology(mesh).edges
    for i, (kind, feature) in enumerate(zip(found.feature_kind, found.feature)):
        if kind == 2:
            expected = unit[feature]
        elif kind == 1:
            expected = unit[[set(edges[feature]) <= set(face) for face in faces]].sum(axis=0)
        else:
            expected = np.zeros(3)
            for triangle, corner in zip(*np.nonzero(faces == feature)):
                a, b, c = np.roll(corners[triangle], -corner, axis=0)
                cosine = (b - a) @ (c - a) / np.linalg.norm(b - a) / np.linalg.norm(c - a)
                expected += np.arccos(cosine) * unit[triangle]
        assert np.allclose(normal[i], expected / np.linalg.norm(expected), rtol=0, atol=1e-9), (i, kind)
    assert set(found.feature_kind) >= {1, 2}
    corner = igl.signed_distance([[2, 2, 2], [2, 0, 0]], *cube_arrays(), return_normals=True)[3]
    assert np.allclose(corner, [np.full(3, 3 ** -0.5), [1, 0, 0]])


def test_igl_signs_of_a_clockwise_mesh(mesh, points):
    faces, inside = np.array(mesh.faces)[:, ::-1], oracles.winding_numbers(mesh, points) > 0.5
    for options in (dict(sign_type=igl.SIGNED_DISTANCE_TYPE_PSEUDONORMAL), dict(return_normals=True)):
        assert np.array_equal(igl.signed_distance(points, mesh.vertices, faces, **options)[0] > 0, inside)
    for kind in (igl.SIGNED_DISTANCE_TYPE_DEFAULT, igl.SIGNED_DISTANCE_TYPE_WINDING_NUMBER, igl.SIGNED_DISTANCE_TYPE_FAST_WINDING_NUMBER):
        assert (igl.signed_distance(points, mesh.vertices, faces, kind)[0] > 0).all()


def cube_arrays():
    cube = proxima.Mesh.sample("cube")
    return cube.vertices, cube.faces


@pytest.mark.parametrize("options", [dict(sign_type=7), dict(sign_type=igl.SIGNED_DISTANCE_TYPE_UNSIGNED, return_normals=True)])
def test_igl_refuses(points, options):
    with pytest.raises(proxima.InvalidInput):
        igl.signed_distance(points, *cube_arrays(), **options)


# ---- Open3D


def ask_ours(meshes=None, wrap=np.asarray, unwrap=np.asarray):
    answers = open3d_answers.ask(open3d.RaycastingScene, meshes or open3d_answers.scene_arrays()[0], wrap, unwrap)
    return {**answers, "INVALID_ID": np.array(open3d.RaycastingScene.INVALID_ID)}


def compare(ours, theirs):
    assert set(ours) == set(theirs)
    assert (ours["cast_rays.t_hit"] < np.inf).any() and (ours["cast_rays.t_hit"] == np.inf).any()
    assert {0, 1} <= set(ours["closest.geometry_ids"].ravel()) and (ours["compute_signed_distance"] < 0).any()
    edges = ours["closest.primitive_uvs"]  # on edges and corners either triangle may be named
    inside = (edges.min(axis=-1) > 1e-4) & (edges.sum(axis=-1) < 1 - 1e-4)
    assert 10 < theirs["three.occupancy"].sum() < 90
    for name, column in ours.items():
        other = theirs[name]
        assert (column.dtype, column.shape) == (other.dtype, other.shape), name
        if name.startswith("closest.primitive"):
            column, other = column[inside], other[inside]
        if column.dtype == np.float32:
            assert np.allclose(column, other, rtol=1e-4, atol=2e-5), name
        else:
            assert np.array_equal(column, other), name


def test_open3d_as_recorded():
    compare(ask_ours(), open3d_answers.of_json(RECORDED.read_text()))


def test_open3d_live():
    if importlib.util.find_spec("open3d") is None or not Path("/usr/include/embree3").exists():
        pytest.skip("python3-open3d or libembree-dev is not installed")
    theirs = subprocess.run([sys.executable, open3d_answers.__file__], check=True, capture_output=True, text=True).stdout
    compare(ask_ours(), open3d_answers.of_json(theirs))


def test_open3d_tensors_and_meshes_of_tensors():
    o3d = pytest.importorskip("open3d")
    meshes = [(o3d.t.geometry.TriangleMesh(o3d.core.Tensor(vertices), o3d.core.Tensor(faces)),)
              for vertices, faces in open3d_answers.scene_arrays()[0]]
    ours = ask_ours(meshes, o3d.core.Tensor, lambda tensor: tensor.numpy())
    assert all(np.array_equal(column, ours[name]) for name, column in ask_ours().items())


def test_open3d_takes_meshes_that_run_clockwise(mesh, points):
    scene = open3d.RaycastingScene()
    scene.add_triangles(mesh.vertices, np.array(mesh.faces)[:, ::-1])
    assert np.array_equal(scene.compute_occupancy(points), oracles.winding_numbers(mesh, points) > 0.5)
    before = scene.compute_signed_distance(points)
    scene.add_triangles(mesh.vertices + 10, mesh.faces)
    assert np.array_equal(scene.compute_signed_distance(points), before)
    assert scene.compute_occupancy(points + 10).sum() == (before < 0).sum()


def test_open3d_takes_parts_apart():
    """Two balls of triangles without shared corners, each with a degenerate triangle between two others."""
    ball, points = proxima.Mesh.sample("icosphere:2"), np.random.default_rng(3).uniform(-1.2, 1.2, (200, 3))
    points = points[np.abs(np.linalg.norm(points, axis=1) - 0.5) > 0.05]
    outside, cavity = (oracles.winding_numbers(proxima.Mesh(ball.vertices * size, ball.faces), points) < 0.5 for size in (1, 0.5))
    ball = oracles.corners(ball)
    ball = np.concatenate((ball, ball[:1, [0, 0, 1]])).reshape(-1, 3)
    soup = np.concatenate((ball, ball / 2))
    scene = open3d.RaycastingScene()
    scene.add_triangles(soup, np.arange(len(soup)).reshape(-1, 3))
    assert np.array_equal(scene.compute_occupancy(points), ~outside & cavity) and 10 < (~outside & cavity).sum() < 190


def test_open3d_takes_open_parts_together():
    ball, points = proxima.Mesh.sample("icosphere:2"), np.random.default_rng(3).uniform(-1.2, 1.2, (200, 3))
    triangles = oracles.corners(ball)
    triangles[triangles.mean(axis=1)[:, 2] > 0] += [0, 0, 1e-3]
    scene = open3d.RaycastingScene()
    scene.add_triangles(triangles.reshape(-1, 3), np.arange(triangles.size // 3).reshape(-1, 3))
    assert np.array_equal(scene.compute_occupancy(points), oracles.winding_numbers(ball, points) > 0.5)
    # Below a small ball are two large sheets, whose winding number there is nearly -1.
    sheet = np.array([[-20, -20, -1], [20, -20, -1], [20, 20, -1], [-20, 20, -1]])
    scene = open3d.RaycastingScene()
    scene.add_triangles(np.concatenate((ball.vertices / 10, sheet, sheet + [0, 0, 0.01])), np.concatenate(
        (ball.faces, np.array([[0, 1, 2], [0, 2, 3], [4, 5, 6], [4, 6, 7]]) + len(ball.vertices))))
    assert scene.compute_occupancy([[0.01, 0.02, 0.03], [0, 0, 0.5]]).tolist() == [1, 0]


def test_open3d_asks_parts_that_are_apart_in_one_index():
    count = 300
    cube = proxima.Mesh.sample("octahedron")
    at = np.stack(np.meshgrid(*[np.arange(15) * 3.0] * 3), axis=-1).reshape(-1, 1, 3)[:count]
    vertices = (cube.vertices + at).reshape(-1, 3)
    faces = np.array(cube.faces) + np.arange(count)[:, None, None] * len(cube.vertices)
    faces[::2] = faces[::2, :, ::-1]
    scene = open3d.RaycastingScene()
    scene.add_triangles(vertices, faces.reshape(-1, 3))
    assert scene.compute_occupancy(at[:, 0]).all() and not scene.compute_occupancy(at[:, 0] + 1.5).any()
    assert len(scene._signs()._indexes) == 1


def test_open3d_refuses():
    scene = open3d.RaycastingScene()
    with pytest.raises(proxima.InvalidInput, match="the scene has no triangles"):
        scene.compute_distance(np.zeros((1, 3)))
    scene.add_triangles(proxima.Mesh.sample("cube"))
    with pytest.raises(proxima.InvalidInput, match=r"rays: must have shape \(.., 6\)"):
        scene.cast_rays(np.zeros((2, 3)))
    with pytest.raises(proxima.InvalidInput, match="query_points"):
        scene.compute_distance(np.zeros(3))
    with pytest.raises(proxima.InvalidInput, match="mesh: must be an open3d.t.geometry.TriangleMesh, .*, is None") as error:
        scene.add_triangles(None)
    assert error.value.code == "invalid_argument"
    legacy = SimpleNamespace(vertices=np.zeros((3, 3)), triangles=np.zeros((1, 3), "i4"))
    with pytest.raises(proxima.InvalidInput, match=r"from_legacy\(mesh\)\), is types.SimpleNamespace"):
        scene.add_triangles(legacy)
    for adapter in (trimesh.ProximityQuery, trimesh.RayMeshIntersector):
        with pytest.raises(proxima.InvalidInput, match="mesh: must be a proxima.Mesh, or .* trimesh.Trimesh has, is str"):
            adapter("mesh")
    with pytest.raises(proxima.InvalidInput, match="intrinsic_matrix: must have an inverse"):
        scene.create_rays_pinhole(np.zeros((3, 3)), np.eye(4), 2, 2)
    with pytest.raises(proxima.InvalidInput, match=r"extrinsic_matrix: .* shape \(4, 4\), has shape \(3, 4\)"):
        scene.create_rays_pinhole(np.eye(3), np.eye(4)[:3], 2, 2)
    for view in ((60, [0, 0, 1], [0, 0, 1], [0, 1, 0]), (60, [0, 0, 1], [0, 0, 2], [0, 0, 1]), (0, [0, 0, 1], [0, 0, 2], [0, 1, 0])):
        with pytest.raises(proxima.InvalidInput, match="center: must not be at eye"):
            scene.create_rays_pinhole(*view, 2, 2)


def test_open3d_takes_geometries_without_triangles():
    scene = open3d.RaycastingScene()
    assert scene.add_triangles(np.zeros((3, 3)), np.zeros((0, 3), "i4")) == 0
    with pytest.raises(proxima.InvalidInput, match="the scene has no triangles"):
        scene.compute_signed_distance(np.zeros((1, 3)))
    assert scene.add_triangles(mesh=proxima.Mesh.sample("cube")) == 1
    assert scene.compute_signed_distance(np.zeros((1, 3))) < 0
    assert scene.cast_rays([[0.1, 0.2, 5, 0, 0, -1]])["geometry_ids"] == 1


def test_open3d_answers_tensors_of_other_libraries_by_arrays():
    scene = open3d.RaycastingScene()
    scene.add_triangles(proxima.Mesh.sample("cube"))
    other = SimpleNamespace(numpy=lambda: np.zeros((2, 3)))  # as torch's: has numpy(), no from_numpy()
    assert scene.compute_occupancy(other).tolist() == [1, 1]


def test_nothing_else_is_imported():
    code = ("import sys, proxima.compat.trimesh, proxima.compat.open3d, proxima.compat.igl\n"
            "assert not {'trimesh', 'open3d', 'igl', 'scipy'} & set(sys.modules)")
    subprocess.run([sys.executable, "-c", code], check=True)
