"""What queries return: named tuples of arrays, one row for each query.

Where a query has a list of answers, those of query i are rows first[i] to first[i + 1] - 1 of the other columns.
"""
from collections import namedtuple

FEATURE_KINDS = ("vertex", "edge", "face")  # of Closest.feature_kind
SIGN_METHODS = ("on_surface", "pseudonormal", "winding_number")  # of Index.signed_distance(method=True)
INSIDE_METHODS = ("crossings", "parity", "winding_number")  # of Containments.method
CONTAINMENTS = ("none", "a_in_b", "b_in_a")  # of Containments.containment
PENETRATION_METHODS = ("apart", "convex", "bounds")  # of PenetrationDepth.method
CONTACT_EVIDENCE = ("intersection", "rounding", "steps")  # of FirstContact.evidence
HOLDS = ("free", "sliding", "sticking")  # of Touch.hold
TOUCH_FAULTS = ("none", "not_finite", "jumped")  # of Touch.fault
CELL_KINDS = ("outer", "inner", "boundary", "unclassified")  # of Leaves.kind


def _represent(self):
    columns = ", ".join(f"{name} {column.dtype}{list(column.shape)}" if hasattr(column, "dtype") else f"{name} {column}"
                        for name, column in zip(self._fields, self))
    return f"<proxima.{type(self).__name__}: {columns}>"


def _result(name, doc, _defaults=(), **columns):
    kind = namedtuple(name, columns, defaults=_defaults, module="proxima")
    kind.__doc__ = doc
    for column, text in columns.items():
        getattr(kind, column).__doc__ = text
    return type(name, (kind,), {"__slots__": (), "__doc__": doc, "__repr__": _represent, "__module__": "proxima"})


_FIRST = "(n + 1,) int64: rows of query i begin at first[i] and end before first[i + 1]"

Closest = _result(
    "Closest", "The closest points of a mesh to n points. Columns that were not asked for are None.",
    distance="(n,) float64, in the mesh's unit",
    point="(n, 3) float64: the closest point",
    triangle="(n,) int32: the lowest triangle that has the feature",
    feature_kind="(n,) uint8: 0 vertex, 1 edge, 2 face, the lowest-dimensional feature that holds the point",
    feature="(n,) int32: the id of the vertex, edge or triangle; edges by first appearance in the faces",
    barycentric="(n, 3) float64: of the point in the triangle, in [0, 1], sum 1")

Hits = _result(
    "Hits", "The first hits of n rays: point = origin + t direction = (1 - u - v) a + u b + v c.",
    t="(n,) float64, in units of the direction; inf for a miss",
    triangle="(n,) int32, -1 for a miss",
    u="(n,) float64, NaN for a miss",
    v="(n,) float64, NaN for a miss")
Hits.hit = property(lambda self: self.triangle >= 0, doc="(n,) bool: whether the ray hits")

HitLists = _result(
    "HitLists", "All hits of n rays, those of each by t, then triangle.",
    first=_FIRST, t="(m,) float64", triangle="(m,) int32", u="(m,) float64", v="(m,) float64")

Pairs = _result(
    "Pairs", "Triangles of two meshes that meet, by a, then b.",
    a="(m,) int32: triangles of the index", b="(m,) int32: triangles of the other")
Pairs.intersecting = property(lambda self: len(self.a) > 0, doc="bool: whether the meshes meet")

PairLists = _result(
    "PairLists", "Triangles of two meshes that meet, for n poses.",
    first=_FIRST, a="(m,) int32: triangles of the index", b="(m,) int32: triangles of the other")
PairLists.intersecting = property(lambda self: self.first[1:] > self.first[:-1],
                                  doc="(n,) bool: for which poses the meshes meet")

SelfIntersections = _result(
    "SelfIntersections", "Triangles of one mesh that meet in more than what they share, by a, then b.",
    a="(m,) int32", b="(m,) int32: larger than a",
    complete="bool: False where there are more than max_pairs")

Containments = _result(
    "Containments", "Which mesh lies inside the other, for n poses; single values where one pose was given.",
    containment="(n,) uint8: 0 neither, 1 the index's mesh in the other, 2 the other in it",
    method="(n,) uint8: how the inside was told: 0 crossings, exact; 1 parity, exact; 2 winding_number, of open meshes")

