"""proxima touch: devices by their makers' libraries and over UDP."""
import json
import os
import socket
import unittest

from proxima_program import ProgramTest
from touch_report import KEYS, MEASURED, OF_A_DEVICE
from udp_hand import UdpHand, free_port

STUB_HD, STUB_DHD = os.environ.get("STUB_HD", ""), os.environ.get("STUB_DHD", "")


class DeviceTest(ProgramTest):
    """Sessions whose report in words is held against that in JSON."""

    def report_of(self, *arguments, **options):
        path = self.folder / "report.json"
        text = self.succeed(*arguments, "--verbose", "--json", path, **options)
        report = json.loads(path.read_text())
        self.assertIn("input: {samples} samples; {not_finite} invalid positions, {jumps} jumps, {freezes} freezes, {silences} silences, "
                      "{losses} losses; {velocities} velocities corrected; {faulty_ticks} ticks with ".format(**report["input"]), text)
        if report["network"]:
            self.assertIn("packets: {received} received, {accepted} accepted; malformed {malformed}, foreign {foreign}, duplicated {duplicated}, "
                          "reordered {reordered}, leapt {leapt}, late {late}, lost {lost}\n".format(**report["network"]), text)
        return report


class Devices(DeviceTest):
    """Stand-ins for the makers' libraries; PROXIMA_STUB says what goes wrong, and when."""

    def feel(self, name, library, fault="", seconds=1, model="cube", **options):
        session = self.folder / "session.pxt"
        environment = {**os.environ, "PROXIMA_STUB": fault}
        report = self.report_of("touch", model, "--device", name, "--device-library", library, "--seconds", seconds,
                                "--record", session, env=environment, **options)
        self.assertEqual(list(report), KEYS)
        self.assertEqual(report["passes"], 0)
        again = self.json_of("touch", model, "--device", f"replay:{session}")
        self.assertEqual((again["replay_differences"], again["ticks"]), (0, report["ticks"]))
        self.assertIsNone(again["device_info"])
        for key in KEYS:
            if key not in (*MEASURED, *OF_A_DEVICE, "device", "replay_differences", "trouble"):
                self.assertEqual(report[key], again[key], key)
        return report

    def test_hd(self):
        report = self.feel("hd", STUB_HD)
        info = report["device_info"]
        self.assertEqual((info["model"], info["serial"], info["max_force"]), ("Proxima's tests Stub Omni", "S-0042", 3.3))
        self.assertAlmostEqual(info["max_stiffness"], 700)
        self.assertGreater(report["max_force"], 1)
        self.assertEqual((report["faulty_ticks"], report["trouble"]), (0, ""))
        self.assertGreaterEqual(report["ticks"], 1000)  # and those in which the force fades at the end
        self.assertLess(report["ticks"], 1100)

    def test_no_limits_are_beyond_the_driver_s(self):
        for name, stiffest in (("falcon", 700), ("delta", 700), ("touch", 400)):
            report = json.loads(self.succeed("touch", "cube", "--device", "hd", "--device-library", STUB_HD, "--seconds", 0.5,
                                             "--stiffness", 5000, "--limits", name, "--json", "-",
                                             env={**os.environ, "PROXIMA_STUB": "press=100"}))
            self.assertLessEqual(report["max_force"], 3.3)
            self.assertEqual(report["device_info"]["max_force"], 3.3)
            self.assertAlmostEqual(report["device_info"]["max_stiffness"], stiffest)

    def test_hd_faults(self):
        report = self.feel("hd", STUB_HD, "unplug=480 replug=630")
        self.assertEqual([report["input"][name] for name in ("losses", "recoveries", "silences")], [1, 1, 0])
        self.assertIn("Communication error", report["trouble"])
        report = self.feel("hd", STUB_HD, "nan=480")
        self.assertEqual(report["input"]["not_finite"], 10)
        report = self.feel("hd", STUB_HD, "jump=480")
        self.assertEqual(report["input"]["jumps"], 1)
        report = self.feel("hd", STUB_HD, "stall=300", seconds=0.8)
        self.assertEqual(report["ticks"], 300)
        self.assertIn("stopped calling", report["trouble"])

    def test_dhd(self):
        report = self.feel("dhd", STUB_DHD, "press=100")
        self.assertEqual((report["device_info"]["max_force"], report["button_events"]), (12, 2))
        self.assertGreater(report["max_force"], 1)
        report = self.feel("dhd:0", STUB_DHD, "unplug=480")
        self.assertEqual(report["input"]["losses"], 1)
        self.assertIn("communication error (stub)", report["trouble"])

    def test_what_is_not_there_is_named(self):
        self.refuse("touch", "cube", "--device", "hd", "--device-library", "/nowhere/libHD.so",
                    says=("tried /nowhere/libHD.so", "install OpenHaptics"))
        self.refuse("touch", "cube", "--device", "dhd", "--device-library", STUB_HD,
                    says=("lacks dhdGetDeviceCount", "install the Force Dimension SDK"))
        self.refuse("touch", "cube", "--device", "dhd:3", "--device-library", STUB_DHD, says="no device dhd:3: devices found: 1")
        text = self.succeed("touch", "--list-devices", "--device-library", STUB_DHD)
        self.assertIn("dhd: Force Dimension omega.3 (stub), number 1234", text)
        self.assertIn("hd: none: ", text)
        listed = json.loads(self.succeed("touch", "--list-devices", "--device-library", STUB_HD, "--json", "-"))["devices"]
        self.assertEqual([device["name"] for device in listed], ["hd", "dhd"])
        self.assertEqual(listed[0]["serial"], "S-0042")
        self.assertIn("lacks", listed[1]["problem"])

    def test_axes_scale_and_clutch(self):
        """The stub goes along its z, so through the hole of a ring, unless axes turn its way or a pose turns the ring."""
        ring = ("touch", "torus:24x12", "--device", "dhd", "--device-library", STUB_DHD, "--seconds", 0.3, "--json", "-")
        turned = ("--pose", "0=0,0,0@0,1,0,90")  # its hole is along x
        touches = [json.loads(self.succeed(*ring, *more))["touching_ticks"] > 50
                   for more in ((), ("--axes", "z,x,y"), turned, (*turned, "--axes", "z,x,y"), (*turned, "--axes", "y,z,x"))]
        self.assertEqual(touches, [False, True, True, False, True])
        scaled = self.json_of("touch", "cube", "--device", "hand:press", "--free-running", "--seconds", 0.2, "--scale", 2)
        usual = self.json_of("touch", "cube", "--device", "hand:press", "--free-running", "--seconds", 0.2)
        self.assertAlmostEqual(scaled["units_per_metre"], 2 * usual["units_per_metre"])
        session = self.folder / "turned.pxt"
        report = json.loads(self.succeed("touch", "cube", "--device", "dhd", "--device-library", STUB_DHD, "--axes", "x,-z,y",
                                         "--clutch", 1, "--seconds", 0.6, "--record", session, "--json", "-",
                                         env={**os.environ, "PROXIMA_STUB": "press=300"}))
        self.assertEqual(report["input"]["clutched_ticks"], 100)
        self.assertEqual(self.json_of("touch", "cube", "--device", f"replay:{session}")["replay_differences"], 0)


