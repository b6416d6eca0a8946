"""Whatever is handed to a function of the package is answered, or refused by one error: no crash, no error from inside."""
import inspect
import os

import numpy as np
import pytest

import proxima

MESH = proxima.Mesh.sample("icosphere:1")
CUBE = proxima.Mesh.sample("cube")
POINTS = np.random.default_rng(1).uniform(-1, 1, (5, 3))
POSE = np.eye(4)[:3]
BOX = np.array([[-5.0, -5, -5], [5, 5, 5]])


class Hostile:
    """Everything that is asked of it fails."""

    def __array__(self, *_):
        raise RuntimeError("hostile")

    __float__ = __index__ = __len__ = __array__


class SubclassOfMasked(np.ma.MaskedArray):
    """One by another name."""


def without_value(kind):
    return kind.__new__(kind)


def calls(folder):
    """{name: (function, good arguments)} of all functions."""
    index = proxima.Index(MESH, signs=True, distances=True)
    topology, octree, solid = proxima.Topology(MESH), proxima.Octree(MESH), proxima.Solid(MESH)
    body, scene = proxima.Polyhedron.of_mesh(CUBE), proxima.Scene(index, [POSE, POSE])
    total, renderer, touched = proxima.minkowski_sum(body, body), proxima.TouchRenderer(MESH), proxima.TouchScene(BOX)
    touched.add(MESH)
    planes, motion = proxima.perspective([0, 0, 5], [0, 0, -1]), proxima.Motion(displacement=(3, 0, 0))
    deviation, closest = index.deviation(proxima.Index(CUBE)), index.closest(POINTS)
    for name, saved in {"a.pxi": index, "a.pxo": octree}.items():
        saved.save(folder / name)
    MESH.write(folder / "a.ply")
    threads, rays = {"threads": 1}, {"origins": POINTS, "directions": POINTS, "t_min": 0.0, "t_max": 1.0, "hits": "first", "faces": "both"}
    corners, layers = {"lower": BOX[0], "upper": BOX[1]}, {"layers": 1}
    bodies, camera = {"a": body, "b": body}, {"eye": BOX[0], "forward": BOX[1], "up": [0, 1, 0], "near": 0.01, "far": 10.0}
    touch = {"texture": proxima.Texture(), "shading": False}
    felt = {"model": MESH, "material": proxima.Material(), **touch}
    watched = {
        "Mesh.read": (proxima.Mesh.read, {"path": str(folder / "a.ply"), "weld": None, "points_and_lines": False}),
        "Mesh.from_bytes": (proxima.Mesh.from_bytes, {"data": (folder / "a.ply").read_bytes(), "format": "ply", "weld": None}),
        "Mesh.write": (MESH.write, {"path": "b.ply", "ascii": False}), "Mesh.report": (MESH.report, {"max_ids": 5, **threads}),
        "Mesh.repair": (MESH.repair, {"weld": True, "weld_distance": 0.0, "min_component_area": 0.0, "min_component_triangles": 0, **threads}),
        "Mesh.weld": (MESH.weld, {}), "Index": (proxima.Index, {"mesh": MESH, "lists": False, "signs": False, **threads}),
        "Index.closest": (index.closest, {"points": POINTS, "columns": None, "out": None, **threads}),
        "Index.signed_distance": (index.signed_distance, {"points": POINTS, "method": False, **threads}),
        "Index.cast": (index.cast, {**rays, **threads}), "Index.intersect": (index.intersect, {"other": index, "poses": None, **threads}),
        "Index.distance_to": (index.distance_to, {"other": index, "poses": POSE, "farthest": 3.0}),
        "Index.self_intersections": (index.self_intersections, {"max_pairs": 10, **threads}),
        "Index.containment": (index.containment, {"other": index, "poses": None}), "Index.contains": (index.contains, {"points": POINTS}),
        "Index.contour": (index.contour, {"other": index, "pose": None}),
        "Index.time_of_contact": (index.time_of_contact, {"other": index, "motion": motion, "tolerance": 1e-9, "max_steps": 1000}),
        "Index.within": (index.within, {"points": POINTS, "radius": 0.5}),
        "Index.nearest": (index.nearest, {"points": POINTS, "count": 2, "radius": 3.0}),
        "Index.distance_field": (index.distance_field, {"resolution": 4, "spacing": 0.0, "margin": 0.05, "box": None, "band": 3.0, **threads}),
        "Index.deviation": (index.deviation, {"other": index, "tolerance": 0.1, "mean_tolerance": 0.1, "max_places": 3, "place_spacing": 0.1,
                                              "bins": 3, "histogram_end": 1.0, "max_splits": 1000, **threads}),
        "Index.save": (index.save, {"path": "b.pxi"}), "Index.load": (proxima.Index.load, {"path": str(folder / "a.pxi"), "map": False}),
        "Index.with_lists": (index.with_lists, {"lists": 1 << 20, **threads}), "Index.with_distances": (index.with_distances, threads),
        "Index.with_signs": (index.with_signs, threads),
        "Index.refit": (index.refit, {"vertices": MESH.vertices, "topology": topology, **threads}),
        "Topology": (proxima.Topology, {"mesh": MESH, **threads}), "Topology.patch": (topology.patch, {"closest": closest, "rings": 1}),
        "Octree": (proxima.Octree, {"mesh": MESH, "max_depth": 3, "threshold": 1, "uniform": False, "root": "cube", **threads}),
        "Octree.along_rays": (octree.along_rays, {"origins": POINTS, "directions": POINTS}), "Octree.save": (octree.save, {"path": "b.pxo"}),
        "Octree.load": (proxima.Octree.load, {"path": str(folder / "a.pxo")}),
        "Octree.export": (octree.export, {"mesh": MESH, "path": "b.vtu"}), "Polyhedron": (proxima.Polyhedron, {"points": POINTS}),
        "minkowski_sum": (proxima.minkowski_sum, bodies),
        "Scene": (proxima.Scene, {"shapes": [index], "poses": [POSE], "shape": [0], "layers": [1], **threads}),
        "Scene.move": (scene.move, {"poses": [POSE, POSE], **threads}),
        "Scene.closest": (scene.closest, {"points": POINTS, "radius": 3.0, **layers, **threads}),
        "Scene.cast": (scene.cast, {**rays, **layers, **threads}),
        "Scene.visible": (scene.visible, {"planes": planes, "triangles": False, **layers, **threads}),
        "Scene.in_contact": (scene.in_contact, {**layers, "others": 1, **threads}),
        "Scene.within": (scene.within, {"distance": 1.0, **layers, "others": 1, **threads}),
        "Scene.boxes_within": (scene.boxes_within, {"distance": 1.0, **layers, "others": 1, **threads}),
        "Solid": (proxima.Solid, {"model": MESH, **threads}),
        "Solid.penetration_depth": (solid.penetration_depth, {"other": solid, "pose": None, "max_points": 10, "max_directions": 10}),
        "Solid.contact_regions": (solid.contact_regions, {"other": solid, "pose": None}),
        "TouchRenderer.step": (renderer.step, {"position": POINTS, "velocity": POINTS, "seconds": 0.001}),
        "TouchRenderer.replay": (proxima.TouchRenderer.replay, {"path": "none.pxt", "model": MESH}),
    }
    plain = {
        "Mesh": (proxima.Mesh, {"vertices": MESH.vertices, "faces": MESH.faces}), "Mesh.of_points": (proxima.Mesh.of_points, {"points": POINTS}),
        "Mesh.of_segments": (proxima.Mesh.of_segments, {"points": POINTS, "segments": [[0, 1], [1, 2]]}),
        "Mesh.sample": (proxima.Mesh.sample, {"name": "cube"}), "Mesh.part": (MESH.part, {"triangles": [0, 1]}),
        "Index.closest_one": (lambda point: index.closest_one(point), {"point": BOX[0]}),
        "Index.visible": (index.visible, {"planes": planes, "exact": False}), "Index.in_box": (index.in_box, corners),
        "Octree.visible": (octree.visible, {"planes": planes, "exact": False}), "Polyhedron.of_mesh": (proxima.Polyhedron.of_mesh, {"mesh": CUBE}),
        "Polyhedron.box": (proxima.Polyhedron.box, corners), "MinkowskiSum.contains": (total.contains, {"points": POINTS}),
        "MinkowskiSum.signed_distance": (total.signed_distance, {"points": POINTS}), "separation": (proxima.separation, bodies),
        "Scene.in_box": (scene.in_box, {**corners, **layers}), "Solid.overlaps": (solid.overlaps, {"other": solid, "poses": None}),
        "TouchScene": (proxima.TouchScene, {"bounds": BOX}), "TouchScene.add": (proxima.TouchScene(BOX).add, {"pose": None, **felt}),
        "TouchScene.move": (touched.move, {"object": 0, "pose": POSE, "seconds": 0.0, "velocity": BOX[0], "spin": BOX[0], "coast_seconds": 0.0}),
        "TouchScene.exchange": (touched.exchange, {"object": 0, **felt}),
        "TouchScene.deform": (touched.deform, {"object": 0, "vertices": MESH.vertices, "seconds": 0.0}),
        "TouchScene.set_material": (touched.set_material, {"object": 0, "material": proxima.Material(), "seconds": 0.0}),
        "TouchScene.pose": (touched.pose, {"object": 0}),
        "TouchRenderer": (proxima.TouchRenderer, {"model": MESH, "device": "omni", "units_per_metre": 10.0, "center": BOX[0], "stiffness": 500.0,
                                                  "damping": 1.0, "proxy_radius": 0.0, "static_friction": 0.4, "guard": "on", **touch}),
        "motion_between": (proxima.motion_between, {"start": POSE, "end": POSE, "center": BOX[0]}),
        "pose_at": (proxima.pose_at, {"motion": motion, "time": 0.5}), "both_ways": (proxima.both_ways, {"there": deviation, "back": deviation}),
        "device_limits": (proxima.device_limits, {"name": "omni"}),
        "perspective": (proxima.perspective, {**camera, "field_of_view": 0.7, "aspect": 1.0}),
        "orthographic": (proxima.orthographic, {**camera, "width": 1.0, "height": 1.0}),
    }
    return {**{name: (function, {**good, "progress": None}) for name, (function, good) in watched.items()}, **plain}


