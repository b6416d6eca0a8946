#!/usr/bin/env python3
"""The engine's side of a channel to Proxima (docs/engine_channel.md): moves an object, and prints what is felt.

    proxima touch cube --device hand:press --engine udp:4712      in one terminal
    engine_client.py udp:4712                                     in another

Needs nothing beyond Python 3.9. The classes UdpChannel and SharedMemoryChannel are all that a program of your own needs:

    channel = open_channel("udp:4712")                                # or "shm:NAME"
    channel.send([pose_of(0, (0, 0, 0.1))])                           # 60 to 100 times a second
    for state in channel.receive(): print(state["force"])             # all ticks since the last call
"""
import argparse
import csv
import fcntl
import math
import mmap
import os
import random
import socket
import struct
import sys
import time

VERSION = 2
SCENE = struct.Struct("<4sHHQQQIIddII")
OBJECT = struct.Struct("<II3d4d3d3d4d")
TOUCH = struct.Struct("<4sHH11Q6Id3d3d4d3d3d3d3d3dd3d3d" + "II3d3dd" * 3)
SEGMENT = struct.Struct("<4sHHIIQQ4I4I")
HAS_POSE, HAS_VELOCITY, HAS_MATERIAL, LEAVING = 1, 2, 4, 1


class ChannelError(Exception):
    """What is wrong, in words."""


def pose_of(number, position, quaternion=(1, 0, 0, 0), velocity=None, spin=(0, 0, 0), material=None):
    """An object of a scene packet. The quaternion is w, x, y, z; velocity and spin are per second, the spin in radians about
    the scene's axes; the material is stiffness (N/m), damping (N s/m), static and dynamic friction."""
    flags = HAS_POSE | (HAS_VELOCITY if velocity or any(spin) else 0) | (HAS_MATERIAL if material else 0)
    return OBJECT.pack(number, flags, *position, *quaternion, *(velocity or (0, 0, 0)), *spin, *(material or (0, 0, 0, 0)))


def state_of(packet):
    """A touch packet as a dictionary. Raises ChannelError for another version."""
    magic, version, size = struct.unpack_from("<4sHH", packet)
    if magic != b"PXTO" or size != len(packet):
        raise ChannelError("this is no touch packet")
    if version != VERSION:
        raise ChannelError(f"Proxima has version {version} of the protocol, and this client {VERSION}: use two that fit")
    n = TOUCH.unpack(packet)
    state = dict(zip(("session", "tick", "nanoseconds", "engine_session", "engine_sequence", "engine_nanoseconds",
                      "accepted", "lost", "refused", "refused_objects", "unsent", "condition", "flags", "hold"), n[3:17]))
    state["buttons"] = n[18]
    state["units_per_metre"] = n[20]
    at = 21
    for name, size in (("center", 3), ("device", 3), ("rotation", 4), ("proxy", 3), ("anchor", 3), ("force", 3), ("torque", 3),
                       ("normal", 3), ("depth", 1), ("surface_velocity", 3), ("force_scale", 1), ("softness", 1),
                       ("added_damping", 1)):
        state[name] = n[at] if size == 1 else n[at:at + size]
        at += size
    state["contacts"] = [{"object": c[0], "triangle": c[1], "position": c[2:5], "normal": c[5:8], "pressure": c[8]}
                         for c in (n[at + 9 * i:at + 9 * i + 9] for i in range(n[17]))]
    return state


class Channel:
    """What both ways to Proxima have in common: numbers and counts."""

    def __init__(self):
        self.session = random.getrandbits(64)
        self.sequence = 0
        self.last_tick = 0
        self.missed = 0  # ticks that were not received

    def scene_packet(self, objects, flags, reply_every, period, material_seconds):
        self.sequence += 1
        body = b"".join(objects)
        return SCENE.pack(b"PXSC", VERSION, SCENE.size + len(body), self.session, self.sequence, time.monotonic_ns(),
                          len(objects), flags, period, material_seconds, reply_every, 0) + body

    def counted(self, state):
        if self.last_tick and state["tick"] > self.last_tick + 1:
            self.missed += state["tick"] - self.last_tick - 1
        self.last_tick = state["tick"]
        return state


