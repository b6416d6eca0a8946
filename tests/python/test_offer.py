"""What the public headers offer, and what Python does: every name of one side is offered by the other, or left out with a
reason. A name that is new in a header, or gone from it, fails here until Python has it or the list says why not."""
from pathlib import Path

import pytest

import cpp_names
import proxima

HEADERS = sorted((Path(__file__).resolve().parents[2] / "include/proxima").glob("*.h"))

# Headers that Python has nothing of.
NO_PART_OF_IT = {
    "export.h": "for compilers",
    "function_ref.h": "C++ callbacks",
    "grow_cells.h": "parts of an octree, for programs that spread it over processes",
    "proxima.h": "includes the others",
    "tool_renderer.h": "touch with a tool: not bound yet, `proxima touch --tool` does it",
    "thesis.h": "the thesis's own methods, to compare with: their answers are those of the index",
}
BATCHES = "the batch answers the same"
STRUCTURE = "how it is made inside"
NAMES = "Python has columns for it"
NOT_YET = "not bound yet"

# C++ name: Python name. Lists of names are separated by spaces.
OFFERED = {
    "cast_ray.h": {
        "closest_hits any_hits all_hits RayBatchOptions.faces": "Index.cast", "RayHit.t RayHit.triangle RayHit.u RayHit.v": "Hits",
        "RayHitLists.first RayHitLists.hits": "HitLists"},
    "cells_along_ray.h": {
        "cells_along_ray": "Octree.along_rays", "CellOnRay.cell": "CellsOnRays.leaf", "CellOnRay.enter": "CellsOnRays.enter",
        "CellOnRay.exit": "CellsOnRays.exit", "CellOnRay.chord": "CellsOnRays.chord",
        "CellOnRay.penetration": "CellsOnRays.penetration"},
    "closest_feature.h": {
        "closest_feature": "Index.closest_one", "closest_features": "Index.closest",
        "ClosestFeature.feature ClosestFeature.triangle ClosestFeature.point ClosestFeature.barycentric": "ClosestOne",
        "ClosestOutputs.distances": "Closest.distance", "ClosestOutputs.points": "Closest.point",
        "ClosestOutputs.triangles": "Closest.triangle", "ClosestOutputs.feature_kinds": "Closest.feature_kind",
        "ClosestOutputs.feature_ids": "Closest.feature", "ClosestOutputs.barycentrics": "Closest.barycentric"},
    "contacts.h": {
        "build_solid": "Solid", "Solid.index": "Solid.index", "Solid.is_convex": "Solid.is_convex", "Solid.hull_error": "Solid.hull_error",
        "solids_overlap": "Solid.overlaps",
        "penetration_depth PenetrationOptions.max_points PenetrationOptions.max_directions": "Solid.penetration_depth",
        "PenetrationDepth.lower": "PenetrationDepth.lower", "PenetrationDepth.upper": "PenetrationDepth.upper",
        "PenetrationDepth.direction": "PenetrationDepth.direction", "PenetrationDepth.translation": "PenetrationDepth.translation",
        "PenetrationDepth.deepest": "PenetrationDepth.deepest", "PenetrationDepth.method": "PenetrationDepth.method",
        "contact_regions": "Solid.contact_regions", "ContactRegion.position": "ContactRegions.position",
        "ContactRegion.normal": "ContactRegions.normal", "ContactRegion.depth": "ContactRegions.depth",
        "ContactRegion.length": "ContactRegions.length", "ContactRegion.area": "ContactRegions.area",
        "ContactRegions.regions ContactRegion.point_count": "ContactRegions.first", "RegionPoint.on_a": "ContactRegions.on_a",
        "RegionPoint.on_b": "ContactRegions.on_b", "RegionPoint.depth ContactRegion.points ContactRegion.contacts": "ContactRegions.point_depth",
        "ContactRegion.first_line ContactRegion.line_count": "ContactRegions.first_line", "ContactRegions.lines": "ContactRegions.line",
        "ContactRegions.contour": "ContactRegions.contour"},
    "convex_polyhedron.h": {
        "convex_hull": "Polyhedron", "mirrored": "Polyhedron.mirrored", "polyhedron_of_box": "Polyhedron.box",
        "polyhedron_of_mesh": "Polyhedron.of_mesh", "HalfSpace.normal HalfSpace.offset": "Polyhedron.half_spaces",
        "ConvexPolyhedron.dimension": "Polyhedron.dimension", "ConvexPolyhedron.half_space": "Polyhedron.half_spaces",
        "ConvexPolyhedron.points": "Polyhedron.vertices", "ConvexPolyhedron.vertex_count": "Polyhedron.vertices",
        "ConvexPolyhedron.facet_loop ConvexPolyhedron.facet_count": "Polyhedron.facets"},
    "cull.h": {"visible_triangles": "Index.visible", "visible_cells VisibleCell.cell": "Octree.visible"},
    "device.h": {
        "find_device": "device_limits", "DeviceLimits.max_force": "DeviceLimits.max_force",
        "DeviceLimits.max_stiffness": "DeviceLimits.max_stiffness", "DeviceLimits.max_damping": "DeviceLimits.max_damping",
        "DeviceLimits.workspace_radius": "DeviceLimits.workspace_radius",
        "DeviceState.pose DeviceState.velocity": "TouchRenderer.step"},
    "execution.h": {"Threads.count": "Index", "Progress.fraction Progress.stage Progress.cancel": "Cancelled"},
    "geometry.h": {"make_rigid_transform RigidTransform.rotation RigidTransform.translation": "Index.intersect",
                   "Ray.origin Ray.direction Ray.t_min Ray.t_max": "Index.cast"},
    "haptic_renderer.h": {
        "make_haptic_renderer fit_workspace RenderOptions.force RenderOptions.proxy_radius RenderOptions.static_friction "
        "RenderOptions.dynamic_friction RenderOptions.guard RenderOptions.shading RenderOptions.texture "
        "ForceOptions.stiffness ForceOptions.damping": "TouchRenderer",
        "HapticRenderer.tick": "TouchRenderer.step", "HapticRenderer.reset": "TouchRenderer.reset",
        "HapticRenderer.options": "TouchRenderer.options", "WorkspaceMap.units_per_metre": "TouchRenderer.units_per_metre",
        "WorkspaceMap.center HapticRenderer.map": "TouchRenderer.center", "RenderTick.force": "Touch.force",
        "RenderTick.proxy": "Touch.proxy", "RenderTick.anchor": "Touch.anchor", "RenderTick.normal": "Touch.normal",
        "RenderTick.depth": "Touch.depth", "RenderTick.hold": "Touch.hold", "RenderTick.is_placed": "Touch.placed",
        "RenderTick.fault": "Touch.fault", "RenderTick.squeezed": "Touch.squeezed", "RenderTick.contacts": "Touch.contacts", "RenderTick.contact_count": "Contacts.first",
        "ContactPoint.position": "Contacts.position", "ContactPoint.normal": "Contacts.normal",
        "ContactPoint.triangle": "Contacts.triangle", "ContactPoint.pressure": "Contacts.pressure"},
    "index_io.h": {"load_index": "Index.load", "save_index": "Index.save"},
    "intersect_meshes.h": {
        "meshes_intersect intersecting_pairs": "Index.intersect", "TrianglePair.a": "Pairs.a", "TrianglePair.b": "Pairs.b",
        "PairLists.first PairLists.pairs": "PairLists", "encloses": "Index.contains", "find_containment": "Index.containment",
        "ContainmentAnswer.containment": "Containments.containment", "ContainmentAnswer.method": "Containments.method",
        "intersection_contour": "Index.contour", "IntersectionContour.length": "Contour.length",
        "IntersectionContour.points ContourPoint.position": "Contour.point",
        "IntersectionContour.lines ContourLine.first ContourLine.count": "Contour.first", "ContourLine.closed": "Contour.closed",
        "ContourPoint.on_a SurfacePart.kind": "Contour.kind_a", "ContourPoint.on_b": "Contour.kind_b",
        "SurfacePart.ids": "Contour.ids_a",
        "find_self_intersections SelfIntersectionOptions.max_pairs": "Index.self_intersections",
        "SelfIntersections.pairs": "SelfIntersections.a", "SelfIntersections.complete": "SelfIntersections.complete"},
    "mesh_distance.h": {
        "mesh_distance MeshDistanceOptions.farthest": "Index.distance_to", "MeshDistance.distance": "Distances.distance",
        "MeshDistance.point_a": "Distances.point_a", "MeshDistance.point_b": "Distances.point_b",
        "MeshDistance.triangle_a": "Distances.triangle_a", "MeshDistance.triangle_b": "Distances.triangle_b"},
    "mesh_index.h": {
        "build_mesh_index": "Index", "mesh_of": "Index.mesh", "with_lists ListOptions.list_bytes": "Index.with_lists",
        "with_signs": "Index.with_signs", "with_slabs": "Index.with_distances", "MeshIndex.bytes": "Index.nbytes",
        "refit_index": "Index.refit", "check_same_mesh MeshIndex.mesh_fingerprint": "Index.fingerprint",
        "MeshIndex.edge_count": "Index.edge_count", "MeshIndex.has_lists": "Index.has_lists",
        "MeshIndex.has_signs": "Index.has_signs", "MeshIndex.has_slabs": "Index.has_distances",
        "MeshIndex.triangle_count": "Index.triangle_count", "MeshIndex.vertex_count": "Index.vertex_count"},
    "mesh_io.h": {"read_mesh ReadOptions.weld ReadOptions.primitives": "Mesh.read", "read_mesh_from_memory": "Mesh.from_bytes",
                  "write_mesh WriteOptions.ply WriteOptions.stl": "Mesh.write"},
    "mesh_repair.h": {
        "repair_mesh": "Mesh.repair", "weld_vertices": "Mesh.weld", "sub_mesh": "Mesh.part", "MeshRepair.mesh": "Repair.mesh",
        "MeshRepair.original_triangles": "Repair.triangle", "MeshRepair.original_vertices": "Repair.vertex",
        "MeshRepair.turned": "Repair.turned", "MeshRepair.pieces": "Repair.pieces",
        "MeshRepair.closed_pieces": "Repair.closed_pieces", "MeshRepair.cavities": "Repair.cavities",
        "MeshRepair.unorientable_pieces": "Repair.unorientable_pieces", "MeshRepair.unorientable_edges": "Repair.unorientable_edges",
        "MeshRepair.step MeshRepair.steps RepairStep.kind RepairStep.enabled RepairStep.count name_of": "Repair.steps",
        "MeshRepairOptions.weld MeshRepairOptions.weld_distance MeshRepairOptions.drop_non_finite "
        "MeshRepairOptions.drop_degenerate MeshRepairOptions.drop_zero_area MeshRepairOptions.drop_duplicates "
        "MeshRepairOptions.min_component_area MeshRepairOptions.min_component_triangles MeshRepairOptions.orient "
        "MeshRepairOptions.turn_outward MeshRepairOptions.keep_cavities MeshRepairOptions.drop_unused_vertices": "Mesh.repair"},
    "mesh_report.h": {
        "report_mesh MeshReportOptions.max_ids": "Mesh.report", "MeshReport.vertices": "Report.vertices",
        "MeshReport.triangles": "Report.triangles", "MeshReport.edges": "Report.edges", "MeshReport.components": "Report.components",
        "MeshReport.boundary_loops": "Report.boundary_loops", "MeshReport.bounds": "Report.bounds", "MeshReport.area": "Report.area",
        "MeshReport.min_edge_length": "Report.min_edge_length", "MeshReport.max_edge_length": "Report.max_edge_length",
        "MeshReport.closed": "Report.closed", "MeshReport.consistently_oriented": "Report.consistently_oriented",
        "MeshReport.closed_if_welded": "Report.closed_if_welded", "MeshReport.orientation": "Report.orientation",
        "MeshReport.signed_volume": "Report.volume", "MeshReport.euler_characteristic": "Report.euler_characteristic",
        "MeshReport.genus": "Report.genus", "MeshReport.findings": "Report.findings",
        "MeshReport.outlook QueryOutlook.query QueryOutlook.outlook QueryOutlook.reason": "Report.outlook",
        "MeshFinding.kind": "Finding.kind", "MeshFinding.severity": "Finding.severity", "MeshFinding.element": "Finding.element",
        "MeshFinding.count": "Finding.number", "MeshFinding.first_ids": "Finding.ids",
        "MeshFinding.first_positions": "Finding.positions", "MeshFinding.meaning": "Finding.meaning"},
    "minkowski_sum.h": {
        "minkowski_sum": "minkowski_sum", "contains": "MinkowskiSum.contains", "signed_distance": "MinkowskiSum.signed_distance",
        "separation Separation.distance Separation.direction": "separation", "MinkowskiSum.dimension": "MinkowskiSum.dimension",
        "MinkowskiSum.position MinkowskiSum.point_count MinkowskiSum.vertex_count": "MinkowskiSum.vertices",
        "MinkowskiSum.facet_loop MinkowskiSum.facet_count": "MinkowskiSum.facets",
        "MinkowskiSum.half_space": "MinkowskiSum.half_spaces", "SurfacePoint.distance": "SumDistances.distance",
        "SurfacePoint.nearest": "SumDistances.nearest", "SurfacePoint.direction": "SumDistances.direction",
        "SurfacePoint.facet": "SumDistances.facet"},
    "mesh_deviation.h": {
        "greatest_deviation mean_deviation": "Deviation", "GreatestDeviationOptions.tolerance MeanDeviationOptions.tolerance": "Index.deviation",
        "GreatestDeviation.distance DistanceBounds.lower DistanceBounds.upper": "Deviation.greatest",
        "GreatestDeviation.point_a": "Deviation.point", "GreatestDeviation.point_b": "Deviation.closest",
        "GreatestDeviation.triangle_a": "Deviation.triangle", "GreatestDeviation.triangle_b": "Deviation.other_triangle",
        "GreatestDeviation.is_complete": "Deviation.complete", "GreatestDeviation.places": "Deviation.places",
        "GreatestDeviation.has_all_places": "Deviation.all_places",
        "GreatestDeviationOptions.max_places GreatestDeviationOptions.place_spacing GreatestDeviationOptions.max_splits "
        "MeanDeviationOptions.max_splits MeanDeviationOptions.histogram_bins": "Index.deviation",
        "MeanDeviation.mean": "Deviation.mean", "MeanDeviation.root_mean_square": "Deviation.root_mean_square",
        "MeanDeviation.is_complete": "Deviation.mean_complete", "MeanDeviation.area": "Deviation.area",
        "MeanDeviation.area_error": "Deviation.area_error", "MeanDeviation.histogram": "Deviation.histogram",
        "MeanDeviationOptions.histogram_end": "Deviation.histogram_end", "FarPlace.distance": "FarPlaces.distance",
        "FarPlace.point_a": "FarPlaces.point", "FarPlace.point_b": "FarPlaces.closest", "FarPlace.triangle_a": "FarPlaces.triangle",
        "FarPlace.triangle_b": "FarPlaces.other_triangle", "both_ways": "both_ways", "TwoSidedMean.mean": "TwoSidedDeviation.mean",
        "TwoSidedMean.root_mean_square": "TwoSidedDeviation.root_mean_square",
        "TwoSidedMean.larger_mean": "TwoSidedDeviation.larger_mean",
        "TwoSidedMean.larger_root_mean_square": "TwoSidedDeviation.larger_root_mean_square"},
    "distance_field.h": {
        "distance_field": "Field", "grid_around GridOptions.resolution GridOptions.spacing GridOptions.margin FieldOptions.band": "Index.distance_field",
        "FieldOutputs.distances": "Field.distance", "FieldOutputs.gradients": "Field.gradient", "FieldOutputs.methods": "Field.method",
        "PointGrid.origin": "Field.origin", "PointGrid.spacing": "Field.spacing", "PointGrid.size": "Field.distance"},
    "neighbourhood.h": {"collect_rings": "Topology.patch", "collect_triangles": "Index.within", "collect_nearest visit_nearest": "Index.nearest",
                        "visit_triangles": "Index.in_box", "NearTriangle.squared_distance": "Nearest.distance",
                        "NearTriangle.triangle": "Nearest.triangle"},
    "octree.h": {
        "build_octree": "Octree", "octree_statistics": "Octree.statistics", "traverse traverse_below": "Octree.leaves",
        "OctreeOptions.root OctreeOptions.max_depth OctreeOptions.threshold OctreeOptions.subdivision OctreeOptions.root_shape "
        "OctreeOptions.classification": "Octree", "Cell.key CellKey.bits": "Leaves.key", "depth": "Leaves.depth",
        "Cell.type": "Leaves.kind", "Octree.box": "Leaves.lower", "cell_box": "Leaves.upper", "Octree.triangles": "Leaves.triangle",
        "OctreeStatistics.boundary OctreeStatistics.bytes OctreeStatistics.depth_reached OctreeStatistics.inner "
        "OctreeStatistics.leaves OctreeStatistics.max_triangles OctreeStatistics.mean_all_leaves OctreeStatistics.mean_triangles "
        "OctreeStatistics.min_triangles OctreeStatistics.occupied_leaves OctreeStatistics.occupied_percent "
        "OctreeStatistics.outer OctreeStatistics.references OctreeStatistics.std_all_leaves OctreeStatistics.std_triangles "
        "OctreeStatistics.total OctreeStatistics.unclassified Octree.bytes": "Octree.statistics"},
    "octree_io.h": {"export_octree export_glb export_htg export_ply export_vtu": "Octree.export", "load_octree": "Octree.load",
                    "save_octree": "Octree.save", "LoadOptions.access": "Index.load"},
    "result.h": {"Error.code Error.message Error.where fail describe": "Error"},
    "sample_meshes.h": {"sample_mesh sample_mesh_names make_cube make_icosphere make_octahedron make_spaceship make_sphere "
                        "make_torus": "Mesh.sample"},
    "scene.h": {
        "build_scene Instance.shape Instance.pose Instance.layers": "Scene", "move_instances move_in_place": "Scene.move", "Scene.shape": "Scene.shapes",
        "Scene.instance": "Scene.poses", "Scene.instance_count": "Scene.instance_count", "Scene.bytes": "Scene.nbytes",
        "Scene.bounds": "Scene.bounds", "Scene.shape_count": "Scene.shape",
        "closest_hits any_hits all_hits SceneRayOptions.faces SceneRayOptions.layers": "Scene.cast", "SceneHit.instance": "SceneHits.instance",
        "SceneHit.hit": "SceneHits.hit", "SceneHitLists.first SceneHitLists.hits": "SceneHitLists",
        "closest_features SceneFeatureOptions.radius SceneFeatureOptions.layers": "Scene.closest",
        "SceneFeature.instance": "SceneClosest.instance", "SceneFeature.distance": "SceneClosest.distance",
        "SceneFeature.point": "SceneClosest.point", "SceneFeature.closest": "SceneClosest.feature",
        "visit_instances": "Scene.in_box", "visible_instances SceneCullOptions.mode SceneCullOptions.layers": "Scene.visible",
        "visible_ranges InstanceRange.rows": "InstanceTriangles.triangle", "InstanceRange.instance": "InstanceTriangles.instance",
        "pairs_in_contact ScenePairOptions.layers ScenePairOptions.others": "Scene.in_contact", "pairs_within": "Scene.within",
        "overlapping_bounds": "Scene.boxes_within", "InstancePair.a": "InstancePairs.a", "InstancePair.b": "InstancePairs.b",
        "NearInstances.a": "NearInstances.a", "NearInstances.b": "NearInstances.b", "NearInstances.nearest": "NearInstances.distance",
        "NearInstances.point_a": "NearInstances.point_a", "NearInstances.point_b": "NearInstances.point_b"},
    "signed_distance.h": {"signed_distances signed_distance SignedOutputs.distances SignedOutputs.methods SignedDistance.distance "
                          "SignedDistance.method": "Index.signed_distance", "name_of": "SIGN_METHODS"},
    "time_of_contact.h": {
        "time_of_contact TimeOfContactOptions.tolerance TimeOfContactOptions.max_steps": "Index.time_of_contact",
        "motion_between": "motion_between", "pose_at": "pose_at", "RigidMotion.start": "Motion.start", "RigidMotion.center": "Motion.center",
        "RigidMotion.displacement": "Motion.displacement", "RigidMotion.turn check_motion": "Motion.turn",
        "TimeOfContact.free_until": "FirstContact.free_until", "TimeOfContact.touches_at": "FirstContact.touches_at",
        "TimeOfContact.evidence": "FirstContact.evidence", "TimeOfContact.free_pose": "FirstContact.free_pose",
        "TimeOfContact.distance": "FirstContact.distance", "TimeOfContact.point_a": "FirstContact.point",
        "TimeOfContact.point_b": "FirstContact.other_point", "TimeOfContact.triangle_a": "FirstContact.triangle",
        "TimeOfContact.triangle_b": "FirstContact.other_triangle", "TimeOfContact.normal": "FirstContact.normal",
        "TimeOfContact.steps": "FirstContact.steps"},
    "topology.h": {"build_topology": "Topology", "Topology.vertices Topology.edge_count": "Topology.edges",
                   "Topology.across": "Topology.neighbours", "Feature.kind Feature.id": "Closest"},
    "touch_scene.h": {
        "TouchScene.add build_touch_body TouchBodyOptions.material TouchBodyOptions.shading TouchBodyOptions.texture": "TouchScene.add",
        "SurfaceTexture.bump Bump.shape": "Texture.bump", "Bump.amplitude": "Texture.amplitude", "Bump.wavelength":
        "Texture.wavelength", "Bump.direction": "Texture.direction", "SurfaceTexture.viscosity": "Texture.viscosity",
        "SurfaceTexture.stick_slip StickSlip.stiffness": "Texture.stick_slip_stiffness",
        "StickSlip.max_force": "Texture.stick_slip_force", "SurfaceTexture.tap Tap.gain": "Texture.tap_gain",
        "Tap.frequency": "Texture.tap_frequency", "Tap.decay": "Texture.tap_decay", "TouchScene.move ObjectMotion.pose "
        "ObjectMotion.seconds ObjectMotion.velocity ObjectMotion.spin ObjectMotion.coast_seconds": "TouchScene.move",
        "TouchScene.exchange": "TouchScene.exchange", "TouchScene.deform refit_touch_body": "TouchScene.deform",
        "TouchScene.set_material": "TouchScene.set_material", "TouchScene.pose": "TouchScene.pose",
        "TouchScene.object_count": "TouchScene.object_count",
        "SurfaceMaterial.stiffness": "Material.stiffness", "SurfaceMaterial.damping": "Material.damping",
        "SurfaceMaterial.static_friction": "Material.static_friction",
        "SurfaceMaterial.dynamic_friction": "Material.dynamic_friction", "object_of": "Contacts.object",
        "triangle_of": "Contacts.triangle"},
    "triangle_mesh.h": {
        "make_triangle_mesh": "Mesh", "mesh_of_points": "Mesh.of_points", "mesh_of_segments": "Mesh.of_segments", "checked_bounding_box bounding_box": "Mesh.bounds",
        "TriangleMesh.position TriangleMesh.positions TriangleMesh.vertex_count": "Mesh.vertices",
        "TriangleMesh.triangle TriangleMesh.triangles TriangleMesh.triangle_count": "Mesh.faces", "mesh_fingerprint": "Mesh.fingerprint"},
    "view_volume.h": {
        "make_perspective_volume": "perspective", "make_orthographic_volume": "orthographic", "make_view_volume": "Index.visible",
        "ViewPlane.normal ViewPlane.offset ViewVolume.planes": "Index.visible",
        "PerspectiveCamera.eye PerspectiveCamera.forward PerspectiveCamera.up PerspectiveCamera.field_of_view "
        "PerspectiveCamera.aspect PerspectiveCamera.near PerspectiveCamera.far": "perspective",
        "OrthographicCamera.eye OrthographicCamera.forward OrthographicCamera.up OrthographicCamera.width "
        "OrthographicCamera.height OrthographicCamera.near OrthographicCamera.far": "orthographic"},
}

