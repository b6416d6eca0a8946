"""Reads exported octrees with other software and prints their leaves, sorted, one per line:

    lower x y z, upper x y z, class, depth, triangles          of octrees
    lower x y z, upper x y z, list length, blocks, depth       of proximity octrees

A line "file" comes before those of each. Coordinates are printed as hexadecimal floats. Exit status 77 where VTK for Python is not installed.
"""
import json
import struct
import sys


def leaf_line(bounds, *numbers):
    return ",".join([float(b).hex() for b in bounds] + [str(int(n)) for n in numbers])


def vtk_output(path, reader_name):
    try:
        import vtk
    except ImportError:
        print("python3-vtk9 is not installed")
        sys.exit(77)

    errors = []
    reader = getattr(vtk, reader_name)()
    reader.AddObserver("ErrorEvent", lambda *_: errors.append("VTK reports an error"))
    reader.SetFileName(path)
    reader.Update()
    if errors:
        sys.exit(errors[0])
    data = reader.GetOutput().GetCellData()
    return vtk, reader.GetOutput(), {n: data.GetArray(n) for n in cell_data_names(data)}


def cell_data_names(data):
    if data.HasArray("class"):
        return "class", "depth", "triangles"
    return "list_length", "blocks", "depth"


def read_vtu(path, reader_name="vtkXMLUnstructuredGridReader"):
    vtk, grid, arrays = vtk_output(path, reader_name)
    for cell in range(grid.GetNumberOfCells()):
        b = grid.GetCell(cell).GetBounds()
        points = grid.GetCell(cell).GetPoints()
        assert grid.GetCellType(cell) == vtk.VTK_VOXEL
        for corner in range(8):
            assert points.GetPoint(corner) == tuple(b[2 * k + (corner >> k & 1)] for k in range(3))
        yield leaf_line((b[0], b[2], b[4], b[1], b[3], b[5]),
                        *(array.GetValue(cell) for array in arrays.values()))


def read_pvtu(path):
    return read_vtu(path, "vtkXMLPUnstructuredGridReader")


def read_htg(path):
    vtk, grid, arrays = vtk_output(path, "vtkXMLHyperTreeGridReader")
    planes = [[values.GetValue(i) for i in (0, 1)]
              for values in (grid.GetXCoordinates(), grid.GetYCoordinates(), grid.GetZCoordinates())]
    root = [planes[axis][side] for side in (0, 1) for axis in range(3)]
    yield "root," + ",".join(float(b).hex() for b in root)
    cursor = vtk.vtkHyperTreeGridNonOrientedGeometryCursor()
    cursor.Initialize(grid, 0)

    def leaves():
        index = cursor.GetGlobalNodeIndex()
        bounds = [0.0] * 6
        cursor.GetBounds(bounds)
        assert arrays["depth"].GetValue(index) == cursor.GetLevel()
        if cursor.IsLeaf():
            places = []
            for side in (0, 1):
                for axis in range(3):
                    lower, upper = planes[axis]
                    place = (bounds[2 * axis + side] - lower) / (upper - lower) * 2**20
                    assert abs(place - round(place)) < 0.01
                    places.append(round(place))
            yield ",".join(str(n) for n in places + [a.GetValue(index) for a in arrays.values()])
            return
        if "class" in arrays:
            assert arrays["class"].GetValue(index) == 2 or arrays["triangles"].GetValue(index) == 0
        else:
            assert arrays["list_length"].GetValue(index) == arrays["blocks"].GetValue(index) == 0
        for octant in range(8):
            cursor.ToChild(octant)
            yield from leaves()
            cursor.ToParent()

    yield from leaves()


