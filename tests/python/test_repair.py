"""Reports and repairs against counting by NumPy alone."""
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import proxima


def edges_of(faces):
    """(3 F, 2) directed edges."""
    return np.stack([faces, np.roll(faces, -1, axis=1)], axis=2).reshape(-1, 2)


def volume_of(mesh):
    return np.linalg.det(mesh.vertices[mesh.faces]).sum() / 6


def soup(mesh):
    """Each triangle with corners of its own."""
    return proxima.Mesh(mesh.vertices[mesh.faces].reshape(-1, 3), np.arange(3 * len(mesh.faces)).reshape(-1, 3))


def found(report, kind):
    return next((finding for finding in report.findings if finding.kind == kind), None)


def test_report_of_a_torus(mesh):
    report = mesh.report()
    corners = mesh.vertices[mesh.faces]
    area = np.linalg.norm(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1).sum() / 2
    lengths = np.linalg.norm(corners - np.roll(corners, 1, axis=1), axis=2)
    assert report[:5] == (len(mesh.vertices), len(mesh.faces), 3 * len(mesh.faces) // 2, 1, 0)
    assert np.array_equal(report.bounds, mesh.bounds)
    assert np.allclose([report.area, report.min_edge_length, report.max_edge_length, report.volume],
                       [area, lengths.min(), lengths.max(), volume_of(mesh)], rtol=1e-12)
    assert report.closed and report.consistently_oriented and report.closed_if_welded is None
    assert (report.orientation, report.euler_characteristic, report.genus) == ("outward", 0, 1)
    assert report.findings == () and {word for word, _ in report.outlook.values()} == {"works"}
    assert str(report).startswith("288 vertices, 576 triangles, 1 components: closed, orientation outward\noctree works")


@given(st.lists(st.tuples(*[st.integers(0, 6)] * 3), max_size=30))
def test_reports_count_as_numpy_does(faces):
    faces = np.array(faces, int).reshape(-1, 3)
    vertices = np.random.default_rng(1).integers(0, 3, (7, 3)).astype(float)
    report = proxima.Mesh(vertices, faces).report(1000)
    proper = np.array([len(set(face)) == 3 for face in faces], bool)
    edges, counts = np.unique(np.sort(edges_of(faces[proper]), axis=1), axis=0, return_counts=True)
    expected = {
        "unreferenced_vertices": len(set(range(7)) - set(faces.ravel().tolist())),
        "duplicate_vertices": 7 - len(np.unique(vertices, axis=0)),
        "degenerate_triangles": (~proper).sum(),
        "boundary_edges": (counts == 1).sum(), "non_manifold_edges": (counts > 2).sum()}
    for kind, count in expected.items():
        finding = found(report, kind)
        assert (finding.number if finding else 0) == count, kind
        assert finding is None or len(finding.ids) == len(finding.positions) == count
    assert report.closed == bool((counts % 2 == 0).all() and len(counts))
    boundary = found(report, "boundary_edges")
    if boundary:
        middles = vertices[edges[counts == 1]].mean(axis=1)
        assert sorted(map(tuple, boundary.positions)) == sorted(map(tuple, middles))


def test_findings_are_as_many_as_asked_for(mesh):
    holed = mesh.part(np.arange(10, len(mesh.faces)))
    report = holed.report(max_ids=3)
    finding = found(report, "boundary_edges")
    assert len(finding.ids) == 3 < finding.number and finding.severity == "warning" and finding.element == "edge"
    topology = proxima.Topology(holed)
    assert np.array_equal(finding.positions, holed.vertices[topology.edges[finding.ids]].mean(axis=1))
    assert not report.closed and report.volume is None and report.genus is None and "boundary_edges" in str(report)


def test_report_takes_nan():
    report = proxima.Mesh([[0, 0, 0], [1, 0, np.nan], [0, 1, 0]], [[0, 1, 2]]).report()
    assert found(report, "non_finite_positions").severity == "error" and report.outlook["octree"][0] == "refused"


def test_repair_makes_a_solid_of_a_soup(mesh):
    broken = soup(mesh)
    assert broken.report().closed_if_welded
    faces = broken.faces.copy()
    faces[::7] = faces[::7, [0, 2, 1]]
    repair = proxima.Mesh(broken.vertices, faces).repair()
    assert np.array_equal(repair.turned, np.arange(len(faces)) % 7 == 0)
    assert np.array_equal(repair.triangle, np.arange(len(faces)))
    assert np.array_equal(repair.mesh.vertices, broken.vertices[repair.vertex])
    assert np.array_equal(np.unique(repair.mesh.vertices, axis=0), np.unique(mesh.vertices, axis=0))
    corners = {tuple(sorted(map(tuple, face))) for face in mesh.vertices[mesh.faces]}
    assert {tuple(sorted(map(tuple, face))) for face in repair.mesh.vertices[repair.mesh.faces]} == corners
    report = repair.mesh.report()
    assert report.closed and report.orientation == "outward" and report.findings == ()
    assert repair.steps["weld_vertices"] == 2 * len(faces) + len(faces) - len(mesh.vertices)
    assert repair.steps["orient_pieces"] == repair.turned.sum() and "drop_zero_area" not in repair.steps
    assert (repair.pieces, repair.closed_pieces, repair.cavities, repair.unorientable_pieces) == (1, 1, 0, 0)


FLAWED = proxima.Mesh([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1], [0.5, 0, 0], [np.nan, 0, 0], [5, 5, 5]],
                      [[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3], [1, 0, 2], [0, 0, 1], [0, 1, 4], [0, 1, 5]])


