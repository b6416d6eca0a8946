from typing import Any, NamedTuple, Optional

from numpy import bool_, float64, int32, int64, uint8, uint64
from numpy.typing import NDArray

from ._core import Mesh

FEATURE_KINDS: tuple[str, str, str]
SIGN_METHODS: tuple[str, str, str]
INSIDE_METHODS: tuple[str, str, str]
CONTAINMENTS: tuple[str, str, str]
PENETRATION_METHODS: tuple[str, str, str]
CONTACT_EVIDENCE: tuple[str, str, str]
HOLDS: tuple[str, str, str]
TOUCH_FAULTS: tuple[str, str, str]
CELL_KINDS: tuple[str, str, str, str]

class Closest(NamedTuple):
    distance: NDArray[float64]
    point: NDArray[float64]
    triangle: NDArray[int32]
    feature_kind: NDArray[uint8]
    feature: NDArray[int32]
    barycentric: NDArray[float64]

class Hits(NamedTuple):
    t: NDArray[float64]
    triangle: NDArray[int32]
    u: NDArray[float64]
    v: NDArray[float64]
    @property
    def hit(self) -> NDArray[bool_]: ...

class HitLists(NamedTuple):
    first: NDArray[int64]
    t: NDArray[float64]
    triangle: NDArray[int32]
    u: NDArray[float64]
    v: NDArray[float64]

class Pairs(NamedTuple):
    a: NDArray[int32]
    b: NDArray[int32]
    @property
    def intersecting(self) -> bool: ...

class PairLists(NamedTuple):
    first: NDArray[int64]
    a: NDArray[int32]
    b: NDArray[int32]
    @property
    def intersecting(self) -> NDArray[bool_]: ...

class SelfIntersections(NamedTuple):
    a: NDArray[int32]
    b: NDArray[int32]
    complete: bool

# One pose gives single values, several give arrays.
class Containments(NamedTuple):
    containment: Any
    method: Any

class Contour(NamedTuple):
    first: NDArray[int64]
    closed: NDArray[bool_]
    point: NDArray[float64]
    kind_a: NDArray[uint8]
    ids_a: NDArray[int32]
    kind_b: NDArray[uint8]
    ids_b: NDArray[int32]
    length: float

# One pose gives single values, several give arrays.
class Distances(NamedTuple):
    distance: Any
    point_a: NDArray[float64]
    point_b: NDArray[float64]
    triangle_a: Any
    triangle_b: Any

class SceneClosest(NamedTuple):
    instance: NDArray[int32]
    distance: NDArray[float64]
    point: NDArray[float64]
    triangle: NDArray[int32]
    feature_kind: NDArray[uint8]
    feature: NDArray[int32]
    barycentric: NDArray[float64]

class SceneHits(NamedTuple):
    instance: NDArray[int32]
    t: NDArray[float64]
    triangle: NDArray[int32]
    u: NDArray[float64]
    v: NDArray[float64]
    @property
    def hit(self) -> NDArray[bool_]: ...

class SceneHitLists(NamedTuple):
    first: NDArray[int64]
    instance: NDArray[int32]
    t: NDArray[float64]
    triangle: NDArray[int32]
    u: NDArray[float64]
    v: NDArray[float64]

class InstanceTriangles(NamedTuple):
    instance: NDArray[int32]
    triangle: NDArray[int32]

class InstancePairs(NamedTuple):
    a: NDArray[int32]
    b: NDArray[int32]

class NearInstances(NamedTuple):
    a: NDArray[int32]
    b: NDArray[int32]
    distance: NDArray[float64]
    point_a: NDArray[float64]
    point_b: NDArray[float64]
    triangle_a: NDArray[int32]
    triangle_b: NDArray[int32]

# Anything that NumPy makes an array of.
class Motion(NamedTuple):
    start: Any = None
    center: Any = (0.0, 0.0, 0.0)
    displacement: Any = (0.0, 0.0, 0.0)
    turn: Any = (0.0, 0.0, 0.0)

class FirstContact(NamedTuple):
    free_until: float
    touches_at: float
    evidence: int
    free_pose: NDArray[float64]
    distance: float
    point: NDArray[float64]
    other_point: NDArray[float64]
    triangle: int
    other_triangle: int
    normal: NDArray[float64]
    steps: int

class PenetrationDepth(NamedTuple):
    lower: float
    upper: float
    direction: NDArray[float64]
    translation: NDArray[float64]
    deepest: NDArray[float64]
    method: int

class ContactRegions(NamedTuple):
    position: NDArray[float64]
    normal: NDArray[float64]
    depth: NDArray[float64]
    length: NDArray[float64]
    area: NDArray[float64]
    first: NDArray[int64]
    on_a: NDArray[float64]
    on_b: NDArray[float64]
    point_depth: NDArray[float64]
    first_line: NDArray[int64]
    line: NDArray[int64]
    contour: Contour

