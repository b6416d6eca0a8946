"""Scenes: every answer against all instances asked one by one, in the arithmetic that include/proxima/scene.h states, and
against the program."""
import copy
import gc
import json
import os
import pickle
import signal
import subprocess
import threading

import numpy as np
import pytest

import proxima

ALL = 0xFFFFFFFF
compared = pytest.mark.skipif("PROXIMA_PROGRAM" not in os.environ, reason="built without the program")


def same(a, b):
    return all(np.asarray(x).tobytes() == np.asarray(y).tobytes() for x, y in zip(a, b)) and len(a) == len(b)


def rotations(random, count):
    turned = np.linalg.qr(random.normal(size=(count, 3, 3)))[0]
    return turned * np.linalg.det(turned)[:, None, None]


class World:
    """A scene, and what it is made of."""

    def __init__(self, seed=3, count=60, spread=3.0):
        random = np.random.default_rng(seed)
        self.shapes = [proxima.Index(proxima.Mesh.sample(name)) for name in ("torus:12x6", "cube", "icosphere:1")]
        self.poses = np.dstack([rotations(random, count), random.uniform(-spread, spread, (count, 3))])
        self.shape = random.integers(0, 3, count)
        self.layers = random.integers(0, 4, count).astype(np.uint32)
        self.scene = proxima.Scene(self.shapes, self.poses, self.shape, self.layers)
        self.points = random.uniform(-spread, spread, (50, 3))
        self.directions = random.normal(size=(50, 3))

    def seen(self, layers):
        return [i for i in range(len(self.poses)) if self.layers[i] & layers]

    def index(self, i):
        return self.shapes[self.shape[i]]


def moved(rotation, translation, points):
    """RigidTransform, each product and sum in its order."""
    x, y, z = np.asarray(points).T
    return np.stack([((rotation[k, 0] * x + rotation[k, 1] * y) + rotation[k, 2] * z) + translation[k] for k in range(3)], axis=-1)


def frame(pose):
    """instance_frame()."""
    r, t = pose[:, :3], pose[:, 3]
    return r.T, np.array([-((r[0, i] * t[0] + r[1, i] * t[1]) + r[2, i] * t[2]) for i in range(3)])


def relative(a, b):
    """relative_pose()."""
    def back(v):
        return [(a[0, i] * v[0] + a[1, i] * v[1]) + a[2, i] * v[2] for i in range(3)]
    return np.column_stack([back(b[:, j]) for j in range(3)] + [back(b[:, 3] - a[:, 3])])


@pytest.fixture(scope="module")
def world():
    return World()


@pytest.mark.parametrize("layers", [ALL, 1, 2])
def test_closest_is_that_of_all_instances_one_by_one(world, layers):
    found = world.scene.closest(world.points, layers=layers)
    for k, point in enumerate(world.points):
        best = None
        for i in world.seen(layers):
            local = moved(*frame(world.poses[i]), [point])
            closest = world.index(i).closest(local)
            off = local[0] - closest.point[0]
            distance = np.sqrt((off[0] * off[0] + off[1] * off[1]) + off[2] * off[2])
            if best is None or distance < best[0]:
                best = distance, i, closest
        assert found.distance[k] == pytest.approx(best[0], rel=1e-15) and found.instance[k] == best[1]
        pose = world.poses[best[1]]
        for mine, other in ((found.point[k], moved(pose[:, :3], pose[:, 3], best[2].point)[0]),
                            (found.triangle[k], best[2].triangle[0]), (found.feature_kind[k], best[2].feature_kind[0]),
                            (found.feature[k], best[2].feature[0]), (found.barycentric[k], best[2].barycentric[0])):
            assert np.asarray(mine).tobytes() == np.asarray(other).tobytes()


def test_closest_within_a_radius(world):
    whole = world.scene.closest(world.points)
    radius = np.median(whole.distance)
    near = world.scene.closest(world.points, radius=radius)
    beyond = whole.distance > radius
    assert beyond.any() and np.array_equal(near.instance, np.where(beyond, -1, whole.instance))
    assert np.isinf(near.distance[beyond]).all() and (near.triangle[beyond] == -1).all() and np.isnan(near.point[beyond]).all()
    assert np.array_equal(near.distance[~beyond], whole.distance[~beyond])


