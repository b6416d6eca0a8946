"""proxima touch --self-test: what it measures of devices whose numbers are known, and what it refuses."""
import os
import pty
import signal
import subprocess
import time
import unittest

from proxima_program import PROXIMA, ProgramTest, run

STUB_HD, STUB_DHD = os.environ.get("STUB_HD", ""), os.environ.get("STUB_DHD", "")
HAND = ("--device", "hand:self-test", "--free-running")
KEYS = ["device", "model", "serial", "driver", "max_force", "max_stiffness", "max_damping", "largest_force", "ticks",
        "missed_deadlines", "sample_rate", "mean_interval", "interval_deviation", "interval_p99", "longest_interval",
        "ticks_without_sample", "repeated_part", "rested", "held", "axes", "settings"]
OF_AN_AXIS = ["encoder", "encoder_step", "noise", "noise_range", "ramps", "breakaway", "static_friction", "weight", "pushes",
              "mass", "damping", "friction", "held_stiffness", "delay", "delay_range", "residual"]


class Measuring(ProgramTest):
    def test_numbers_of_simulated_devices(self):
        for mass, damping, friction, step, delay in ((0.1, 0.3, 0.2, 5e-5, 1), (0.06, 0.8, 0.1, 1e-5, 4)):
            report = self.json_of("touch", "--self-test", *HAND, "--hand-mass", mass, "--device-damping", damping,
                                  "--device-friction", friction, "--encoder-step", step, "--delay", delay)
            self.assertEqual(list(report), KEYS)
            self.assertTrue(report["rested"])
            self.assertFalse(report["held"])
            self.assertIsNone(report["sample_rate"])  # ticks did not wait for time
            self.assertAlmostEqual(report["largest_force"], 0.3 * 3.3)
            for axis in report["axes"].values():
                self.assertEqual(list(axis), OF_AN_AXIS)
                self.assertEqual((axis["encoder"], axis["ramps"], axis["pushes"]), ("grid", ["complete"] * 2, ["complete"] * 2))
                self.assertAlmostEqual(axis["encoder_step"], step, delta=1e-3 * step)
                self.assertAlmostEqual(axis["static_friction"], friction, delta=0.01)
                self.assertAlmostEqual(axis["mass"]["value"], mass, delta=0.03 * mass)
                self.assertAlmostEqual(axis["damping"]["value"], damping, delta=max(0.05, 4 * axis["damping"]["error"]))
                self.assertAlmostEqual(axis["friction"]["value"], friction, delta=0.01)
                self.assertEqual((axis["delay"], axis["delay_range"]), (delay, [delay, delay]))
            settings = report["settings"]
            self.assertLessEqual(settings["stiffness"], min(700, 0.81 * settings["by_delay"], 0.81 * settings["by_encoder"]))

    def test_long_delays_are_found(self):
        for delay, extra in ((40, ()), (64, ("--device-friction", 0.1))):
            report = self.json_of("touch", "--self-test", *HAND, "--delay", delay, *extra)
            for axis in report["axes"].values():
                self.assertEqual((axis["delay"], axis["delay_range"]), (delay, [delay, delay]))
            self.assertLess(report["settings"]["stiffness"], report["settings"]["by_delay"])

    def test_rounding_is_no_encoder_step_and_no_friction(self):
        text = self.succeed("touch", "--self-test", *HAND, "--hand-stiffness", 0, "--hand-damping", 0)
        self.assertEqual(text.count("hardly moved"), 3)
        self.assertNotIn("e-1", text)
        self.assertNotIn("e-12", self.succeed("touch", "--self-test", *HAND, "--device-damping", 1000))

    def test_what_is_suggested_does_not_oscillate(self):
        device = ("--hand-mass", 0.1, "--device-damping", 0.1, "--encoder-step", 1e-5, "--device-friction", 0.05, "--delay", 2)
        settings = self.json_of("touch", "--self-test", *HAND, *device)["settings"]
        touched = self.json_of("touch", "cube", "--device", "hand:press", "--free-running", *device, "--seconds", 4,
                               "--stiffness", settings["stiffness"], "--damping", settings["damping"])
        self.assertGreater(touched["touching_ticks"], 1000)
        self.assertEqual(touched["softened_ticks"], 0)

    def test_the_page_is_a_screen(self):
        text = self.succeed("touch", "--self-test", *HAND, "--device-friction", 0.2, "--encoder-step", 5e-5, "--delay", 1)
        self.assertLessEqual(text.count("\n"), 30)
        self.assertLess(max(map(len, text.splitlines())), 120)
        for part in ("encoder step, mm", "friction at rest, N", "delay, ticks", "Set --stiffness 700 --damping", "--delay 1"):
            self.assertIn(part, text)

    def test_what_cannot_be_measured_is_said(self):
        text = self.succeed("touch", "--self-test", *HAND, "--device-friction", 2)
        self.assertIn("Up to 0.99 N did not move the tip", text)
        self.assertIn("above 0.99", text)
        self.assertIn("No settings", text)

    def test_a_tip_that_never_rests_is_not_pushed(self):
        loose = ("--device-damping", 0, "--hand-damping", 0.1, "--hand-stiffness", 50)  # it drifts when it is let go
        report = self.json_of("touch", "--self-test", *HAND, *loose)
        self.assertFalse(report["rested"])
        self.assertIsNone(report["settings"])
        for axis in report["axes"].values():
            self.assertEqual((axis["ramps"], axis["pushes"], axis["mass"]), (["not_done"] * 2, ["not_done"] * 2, None))
        self.assertIn("The tip did not rest after it was let go", self.succeed("touch", "--self-test", *HAND, *loose))

    def test_refuses_what_it_does_not_use(self):
        for arguments, words in (
                (("cube", "--self-test", *HAND), ("MODEL", "leave it out")),
                (("--self-test", *HAND, "--stiffness", 5), ("--stiffness", "leave it out")),
                (("--self-test", *HAND, "--object", "cube"), ("--object", "leave it out")),
                (("--self-test", "--device", "hand:press"), ("hand:press", "hand:self-test")),
                (("--self-test", "--device", "replay:a.pxt"), ("replay:a.pxt", "hand:self-test")),
                (("cube", *HAND), ("hand:self-test", "--self-test")),
                (("cube", "--device", "hand:press", "--yes"), ("--yes", "--self-test")),
                (("--self-test", "--device", "udp:4711", "--delay", 1), ("--delay", "simulated hand")),
                (("--self-test", "--device", "udp:4711", "--free-running"), ("--free-running",))):
            self.refuse("touch", *arguments, status=2, says=words)
        self.refuse("touch", "--self-test", status=2, says="--device")

    def test_a_faulty_device_gives_one_error(self):
        for name, library, fault, words in (("hd", STUB_HD, "unplug=500", "lost the device"),
                                            ("hd", STUB_HD, "nan=500", "not a number"),
                                            ("hd", STUB_HD, "jump=500", "jumped"),
                                            ("hd", STUB_HD, "stall=500", "stopped calling"),
                                            ("dhd", STUB_DHD, "unplug=500", "lost the device")):
            result = run("touch", "--self-test", "--yes", "--quiet", "--device", name, "--device-library", library,
                         env={**os.environ, "PROXIMA_STUB": fault})
            self.assertEqual((result.returncode, result.stdout, result.stderr.count("\n")), (1, "", 1), result.stderr)
            self.assertIn(words, result.stderr)

    def test_waits_for_enter_and_stops_at_control_c(self):
        master, terminal = pty.openpty()
        with subprocess.Popen([PROXIMA, "touch", "--self-test", "--device", "hd", "--device-library", STUB_HD], stdin=terminal,
                              stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True) as process:
            time.sleep(4)  # longer than the three seconds without a terminal
            os.write(master, b"\n")
            time.sleep(0.5)
            process.send_signal(signal.SIGINT)
            text, error = process.communicate(timeout=60)
        os.close(terminal)
        os.close(master)
        self.assertEqual((process.returncode, text), (130, ""))
        self.assertIn("Press Enter to begin", error)
        self.assertNotIn("2 of 4", error)
        self.assertIn("proxima: stopped on request", error)


if __name__ == "__main__":
    unittest.main()
