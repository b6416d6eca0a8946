"""The programs in Python of docs/coming_from.md: each pair gives the same answers, where the other library is installed.
And the numbers of libigl's names."""
import importlib.util
import re
from pathlib import Path

import numpy as np
import pytest

import proxima
from proxima.compat import igl

PAGE = (Path(__file__).resolve().parents[2] / "docs/coming_from.md").read_text()
SECTIONS = {heading: re.findall(r"```python\n(.*?)```", text, re.DOTALL)
            for heading, text in re.findall(r"^## (.*?)\n(.*?)(?=^## |\Z)", PAGE, re.DOTALL | re.MULTILINE)}
PAIRS = {"Open3D": "open3d", "trimesh": "trimesh", "libigl": "igl", "FCPW": "fcpw"}


def given():
    """What a program of the page begins with."""
    mesh = proxima.Mesh.sample("torus:60x40")
    random = np.random.default_rng(4)
    points = random.uniform(-1.6, 1.6, (500, 3)) * [1, 1, 0.4]
    return {"vertices": np.array(mesh.vertices), "faces": np.array(mesh.faces), "points": points}


def run(program):
    names = given()
    exec(compile(program, "docs/coming_from.md", "exec"), names)
    return names


def test_each_library_has_two_programs():
    assert {heading: len(programs) for heading, programs in SECTIONS.items() if programs} == dict.fromkeys(PAIRS, 2)


def torus(points):
    """The signed distance from the torus that the mesh stands for."""
    return np.hypot(np.hypot(points[:, 0], points[:, 1]) - 1, points[:, 2]) - 0.5


@pytest.mark.parametrize("library", PAIRS)
def test_ours_is_right(library):
    names = run(SECTIONS[library][1])
    truth = torus(names["points"])
    wanted = {"Open3D": np.abs(truth), "trimesh": -truth, "libigl": truth, "FCPW": np.abs(truth)}[library]
    assert np.abs(names["distances"] - wanted).max() < 0.01
    if "inside" in names:
        sure = np.abs(truth) > 0.01
        assert np.array_equal(names["inside"][sure], truth[sure] < 0) and names["inside"].any()
    if "closest" in names:
        assert np.abs(torus(names["closest"])).max() < 0.01


@pytest.mark.parametrize("library", PAIRS)
def test_theirs_says_the_same(library):
    theirs, ours = SECTIONS[library]
    compile(theirs, "docs/coming_from.md", "exec")
    if importlib.util.find_spec(PAIRS[library]) is None:
        pytest.skip(f"{library} is not installed")
    other, own = run(theirs), run(ours)
    for name in ("distances", "closest", "squared"):
        if name in own:
            assert np.abs(own[name] - other[name]).max() < 1e-4, name  # theirs are floats
    if "inside" in own:
        assert np.array_equal(own["inside"], other["inside"])


def test_libigl_s_numbers_are_taken_for_its_names():
    """Those of its enum SignedDistanceType."""
    for number, name in enumerate(("PSEUDONORMAL", "WINDING_NUMBER", "DEFAULT", "UNSIGNED", "FAST_WINDING_NUMBER")):
        assert getattr(igl, f"SIGNED_DISTANCE_TYPE_{name}") == number
    vertices, faces, points = given().values()
    truth = torus(points)
    sure = np.abs(truth) > 0.01
    for number in range(5):
        answers = igl.signed_distance(points.astype("f4"), vertices, faces.astype("i4"), number)
        assert [column.dtype for column in answers] == ["f4", "i4", "f4"]
        assert np.array_equal(answers[0][sure] < 0, truth[sure] < 0) == (number != 3)