def hits_one_by_one(world, k, layers, faces, t_max):
    """(t, instance, triangle, u, v) of a ray, in order."""
    hits = []
    for i in world.seen(layers):
        r, t = frame(world.poses[i])
        lists = world.index(i).cast(moved(r, t, [world.points[k]]), moved(r, np.zeros(3), [world.directions[k]]), hits="all",
                                    faces=faces, t_max=t_max)
        hits += [(a, i, b, c, d) for a, b, c, d in zip(*lists[1:])]
    return sorted(hits)


@pytest.mark.parametrize("layers, faces, t_max", [(ALL, "both", np.inf), (1, "front", np.inf), (2, "back", 0.8)])
def test_rays_hit_what_they_hit_one_by_one(world, layers, faces, t_max):
    def ask(hits):
        return world.scene.cast(world.points, world.directions, hits=hits, layers=layers, faces=faces, t_max=t_max)
    first, any_hit, lists = ask("first"), ask("any"), ask("all")
    assert any_hit.dtype == bool and np.array_equal(any_hit, first.hit) and 5 < any_hit.sum()
    for k in range(len(world.points)):
        expected = hits_one_by_one(world, k, layers, faces, t_max)
        rows = slice(*lists.first[k:k + 2])
        assert list(zip(lists.t[rows], lists.instance[rows], lists.triangle[rows], lists.u[rows], lists.v[rows])) == expected
        if expected:
            assert (first.t[k], first.instance[k], first.triangle[k], first.u[k], first.v[k]) == expected[0]
        else:
            assert (first.instance[k], first.triangle[k], first.t[k]) == (-1, -1, np.inf) and np.isnan(first.u[k])


def test_pairs_are_those_of_all_pairs(world):
    count = len(world.poses)
    meet, near, boxes = [], {}, []
    bounds = world.scene.bounds
    for a in range(count):
        for b in range(a + 1, count):
            if not (world.layers[a] and world.layers[b]):
                continue  # never found
            pose = relative(world.poses[a], world.poses[b])
            if world.index(a).intersect(world.index(b), pose, pairs=False):
                meet.append((a, b))
            distance = world.index(a).distance_to(world.index(b), pose, farthest=0.3)
            if distance.distance <= 0.3:
                near[a, b] = distance
            if (bounds[a, 0] <= bounds[b, 1]).all() and (bounds[b, 0] <= bounds[a, 1]).all():
                boxes.append((a, b))
    found = world.scene.in_contact()
    assert list(zip(found.a, found.b)) == meet and len(meet) > 20
    found = world.scene.boxes_within()
    assert list(zip(found.a, found.b)) == boxes and len(boxes) > len(meet)
    found = world.scene.within(0.3)
    assert list(zip(found.a, found.b)) == list(near) and len(near) > len(meet)
    for row, ((a, b), distance) in enumerate(near.items()):
        assert found.distance[row] == distance.distance
        assert (found.triangle_a[row], found.triangle_b[row]) == (distance.triangle_a, distance.triangle_b)
        pose = world.poses[a]
        assert found.point_a[row].tolist() == moved(pose[:, :3], pose[:, 3], [distance.point_a])[0].tolist()
        assert found.point_b[row].tolist() == moved(pose[:, :3], pose[:, 3], [distance.point_b])[0].tolist()


def test_pairs_by_layers(world):
    whole, some = world.scene.in_contact(), world.scene.in_contact(layers=1, others=2)
    of = world.layers
    wanted = [(a, b) for a, b in zip(whole.a, whole.b) if (of[a] & 1 and of[b] & 2) or (of[b] & 1 and of[a] & 2)]
    assert list(zip(some.a, some.b)) == wanted and 0 < len(wanted) < len(whole.a)