Contour = _result(
    "Contour", "The n lines along which two surfaces meet.",
    first="(n + 1,) int64: the points of line i are rows first[i] to first[i + 1] - 1",
    closed="(n,) bool: the line goes on from its last point to its first",
    point="(m, 3) float64: points of both surfaces",
    kind_a="(m,) uint8: 0 vertex, 1 edge, 2 face of the index's mesh that holds the point",
    ids_a="(m, 2) int32: the vertex twice, the edge's vertices, or the triangle twice",
    kind_b="(m,) uint8: of the other mesh", ids_b="(m, 2) int32: of the other mesh",
    length="float: of all lines, in the mesh's unit")

Distances = _result(
    "Distances", "Distances of two surfaces, for n poses; single values where one pose was given.",
    distance="(n,) float64: 0 where they touch, inf where nothing was found",
    point_a="(n, 3) float64: the closest point of the index's mesh",
    point_b="(n, 3) float64: that of the other, moved",
    triangle_a="(n,) int32, -1 where nothing was found",
    triangle_b="(n,) int32, -1 where nothing was found")

SceneClosest = _result(
    "SceneClosest", "The closest points of a scene's instances to n points.",
    instance="(n,) int32: -1 where none is within the radius",
    distance="(n,) float64: inf where none is within the radius",
    point="(n, 3) float64: the closest point, in the scene",
    triangle="(n,) int32: of the instance's index, the lowest that has the feature",
    feature_kind="(n,) uint8: 0 vertex, 1 edge, 2 face, as Closest has it",
    feature="(n,) int32: the id of the vertex, edge or triangle",
    barycentric="(n, 3) float64: of the point in the triangle")

SceneHits = _result(
    "SceneHits", "The first hits of n rays and a scene: point = origin + t direction.",
    instance="(n,) int32, -1 for a miss",
    t="(n,) float64, in units of the direction; inf for a miss",
    triangle="(n,) int32: of the instance's index, -1 for a miss",
    u="(n,) float64, NaN for a miss", v="(n,) float64, NaN for a miss")
SceneHits.hit = property(lambda self: self.triangle >= 0, doc="(n,) bool: whether the ray hits")

SceneHitLists = _result(
    "SceneHitLists", "All hits of n rays and a scene, those of each by t, then instance, then triangle.",
    first=_FIRST, instance="(m,) int32", t="(m,) float64", triangle="(m,) int32", u="(m,) float64", v="(m,) float64")

InstanceTriangles = _result(
    "InstanceTriangles", "Triangles of instances, by instance, then triangle.",
    instance="(m,) int32", triangle="(m,) int32: of the instance's index")

InstancePairs = _result(
    "InstancePairs", "Pairs of instances, by a, then b.", a="(m,) int32", b="(m,) int32: larger than a")

NearInstances = _result(
    "NearInstances", "Pairs of instances that are near each other, by a, then b.",
    a="(m,) int32", b="(m,) int32: larger than a",
    distance="(m,) float64: of the surfaces, 0 where they touch",
    point_a="(m, 3) float64: the closest point of a, in the scene", point_b="(m, 3) float64: that of b",
    triangle_a="(m,) int32: of a's index", triangle_b="(m,) int32: of b's index")

Motion = _result(
    "Motion", "A rigid motion of a mesh from time 0 to time 1, which turns about a center that moves along a straight line.",
    (None, (0.0, 0.0, 0.0), (0.0, 0.0, 0.0), (0.0, 0.0, 0.0)),
    start="(3, 4) or (4, 4) floats: the pose at time 0; None: as it is",
    center="(3,) floats: in the mesh's own coordinates",
    displacement="(3,) floats: of the center, over the whole motion",
    turn="(3,) floats: the axis times the angle in radians, in the other mesh's axes; more than one revolution is one")

FirstContact = _result(
    "FirstContact", "When a moving mesh first touches another one.",
    free_until="float: touching nothing is proven from 0 up to this time, roundings included",
    touches_at="float: a time at which they meet; the first contact is between the two; inf where the evidence is none",
    evidence="int: 0 intersection, exact; 1 rounding, nearer than roundings and neither shown to meet nor to miss; 2 steps, "
             "max_steps were taken",
    free_pose="(3, 4) float64: of the moving mesh at free_until",
    distance="float: of the surfaces then",
    point="(3,) float64: their closest points then", other_point="(3,) float64",
    triangle="int", other_triangle="int: of the moving mesh",
    normal="(3,) float64: towards the moving mesh, of length 1; 0 where they meet at the start",
    steps="int: distances that were computed")

