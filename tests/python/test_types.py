"""The type stubs are those of the module: names and signatures, and what mypy says of programs."""
import ast
import re
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

import proxima
from proxima import _core, _results

PACKAGE = Path(proxima.__file__).parent
ROOT = Path(__file__).resolve().parents[2]


def stub(name):
    """{name: nodes} of a stub's functions, and of those of its classes."""
    found = {}

    def add(body, prefix):
        for node in body:
            if isinstance(node, ast.ClassDef):
                found[prefix + node.name] = [node]
                add(node.body, prefix + node.name + ".")
            elif isinstance(node, ast.FunctionDef):
                found.setdefault(prefix + node.name, []).append(node)
            elif isinstance(node, ast.AnnAssign):
                found[prefix + node.target.id] = [node]

    add(ast.parse((PACKAGE / name).read_text()).body, "")
    return {key: nodes for key, nodes in found.items() if not key.startswith("_") or key == "__version__"}


def in_module(module, own=lambda name: not name.startswith("_")):
    for name, thing in vars(module).items():
        if own(name) or name == "__version__":
            yield name
        if own(name) and isinstance(thing, type):
            yield from (f"{name}.{member}" for member in vars(thing) if own(member) or
                        (member == "__init__" and str(vars(thing)[member].__doc__).startswith("__init__")))


def parameters(node):
    """[(name, kind, default)] of a function."""
    arguments = node.args
    plain = [argument.arg for argument in arguments.posonlyargs + arguments.args]
    defaults = [None] * (len(plain) - len(arguments.defaults)) + arguments.defaults
    listed = [(name, "plain", default) for name, default in zip(plain, defaults)]
    listed += [(argument.arg, "keyword", default) for argument, default in zip(arguments.kwonlyargs, arguments.kw_defaults)]
    return [(name, kind, default and ast.unparse(default)) for name, kind, default in listed]


def agrees(of_stub, of_module):
    """Whether a stub's parameters are the module's; "..." stands for a value that cannot be written, a Literal for any."""
    return [p[:2] for p in of_stub] == [p[:2] for p in of_module] and all(
        a == b or (a == "..." and b == "inf") for (_, _, a), (_, _, b) in zip(of_stub, of_module))


def test_names_are_those_of_the_module():
    core = stub("_core.pyi")
    names = {name for name in core if "." not in name or core[name.split(".")[0]][0].bases == [] } - {"Error.code"}
    assert names == {name for name in in_module(_core) if not name.startswith("Error.")}


@pytest.mark.parametrize("name, nodes", [
    (name, nodes) for name, nodes in stub("_core.pyi").items()
    if isinstance(nodes[0], ast.FunctionDef) and not any(isinstance(d, ast.Name) and d.id == "property"
                                                         for d in nodes[0].decorator_list)])
def test_signatures_are_those_of_the_module(name, nodes):
    if name == "Index.closest_one":
        assert [[p[0] for p in parameters(node)] for node in nodes] == [["self", "x", "y", "z"], ["self", "point"]]
        return
    thing = _core
    for part in name.split("."):
        thing = getattr(thing, part)
    real = parameters(ast.parse(f"def {thing.__doc__.splitlines()[0]}: ...").body[0])
    assert agrees(parameters(nodes[0]), real), f"{parameters(nodes[0])}\n{real}"
    for other in nodes[1:]:  # overloads differ in what one argument must be
        assert [p[:2] for p in parameters(other)] == [p[:2] for p in real]
    static = "self" not in [p[0] for p in real] and "." in name
    assert static == any(ast.unparse(d) == "staticmethod" for d in nodes[0].decorator_list)


def test_properties_are_those_of_the_module():
    for name, nodes in stub("_core.pyi").items():
        if "property" in [ast.unparse(d) for d in getattr(nodes[0], "decorator_list", [])]:
            kind, member = name.split(".")
            assert not callable(vars(getattr(_core, kind))[member]), name


def test_columns_are_those_of_the_results():
    results = stub("_results.pyi")
    for name, nodes in results.items():
        if isinstance(nodes[0], ast.ClassDef):
            fields = [node.target.id for node in nodes[0].body if isinstance(node, ast.AnnAssign)]
            assert tuple(fields) == getattr(_results, name)._fields
            own = {member for member in vars(getattr(_results, name)) if not member.startswith("_")}
            assert own == {key.split(".")[1] for key in results if key.startswith(name + ".")} - set(fields)
    assert {name for name in results if "." not in name} == {
        name for name, thing in vars(_results).items() if not name.startswith("_") and name != "namedtuple"}


def type_of(column):
    """How a stub writes the type of a column, or the beginning of that."""
    return f"NDArray[{column.dtype}]" if hasattr(column, "dtype") else type(column).__name__