@pytest.mark.parametrize("exact", [False, True])
def test_what_is_in_view_is_that_of_instances_one_by_one(world, exact):
    planes = proxima.perspective([0, 0, 5], [0, 0.1, -1], field_of_view=0.5)
    ids = world.scene.visible(planes, exact=exact)
    triangles = world.scene.visible(planes, triangles=True, exact=exact)
    assert ids.dtype == np.int32 and 0 < len(ids) < len(world.poses)
    assert np.array_equal(np.unique(triangles.instance), ids) and (np.diff(triangles.instance) >= 0).all()
    for i in world.seen(ALL):
        pose = world.poses[i]
        n, t = planes[:, :3], pose[:, 3]
        local = np.column_stack([moved(pose[:, :3].T, np.zeros(3), n),
                                 ((n[:, 0] * t[0] + n[:, 1] * t[1]) + n[:, 2] * t[2]) + planes[:, 3]])
        expected = world.index(i).visible(local, exact=exact)
        assert np.array_equal(triangles.triangle[triangles.instance == i], expected)
    one = world.scene.visible(planes, exact=exact, layers=1)
    assert np.array_equal(one, [i for i in ids if world.layers[i] & 1])


def test_instances_in_a_box(world):
    lower, upper = np.array([-1, -2, 0]), np.array([0.5, 0, 1])
    bounds = world.scene.bounds
    meets = (bounds[:, 0] <= upper).all(axis=1) & (bounds[:, 1] >= lower).all(axis=1)
    assert np.array_equal(world.scene.in_box(lower, upper), np.nonzero(meets & (world.layers > 0))[0]) and meets.sum() > 5
    assert np.array_equal(world.scene.in_box(lower, upper, layers=2), np.nonzero(meets & (world.layers & 2 > 0))[0])
    with pytest.raises(proxima.InvalidInput, match="lower: must be at most upper along each axis"):
        world.scene.in_box(upper, lower)


def test_boxes_hold_instances(world):
    for i, box in enumerate(world.scene.bounds):
        corners = moved(world.poses[i, :, :3], world.poses[i, :, 3], world.index(i).mesh().vertices)
        assert (box[0] <= corners.min(axis=0)).all() and (box[1] >= corners.max(axis=0)).all()
        assert (np.ptp(box, axis=0) < 1.5 * np.ptp(corners, axis=0) + 1e-9).all()  # of few triangles


def test_moved_scenes_answer_as_new_ones(world):
    random = np.random.default_rng(8)
    poses = world.poses.copy()
    poses[:, :, 3] += random.uniform(-1, 1, (len(poses), 3))
    other, new = world.scene.move(poses), proxima.Scene(world.shapes, poses, world.shape, world.layers)
    assert np.array_equal(other.poses, poses) and np.array_equal(world.scene.poses, world.poses)
    for scene in (other, pickle.loads(pickle.dumps(other))):
        assert same(scene.closest(world.points), new.closest(world.points)) and same(scene.in_contact(), new.in_contact())
        assert same(scene.cast(world.points, world.directions), new.cast(world.points, world.directions))
        assert same([scene.bounds, scene.shape, scene.layers], [new.bounds, world.shape.astype("i4"), world.layers])
    with pytest.raises(proxima.InvalidInput, match="59 poses, but 60 instances"):
        world.scene.move(poses[1:])


def test_threads_change_no_answer(world):
    one = proxima.Scene(world.shapes, world.poses, world.shape, world.layers, threads=1)
    assert same(one.closest(world.points, threads=1), world.scene.closest(world.points))
    assert same(one.within(0.3, threads=1), world.scene.within(0.3)) and one.nbytes == world.scene.nbytes