def wrong_values(good):
    """Of no use to any argument; then the good one as other arrays."""
    yield from (None, True, -1, 2**31, 2**63, -2**64, 10**30, 10**400, 0.5, np.nan, np.inf, -np.inf, 1j, "", "a\0b", "\ud800", b"\xff", [], {}, [[]], [np.nan],
                [[1, 2, 3], [4]], ["a"], [None], object(), int, lambda: None, MESH, CUBE.report(), Hostile(), {1}, range(3), np, np.float32(1),
                np.uint64(2**64 - 1), np.complex128(1 + 5j), np.str_("x"), np.datetime64("2020-01-01"), memoryview(b"abcdef")[::2], np.zeros((0, 3)), np.zeros((3, 0)))
    yield from map(without_value, (proxima.Mesh, proxima.Index, proxima.Topology, proxima.Octree, proxima.Polyhedron, proxima.MinkowskiSum,
                                   proxima.Scene, proxima.Solid, proxima.TouchScene, proxima.TouchRenderer))
    if isinstance(good, (np.ndarray, list, float, int)) and not isinstance(good, bool):
        try:
            array = np.array(good, float)
        except (TypeError, ValueError):
            return
        yield from (array.astype(kind) for kind in ("f2", "f4", ">f8", "g", "i8", "u8", "i1", "?", "O", "c16", "U5", "M8[s]"))
        yield from (np.asfortranarray(array), array[None], array.T, np.full_like(array, 1e308), np.full_like(array, -1), np.full_like(array, np.nan))
        if array.ndim:
            yield from (array[::-1], array[:0], array[..., :1], np.ma.array(array, mask=array > 0),
                        np.frombuffer(b"\0" + array.tobytes(), "u1")[1:].view("f8").reshape(array.shape),
                        np.lib.stride_tricks.as_strided(array, (2**55, *array.shape[1:]), (0, *array.strides[1:])))


