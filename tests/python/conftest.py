"""Meshes and NumPy oracles that the tests share."""
import os

import numpy as np
import pytest
from hypothesis import settings

import proxima

# The same examples in every run of the suite; more and others with PROXIMA_HYPOTHESIS=thorough.
settings.register_profile("suite", derandomize=True, deadline=None, max_examples=60)
settings.register_profile("thorough", deadline=None, max_examples=3000)
settings.load_profile(os.environ.get("PROXIMA_HYPOTHESIS", "suite"))


@pytest.fixture(scope="session")
def mesh():
    return proxima.Mesh.sample("torus:24x12")


@pytest.fixture(scope="session")
def index(mesh):
    return proxima.Index(mesh, signs=True)


@pytest.fixture
def points():
    return np.random.default_rng(7).uniform(-2, 2, (300, 3))