class Udp(DeviceTest):
    def feel(self, seconds=2, **hand):
        port = free_port()
        other_side = UdpHand(port, seconds + 1, **hand)
        other_side.start()
        session = self.folder / "udp.pxt"
        report = self.report_of("touch", "cube", "--device", f"udp:{port}", "--seconds", seconds, "--record", session)
        other_side.join()
        again = self.json_of("touch", "cube", "--device", f"replay:{session}")
        self.assertEqual((again["replay_differences"], again["ticks"]), (0, report["ticks"]))
        self.assertLessEqual(report["max_force"], 3.3)
        return report, other_side.replies

    def test_a_hand_in_another_program(self):
        report, replies = self.feel()
        self.assertGreater(report["network"]["accepted"], 500)
        self.assertEqual(report["network"]["sessions"], 1)
        self.assertEqual(report["button_events"], 1)
        self.assertGreater(report["touching_ticks"], 300)
        self.assertGreater(len(replies), 500)
        for magic, version, size, session, *_ in replies:
            self.assertEqual((magic, version, size, session), (b"PXDN", 1, 256, 4242))
        forces = [reply[8:11] for reply in replies]
        self.assertGreater(max(z for _, _, z in forces), 1)
        pressed = next(reply for reply in replies if reply[10] == max(z for _, _, z in forces))
        self.assertEqual(pressed[7], 1)  # one plane: the upper face
        self.assertAlmostEqual(pressed[22], 1)  # whose normal is z

    def test_junk_and_silence(self):
        report, _ = self.feel(seconds=3, junk=True, silent=(1.2, 1.6))
        self.assertGreater(report["network"]["malformed"], 500)
        self.assertGreaterEqual(report["input"]["silences"], 1)
        self.assertEqual(report["input"]["losses"], 0)
        self.assertGreaterEqual(report["input"]["recoveries"], 1)
        self.assertGreater(report["input"]["longest_recovery"], 0)

    def test_a_poor_line(self):
        network = self.feel(poor=True)[0]["network"]
        kinds = ("accepted", "malformed", "foreign", "duplicated", "reordered", "leapt", "late")
        self.assertEqual(sum(network[kind] for kind in kinds), network["received"])
        self.assertGreater(network["late"], 3)
        self.assertGreater(network["lost"], 0.6 * network["accepted"])  # four numbers to six packets
        self.assertEqual((network["malformed"], network["duplicated"], network["sessions"]), (0, 0, 1))

    def test_nobody_comes(self):
        report = self.json_of("touch", "cube", "--device", f"udp:{free_port()}", "--seconds", 0.2)
        self.assertIn("no packet arrived at 127.0.0.1:", report["trouble"])
        self.assertEqual(report["max_force"], 0)

    def test_a_port_that_is_taken(self):
        with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as line:
            line.bind(("127.0.0.1", 0))
            port = line.getsockname()[1]
            self.refuse("touch", "cube", "--device", f"udp:{port}", says=(f"127.0.0.1:{port}", "in use"))


if __name__ == "__main__":
    unittest.main()