@pytest.fixture(scope="module")
def table(tmp_path_factory):
    folder = tmp_path_factory.mktemp("files")
    before = os.getcwd()
    os.chdir(folder)
    yield calls(folder)
    os.chdir(before)


def test_the_table_has_every_function(table):
    without_arguments = {"Mesh.vertices", "Index.mesh", "Octree.leaves", "Polyhedron.mirrored", "TouchRenderer.reset"}
    functions = set()
    for name in proxima.__all__:
        thing = getattr(proxima, name)
        if isinstance(thing, type) and not issubclass(thing, (tuple, Exception)):
            functions |= {name} | {f"{name}.{member}" for member, value in vars(thing).items()
                                   if not member.startswith("_") and (inspect.isroutine(value) or isinstance(value, staticmethod))}
        elif inspect.isroutine(thing):
            functions.add(name)
    assert functions - without_arguments - {"MinkowskiSum", "ClosestOne"} == set(table)


def ask(function, arguments):
    """What it raises, or None."""
    try:
        function(**arguments)
    except KeyboardInterrupt:
        raise
    except BaseException as error:
        return error
    return None


def is_one_clear_error(error):
    if error is None or "hostile" in str(error):
        return True
    kinds = (proxima.Error, TypeError, MemoryError)  # the last of NumPy, whose sentence is clear
    return isinstance(error, kinds) and not isinstance(error, UnicodeError) and str(error) not in ("", "std::bad_alloc")