def read_ply(path):
    """The boxes of our .ply: eight vertices and six quads each, normals pointing out."""
    data = open(path, "rb").read()
    end = data.index(b"end_header\n") + len(b"end_header\n")
    words = data[:end].decode().split()
    counts = {words[i + 1]: int(words[i + 2]) for i, w in enumerate(words) if w == "element"}
    vertex, face = struct.Struct("<3d3B"), struct.Struct("<B4I5B")
    assert len(data) == end + counts["vertex"] * vertex.size + counts["face"] * face.size
    vertices = list(vertex.iter_unpack(data[end:end + counts["vertex"] * vertex.size]))
    faces = list(face.iter_unpack(data[end + counts["vertex"] * vertex.size:]))
    assert counts["vertex"] * 6 == counts["face"] * 8
    for leaf in range(counts["vertex"] // 8):
        corners = [v[:3] for v in vertices[8 * leaf:8 * leaf + 8]]
        box = [f(c[k] for c in corners) for f in (min, max) for k in range(3)]
        used = set()
        for side in faces[6 * leaf:6 * leaf + 6]:
            assert side[0] == 4 and side[5:8] == vertices[side[1]][3:6]
            a, b, c, d = (vertices[i][:3] for i in side[1:5])
            used.update((a, b, c, d))
            u = [b[k] - a[k] for k in range(3)]
            v = [d[k] - a[k] for k in range(3)]
            n = [u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]]
            out = [(a[k] + c[k]) / 2 - (box[k] + box[k + 3]) / 2 for k in range(3)]
            assert sum(p * q for p, q in zip(n, out)) > 0, "a side faces in"
        assert len(used) == 8
        yield leaf_line(box, side[8], side[9], -1)


def read_glb(path):
    """Checks the container and every accessor; prints the boxes of the boundary leaves."""
    data = open(path, "rb").read()
    magic, version, total = struct.unpack_from("<4sII", data)
    assert (magic, version, total) == (b"glTF", 2, len(data))
    size, kind = struct.unpack_from("<I4s", data, 12)
    assert kind == b"JSON" and size % 4 == 0
    gltf = json.loads(data[20:20 + size])
    buffer_size, kind = struct.unpack_from("<I4s", data, 20 + size)
    assert kind == b"BIN\0" and buffer_size % 4 == 0
    buffer = data[28 + size:]
    assert len(buffer) == buffer_size == gltf["buffers"][0]["byteLength"]
    assert gltf["asset"]["version"] == "2.0"

    def values(index):
        accessor = gltf["accessors"][index]
        view = gltf["bufferViews"][accessor["bufferView"]]
        width = {"VEC3": 3, "SCALAR": 1}[accessor["type"]]
        code = {5126: "f", 5125: "I"}[accessor["componentType"]]
        assert view["byteOffset"] % 4 == 0 and view["byteLength"] == 4 * width * accessor["count"]
        assert view["byteOffset"] + view["byteLength"] <= buffer_size
        flat = struct.unpack_from("<%d%s" % (width * accessor["count"], code), buffer,
                                  view["byteOffset"])
        if width == 1:
            return flat
        points = [flat[i:i + 3] for i in range(0, len(flat), 3)]
        for k in range(3):
            lower, upper = min(p[k] for p in points), max(p[k] for p in points)
            assert struct.pack("<f", accessor["min"][k]) == struct.pack("<f", lower)
            assert struct.pack("<f", accessor["max"][k]) == struct.pack("<f", upper)
        return points

    assert gltf["scenes"][0]["nodes"] == list(range(len(gltf["nodes"])))
    for node in gltf["nodes"]:
        (primitive,) = gltf["meshes"][node["mesh"]]["primitives"]
        assert primitive["material"] < len(gltf["materials"])
        points = values(primitive["attributes"]["POSITION"])
        indices = values(primitive["indices"])
        assert max(indices) < len(points)
        if primitive["mode"] == 4:
            assert len(indices) % 3 == 0
            yield "mesh,%d" % (len(indices) // 3)
            continue
        assert primitive["mode"] == 1 and len(indices) % 24 == 0
        for first in range(0, len(indices), 24):
            ends = [points[i] for i in indices[first:first + 24]]
            for a, b in zip(ends[::2], ends[1::2]):
                assert sum(p != q for p, q in zip(a, b)) == 1, "an edge leaves its axis"
            assert len(set(ends)) == 8
            box = [f(c[k] for c in ends) + node["translation"][k]
                   for f in (min, max) for k in range(3)]
            yield leaf_line(box, 2, -1, -1)


READERS = {"htg": read_htg, "vtu": read_vtu, "pvtu": read_pvtu, "ply": read_ply, "glb": read_glb}
for name in sys.argv[1:]:
    print("file")
    for line in sorted(READERS[name.rsplit(".", 1)[1]](name)):
        print(line)
