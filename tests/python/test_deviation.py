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


def test_refuses_tolerances_that_are_none():
    with pytest.raises(proxima.InvalidInput, match="tolerance"):
        index_of("cube").deviation(index_of("cube"), tolerance=-1)


def test_can_be_stopped():
    with pytest.raises(proxima.Cancelled):
        index_of("icosphere:5").deviation(index_of("icosphere:6"), mean_tolerance=1e-9, progress=lambda stage, part: False)
