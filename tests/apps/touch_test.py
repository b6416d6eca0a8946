"""proxima touch: sessions of a simulated hand and of devices, recordings and their replay."""
import contextlib
import csv
import json
import math
import os
import pty
import re
import signal
import struct
import subprocess
import time
import unittest
import zlib

from proxima_program import PROXIMA, SANITIZED, ProgramTest, has_signal
from touch_report import KEYS, MEASURED, OF_A_DEVICE, SCRIPTS
from udp_hand import free_port

STUB_HD = os.environ.get("STUB_HD", "")


PNG_START = b"\x89PNG\r\n\x1a\n"


def chunk(kind, content):
    return struct.pack(">I", len(content)) + kind + content + struct.pack(">I", zlib.crc32(kind + content))


def grey_png(width, height, bits, greys):
    """A PNG of grey values, row by row from the top."""
    form = ">" + str(width) + ("H" if bits == 16 else "B")
    rows = b"".join(b"\0" + struct.pack(form, *greys[width * y:width * (y + 1)]) for y in range(height))
    return (PNG_START + chunk(b"IHDR", struct.pack(">IIBBBBB", width, height, bits, 0, 0, 0, 0)) + chunk(b"IDAT", zlib.compress(rows)) +
            chunk(b"IEND", b""))


def npy(kind, shape, content):
    header = f"{{'descr': '{kind}', 'fortran_order': False, 'shape': {shape}, }}".ljust(117) + "\n"
    return b"\x93NUMPY\x01\x00" + struct.pack("<H", len(header)) + header.encode() + content


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

    def test_lists_change_no_force(self):
        plain, listed, index = (self.folder / name for name in ("plain.pxt", "listed.pxt", "torus.pxi"))
        scene = ("--object", "icosphere:2", "--pose", "1=0,0,2.2")
        for script in SCRIPTS:
            for objects in ((), scene):
                session = ("touch", "torus:24x12", *objects, "--device", "hand:" + script, "--seconds", 1, "--free-running")
                self.succeed(*session, "--record", plain)
                self.succeed(*session, "--lists", "--record", listed)
                self.assertEqual(plain.read_bytes(), listed.read_bytes(), (script, objects))
        self.succeed("index", "torus:24x12", "--save", index)
        self.refuse("touch", index, "--device", "hand:press", "--lists", status=2, says=("--lists", "saved index"))

    def test_the_course_of_a_session(self):
        session = ("touch", "cube", "--device", "hand:press", "--seconds", 1, "--free-running")
        table, recording, again = (self.folder / name for name in ("course.csv", "course.pxt", "again.csv"))
        result = self.json_of(*session, "--picture", table, "--record", recording)
        lines = table.read_text().splitlines()
        self.assertEqual(lines[0], "seconds,x,y,z,force_x,force_y,force_z,depth,share,hold,condition")
        rows = [line.split(",") for line in lines[1:]]
        self.assertEqual(len(rows), 1000)
        self.assertEqual(sum(row[9] != "free" for row in rows), result["touching_ticks"])
        self.assertEqual(sum(row[9] == "sticking" for row in rows), result["sticking_ticks"])
        self.assertAlmostEqual(max(float(row[7]) for row in rows), result["max_depth"], places=12)
        largest = max(sum(float(x) ** 2 for x in row[4:7]) ** 0.5 for row in rows)
        self.assertAlmostEqual(largest, result["max_force"], places=12)
        # The force ramps up in a quarter of a second.
        self.assertAlmostEqual(float(rows[124][8]), 0.5, places=6)
        self.assertEqual((rows[249][8], rows[0][0], rows[999][0]), ("1", "0", "0.999"))
        self.succeed("touch", "cube", "--device", f"replay:{recording}", "--picture", again)
        self.assertEqual(again.read_bytes(), table.read_bytes())
        for name, begin in (("course.png", b"\x89PNG"), ("course.svg", b"<?xml"), ("course.pdf", b"%PDF")):
            self.assertIn(f"wrote {self.folder / name}", self.succeed(*session, "--picture", self.folder / name))
            self.assertEqual((self.folder / name).read_bytes()[:len(begin)], begin)
        self.refuse(*session, "--picture", self.folder / "course.foo", says=("course.foo", ".csv, .svg, .pdf or .png"))
        self.refuse("touch", "cube", "--device", "hand:press", "--seconds", 86400, "--picture", table,
                    says=("--picture", "GB in memory", "at most --seconds"))

    def test_words_and_json_say_what_was_felt(self):
        """How deep it was is known by the positions; without damping and friction Hooke says the force."""
        path, table = self.folder / "report.json", self.folder / "course.csv"
        text = self.succeed("touch", "cube", "--device", "hand:press", "--seconds", 2, "--free-running", "--damping", 0, "--friction", 0,
                            "--guard", "off", "--json", path, "--picture", table)
        report = json.loads(path.read_text())
        with open(table) as file:
            deepest = max(1 / report["units_per_metre"] - max(abs(float(row[x])) for x in "xyz") for row in csv.DictReader(file))
        self.assertGreater(deepest, 0.001)
        force, depth = map(float, re.search(r"; force at most (\S+) N, depth (\S+) mm\n", text).groups())
        self.assertAlmostEqual(report["max_depth"], deepest, delta=1e-12)
        self.assertAlmostEqual(report["max_force"], report["stiffness"] * deepest, delta=1e-9)
        self.assertAlmostEqual(depth, 1e3 * deepest, delta=0.0051)
        self.assertAlmostEqual(force, report["stiffness"] * deepest, delta=0.00051)
        times = [report["tick"][name + "_ns"] for name in ("p50", "p99", "p99_9", "p99_99", "max")]
        self.assertEqual(times, sorted(times))
        self.assertLess(times[0], times[-1])
        self.assertIn("computing a force: p50 %.2f, p99 %.2f, p99.9 %.2f, p99.99 %.2f, max %.2f us\n" % tuple(1e-3 * time for time in times), text)

    def test_ticks_that_guards_changed_are_counted(self):
        """A strong hand is given 3.3 N and no more, and 2 N more in a millisecond."""
        path, table = self.folder / "report.json", self.folder / "course.csv"
        session = ("touch", "cube", "--device", "hand:poke", "--seconds", 4, "--free-running", "--limits", "touch", "--stiffness", 9000,
                   "--hand-stiffness", 1000)
        text = self.succeed(*session, "--json", path, "--picture", table)
        report = json.loads(path.read_text())
        with open(table) as file:
            forces = [[float(row["force_" + x]) for x in "xyz"] for row in csv.DictReader(file)]
        limited = sum(math.hypot(*force) > 3.3 - 1e-9 for force in forces)
        slewed = sum(math.dist(*pair) > 2 - 1e-9 for pair in zip(forces, forces[1:]))
        clamped = report["clamped_ticks"]
        self.assertEqual(report["slewed_ticks"], slewed)
        self.assertGreater(limited, 10 * slewed)
        self.assertGreater(slewed, 0)
        self.assertTrue(limited <= clamped <= limited + slewed, clamped)  # some were both
        self.assertIn(f"force limited in {clamped}, its change limited in {slewed}\n", text)
        self.assertIn(f"guards: force limited in {clamped} ticks, its change in {slewed}\n", self.succeed(*session, "--verbose"))

    def test_patches_of_a_collision_loop(self):
        arguments = ("touch", "sphere:100x100", "--device", "hand:slide", "--seconds", 3)
        result = self.json_of(*arguments, "--free-running", "--patch", "16,1,3")
        many, one, three = result["patches"]
        self.assertEqual([row["patch"] for row in result["patches"]], ["rings 16", "rings 1", "rings 3"])
        self.assertLessEqual(many["waited_ticks"], 20)
        self.assertEqual((many["incomplete"], many["lost_ticks"]), (0, 0))
        self.assertGreater(many["touching_ticks"], 1000)
        self.assertEqual(many["patches"], 300)
        self.assertEqual((many["missed_ticks"], many["apart_ticks"]), (0, 0))
        self.assertGreater(one["missed_ticks"], three["missed_ticks"])
        self.assertGreater(three["mean_triangles"], one["mean_triangles"])
        for row in result["patches"]:
            self.assertTrue(0 < row["tick"]["p50_ns"] <= row["tick"]["max_ns"])
            self.assertAlmostEqual(row["percent_sent"], 100 * row["mean_triangles"] / 19800, places=9)
            self.assertLessEqual(row["oldest_ticks"], 20)
        live = self.json_of("touch", "cube", "--device", "hand:slide", "--seconds", 1, "--patch", 4,
                            "--collision-rate", 200, "--graphics-rate", 25)
        self.assertEqual(len(live["patches"]), 1)
        self.assertGreater(live["patches"][0]["patches"], 20)
        text = self.succeed(*arguments, "--free-running", "--patch", "2")
        self.assertIn("rings 2", text)
        self.assertIn("sent down", text)
        for wrong in ("", "some", "metric", "-1", "1,,2", "65", "1.5"):
            self.refuse("touch", "cube", "--device", "hand:slide", "--patch", wrong, status=2)

    def test_shaded_patches_are_held_against_what_is_shaded(self):
        for script in ("stroke", "walk"):
            result = self.json_of("touch", "icosphere:3", "--device", "hand:" + script, "--seconds", 2, "--free-running",
                                  "--shading", "--patch", 64)
            (row,) = result["patches"]
            self.assertEqual((result["shading"], row["missed_ticks"], row["apart_ticks"]), (True, 0, 0), script)
            self.assertGreater(row["touching_ticks"], 100 if SANITIZED else 300)

    def test_penalty_forces_are_the_baseline(self):
        """They pop and jump where a proxy does not, are recorded as what they are, and are of one model's point."""
        recording = self.folder / "penalty.pxt"
        plate = self.file("plate.obj", "".join(f"v {x} {y} {z}\n" for z in (-0.01, 0.01) for y in (-1, 1) for x in (-1, 1)) +
                          "".join(f"f {face}\n" for face in ("1 4 2", "1 3 4", "5 6 8", "5 8 7", "1 2 6", "1 6 5", "3 8 4",
                                                             "3 7 8", "1 5 7", "1 7 3", "2 4 8", "2 8 6")))
        arguments = ("touch", plate, "--device", "hand:poke", "--seconds", 4, "--free-running")
        proxy = self.json_of(*arguments, "--friction", 0)
        report = self.json_of(*arguments, "--force", "penalty", "--record", recording)
        self.assertEqual((proxy["force"], proxy["passes"]), ("proxy", 0))
        self.assertEqual((report["force"], report["static_friction"], report["sticking_ticks"]), ("penalty", 0, 0))
        self.assertGreater(report["passes"], 3)
        self.assertLess(report["touching_ticks"], proxy["touching_ticks"])
        again = self.json_of("touch", plate, "--device", f"replay:{recording}")
        self.assertEqual((again["force"], again["replay_differences"], again["passes"]), ("penalty", 0, report["passes"]))
        self.assertIn("by penalty forces", self.succeed(*arguments, "--force", "penalty"))
        for option in (("--radius", 0.001), ("--friction", 0.5), ("--shading",), ("--patch", 3), ("--object", "cube")):
            self.refuse(*arguments, "--force", "penalty", *option, status=2, says=("--force", option[0]))
        self.refuse(*arguments, "--force", "spring", status=2, says="--force")

    def test_textures_are_felt_and_replay(self):
        """Of all that is touched, and of an object alone; what makes no texture is wrong usage."""
        recording = self.folder / "textured.pxt"
        session = ("touch", "icosphere:3", "--device", "hand:slide", "--seconds", 3, "--free-running")
        plain = self.json_of(*session)
        self.assertIsNone(plain["texture"])
        self.assertEqual(plain["texture_report"], {"slips": 0, "taps": 0, "most_given": 0, "damped_ticks": 0})
        report = self.json_of(*session, "--texture", "noise:0.0001,0.003", "--texture", "viscosity:1", "--texture",
                              "stick-slip:150,0.3", "--texture", "tap:2,200,100", "--record", recording)
        for first, second in (("grating:0.0001,0.003", "noise:0.0001,0.003"), ("tap:2", "tap:2"), ("0=dimples:0.0001,0.003", "0=noise:0.0001,0.003")):
            self.refuse(*session, "--texture", first, "--texture", second, status=2, says=(first, second, "take the place of"))
        texture = report["texture"]
        self.assertEqual((texture["bump"], texture["wavelength"], texture["viscosity"]), ("noise", 0.003, 1))
        self.assertEqual((texture["stick_slip_stiffness"], texture["stick_slip_max_force"]), (150, 0.3))
        self.assertEqual((texture["tap_gain"], texture["tap_frequency"], texture["tap_decay"]), (2, 200, 100))
        self.assertLess(texture["amplitude"], 0.0001)  # limited by the device
        self.assertGreater(report["texture_report"]["slips"], 5)
        self.assertEqual((report["passes"], report["softenings"]), (0, 0))
        self.assertNotEqual(report["max_force"], plain["max_force"])
        self.assertIn("texture: noise of", self.succeed(*session, "--texture", "noise:0.00001,0.003"))
        again = self.json_of("touch", "icosphere:3", "--device", f"replay:{recording}")
        self.assertEqual((again["replay_differences"], again["texture_report"]), (0, report["texture_report"]))
        tapped = self.json_of("touch", "icosphere:3", "--device", "hand:press", "--seconds", 3, "--free-running", "--texture", "tap:2")
        self.assertGreater(tapped["texture_report"]["taps"], 1)
        self.assertLess(tapped["texture_report"]["most_given"], 1e-3)

        scene = (*session, "--object", "cube", "--pose", "1=0,0,2.2", "--texture", "viscosity:1", "--texture", "1=grating:1e-5,0.01,0,1,0")
        ball, cube = self.json_of(*scene, "--record", recording)["objects"]
        self.assertIsNone(ball["texture"])
        self.assertEqual((cube["texture"]["bump"], cube["texture"]["direction"], cube["texture"]["viscosity"]), ("grating", [0, 1, 0], 1))
        again = self.json_of("touch", "icosphere:3", "--object", "cube", "--device", f"replay:{recording}")
        self.assertEqual((again["replay_differences"], again["objects"][1]["texture"]), (0, cube["texture"]))

        for text in ("", "noise", "noise:1", "noise:1,1", "noise:1e-5,0", "grating:1e-5,0.01,0,0,0", "dimples:1e-5,0.01,1,0,0",
                     "viscosity:-1", "viscosity:nan", "stick-slip:1", "tap:1,2", "tap:1,5,80", "velvet:1", "x=viscosity:1", "=viscosity:1"):
            self.refuse(*session, "--texture", text, status=2, says="--texture")
        self.refuse(*session, "--texture", "1=viscosity:1", says=("--texture", "no object 1"))
        self.refuse(*session, "--texture", "viscosity:1", "--force", "penalty", status=2, says=("--force", "--texture"))
        self.refuse("touch", "icosphere:3", "--device", f"replay:{recording}", "--texture", "viscosity:1", status=2, says="--texture")

    def test_images_are_felt_and_replay(self):
        """As pictures and as arrays, of all that is touched and of an object alone."""
        recording = self.folder / "image.pxt"
        width, height = 12, 8
        greys = [round(127.5 + 127.5 * math.cos(2 * math.pi * (x / width + 2 * y / height))) for y in range(height) for x in range(width)]
        picture = self.file("waves, 3=a.png", grey_png(width, height, 8, greys))
        array = self.file("waves.npy", npy("|u1", (height, width), bytes(greys)))
        deep = self.file("deep.png", grey_png(width, height, 16, [257 * grey for grey in greys]))
        session = ("touch", "icosphere:3", "--device", "hand:slide", "--seconds", 2, "--free-running")
        plain = self.json_of(*session)
        report = self.json_of(*session, "--texture", f"image:{picture},0.0002,0.01", "--record", recording)
        texture = report["texture"]
        self.assertEqual((texture["bump"], texture["image"], texture["wavelength"]), ("image", [width, height], 0.01))
        self.assertEqual(texture["direction"], [0, 0, 1])
        self.assertLess(texture["amplitude"], 0.0002)  # limited by the device
        self.assertEqual((report["passes"], report["softenings"]), (0, 0))
        self.assertNotEqual(report["max_force"], plain["max_force"])
        self.assertIn("texture: image, 12 x 8, of", self.succeed(*session, "--texture", f"image:{picture},0.0002,0.01"))
        session_file = recording.read_bytes()
        picture.unlink()  # the recording has it
        again = self.json_of("touch", "icosphere:3", "--device", f"replay:{recording}")
        self.assertEqual((again["replay_differences"], again["texture"]), (0, texture))
        for same in (array, deep):
            self.succeed(*session, "--texture", f"image:{same},0.0002,0.01,0,0,1", "--record", recording)
            self.assertEqual(recording.read_bytes(), session_file, same)
        self.succeed(*session, "--texture", f"image:{array},0.0002,0.01,0,1,0", "--record", recording)
        self.assertNotEqual(recording.read_bytes(), session_file)

        scene = (*session, "--object", "cube", "--pose", "1=0,0,2.2", "--texture", "viscosity:1", "--texture", f"1=image:{array},1e-5,0.01")
        ball, cube = self.json_of(*scene, "--record", recording)["objects"]
        self.assertIsNone(ball["texture"])
        self.assertEqual((cube["texture"]["image"], cube["texture"]["viscosity"]), ([width, height], 1))
        again = self.json_of("touch", "icosphere:3", "--object", "cube", "--device", f"replay:{recording}")
        self.assertEqual((again["replay_differences"], again["objects"][1]["texture"]), (0, cube["texture"]))

        for text in ("image", "image:", "image:1e-5,0.01", f"image:{array}", f"image:{array},1e-5", f"image:{array},1,0.01",
                     f"image:{array},1e-5,0", f"image:{array},1e-5,0.01,0,0,0", f"=image:{array},1e-5,0.01"):
            self.refuse(*session, "--texture", text, status=2, says="--texture")
        colours = self.file("colours.png", PNG_START + chunk(b"IHDR", struct.pack(">IIBBBBB", 1, 1, 8, 2, 0, 0, 0)) + chunk(b"IDAT", b""))
        for name, says in ((self.folder / "none.png", "none.png"), (colours, "not a grey one"), (recording, "neither a PNG"),
                           (self.file("high.npy", npy("<f4", (1, 2), struct.pack("<ff", 0, 7))), "row 0, column 1")):
            self.refuse(*session, "--texture", f"image:{name},1e-5,0.01", says=says)
            self.refuse(*session, "--object", "cube", "--texture", f"1=image:{name},1e-5,0.01", says=says)

    def test_shaded_forces_replay(self):
        recording = self.folder / "shaded.pxt"
        result = self.json_of("touch", "icosphere:2", "--device", "hand:stroke", "--seconds", 2, "--free-running",
                              "--shading", "--record", recording)
        self.assertEqual((result["shading"], result["passes"]), (True, 0))
        again = self.json_of("touch", "icosphere:2", "--device", "replay:" + str(recording))
        self.assertEqual((again["shading"], again["replay_differences"]), (True, 0))

    def test_a_session_at_its_rate(self):
        result = self.json_of("touch", "cube", "--device", "hand:press", "--seconds", 0.5)
        servo = result["servo"]
        self.assertEqual(result["ticks"], 500)
        self.assertGreaterEqual(servo["seconds"], 0.499)
        self.assertLessEqual(servo["overslept"], servo["missed_deadlines"])
        self.assertGreater(servo["work"]["p50_ns"], result["tick"]["p50_ns"])
        self.assertEqual(servo["real_time_priority"] and servo["locked_memory"], servo["note"] == "")
        short = self.succeed("touch", "cube", "--device", "hand:press", "--seconds", 0.2)
        self.assertLessEqual(short.count("\n"), 8)
        for part in ("cube: 12 triangles", "passed through the surface 0 times", "servo: ", "deadlines missed"):
            self.assertIn(part, short)
        text = self.succeed("touch", "cube", "--device", "hand:press", "--seconds", 0.2, "--verbose")
        for part in ("cube: 12 triangles", "workspace: 1 m of the device is", "passed through the surface 0 times", "deadlines missed",
                     "real-time priority:"):
            self.assertIn(part, text)
        self.assertEqual(self.succeed("touch", "cube", "--device", "hand:press", "--seconds", 0.05, "--quiet"), "")
        # Between the ticks there is one interval less than ticks.
        self.assertIn("servo: 0.0 Hz", self.succeed("touch", "cube", "--device", "hand:press", "--seconds", 0.001))

    def test_the_same_seed_feels_the_same(self):
        def feel(seed):
            result = self.json_of("touch", "sphere:12x12", "--device", "hand:walk", "--seed", seed, "--seconds", 1,
                                  "--free-running")
            return {key: value for key, value in result.items() if key not in MEASURED}
        self.assertEqual(feel(3), feel(3))
        self.assertNotEqual(feel(3), feel(4))

    def test_the_hand_is_as_it_was_asked_for(self):
        usual = ("touch", "cube", "--device", "hand:press", "--seconds", 2, "--free-running")
        result = self.json_of(*usual)
        self.assertEqual(result["hand"], {"mass": 0.1, "stiffness": 150, "damping": 5, "device_damping": 0.5, "device_friction": 0,
                                          "encoder_step": 0, "delay": 0, "stable_stiffness": 3000})
        other = self.json_of(*usual, "--hand-mass", 0.2, "--hand-stiffness", 80, "--hand-damping", 2, "--device-damping", 0.3,
                             "--device-friction", 0.02, "--encoder-step", 2e-5, "--delay", 2)
        self.assertEqual(other["hand"], {"mass": 0.2, "stiffness": 80, "damping": 2, "device_damping": 0.3, "device_friction": 0.02,
                                         "encoder_step": 2e-5, "delay": 2, "stable_stiffness": 520})
        # A hand of twice the mass and less damping hits harder, a light and soft one presses less; pulled by nothing it touches nothing.
        self.assertGreater(other["max_force"], 1.2 * result["max_force"])
        self.assertLess(self.json_of(*usual, "--hand-stiffness", 75, "--hand-mass", 0.05)["max_force"], 0.8 * result["max_force"])
        self.assertEqual(self.json_of(*usual, "--hand-stiffness", 0)["max_force"], 0)
        self.assertIn("1 ticks late; if nobody held the device, walls stiffer than 1000 N/m would oscillate",
                      self.succeed(*usual, "--delay", 1, "--verbose"))

    def test_a_simulated_hand_has_no_buttons(self):
        self.refuse("touch", "cube", "--device", "hand:press", "--seconds", 0.1, "--clutch", 1, status=2, says=("--clutch", "no buttons"))

    def test_more_than_the_device_bears_is_said(self):
        free = ("touch", "cube", "--device", "hand:press", "--seconds", 0.1, "--free-running")
        text = self.succeed(*free, "--stiffness", 2000, "--damping", 9)
        self.assertIn("stiffness: 700 N/m of the 2000 asked for", text)
        self.assertIn("damping: 5 N s/m of the 9 asked for", text)
        for enough in (free, (*free, "--stiffness", 700), (*free, "--stiffness", 2000, "--limits", "delta")):
            self.assertNotIn("asked for", self.succeed(*enough))

    def test_late_forces_swing(self):
        """What the stability table says of walls holds on the command line too."""
        bare = ("touch", "cube", "--device", "hand:press", "--seconds", 4, "--free-running", "--damping", 0, "--hand-damping", 0,
                "--friction", 0)
        late = self.json_of(*bare, "--stiffness", 700, "--device-damping", 0.1, "--delay", 3)
        fresh = self.json_of(*bare, "--stiffness", 300, "--device-damping", 0.5)
        self.assertLess(late["hand"]["stable_stiffness"], 30)
        self.assertGreater(late["damped_ticks"], 100)
        # A hand without damping swings in and out and is damped, never softened.
        self.assertEqual((fresh["softened_ticks"], fresh["softenings"]), (0, 0))
        watched = self.json_of(*bare, "--stiffness", 700, "--device-damping", 0.1, "--delay", 3, "--guard", "observe")
        alone = self.json_of(*bare, "--stiffness", 700, "--device-damping", 0.1, "--delay", 3, "--guard", "off")
        self.assertEqual((late["guard"], watched["guard"], alone["guard"]), ("on", "observe", "off"))
        self.assertGreater(watched["swings"], 0)
        self.assertEqual(alone["swings"], 0)
        for key in ("max_force", "max_depth", "taken_energy"):
            self.assertEqual(watched[key], alone[key])
        text = self.succeed(*bare, "--stiffness", 700, "--device-damping", 0.1, "--delay", 3, "--guard", "observe")
        self.assertIn("the guard would have added damping", text)

    def test_limits_are_the_device_s(self):
        arguments = ("touch", "cube", "--device", "hand:press", "--seconds", 1, "--free-running", "--stiffness", 9000)
        for name, force, stiffness in (("touch", 3.3, 400), ("omni", 3.3, 700), ("falcon", 8, 3000)):
            result = self.json_of(*arguments, "--limits", name)
            self.assertEqual(result["stiffness"], stiffness)
            self.assertLessEqual(result["max_force"], force)

    def test_a_saved_octree_feels_as_its_mesh(self):
        octree = self.folder / "torus.pxi"
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
        report = self.json_of("touch", "torus:24x12", "--device", "hand:stroke", "--seconds", 2, "--free-running",
                              "--radius", 0.001, "--record", session)
        again = self.json_of("touch", "torus:24x12", "--device", f"replay:{session}")
        self.assertEqual(again["replay_differences"], 0)
        for key in KEYS:
            if key not in (*MEASURED, *OF_A_DEVICE, "device", "replay_differences"):
                self.assertEqual(report[key], again[key], key)
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


