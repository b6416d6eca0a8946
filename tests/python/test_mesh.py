import copy
import gc
import pickle
from pathlib import Path

import numpy as np
import pytest

import proxima

VERTICES = [[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]]
FACES = [[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]]


@pytest.mark.parametrize("dtype", ["f4", "f8", ">f8", "i2", "u8"])
@pytest.mark.parametrize("index_dtype", ["i1", "u1", "i4", "u4", "i8", "u8", ">i4"])
def test_takes_numbers_of_any_type(dtype, index_dtype):
    mesh = proxima.Mesh(np.array(VERTICES, dtype), np.array(FACES, index_dtype))
    assert np.array_equal(mesh.vertices, VERTICES) and np.array_equal(mesh.faces, FACES)


def test_takes_any_memory_order():
    vertices = np.asfortranarray(VERTICES, "f8")
    faces = np.repeat(np.array(FACES), 2, axis=1)[:, ::2]
    mesh = proxima.Mesh(vertices, faces[::-1])
    assert np.array_equal(mesh.vertices, VERTICES) and np.array_equal(mesh.faces, FACES[::-1])


def test_takes_unaligned_arrays():
    raw = b"x" + np.array(VERTICES, "f8").tobytes()
    mesh = proxima.Mesh(np.frombuffer(raw, "f8", offset=1).reshape(-1, 3), FACES)
    assert np.array_equal(mesh.vertices, VERTICES)


def test_takes_lists():
    assert repr(proxima.Mesh(VERTICES, FACES)) == "<proxima.Mesh: 4 vertices, 4 triangles>"


@pytest.mark.parametrize("vertices, faces, says", [
    ([0, 0, 0], FACES, r"vertices: must have shape \(n, 3\), has \(3,\)"),
    (np.zeros((4, 2)), FACES, r"vertices: must have shape \(n, 3\), has \(4, 2\)"),
    (np.zeros((4, 3), complex), FACES, "vertices: must be an array of numbers, has dtype complex128"),
    (np.zeros((4, 3), bool), FACES, "vertices: must be an array of numbers, has dtype bool"),
    ("text", FACES, "vertices: must be an array of numbers, has dtype <U4"),
    (None, FACES, "vertices: must be an array of numbers"),
    (VERTICES, np.array(FACES, float), "faces: must be an array of integers, has dtype float64"),
    (VERTICES, [[0, 1]], r"faces: must have shape \(n, 3\), has \(1, 2\)"),
    (VERTICES, [[0, 1, 2], [0, -1, 2]], "faces: triangle 1 has the vertex index -1"),
    (VERTICES, [[0, 1, 2**40]], "faces: triangle 0 has the vertex index 1099511627776"),
    (VERTICES, [[0, 1, 4]], "4"),
])
def test_refuses_what_is_no_mesh(vertices, faces, says):
    with pytest.raises(proxima.InvalidInput, match=says) as caught:
        proxima.Mesh(vertices, faces)
    assert isinstance(caught.value, ValueError) and isinstance(caught.value, proxima.Error)
    assert caught.value.code in ("invalid_argument", "invalid_mesh")


def test_arrays_are_views_that_keep_the_mesh_alive():
    mesh = proxima.Mesh.sample("sphere:20x20")
    vertices, faces = mesh.vertices, mesh.faces
    expected = vertices.copy(), faces.copy()
    assert np.shares_memory(vertices, mesh.vertices)
    with pytest.raises(ValueError):
        vertices[0, 0] = 3
    del mesh
    gc.collect()
    assert np.array_equal(vertices, expected[0]) and np.array_equal(faces, expected[1])


@pytest.mark.parametrize("name", ["a.obj", "a.ply", "a.stl", "a.off"])
def test_reads_what_it_writes(tmp_path, mesh, name):
    mesh.write(tmp_path / name)
    read = proxima.Mesh.read(str(tmp_path / name))
    assert len(read.faces) == len(mesh.faces)
    assert np.allclose(read.vertices[read.faces], mesh.vertices[mesh.faces], atol=1e-6)


@pytest.mark.skipif(not list(Path(proxima.__file__).parent.glob("libproxima_scenes*")), reason="built without assimp")
def test_reads_points_and_lines():
    text = b"v 0 0 0\nv 1 0 0\nl 1 2\np 2\n"
    assert len(proxima.Mesh.from_bytes(text, "obj").faces) == 0
    lines = proxima.Mesh.from_bytes(text, "obj", points_and_lines=True)
    assert np.array_equal(lines.faces, [[0, 1, 1], [1, 1, 1]])


def test_reads_points_and_lines_of_a_file(tmp_path):
    (tmp_path / "a.obj").write_text("v 0 0 0\nv 1 0 0\nl 1 2\np 2\n")
    assert len(proxima.Mesh.read(tmp_path / "a.obj").faces) == 0
    assert proxima.Mesh.read(tmp_path / "a.obj", points_and_lines=True).faces.tolist() == [[0, 1, 1], [1, 1, 1]]


