"""Asks Open3D's RaycastingScene what tests/python/test_compat.py asks the adapter, and prints the answers as JSON.

    python3 tests/python/open3d_answers.py > tests/python/open3d.json        needs python3-open3d, libembree-dev and cc

Every ray of Debian's Open3D 0.16 misses: it leaves the mask of rays at 0, and Debian's Embree heeds masks. A library that
is loaded before Embree sets the mask here.
"""
import json
import os
import subprocess
import sys
import tempfile
from pathlib import Path

import numpy as np

MASK = """
#include <dlfcn.h>
#include <embree3/rtcore.h>
#define WITH_MASK(NAME, TYPE, MASK) \\
    void NAME(RTCScene scene, struct RTCIntersectContext* context, struct TYPE* rays, unsigned count, size_t stride) \\
    { \\
        void (*real)(RTCScene, struct RTCIntersectContext*, struct TYPE*, unsigned, size_t) = \\
            dlsym(dlopen("libembree3.so.3", RTLD_NOW), #NAME); \\
        for (unsigned i = 0; i < count; ++i) ((struct TYPE*)((char*)rays + i * stride))->MASK = -1; \\
        real(scene, context, rays, count, stride); \\
    }
WITH_MASK(rtcIntersect1M, RTCRayHit, ray.mask)
WITH_MASK(rtcOccluded1M, RTCRay, mask)
"""


def scene_arrays():
    """Two meshes, and rays and points that come near no edge: Open3D counts in floats."""
    import proxima

    torus, ball = proxima.Mesh.sample("torus:24x12"), proxima.Mesh.sample("icosphere:2")
    meshes = [(np.array(torus.vertices, "f4"), np.array(torus.faces, "u4")),
              (np.array(ball.vertices, "f4") / 2 + np.array([0, 0, 4], "f4"), np.array(ball.faces, "u4"))]
    random = np.random.default_rng(17)
    origins = random.normal(size=(12, 5, 3)) * 4
    targets = random.uniform([-1.2, -1.2, -0.5], [1.2, 1.2, 4.5], (12, 5, 3))
    rays = np.concatenate((origins, targets - origins), axis=2).astype("f4")
    return meshes, rays, random.uniform([-1.5, -1.5, -0.5], [1.5, 1.5, 4.5], (10, 6, 3)).astype("f4")


def parity_scenes():
    """Scenes in which windings add up to something else than crossings, by name, and points of shape (100, 3)."""
    import proxima

    ball = proxima.Mesh.sample("icosphere:2")
    vertices, faces = np.array(ball.vertices, "f4"), np.array(ball.faces, "u4")
    small, beside, turned = vertices / 2, vertices + np.array([0.7, 0, 0], "f4"), faces[:, ::-1].copy()
    far = vertices + np.array([3, 0, 0], "f4")

    def in_one(other, other_faces):
        return [(np.concatenate((vertices, other)), np.concatenate((faces, other_faces + np.uint32(len(vertices)))))]

    scenes = {"nested": [(vertices, faces), (small, faces)], "cavity": [(vertices, faces), (small, turned)],
              "overlap": [(vertices, faces), (beside, faces)], "overlap_turned": [(vertices, turned), (beside, faces)],
              "twice": [(vertices, faces), (vertices, faces)], "nested_in_one": in_one(small, faces),
              "cavity_in_one": in_one(small, turned), "overlap_in_one": in_one(beside, turned), "apart_in_one": in_one(far, turned),
              "three": [(vertices, faces), (small / 2, turned), (small, faces), (far, turned)]}
    return scenes, np.random.default_rng(19).uniform([-1.1, -1.1, -1.1], [4.1, 1.1, 1.1], (100, 3)).astype("f4")


def ask(new_scene, meshes, wrap, unwrap):
    """All answers by name, as arrays: of a scene of the meshes, and of parity_scenes()."""
    scene = new_scene()
    _, rays, points = scene_arrays()
    answers = {"add_triangles": np.array([scene.add_triangles(*arrays) for arrays in meshes])}
    answers.update({f"cast_rays.{name}": unwrap(column) for name, column in scene.cast_rays(wrap(rays)).items()})
    answers.update({f"closest.{name}": unwrap(column)
                    for name, column in scene.compute_closest_points(wrap(points)).items()})
    answers["test_occlusions"] = unwrap(scene.test_occlusions(wrap(rays), 0.2, 0.9))
    answers["count_intersections"] = unwrap(scene.count_intersections(wrap(rays)))
    for name in ("compute_distance", "compute_signed_distance", "compute_occupancy"):
        answers[name] = unwrap(getattr(scene, name)(wrap(points)))
    intrinsic, extrinsic = np.array([[100.0, 3, 32], [0, 110, 24], [0, 0, 1]]), np.eye(4)
    extrinsic[:3] = [[0.6, -0.8, 0, 0.1], [0.8, 0.6, 0, 0.2], [0, 0, 1, 3]]
    answers["rays_of_matrices"] = unwrap(new_scene.create_rays_pinhole(wrap(intrinsic), wrap(extrinsic), 4, 3))
    answers["rays_of_view"] = unwrap(new_scene.create_rays_pinhole(
        fov_deg=60.0, center=wrap(np.zeros(3)), eye=wrap(np.array([1.0, 2, 3])), up=wrap(np.array([0, 1, 0.3])), width_px=5, height_px=2))
    answers["tfar_before_tnear"] = unwrap(scene.test_occlusions(wrap(rays), 0.9, 0.2))
    scenes, points = parity_scenes()
    for name, geometries in scenes.items():
        scene = new_scene()
        for vertices, faces in [*geometries, (np.zeros((0, 3), "f4"), np.zeros((0, 3), "u4"))]:
            scene.add_triangles(vertex_positions=wrap(vertices), triangle_indices=wrap(faces))
        answers[f"{name}.signed_distance"] = unwrap(scene.compute_signed_distance(wrap(points)))
        answers[f"{name}.occupancy"] = unwrap(scene.compute_occupancy(wrap(points)))
    return answers


def of_json(text):
    """The arrays that main() printed."""
    return {name: np.array([np.inf if value is None else value for value in column["values"]], column["dtype"])
            .reshape(column["shape"]) for name, column in json.loads(text).items()}


def main():
    if "LD_PRELOAD" not in os.environ:
        with tempfile.TemporaryDirectory() as folder:
            source, library = Path(folder, "mask.c"), Path(folder, "mask.so")
            source.write_text(MASK)
            subprocess.run(["cc", "-shared", "-fPIC", "-O1", "-o", library, source], check=True)
            sys.exit(subprocess.run([sys.executable, __file__], env={**os.environ, "LD_PRELOAD": str(library)}).returncode)
    import open3d

    tensor = open3d.core.Tensor
    meshes = [[tensor(array) for array in arrays] for arrays in scene_arrays()[0]]
    answers = ask(open3d.t.geometry.RaycastingScene, meshes, tensor, lambda given: given.numpy())
    answers["INVALID_ID"] = np.array(open3d.t.geometry.RaycastingScene.INVALID_ID)
    print(json.dumps({name: {"dtype": str(column.dtype), "shape": column.shape,
                             "values": [None if value == np.inf else value for value in column.ravel().tolist()]}
                      for name, column in answers.items()}))


if __name__ == "__main__":
    main()
