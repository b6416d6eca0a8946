"""A device in another program, over UDP."""
import os
import socket
import struct
import threading
import time

PATIENCE = 60  # seconds until the program is there


class UdpHand(threading.Thread):
    """The device's side, by the documented bytes alone: goes down 30 mm in a second and stays.

    It waits above until the program answers, since a busy machine may take seconds to start that. On a poor line four of
    ten numbers never come, and now and then a packet is a second old."""

    def __init__(self, port, seconds, junk=False, silent=(9, 9), poor=False):
        super().__init__(daemon=True)
        self.port, self.seconds, self.junk, self.silent, self.poor = port, seconds, junk, silent, poor
        self.replies = []

    def run(self):
        with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as line:
            line.setblocking(False)
            self.move(line)

    def move(self, line):
        started = time.monotonic()
        begin = None
        number = 0
        passed = 0
        while passed < self.seconds:
            number += 5 if self.poor and number % 10 == 9 else 1
            now = time.monotonic()
            if begin is None and self.replies:
                begin = now
            if begin is None and now - started > PATIENCE:
                return
            passed = now - begin if begin else 0
            height = 0.05 - 0.03 * min(passed, 1)
            buttons = 1 if passed > 0.5 else 0
            age = 1 if self.poor and number % 100 == 5 else 0
            packet = struct.pack("<4sHHQQQII3d3d4d", b"PXUP", 1, 120, 4242, number, int((now - started + 1 - age) * 1e9), buttons, 0,
                                 0, 0, height, 0, 0, 0, 1, 0, 0, 0)
            if not self.silent[0] <= passed < self.silent[1]:
                line.sendto(packet, ("127.0.0.1", self.port))
            if self.junk:
                line.sendto(os.urandom(number % 300), ("127.0.0.1", self.port))
                line.sendto(packet[:-1], ("127.0.0.1", self.port))
            try:
                while True:
                    reply = line.recv(1024)
                    self.replies.append(struct.unpack("<4sHHQQQII3ddddddd3d12d3d", reply))
            except OSError:  # nothing more, or nobody there yet
                pass
            time.sleep(0.001)


def free_port():
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as line:
        line.bind(("127.0.0.1", 0))
        return line.getsockname()[1]
