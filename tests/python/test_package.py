"""The package as a whole: docs, size, what it links, its wheel."""
import os
import pickle
import re
import subprocess
import sys
import zipfile
from pathlib import Path

import numpy as np
import pytest

import proxima

ROOT = Path(__file__).resolve().parents[2]
PACKAGE = Path(proxima.__file__).parent
MODULE = next(PACKAGE.glob("_core*.so"))


def members():
    for name in proxima.__all__:
        thing = getattr(proxima, name)
        if callable(thing):
            yield name, thing
        if isinstance(thing, type) and not issubclass(thing, BaseException):
            for attribute, value in vars(thing).items():
                if not attribute.startswith("_") and (callable(value) or isinstance(value, (property, staticmethod))):
                    yield f"{name}.{attribute}", getattr(thing, attribute)


def test_everything_is_documented():
    counts = {"Index.triangle_count", "Index.vertex_count", "Index.edge_count", "Index.has_lists", "Index.has_distances",
              "Index.has_signs"}
    assert [name for name, thing in members() if not (thing.__doc__ or "").strip() and name not in counts] == []


def test_names_are_those_of_the_package():
    assert {name for name in vars(proxima) if not name.startswith("_")} == set(proxima.__all__) - {"__version__"}
    for name in proxima.__all__:
        if callable(getattr(proxima, name)):
            assert getattr(proxima, name).__module__ == "proxima", name


def test_the_example_of_the_docs_runs(tmp_path):
    pages = [ROOT / "docs/python.md", ROOT / "README.md"]
    for page in pages:
        for number, code in enumerate(re.findall(r"```python\n(.*?)```", page.read_text(), re.DOTALL)):
            done = subprocess.run([sys.executable, "-c", code], cwd=tmp_path, capture_output=True, text=True)
            assert done.returncode == 0, f"{page.name}, program {number}:\n{code}\n{done.stderr}"


EXAMPLES = {
    "volume_by_signed_distances": r"by counting:  (2\.\d+|3\.\d+|4\.\d+)", "thickness_of_walls": r"thickness: 0\.\d+ at least",
    "clearance_of_a_moving_part": r"first contact at x = \d\.\d+: \d+ pairs",
    "what_is_wrong_with_a_mesh": r"^not watertight\nwarning: 6 boundary edges, the first at \[\[.*\n.*3 inconsistent edges",
    "repair_a_mesh": r"weld vertices: 4000\norient pieces: 4\d\d\nclosed: False before, True after; volume 4\.83",
    "signed_distances_on_a_grid": r"change by (1\.00|0\.99)\d per unit of length, 4\.9\d+ of the volume",
    "where_two_parts_meet": r"along 2 lines, 2 of them closed, of length 10\.99(.*\n)+.*apart by 6\.2\d+, contained: none",
    "what_a_camera_sees": r"^\d+ of 10000 triangles are in view\n(.*\n)*.*@@@", "x_ray_of_a_mesh": r"; volume 4\.9\d+",
    "octree_in_numpy": r"inner: \d+ leaves, 2\.8\d+ of the volume(.*\n)+a ray along x goes through 22 leaves, 1\.875",
    "a_scene_of_many_copies": r"1000 instances of 1 shapes(.*\n)+\d+% of the rays hit(.*\n)+\d+ pairs meet, \d+ are within(.*\n)+after all",
    "contact_for_physics": r"free until 0\.\d+, intersection at(.*\n)+at the end \d\.\d+ to \d\.\d+ deep \(bounds\)\n  region 0 at(.*\n)+.*overlap: False",
    "feel_a_surface_along_a_path": r"  300 ms   0\.000 N  free\n(.*\n)*.*1200 ms   0\.9\d+ N  sliding"}


def test_every_example_is_run():
    names = {path.stem for path in (ROOT / "examples").glob("*.py")}
    assert names == set(EXAMPLES) | {"engine_client"}  # which the tests of the program run


@pytest.mark.parametrize("name, says", EXAMPLES.items())
def test_examples_run(name, says):
    path = ROOT / f"examples/{name}.py"
    assert len(path.read_text().splitlines()) < 40
    for mesh in ([], [ROOT / "examples/tetrahedron.off"]):
        done = subprocess.run([sys.executable, "-W", "error", path, *mesh], capture_output=True, text=True)
        assert done.returncode == 0, done.stderr
        assert mesh or re.search(says, done.stdout), done.stdout