LEFT_OUT = {
    "cells_along_ray.h": {"penetration": "CellsOnRays has it of leaves"},
    "cast_ray.h": {"closest_hit any_hit": BATCHES, "visit_hits": "a callback for each hit: hits=\"all\" has them",
                   "RayHit.before": "the order of Index.cast(hits=\"all\")"},
    "closest_feature.h": {
        "is_found no_closest_feature": "points that are not finite are refused", "ClosestFeature.squared_distance": NAMES,
        "ClosestOutputs.answers ClosestOutputs.squared_distances": NAMES, "BatchOptions.order": "for tuning: answers are the same",
        "ClosestFeatureOptions.radius ClosestFeatureOptions.start_from": "for loops in C++, where a start saves a microsecond"},
    "contacts.h": {"Solid.enclosure Solid.parts": STRUCTURE},
    "convex_polyhedron.h": {
        "polyhedron_of_half_spaces ConvexPolyhedron.is_bounded ConvexPolyhedron.is_ray ConvexPolyhedron.rays "
        "ConvexPolyhedron.direction": "unbounded polyhedra: " + NOT_YET, "polyhedron_of_triangle": "Polyhedron(corners) is that",
        "PolyhedronEdge.from PolyhedronEdge.left PolyhedronEdge.right PolyhedronEdge.to PolyhedronNeighbour.edge "
        "PolyhedronNeighbour.vertex ConvexPolyhedron.edges ConvexPolyhedron.neighbours": "facets have the edges",
        "PolyhedronSupport.value PolyhedronSupport.vertex ConvexPolyhedron.support": "a product of arrays: vertices @ direction",
        "ConvexPolyhedron.normal_factors ConvexPolyhedron.normal_sign ConvexPolyhedron.scaled_normal": STRUCTURE,
        "ConvexPolyhedron.vertex": NAMES, "ConvexMeshOptions.tolerance": NOT_YET},
    "cull.h": {"visible_ranges visit_visible TriangleRange.count TriangleRange.first": NAMES,
               "VisibleCell.is_inside": "the boxes of Leaves tell it"},
    "device.h": {
        "open_device is_device_name OpenDeviceOptions.library OpenDeviceOptions.limits Device.info Device.read Device.run "
        "Device.trouble Device.write DeviceInfo.buttons DeviceInfo.driver DeviceInfo.limits DeviceInfo.model DeviceInfo.name "
        "DeviceInfo.patience DeviceInfo.pushes DeviceInfo.rotates DeviceInfo.serial DeviceInfo.stillness DeviceReading.sample "
        "DeviceReading.state DeviceCommand.anchor DeviceCommand.condition DeviceCommand.damping DeviceCommand.dynamic_friction "
        "DeviceCommand.force DeviceCommand.force_scale DeviceCommand.plane_count DeviceCommand.planes DeviceCommand.static_friction "
        "DeviceCommand.stiffness DeviceCommand.torque DevicePlane.normal DevicePlane.offset make_device_input DeviceInput.accept "
        "DeviceInput.command DeviceInput.next_button_event DeviceInput.release DeviceInput.report DeviceInput.state "
        "InputOptions.clutch_buttons InputOptions.frozen_force InputOptions.frozen_seconds InputOptions.max_distance "
        "InputOptions.max_jump InputOptions.rotation InputOptions.settle_seconds InputOptions.stillness InputOptions.tick_seconds "
        "InputReport.clutched_ticks InputReport.faulty_ticks InputReport.freezes InputReport.jumps InputReport.longest_fault "
        "InputReport.longest_recovery InputReport.losses InputReport.not_finite InputReport.recoveries InputReport.samples "
        "InputReport.silences InputReport.suspicions InputReport.velocities ButtonEvent.button ButtonEvent.pressed "
        "ButtonEvent.tick run_servo_loop ServoOptions.pace ServoOptions.rate ServoOptions.ticks ServoStatistics.late "
        "ServoStatistics.locked_memory ServoStatistics.missed ServoStatistics.note ServoStatistics.overslept "
        "ServoStatistics.page_faults ServoStatistics.real_time_priority ServoStatistics.seconds ServoStatistics.skipped "
        "ServoStatistics.ticks ServoStatistics.work LatencyHistogram.add LatencyHistogram.count LatencyHistogram.count_below "
        "LatencyHistogram.max LatencyHistogram.quantile DeviceState.buttons DeviceState.condition":
        "a servo loop of 1,000 ticks a second has no place for an interpreter: `proxima touch` runs one",
        "known_devices DeviceLimits.name within": "the message of an unknown device lists them", "DeviceLimits.max_torque": "of tools"},
    "execution.h": {"Execution.budget MemoryBudget.bytes": "memory that is short raises LimitExceeded",
                    "Execution.threads Execution.progress": "the arguments threads and progress",
                    "Progress.advance Progress.begin_stage Progress.cancelled Progress.cancel_after": "what queries report to"},
    "geometry.h": {
        "scaled_normal is_valid rotation_error Box.center Box.contains Box.empty Box.extend Box.extent Box.lower Box.upper "
        "Triangle.vertices Ray.at RigidTransform.inverse Displacement.from Displacement.rounded Displacement.to bounding_box":
        "arithmetic of arrays"},
    "haptic_renderer.h": {
        "ForceOptions.loss_seconds ForceOptions.max_slew ForceOptions.start_seconds RenderOptions.max_jump RenderOptions.max_moves":
        "for tuning: " + NOT_YET, "RenderTick.tap RenderTick.texture": "parts of Touch.force",
        "HapticRenderer.last HapticRenderer.path RenderTick.condition RenderTick.moves RenderTick.position RenderTick.slide_end "
        "RenderTick.spring RenderTick.surface_velocity": NOT_YET,
        "WorkspaceMap.to_device WorkspaceMap.to_model": "arithmetic of arrays"},
    "intersect_meshes.h": {
        "visit_intersecting_pairs": NAMES, "find_meeting MeshMeeting.row_a MeshMeeting.row_b MeshMeeting.triangle_a "
        "MeshMeeting.triangle_b MeetingOptions.start_from": "for loops in C++ over poses that change little",
        "IntersectionContour.points_of": NAMES, "build_enclosure Enclosure.method Enclosure.parts": STRUCTURE},
    "mesh_distance.h": {"MeshDistance.part_a MeshDistance.part_b MeshDistance.row_a MeshDistance.row_b": STRUCTURE,
                        "MeshDistanceOptions.start_from": "poses of one call start from each other",
                        "MeshDistanceOptions.progress": "progress= of distance_to"},
    "mesh_index.h": {
        "bytes_of MeshIndexBytes.blocks MeshIndexBytes.ids MeshIndexBytes.incidences MeshIndexBytes.lists MeshIndexBytes.rows "
        "MeshIndexBytes.signs MeshIndexBytes.slabs": STRUCTURE, "default_list_bytes ListOptions.margin ListOptions.max_depth":
        "for tuning: answers are the same", "MeshIndex.ids MeshIndex.parts": STRUCTURE},
    "mesh_report.h": {"MeshReport.find name_of": NAMES},
    "mesh_io.h": {"format_name format_of_path known_mesh_extensions": "the message of an unknown extension lists them"},
    "minkowski_sum.h": {
        "directional_depth": NOT_YET, "SumFacet.a SumFacet.b SumFacet.origin SumFacet.turn SumCorner.a SumCorner.b SumCorner.kind "
        "MinkowskiSum.a MinkowskiSum.b MinkowskiSum.corner MinkowskiSum.edges MinkowskiSum.facet": "which parts a facet is made of: "
        + NOT_YET, "MinkowskiSum.support": "a product of arrays: vertices @ direction",
        "MinkowskiSum.holds_line MinkowskiSum.is_all_of_space MinkowskiSum.is_bounded MinkowskiSum.is_ray":
        "unbounded polyhedra: " + NOT_YET, "MinkowskiSum.normal_factors MinkowskiSum.scale MinkowskiSum.scaled": STRUCTURE},
    "mesh_deviation.h": {
        "GreatestDeviation.splits MeanDeviation.splits": "for tuning",
        "GreatestDeviationOptions.default_tolerance MeanDeviationOptions.default_tolerance "
        "GreatestDeviationOptions.default_spacing": "the docstring of Index.deviation tells them"},
    "distance_field.h": {"PointGrid.point PointGrid.position PointGrid.point_count": NAMES},
    "neighbourhood.h": {
        "collect_features NearestFeature.feature NearestFeature.squared": NOT_YET, "Neighbourhood.complete Neighbourhood.written": NAMES,
        "NeighbourhoodScratch.begin NeighbourhoodScratch.mark NeighbourhoodScratch.set_round NeighbourhoodScratch.triangle_count "
        "NeighbourhoodScratch.vertex_count": "memory of a search"},
    "octree.h": {
        "cell_coordinates cell_key child octant parent tight_root OctreeFrame.edge OctreeFrame.lower OctreeFrame.plane": NAMES,
        "OctreeNode.count OctreeNode.empty_split_bit OctreeNode.first OctreeNode.inner_mask OctreeNode.is_empty "
        "OctreeNode.is_leaf OctreeNode.leaf OctreeNode.leaf_bit OctreeNode.packed "
        "OctreeNode.recorded_mask OctreeNode.split Cell.no_node Cell.node Octree.adopt Octree.child Octree.frame Octree.is_leaf "
        "Octree.nodes Octree.parameters Octree.references Octree.root Octree.triangle_count": STRUCTURE,
        "ClassificationSummary.components ClassificationSummary.leaked_components ClassificationSummary.leaked_leaves "
        "OctreeParameters.classification OctreeParameters.classified OctreeParameters.exact OctreeParameters.max_depth "
        "OctreeParameters.method OctreeParameters.subdivision OctreeParameters.threshold": "what it was built with: " + NOT_YET,
        "OctreeStatistics.leaves_at_depth": NAMES},
    "octree_io.h": {"LoadOptions.verify": "files are always checked whole"},
    "scene.h": {
        "closest_hit any_hit closest_feature": BATCHES, "visit_hits": "a callback for each hit: hits=\"all\" has them",
        "SceneHit.before": "the order of Scene.cast(hits=\"all\")", "instance_frame relative_pose to_instance": "arithmetic of arrays",
        "to_index": "ids are int32", "Scene.parts": STRUCTURE},
    "sample_meshes.h": {"is_sample_mesh_name": "a wrong name raises InvalidInput"},
    "signed_distance.h": {"has_local_signs sign_of SignedDistance.closest SignedOutputs.answers": NAMES},
    "topology.h": {"Topology.bytes": STRUCTURE, "to_index": "ids are int32",
                   "Topology.edges Topology.triangles Topology.find_edge Topology.other_end Topology.triangle_count "
                   "Topology.vertex_count": NAMES},
    "touch_scene.h": {
        "TouchBody.mesh": "Index.mesh has it", "TouchScene.advance SceneTick.exchanged SceneTick.moved SceneTick.seconds": STRUCTURE,
        "TouchScene.velocity": NOT_YET, "scene_triangle to_index": NAMES,
        "SurfaceTexture.any Bump.any StickSlip.any Tap.any": "arithmetic of numbers",
        "build_height_image Bump.image HeightImage.columns HeightImage.rows HeightImage.samples HeightImage.parts": NOT_YET,
        "open_engine_channel EngineChannel.receive EngineChannel.report EngineChannel.send EngineChannel.trouble "
        "EngineReport.accepted EngineReport.duplicated EngineReport.foreign EngineReport.leapt EngineReport.lost "
        "EngineReport.malformed EngineReport.materials EngineReport.motions EngineReport.other_versions EngineReport.received "
        "EngineReport.refused_objects EngineReport.reordered EngineReport.sent EngineReport.sessions EngineReport.unsent":
        "the other end of it: engine_client.py in examples"},
    "triangle_mesh.h": {"to_index": "ids are int32"},
    "view_volume.h": {"ViewVolume.empty ViewVolume.inner_point": STRUCTURE},
}