class Stopping(ProgramTest):
    def test_control_c_leaves_report_and_recording(self):
        session = self.folder / "session.pxt"
        for name, more in (("hand:press", ()), ("hd", ("--device-library", STUB_HD)), (f"udp:{free_port()}", ())):
            with subprocess.Popen([PROXIMA, "touch", "cube", "--device", name, *more, "--seconds", "60", "--record", session,
                                   "--json", "-"], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True) as process:
                time.sleep(1.5)
                process.send_signal(signal.SIGINT)
                text, error = process.communicate(timeout=60)
            self.assertEqual((process.returncode, error), (0, ""), name)
            report = json.loads(text)
            self.assertTrue(report["interrupted"])
            self.assertGreater(report["ticks"], 100)
            self.assertLess(report["ticks"], 50000)
            again = self.json_of("touch", "cube", "--device", f"replay:{session}")
            self.assertEqual((again["replay_differences"], again["ticks"]), (0, report["ticks"]))
            session.unlink()

    @contextlib.contextmanager
    def session(self):
        """A session of a minute, once it handles signals."""
        with subprocess.Popen([PROXIMA, "touch", "cube", "--device", "hand:press", "--seconds", "60", "--json", "-"],
                              stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True) as process:
            while not has_signal(process.pid, "SigCgt", signal.SIGINT):
                self.assertIsNone(process.poll())
                time.sleep(0.01)
            time.sleep(0.3)
            yield process

    def interrupt(self, process):
        """Sends SIGINT and waits until it is handled."""
        process.send_signal(signal.SIGINT)
        while process.poll() is None and has_signal(process.pid, "ShdPnd", signal.SIGINT):
            pass

    def test_a_signal_that_comes_twice_at_once_lets_the_force_fade(self):
        for _ in range(20):  # a busy machine may come to the second one late
            with self.session() as process:
                begin = time.monotonic()
                self.interrupt(process)
                process.send_signal(signal.SIGINT)
                passed = time.monotonic() - begin
                text, error = process.communicate(timeout=60)
            if passed < 0.03:  # while the force fades, and long before a quarter of a second
                self.assertEqual((process.returncode, error), (0, ""))
                self.assertTrue(json.loads(text)["interrupted"])
                return
        self.fail("two signals never came within 0.03 s")

    def test_a_signal_that_comes_again_later_ends_the_program(self):
        for _ in range(20):  # a busy machine may come to stop it after its end
            with self.session() as process:
                self.interrupt(process)
                process.send_signal(signal.SIGSTOP)
                time.sleep(0.3)
                process.send_signal(signal.SIGINT)
                process.send_signal(signal.SIGCONT)
                process.communicate(timeout=60)
            if process.returncode != 0:
                self.assertEqual(process.returncode, -signal.SIGINT)
                return
        self.fail("the session was never stopped before its end")

    def test_a_reader_that_leaves_does_not_end_the_session(self):
        report = self.folder / "report.json"
        with subprocess.Popen([PROXIMA, "touch", "cube", "--device", "hand:press", "--seconds", "1.5", "--progress", "--json", report],
                              stdout=subprocess.PIPE, stderr=subprocess.PIPE) as process:
            process.stderr.close()
            process.stdout.close()
            self.assertEqual(process.wait(timeout=60), 1)  # its words could not be written
        self.assertGreater(json.loads(report.read_text())["ticks"], 1000)

    def test_a_terminal_shows_rate_and_force(self):
        master, terminal = pty.openpty()
        with subprocess.Popen([PROXIMA, "touch", "cube", "--device", "hand:press", "--seconds", "1"], stderr=terminal,
                              stdout=subprocess.PIPE) as process:
            os.close(terminal)
            shown = b""
            try:
                while chunk := os.read(master, 4096):
                    shown += chunk
            except OSError:  # the other end is closed
                pass
            process.communicate()
        os.close(master)
        self.assertEqual(process.returncode, 0)
        self.assertRegex(shown.decode(), r"\d Hz +\d\.\d+ N (free|sticking|sliding)")