@pytest.mark.filterwarnings("ignore")
def test_any_object_is_answered_or_refused(table):
    unclear = []
    for name, (function, good) in table.items():
        error = ask(function, good)
        assert error is None or name == "TouchRenderer.replay", f"{name}: {error!r}"
        for argument, value in good.items():
            for wrong in wrong_values(value):
                error = ask(function, {**good, argument: wrong})
                if not is_one_clear_error(error):
                    unclear.append(f"{name}, {argument}, {type(wrong).__name__}: {error!r}")
    assert unclear == []


@pytest.mark.filterwarnings("error:Casting complex", "ignore::UserWarning")
def test_any_coordinate_is_answered_or_refused():
    index = proxima.Index(CUBE)
    for wrong in wrong_values(0.5):
        for k in range(3):
            given = [0.5, 0.5, 0.5]
            given[k] = wrong
            error = ask(lambda: index.closest_one(*given), {})
            assert is_one_clear_error(error), f"{k}, {type(wrong).__name__}: {error!r}"


@pytest.mark.filterwarnings("ignore")
@pytest.mark.parametrize("name, argument", [("Index.time_of_contact", "motion"), ("pose_at", "motion"), ("both_ways", "there"), ("both_ways", "back"),
                                            ("TouchScene.add", "texture"), ("TouchScene.set_material", "material"), ("Topology.patch", "closest")])
def test_any_column_is_answered_or_refused(table, name, argument):
    function, good = table[name]
    for field, value in good[argument]._asdict().items():
        for wrong in wrong_values(value):
            error = ask(function, {**good, argument: good[argument]._replace(**{field: wrong})})
            assert is_one_clear_error(error), f"{field}, {type(wrong).__name__}: {error!r}"


@pytest.mark.parametrize("name, argument, wrong, says", [
    ("Index.deviation", "max_splits", -1, "max_splits: must be 0 or more"), ("Index.deviation", "bins", 2**70, "bins: must be from 0 to 4096"),
    ("Index.deviation", "mean_tolerance", -1, "mean_tolerance: must be 0 or more, is -1.0"), ("Index.closest", "threads", -2**70, "threads: must be"),
    ("Index.deviation", "tolerance", np.nan, "^tolerance: must be 0 or more, is nan"), ("Mesh.report", "max_ids", -1, "max_ids: must be 0 or more"),
    ("Mesh.repair", "min_component_triangles", -1, "min_component_triangles: must be 0 or more"), ("Octree", "threshold", -1, "threshold: must be"),
    ("Octree", "max_depth", 20, "max_depth: must be from 0 to 19"), ("Index.distance_field", "resolution", -1, "resolution: must be"),
    ("Index.self_intersections", "max_pairs", -1, "max_pairs: must be 0 or more"), ("Index.nearest", "count", 0, "count: must be from 1"),
    ("Index.distance_to", "farthest", np.nan, "farthest: must be 0 or more, is nan"), ("pose_at", "time", np.nan, "time: must be finite"),
    ("pose_at", "time", 1e308, "time: the pose then is beyond the largest double"), ("pose_at", "time", -1e308, "time: the pose then is beyond"),
    ("Polyhedron.box", "upper", [0, 0, np.nan], "lower: must be at most upper along each axis, and no NaN"),
    ("Mesh.of_segments", "segments", [[0, 9]], "segment 0 uses point 9: there are only 5 points"), ("Mesh", "faces", [[0, 1, 99]], "triangle 0 uses vertex 99: there are only 42 vertices"),
    ("Index.contains", "points", np.ma.array(POINTS, mask=POINTS > 0), "points: must have no mask"),
    ("Index.contains", "points", [np.ma.array(row, mask=row > 0) for row in POINTS], "points: must have no mask"),
    ("Index.contains", "points", [[0.0, np.ma.masked, 1.0]], "points: must have no mask"),
    ("Index.contains", "points", SubclassOfMasked(POINTS, mask=POINTS > 0), "points: must have no mask"),
    ("Mesh.part", "triangles", np.ma.array([0, 1], mask=[0, 1]), "triangles: must have no mask"),
    ("Mesh.part", "triangles", np.array([2**64 - 1], "u8"), "triangles: has a number of 2.63 or more"), ("Mesh.sample", "name", "a\0b", "a\0b"),
    ("Mesh.read", "path", b"\xff.ply", r"\\xff\.ply")])