def test_dtypes_of_columns():
    mesh = proxima.Mesh.sample("cube")
    index = proxima.Index(mesh)
    answers = [index.closest([[0, 0, 3]]), index.cast([0, 0, 3], [[0, 0, -1]]), index.cast([0, 0, 3], [[0, 0, -1]], hits="all"),
               index.intersect(index), index.intersect(index, [[[1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, 0]]]),
               index.within([[0, 0, 1]], 1), index.nearest([[0, 0, 1]], 2),
               proxima.Index(mesh, signs=True).distance_field(2, gradient=True, method=True), proxima.Octree(mesh).leaves(), proxima.Polyhedron.of_mesh(mesh).facets,
               proxima.Topology(mesh).patch(index.closest([[0, 0, 3]]))]
    answers += [mesh.report(), proxima.Mesh(mesh.vertices[:3], [[0, 1, 2]]).report().findings[0], mesh.repair()]
    answers += [index.self_intersections(), index.contour(index, np.eye(4)[:3] + 0.1 * np.eye(3, 4, 3)),
                proxima.Octree(mesh).along_rays([[0, 0, 3]], [[0, 0, -1]]), proxima.Material(), proxima.Texture(), proxima.DeviceLimits()]
    answers += [proxima.TouchRenderer(mesh).step(np.zeros((3, 3))), index.deviation(index, max_places=1)]
    answers += [answers[-2].contacts, answers[-1].places, proxima.both_ways(answers[-1], answers[-1])]
    scene, solid = proxima.Scene(index, [np.eye(4), np.eye(4)]), proxima.Solid(mesh)
    rays = ([0, 0, 3], [[0, 0, -1]])
    answers += [scene.closest([[0, 0, 3]]), scene.cast(*rays), scene.cast(*rays, hits="all"), scene.in_contact(), scene.within(1),
                scene.visible([[0, 0, 1, 9]], triangles=True), index.time_of_contact(index, proxima.Motion()), proxima.Motion(),
                proxima.motion_between(None, None, [0, 0, 0]), solid.penetration_depth(solid), solid.contact_regions(solid)]
    body = proxima.Polyhedron.of_mesh(mesh)
    answers.append(proxima.minkowski_sum(body, body).signed_distance([[0, 0, 9]]))
    kinds = {type(answer).__name__ for answer in answers}
    assert kinds == {n for n, t in vars(_results).items() if isinstance(t, type) and issubclass(t, tuple)} - {
        "Distances", "Containments", "Replay"}
    results = stub("_results.pyi")
    for answer in answers:
        for field, column in zip(answer._fields, answer):
            [node] = results[f"{type(answer).__name__}.{field}"]
            written = re.sub(r"bool_\b", "bool", ast.unparse(node.annotation))
            assert written.startswith(type_of(column)) or written == f"Optional[{type_of(column)}]" or (
                written == "Any" or column is None and written.startswith("Optional")), field


def mypy(folder, *what):
    done = subprocess.run([sys.executable, "-m", "mypy", "--strict", "--cache-dir", str(folder / "cache"), *what], cwd=folder,
                          env={"MYPYPATH": str(PACKAGE.parent), "PATH": "/usr/bin:/bin"}, capture_output=True, text=True)
    return done.returncode, done.stdout + done.stderr


def test_the_package_has_right_types(tmp_path):
    status, said = mypy(tmp_path, "-p", "proxima")
    assert status == 0, said


def test_mypy_takes_right_programs_and_no_wrong_ones(tmp_path):
    code = """
import numpy as np
import proxima
mesh = proxima.Mesh.sample("cube")
index = proxima.Index(mesh, signs=True, lists=1 << 20)
points = np.zeros((3, 3), "f4")
closest: proxima.Closest = index.closest(points, columns=("distance",))
corners = mesh.vertices[mesh.faces[closest.triangle]]
distances, methods = index.signed_distance(points, method=True)
inside = index.signed_distance(points) < 0
hit = index.cast(points, [[0, 0, 1]]).hit | index.cast(points, [[0, 0, 1]], hits="any")
first = index.cast([0, 0, 0], points, hits="all", t_max=3).first
one = index.closest_one(1, 2, 3.5).point[0] + index.closest_one(points[0]).distance
rings = proxima.Topology(mesh).patch(closest, 2).ring.max()
index.save("a.pxi", progress=lambda stage, part: part < 0.5)
try:
    proxima.Octree.load("none.pxo").leaves().kind
except proxima.FileMissing as error:
    print(error.code, error.errno)
"""
    (tmp_path / "right.py").write_text(code)
    status, said = mypy(tmp_path, "right.py")
    assert status == 0, said
    (tmp_path / "wrong.py").write_text("""
import proxima
mesh = proxima.Mesh.sample("cube")
index = proxima.Index(mesh, True)
index.closest([[0, 0, 0]]).colour
index.cast([0, 0, 0], [[0, 0, 1]], hits="none")
proxima.Mesh.read(3)
index.signed_distance([[0, 0, 0]], method=True).shape
proxima.Topology(index)
""")
    said = mypy(tmp_path, "wrong.py")[1]
    assert [int(line) for line in re.findall(r"^wrong.py:(\d+): error", said, re.MULTILINE)] == [4, 5, 6, 7, 8, 9], said