PenetrationDepth = _result(
    "PenetrationDepth", "The length of the shortest translation that separates two solids, as an interval that holds it.",
    lower="float: no shorter translation of the other solid separates them",
    upper="float: moved by `translation`, no longer than this, it is free",
    direction="(3,) float64: of the translation, of length 1; 0 where they are apart",
    translation="(3,) float64: to add to that of the other's pose",
    deepest="(3,) float64: a point of both; 0 where they are apart",
    method="int: 0 apart, 1 convex, by the Minkowski sum; 2 bounds, of solids that are not convex")

ContactRegions = _result(
    "ContactRegions", "The n connected parts of the contour of two solids, each with at most four points for physics.",
    position="(n, 3) float64: mean of the region's contour",
    normal="(n, 3) float64: towards the other solid, of length 1",
    depth="(n,) float64: the largest found along the normal",
    length="(n,) float64: of the contour", area="(n,) float64: that its loops span, along the normal",
    first="(n + 1,) int64: the points of region i are rows first[i] to first[i + 1] - 1, the deepest first",
    on_a="(m, 3) float64: the end along the normal, most often on this solid's surface",
    on_b="(m, 3) float64: the end against it, most often on the other's",
    point_depth="(m,) float64: how far apart the two are",
    first_line="(n + 1,) int64: the lines of region i are rows first_line[i] to first_line[i + 1] - 1 of `line`",
    line="(k,) int64: numbers of the contour's lines, region by region",
    contour="Contour")

Finding = _result(
    "Finding", "One kind of flaw of a mesh.",
    kind='str: "boundary_edges", "duplicate_vertices", ...',
    severity='str: "note" no query is worse off, "warning" some answers need care, "error" builders refuse the mesh',
    element='str: what is counted: "mesh", "vertex", "edge", "triangle", or "component", given by its lowest triangle',
    number="int: how many were found",
    ids="(k,) int32: the lowest ones, ascending, at most max_ids; edges by first appearance in the faces",
    positions="(k, 3) float64: vertex, middle of the edge or centroid of each of these",
    meaning="str: what it is, and what it means for the queries")

Report = _result(
    "Report", "What is wrong with a mesh, and what to expect of queries. Print it for the text.",
    vertices="int", triangles="int",
    edges="int: distinct pairs of vertices that a triangle joins",
    components="int: sets of triangles connected across edges",
    boundary_loops="int: sets of boundary edges connected by vertices",
    bounds="(2, 3) float64: of the finite positions that triangles use",
    area="float, in the mesh's unit squared",
    min_edge_length="float, in the mesh's unit", max_edge_length="float, in the mesh's unit",
    closed="bool: every edge has an even number of triangles, so that the surface encloses something",
    consistently_oriented="bool: at every such edge half of the triangles run each way",
    closed_if_welded="bool, of open meshes with duplicate vertices: whether welding closes them; None of others",
    orientation='str: "outward", "inward", "mixed", or "undefined" where it is open or not consistent',
    volume="float, negative where it faces inward; None of open, inconsistent or infinite meshes",
    euler_characteristic="int",
    genus="int: handles of all components; None where not closed, manifold and consistent",
    findings="tuple of Finding: only what was found",
    outlook='dict: query to ("works", "with_care" or "refused", reason)')


def _describe(report):
    lines = [f"{report.vertices} vertices, {report.triangles} triangles, {report.components} components: "
             f"{'closed' if report.closed else 'open'}, orientation {report.orientation}"]
    lines += [f"{finding.severity}: {finding.number} {finding.kind}: {finding.meaning}" for finding in report.findings]
    lines += [f"{query} {outlook}: {reason}" for query, (outlook, reason) in report.outlook.items()]
    return "\n".join(lines)


Report.__str__ = _describe

