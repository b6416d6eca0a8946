"""proxima contacts and contact-time as their users run them, on shapes whose answers are known."""
import json
import math
import unittest

from bad_input_test import off
from proxima_program import ProgramTest, run

TIME_KEYS = ["a", "b", "triangles_a", "triangles_b", "build_seconds", "rotation_error", "center", "displacement", "turn", "contact", "evidence",
             "free_until", "touches_at", "free_pose", "distance", "point_a", "point_b", "triangle_a", "triangle_b", "normal", "steps",
             "seconds"]
POSE_KEYS = ["method", "lower", "upper", "direction", "translation", "deepest", "depth_seconds", "regions", "region_seconds"]
REGION_KEYS = ["position", "normal", "depth", "length", "area", "lines", "points"]


class ContactTime(ProgramTest):
    def test_two_cubes_meet_halfway(self):
        found = self.json_of("contact-time", "cube", "cube", "--from", "4,0.3,0.1", "--to", "0,0.3,0.1")
        self.assertEqual(list(found), TIME_KEYS)
        self.assertTrue(found["contact"])
        self.assertEqual(found["evidence"], "intersection")
        self.assertLessEqual(found["free_until"], 0.5)
        self.assertGreaterEqual(found["touches_at"], 0.5)
        self.assertLess(found["touches_at"] - found["free_until"], 1.1e-9)
        self.assertEqual(found["displacement"], [-4, 0, 0])
        self.assertEqual([round(x, 9) for x in found["normal"]], [1, 0, 0])
        # The pose that it prints is free, and the meshes there are as far apart as it says.
        pose = ",".join(map(repr, found["free_pose"]))
        there = self.json_of("intersect", "cube", "cube", "--pose", pose, "--distance")["poses"][0]
        self.assertFalse(there["intersecting"])
        self.assertEqual(there["separation"], found["distance"])
        text = self.succeed("contact-time", "cube", "cube", "--from", "4,0.3,0.1", "--to", "0,0.3,0.1")
        self.assertIn("touches at 0.5", text)

    def test_free_motions_and_starts_in_contact(self):
        found = self.json_of("contact-time", "cube", "cube", "--from", "4,0,0", "--to", "2.5,9,0")
        self.assertFalse(found["contact"])
        self.assertNotIn("free_until", found)
        self.assertIn("no contact", self.succeed("contact-time", "cube", "cube", "--from", "4,0,0", "--to", "2.5,9,0"))
        found = self.json_of("contact-time", "cube", "cube", "--to", "9,0,0")
        self.assertEqual([found["free_until"], found["touches_at"]], [0, 0])

    def test_turns_about_a_center(self):
        # A bar from 1 to 3 on the x axis turns about the origin into a wall that begins at y = 2.
        corners = [(x, y, z) for x in (1, 3) for y in (-0.01, 0.01) for z in (-0.1, 0.1)]
        faces = [(0, 1, 3), (0, 3, 2), (4, 6, 7), (4, 7, 5), (0, 4, 5), (0, 5, 1), (2, 3, 7), (2, 7, 6), (0, 2, 6), (0, 6, 4), (1, 5, 7),
                 (1, 7, 3)]
        bar = self.file("bar.off", off(corners, faces))
        wall = self.file("wall.off", off([(x, y, z) for x in (-9, 9) for y in (2, 4) for z in (-1, 1)], faces))
        angle = math.asin(2 / math.hypot(3, 0.01)) - math.atan2(0.01, 3)
        for turns in (1, 5):
            found = self.json_of("contact-time", wall, bar, "--to", "0,0,0", "--center", "0,0,0", "--turn", f"0,0,1,{360 * turns}")
            self.assertAlmostEqual(found["free_until"] * 2 * math.pi * turns, angle, delta=1e-7)
        cut = self.json_of("contact-time", wall, bar, "--to", "0,0,0", "--center", "0,0,0", "--turn", "0,0,1,360", "--max-steps", "1")
        self.assertEqual((cut["evidence"], cut["touches_at"], cut["steps"]), ("steps", None, 1))

    def test_rounded_rotations_are_named(self):
        turn = "0.7071,-0.7071,0,0,0.7071,0.7071,0,0,0,0,1,4"
        for poses in (("--from", "0,0,4", "--to", turn), ("--from", turn, "--to", "0,0,0")):
            noted = run("contact-time", "cube", "cube", *poses, "--json", "-")
            self.assertTrue(1e-5 < json.loads(noted.stdout)["rotation_error"] < 1e-3)
            self.assertEqual((noted.returncode, noted.stderr.count("\n")), (0, 1))
            self.assertIn("nearest rotations", noted.stderr)
            self.assertIn("nearest rotations", self.succeed("contact-time", "cube", "cube", *poses))
        found = self.json_of("contact-time", "cube", "cube", "--from", "0,0,4", "--to", "0,0,0@0,0,1,45")
        self.assertEqual(found["rotation_error"], 0)

    def test_bad_options(self):
        for options, says in ((["--turn", "0,0,0,3"], "axis"), (["--turn", "1,2"], "AX,AY,AZ"), (["--center", "1"], "X,Y,Z"),
                              (["--turn", "0,0,1,1e9"], "radians")):
            self.refuse("contact-time", "cube", "cube", "--to", "1,0,0", *options, says=says)
        for pose in ("nan,0,0", "0,-inf,0", "1e999,0,0", "nan,0,0@0,0,1,90"):
            self.refuse("contact-time", "cube", "cube", f"--to={pose}", says="finite")
        self.refuse("contact-time", "cube", "cube", status=2, says="--to")
        self.refuse("contact-time", "cube", "cube", "--to", "-1", says=("-1: is no pose", "No such file", "TX,TY,TZ"))
        for tolerance in ("-1", "1.5", "nan"):
            self.refuse("contact-time", "cube", "cube", "--to", "1,0,0", "--tolerance", tolerance, status=2, says="--tolerance")
        self.refuse("contact-time", "cube", "cube", "--to", self.file("two.csv", "1,0,0\n2,0,0\n"), says="one pose")


