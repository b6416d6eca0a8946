"""proxima touch with several objects, at rest and moving, as its users run it."""
import json
import os
import unittest
from pathlib import Path

from proxima_program import ProgramTest
from touch_report import KEYS, MEASURED, OF_A_DEVICE, SCRIPTS

STUB_DHD = os.environ.get("STUB_DHD", "")
SCENE = ("cube", "--object", "icosphere:2", "--object", "torus:24x12")
PLACES = ("--pose", "1=0,0,2.2", "--pose", "2=2.6,0,0@1,0,0,90")
MOTIONS = ("--motion", "0=rock:0,0,1,20,3", "--motion", "1=swing:0.5,0,-0.3,1.5", "--motion", "2=spin:0,0,1,90")


class Scenes(ProgramTest):
    """Several objects, at rest and moving."""

    def test_every_script_touches_objects_that_move(self):
        touched = [0, 0, 0]
        for script in SCRIPTS:
            session = self.folder / "session.pxt"
            report = self.json_of("touch", *SCENE, *PLACES, *MOTIONS, "--material", "1=200,0.5,0.2", "--device",
                                  "hand:" + script, "--seconds", 3, "--free-running", "--record", session)
            self.assertEqual(list(report), KEYS)
            self.assertEqual((report["triangles"], report["ticks"], report["moving_ticks"]), (12 + 320 + 576, 3000, 3000))
            self.assertEqual((report["passes"], report["overloaded_ticks"], report["faulty_ticks"]), (0, 0, 0), script)
            self.assertGreater(report["touching_ticks"], 50, script)
            self.assertLessEqual(report["max_force"], 3.3)
            touched = [sum + row["touching_ticks"] for sum, row in zip(touched, report["objects"])]
            again = self.json_of("touch", *SCENE, "--device", f"replay:{session}")
            self.assertEqual(again["replay_differences"], 0)
            for key in KEYS:
                if key not in (*MEASURED, *OF_A_DEVICE, "device", "replay_differences"):
                    self.assertEqual(report[key], again[key], key)
        self.assertGreater(min(touched), 100)

    def test_objects_are_as_they_were_asked_for(self):
        asked = ("touch", *SCENE, *PLACES, *MOTIONS, "--material", "1=200,0.5,0.2", "--material", "0=150",
                 "--damping", 2, "--device", "hand:press", "--seconds", 0.1, "--free-running")
        report = self.json_of(*asked)
        cube, ball, ring = report["objects"]
        self.assertEqual([row["model"] for row in report["objects"]], [SCENE[0], SCENE[2], SCENE[4]])
        self.assertEqual(ball["material"], {"stiffness": 200, "damping": 0.5, "static_friction": 0.2,
                                            "dynamic_friction": 0.75 * 0.2})
        self.assertEqual((cube["material"]["stiffness"], cube["material"]["damping"]), (150, 2))
        self.assertIsNone(ring["material"])
        lines = [line for line in self.succeed(*asked).splitlines() if " triangles, " in line]
        self.assertIn(" triangles, K 150 N/m, B 2 N s/m, friction ", lines[0])
        self.assertIn(" triangles, K 200 N/m, B 0.5 N s/m, friction 0.2 and 0.15, swings", lines[1])
        self.assertIn(" triangles, spins", lines[2])
        self.assertEqual(ball["pose"], [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 2.2])
        for is_, should in zip(ring["pose"], [1, 0, 0, 2.6, 0, 0, -1, 0, 0, 1, 0, 0]):
            self.assertAlmostEqual(is_, should)
        self.assertEqual(ball["motion"], {"kind": "swing", "along": [0.5, 0, -0.3], "degrees": 0, "seconds": 1.5})
        self.assertEqual((cube["motion"]["kind"], ring["motion"]["kind"]), ("rock", "spin"))
        self.assertAlmostEqual(ring["motion"]["degrees"], 90)
        # The workspace holds the ball at the end of its way, and nothing that is not reached.
        self.assertAlmostEqual(report["center"][2], (3.2 + -1.75) / 2, delta=0.4)

    def test_a_pose_turns_and_shifts(self):
        """A cube on its own feels the same wherever it stands, but for where it stands."""
        arguments = ("--device", "hand:press", "--seconds", 2, "--free-running", "--friction", 0)
        plain = self.json_of("touch", "cube", *arguments)
        matrix = "0=0,-1,0,5,1,0,0,6,0,0,1,7"
        for pose in (matrix, "0=5,6,7@0,0,1,90"):
            moved = self.json_of("touch", "cube", "--pose", pose, *arguments)
            self.assertEqual(moved["touching_ticks"], plain["touching_ticks"])
            self.assertAlmostEqual(moved["max_force"], plain["max_force"], places=6)
            for is_, should in zip(moved["center"], (5, 6, 7)):
                self.assertAlmostEqual(is_, should)

    def test_what_comes_at_a_hand_pushes_it(self):
        """What swings carries the hand along; what rests does not. At its ends, from word to word, it stands still."""
        still = self.json_of("touch", "cube", "--object", "cube", "--pose", "1=0,0,4", "--device", "hand:press",
                             "--seconds", 3, "--free-running", "--shading")
        self.assertEqual((still["moving_ticks"], still["passes"], still["shading"]), (0, 0, True))
        swung = self.json_of("touch", "cube", "--object", "cube", "--pose", "1=0,0,4", "--motion", "1=swing:0,0,-1.5,0.5",
                             "--device", "hand:press", "--seconds", 3, "--free-running")
        self.assertEqual((2500 < swung["moving_ticks"] <= 3000, swung["passes"]), (True, 0))
        self.assertGreater(swung["objects"][1]["max_carrying"], 0.01)
        self.assertEqual(swung["objects"][0]["max_carrying"], 0)

    def test_a_press_is_counted(self):
        """Two cubes that close on a hand between them leave it no room."""
        report = self.json_of("touch", "cube", "--object", "cube", "--pose", "0=-1.5,0,0", "--pose", "1=1.5,0,0",
                              "--motion", "0=swing:0.6,0,0,2", "--motion", "1=swing:-0.6,0,0,2", "--device", "hand:press",
                              "--seconds", 5, "--radius", 0.004, "--free-running")
        self.assertGreater(report["squeezed_ticks"], 0)
        self.assertEqual(report["passes"], 0)
        self.assertLessEqual(report["max_force"], 3.3)
        text = self.succeed("touch", *SCENE, *PLACES, "--device", "hand:press", "--seconds", 0.2, "--free-running")
        for part in ("3 objects", "1 icosphere:2: 320 triangles, rests", "2 torus:24x12"):
            self.assertIn(part, text)

    def test_a_saved_octree_in_a_scene(self):
        octree = self.folder / "torus.pxi"
        self.succeed("proximity", "torus:24x12", "--save", octree)
        arguments = (*PLACES, *MOTIONS, "--device", "hand:press", "--seconds", 1, "--free-running")
        results = [self.json_of("touch", *SCENE[:4], model, *arguments) for model in (SCENE[4], octree)]
        for result in results:
            for key in MEASURED:
                result.pop(key)
            result["objects"][2].pop("model")
        self.assertEqual(*results)

    def test_other_devices_touch_scenes(self):
        session = self.folder / "hd.pxt"
        report = json.loads(self.succeed("touch", *SCENE, *PLACES, *MOTIONS, "--device", "dhd", "--device-library", STUB_DHD,
                                         "--seconds", 1, "--record", session, "--json", "-"))
        self.assertEqual((report["passes"], len(report["objects"])), (0, 3))
        self.assertEqual(self.json_of("touch", *SCENE, "--device", f"replay:{session}")["replay_differences"], 0)

    def test_replays_want_what_was_touched(self):
        session = self.folder / "scene.pxt"
        feel = ("--device", "hand:press", "--seconds", 0.2, "--free-running")
        self.succeed("touch", *SCENE, *PLACES, *feel, "--record", session)
        replay = ("--device", f"replay:{session}")
        self.refuse("touch", "cube", *replay, says=("scene.pxt", "has 3 objects", "--object"))
        self.refuse("touch", "cube", "--object", "torus:24x12", "--object", "icosphere:2", *replay,
                    says=("scene.pxt", "as object 1", "torus:24x12"))
        for option, value in (("--pose", "1=0,0,0"), ("--motion", "1=spin:0,0,1,1"), ("--material", "1=1")):
            self.refuse("touch", *SCENE, option, value, *replay, status=2, says=(option, "as it was recorded"))
        single = self.folder / "single.pxt"
        self.succeed("touch", "cube", *feel, "--record", single)
        self.refuse("touch", "cube", "--object", "cube", "--device", f"replay:{single}", says=("single.pxt", "has 1 object"))

    def test_forged_recordings(self):
        """Under right checksums, one with a tick of 1e308 seconds, and sessions of today."""
        seeds = Path(__file__).resolve().parents[2] / "fuzz" / "corpus" / "recording"
        cubes = ("touch", "cube", "--object", "cube", "--object", "cube", "--device")
        self.refuse(*cubes, f"replay:{seeds / 'endless_tick.pxt'}",
                    says=("endless_tick.pxt", "tick_seconds is 1e+308 and must be 1e-06 to 1"))
        self.assertEqual(self.json_of(*cubes, f"replay:{seeds / 'scene.pxt'}")["ticks"], 24)
        for name in ("cube", "penalty"):
            self.assertEqual(self.json_of("touch", "cube", "--device", f"replay:{seeds / name}.pxt")["ticks"], 16)

    def test_usage(self):
        good = ("touch", *SCENE, "--device", "hand:press", "--seconds", 0.1, "--free-running")
        for option, wrong in (("--pose", ("", "1", "1=", "=0,0,0", "x=0,0,0", "-1=0,0,0", "1=0,0", "1=0,0,nan", "1=0,0,0,0",
                                          "1=0,0,0,0,0,0,90", "1=2,0,0,0,0,1,0,0,0,0,1,0", "1=-1,0,0,0,0,1,0,0,0,0,1,0")),
                              ("--motion", ("1=fly:0,0,1,1", "1=spin:0,0,1", "1=spin:0,0,0,1", "1=spin:0,0,1,2000",
                                            "1=spin:0,0,1,inf", "1=rock:0,0,1,10", "1=rock:0,0,1,10,0", "1=rock:0,0,1,99,0.01",
                                            "1=spin:0,0,1e-160,1", "1=spin:0,0,1e101,1", "1=rock:0,0,1,10,1e10",
                                            "1=swing:0,0,0,1", "1=swing:0,0,1,0", "1=swing:0,0,1,-1", "spin:0,0,1,1")),
                              ("--material", ("1=", "1=-1", "1=1,-1", "1=1,1,-1", "1=1,1,1,1", "1=nan", "1", "1=2e9"))):
            for value in wrong:
                self.refuse(*good, f"{option}={value}", status=2, says=option)
        for option, value in (("--pose", "3=0,0,0"), ("--motion", "9=spin:0,0,1,1"), ("--material", "3=1")):
            self.refuse(*good, option, value, says=(option, "there is no object", "0 to 2"))
        for option, value in (("--pose", "1=0,0,0"), ("--motion", "1=spin:0,0,1,1"), ("--material", "1=1")):
            self.refuse(*good, option, value, option, value, says=(option, "twice", "object 1"))
        self.refuse(*good, "--pose", "1=1e308,0,0", says="too far")
        self.refuse(*good, "--patch", 3, status=2, says=("--patch", "one model at rest"))
        self.refuse(*good, "--object", self.folder / "none.obj", says="none.obj")
        self.refuse(*good, *(["--object", "cube"] * 62), says=("--object", "64"))


if __name__ == "__main__":
    unittest.main()
