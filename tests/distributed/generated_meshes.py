"""Meshes for the tests of proxima-mpi, and the bytes of their files."""
import math
import random
import struct


def ply(positions, triangles):
    header = (f"ply\nformat binary_little_endian 1.0\nelement vertex {len(positions)}\nproperty double x\nproperty double y\n"
              f"property double z\nelement face {len(triangles)}\nproperty list uchar int vertex_indices\nend_header\n")
    return (header.encode() + b"".join(struct.pack("<3d", *at) for at in positions)
            + b"".join(struct.pack("<B3i", 3, *corners) for corners in triangles))


def npy(rows, kind, letter, version=1):
    """An array of N x 3 numbers as NumPy writes it: kind "<f8" and the like, with the letter that struct has for it."""
    header = f"{{'descr': '{kind}', 'fortran_order': False, 'shape': ({len(rows)}, 3), }}"
    header += " " * (-(len(header) + 9 + 2 * version) % 64) + "\n"
    return (b"\x93NUMPY" + bytes([version, 0]) + struct.pack("<H" if version == 1 else "<I", len(header)) + header.encode()
            + b"".join(struct.pack(f"<3{letter}", *row) for row in rows))


def nasty_mesh(seed):
    """Slivers, corners on cell planes and triangles across everything, in no order."""
    chance = random.Random(seed)
    kinds = [lambda: [float(chance.randrange(9)) for _ in range(3)],
             lambda: [chance.uniform(0, 8) for _ in range(3)]]
    positions = [kinds[seed % 2]() for _ in range(chance.randrange(3, 200))]
    count = chance.randrange(1, 300)
    return positions, [[chance.randrange(len(positions)) for _ in range(3)] for _ in range(count)]


def wide_triangles(seed, count):
    """Triangles across a cube, without common corners."""
    chance = random.Random(seed)
    positions = [[8.0 * (chance.random() if axis == free else chance.randrange(2)) for axis in range(3)]
                 for _ in range(3 * count) for free in [chance.randrange(3)]]
    return positions, [[3 * i, 3 * i + 1, 3 * i + 2] for i in range(count)]


def shell(chance, center, radius, rows):
    """A closed surface of rings and two poles, each vertex a little off the sphere."""
    positions = [[center[0], center[1], center[2] - radius], [center[0], center[1], center[2] + radius]]
    for i in range(1, rows):
        for j in range(rows):
            polar, around = math.pi * i / rows, 2 * math.pi * j / rows
            at = radius * chance.uniform(0.9, 1)
            positions.append([center[0] + at * math.sin(polar) * math.cos(around), center[1] + at * math.sin(polar) * math.sin(around),
                              center[2] - at * math.cos(polar)])
    triangles = []
    for j in range(rows):
        following = (j + 1) % rows
        triangles.append([0, 2 + following, 2 + j])
        last = 2 + (rows - 2) * rows
        triangles.append([1, last + j, last + following])
        for i in range(rows - 2):
            low, high = 2 + i * rows, 2 + (i + 1) * rows
            triangles += [[low + j, low + following, high + following], [low + j, high + following, high + j]]
    return positions, triangles


def surfaces(seed):
    """Shells within and across each other; odd seeds with holes, flips and repeats, others with welds undone."""
    chance = random.Random(seed)
    positions, triangles = [], []
    for _ in range(chance.randrange(1, 5)):
        some, corners = shell(chance, [chance.uniform(-1, 1) for _ in range(3)], chance.uniform(0.2, 2), chance.randrange(3, 9))
        if chance.random() < 0.3:
            corners = [[a, c, b] for a, b, c in corners]
        triangles += [[corner + len(positions) for corner in three] for three in corners]
        positions += some
    if seed % 2:
        for _ in range(chance.randrange(1, 12)):
            at = chance.randrange(len(triangles))
            kind = chance.randrange(4)
            if kind < 2:
                del triangles[at:at + chance.randrange(1, 4)]
            elif kind == 2:
                triangles.append(triangles[at])
            else:
                triangles[at] = triangles[at][::-1]
            if not triangles:
                return surfaces(seed + 1000)
    if seed % 3 == 0:
        positions, triangles = ([positions[corner] for three in triangles for corner in three],
                                [[3 * i, 3 * i + 1, 3 * i + 2] for i in range(len(triangles))])
    if seed % 4 < 2:
        chance.shuffle(triangles)
    positions.insert(0, list(positions[triangles[0][0]]))  # unused, and where another vertex is
    return positions, [[corner + 1 for corner in three] for three in triangles]


BOX = [[0, 4, 6], [0, 6, 2], [1, 3, 7], [1, 7, 5], [0, 1, 5], [0, 5, 4], [2, 6, 7], [2, 7, 3], [0, 2, 3], [0, 3, 1], [4, 5, 7], [4, 7, 6]]


def ball_in_a_box(seed):
    """Most triangles in one corner of a box, so that some ranks have none of the box's walls; from seed 1 on the ball has a hole."""
    positions, triangles = shell(random.Random(seed), [0.1, 0.2, 0.3], 2, 40)
    if seed > 0:
        triangles = [three for three in triangles if min(positions[corner][seed - 1] for corner in three) < 1.5]
    first = len(positions)
    positions += [[(-3.1, 21)[corner >> axis & 1] for axis in range(3)] for corner in range(8)]
    return positions, triangles + [[first + corner for corner in three] for three in BOX]
