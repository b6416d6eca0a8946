import json
import os
import subprocess

import numpy as np
import pytest

import proxima


def index_of(name):
    return proxima.Index(proxima.Mesh.sample(name))


def test_parallel_squares_are_as_far_apart_as_they_are():
    square = [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]]
    faces = [[0, 1, 2], [0, 2, 3]]
    one = proxima.Index(proxima.Mesh(square, faces))
    other = proxima.Index(proxima.Mesh(np.add(square, [0, 0, 0.25]), faces))
    found = one.deviation(other)
    for lower, upper in (found.greatest, found.mean, found.root_mean_square):
        assert lower <= 0.25 <= upper and upper - lower < 1e-4
    assert found.point[2] == 0 and found.closest[2] == 0.25


def test_intervals_hold_what_samples_say():
    coarse, fine = index_of("icosphere:1"), index_of("icosphere:3")
    found = coarse.deviation(fine, threads=1)
    mesh = proxima.Mesh.sample("icosphere:1")
    corners = mesh.vertices[mesh.faces]
    weights = np.random.default_rng(3).dirichlet(np.ones(3), (len(corners), 400))
    samples = np.einsum("fsk,fkx->fsx", weights, corners)
    distances = fine.closest(samples.reshape(-1, 3)).distance.reshape(len(corners), -1)
    assert distances.max() <= found.greatest[1]
    assert distances.max() > 0.98 * found.greatest[0]
    areas = np.linalg.norm(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1)
    mean = np.average(distances.mean(axis=1), weights=areas)
    assert found.mean[0] - 2e-4 < mean < found.mean[1] + 2e-4  # of 32,000 samples
    assert np.isclose(np.linalg.norm(found.point - found.closest), found.greatest[0], atol=1e-5)


def test_leaves_the_mean_out():
    found = index_of("cube").deviation(index_of("icosphere:2"), mean=False)
    assert found.mean is None and found.root_mean_square is None and found.greatest[0] > 0.7


def test_names_all_places_that_are_as_far():
    inner = proxima.Mesh.sample("cube")
    center = inner.vertices.mean(axis=0)
    outer = proxima.Mesh(center + 3 * (inner.vertices - center), inner.faces)
    found = proxima.Index(outer).deviation(proxima.Index(inner), mean=False, max_places=20)
    places = found.places
    corners = {tuple(corner) for corner in outer.vertices}
    assert {tuple(point) for point in places.point} == corners and len(places.point) == 8 and found.all_places is True
    assert np.allclose(places.closest, center + (places.point - center) / 3)
    assert np.allclose(places.distance, np.linalg.norm(outer.vertices[0] - inner.vertices[0]), rtol=1e-12)
    for triangle, point in zip(places.triangle, places.point):
        assert tuple(point) in {tuple(corner) for corner in outer.vertices[outer.faces[triangle]]}
    fewer = proxima.Index(outer).deviation(proxima.Index(inner), mean=False, max_places=3)
    assert len(fewer.places.point) == 3 and fewer.all_places is False
    wide = proxima.Index(outer).deviation(proxima.Index(inner), mean=False, max_places=20, place_spacing=1e9)
    assert len(wide.places.point) == 1


def slope_and_plane():
    """A square whose points are 0 to 0.5 above a plane, evenly by area."""
    faces = [[0, 1, 2], [0, 2, 3]]
    slope = proxima.Mesh([[0, 0, 0], [1, 0, 0.5], [1, 1, 0.5], [0, 1, 0]], faces)
    return proxima.Index(slope), proxima.Index(proxima.Mesh([[-9, -9, 0], [9, -9, 0], [9, 9, 0], [-9, 9, 0]], faces))


def test_histograms_of_an_even_slope_are_flat():
    slope, plane = slope_and_plane()
    found = slope.deviation(plane, bins=5)
    assert np.allclose(found.histogram, 0.2, atol=0.01) and found.histogram_end == found.greatest[1]
    assert abs(found.area - np.sqrt(1.25)) <= found.area_error < 1e-12 and found.complete is True and found.mean_complete is True
    assert found.mean[0] <= 0.25 <= found.mean[1] and found.root_mean_square[0] <= 0.5 / np.sqrt(3) <= found.root_mean_square[1]
    assert np.allclose(slope.deviation(plane, bins=4, histogram_end=1).histogram, [0.5, 0.5, 0, 0], atol=0.01)
    assert np.allclose(slope.deviation(plane, bins=2, histogram_end=0.125).histogram, [0.125, 0.875], atol=0.01)
    none = plane.deviation(plane, bins=4)
    assert none.histogram is None and none.histogram_end is None and none.greatest.tolist() == [0, 0]