def test_poses_and_shapes_in_any_form(world):
    shape = world.shapes[1]
    poses = np.zeros((3, 4, 4), "f4")
    poses[:, range(4), range(4)] = 1
    poses[:, 0, 3] = [0, 5, 10]
    scene = proxima.Scene(shape, poses)
    assert scene.instance_count == 3 and scene.shape.tolist() == [0, 0, 0] and scene.layers.tolist() == [ALL] * 3
    assert np.array_equal(scene.poses, poses[:, :3].astype("f8")) and scene.shapes[0].fingerprint == shape.fingerprint
    assert proxima.Scene(shape, poses[0]).instance_count == 1 and proxima.Scene((shape,), np.zeros((0, 3, 4))).instance_count == 0
    assert proxima.Scene([shape], poses, layers=3).layers.tolist() == [3, 3, 3]
    assert repr(scene) == f"<proxima.Scene: 3 instances of 1 shapes, {scene.nbytes} bytes>"
    assert copy.copy(scene) is scene and copy.deepcopy(scene) is scene
    nothing = proxima.Scene([], np.zeros((0, 3, 4)))
    assert nothing.closest([[0, 0, 0]]).instance.tolist() == [-1] and len(nothing.in_contact().a) == 0


@pytest.mark.parametrize("arguments, says", [
    (([], np.eye(4)[None]), "instance 0: its shape is not one"),
    ((0, np.eye(4)), "shapes: must be one proxima.Index or a list of them, is a int"),
    (([3], np.eye(4)), r"shapes\[0\]: must be a proxima.Index, is a int"),
    ((None, np.eye(3)), r"poses: must have shape \(3, 4\), \(4, 4\), \(n, 3, 4\) or \(n, 4, 4\), has \(3, 3\)"),
    ((None, None), "poses: must have shape .* is None"),
    ((None, np.full((2, 3, 4), np.nan)), "pose 0: "),
    ((None, 2 * np.eye(4)[None, :3]), "pose 0: "),
    ((None, np.eye(4), [1]), "instance 0: its shape is not one"),
    ((None, np.eye(4), [-1]), "shape: must be from 0 to 4294967295, that of instance 0 is -1"),
    ((None, np.eye(4), [0.5]), "shape: must be an integer, or one for each pose"),
    ((None, np.eye(4), None, [1, 2]), "layers: must be one, or one for each of 1 poses, are 2"),
    ((None, np.eye(4), None, [2**32]), "layers: must be from 0 to 4294967295")])
def test_wrong_scenes_are_refused(world, arguments, says):
    shapes = world.shapes[0] if arguments[0] is None else arguments[0]
    with pytest.raises((proxima.InvalidInput, TypeError), match=says):
        proxima.Scene(shapes, *arguments[1:])


@pytest.mark.parametrize("ask, says", [
    (lambda scene: scene.closest([[0, 0, np.nan]]), "points: point 0 has a coordinate that is not finite"),
    (lambda scene: scene.closest([0, 0, 0]), r"points: must have shape \(n, 3\)"),
    (lambda scene: scene.closest([[0, 0, 0]], radius=np.nan), "radius: must be 0 or more"),
    (lambda scene: scene.closest([[0, 0, 0]], layers=-1), "layers: must be one integer from 0 to 4294967295"),
    (lambda scene: scene.cast([0, 0, 0], [[0, 0, 0]]), "rays: ray 0 is none"),
    (lambda scene: scene.cast([0, 0, 0], [[0, 0, 1]], hits="some"), 'hits: must be "first", "any" or "all"'),
    (lambda scene: scene.cast([0, 0, 0], [[0, 0, 1]], faces="in"), 'faces: must be "both"'),
    (lambda scene: scene.visible([[0, 0, 1]]), r"planes: must have shape \(n, 4\)"),
    (lambda scene: scene.within(-1), "a distance of -1"),
    (lambda scene: scene.boxes_within(np.inf), "a distance of inf"),
    (lambda scene: scene.in_contact(others="all"), "others: must be an integer")])
def test_wrong_questions_are_refused(world, ask, says):
    with pytest.raises(proxima.InvalidInput, match=says):
        ask(world.scene)


def test_scenes_own_what_they_need():
    world = World(seed=5)
    scene, points = world.scene, world.points
    expected = scene.closest(points)
    bounds, shapes = scene.bounds, scene.shapes
    world.__dict__.clear()
    gc.collect()
    trash = [np.random.rand(1000) for _ in range(1000)]
    assert same(scene.closest(points), expected) and trash
    del scene
    gc.collect()
    assert np.isfinite(bounds).all() and shapes[0].triangle_count == 144