@pytest.mark.parametrize("name, out, written", [
    ("repair_a_mesh", "a.ply", ["a.ply"]), ("signed_distances_on_a_grid", "a.npz", ["a.npz"]),
    ("octree_in_numpy", "", ["octree.htg", "octree.vtu"])])
def test_examples_write_files(tmp_path, name, out, written):
    subprocess.run([sys.executable, "-W", "error", ROOT / f"examples/{name}.py", ROOT / "examples/tetrahedron.off", tmp_path / out],
                   check=True, capture_output=True)
    assert sorted(path.name for path in tmp_path.iterdir()) == written


def test_the_module_is_small_and_exports_its_beginning_only():
    assert MODULE.stat().st_size < 5_000_000  # with symbols or assimp it would have several times as much
    listed = subprocess.run(["nm", "-D", "--defined-only", MODULE], capture_output=True, text=True, check=True).stdout
    assert [line.split()[-1] for line in listed.splitlines()] == ["PyInit__core"]


def test_the_module_does_without_assimp():
    listed = subprocess.run(["readelf", "-d", MODULE], capture_output=True, text=True, check=True).stdout
    assert "libhwy" in listed and "assimp" not in listed


def test_the_version_is_the_project_s():
    version = re.search(r"project\(proxima VERSION ([\d.]+)", (ROOT / "CMakeLists.txt").read_text())[1]
    assert proxima.__version__ == version


def test_the_wheel_works_elsewhere(tmp_path):
    sys.path.insert(0, str(ROOT / "python"))
    import build_wheel

    name = build_wheel.build_wheel(str(tmp_path), {"build-dir": os.environ["PROXIMA_BUILD"]})
    assert re.fullmatch(r"proxima-[\d.]+-cp3\d+-cp3\d+-linux_\w+\.whl", name)
    with zipfile.ZipFile(tmp_path / name) as wheel:
        wheel.extractall(tmp_path / "site")
    for name in ("_results.py", "py.typed", "_core.pyi", "_results.pyi", "compat/open3d.py"):
        assert (tmp_path / "site/proxima" / name).exists()
    answer = subprocess.run([sys.executable, "-c", "import proxima; print(proxima.__file__, proxima.Mesh.sample('cube'))"],
                            env={"PYTHONPATH": str(tmp_path / "site"), "PYTHONDONTWRITEBYTECODE": "1"}, cwd=tmp_path,
                            capture_output=True, text=True, check=True).stdout
    assert str(tmp_path) in answer and "8 vertices" in answer


class OfYourOwn(proxima.Mesh):
    """A subclass, of which pickle wants the name."""


def test_what_pickles_keep():
    """As docs/python.md says."""
    points = np.random.default_rng(6).normal(size=(400, 3))
    body = proxima.Polyhedron(points)
    again = pickle.loads(pickle.dumps(body))
    assert np.array_equal(again.vertices, body.vertices) and len(body.vertices) < 400
    planes, same_planes = (np.unique(of.half_spaces.round(12), axis=0) for of in (body, again))
    assert np.array_equal(planes, same_planes) and len(planes) == len(body.half_spaces)
    mine = OfYourOwn(points, [[0, 1, 2]])
    mine.note = "mine"
    again = pickle.loads(pickle.dumps(mine))
    assert type(again) is OfYourOwn and again.fingerprint == mine.fingerprint and not hasattr(again, "note")


def test_facets_of_flat_sums():
    """-1 where the sum is a point or a segment, as SumDistances says; a polygon has two."""
    origin, along, across = (proxima.Polyhedron(points) for points in ([[0, 0, 0]], [[0, 0, 0], [1, 0, 0]], [[0, 0, 0], [0, 1, 0]]))
    for a, b, dimension in ((origin, origin, 0), (origin, along, 1), (along, along, 1), (along, across, 2)):
        total = proxima.minkowski_sum(a, b)
        found = total.signed_distance([[0.5, 0.5, 3], [0.5, 0.5, -3], [5, 0, 0]])
        assert total.dimension == dimension and ((found.facet >= 0) == (dimension == 2)).all() and found.facet.min() >= -1
    assert "-1 for a sum that is a point or a segment" in proxima.SumDistances.facet.__doc__


def test_numbers_of_numpy_are_taken_as_options():
    index = proxima.Index(proxima.Mesh.sample("cube"), threads=np.int64(1))
    assert len(index.within([[0, 0, 0]], np.float32(2)).triangle) == 12