class UdpChannel(Channel):
    def __init__(self, host, port):
        super().__init__()
        self.line = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self.line.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 1 << 20)
        self.line.connect((host, port))
        self.line.setblocking(False)

    def send(self, objects=(), flags=0, reply_every=1, period=0, material_seconds=0.05):
        try:
            self.line.send(self.scene_packet(objects, flags, reply_every, period, material_seconds))
        except ConnectionRefusedError:
            pass  # nobody listens yet

    def receive(self):
        """The states of all ticks that came since the last call, in order."""
        states = []
        while True:
            try:
                states.append(self.counted(state_of(self.line.recv(2048))))
            except BlockingIOError:
                return states
            except ConnectionRefusedError:
                pass

    def close(self):
        self.send(flags=LEAVING)
        self.line.close()


class SharedMemoryChannel(Channel):
    """Relies on a processor that keeps the order of writes, as x86 does: on others a packet may be torn, and is refused
    or counts for a frame."""

    def __init__(self, name):
        super().__init__()
        path = f"/dev/shm/proxima-{name}"
        try:
            self.file = os.open(path, os.O_RDWR | os.O_CLOEXEC)
        except FileNotFoundError:
            raise ChannelError(f"there is no {path}: start proxima touch ... --engine shm:{name} first") from None
        try:
            rings = self.join(path)
        except BaseException:
            os.close(self.file)
            raise
        self.touch, self.scene = rings[:4], rings[4:]  # offset, size and number of slots, offset of the count
        self.read = self.number_at(self.touch[3])
        self.written = self.number_at(self.scene[3])

    def join(self, path):
        """Locks and maps the file. Returns where its two rings are."""
        try:  # Proxima holds this lock while it runs; what a killed one left, the next one takes over
            fcntl.flock(self.file, fcntl.LOCK_SH | fcntl.LOCK_NB)
        except OSError:
            pass
        else:
            fcntl.flock(self.file, fcntl.LOCK_UN)
            raise ChannelError(f"the program that made {path} has ended")
        try:  # one engine at a time; the lock is the process's, and does not keep two channels of one program apart
            fcntl.lockf(self.file, fcntl.LOCK_EX | fcntl.LOCK_NB, 1)
        except OSError:
            raise ChannelError(f"another engine uses {path}") from None
        if os.fstat(self.file).st_size < SEGMENT.size:
            raise ChannelError(f"{path} is not set up yet")
        self.memory = mmap.mmap(self.file, 0)
        magic, version, _, endianness, flags, size, _, *rings = SEGMENT.unpack_from(self.memory)
        if magic != b"PXSM" or endianness != 0x01020304 or size != len(self.memory):
            raise ChannelError(f"{path} is no channel of Proxima, or not set up yet")
        if version != VERSION:
            raise ChannelError(f"Proxima has version {version} of the protocol, and this client {VERSION}: use two that fit")
        if not flags & 1:
            raise ChannelError(f"the program that made {path} has ended")
        return rings

    def number_at(self, offset):
        return struct.unpack_from("<Q", self.memory, offset)[0]

    def send(self, objects=(), flags=0, reply_every=1, period=0, material_seconds=0.05):
        packet = self.scene_packet(objects, flags, reply_every, period, material_seconds)
        slot = self.scene[0] + self.scene[1] * (self.written % self.scene[2])
        struct.pack_into("<Q", self.memory, slot, 2 * self.written + 1)
        self.memory[slot + 8:slot + 8 + len(packet)] = packet
        struct.pack_into("<Q", self.memory, slot, 2 * self.written + 2)
        self.written += 1
        struct.pack_into("<Q", self.memory, self.scene[3], self.written)

    def receive(self):
        """The states of all ticks since the last call, in order; those that were overwritten are missed."""
        written = self.number_at(self.touch[3])
        if written < self.read:  # Proxima was started anew with the same memory
            self.read = 0
        self.read = max(self.read, written - self.touch[2])
        states = []
        while self.read < written:
            slot = self.touch[0] + self.touch[1] * (self.read % self.touch[2])
            there = 2 * self.read + 2
            self.read += 1
            if self.number_at(slot) != there:
                continue
            packet = self.memory[slot + 8:slot + 8 + TOUCH.size]
            if self.number_at(slot) == there:
                states.append(self.counted(state_of(packet)))
        return states

    def close(self):
        self.send(flags=LEAVING)
        self.memory.close()
        os.close(self.file)


