"""proxima touch: sessions of a simulated hand, recordings and their replay."""
import unittest

from proxima_program import ProgramTest

KEYS = ["model", "triangles", "device", "build_seconds", "units_per_metre", "center", "stiffness", "damping",
        "static_friction", "dynamic_friction", "radius", "ticks", "touching_ticks", "sticking_ticks", "passes",
        "limited_ticks", "overloaded_ticks", "faulty_ticks", "max_force", "max_spring", "max_depth", "max_speed",
        "max_step_ratio", "max_turn_degrees", "taken_energy", "max_moves", "clamped_ticks", "slewed_ticks",
        "damped_ticks", "lowest_energy", "tick", "servo", "replay_differences"]
SCRIPTS = ("press", "slide", "stroke", "corner", "poke", "walk")
MEASURED = ("build_seconds", "tick", "servo")


class Touching(ProgramTest):
    def test_every_script(self):
        for script in SCRIPTS:
            result = self.json_of("touch", "torus:24x12", "--device", "hand:" + script, "--seconds", 2, "--free-running")
            self.assertEqual(list(result), KEYS)
            self.assertEqual((result["triangles"], result["ticks"], result["servo"]), (576, 2000, None))
            self.assertGreater(result["touching_ticks"], 50, script)
            self.assertEqual((result["passes"], result["overloaded_ticks"], result["faulty_ticks"]), (0, 0, 0), script)
            self.assertLessEqual(result["max_force"], 3.3)
            self.assertGreater(result["max_force"], 0.1)

    def test_a_session_at_its_rate(self):
        result = self.json_of("touch", "cube", "--device", "hand:press", "--seconds", 0.5)
        servo = result["servo"]
        self.assertEqual(result["ticks"], 500)
        self.assertGreaterEqual(servo["seconds"], 0.499)
        self.assertEqual(servo["real_time_priority"] and servo["locked_memory"], servo["note"] == "")
        text = self.succeed("touch", "cube", "--device", "hand:press", "--seconds", 0.2)
        for part in ("cube: 12 triangles", "workspace: 1 m of the device is", "passed through: 0", "deadlines missed",
                     "real-time priority:"):
            self.assertIn(part, text)
        self.assertEqual(self.succeed("touch", "cube", "--device", "hand:press", "--seconds", 0.05, "--quiet"), "")

    def test_the_same_seed_feels_the_same(self):
        def feel(seed):
            result = self.json_of("touch", "sphere:12x12", "--device", "hand:walk", "--seed", seed, "--seconds", 1,
                                  "--free-running")
            return {key: value for key, value in result.items() if key not in MEASURED}
        self.assertEqual(feel(3), feel(3))
        self.assertNotEqual(feel(3), feel(4))

    def test_limits_are_the_device_s(self):
        arguments = ("touch", "cube", "--device", "hand:press", "--seconds", 1, "--free-running", "--stiffness", 9000)
        for name, force, stiffness in (("touch", 3.3, 400), ("omni", 3.3, 700), ("falcon", 8, 3000)):
            result = self.json_of(*arguments, "--limits", name)
            self.assertEqual(result["stiffness"], stiffness)
            self.assertLessEqual(result["max_force"], force)

    def test_a_saved_octree_feels_as_its_mesh(self):
        octree = self.folder / "torus.pxp"
        self.succeed("proximity", "torus:24x12", "--save", octree)
        results = [self.json_of("touch", model, "--device", "hand:slide", "--seconds", 1, "--free-running")
                   for model in ("torus:24x12", octree)]
        for result in results:
            for key in (*MEASURED, "model"):
                result.pop(key)
        self.assertEqual(*results)


class Recording(ProgramTest):
    def test_replays_bit_for_bit(self):
        session = self.folder / "session.pxt"
        felt = self.json_of("touch", "torus:24x12", "--device", "hand:stroke", "--seconds", 2, "--free-running",
                            "--radius", 0.001, "--record", session)
        again = self.json_of("touch", "torus:24x12", "--device", f"replay:{session}")
        self.assertEqual(again["replay_differences"], 0)
        for key in KEYS:
            if key not in (*MEASURED, "device", "replay_differences"):
                self.assertEqual(felt[key], again[key], key)
        self.assertIn("0 ticks differ", self.succeed("touch", "torus:24x12", "--device", f"replay:{session}"))

    def test_what_is_no_recording_is_refused(self):
        session = self.folder / "session.pxt"
        self.succeed("touch", "cube", "--device", "hand:press", "--seconds", 0.1, "--free-running", "--record", session)
        replay = f"replay:{session}"
        self.refuse("touch", "octahedron", "--device", replay, says=("session.pxt", "another model"))
        data = bytearray(session.read_bytes())
        data[-1] ^= 1
        session.write_bytes(data)
        self.refuse("touch", "cube", "--device", replay, says="session.pxt")
        session.write_bytes(data[:100])
        self.refuse("touch", "cube", "--device", replay, says="session.pxt")
        self.refuse("touch", "cube", "--device", "replay:" + str(self.folder / "none.pxt"), says="none.pxt")


class Refusing(ProgramTest):
    def test_usage(self):
        self.refuse("touch", "cube", status=2, says="--device")
        for device in ("hand", "hand:", "hand:hit", "replay:", "replay", "omni", "udp:9"):
            self.refuse("touch", "cube", "--device", device, status=2, says=("--device", "hand:SCRIPT", "press"))
        good = ("touch", "cube", "--device", "hand:press")
        for option in ("--seconds=0", "--seconds=nan", "--seconds=-1", "--stiffness=-1", "--damping=-1", "--radius=-1",
                       "--friction=-0.1", "--limits=hammer", "--seed=-1"):
            self.refuse(*good, option, status=2, says=option.split("=")[0])

    def test_models_and_outputs(self):
        self.refuse("touch", self.folder / "none.obj", "--device", "hand:press", says="none.obj")
        flat = self.file("flat.off", "OFF\n3 1 0\n0 0 0\n1 0 0\n2 0 0\n3 0 1 2\n")
        self.refuse("touch", flat, "--device", "hand:press", says="area")
        self.refuse("touch", "cube", "--device", "hand:press", "--record", self.folder / "no" / "a.pxt", says="a.pxt")


if __name__ == "__main__":
    unittest.main()