def test_both_ways_weigh_by_area_or_take_the_larger():
    slope, plane = slope_and_plane()
    there, back = slope.deviation(plane), plane.deviation(slope)
    both = proxima.both_ways(there, back)
    assert both.greatest.tolist() == np.maximum(there.greatest, back.greatest).tolist()
    assert both.larger_mean.tolist() == back.mean.tolist() and both.larger_root_mean_square.tolist() == back.root_mean_square.tolist()
    weights = np.array([there.area, back.area]) / (there.area + back.area)
    assert np.allclose(both.mean, weights @ [there.mean, back.mean], rtol=1e-9)
    assert np.allclose(both.root_mean_square, np.sqrt(weights @ np.square([there.root_mean_square, back.root_mean_square])), rtol=1e-9)
    without = proxima.both_ways(slope.deviation(plane, mean=False), back)
    assert without.greatest.tolist() == both.greatest.tolist() and without.mean is None and without.larger_mean is None


@pytest.mark.skipif("PROXIMA_PROGRAM" not in os.environ, reason="built without the program")
def test_says_what_the_program_says():
    names = "icosphere:2", "torus:24x12"
    done = subprocess.run([os.environ["PROXIMA_PROGRAM"], "deviation", *names, "--places", "9", "--place-spacing", "0.2", "--bins", "7",
                           "--tolerance", "0.001", "--mean-tolerance", "0.001", "--quiet", "--json", "-"], capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    program = json.loads(done.stdout)
    a, b = map(index_of, names)
    ways = [one.deviation(other, max_places=9, place_spacing=0.2, bins=7, histogram_end=program["histogram_end"], tolerance=1e-3,
                          mean_tolerance=1e-3) for one, other in ((a, b), (b, a))]
    for ours, theirs in zip(ways, (program["a_to_b"], program["b_to_a"])):
        for field, key in {"greatest": "greatest", "point": "point_a", "closest": "point_b", "mean": "mean",
                           "root_mean_square": "root_mean_square", "histogram": "histogram"}.items():
            assert getattr(ours, field).tolist() == theirs[key]
        for field, key in {"triangle": "triangle_a", "other_triangle": "triangle_b", "complete": "complete", "area": "area",
                           "mean_complete": "mean_complete", "all_places": "all_places"}.items():
            assert getattr(ours, field) == theirs[key]
        for field, key in {"distance": "distance", "point": "point_a", "closest": "point_b", "triangle": "triangle_a",
                           "other_triangle": "triangle_b"}.items():
            assert getattr(ours.places, field).tolist() == [place[key] for place in theirs["places"]]
    both = proxima.both_ways(*ways)
    assert both.greatest.tolist() == program["hausdorff"]
    assert {field: getattr(both, field).tolist() for field in both._fields[1:]} == program["both_ways"]


def test_stops_after_max_splits():
    a, b = index_of("cube"), index_of("torus:24x12")
    full = a.deviation(b)
    stopped = a.deviation(b, tolerance=1e-12, mean_tolerance=1e-12, max_splits=1)
    assert full.complete is True and stopped.complete is False and stopped.mean_complete is False
    assert stopped.greatest[0] <= full.greatest[1] and full.greatest[0] <= stopped.greatest[1]


@pytest.mark.parametrize("argument, says", [
    ({"max_places": 257}, "max_places.*256"), ({"max_places": -1}, "max_places.*256"), ({"bins": 4097}, "bins.*4096"),
    ({"bins": 2, "mean": False}, "bins.*mean"), ({"bins": 2, "histogram_end": -1}, "histogram_end"),
    ({"bins": 2, "histogram_end": np.nan}, "histogram_end"), ({"max_places": 1, "place_spacing": -1}, "spacing"),
    ({"mean_tolerance": np.nan}, "tolerance")])
def test_refuses_arguments_that_make_no_sense(argument, says):
    with pytest.raises(proxima.InvalidInput, match=says):
        index_of("icosphere:1").deviation(index_of("cube"), **argument)


def test_both_ways_takes_deviations_only():
    one = index_of("cube").deviation(index_of("icosphere:1"))
    with pytest.raises(proxima.InvalidInput, match="greatest"):
        proxima.both_ways(one._replace(greatest=[1, 2, 3]), one)
    with pytest.raises((TypeError, AttributeError)):
        proxima.both_ways(one, 3)


def test_refuses_tolerances_that_are_none():
    with pytest.raises(proxima.InvalidInput, match="tolerance"):
        index_of("cube").deviation(index_of("cube"), tolerance=-1)


def test_can_be_stopped():
    with pytest.raises(proxima.Cancelled):
        index_of("icosphere:5").deviation(index_of("icosphere:6"), mean_tolerance=1e-9, progress=lambda stage, part: False)
