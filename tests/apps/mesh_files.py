"""A tetrahedron in every format that proxima reads, as bytes; READ are those that this build reads."""
import base64
import json
import os
import struct

POSITIONS = [(0.0, 0.0, 0.0), (1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0)]
TRIANGLES = [(0, 2, 1), (0, 1, 3), (0, 3, 2), (1, 2, 3)]


def obj():
    lines = ["v %r %r %r" % point for point in POSITIONS]
    lines += ["f %d %d %d" % tuple(i + 1 for i in triangle) for triangle in TRIANGLES]
    return "\n".join(lines).encode() + b"\n"


def off():
    lines = ["OFF", "4 4 6"] + ["%r %r %r" % point for point in POSITIONS]
    lines += ["3 %d %d %d" % triangle for triangle in TRIANGLES]
    return "\n".join(lines).encode() + b"\n"


def ply_header(encoding):
    return (f"ply\nformat {encoding} 1.0\nelement vertex 4\nproperty double x\nproperty double y\n"
            "property double z\nelement face 4\nproperty list uchar int vertex_indices\nend_header\n").encode()


def ply_ascii():
    lines = ["%r %r %r" % point for point in POSITIONS] + ["3 %d %d %d" % t for t in TRIANGLES]
    return ply_header("ascii") + "\n".join(lines).encode() + b"\n"


def ply_binary(order, encoding):
    data = b"".join(struct.pack(order + "3d", *point) for point in POSITIONS)
    data += b"".join(struct.pack(order + "B3i", 3, *triangle) for triangle in TRIANGLES)
    return ply_header(encoding) + data


def stl_ascii():
    text = "solid t\n"
    for triangle in TRIANGLES:
        text += "facet normal 0 0 0\nouter loop\n"
        text += "".join("vertex %r %r %r\n" % POSITIONS[i] for i in triangle)
        text += "endloop\nendfacet\n"
    return (text + "endsolid t\n").encode()


def stl_binary():
    data = b" " * 80 + struct.pack("<I", len(TRIANGLES))
    for triangle in TRIANGLES:
        data += struct.pack("<12fH", 0, 0, 0, *(x for i in triangle for x in POSITIONS[i]), 0)
    return data


def chunk(kind, content):
    return struct.pack("<HI", kind, 6 + len(content)) + content


def three_ds():
    vertices = struct.pack("<H", 4) + b"".join(struct.pack("<3f", *point) for point in POSITIONS)
    faces = struct.pack("<H", 4) + b"".join(struct.pack("<4H", *triangle, 0) for triangle in TRIANGLES)
    mesh = chunk(0x4100, chunk(0x4110, vertices) + chunk(0x4120, faces))
    return chunk(0x4D4D, chunk(0x3D3D, chunk(0x4000, b"t\0" + mesh)))


def gltf_parts():
    points = b"".join(struct.pack("<3f", *point) for point in POSITIONS)
    indices = b"".join(struct.pack("<3H", *triangle) for triangle in TRIANGLES)
    scene = {"asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0]}], "nodes": [{"mesh": 0}],
             "meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "indices": 1}]}],
             "buffers": [{"byteLength": len(points) + len(indices)}],
             "bufferViews": [{"buffer": 0, "byteLength": len(points)},
                             {"buffer": 0, "byteOffset": len(points), "byteLength": len(indices)}],
             "accessors": [{"bufferView": 0, "componentType": 5126, "count": 4, "type": "VEC3",
                            "min": [0, 0, 0], "max": [1, 1, 1]},
                           {"bufferView": 1, "componentType": 5123, "count": 12, "type": "SCALAR"}]}
    return scene, points + indices


def gltf():
    scene, data = gltf_parts()
    scene["buffers"][0]["uri"] = "data:application/octet-stream;base64," + base64.b64encode(data).decode()
    return json.dumps(scene).encode()


def glb():
    scene, data = gltf_parts()
    text = json.dumps(scene).encode()
    text += b" " * (-len(text) % 4)
    data += b"\0" * (-len(data) % 4)
    body = struct.pack("<I4s", len(text), b"JSON") + text + struct.pack("<I4s", len(data), b"BIN\0") + data
    return struct.pack("<4sII", b"glTF", 2, 12 + len(body)) + body


PLAIN = {"a.obj": obj(), "a.off": off(), "ascii.ply": ply_ascii(),
         "little.ply": ply_binary("<", "binary_little_endian"),
         "big.ply": ply_binary(">", "binary_big_endian"), "ascii.stl": stl_ascii(),
         "binary.stl": stl_binary()}
SCENES = {"a.3ds": three_ds(), "a.gltf": gltf(), "a.glb": glb()}
READS_SCENES = os.environ.get("PROXIMA_WITH_ASSIMP", "ON") == "ON"  # what the program was built with
READ = {**PLAIN, **(SCENES if READS_SCENES else {})}
