"""proxima touch --tool: sessions of a simulated hand with a rigid tool."""
import json
import unittest

from proxima_program import ProgramTest, run

KEYS = ["model", "triangles", "tool", "tool_triangles", "device", "ticks", "interrupted", "replay_differences", "touching_ticks", "entered_ticks", "unplaced_ticks",
        "limited_ticks", "cut_short_ticks", "overloaded_ticks", "max_near_pairs", "max_force", "max_torque", "max_spring_torque", "max_stretch",
        "guard", "damped_ticks", "softened_ticks", "lowest_softness", "swings", "softenings", "most_damping", "longest_softening", "most_given",
        "clock", "processor", "missed_deadlines"]


class Tools(ProgramTest):
    session = ("--tool", "cube", "--tool-scale", 0.1, "--device", "hand:press", "--turn", 20, "--free-running", "--seconds", 1)

    def test_it_touches_and_enters_nothing(self):
        for torque in (0, 0.1):
            result = self.json_of("touch", "torus:24x12", *self.session, "--max-torque", torque)
            self.assertEqual(list(result), KEYS)
            self.assertEqual((result["triangles"], result["tool_triangles"], result["ticks"]), (576, 12, 1000))
            self.assertEqual((result["entered_ticks"], result["overloaded_ticks"]), (0, 0))
            self.assertGreater(result["touching_ticks"], 100)
            self.assertTrue(0.1 < result["max_force"] <= 3.3)
            self.assertGreater(result["max_spring_torque"], 0)
            self.assertEqual(result["max_torque"] > 0, torque > 0)
            self.assertLessEqual(result["max_torque"], torque)

    def test_friction_holds_the_tool_back(self):
        stretches = []
        for friction in (0, 1):
            result = self.json_of("touch", "torus:24x12", *self.session, "--friction", friction)
            self.assertEqual(result["entered_ticks"], 0)
            stretches.append(result["max_stretch"])
        self.assertLess(stretches[0], stretches[1])

    def test_the_table_of_ticks(self):
        table = self.folder / "ticks.csv"
        result = self.json_of("touch", "torus:24x12", *self.session, "--max-torque", 1, "--ticks", table)
        header, *rows = table.read_text().splitlines()
        rows = [dict(zip(header.split(","), map(float, row.split(",")))) for row in rows]
        self.assertEqual(len(rows), 1000)
        for name, key in (("force", "max_force"), ("torque", "max_torque")):
            largest = max(sum(row[f"{name}_{axis}"] ** 2 for axis in "xyz") ** 0.5 for row in rows)
            self.assertAlmostEqual(largest, result[key], places=6)
        self.assertEqual(sum(row["contacts"] > 0 for row in rows), result["touching_ticks"])

    def test_files_are_named_after_the_report(self):
        names = [self.folder / name for name in ("a.pxt", "a.csv")]
        text = self.succeed("touch", "cube", *self.session, "--record", names[0], "--ticks", names[1])
        self.assertEqual(text.splitlines()[-2:], [f"wrote {name}" for name in names])

    def test_a_session_that_could_not_be_recorded_is_reported_all_the_same(self):
        recording, table, report = (self.folder / name for name in ("a.pxt", "a.csv", "a.json"))
        recording.symlink_to("/dev/full")
        done = run("touch", "cube", *self.session, "--record", recording, "--ticks", table, "--json", report)
        self.assertEqual((done.returncode, done.stderr.count("\n")), (1, 1))
        self.assertIn("a.pxt", done.stderr)
        self.assertIn("1000 ticks", done.stdout)
        self.assertNotIn(f"wrote {recording}", done.stdout)
        self.assertEqual(len(table.read_text().splitlines()), 1001)
        self.assertEqual(json.loads(report.read_text())["ticks"], 1000)

    def test_a_recorded_session_replays_without_a_difference(self):
        file, before, after = (self.folder / name for name in ("a.pxt", "before.csv", "after.csv"))
        first = self.json_of("touch", "torus:24x12", *self.session, "--max-torque", 0.1, "--record", file, "--ticks", before)
        tool = ("--tool", "cube", "--tool-scale", 0.1)
        replay = ("--device", f"replay:{file}")
        again = self.json_of("touch", "torus:24x12", *tool, *replay, "--ticks", after)
        self.assertEqual((first["replay_differences"], again["replay_differences"]), (None, 0))
        for key in ("model", "tool", "ticks", "touching_ticks", "max_force", "max_torque", "max_stretch"):
            self.assertEqual(first[key], again[key])
        self.assertEqual(before.read_bytes(), after.read_bytes())
        self.refuse("touch", "torus:24x12", "--tool", "cube", "--tool-scale", 0.2, *replay, says="another model, tool")
        self.refuse("touch", "cube", *tool, *replay, says="another model, tool")
        for option, value in (("--max-work", 100), ("--friction", 1), ("--seconds", 2), ("--record", self.folder / "b.pxt")):
            self.refuse("touch", "torus:24x12", *tool, *replay, option, value, status=2, says=option)
        # Points and tools have recordings of their own.
        self.refuse("touch", "torus:24x12", *replay, says="a.pxt")

    def test_the_guard_damps_springs_that_swing(self):
        swinging = ("--stiffness", 700, "--damping", 0, "--hand-damping", 0, "--device-damping", 0.1, "--delay", 3, "--max-torque", 0.1)
        tables, results = {}, {}
        for guard in ("off", "observe", "on"):
            tables[guard] = self.folder / f"{guard}.csv"
            results[guard] = self.json_of("touch", "cube", *self.session[:-2], "--seconds", 4, *swinging, "--guard", guard, "--ticks", tables[guard])
            self.assertEqual(results[guard]["guard"], guard)
            self.assertEqual(results[guard]["entered_ticks"], 0)
        self.assertEqual(tables["observe"].read_bytes(), tables["off"].read_bytes())
        self.assertEqual((results["off"]["swings"], results["off"]["damped_ticks"]), (0, 0))
        for guard in ("observe", "on"):
            self.assertGreater(results[guard]["swings"], 0)
            self.assertTrue(0 < results[guard]["most_damping"] <= 5)
            self.assertGreater(results[guard]["most_given"], 0)
        # It is part of the session.
        file = self.folder / "on.pxt"
        self.json_of("touch", "cube", *self.session[:-2], "--seconds", 4, *swinging, "--record", file)
        again = self.json_of("touch", "cube", "--tool", "cube", "--tool-scale", 0.1, "--device", f"replay:{file}")
        self.assertEqual((again["guard"], again["replay_differences"]), ("on", 0))
        self.assertEqual(again["damped_ticks"], results["on"]["damped_ticks"])
        self.refuse("touch", "cube", "--tool", "cube", "--device", f"replay:{file}", "--guard", "off", status=2, says="--guard")

    def test_what_does_not_go_together(self):
        for option, value in (("--radius", 0.001), ("--force", "penalty"),
                              ("--picture", self.folder / "a.png"), ("--patch", 1),
                              ("--object", "cube"), ("--texture", "viscosity:1"), ("--engine", "udp:0"),
                              ("--method", "thesis"), ("--graphics-rate", 10), ("--collision-rate", 10)):
            self.refuse("touch", "cube", *self.session, option, value, status=2, says=(option, "--tool"))
        for option in ("--shading", "--lists"):
            self.refuse("touch", "cube", *self.session, option, status=2, says=(option, "--tool"))
        for option in ("--tool-scale", "--turn", "--max-torque", "--clearance"):
            self.refuse("touch", "cube", "--tool", "cube", "--device", "hand:press", option, "nan", status=2, says=option)
        for work in ("99", "-1", "1.5", "0x64"):
            self.refuse("touch", "cube", *self.session, "--max-work", work, status=2, says="--max-work")
        self.refuse("touch", "cube", "--tool", "cube", "--device", "udp:0", "--turn", 3, status=2, says="--turn")
        self.refuse("touch", "cube", *self.session, "--ticks", self.folder / "a.txt", says=".csv")
        self.refuse("touch", "cube", "--tool", "cube", "--device", "hand:press", "--seconds", 86400, "--ticks",
                    self.folder / "a.csv", says=("--ticks", "GB"))
        self.refuse("touch", "cube", "--device", "hand:press", "--turn", 3, status=2, says=("--turn", "--tool"))
        self.refuse("touch", "cube", *self.session, "--record", self.folder / "a.txt", says=".pxt")
        self.refuse("touch", "cube", "--tool", "missing.obj", "--device", "hand:press", says=("missing.obj",))
        flawed = self.file("flawed.off", "OFF\n3 1 0\n0 0 0\n1 0 0\n0 nan 0\n3 0 1 2\n")
        self.refuse("touch", "cube", "--tool", flawed, "--device", "hand:press", says=("flawed.off", "finite"))


if __name__ == "__main__":
    unittest.main()
