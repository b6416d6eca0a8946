"""proxima touch --engine: the clients of examples/ move objects and hear what is touched."""
import csv
import json
import os
import re
import signal
import socket
import struct
import subprocess
import sys
import time
import unittest
from pathlib import Path

from proxima_program import PROXIMA, ProgramTest, environment_of_program
from udp_hand import PATIENCE, free_port

CLIENT_C, CLIENT_PY = os.environ.get("ENGINE_CLIENT_C", ""), os.environ.get("ENGINE_CLIENT_PY", "")
sys.path.insert(0, str(Path(CLIENT_PY).parent))
import engine_client  # noqa: E402


def segment_of(name):
    return Path("/dev/shm") / f"proxima-{name}"


class EngineTest(ProgramTest):
    def channels(self):
        return [f"udp:{free_port()}", f"shm:test-{os.getpid()}"]

    def start(self, channel, *arguments, seconds=3600):
        """Proxima with a hand that presses on a cube; ended by interrupting it."""
        program = subprocess.Popen([PROXIMA, "touch", "cube", "--device", "hand:press", "--engine", channel, "--seconds",
                                    str(seconds), *map(str, arguments)],
                                   text=True, stdout=subprocess.PIPE, stderr=subprocess.PIPE, env=environment_of_program())
        self.addCleanup(program.stdout.close)
        self.addCleanup(program.stderr.close)
        self.addCleanup(program.wait)
        self.addCleanup(program.kill)
        return program

    def stop(self, program):
        program.send_signal(signal.SIGINT)
        return program.communicate(timeout=PATIENCE)

    def client(self, *command):
        return subprocess.run(list(map(str, command)), text=True, timeout=2 * PATIENCE, stdout=subprocess.PIPE,
                              stderr=subprocess.PIPE)


class Sessions(EngineTest):
    def feel(self, channel, *client):
        session, report_file = self.folder / "engine.pxt", self.folder / "report.json"
        # No longer, for the program makes room for the whole recording before its first tick.
        program = self.start(channel, "--record", session, "--json", report_file, seconds=60)
        result = self.client(*client)
        _, errors = self.stop(program)
        self.assertEqual(result.returncode, 0, result.stderr)
        report = json.loads(report_file.read_text())
        self.assertTrue(report["interrupted"], errors)
        self.assertEqual((report["passes"], report["engine"]["name"].split(":")[0]), (0, channel.split(":")[0]))
        self.assertLessEqual(report["max_force"], 3.3)
        # Replayed without the engine: the same poses, the same forces.
        again = self.json_of("touch", "cube", "--device", f"replay:{session}")
        self.assertEqual((again["replay_differences"], again["ticks"]), (0, report["ticks"]))
        self.assertEqual((again["moving_ticks"], again["max_force"], again["engine"]),
                         (report["moving_ticks"], report["max_force"], None))
        self.assertGreater(report["moving_ticks"], 500)
        heard = re.search(r"^(\d+) ticks received, (\d+) missed; (\d+) packets sent, 0 lost\n"
                          r"touching in (\d+) ticks, force at most ([\d.]+) N\n"
                          r"from a pose to the force of its first tick: p50 [\d.]+ ms", result.stdout)
        self.assertIsNotNone(heard, result.stdout)
        self.assertGreater(int(heard[1]), 500)
        self.assertGreater(int(heard[4]), 100)
        self.assertGreater(float(heard[5]), 0.3)
        self.assertLessEqual(float(heard[5]), report["max_force"] + 0.001)
        self.assertGreater(report["engine"]["accepted"], 30)
        self.assertEqual(report["engine"]["sessions"], 1)
        self.assertEqual(report["engine"]["refused_objects"], 0)
        return report

    def test_python(self):
        for channel in self.channels():
            table = self.folder / "ticks.csv"
            report = self.feel(channel, sys.executable, "-B", CLIENT_PY, channel, "--seconds", 1.5, "--patience", PATIENCE,
                               "--material", "300,1,0.4,0.3", "--csv", table)
            self.assertGreater(report["engine"]["materials"], 30)
            rows = list(csv.DictReader(table.read_text().splitlines()))
            touching = [row for row in rows if row["contacts"]]
            self.assertTrue(all(re.fullmatch(r"0:\d+( 0:\d+)*", row["contacts"]) for row in touching))
            self.assertGreater(len(touching), 100)

    def test_c(self):
        for channel in self.channels():
            self.feel(channel, CLIENT_C, channel, 1.5, 90)