class Contacts(ProgramTest):
    def test_cubes(self):
        poses = self.file("poses.csv", "0.5,0.25,1.75\n5,0,0\n")
        result = self.json_of("contacts", "cube", "cube", "--pose", poses)
        self.assertEqual([result["convex_a"], result["convex_b"]], [True, True])
        deep, apart = result["poses"]
        self.assertEqual(list(deep), POSE_KEYS)
        self.assertEqual(deep["method"], "convex")
        self.assertAlmostEqual(deep["lower"], 0.25, delta=1e-12)
        self.assertAlmostEqual(deep["upper"], 0.25, delta=1e-12)
        self.assertLessEqual(deep["lower"], 0.25)
        self.assertGreaterEqual(deep["upper"], 0.25)
        region, = deep["regions"]
        self.assertEqual(list(region), REGION_KEYS)
        self.assertAlmostEqual(region["depth"], 0.25, delta=1e-12)
        self.assertEqual([round(x, 9) for x in region["normal"]], [0, 0, 1])
        self.assertEqual(len(region["points"]), 4)
        self.assertEqual((apart["method"], apart["upper"], apart["regions"]), ("apart", 0, []))
        moved = ",".join(str(x + y) for x, y in zip((0.5, 0.25, 1.75), deep["translation"]))
        self.assertEqual(self.json_of("contacts", "cube", "cube", "--pose", moved)["poses"][0]["method"], "apart")
        text = self.succeed("contacts", "cube", "cube", "--pose", poses)
        self.assertIn("penetration depth 0.25 to 0.25 (convex)", text)
        self.assertIn("pose 1: apart", text)

    def test_shapes_that_are_not_convex_have_bounds(self):
        pose, = self.json_of("contacts", "torus:24x12", "icosphere:2", "--pose", "1.9,0,0.1")["poses"]
        self.assertEqual(pose["method"], "bounds")
        # A ball of radius 1 and a tube of radius 1/2 about the circle: depth 1.5 - 0.9 or so.
        self.assertLess(pose["lower"], 0.61)
        self.assertGreater(pose["lower"], 0.5)
        self.assertGreater(pose["upper"], 0.5)
        self.assertLess(pose["upper"], 0.75)

    def test_refuses_what_has_no_inside(self):
        open_mesh = self.file("open.off", off([(0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1)], [(0, 2, 1), (0, 1, 3), (1, 2, 3)]))
        self.refuse("contacts", "cube", open_mesh, says=("open: 3 edges", "open.off"))
        inward = self.file("inward.off", off([(0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1)], [(0, 1, 2), (0, 3, 1), (1, 3, 2), (0, 2, 3)]))
        self.refuse("contacts", inward, "cube", says=("inside out", "inward.off"))
        self.refuse("contacts", "cube", "cube", "--points", "-1", status=2, says="--points")
        self.refuse("contacts", "cube", "cube", "--directions", "1000000000", status=2, says="--directions")

    def test_flush_cubes_face_across_the_least_depth(self):
        region, = self.json_of("contacts", "cube", "cube", "--pose", "0,0,1.9")["poses"][0]["regions"]
        self.assertEqual([round(x, 9) for x in region["normal"]], [0, 0, 1])
        self.assertAlmostEqual(region["depth"], 0.1, delta=1e-12)


if __name__ == "__main__":
    unittest.main()