Repair = _result(
    "Repair", "A repaired mesh, and where its parts come from. Triangles and vertices keep their order.",
    mesh="Mesh",
    triangle="(F,) int32: the id that each triangle had, ascending",
    vertex="(V,) int32: the lowest id of those that became each vertex and have its position, ascending",
    turned="(F,) bool: whether the triangle's last corners were swapped",
    steps="dict: step to how many elements it changed, in the order in which they were done; without those switched off",
    pieces="int: sets of triangles connected across edges of exactly two",
    closed_pieces="int",
    cavities="int: closed pieces inside others",
    unorientable_pieces="int",
    unorientable_edges="int: their edges whose triangles do not match")

Neighbours = _result(
    "Neighbours", "The triangles near n points, those of each ascending.",
    first=_FIRST, triangle="(m,) int32")

Nearest = _result(
    "Nearest", "The k triangles nearest to n points, nearest first.",
    distance="(n, k) float64: inf where there is none", triangle="(n, k) int32: -1 where there is none")

Field = _result(
    "Field", "Signed distances at nx, ny, nz points: point i, j, k is origin + spacing * (i, j, k). In memory x runs fastest.",
    distance="(nx, ny, nz) float64: negative inside; beyond the band its width with the sign",
    gradient="(nx, ny, nz, 3) float64: the direction in which the distance grows, zero beyond the band; None where not asked for",
    method="(nx, ny, nz) uint8: how each sign was found, see SIGN_METHODS; None where not asked for",
    origin="(3,) float64", spacing="float: between points, along all axes")

Deviation = _result(
    "Deviation", "How far one surface is from another. Intervals hold the true numbers, rounding included.",
    _defaults=(None,) * 10,
    greatest="(2,) float64: lower and upper bound of the greatest distance of its points from the other",
    point="(3,) float64: the point that is that far", closest="(3,) float64: the other's closest point",
    triangle="int: of the point", other_triangle="int: of the closest point",
    mean="(2,) float64: bounds of the mean distance, by area; without the mean it is None, as root_mean_square, mean_complete, area, "
    "area_error and the histogram are",
    root_mean_square="(2,) float64: of the root of the mean of squared distances",
    complete="bool: whether the bounds of the greatest distance are within the tolerance",
    mean_complete="bool: whether those of the mean and of the root mean square are",
    area="float: of this surface, in the square of the mesh's unit", area_error="float: by which the area may be off",
    histogram="(bins,) float64: shares of the area by distance, in bins of one width from 0; what is beyond the end is in the "
    "last. An estimate, the better the smaller mean_tolerance. None without bins, and where all distances are 0 and no end was given",
    histogram_end="float: where the last bin ends; None without a histogram",
    places="FarPlaces: points that are as far as the greatest, within the tolerance; None, as all_places, without max_places",
    all_places="bool: whether every point that is as far is within three times the spacing of one of the places")

FarPlaces = _result(
    "FarPlaces", "The k points of a surface that are farthest from another one, the farthest first.",
    distance="(k,) float64, in the mesh's unit, up to rounding", point="(k, 3) float64",
    closest="(k, 3) float64: the other surface's closest point", triangle="(k,) int32: of the point",
    other_triangle="(k,) int32: of the closest point")

TwoSidedDeviation = _result(
    "TwoSidedDeviation", "How far two surfaces are from each other, both ways. Intervals hold the true numbers, rounding included.",
    _defaults=(None,) * 4,
    greatest="(2,) float64: bounds of the Hausdorff distance, in the mesh's unit",
    mean="(2,) float64: of the mean over both surfaces, by area: the larger one counts more. None, as all that follows, without means",
    root_mean_square="(2,) float64: of the root mean square over both, by area",
    larger_mean="(2,) float64: of the larger mean of both ways: each surface counts as much as the other",
    larger_root_mean_square="(2,) float64: of the larger root mean square of both ways")

Patches = _result(
    "Patches", "Triangles round n features, those of each ring by ring, ascending within a ring.",
    first=_FIRST, triangle="(m,) int32", ring="(m,) int32: 0 for the triangles that have the feature")

Leaves = _result(
    "Leaves", "The n leaves of an octree in Morton order.",
    key="(n,) uint64: 1, then three bits (z, y, x) for each level",
    depth="(n,) uint8",
    kind="(n,) uint8: 0 outer, 1 inner, 2 boundary, 3 unclassified",
    lower="(n, 3) float64: lowest corner",
    upper="(n, 3) float64: highest corner",
    first=_FIRST,
    triangle="(m,) int32: the triangles that touch each leaf, ascending")

