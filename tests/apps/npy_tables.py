"""Tables of numbers in .npy files, without NumPy."""
import struct


def npy(points, kind="<f8", columns_first=False, shape=None, version=1):
    """The bytes of a .npy file."""
    header = "{'descr': '%s', 'fortran_order': %s, 'shape': %s, }" % (kind, columns_first, shape or (len(points), 3))
    length = struct.pack("<H" if version == 1 else "<I", len(header) + 1)
    numbers = [p[axis] for axis in range(3) for p in points] if columns_first else [x for p in points for x in p]
    letter = {"f2": "e", "f4": "f", "f8": "d", "i1": "b", "i2": "h", "i4": "i", "i8": "q", "u1": "B", "u2": "H"}[kind[1:]]
    if kind[1] != "f":
        numbers = list(map(int, numbers))
    return (b"\x93NUMPY" + bytes((version, 0)) + length + header.encode() + b"\n"
            + struct.pack("%s%d%s" % (kind[0].replace("|", "<"), len(numbers), letter), *numbers))


def read_npy(data):
    """Rows of a table of float64."""
    length = struct.unpack_from("<H", data, 8)[0]
    header = eval(data[10:10 + length])
    rows, columns = header["shape"]
    assert (data[:8], header["descr"], header["fortran_order"]) == (b"\x93NUMPY\x01\x00", "<f8", False)
    assert (10 + length) % 64 == 0 and len(data) == 10 + length + 8 * rows * columns
    return [struct.unpack_from("<%dd" % columns, data, 10 + length + 8 * columns * i) for i in range(rows)]