# Python names that no C++ name stands for, and why.
PYTHONS_OWN = {
    "Neighbours Patches Facets Leaves.first Neighbours.first Neighbours.triangle Patches.first Patches.triangle Patches.ring "
    "Facets.first Facets.vertex HitLists.first HitLists.t HitLists.triangle HitLists.u HitLists.v PairLists.first PairLists.a "
    "PairLists.b Hits.t Hits.triangle Hits.u Hits.v": "columns of answers",
    "Hits.hit Pairs.intersecting PairLists.intersecting": "made of the columns", "Scene.shape Scene.layers": "columns of instances",
    "Closest ClosestOne Hits Pairs Distances Leaves SumDistances Report Finding Repair SelfIntersections "
    "SceneClosest SceneHits InstanceTriangles InstancePairs NearInstances Motion FirstContact PenetrationDepth ContactRegions "
    "NearInstances.triangle_a NearInstances.triangle_b Containments Contour FarPlaces TwoSidedDeviation TwoSidedDeviation.greatest Field Nearest CellsOnRays CellsOnRays.first Material Texture DeviceLimits Touch Contacts "
    "Contour.ids_b SelfIntersections.b": "tuples of columns",
    "SceneClosest.triangle SceneClosest.feature_kind SceneClosest.barycentric": "named as the columns of Closest",
    "SceneHits.t SceneHits.triangle SceneHits.u SceneHits.v SceneHitLists.first SceneHitLists.instance SceneHitLists.t "
    "SceneHitLists.triangle SceneHitLists.u SceneHitLists.v": "named as the columns of Hits",
    "ClosestOne.distance ClosestOne.point ClosestOne.triangle ClosestOne.feature_kind ClosestOne.feature ClosestOne.barycentric":
    "named as the columns of Closest",
    "Replay Replay.touch Replay.seconds Replay.position Replay.velocity Replay.force Replay.differences Replay.tick_seconds "
    "Replay.units_per_metre Replay.center TouchRenderer.replay": "sessions of `proxima touch`, which C++ has no public reader of",
    "TouchScene": "its bounds are the constructor's",
    "PENETRATION_METHODS CONTACT_EVIDENCE FEATURE_KINDS CELL_KINDS INSIDE_METHODS CONTAINMENTS HOLDS TOUCH_FAULTS": "names of numbers",
    "InvalidInput FileMissing FileNotWritable LimitExceeded": "Error.code as types",
    "__version__": "", "MinkowskiSum": "made by minkowski_sum()",
}
ANSWERS = ("count", "index")  # what tuples have of their own