def test_finds_the_closest_points_of_a_cloud(tmp_path):
    points = np.random.default_rng(5).normal(size=(500, 3))
    np.savetxt(tmp_path / "cloud.xyz", points, fmt="%.17g")
    index = proxima.Index(proxima.Mesh.read(tmp_path / "cloud.xyz"))
    asked = np.random.default_rng(6).normal(size=(200, 3))
    distances = np.linalg.norm(asked[:, None] - points, axis=2)
    found = index.closest(asked)
    assert np.array_equal(found.triangle, distances.argmin(axis=1))
    assert np.allclose(found.distance, distances.min(axis=1), rtol=1e-14)


def test_reads_scenes():
    scene = proxima.Mesh.read("fuzz/corpus/glb/two_tetrahedra.glb")
    assert len(scene.faces) == 8


def test_file_errors(tmp_path):
    with pytest.raises(proxima.FileMissing, match="none.obj") as caught:
        proxima.Mesh.read(tmp_path / "none.obj")
    assert isinstance(caught.value, FileNotFoundError) and caught.value.code == "file_not_found"
    (tmp_path / "bad.obj").write_text("v 0 0 0\nf 1 2 3\n")
    with pytest.raises(proxima.InvalidInput, match="bad.obj:2"):
        proxima.Mesh.read(tmp_path / "bad.obj")
    with pytest.raises(proxima.FileNotWritable) as caught:
        proxima.Mesh.sample("cube").write(tmp_path / "no" / "folder.obj")
    assert isinstance(caught.value, OSError)


@pytest.mark.parametrize("code, kind, ask", [
    ("invalid_argument", proxima.InvalidInput, lambda cube: cube.part([12])),
    ("file_not_found", proxima.FileMissing, lambda cube: proxima.Mesh.read("none.obj")),
    ("file_not_writable", proxima.FileNotWritable, lambda cube: cube.write("no/folder.obj")),
    ("unsupported_format", proxima.InvalidInput, lambda cube: cube.write("a.dae")),
    ("malformed_file", proxima.InvalidInput, lambda cube: proxima.Mesh.from_bytes(b"v 0 0 0\nf 1 2 3\n", "obj")),
    ("invalid_mesh", proxima.InvalidInput, lambda cube: proxima.Index(proxima.Mesh(cube.vertices * np.nan, cube.faces))),
    ("limit_exceeded", proxima.LimitExceeded, lambda cube: proxima.Mesh.sample("sphere:100000x100000")),
    ("budget_exceeded", proxima.LimitExceeded, lambda cube: proxima.Octree(cube, max_depth=19, threshold=0, uniform=True)),
    ("cancelled", proxima.Cancelled, lambda cube: proxima.Index(proxima.Mesh.sample("icosphere:6"), lists=True, progress=lambda *_: False))])
def test_errors_have_the_code_of_their_kind(code, kind, ask):
    with pytest.raises(kind) as caught:
        ask(proxima.Mesh.sample("cube"))
    assert caught.value.code == code


def test_bounds_and_copies(mesh):
    assert np.array_equal(mesh.bounds, [mesh.vertices.min(0), mesh.vertices.max(0)])
    assert copy.copy(mesh) is mesh and copy.deepcopy([mesh])[0] is mesh
    other = pickle.loads(pickle.dumps(mesh))
    assert np.array_equal(other.vertices, mesh.vertices) and np.array_equal(other.faces, mesh.faces)


@pytest.mark.parametrize("name", ["obj", "ply", "stl", "off"])
def test_reads_bytes_as_it_reads_files(tmp_path, mesh, name):
    path = tmp_path / f"a.{name}"
    mesh.write(path)
    for data in (path.read_bytes(), bytearray(path.read_bytes()), np.fromfile(path, "u1"), memoryview(path.read_bytes())):
        read = proxima.Mesh.from_bytes(data, name)
        assert read.fingerprint == proxima.Mesh.read(path).fingerprint


def test_welds_as_asked(tmp_path, mesh):
    mesh.write(tmp_path / "a.stl")
    counts = [len(proxima.Mesh.read(tmp_path / "a.stl", weld=weld).vertices) for weld in (None, True, False)]
    assert counts == [len(mesh.vertices)] * 2 + [3 * len(mesh.faces)]
    data = (tmp_path / "a.stl").read_bytes()
    assert len(proxima.Mesh.from_bytes(data, "stl", weld=False).vertices) == counts[2]


def test_writes_text(tmp_path, mesh):
    for name, begins in (("a.ply", b"ply\nformat ascii"), ("a.stl", b"solid")):
        mesh.write(tmp_path / name, ascii=True)
        assert (tmp_path / name).read_bytes().startswith(begins)
        assert np.array_equal(proxima.Mesh.read(tmp_path / name).vertices, mesh.vertices) or name == "a.stl"


@pytest.mark.parametrize("data, format, says", [
    (b"v 0 0 0\nf 1 2 3\n", "obj", "OBJ data:2"), (b"solid", "dae", 'format: must be one of .*obj.* without the dot, is "dae"'),
    (np.zeros((4, 4), "u1")[:, ::2], "obj", "data: must be contiguous")])
def test_refuses_bytes(data, format, says):
    with pytest.raises(proxima.InvalidInput, match=says):
        proxima.Mesh.from_bytes(data, format)


def test_fingerprints(mesh):
    assert mesh.fingerprint == proxima.Mesh(mesh.vertices, mesh.faces).fingerprint == proxima.Index(mesh).fingerprint
    assert mesh.fingerprint != proxima.Mesh(mesh.vertices, mesh.faces[::-1]).fingerprint
