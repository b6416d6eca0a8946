import pickle

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra import numpy as arrays

import proxima

BOX = proxima.Polyhedron.box([0, 0, 0], [1, 2, 3])


def test_sum_of_boxes_is_a_box():
    total = proxima.minkowski_sum(BOX, proxima.Polyhedron.box([-1, -1, -1], [1, 1, 1]))
    assert sorted(map(tuple, total.vertices)) == sorted(
        (x, y, z) for x in (-1.0, 2.0) for y in (-1.0, 3.0) for z in (-1.0, 4.0))
    assert np.diff(total.facets.first).tolist() == [4] * 6 and total.dimension == 3
    assert total.contains([[2, 3, 4], [2.1, 0, 0], [0, 0, 0]]).tolist() == [True, False, True]
    found = total.signed_distance([[0, 0, 0], [5, 0, 0]])
    assert found.distance.tolist() == [-1, 3] and found.nearest[1].tolist() == [2, 0, 0]
    assert repr(total) == "<proxima.MinkowskiSum: 8 vertices, 6 facets>"


def test_distances_name_the_facet():
    total = proxima.minkowski_sum(BOX, proxima.Polyhedron.box([-1, -1, -1], [1, 1, 1]))  # from -1, -1, -1 to 2, 3, 4
    found = total.signed_distance([[0.5, 2.5, 1], [0.5, 1, -3], [4, 1, 1]])
    assert found.distance.tolist() == [-0.5, 2, 2] and found.nearest.tolist() == [[0.5, 3, 1], [0.5, 1, -1], [2, 1, 1]]
    assert found.direction.tolist() == [[0, 1, 0], [0, 0, -1], [1, 0, 0]]
    assert total.half_spaces[found.facet].tolist() == [[0, 1, 0, 3], [0, 0, -1, 1], [1, 0, 0, 2]]


def test_facets_lie_in_their_half_spaces():
    hull = proxima.Polyhedron(np.random.default_rng(3).normal(size=(40, 3)))
    first, loops = hull.facets
    for facet, (x, y, z, d) in enumerate(hull.half_spaces):
        heights = hull.vertices @ [x, y, z] - d
        assert heights.max() < 1e-12
        assert np.abs(heights[loops[first[facet]:first[facet + 1]]]).max() < 1e-12


COORDINATES = st.integers(-4, 4).map(float)


@given(arrays.arrays("f8", (7, 3), elements=COORDINATES), arrays.arrays("f8", (6, 3), elements=COORDINATES))
def test_every_sum_of_points_is_in_the_sum(a, b):
    total = proxima.minkowski_sum(proxima.Polyhedron(a), proxima.Polyhedron(b))
    sums = (a[:, None] + b).reshape(-1, 3)
    assert total.contains(sums).all()
    # And no vertex is anything else.
    assert {tuple(v) for v in total.vertices} <= {tuple(v) for v in sums}


def test_separation():
    other = proxima.Polyhedron.box([4, 0, 0], [5, 2, 3])
    distance, direction = proxima.separation(BOX, other)
    assert distance == 3 and direction.tolist() == [1, 0, 0]
    distance, direction = proxima.separation(BOX, proxima.Polyhedron.box([0.9, 0, 0], [5, 2, 3]))
    assert distance == pytest.approx(-0.1) and direction.tolist() == [1, 0, 0]


def test_polyhedra_of_meshes_and_pickles():
    cube = proxima.Polyhedron.of_mesh(proxima.Mesh.sample("cube"))
    assert cube.dimension == 3 and len(cube.vertices) == 8
    assert np.array_equal(pickle.loads(pickle.dumps(cube)).vertices, cube.vertices)
    assert np.array_equal(np.sort(cube.mirrored().vertices, 0), np.sort(-cube.vertices, 0))
    for bad in (np.zeros((0, 3)), [[np.nan, 0, 0]], np.zeros(3)):
        with pytest.raises(proxima.InvalidInput):
            proxima.Polyhedron(bad)
    with pytest.raises(proxima.InvalidInput):
        proxima.Polyhedron.of_mesh(proxima.Mesh.sample("torus:8x8"))
    with pytest.raises(proxima.InvalidInput, match="point 1 is not finite"):
        proxima.minkowski_sum(cube, cube).contains([[0, 0, 0], [0, 0, np.inf]])


def test_a_sum_cannot_be_pickled_and_says_so():
    total = proxima.minkowski_sum(BOX, BOX)
    for protocol in range(pickle.HIGHEST_PROTOCOL + 1):
        with pytest.raises(TypeError, match="pickle"):
            pickle.dumps(total, protocol)
