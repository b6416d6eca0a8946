"""Spatial questions about triangle meshes, answered in doubles.

    import numpy as np, proxima

    mesh = proxima.Mesh.read("bunny.obj")            # or proxima.Mesh(vertices, faces)
    index = proxima.Index(mesh, signs=True)
    points = np.random.default_rng(1).uniform(*mesh.bounds, (1000, 3))
    distances = index.signed_distance(points)        # negative inside
    closest = index.closest(points)                  # .distance .point .triangle .feature ...
    hits = index.cast(points, np.array([[0, 0, 1.0]]).repeat(1000, 0))

Ids of triangles, vertices and edges are int32, -1 for none. Lengths are in the mesh's unit. Arrays go in as float32 or
float64 in any memory order. Answers are the same for every number of threads and every instruction set.
"""
from ._core import (Cancelled, ClosestOne, Error, FileMissing, FileNotWritable, Index, InvalidInput, LimitExceeded, Mesh,
                    MinkowskiSum, Octree, Polyhedron, Scene, Solid, Topology, TouchRenderer, TouchScene, __version__, both_ways,
                    device_limits, minkowski_sum, motion_between, orthographic, perspective, pose_at, separation)
from ._results import (CELL_KINDS, CONTACT_EVIDENCE, CONTAINMENTS, FEATURE_KINDS, HOLDS, INSIDE_METHODS, PENETRATION_METHODS, SIGN_METHODS,
                       TOUCH_FAULTS, CellsOnRays, Closest, ContactRegions, Contacts, Containments, Contour, Deviation, DeviceLimits, Distances,
                       Facets, FarPlaces, Field, Finding, FirstContact, HitLists, Hits, InstancePairs, InstanceTriangles, Leaves, Material, Motion,
                       NearInstances, Nearest, Neighbours, PairLists, Pairs, Patches, PenetrationDepth, Repair, Replay, Report, SceneClosest,
                       SceneHitLists, SceneHits, SelfIntersections, SumDistances, Texture, Touch, TwoSidedDeviation)

__all__ = [
    "Mesh", "Index", "Topology", "Octree", "Polyhedron", "MinkowskiSum", "minkowski_sum", "separation", "perspective", "orthographic",
    "Scene", "Solid", "Motion", "motion_between", "pose_at",
    "TouchScene", "TouchRenderer", "Material", "Texture", "DeviceLimits", "device_limits",
    "Closest", "ClosestOne", "Hits", "HitLists", "Pairs", "PairLists", "SelfIntersections", "Containments", "Contour", "Distances",
    "SceneClosest", "SceneHits", "SceneHitLists", "InstanceTriangles", "InstancePairs", "NearInstances", "FirstContact", "PenetrationDepth",
    "ContactRegions", "PENETRATION_METHODS", "CONTACT_EVIDENCE",
    "Neighbours", "Nearest", "Field", "Deviation", "FarPlaces", "TwoSidedDeviation", "both_ways", "Patches", "Leaves", "CellsOnRays", "Facets", "SumDistances", "Report", "Finding", "Repair", "Touch", "Contacts",
    "Replay", "FEATURE_KINDS", "SIGN_METHODS", "CELL_KINDS", "INSIDE_METHODS", "CONTAINMENTS", "HOLDS", "TOUCH_FAULTS",
    "Error", "InvalidInput", "FileMissing", "FileNotWritable", "LimitExceeded", "Cancelled", "__version__",
]
for _name in __all__:
    if isinstance(globals()[_name], type) or callable(globals()[_name]):
        globals()[_name].__module__ = "proxima"
del _name