class Endings(EngineTest):
    def test_shared_memory_is_removed(self):
        name = f"end-{os.getpid()}"
        for number in (signal.SIGINT, signal.SIGTERM):
            program = self.start(f"shm:{name}")
            channel = engine_client.open_channel(f"shm:{name}", PATIENCE)
            self.assertTrue(segment_of(name).exists())
            with self.assertRaisesRegex(engine_client.ChannelError, "there is no .*proxima touch"):
                engine_client.open_channel("shm:nobody")
            other = self.client(sys.executable, "-B", CLIENT_PY, f"shm:{name}", "--patience", 0)
            self.assertIn("another engine uses", other.stderr)
            self.refuse("touch", "cube", "--device", "hand:press", "--engine", f"shm:{name}", says="in use by another program")
            program.send_signal(number)
            program.wait(PATIENCE)
            self.assertFalse(segment_of(name).exists())
            channel.close()

    def test_a_killed_program_leaves_nothing_in_the_way(self):
        name = f"kill-{os.getpid()}"
        program = self.start(f"shm:{name}")
        engine_client.open_channel(f"shm:{name}", PATIENCE).close()
        program.kill()
        program.wait(PATIENCE)
        self.assertTrue(segment_of(name).exists())
        report = self.json_of("touch", "cube", "--device", "hand:press", "--engine", f"shm:{name}", "--seconds", 0.1)
        self.assertEqual(report["engine"]["sent"], 100)
        self.assertFalse(segment_of(name).exists())

    def test_an_engine_that_dies_or_begins_anew(self):
        for name in self.channels():
            report_file = self.folder / "report.json"
            program = self.start(name, "--json", report_file)
            for _ in range(2):
                channel = engine_client.open_channel(name, PATIENCE)
                end = time.monotonic() + PATIENCE
                answered = False
                while not answered and time.monotonic() < end:
                    channel.send([engine_client.pose_of(0, (0, 0, 0.01))])
                    time.sleep(0.02)
                    answered = any(state["engine_session"] == channel.session for state in channel.receive())
                self.assertTrue(answered)
                if name.startswith("udp"):
                    channel.line.close()
                    time.sleep(1.1)  # a program at another address is heard after a second
                else:
                    channel.memory.close()
                    os.close(channel.file)
            self.stop(program)
            self.assertEqual(json.loads(report_file.read_text())["engine"]["sessions"], 2)