def words(table):
    return {word for names in table for word in names.split()}


def in_python():
    """Names of the package and of its classes' public members."""
    for name in proxima.__all__:
        yield name
        thing = getattr(proxima, name)
        if isinstance(thing, type) and not issubclass(thing, BaseException):
            names = {member for base in thing.__mro__[:-1] if base is not tuple for member in vars(base)}
            own = ANSWERS if issubclass(thing, tuple) else ()
            yield from (f"{name}.{member}" for member in names if not member.startswith("_") and member not in own)


@pytest.mark.parametrize("header", [path.name for path in HEADERS if path.name not in NO_PART_OF_IT])
def test_every_name_of_a_header_is_offered_or_left_out_with_a_reason(header):
    functions, classes = cpp_names.declarations(HEADERS[0].with_name(header))
    declared = functions | {f"{name}.{member}" for name, members in classes.items() for member in members}
    declared = {name for name in declared if not name.endswith("Options.execution")}
    offered, left_out = words(OFFERED.get(header, {})), words(LEFT_OUT.get(header, {}))
    assert declared - offered - left_out == set(), "neither offered nor left out"
    assert (offered | left_out) - declared == set(), "not declared"


def test_every_header_is_looked_at():
    names = {path.name for path in HEADERS}
    assert len(names) > 30 and set(NO_PART_OF_IT) | set(OFFERED) == names and not set(NO_PART_OF_IT) & set(OFFERED)
    assert set(LEFT_OUT) <= set(OFFERED)