def test_long_work_stops_on_request_and_leaves_others_running(world):
    told = []
    many = np.tile(world.points, (20_000, 1))

    def stop(stage, part):
        told.append(stage)
        return len(told) < 3
    with pytest.raises(proxima.Cancelled):
        world.scene.closest(many, threads=1, progress=stop)
    assert set(told) - {""} == {"closest features"} and len(told) == 3  # "" before the work begins
    threading.Timer(0.2, lambda: signal.raise_signal(signal.SIGINT)).start()
    with pytest.raises(KeyboardInterrupt):
        for _ in range(200):  # a minute
            world.scene.cast(many, np.tile(world.directions, (20_000, 1)), hits="all", threads=1)


def test_one_long_distance_stops_on_request():
    large = proxima.Mesh.sample("icosphere:5")
    inner = proxima.Index(proxima.Mesh(0.99 * large.vertices, large.faces))
    outer = proxima.Index(large)
    copies = proxima.Scene([outer, inner], np.tile(np.eye(4), (2, 1, 1)), [0, 1])
    with pytest.raises(proxima.Cancelled):
        outer.distance_to(inner, progress=lambda *_: False)
    with pytest.raises(proxima.Cancelled):
        outer.time_of_contact(inner, proxima.Motion(turn=(3, 4, 5)), progress=lambda *_: False)
    with pytest.raises(proxima.Cancelled):
        copies.within(1, progress=lambda *_: False)


def test_visible_triangles_of_many_copies_stop_on_request():
    ball = proxima.Index(proxima.Mesh.sample("icosphere:4"))
    copies = proxima.Scene(ball, np.tile(np.eye(4), (2000, 1, 1)))
    told = []

    def stop(stage, part):
        told.append((stage, part))
        return stage != "visible triangles"
    with pytest.raises(proxima.Cancelled):
        copies.visible([[0, 0, 1, 0.5]], triangles=True, progress=stop)
    assert told[-1][0] == "visible triangles" and told[-1][1] < 1


@compared
def test_answers_have_the_bits_of_the_program(world, tmp_path):
    np.save(tmp_path / "poses.npy", world.poses.reshape(-1, 12))
    np.save(tmp_path / "shapes.npy", world.shape.astype("f8")[:, None])
    np.save(tmp_path / "points.npy", world.points)
    np.save(tmp_path / "rays.npy", np.hstack([world.points, world.directions]))

    def answer(*question):
        command = [os.environ["PROXIMA_PROGRAM"], "scene", "torus:12x6", "cube", "icosphere:1", "--poses", tmp_path / "poses.npy",
                   "--shapes", tmp_path / "shapes.npy", *question, "--out", tmp_path / "a.npy", "--json", "-", "--quiet"]
        done = subprocess.run(command, capture_output=True, text=True)
        assert done.returncode == 0 and json.loads(done.stdout)["instances"] == len(world.poses), done.stderr
        return np.load(tmp_path / "a.npy")
    scene = proxima.Scene(world.shapes, world.poses, world.shape)
    near = scene.within(0.4)
    assert np.array_equal(answer("--pairs", "--within", "0.4"),
                          np.column_stack([near.a, near.b, near.distance, near.point_a, near.point_b]))
    meet = scene.in_contact()
    assert np.array_equal(answer("--pairs"), np.column_stack(meet)) and len(meet.a) > 20
    hits, theirs = scene.cast(world.points, world.directions), answer("--rays", tmp_path / "rays.npy")
    columns = np.column_stack([np.arange(len(hits.t)), hits.t, hits.instance, hits.triangle, hits.u, hits.v])
    assert np.array_equal(theirs[hits.hit], columns[hits.hit]) and (theirs[~hits.hit, 2] == -1).all() and hits.hit.sum() > 5
    closest, theirs = scene.closest(world.points), answer("--points", tmp_path / "points.npy")
    assert np.array_equal(theirs, np.column_stack([np.arange(len(theirs)), closest.distance, closest.point, closest.instance,
                                                   closest.triangle, closest.feature_kind, closest.feature]))