def test_says_what_is_wrong(table, name, argument, wrong, says):
    function, good = table[name]
    with pytest.raises(proxima.Error, match=says):
        function(**{**good, argument: wrong})


@pytest.mark.parametrize("name, argument, wrong, says", [
    ("both_ways", "there", 3, "there: must be a proxima.Deviation, is a int"), ("both_ways", "back", None, "back: must be a proxima.Deviation"),
    ("Index.closest", "columns", "distance", "columns: must be a tuple of names"), ("Index.closest", "columns", ["point", 3], r"columns\[1\]: must be .*, is a int"),
    ("Index.closest", "out", 3, "out: must be a proxima.Closest, is a int"), ("Mesh.weld", "progress", 3, "progress: must be None or a function"),
    ("Solid.overlaps", "other", without_value(proxima.Solid), "made by __new__ alone"),
    ("Index", "mesh", without_value(proxima.Mesh), "made by __new__ alone")])
def test_says_which_type_is_wrong(table, name, argument, wrong, says):
    function, good = table[name]
    with pytest.raises(TypeError, match=says):
        function(**{**good, argument: wrong})


@pytest.mark.parametrize("kind", [proxima.Mesh, proxima.Index, proxima.Topology, proxima.Octree, proxima.Polyhedron, proxima.MinkowskiSum,
                                  proxima.Scene, proxima.Solid, proxima.TouchScene, proxima.TouchRenderer])
def test_objects_without_a_value_are_refused(kind):
    empty = without_value(kind)
    with pytest.raises(TypeError, match="made by __new__ alone"):
        repr(empty)
    for name, member in vars(kind).items():
        if isinstance(member, property):
            with pytest.raises(TypeError, match="made by __new__ alone|incompatible"):
                getattr(empty, name)
    if kind is proxima.Index:
        with pytest.raises(TypeError, match="made by __new__ alone"):
            empty.closest_one(0, 0, 0)


@pytest.mark.parametrize("error", [KeyboardInterrupt, MemoryError, RuntimeError])
def test_errors_of_arguments_themselves_reach_the_caller(table, error):
    class Failing:
        def __array__(self, *_):
            raise error("hostile")

        __index__ = __array__

    for name, argument in (("Index.contains", "points"), ("Mesh.part", "triangles"), ("Index.nearest", "count"), ("Index.closest", "threads")):
        function, good = table[name]
        with pytest.raises(error, match="hostile"):
            function(**{**good, argument: Failing()})


def test_bytes_of_answers_do_not_wrap(tmp_path):
    rows, columns = 716165683, 2146470725
    assert rows * columns * 12 - 2**64 < 20_000  # bytes: they would wrap
    points = np.memmap(tmp_path / "points", float, "w+", shape=(rows, 3))  # a file of holes
    with pytest.raises(proxima.LimitExceeded, match="the answer needs at least 9223"):
        proxima.Index(CUBE).nearest(points, columns)


def test_intervals_must_be_in_order(table):
    function, good = table["both_ways"]
    for field in ("greatest", "mean", "root_mean_square"):
        for wrong in ([2, 1], [-1, 1], [0, np.nan], [1, 2, 3], [[0, 1]], None):
            if (field, wrong) == ("mean", None):  # without means
                continue
            with pytest.raises(proxima.InvalidInput, match=f"there.{field}: must be"):
                function(good["there"]._replace(**{field: wrong}), good["back"])
    for field in ("area", "area_error"):
        for wrong in (-1, np.nan, None, "x"):
            with pytest.raises(proxima.InvalidInput, match=f"back.{field}: must be"):
                function(good["there"], good["back"]._replace(**{field: wrong}))


def test_answers_may_overwrite_the_points():
    index = proxima.Index(proxima.Mesh.sample("torus:24x12"))
    numbers = np.random.default_rng(2).uniform(-2, 2, (9001, 3))
    points = numbers[:-1]
    expected = index.closest(points.copy())
    answer = index.closest(points, out=index.closest(points)._replace(point=numbers[1:]))
    assert all(np.array_equal(a, b) for a, b in zip(answer, expected))
    again = index.closest(answer.point, out=answer)
    assert np.abs(again.distance).max() < 1e-12


def test_numpy_s_false_cancels():
    mesh, asked = proxima.Mesh.sample("spaceship:60000"), []
    with pytest.raises(proxima.Cancelled):
        proxima.Index(mesh, lists=True, progress=lambda stage, part: np.bool_(False))
    proxima.Index(mesh, progress=lambda stage, part: asked.append(stage) or 0)  # not False
    assert asked