def test_every_name_of_python_is_one_of_the_headers_or_its_own():
    stands_for = {name for table in OFFERED.values() for name in table.values()}
    ours, own = set(in_python()), words(PYTHONS_OWN)
    assert stands_for - ours == set(), "offered under a name that Python does not have"
    assert ours - stands_for - own == set(), "stands for nothing"
    assert own - ours == set(), "not in Python"


def test_names_are_read_from_headers(tmp_path):
    header = tmp_path / "some.h"
    header.write_text("""#pragma once
namespace PROXIMA_EXPORT proxima {
class Later;
inline constexpr int limit = f(3);
enum class Kind { one, two };
struct Options { int depth = g(2); std::array<int, 2> pair = {1, 2}; Execution execution = {}; }; // int no(int);
class Thing {
public:
    explicit Thing(int a);
    [[nodiscard]] int size() const noexcept { return size_; }
    friend bool operator==(const Thing&, const Thing&) = default;
private:
    int hidden() const;
    int size_ = 0;
};
template <class T> concept Visitor = requires(T t) { t(); };
[[nodiscard]] Result<Thing> make_thing(const Options& options = {});
[[nodiscard]] inline int size_of(const Thing& thing) { return thing.size(); }
} // namespace proxima
""")
    assert cpp_names.declarations(header) == (
        {"make_thing", "size_of"}, {"Options": {"depth", "pair", "execution"}, "Thing": {"size"}})