class Finding(NamedTuple):
    kind: str
    severity: str
    element: str
    number: int
    ids: NDArray[int32]
    positions: NDArray[float64]
    meaning: str

class Report(NamedTuple):
    vertices: int
    triangles: int
    edges: int
    components: int
    boundary_loops: int
    bounds: NDArray[float64]
    area: float
    min_edge_length: float
    max_edge_length: float
    closed: bool
    consistently_oriented: bool
    closed_if_welded: Optional[bool]
    orientation: str
    volume: Optional[float]
    euler_characteristic: int
    genus: Optional[int]
    findings: tuple[Finding, ...]
    outlook: dict[str, tuple[str, str]]

class Repair(NamedTuple):
    mesh: Mesh
    triangle: NDArray[int32]
    vertex: NDArray[int32]
    turned: NDArray[bool_]
    steps: dict[str, int]
    pieces: int
    closed_pieces: int
    cavities: int
    unorientable_pieces: int
    unorientable_edges: int

class Neighbours(NamedTuple):
    first: NDArray[int64]
    triangle: NDArray[int32]

class Nearest(NamedTuple):
    distance: NDArray[float64]
    triangle: NDArray[int32]

class Field(NamedTuple):
    distance: NDArray[float64]
    gradient: Optional[NDArray[float64]]
    method: Optional[NDArray[uint8]]
    origin: NDArray[float64]
    spacing: float

class Deviation(NamedTuple):
    greatest: NDArray[float64]
    point: NDArray[float64]
    closest: NDArray[float64]
    triangle: int
    other_triangle: int
    mean: Optional[NDArray[float64]] = None
    root_mean_square: Optional[NDArray[float64]] = None
    complete: Optional[bool] = None
    mean_complete: Optional[bool] = None
    area: Optional[float] = None
    area_error: Optional[float] = None
    histogram: Optional[NDArray[float64]] = None
    histogram_end: Optional[float] = None
    places: Optional[FarPlaces] = None
    all_places: Optional[bool] = None

class FarPlaces(NamedTuple):
    distance: NDArray[float64]
    point: NDArray[float64]
    closest: NDArray[float64]
    triangle: NDArray[int32]
    other_triangle: NDArray[int32]

class TwoSidedDeviation(NamedTuple):
    greatest: NDArray[float64]
    mean: Optional[NDArray[float64]] = None
    root_mean_square: Optional[NDArray[float64]] = None
    larger_mean: Optional[NDArray[float64]] = None
    larger_root_mean_square: Optional[NDArray[float64]] = None

class Patches(NamedTuple):
    first: NDArray[int64]
    triangle: NDArray[int32]
    ring: NDArray[int32]

class Leaves(NamedTuple):
    key: NDArray[uint64]
    depth: NDArray[uint8]
    kind: NDArray[uint8]
    lower: NDArray[float64]
    upper: NDArray[float64]
    first: NDArray[int64]
    triangle: NDArray[int32]

class CellsOnRays(NamedTuple):
    first: NDArray[int64]
    leaf: NDArray[int32]
    enter: NDArray[float64]
    exit: NDArray[float64]
    chord: NDArray[float64]
    penetration: NDArray[float64]

class Facets(NamedTuple):
    first: NDArray[int64]
    vertex: NDArray[int32]

class SumDistances(NamedTuple):
    distance: NDArray[float64]
    nearest: NDArray[float64]
    direction: NDArray[float64]
    facet: NDArray[int32]

class Material(NamedTuple):
    stiffness: float = 500.0
    damping: float = 1.0
    static_friction: float = 0.4
    dynamic_friction: float = 0.3

class Texture(NamedTuple):
    bump: str = "none"
    amplitude: float = 0.0
    wavelength: float = 0.004
    direction: tuple[float, float, float] = (1.0, 0.0, 0.0)
    viscosity: float = 0.0
    stick_slip_stiffness: float = 0.0
    stick_slip_force: float = 0.0
    tap_gain: float = 0.0
    tap_frequency: float = 150.0
    tap_decay: float = 80.0

class DeviceLimits(NamedTuple):
    max_force: float = 3.3
    max_stiffness: float = 400.0
    max_damping: float = 4.0
    workspace_radius: float = 0.075

class Contacts(NamedTuple):
    first: NDArray[int64]
    object: NDArray[int32]
    triangle: NDArray[int32]
    position: NDArray[float64]
    normal: NDArray[float64]
    pressure: NDArray[float64]

# One position gives single values, several give arrays.
class Touch(NamedTuple):
    force: NDArray[float64]
    proxy: NDArray[float64]
    anchor: NDArray[float64]
    normal: NDArray[float64]
    depth: Any
    hold: Any
    placed: Any
    fault: Any
    squeezed: Any
    contacts: Contacts

class Replay(NamedTuple):
    touch: Touch
    seconds: NDArray[float64]
    position: NDArray[float64]
    velocity: NDArray[float64]
    force: NDArray[float64]
    differences: int
    tick_seconds: float
    units_per_metre: float
    center: NDArray[float64]