class Refusing(ProgramTest):
    def test_usage(self):
        self.refuse("touch", "cube", status=2, says="--device")
        for device in ("hand", "hand:", "hand:hit", "replay:", "replay", "omni", "udp", "udp:", "udp:x", "udp:1:2",
                       "udp:70000", "hd:", "dhd:", "dhd:x", "dhd:-1"):
            self.refuse("touch", "cube", "--device", device, status=2, says=("--device", "hand:SCRIPT", "press"))
        good = ("touch", "cube", "--device", "hand:press")
        for option in ("--seconds=0", "--seconds=nan", "--seconds=-1", "--stiffness=-1", "--damping=-1", "--radius=-1",
                       "--friction=-0.1", "--limits=hammer", "--seed=-1", "--scale=0", "--axes=x,y", "--axes=x,x,z",
                       "--axes=y,x,z", "--clutch=0", "--clutch=33", "--hand-mass=0", "--hand-mass=nan", "--hand-stiffness=-1",
                       "--hand-damping=-1", "--device-damping=-1", "--device-friction=-1", "--encoder-step=-1", "--encoder-step=1",
                       "--delay=-1", "--delay=65", "--delay=1.5"):
            self.refuse(*good, option, status=2, says=option.split("=")[0])
        self.refuse("touch", "cube", "--device", "udp:9", "--free-running", status=2, says=("--free-running", "simulated hand"))

    def test_options_without_effect(self):
        session = self.folder / "session.pxt"
        self.succeed("touch", "cube", "--device", "hand:press", "--seconds", 0.1, "--free-running", "--record", session)
        for option, value in (("--record", "again.pxt"), ("--stiffness", 100), ("--seconds", 1), ("--patch", 3),
                              ("--limits", "touch"), ("--free-running", None), ("--hand-mass", 0.2), ("--delay", 1)):
            extra = (option,) if value is None else (option, value)
            self.refuse("touch", "cube", "--device", f"replay:{session}", *extra, status=2, says=(option, "as it was recorded"))
        good = ("touch", "cube", "--device", "hand:press")
        self.refuse(*good, "--collision-rate", 50, status=2, says=("--collision-rate", "--patch"))
        self.refuse(*good, "--device-library", "libHD.so", status=2, says=("--device-library", "hd and dhd"))
        self.refuse(*good, "--patch", 3, "--record", self.folder / "a.pxt", status=2, says=("--record", "--patch"))
        self.refuse(*good, "--seconds", 86400, "--record", self.folder / "a.pxt", says=("--record", "GB", "--seconds"))
        for option in ("--seed", "--hand-mass", "--hand-stiffness", "--hand-damping", "--device-damping", "--device-friction", "--delay"):
            self.refuse("touch", "cube", "--device", "udp:9", option, 4, status=2, says=(option, "simulated hand"))
        for seed in ("99999999999999999999999", "-1", "1.5"):
            self.refuse(*good, "--seed", seed, status=2, says=("--seed", "whole number"))

    def test_models_and_outputs(self):
        self.refuse("touch", self.folder / "none.obj", "--device", "hand:press", says="none.obj")
        flat = self.file("flat.off", "OFF\n3 1 0\n0 0 0\n1 0 0\n2 0 0\n3 0 1 2\n")
        self.refuse("touch", flat, "--device", "hand:press", says="area")
        self.refuse("touch", "cube", "--device", "hand:press", "--record", self.folder / "no" / "a.pxt", says="a.pxt")


if __name__ == "__main__":
    unittest.main()