@pytest.mark.parametrize("options, triangles, vertices", [
    ({}, [0, 1, 2, 3, 6], [0, 1, 2, 3, 4]),
    ({"drop_non_finite": False}, [0, 1, 2, 3, 6, 7], [0, 1, 2, 3, 4, 5]),
    ({"drop_degenerate": False}, [0, 1, 2, 3, 5, 6], [0, 1, 2, 3, 4]),
    ({"drop_zero_area": True}, [0, 1, 2, 3], [0, 1, 2, 3]),
    ({"drop_duplicates": False}, [0, 1, 2, 3, 4, 6], [0, 1, 2, 3, 4]),
    ({"drop_unused_vertices": False}, [0, 1, 2, 3, 6], [0, 1, 2, 3, 4, 5, 6])])
def test_repair_does_the_steps_that_are_asked_for(options, triangles, vertices):
    """Of a tetrahedron and four triangles: its first one again, one of a vertex twice, one of three vertices on a line, one with NaN."""
    repair = FLAWED.repair(**options)
    assert repair.triangle.tolist() == triangles and repair.vertex.tolist() == vertices


@pytest.mark.parametrize("options, mixed, inward", [
    ({}, [0], range(12)), ({"orient": False}, [], range(12)), ({"turn_outward": False}, [0], []), ({"orient": False, "turn_outward": False}, [], [])])
def test_repair_turns_what_is_asked_for(options, mixed, inward):
    cube = proxima.Mesh.sample("cube")
    for wrong, turned in (([0], mixed), (range(12), inward)):
        faces = cube.faces.copy()
        faces[wrong] = faces[wrong, ::-1]
        assert np.nonzero(proxima.Mesh(cube.vertices, faces).repair(**options).turned)[0].tolist() == list(turned)


def test_repair_turns_cavities_inward_or_not():
    outer, inner = proxima.Mesh.sample("cube"), proxima.Mesh.sample("octahedron")
    both = proxima.Mesh(np.concatenate([outer.vertices, 0.1 * inner.vertices]),
                        np.concatenate([outer.faces, inner.faces + len(outer.vertices)]))
    volume, cavity = volume_of(outer), 1e-3 * volume_of(inner)
    assert np.isclose(volume_of(both.repair().mesh), volume - cavity) and both.repair().cavities == 1
    assert np.isclose(volume_of(both.repair(keep_cavities=False).mesh), volume + cavity)
    assert len(both.repair(min_component_area=0.5).mesh.faces) == len(outer.faces)
    assert len(both.repair(min_component_triangles=9).mesh.faces) == len(outer.faces)


def test_repair_welds_within_a_distance(mesh):
    broken = soup(mesh)
    moved = broken.vertices + np.random.default_rng(2).uniform(-1e-6, 1e-6, broken.vertices.shape)
    moved = proxima.Mesh(moved, broken.faces)
    assert len(moved.repair().mesh.vertices) == len(moved.vertices)
    repair = moved.repair(weld_distance=1e-5)
    assert len(repair.mesh.vertices) == len(mesh.vertices) and repair.mesh.report().closed
    assert len(moved.repair(weld_distance=1e-5, weld=False, drop_unused_vertices=False).mesh.vertices) == len(moved.vertices)


def test_weld_and_part(mesh):
    broken = soup(mesh)
    welded = broken.weld()
    assert len(welded.vertices) == len(mesh.vertices)
    assert np.array_equal(welded.vertices[welded.faces], mesh.vertices[mesh.faces])
    ids = np.array([7, 3, 3], "u1")
    part = mesh.part(ids)
    assert np.array_equal(part.vertices[part.faces], mesh.vertices[mesh.faces[ids]])
    assert len(part.vertices) == len(np.unique(mesh.faces[ids]))
    assert len(mesh.part([]).faces) == 0


@pytest.mark.parametrize("ask, says", [
    (lambda m: m.part([0, -1]), r"triangles: row 1 must be 0 or more and below 12, is -1"),
    (lambda m: m.part([12]), "triangles: row 0 must be 0 or more and below 12, is 12"),
    (lambda m: m.part([0.5]), r"triangles: must be integers of shape \(n,\)"),
    (lambda m: m.part([[0]]), r"triangles: must be integers of shape \(n,\)"),
    (lambda m: m.repair(weld_distance=-1), "weld"),
    (lambda m: m.repair(min_component_area=2), "component"),
])
def test_refuses(ask, says):
    with pytest.raises(proxima.InvalidInput, match=says):
        ask(proxima.Mesh.sample("cube"))


def test_progress_stops_them():
    mesh = proxima.Mesh.sample("torus:500x300")
    for work in (mesh.report, mesh.repair):
        with pytest.raises(proxima.Cancelled):
            work(progress=lambda stage, part: False)