class Restarts(EngineTest):
    """Proxima is killed and started anew, with the shared memory that it left."""

    def counts(self, name):
        """How many touch packets and scene packets were written to a segment."""
        try:
            memory = segment_of(name).read_bytes()
            return struct.unpack_from("<Q", memory, 64)[0], struct.unpack_from("<Q", memory, 128)[0]
        except (FileNotFoundError, struct.error):
            return 0, 0

    def wait_until(self, condition):
        end = time.monotonic() + PATIENCE
        while not condition():
            self.assertLess(time.monotonic(), end)
            time.sleep(0.005)

    def begin(self, *command):
        client = subprocess.Popen(list(map(str, command)), text=True, stdout=subprocess.PIPE, stderr=subprocess.PIPE)
        self.addCleanup(client.stdout.close)
        self.addCleanup(client.stderr.close)
        self.addCleanup(client.wait)
        self.addCleanup(client.kill)
        return client

    def clients(self, channel, seconds):
        return (CLIENT_C, channel, seconds), (sys.executable, "-B", CLIENT_PY, channel, "--seconds", seconds)

    def test_clients_go_on(self):
        name, report_file = f"anew-{os.getpid()}", self.folder / "report.json"
        for command in self.clients(f"shm:{name}", 2):
            program = self.start(f"shm:{name}")
            client = self.begin(*command)
            self.wait_until(lambda: self.counts(name)[1] > 20)
            program.kill()
            program.wait(PATIENCE)
            again = self.start(f"shm:{name}", "--json", report_file)
            output, errors = client.communicate(timeout=PATIENCE)
            self.assertEqual((client.returncode, errors), (0, ""))
            self.assertNotIn("no longer answers", output)
            self.stop(again)
            self.assertGreater(json.loads(report_file.read_text())["engine"]["accepted"], 10)

    def test_clients_wait_for_an_owner(self):
        name = f"stale-{os.getpid()}"
        for command in self.clients(f"shm:{name}", 0.3):
            program = self.start(f"shm:{name}")
            self.wait_until(lambda: self.counts(name)[0] > 0)
            program.kill()
            program.wait(PATIENCE)
            with self.assertRaisesRegex(engine_client.ChannelError, "has ended"):
                engine_client.open_channel(f"shm:{name}")
            client = self.begin(*command)
            time.sleep(0.4)
            self.assertEqual((client.poll(), self.counts(name)[1]), (None, 0))
            again = self.start(f"shm:{name}")
            output, errors = client.communicate(timeout=PATIENCE)
            self.assertEqual((client.returncode, errors), (0, ""))
            self.assertRegex(output, r"^[1-9]\d* ticks received")
            self.stop(again)


class Words(EngineTest):
    def test_options_that_do_not_go_together(self):
        for option, value in (("--motion", ["0=spin:0,0,1,10"]), ("--patch", ["1"]), ("--free-running", []),
                              ("--force", ["penalty"])):
            self.refuse("touch", "cube", "--device", "hand:press", "--engine", "udp:0", option, *value,
                        status=2, says=(option, "--engine"))
        self.refuse("touch", "cube", "--device", "replay:x.pxt", "--engine", "udp:0", status=2, says="--engine")
        for wrong in ("tcp:1", "shm:", "shm:a/b", "udp:x"):
            self.refuse("touch", "cube", "--device", "hand:press", "--engine", wrong, status=2, says=wrong.split(":")[1])
        with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as line:
            line.bind(("127.0.0.1", 0))
            port = line.getsockname()[1]
            self.refuse("touch", "cube", "--device", "hand:press", "--engine", f"udp:{port}", says="in use")

    def test_other_versions_are_refused_by_both_sides(self):
        port = free_port()
        program = self.start(f"udp:{port}", seconds=3600)
        with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as line:
            line.connect(("127.0.0.1", port))
            for _ in range(50):
                try:
                    line.send(struct.pack("<4sHH56x", b"PXSC", 3, 64))
                except ConnectionRefusedError:
                    pass
                time.sleep(0.02)
        text, _ = self.stop(program)
        self.assertRegex(text, r"packets at udp:127.0.0.1:\d+ have version 3 of the protocol, and this program has 2")
        for client in ([CLIENT_C], [sys.executable, "-B", CLIENT_PY]):
            with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as line:
                line.bind(("127.0.0.1", 0))
                line.settimeout(PATIENCE)
                running = subprocess.Popen([*client, f"udp:{line.getsockname()[1]}"], text=True, stdout=subprocess.PIPE,
                                           stderr=subprocess.PIPE)
                _, address = line.recvfrom(2048)
                line.sendto(struct.pack("<4sHH568x", b"PXTO", 3, 576), address)
                _, errors = running.communicate(timeout=PATIENCE)
                self.assertEqual(running.returncode, 1)
                self.assertRegex(errors, r"version")

    def test_nobody_comes(self):
        report = self.json_of("touch", "cube", "--device", "hand:press", "--engine", "udp:0", "--seconds", 0.1)
        self.assertIn("no packet arrived at udp:127.0.0.1:", report["engine"]["trouble"])
        text = self.succeed("touch", "cube", "--device", "hand:press", "--engine", "udp:0", "--seconds", 0.1)
        self.assertIn("engine: no packet arrived", text)


if __name__ == "__main__":
    unittest.main()