CellsOnRays = _result(
    "CellsOnRays", "The leaves of an octree along n rays, those of each in order.",
    first=_FIRST,
    leaf="(m,) int32: rows of Octree.leaves()",
    enter="(m,) float64: t, in units of the direction",
    exit="(m,) float64: t; the next leaf's enter",
    chord="(m,) float64: the length of the ray in the leaf, in the mesh's unit",
    penetration="(m,) float64: 1 through the middle of the leaf, 0 along its border")

Facets = _result(
    "Facets", "The n facets of a polyhedron.",
    first=_FIRST, vertex="(m,) int32: loops of vertices, counter-clockwise seen from outside")

SumDistances = _result(
    "SumDistances", "Distances of n points from the surface of a Minkowski sum.",
    distance="(n,) float64, negative inside",
    nearest="(n, 3) float64: the nearest point of the surface",
    direction="(n, 3) float64, of length 1: outward",
    facet="(n,) int32: that holds the nearest point, -1 for a sum that is a point or a segment")

Material = _result(
    "Material", "What an object feels like; a device's limits bound it.", (500.0, 1.0, 0.4, 0.3),
    stiffness="float: N/m", damping="float: N s/m", static_friction="float", dynamic_friction="float: at most static_friction")

Texture = _result(
    "Texture", "What a surface feels like beside its Material. Nothing by default; a device's limits bound it.",
    ("none", 0.0, 0.004, (1.0, 0.0, 0.0), 0.0, 0.0, 0.0, 0.0, 150.0, 80.0),
    bump='str: "none", "grating" along direction, "dimples" or "noise": grooves below the triangles',
    amplitude="float: m of the device, half the depth of a groove", wavelength="float: m of the device",
    direction="(3,) floats, of a grating, in the object's frame",
    viscosity="float: N s/m, against motion along the surface",
    stick_slip_stiffness="float: N/m, of a spring along the surface that lets go", stick_slip_force="float: N, at which it lets go",
    tap_gain="float: N s/m, of a vibration after an impact", tap_frequency="float: Hz", tap_decay="float: 1/s")

DeviceLimits = _result(
    "DeviceLimits", "What a haptic device can do.", (3.3, 400.0, 4.0, 0.075),
    max_force="float: N", max_stiffness="float: N/m", max_damping="float: N s/m",
    workspace_radius="float: m, of a ball that the tip can reach")

Contacts = _result(
    "Contacts", "Points that held the proxy back, at most three a tick; in the model's units.",
    first="(n + 1,) int64: those of tick i are rows first[i] to first[i + 1] - 1",
    object="(m,) int32: of a scene; 0 where there is none",
    triangle="(m,) int32: of the object, the lowest of those touched there",
    position="(m, 3) float64", normal="(m, 3) float64, of length 1: from the surface to the proxy",
    pressure="(m,) float64: its part of the spring's stretch")

Touch = _result(
    "Touch", "What was felt in n ticks; rows of one tick where one position was given.",
    force="(n, 3) float64: N, what the device gets",
    proxy="(n, 3) float64: where the finger would be if it could not enter, in the model's units",
    anchor="(n, 3) float64: what the spring pulls the device to; the device where nothing is touched",
    normal="(n, 3) float64: of all contacts, of length 1; 0 where nothing is touched",
    depth="(n,) float64: of the device below the surface, in the model's units",
    hold="(n,) uint8: 0 free, 1 sliding, 2 sticking",
    placed="(n,) bool: False where the device began inside: nothing is touched until it is out",
    fault="(n,) uint8: 0 none, 1 a position that is not finite, 2 a jump that no hand makes",
    squeezed="(n,) bool: True where moving objects left the finger no free place: the force then rises as at a start",
    contacts="Contacts")

Replay = _result(
    "Replay", "A recorded session, felt again.",
    touch="Touch: what was felt now", seconds="(n,) float64: since the first tick",
    position="(n, 3) float64: of the device, m", velocity="(n, 3) float64: m/s",
    force="(n, 3) float64: N, as recorded",
    differences="int: ticks whose force or proxy has other bits than recorded",
    tick_seconds="float", units_per_metre="float", center="(3,) float64: of the model, at the middle of the workspace")