def open_channel(name, patience=0):
    """udp:PORT, udp:ADDRESS:PORT or shm:NAME. Waits so many seconds for shared memory to be there."""
    kind, _, rest = name.partition(":")
    if kind == "udp":
        host, _, port = rest.rpartition(":")
        if not port.isdecimal() or not 0 < int(port) < 65536:
            raise ChannelError(f"{name} is no channel: give a port from 1 to 65535")
        return UdpChannel(host or "127.0.0.1", int(port))
    if kind != "shm":
        raise ChannelError(f"{name} is no channel: give udp:PORT, udp:ADDRESS:PORT or shm:NAME")
    end = time.monotonic() + patience
    while True:
        try:
            return SharedMemoryChannel(rest)
        except ChannelError:
            if time.monotonic() > end:
                raise
            time.sleep(0.02)


def quantile(values, part):
    return sorted(values)[min(len(values) - 1, int(part * len(values)))] if values else math.nan


def main():
    parser = argparse.ArgumentParser(description="Moves an object of proxima touch --engine, and prints what is felt")
    parser.add_argument("channel", help="udp:PORT, udp:ADDRESS:PORT or shm:NAME")
    parser.add_argument("--seconds", type=float, default=5, help="from the first answer on")
    parser.add_argument("--patience", type=float, default=10, help="seconds to wait for Proxima")
    parser.add_argument("--rate", type=float, default=60, help="poses per second")
    parser.add_argument("--object", type=int, default=0)
    parser.add_argument("--swing", type=float, default=0.1, help="how far the object goes up and down, in the scene's unit")
    parser.add_argument("--material", help="stiffness,damping,static friction,dynamic friction")
    parser.add_argument("--csv", help="write a row for each tick")
    options = parser.parse_args()
    if not options.rate > 0:
        parser.error("--rate must be more than 0")
    try:
        material = tuple(map(float, options.material.split(","))) if options.material else None
    except ValueError:
        material = ()
    if material is not None and len(material) != 4:
        parser.error("--material takes four numbers")
    channel = open_channel(options.channel, options.patience)
    started = time.monotonic()
    first = heard = None
    states, delays, sent_at = [], [], {}
    next_pose = started
    while first is None or time.monotonic() - first < options.seconds:
        now = time.monotonic()
        if first is not None and now - heard > 2:
            print("Proxima no longer answers")
            break
        if first is None and now - started > options.patience:
            raise ChannelError(f"nobody answers at {options.channel}: is proxima touch ... --engine {options.channel} "
                               f"running, with version {VERSION} of the protocol, and with no other engine?")
        if now >= next_pose:
            next_pose = max(next_pose + 1 / options.rate, now)
            phase = 0 if first is None else now - first
            height = options.swing * math.sin(math.pi * phase)
            channel.send([pose_of(options.object, (0, 0, height), material=material)])
            sent_at[channel.sequence] = time.monotonic()
        for state in channel.receive():
            if state["engine_session"] != channel.session:
                continue
            heard = time.monotonic()
            first = first or heard
            states.append(state)
            if state["engine_sequence"] in sent_at:  # the first tick with that pose
                delays.append(time.monotonic() - sent_at.pop(state["engine_sequence"]))
        time.sleep(0.0002)
    channel.close()
    if options.csv:
        with open(options.csv, "w", newline="") as file:
            writer = csv.writer(file)
            writer.writerow(["tick", "fx", "fy", "fz", "proxy_z", "anchor_z", "device_z", "contacts"])
            for state in states:
                touched = " ".join(f"{c['object']}:{c['triangle']}" for c in state["contacts"])
                writer.writerow([state["tick"], *state["force"], state["proxy"][2], state["anchor"][2], state["device"][2], touched])
    force = max(math.hypot(*state["force"]) for state in states)
    touching = sum(1 for state in states if state["contacts"])
    print(f"{len(states)} ticks received, {channel.missed} missed; {channel.sequence} packets sent, {states[-1]['lost']} lost")
    print(f"touching in {touching} ticks, force at most {force:.3f} N")
    print(f"from a pose to the force of its first tick: p50 {1e3 * quantile(delays, 0.5):.3f} ms, "
          f"p99 {1e3 * quantile(delays, 0.99):.3f} ms")


if __name__ == "__main__":
    try:
        main()
    except ChannelError as error:
        sys.exit(f"engine_client.py: {error}")
