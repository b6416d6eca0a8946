"""Touch against a spring and a plane, against the interface for C, and against sessions of the program."""
import ctypes
import gc
import json
import os
import socket
import struct
import subprocess
import threading
import time
from pathlib import Path

import numpy as np
import pytest

import proxima

ROOT = Path(__file__).resolve().parents[2]

# One metre of the device is one unit of the model, whose origin is the device's.
PLAIN = {"units_per_metre": 1.0, "center": (0, 0, 0)}


@pytest.fixture
def wall():
    """A cube of 10 cm whose upper side is z = 0."""
    cube = proxima.Mesh.sample("cube")
    lower, upper = cube.bounds
    return proxima.Mesh((cube.vertices - [*(lower + upper)[:2] / 2, upper[2]]) / (upper - lower) * 0.1, cube.faces)


compared = pytest.mark.skipif("PROXIMA_PROGRAM" not in os.environ, reason="built without the program or the interface for C")


def press(depth, ticks=2000, across=0.0):
    """Positions from 2 cm above the wall to a depth below it, held for half of the ticks, and then along x."""
    z = np.concatenate([np.linspace(0.02, -depth, ticks // 2), np.full(ticks // 2, -depth)])
    return np.stack([np.concatenate([np.zeros(ticks // 2), np.linspace(0, across, ticks // 2)]), 0 * z, z], axis=1)


def same(a, b):
    """Whether all columns have the same bits."""
    return all(same(x, y) if isinstance(x, tuple) else np.asarray(x).tobytes() == np.asarray(y).tobytes() for x, y in zip(a, b))


def test_a_wall_is_a_spring(wall):
    renderer = proxima.TouchRenderer(wall, stiffness=300, **PLAIN)
    path = press(0.005)
    touch = renderer.step(path)
    above = path[:, 2] > 0
    assert (touch.force[above] == 0).all() and (touch.hold[above] == 0).all() and touch.placed.all() and not touch.fault.any()
    late = slice(1500, None)
    assert np.allclose(touch.force[late], [0, 0, 300 * 0.005], atol=1e-3)
    assert np.allclose(touch.proxy[late], [0, 0, 0], atol=1e-6) and np.allclose(touch.depth[late], 0.005, atol=1e-6)
    assert np.array_equal(touch.normal[late], np.tile([0, 0, 1.0], (500, 1)))
    contacts = touch.contacts
    assert contacts.first[-1] == len(contacts.triangle) and np.diff(contacts.first)[late].min() >= 1
    corners = wall.vertices[wall.faces[contacts.triangle]]
    assert np.allclose(corners[:, :, 2], 0) and np.allclose(contacts.normal, [0, 0, 1]) and not contacts.object.any()
    assert np.abs(contacts.position[:, 2]).max() < 1e-6
    assert renderer.options == {"stiffness": 300, "damping": 1, "proxy_radius": 0, "static_friction": 0.4, "dynamic_friction": 0.3}


def test_forces_are_limited_by_the_device(wall):
    limits = proxima.device_limits("omni")
    assert limits == proxima.DeviceLimits(*limits) and limits.max_force == 3.3
    renderer = proxima.TouchRenderer(wall, stiffness=1e4, **PLAIN)
    assert renderer.options["stiffness"] == limits.max_stiffness
    assert np.linalg.norm(renderer.step(press(0.03)).force, axis=1).max() == pytest.approx(limits.max_force)
    weak = proxima.TouchRenderer(wall, device=proxima.DeviceLimits(max_force=1), **PLAIN)
    assert np.linalg.norm(weak.step(press(0.03)).force, axis=1).max() == pytest.approx(1)


def test_friction_sticks_and_then_slides(wall):
    touch = proxima.TouchRenderer(wall, stiffness=300, static_friction=0.4, dynamic_friction=0.3, **PLAIN).step(
        press(0.004, 4000, across=0.02))
    words = [proxima.HOLDS[hold] for hold in touch.hold]
    assert words[2100] == "sticking" and words[-1] == "sliding"
    assert -touch.force[-1, 0] == pytest.approx(0.3 * touch.force[-1, 2], rel=0.02)
    smooth = proxima.TouchRenderer(wall, stiffness=300, static_friction=0, dynamic_friction=0, **PLAIN)
    assert np.abs(smooth.step(press(0.004, 4000, across=0.02)).force[2500:, 0]).max() < 1e-3


def test_damping_needs_velocities(wall):
    path = press(0.005)
    velocity = np.gradient(path, 1e-3, axis=0)
    damped = proxima.TouchRenderer(wall, damping=2, guard="off", **PLAIN).step(path, velocity)
    plain = proxima.TouchRenderer(wall, damping=2, guard="off", **PLAIN).step(path)
    pressing = slice(900, 990)
    assert np.allclose((damped.force - plain.force)[pressing, 2], -2 * velocity[pressing, 2], rtol=1e-6)


def test_ticks_one_by_one_are_those_of_an_array(index):
    random = np.random.default_rng(4)
    renderer = proxima.TouchRenderer(index)
    path = np.cumsum(random.normal(0, 4e-4, (6000, 3)), axis=0)  # more than a brief batch
    path[3000:3010] = np.nan
    velocity = random.normal(0, 0.1, path.shape)
    all_at_once = renderer.step(path, velocity, 1e-3)
    assert (np.linalg.norm(all_at_once.force, axis=1) > 0).sum() > 100
    assert [proxima.TOUCH_FAULTS[fault] for fault in all_at_once.fault[2999:3001]] == ["none", "not_finite"]
    renderer.reset()
    for i in range(len(path)):
        one = renderer.step(path[i], velocity[i], 1e-3)
        rows = slice(*all_at_once.contacts.first[i:i + 2])
        assert same(one[:-1], [column[i] for column in all_at_once[:-1]]), i
        assert same(one.contacts[1:], [column[rows] for column in all_at_once.contacts[1:]]), i
    assert isinstance(renderer.step([0, 0, 0]).force, np.ndarray) and renderer.step([0, 0, 0]).force.shape == (3,)


def test_the_model_is_fitted_into_the_workspace(index):
    renderer = proxima.TouchRenderer(index, device="omega")
    lower, upper = index.mesh().bounds
    radius = proxima.device_limits("omega").workspace_radius
    assert renderer.units_per_metre == pytest.approx(np.linalg.norm(upper - lower) / 2 / (0.6 * radius))
    assert np.allclose(renderer.center, (lower + upper) / 2)
    touch = renderer.step([0.01, 0.02, 0.03])
    assert np.allclose(touch.proxy, renderer.center + renderer.units_per_metre * np.array([0.01, 0.02, 0.03]))


class Tick(ctypes.Structure):
    class Contact(ctypes.Structure):
        _fields_ = [("position", ctypes.c_double * 3), ("normal", ctypes.c_double * 3), ("pressure", ctypes.c_double),
                    ("object", ctypes.c_uint32), ("triangle", ctypes.c_uint32)]

    _fields_ = [(name, ctypes.c_double * 3) for name in ("force", "proxy", "anchor", "normal")] + [
        ("depth", ctypes.c_double), ("hold", ctypes.c_int32), ("placed", ctypes.c_int32), ("fault", ctypes.c_int32),
        ("squeezed", ctypes.c_int32), ("count", ctypes.c_uint32), ("contacts", Contact * 3)]


def doubles(values):
    """As C takes them."""
    return (ctypes.c_double * np.size(values))(*np.ravel(values))


@compared
def test_devices_and_workspaces_are_those_of_the_interface_for_c():
    c = ctypes.CDLL(os.environ["PROXIMA_C_LIBRARY"])
    for name in ("touch", "omni", "desktop", "falcon", "omega", "delta"):
        limits = doubles([0] * 4)
        assert c.proxima_device_limits_of(name.encode(), limits) == 0
        assert list(limits) == list(proxima.device_limits(name)), name
    fitted = doubles([0] * 4)
    assert c.proxima_fit_workspace(doubles([1, 2, 3]), doubles([3, 4, 5]), ctypes.c_double(0.1), fitted) == 0
    scene = proxima.TouchScene([[1, 2, 3], [3, 4, 5]])
    scene.add(proxima.Mesh.sample("octahedron"), np.hstack([np.eye(3), [[2], [3], [4]]]))
    renderer = proxima.TouchRenderer(scene, device="omni")
    assert list(fitted) == [renderer.units_per_metre, *renderer.center] and fitted[1:] == [2, 3, 4]
    assert fitted[0] == pytest.approx(np.sqrt(3) / (0.6 * 0.1))


@compared
def test_the_interface_for_c_has_the_same_bits():
    c = ctypes.CDLL(os.environ["PROXIMA_C_LIBRARY"])

    def made(function, *arguments):
        thing = ctypes.c_void_p()
        assert function(*arguments, ctypes.byref(thing)) == 0
        return thing

    bounds, pose, options = [[-3] * 3, [3] * 3], np.hstack([np.eye(3), [[0.1], [0.2], [0.3]]]), (400, 1.5, 0.001, 0.5, 0.3)
    body = made(c.proxima_body_create, made(c.proxima_mesh_sample, b"torus:24x12"), doubles((350, 1, 0.6, 0.4)))
    other = made(c.proxima_body_create, made(c.proxima_mesh_sample, b"icosphere:3"), None)
    scene = made(c.proxima_scene_create, doubles(bounds[0]), doubles(bounds[1]))
    number = ctypes.c_uint32()
    for what, where in ((body, pose), (other, np.eye(4)[:3])):
        assert c.proxima_scene_add(scene, what, doubles(where), ctypes.byref(number)) == 0
    limits = proxima.device_limits("omni")
    map_of_c = doubles((0,) * 4)
    assert c.proxima_fit_workspace(doubles(bounds[0]), doubles(bounds[1]), ctypes.c_double(limits.workspace_radius), map_of_c) == 0
    rendered = made(c.proxima_renderer_create, scene, map_of_c, doubles(limits), bytes(doubles(options)) + b"\2\0\0\0\0\0\0\0")

    ours = proxima.TouchScene(bounds)
    assert ours.add(proxima.Mesh.sample("torus:24x12"), pose, material=proxima.Material(350, 1, 0.6, 0.4)) == 0
    assert ours.add(proxima.Mesh.sample("icosphere:3")) == 1 and ours.object_count == 2
    renderer = proxima.TouchRenderer(ours, **dict(zip(
        ("stiffness", "damping", "proxy_radius", "static_friction", "dynamic_friction"), options)))
    assert renderer.units_per_metre == map_of_c[0]

    random = np.random.default_rng(6)
    turn = np.linspace(0, 9, 3000)
    path = 0.013 * np.stack([np.cos(turn), np.sin(turn), 0.3 * np.sin(3 * turn)], axis=1)
    path += np.cumsum(random.normal(0, 3e-5, path.shape), axis=0)
    velocity = random.normal(0, 0.1, path.shape)
    there = pose + np.hstack([np.zeros((3, 3)), [[0.2], [0], [0]]])
    touched = 0
    for begin in (0, 1000, 2000):
        if begin == 1000:
            motion = doubles([*there.ravel(), 0.5, 0.01, 0, 0, 0, 0, 0.3, 0.2])
            assert c.proxima_scene_move(scene, 0, motion) == 0
            ours.move(0, there, seconds=0.5, velocity=(0.01, 0, 0), spin=(0, 0, 0.3), coast_seconds=0.2)
        touch = renderer.step(path[begin:begin + 1000], velocity[begin:begin + 1000])
        for i in range(1000):
            tick = Tick()
            assert c.proxima_renderer_tick(rendered, doubles(path[begin + i]), doubles(velocity[begin + i]), ctypes.c_double(1e-3),
                                           ctypes.byref(tick)) == 0
            for name in ("force", "proxy", "anchor", "normal", "depth"):
                assert np.asarray(getattr(tick, name)).tobytes() == getattr(touch, name)[i].tobytes(), (begin + i, name)
            assert (tick.hold, tick.placed, tick.fault, tick.squeezed) == (touch.hold[i], touch.placed[i], touch.fault[i], touch.squeezed[i])
            rows = range(*touch.contacts.first[i:i + 2])
            assert len(rows) == tick.count
            for row, contact in zip(rows, tick.contacts):
                assert (contact.object, contact.triangle) == (touch.contacts.object[row], touch.contacts.triangle[row])
                assert list(contact.position) == touch.contacts.position[row].tolist()
                assert contact.pressure == touch.contacts.pressure[row]
            touched += tick.count > 0
    assert touched > 500 and not np.array_equal(ours.pose(0), pose) and np.array_equal(ours.pose(1), np.eye(4)[:3])


def session(tmp_path, *arguments):
    """The report of a session of the program, which it recorded to a.pxt."""
    done = subprocess.run([os.environ["PROXIMA_PROGRAM"], "touch", *arguments, "--free-running", "--seconds", "2", "--quiet",
                           "--record", tmp_path / "a.pxt", "--json", "-"], capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    return json.loads(done.stdout)


@compared
def test_replays_a_session_of_the_program(tmp_path):
    session(tmp_path, "torus:24x12", "--device", "hand:slide", "--radius", "0.001", "--shading", "--texture", "grating:0.0002,0.004")
    mesh = proxima.Mesh.sample("torus:24x12")
    replay = proxima.TouchRenderer.replay(tmp_path / "a.pxt", mesh)
    assert len(replay.seconds) == 2000 and replay.differences == 0 and replay.tick_seconds == 1e-3
    assert np.allclose(replay.seconds, 1e-3 * np.arange(2000), rtol=0, atol=1e-9)
    assert replay.touch.force.tobytes() == replay.force.tobytes() and (np.linalg.norm(replay.force, axis=1) > 0.1).any()
    assert proxima.TouchRenderer.replay(str(tmp_path / "a.pxt"), proxima.Index(mesh, lists=True)).differences == 0
    session(tmp_path, "torus:24x12", "--device", "hand:press", "--force", "penalty")
    assert proxima.TouchRenderer.replay(tmp_path / "a.pxt", mesh).differences == 0


@compared
def test_steps_have_the_bits_of_the_program(tmp_path):
    session(tmp_path, "torus:24x12", "--device", "hand:press", "--friction", "0.5", "--stiffness", "350", "--limits", "omega")
    mesh = proxima.Mesh.sample("torus:24x12")
    replay = proxima.TouchRenderer.replay(tmp_path / "a.pxt", mesh)
    renderer = proxima.TouchRenderer(mesh, device="omega", stiffness=350, static_friction=0.5, dynamic_friction=0.375)
    assert renderer.units_per_metre == replay.units_per_metre and np.array_equal(renderer.center, replay.center)
    touch = renderer.step(replay.position, replay.velocity, replay.tick_seconds)
    assert touch.force.tobytes() == replay.force.tobytes() and (np.linalg.norm(touch.force, axis=1) > 0.1).any()


@compared
def test_textures_have_the_bits_of_the_program(tmp_path):
    session(tmp_path, "torus:24x12", "--device", "hand:stroke", "--friction", "0.5", "--texture", "grating:0.0003,0.004,0,1,0",
            "--texture", "viscosity:0.5", "--texture", "stick-slip:60,0.5", "--texture", "tap:3,120,60")
    mesh = proxima.Mesh.sample("torus:24x12")
    replay = proxima.TouchRenderer.replay(tmp_path / "a.pxt", mesh)
    texture = proxima.Texture("grating", 0.0003, 0.004, (0, 1, 0), viscosity=0.5, stick_slip_stiffness=60, stick_slip_force=0.5,
                              tap_gain=3, tap_frequency=120, tap_decay=60)
    for chosen in (texture, None):
        renderer = proxima.TouchRenderer(mesh, static_friction=0.5, dynamic_friction=0.375, texture=chosen)
        touch = renderer.step(replay.position, replay.velocity, replay.tick_seconds)
        assert (touch.force.tobytes() == replay.force.tobytes()) == (chosen is texture)


@compared
@pytest.mark.parametrize("bump", ["dimples", "noise"])
def test_bumps_have_the_bits_of_the_program(tmp_path, bump):
    session(tmp_path, "torus:24x12", "--device", "hand:stroke", "--friction", "0.5", "--texture", f"{bump}:0.0003,0.004")
    mesh = proxima.Mesh.sample("torus:24x12")
    replay = proxima.TouchRenderer.replay(tmp_path / "a.pxt", mesh)
    for chosen in ("grating", "dimples", "noise"):
        renderer = proxima.TouchRenderer(mesh, static_friction=0.5, dynamic_friction=0.375, texture=proxima.Texture(chosen, 0.0003, 0.004))
        touch = renderer.step(replay.position, replay.velocity, replay.tick_seconds)
        assert (touch.force.tobytes() == replay.force.tobytes()) == (chosen == bump), chosen


@compared
def test_replays_a_scene(tmp_path):
    session(tmp_path, "torus:24x12", "--object", "icosphere:3", "--pose", "1=3,0,0", "--motion", "0=rock:0,0,1,20,2",
            "--material", "1=200,1,0.2", "--shading", "--device", "hand:slide")
    models = [proxima.Mesh.sample("torus:24x12"), proxima.Mesh.sample("icosphere:3")]
    replay = proxima.TouchRenderer.replay(tmp_path / "a.pxt", models)
    assert replay.differences == 0 and replay.touch.force.tobytes() == replay.force.tobytes()
    assert (np.linalg.norm(replay.force, axis=1) > 0.1).any()
    for models, says in ((models[::-1], "model 0: is not the one that was recorded"),
                         (models[:1], "model: must be a list of the scene's 2"),
                         (models[0], "model: must be a list of the scene's 2")):
        with pytest.raises(proxima.InvalidInput, match=says):
            proxima.TouchRenderer.replay(tmp_path / "a.pxt", models)


@pytest.mark.parametrize("given, flags", [
    ({}, 1), ({"velocity": (1, 2, 3)}, 3), ({"spin": (0, 0, 5)}, 3), ({"velocity": (1, 2, 3), "spin": (0, -4, 5)}, 3),
    ({"material": (300, 1, 0.4, 0.3)}, 5), ({"spin": (6, 0, 0), "material": (300, 1, 0.4, 0.3)}, 7)])
def test_an_engine_sends_all_that_it_says_of_an_object(monkeypatch, given, flags):
    """By the table in docs/engine_channel.md: Proxima heeds what the flags name."""
    monkeypatch.syspath_prepend(ROOT / "examples")
    import engine_client

    number, told, *numbers = struct.unpack("<II17d", engine_client.pose_of(7, (0.1, 0.2, 0.3), (0.8, 0, 0.6, 0), **given))
    assert (number, told, numbers[:7]) == (7, flags, [0.1, 0.2, 0.3, 0.8, 0, 0.6, 0])
    assert numbers[7:10] == list(given.get("velocity", [0] * 3)) and numbers[10:13] == list(given.get("spin", [0] * 3))
    assert numbers[13:] == list(given.get("material", [0] * 4))


@compared
def test_replays_what_an_engine_moved(tmp_path, monkeypatch):
    monkeypatch.syspath_prepend(ROOT / "examples")
    import engine_client

    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as line:
        line.bind(("127.0.0.1", 0))
        name = f"udp:{line.getsockname()[1]}"
    program = subprocess.Popen([os.environ["PROXIMA_PROGRAM"], "touch", "cube", "--device", "hand:press", "--engine", name,
                                "--seconds", "2", "--quiet", "--record", tmp_path / "a.pxt"])
    channel = engine_client.open_channel(name)
    step = 0
    while program.poll() is None:
        channel.send([engine_client.pose_of(0, (0.02 * np.sin(0.2 * step), 0, 0.02 * np.sin(0.1 * step)),
                                            material=(200 + step, 1, 0.3, 0.2))])
        time.sleep(0.02)
        step += 1
    channel.close()
    assert program.returncode == 0
    replay = proxima.TouchRenderer.replay(tmp_path / "a.pxt", [proxima.Mesh.sample("cube")])
    assert replay.differences == 0 and (np.linalg.norm(replay.force, axis=1) > 0.1).any()


@compared
def test_replay_refuses(tmp_path, mesh):
    session(tmp_path, "cube", "--device", "hand:press")
    with pytest.raises(proxima.InvalidInput, match="model: is not the one that was recorded"):
        proxima.TouchRenderer.replay(tmp_path / "a.pxt", mesh)
    (tmp_path / "a.pxt").write_bytes((tmp_path / "a.pxt").read_bytes()[:-9])
    with pytest.raises(proxima.InvalidInput, match="a.pxt"):
        proxima.TouchRenderer.replay(tmp_path / "a.pxt", proxima.Mesh.sample("cube"))
    with pytest.raises(proxima.FileMissing):
        proxima.TouchRenderer.replay(tmp_path / "none.pxt", mesh)


def test_objects_move_bend_and_change(wall):
    scene = proxima.TouchScene([[-1, -1, -1], [1, 1, 1]])
    assert scene.add(proxima.Index(wall)) == 0
    renderer = proxima.TouchRenderer(scene, stiffness=300, **PLAIN)

    def force():
        return renderer.step(np.tile([0, 0, -0.002], (1000, 1))).force[-1, 2]

    renderer.step(press(0.002))
    assert force() == pytest.approx(0.6, rel=1e-3)
    scene.move(0, np.hstack([np.eye(3), [[0], [0], [0.001]]]), seconds=0.5)
    assert force() == pytest.approx(0.9, rel=1e-3) and scene.pose(0)[2, 3] == pytest.approx(0.001)
    scene.set_material(0, proxima.Material(stiffness=100))
    assert force() == pytest.approx(0.3, rel=1e-3)
    scene.deform(0, wall.vertices + [0, 0, 0.002], seconds=0.1)
    assert force() == pytest.approx(0.5, rel=1e-3)
    scene.deform(0, wall.vertices, seconds=0.1)
    assert force() == pytest.approx(0.3, rel=1e-3)
    scene.exchange(0, wall, material=(200, 1, 0.1, 0.1))
    assert force() == pytest.approx(0.6, rel=1e-3)


def test_poses_wait_for_a_tick_and_not_for_a_batch():
    scene = proxima.TouchScene([[-2, -2, -2], [2, 2, 2]])
    scene.add(proxima.Mesh.sample("icosphere:3"))
    away = np.tile([0.0, 0.0, 3.0], (200_000, 1))
    stopped = threading.Event()

    def touch(renderer):
        while not stopped.is_set():
            renderer.step(away)

    threads = [threading.Thread(target=touch, args=(proxima.TouchRenderer(scene),)) for _ in range(4)]
    for thread in threads:
        thread.start()
    begin = time.monotonic()
    for _ in range(10):
        assert np.array_equal(scene.pose(0), np.eye(3, 4))
    waited = time.monotonic() - begin
    stopped.set()
    for thread in threads:
        thread.join()
    assert waited < 10  # batches of four threads overlap: whoever waited for them waited for long


def test_materials_and_shapes_change_evenly(wall):
    scene = proxima.TouchScene([[-1, -1, -1], [1, 1, 1]])
    scene.add(wall, material=proxima.Material(300, 0, 0.4, 0.3))
    renderer = proxima.TouchRenderer(scene, **PLAIN)
    renderer.step(press(0.002))

    def force_after(ticks):
        return renderer.step(np.tile([0, 0, -0.002], (ticks, 1))).force[-1, 2]

    assert force_after(100) == pytest.approx(300 * 0.002, rel=1e-3)
    scene.set_material(0, proxima.Material(100, 0, 0.4, 0.3), seconds=1)
    assert force_after(500) == pytest.approx(200 * 0.002, rel=1e-2) and force_after(250) == pytest.approx(150 * 0.002, rel=1e-2)
    assert force_after(300) == pytest.approx(100 * 0.002, rel=1e-3)
    scene.deform(0, wall.vertices + [0, 0, 0.002], seconds=1)
    assert force_after(500) == pytest.approx(100 * 0.003, rel=1e-2) and force_after(250) == pytest.approx(100 * 0.0035, rel=1e-2)
    assert force_after(300) == pytest.approx(100 * 0.004, rel=1e-3)


@pytest.mark.parametrize("exchanged", [False, True])
def test_objects_have_textures_of_their_own(wall, exchanged):
    forces = []
    for texture in (None, proxima.Texture(viscosity=1)):
        own = {"texture": texture, "material": proxima.Material(300, 0, 0, 0)}
        scene = proxima.TouchScene([[-1, -1, -1], [1, 1, 1]])
        scene.add(wall, **({} if exchanged else own))
        if exchanged:
            scene.exchange(0, wall, **own)
        path = press(0.004, 4000, across=0.02)
        forces.append(proxima.TouchRenderer(scene, **PLAIN).step(path, np.gradient(path, 1e-3, axis=0)).force[-100:])
    assert np.allclose(forces[0][:, 0], 0, atol=1e-6)
    assert np.allclose(forces[1][:, 0], -1 * 0.02 / 2, rtol=0.1)  # 1 N s/m, 2 cm in two seconds


@pytest.mark.parametrize("exchanged", [False, True])
def test_shading_leans_forces_to_the_smooth_normal(exchanged):
    ball = proxima.Mesh.sample("icosphere:2")
    outward = ball.vertices[ball.faces[0]].T @ [0.2, 0.3, 0.5]
    outward /= np.linalg.norm(outward)
    angles = []
    for shading in (False, True):
        scene = proxima.TouchScene([[-2, -2, -2], [2, 2, 2]])
        scene.add(ball, shading=shading and not exchanged)
        if exchanged:
            scene.exchange(0, ball, shading=shading)
        renderer = proxima.TouchRenderer(scene, static_friction=0, dynamic_friction=0, shading=shading)
        path = np.linspace(1.2, 0.95, 1500)[:, None] * outward / renderer.units_per_metre
        force = renderer.step(path).force[-1]
        angles.append(np.degrees(np.arccos(force @ outward / np.linalg.norm(force))))
    assert angles[1] < 0.5 * angles[0] and angles[0] > 1


def test_renderers_keep_what_they_touch(wall):
    scene = proxima.TouchScene([[-1, -1, -1], [1, 1, 1]])
    scene.add(wall)
    renderer = proxima.TouchRenderer(scene, **PLAIN)
    expected = renderer.step(press(0.005))
    renderer.reset()
    del scene, wall
    gc.collect()
    assert same(renderer.step(press(0.005)), expected)


def test_threads_touch_one_scene(wall):
    scene = proxima.TouchScene([[-1, -1, -1], [1, 1, 1]])
    scene.add(wall)
    renderers = [proxima.TouchRenderer(scene, **PLAIN) for _ in range(4)]
    expected = proxima.TouchRenderer(wall, **PLAIN).step(press(0.005, 20000)).force
    forces = [None] * len(renderers)

    def feel(i):
        forces[i] = renderers[i].step(press(0.005, 20000)).force

    threads = [threading.Thread(target=feel, args=(i,)) for i in range(len(renderers))]
    for thread in threads:
        thread.start()
    while any(thread.is_alive() for thread in threads):
        assert scene.pose(0).shape == (3, 4)
    for thread in threads:
        thread.join()
    assert all(np.allclose(force, expected, atol=1e-6) for force in forces)


def test_poses_are_told_while_objects_are_added(wall):
    scene = proxima.TouchScene([[-100, -1, -1], [100, 1, 1]])
    scene.add(wall)
    wrong, ending = [], threading.Event()

    def ask():
        while not ending.is_set():
            for number in range(scene.object_count):
                x = scene.pose(number)[0, 3]
                if x != number:
                    wrong.append((number, x))

    threads = [threading.Thread(target=ask) for _ in range(2)]
    for thread in threads:
        thread.start()
    for number in range(1, 64):
        scene.add(wall, np.hstack([np.eye(3), [[number], [0], [0]]]))
    renderers = [proxima.TouchRenderer(scene, **PLAIN) for _ in range(8)]
    ending.set()
    for thread in threads:
        thread.join()
    assert (wrong, scene.object_count, len(renderers)) == ([], 64, 8)


def test_calls_of_one_renderer_wait_for_one_another(wall):
    """Friction holds the proxy back, so what is felt depends on the way so far, and on no other call's ticks in between."""
    turn = np.linspace(0, 2 * np.pi, 5000)
    path = np.stack([0.02 * np.sin(turn), 0.02 * np.cos(turn), 0.002 - 0.006 * np.sin(turn / 2)], axis=1)
    one_by_one = proxima.TouchRenderer(wall, **PLAIN)
    expected = [one_by_one.step(path) for _ in range(4)]
    renderer = proxima.TouchRenderer(wall, **PLAIN)
    ready = threading.Barrier(4)
    answers = []

    def step():
        ready.wait()
        answers.append(renderer.step(path))

    threads = [threading.Thread(target=step) for _ in range(4)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert len(answers) == 4 and (expected[0].hold != 0).any()
    for answer in answers:  # in any order
        found = [same(answer, other) for other in expected]
        assert any(found)
        del expected[found.index(True)]


def test_progress_stops_touching(wall):
    renderer = proxima.TouchRenderer(wall, **PLAIN)
    with pytest.raises(proxima.Cancelled):
        renderer.step(np.tile([0, 0, -0.01], (3_000_000, 1)), progress=lambda stage, part: False)


BOX = [[-1, -1, -1], [1, 1, 1]]
TURNED = [[2, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, 0]]


@pytest.mark.parametrize("ask, says", [
    (lambda w: proxima.TouchScene([[0, 0, 0]]), r"bounds: must be lowest and highest corner, \(2, 3\)"),
    (lambda w: proxima.TouchScene(BOX[::-1]), "bounds: must be finite and not flat, the lowest corner first"),
    (lambda w: proxima.TouchScene([BOX[0], [1, 1, -1]]), "bounds: must be finite and not flat"),
    (lambda w: proxima.TouchScene([[-1e308] * 3, [1e308] * 3]), "bounds: must be finite and not flat"),
    (lambda w: proxima.TouchScene(BOX).add(w, np.zeros((2, 3, 4))),
     r"pose: must be one pose, of shape \(3, 4\) or \(4, 4\), has \(2, 3, 4\)"),
    (lambda w: proxima.TouchScene(BOX).add(w, TURNED), "pose: "),
    (lambda w: proxima.TouchScene(BOX).add(w, [[1, 0, 0, 5], [0, 1, 0, 0], [0, 0, 1, 0]]), "bounds"),
    (lambda w: proxima.TouchScene(BOX).add(w, material=(1, 2)), "material: must be a Material"),
    (lambda w: proxima.TouchScene(BOX).add(w, material=proxima.Material(-1)), "stiffness|material"),
    (lambda w: proxima.TouchScene(BOX).move(0, np.eye(4)), "object: must be below 0, the number of objects, is 0"),
    (lambda w: proxima.TouchScene(BOX).pose(-1), "object: must be below 0, the number of objects, is -1"),
    (lambda w: proxima.TouchRenderer(w, texture=proxima.Texture("wood")),
     'texture.bump: must be "none", "grating", "dimples" or "noise", is "wood"'),
    (lambda w: proxima.TouchRenderer(w, texture=proxima.Texture("noise", "deep")), "texture.amplitude: must be a number"),
    (lambda w: proxima.TouchRenderer(w, texture=proxima.Texture("noise", 1)), "amplitude"),
    (lambda w: proxima.TouchRenderer(w, device="pen"), 'device: "pen" is not known: use one of touch omni'),
    (lambda w: proxima.TouchRenderer(w, device=(1, 2)), "device: must be a name or DeviceLimits"),
    (lambda w: proxima.TouchRenderer(w, device=(1, 2, 3, 0)), "device.workspace_radius: must be above 0"),
    (lambda w: proxima.TouchRenderer(w, guard="maybe"), 'guard: must be "off", "observe" or "on", is "maybe"'),
    (lambda w: proxima.TouchRenderer(w, stiffness=-1), "stiffness"),
    (lambda w: proxima.TouchRenderer(w, units_per_metre=0), "units_per_metre|unit"),
    (lambda w: proxima.TouchRenderer(w).step([0, 0]), r"position: must have shape \(3,\) or \(n, 3\), has \(2,\)"),
    (lambda w: proxima.TouchRenderer(w).step([0, 0, 0], [[0, 0, 0]]), "velocity: must have the shape of position"),
    (lambda w: proxima.TouchRenderer(w).step([0, 0, 0], seconds=0), "seconds: must be above 0 and finite"),
    (lambda w: proxima.device_limits("pen"), "device: .* is not known"),
])
def test_refuses(wall, ask, says):
    with pytest.raises(proxima.InvalidInput, match=says):
        ask(wall)


def test_closing_objects_squeeze_the_finger():
    scene = proxima.TouchScene([[-4] * 3, [4] * 3])
    side = np.hstack([np.eye(3), [[1.5], [0], [0]]])
    for pose in (side, side * np.where(np.arange(4) == 3, -1, 1)):
        scene.add(proxima.Mesh.sample("octahedron"), pose)
    renderer = proxima.TouchRenderer(scene, units_per_metre=1)
    assert not renderer.step([0, 0, 0]).squeezed
    for number in (0, 1):
        scene.move(number, np.eye(4), seconds=0.5)
    assert renderer.step(np.zeros((600, 3))).squeezed.any()


def test_scenes_are_whole_before_they_are_touched(wall):
    scene = proxima.TouchScene(BOX)
    scene.add(wall)
    renderer = proxima.TouchRenderer(scene)
    with pytest.raises(proxima.InvalidInput, match="add all objects before the first TouchRenderer is made"):
        scene.add(wall)
    with pytest.raises(TypeError, match="model: must be a proxima.Mesh, Index or TouchScene, is a list"):
        proxima.TouchRenderer([])
    with pytest.raises(TypeError, match="model: must be a proxima.Mesh or Index, is a int"):
        scene.add(3)
    with pytest.raises(TypeError, match="texture: must be a proxima.Texture, is a int"):
        proxima.TouchScene(BOX).add(wall, texture=3)
    with pytest.raises(proxima.InvalidInput, match="deform|vertices|positions"):
        scene.deform(0, wall.vertices[1:])
    assert "1 objects" in repr(scene) and "a scene" in repr(renderer)
