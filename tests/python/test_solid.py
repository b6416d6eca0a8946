"""Times of contact, penetration depths and contact regions: boxes and balls worked out by hand, fine steps, and the bits of the
program."""
import copy
import gc
import json
import os
import pickle
import subprocess

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import proxima

compared = pytest.mark.skipif("PROXIMA_PROGRAM" not in os.environ, reason="built without the program")


def at(*translation):
    return np.hstack([np.eye(3), np.array(translation, float)[:, None]])


def turned(axis, angle, translation=(0, 0, 0)):
    x, y, z = np.array(axis) / np.linalg.norm(axis)
    cross = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    return np.hstack([np.eye(3) + np.sin(angle) * cross + (1 - np.cos(angle)) * cross @ cross, np.array(translation, float)[:, None]])


def program(*arguments):
    done = subprocess.run([os.environ["PROXIMA_PROGRAM"], *map(str, arguments), "--json", "-", "--quiet"], capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    return json.loads(done.stdout)


def row(pose):
    return ",".join(repr(float(number)) for number in np.asarray(pose).ravel())


@pytest.fixture(scope="module")
def cube():
    return proxima.Mesh.sample("cube")


@pytest.fixture(scope="module")
def box(cube):
    return proxima.Solid(cube)


# ---- times of contact ----

def test_a_box_that_moves_towards_another_one(cube):
    index = proxima.Index(cube, distances=True)
    edge = np.ptp(cube.vertices[:, 0])
    found = index.time_of_contact(index, proxima.Motion(start=at(3 * edge, 0, 0), displacement=[-4 * edge, 0, 0]))
    assert found.free_until == pytest.approx(0.5, abs=1e-9) and found.free_until <= 0.5 <= found.touches_at <= found.free_until + 1e-8
    assert proxima.CONTACT_EVIDENCE[found.evidence] == "intersection" and found.normal.tolist() == [1, 0, 0]
    assert found.distance == pytest.approx(0, abs=1e-8) and found.free_pose[0, 3] == pytest.approx(edge)
    assert index.time_of_contact(index, proxima.Motion(at(3 * edge, 0, 0), displacement=[0, 5, 0])) is None
    start = index.time_of_contact(index, proxima.Motion())
    assert start.free_until == 0 == start.touches_at and start.normal.tolist() == [0, 0, 0]


@given(st.integers(0, 1000))
def test_contact_lies_between_fine_steps(seed):
    random = np.random.default_rng(seed)
    torus, ball = (proxima.Index(proxima.Mesh.sample(name)) for name in ("torus:12x6", "icosphere:1"))
    start = turned(random.normal(size=3), 1, random.uniform(-1, 1, 3) + [4, 0, 0])
    motion = proxima.Motion(start, random.uniform(-0.2, 0.2, 3), [-5, *random.uniform(-1, 1, 2)], random.normal(size=3))
    times = np.linspace(0, 1, 201)
    meets = torus.intersect(ball, np.stack([proxima.pose_at(motion, time) for time in times]), pairs=False)
    found = torus.time_of_contact(ball, motion)
    if found is None:
        assert not meets.any()
        return
    first = times[meets][0] if meets.any() else 1
    assert found.free_until <= first and not meets[times <= found.free_until].any()
    assert proxima.pose_at(motion, found.free_until).tobytes() == found.free_pose.tobytes()
    assert torus.intersect(ball, proxima.pose_at(motion, found.touches_at), pairs=False)
    assert torus.distance_to(ball, found.free_pose).distance == found.distance


def test_motions_between_poses():
    start, end = turned([1, 2, 3], 0.4, [1, 0, 0]), turned([0, 1, 0], 2, [0, 1, 2])
    motion = proxima.motion_between(start, end, [0.1, 0.2, 0.3])
    assert motion.start.tobytes() == start.tobytes() == proxima.pose_at(motion, 0).tobytes()
    assert np.allclose(proxima.pose_at(motion, 1), end, atol=1e-14)
    center = np.array([0.1, 0.2, 0.3, 1])
    middle = proxima.pose_at(motion, 0.5) @ center
    assert np.allclose(middle, (start @ center + end @ center) / 2) and motion.center.tolist() == [0.1, 0.2, 0.3]
    whole = proxima.Motion(turn=[0, 0, 2 * np.pi])
    assert np.allclose(proxima.pose_at(whole, 0.25)[:, 0], [0, 1, 0])


@pytest.mark.parametrize("motion, options, says", [
    (at(0, 0, 0), {}, "motion: must be a proxima.Motion, is a numpy.ndarray"),
    (proxima.Motion(center=[0, 0]), {}, r"motion.center: must have shape \(3,\)"),
    (proxima.Motion(turn=[0, 0, np.nan]), {}, "NaN or infinite"),
    (proxima.Motion(turn=[0, 0, 1e9]), {}, "turn"),
    (proxima.Motion(start=2 * np.eye(4)[:3]), {}, "pose: "),
    (proxima.Motion(), {"tolerance": np.nan}, "tolerance: must be from 0 to 1"),
    (proxima.Motion(), {"max_steps": 0}, "max_steps: must be from 1")])
def test_wrong_motions_are_refused(index, motion, options, says):
    with pytest.raises((proxima.InvalidInput, TypeError), match=says):
        index.time_of_contact(index, motion, **options)


def test_how_near_and_how_long_times_are_searched(ring_and_ball):
    ring, ball = (solid.index for solid in ring_and_ball)
    motion = proxima.Motion(at(4, 0.1, 0.2), displacement=[-5, 0, 0], turn=[0.3, 0.5, 1])
    fine, coarse, few = (ring.time_of_contact(ball, motion, **options) for options in ({}, {"tolerance": 1e-3}, {"max_steps": 3}))
    assert 0 < fine.free_until <= fine.touches_at <= fine.free_until + 1e-9
    assert coarse.free_until <= fine.free_until and fine.touches_at <= coarse.touches_at
    assert 1e-6 < coarse.touches_at - coarse.free_until <= 1.000001e-3 and coarse.steps < fine.steps
    assert proxima.CONTACT_EVIDENCE[few.evidence] == "steps" and few.steps == 3
    assert 0 < few.free_until < fine.free_until and few.touches_at == np.inf


@compared
def test_times_have_the_bits_of_the_program():
    start, end = turned([1, 2, 3], 0.4, [3, 0.1, 0.2]), turned([0, 1, 0], 2, [-3, 0.3, 0])
    told = program("contact-time", "torus:24x12", "icosphere:2", "--from", row(start), "--to", row(end), "--center", "0.1,0,0")
    torus, ball = (proxima.Index(proxima.Mesh.sample(name), distances=True) for name in ("torus:24x12", "icosphere:2"))
    motion = proxima.motion_between(start, end, [0.1, 0, 0])
    assert (told["turn"], told["displacement"]) == (motion.turn.tolist(), motion.displacement.tolist())
    found = torus.time_of_contact(ball, motion)
    assert 0 < found.free_until < 1 and told["evidence"] == proxima.CONTACT_EVIDENCE[found.evidence]
    names = {"triangle": "triangle_a", "other_triangle": "triangle_b", "point": "point_a", "other_point": "point_b"}
    for name in ("free_until", "touches_at", "distance", "steps", "triangle", "other_triangle"):
        assert told[names.get(name, name)] == getattr(found, name), name
    for name in ("free_pose", "point", "other_point", "normal"):
        assert told[names.get(name, name)] == getattr(found, name).ravel().tolist(), name


# ---- solids ----

def test_two_boxes(cube, box):
    edge = np.ptp(cube.vertices[:, 0])
    assert box.is_convex and box.hull_error == 0 and box.index.has_signs and repr(box) == "<proxima.Solid: 12 triangles, convex>"
    pose = at(0.75 * edge, 0.1 * edge, 0)
    depth = box.penetration_depth(box, pose)
    assert proxima.PENETRATION_METHODS[depth.method] == "convex" and depth.direction.tolist() == [1, 0, 0]
    assert depth.lower <= 0.25 * edge <= depth.upper and depth.upper - depth.lower < 1e-12
    assert box.overlaps(box, pose) is True and box.overlaps(box, pose + np.column_stack([np.zeros((3, 3)), depth.translation])) is False
    poses = np.stack([pose, at(2 * edge, 0, 0), at(edge, 0, 0)])
    assert box.overlaps(box, poses).tolist() == [True, False, True]
    apart = box.penetration_depth(box, poses[1])
    assert proxima.PENETRATION_METHODS[apart.method] == "apart" and apart.upper == 0 and apart.direction.tolist() == [0, 0, 0]
    regions = box.contact_regions(box, pose)
    assert len(regions.depth) == 1 and regions.normal.tolist() == [[1, 0, 0]] and regions.depth == pytest.approx(0.25 * edge)
    assert regions.first.tolist()[0] == 0 and regions.first[1] == len(regions.on_a) == len(regions.point_depth)
    assert np.allclose(regions.on_a[:, 0], cube.vertices[:, 0].max()) and np.allclose(regions.on_b[:, 0], regions.on_a[:, 0] - 0.25 * edge)
    assert np.array_equal(np.sort(regions.line), np.arange(len(regions.contour.closed))) and regions.first_line[1] == len(regions.line)
    assert regions.length[0] == pytest.approx(regions.contour.length)
    assert len(box.contact_regions(box, poses[1]).depth) == 0


@pytest.fixture(scope="module")
def ring_and_ball():
    """A ring whose tube has the radius 1/2 and whose middle is the unit circle, and a ball of radius 1."""
    return [proxima.Solid(proxima.Mesh.sample(name)) for name in ("torus:48x24", "icosphere:3")]


def test_two_regions_of_a_ring_through_a_ball(ring_and_ball):
    """The ball is about (1, 0, 0), in the middle of the tube. With r the distance from the z axis, the ring's surface has
    (r - 1)^2 + z^2 = 1/4, and is 1 away from there where r^2 + z^2 = 2 x, so where x = r - 3/8: a loop at y > 0, and its mirror image."""
    ring, ball = ring_and_ball
    pose = turned([1, 2, 3], 0.4, [1, 0, 0])  # no corner of the ball is on an edge of the ring
    regions = ring.contact_regions(ball, pose)
    turn = np.linspace(0, 2 * np.pi, 2001)
    r, z = 1 + 0.5 * np.cos(turn), 0.5 * np.sin(turn)
    loop = np.stack([r - 3 / 8, np.sqrt(r**2 - (r - 3 / 8)**2), z], axis=1)
    lengths = np.linalg.norm(np.diff(loop, axis=0), axis=1)
    middle = lengths @ (loop[1:] + loop[:-1]) / (2 * lengths.sum())
    area = np.cross(loop[:-1], loop[1:]).sum(axis=0) / 2
    normal = -np.sign(area[1]) * area / np.linalg.norm(area)  # into the ball
    mirrored = [1, -1, 1]
    assert not ring.is_convex and len(regions.depth) == 2 and np.diff(regions.first_line).tolist() == [1, 1]
    assert regions.contour.closed.all()
    order = np.argsort(regions.position[:, 1])
    assert np.allclose(regions.position[order], [middle * mirrored, middle], atol=0.01)
    assert np.allclose(regions.normal[order], [normal * mirrored, normal], atol=0.01)
    assert np.allclose(regions.length, lengths.sum(), rtol=0.02) and np.allclose(regions.area, np.linalg.norm(area), rtol=0.03)
    # The line through each middle is 1.76 long in ring and ball, and none in the ball is longer than 2.
    assert (regions.depth > 1.7).all() and (regions.depth <= 2).all()
    depth = ring.penetration_depth(ball, pose)
    assert 0 < depth.lower <= depth.upper == pytest.approx(1.5, abs=0.02)  # balls of radius 1/2 and 1 have one centre


def test_a_ball_in_the_rim_of_a_ring(ring_and_ball):
    """Along x the ring ends at 1.5, and the ball begins at 0.7."""
    ring, ball = ring_and_ball
    pose = turned([1, 2, 3], 0.4, [1.7, 0, 0])
    regions = ring.contact_regions(ball, pose)
    assert len(regions.depth) == 1 and regions.depth[0] == pytest.approx(0.8, abs=0.01)
    assert np.allclose(regions.normal, [[1, 0, 0]], atol=0.01) and np.allclose(regions.position[0, 1:], 0, atol=0.01)
    depth = ring.penetration_depth(ball, pose)
    assert 0 < depth.lower <= depth.upper == pytest.approx(0.8, abs=0.02) and depth.direction[0] > 0.95
    free = pose + np.column_stack([np.zeros((3, 3)), depth.translation])
    assert not ring.overlaps(ball, free) and not ring.index.intersect(ball.index, free, pairs=False)


def test_depths_are_as_near_as_asked_for(ring_and_ball):
    ring, ball = ring_and_ball
    pose = turned([1, 2, 3], 0.4, [1, 0, 0])  # 1.5 deep, as above
    assert ring.penetration_depth(ball, pose).lower > 1.2 and ring.penetration_depth(ball, pose, max_points=0).lower == 0
    ring = proxima.Solid(proxima.Mesh.sample("torus:3x3"))  # whose corners stick out
    pose = turned([1, 2, 3], 2, [0.6, 0.1, 0.2])
    usual, few = ring.penetration_depth(ring, pose), ring.penetration_depth(ring, pose, max_directions=0)
    assert usual.upper < 0.7 * few.upper
    for depth in (usual, few):
        assert ring.overlaps(ring, pose) and not ring.overlaps(ring, pose + np.column_stack([np.zeros((3, 3)), depth.translation]))


@pytest.mark.parametrize("make, says", [
    (lambda mesh: mesh.part([0, 1, 2]), "open|boundary|closed"), (lambda mesh: proxima.Mesh(mesh.vertices, mesh.faces[:, ::-1]), "inside out|inward"),
    (lambda mesh: proxima.Mesh(np.zeros((0, 3)), np.zeros((0, 3), int)), "no triangles|empty")])
def test_what_is_no_solid_is_refused(cube, make, says):
    with pytest.raises(proxima.InvalidInput, match=says) as caught:
        proxima.Solid(make(cube))
    assert caught.value.code == "invalid_mesh"


def test_wrong_questions_are_refused(box):
    with pytest.raises(TypeError, match="model: must be a proxima.Mesh or Index, is a int"):
        proxima.Solid(3)
    with pytest.raises(proxima.InvalidInput, match="max_points: must be from 0 to 1000000"):
        box.penetration_depth(box, max_points=-1)
    for ask in (box.penetration_depth, box.contact_regions):
        with pytest.raises(proxima.InvalidInput, match="pose: "):
            ask(box, np.full((3, 4), np.inf))
        with pytest.raises(proxima.InvalidInput, match="pose: must be one pose"):
            ask(box, np.tile(np.eye(4), (2, 1, 1)))
    with pytest.raises(TypeError):
        box.overlaps(box.index)


def test_solids_own_what_they_need_and_can_be_copied(cube):
    index = proxima.Index(cube)
    solid = proxima.Solid(index)
    kept = solid.index
    expected = solid.penetration_depth(solid, at(0.5, 0, 0))
    other = pickle.loads(pickle.dumps(solid))
    assert copy.copy(solid) is solid and copy.deepcopy(solid) is solid
    regions = solid.contact_regions(solid, at(0.5, 0, 0))
    del index, solid
    gc.collect()
    trash = [np.random.rand(1000) for _ in range(1000)]
    for mine, theirs in zip(other.penetration_depth(other, at(0.5, 0, 0)), expected):
        assert np.array_equal(mine, theirs)
    assert kept.has_signs and kept.closest([[0, 0, 0]]).distance[0] > 0 and regions.contour.point.size and trash


def test_searches_can_be_stopped():
    ring = proxima.Solid(proxima.Mesh.sample("torus:200x100"))
    with pytest.raises(proxima.Cancelled):
        ring.penetration_depth(ring, at(0.3, 0.1, 0.2), max_points=1_000_000, max_directions=1_000_000, progress=lambda stage, part: False)
    with pytest.raises(proxima.Cancelled):
        proxima.Solid(proxima.Mesh.sample("icosphere:6"), progress=lambda stage, part: False)


@compared
@pytest.mark.parametrize("a, b", [("cube", "icosphere:2"), ("torus:24x12", "icosphere:2")])
def test_depths_and_regions_have_the_bits_of_the_program(a, b):
    pose = turned([1, 2, 3], 0.4, [0.9, 0.1, 0.2])
    told = program("contacts", a, b, "--pose", row(pose))["poses"][0]
    solid, other = (proxima.Solid(proxima.Mesh.sample(name)) for name in (a, b))
    depth, regions = solid.penetration_depth(other, pose), solid.contact_regions(other, pose)
    assert told["method"] == proxima.PENETRATION_METHODS[depth.method] != "apart"
    for name in ("lower", "upper"):
        assert told[name] == getattr(depth, name), name
    for name in ("direction", "translation", "deepest"):
        assert told[name] == getattr(depth, name).tolist(), name
    assert len(told["regions"]) == len(regions.depth) > 0
    for i, region in enumerate(told["regions"]):
        for name in ("position", "normal", "depth", "length", "area"):
            assert region[name] == getattr(regions, name)[i].tolist(), name
        rows = range(*regions.first[i:i + 2])
        assert [(point["on_a"], point["on_b"], point["depth"]) for point in region["points"]] == [
            (regions.on_a[k].tolist(), regions.on_b[k].tolist(), regions.point_depth[k]) for k in rows]
        assert region["lines"] == np.diff(regions.first_line[i:i + 2])
