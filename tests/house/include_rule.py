#!/usr/bin/env python3
"""The include rule: who may include whom.

    base  geometry  mesh  minkowski  octree  index  query  haptics  thesis  lab  c  apps
    <--------------------------------------- a file includes its own folder and those to its left

The public headers, include/proxima, each belong to one of these layers. They include public headers
of their own layer and those to its left, Eigen and the standard library only; result.h also
tl/expected.hpp. proxima.h includes all of them, and the library's own files never include it.

An app sees only itself among the apps, the viewer and the distributed program also the
command line, and the program's main file all. Includes are
written as the path below src/, include/ or apps/, files never include each other in a circle, and foreign
headers stay in the layers that may use them. Nobody, tests and benchmarks neither, writes for one
processor: vector code goes through Highway, in base and in the kernels named below.

    include_rule.py ROOT      prints each broken rule as FILE:LINE: what; exit status 1 if any
"""
import re
import sys
from pathlib import Path

# Layers by rank: a layer may include layers of lower rank, and itself.
RANK = {"base": 0, "geometry": 1, "mesh": 2, "minkowski": 3, "octree": 4,
        "index": 5, "query": 6, "haptics": 7, "thesis": 8, "lab": 9, "c": 10, "apps": 11}

# Apps stand beside each other, but for those that may include another one. The program's main file
# knows the commands of all.
MAY_INCLUDE_APP = {"viewer": {"cli"}, "distributed": {"cli"}}
PROGRAM = "apps/cli/main.cpp"

# Foreign headers (first part of the path) and the layers that may name them; None: all layers.
FOREIGN = {"Eigen": None, "hwy": {"base"}, "tl": None, "xxhash.h": None, "sys": None, "netinet": {"base"},
           "sanitizer": {"base"}, "tbb": {"base"}, "oneapi": {"base"}, "assimp": {"mesh"}}
THREAD_LIBRARY = {"tbb", "oneapi"}
THREADS = "src/base/parallel.cpp"
FOREIGN_TO_ALL_BUT_APPS = {"CLI", "fmt", "nlohmann", "png.h", "GLFW", "epoxy", "imgui.h", "pybind11", "gtest",
                           "cairo.h", "cairo-pdf.h", "cairo-svg.h", "pango"}

# Public headers and the layer that implements them.
PUBLIC = {
    "execution.h": "base", "export.h": "base", "function_ref.h": "base", "result.h": "base",
    "geometry.h": "geometry", "view_volume.h": "geometry",
    "mesh_io.h": "mesh", "mesh_repair.h": "mesh", "mesh_report.h": "mesh", "sample_meshes.h": "mesh",
    "topology.h": "mesh", "triangle_mesh.h": "mesh",
    "convex_polyhedron.h": "minkowski", "minkowski_sum.h": "minkowski",
    "grow_cells.h": "octree", "octree.h": "octree", "octree_io.h": "octree",
    "index_io.h": "index", "mesh_index.h": "index",
    "cast_ray.h": "query", "cells_along_ray.h": "query", "closest_feature.h": "query", "cull.h": "query",
    "intersect_meshes.h": "query", "mesh_distance.h": "query", "neighbourhood.h": "query",
    "contacts.h": "query", "distance_field.h": "query", "mesh_deviation.h": "query", "scene.h": "query",
    "signed_distance.h": "query", "time_of_contact.h": "query",
    "thesis.h": "thesis",
    "device.h": "haptics", "haptic_renderer.h": "haptics", "tool_renderer.h": "haptics", "touch_scene.h": "haptics",
}
EVERYTHING = Path("include/proxima/proxima.h")
FOR_C = Path("include/proxima/c/proxima.h")
PUBLIC_FOREIGN = {"result.h": {"tl"}}

# Files outside base that are compiled once per instruction set.
KERNELS = {f"src/octree/{name}" for name in (
    "distribute_children.cpp", "snapped_boxes.cpp", "snapped_lanes-inl.h", "snapped_overlap.cpp")} | {
    f"src/index/{name}" for name in (
        "lists/block_scan-inl.h", "lists/domination.cpp", "lists/eight_corners-inl.h", "lists/local_region.cpp",
        "triangle_lanes.cpp")} | {
    f"src/query/{name}" for name in (
        "closest/batch_lists-inl.h", "closest/closest_batch_in_index.cpp", "closest/closest_in_index.cpp",
        "closest/row_distance-inl.h", "closest/search_index-inl.h",
        "closest/search_lists-inl.h", "contact/box_pairs-inl.h", "contact/eight_points-inl.h",
        "contact/intersect_meshes.cpp", "contact/leaf_intersection-inl.h", "contact/walk_pairs-inl.h", "contacts/child_steps.cpp",
        "culling/cull_volume.cpp", "distance/mesh_distance.cpp", "distance/pair_bounds-inl.h", "field/search_grid.cpp",
        "rays/cast_ray.cpp",
        "rays/intersect_exact-inl.h", "rays/prepare_ray-inl.h", "rays/walk_ray-inl.h", "scene/instance_box.cpp", "scene/walk_scene.cpp")} | {
    f"src/haptics/surface/{name}" for name in (
        "ball_gaps-inl.h", "find_groups.cpp", "groups_along_segment.cpp", "near_groups.cpp", "triangle_groups.cpp",
        "triangle_tree_search.cpp")} | {"src/haptics/tool/closest_directions.cpp"}

# Headers of one processor: immintrin.h, x86intrin.h, arm_neon.h, riscv_vector.h and their like.
INTRINSICS = re.compile(r"^(\w*intrin|cpuid|(arm|riscv)_\w+|altivec|wasm_simd128|msa)\.h$")
OTHER_FOLDERS = ("tests", "bench", "fuzz", "examples", "python")

INCLUDE = re.compile(r'^\s*#\s*include\s*(["<])([^">]+)[">]')


def is_public(path):
    return path.parts[0] == "include"


def layer_of(path):
    """Layer of a path below the root, such as src/mesh/x.h, include/proxima/x.h or apps/cli/x.h."""
    parts = path.parts
    if is_public(path):
        return "c" if path == FOR_C else PUBLIC.get(path.name)
    return "apps" if parts[0] == "apps" else parts[1] if len(parts) > 2 else None


def room_of(path):
    """What a file may always include: its layer, or for an app its own folder."""
    return path.parts[:2] if path.parts[0] == "apps" else layer_of(path)


def intrinsics_problem(name):
    return f"<{name}> is for one processor only: use Highway" if INTRINSICS.match(name) else None


def foreign_problem(name, source):
    first, layer = name.split("/")[0], layer_of(source)
    if INTRINSICS.match(name):
        return intrinsics_problem(name)
    if source == FOR_C:
        return None if name in ("stddef.h", "stdint.h") else f"<{name}> is not for the header for C"
    if is_public(source) and ("/" in name or first in FOREIGN or name.endswith(".h")):
        allowed = first == "Eigen" or first in PUBLIC_FOREIGN.get(source.name, set())
        return None if allowed else f"<{name}> is not for public headers"
    if first == "hwy" and source.as_posix() in KERNELS:
        return None
    if layer == "apps":
        return None if first != "hwy" else f"<{name}> is for base and kernels only"
    if first in THREAD_LIBRARY and source.as_posix() != THREADS:
        return f"<{name}> is for {THREADS} only"
    if first in FOREIGN_TO_ALL_BUT_APPS:
        return f"<{name}> is for apps only"
    if first in FOREIGN:
        allowed = FOREIGN[first]
        if allowed is not None and layer not in allowed:
            return f"<{name}> is for {', '.join(sorted(allowed))} only"
        return None
    return f"<{name}> is of no library the core may use" if "/" in name else None


def edge_problem(source, target):
    """Why `source` may not include `target`, both paths below the root; None where it may."""
    if is_public(source) and not is_public(target):
        return f"a public header must not include {target}"
    if target == EVERYTHING:
        return "proxima.h is for users only"
    if room_of(source) == room_of(target):
        return None
    one, other = layer_of(source), layer_of(target)
    if other not in RANK:
        return f"{other} is no layer"
    if RANK[other] < RANK[one]:
        return None
    if one != other:
        return f"{one} must not include {other}"
    if source.as_posix() == PROGRAM or target.parts[1] in MAY_INCLUDE_APP.get(source.parts[1], set()):
        return None
    return "an app must not include another app"


def circles(graph):
    """One circle of includes per group of files that include each other, as lists of paths."""
    found, state = [], {}
    for start in sorted(graph):
        if start in state:
            continue
        state[start] = "open"
        path, pending = [start], [iter(sorted(graph[start]))]
        while pending:
            following = next(pending[-1], None)
            if following is None:
                state[path.pop()] = "done"
                pending.pop()
            elif state.get(following) == "open":
                found.append(path[path.index(following):] + [following])
            elif following in graph and following not in state:
                state[following] = "open"
                path.append(following)
                pending.append(iter(sorted(graph[following])))
    return found


def problems_of_everything(root):
    """proxima.h names every public header and nothing else."""
    text = (root / EVERYTHING).read_text()
    named = [match[2] for match in map(INCLUDE.match, text.splitlines()) if match]
    there = sorted(f"proxima/{path.name}" for path in (root / EVERYTHING.parent).glob("*.h") if path.name != EVERYTHING.name)
    if named != there:
        wrong = sorted(set(named) ^ set(there)) or ["their order"]
        yield f"{EVERYTHING}:1: it must include all public headers, by name: {', '.join(wrong)}"


def problems_of_file(root, source, targets):
    """Broken rules of one file; adds the project's files that it includes to `targets`."""
    if source == EVERYTHING:
        yield from problems_of_everything(root)
        return
    layer = layer_of(source)
    if layer not in RANK:
        yield (f"{source}:1: a public header without a layer: name it in include_rule.py" if is_public(source)
               else f"{source}:1: {layer or 'src'} is no layer: they are {', '.join(RANK)}")
        return
    for number, line in enumerate((root / source).read_text().splitlines(), 1):
        match = INCLUDE.match(line)
        if not match:
            continue
        quoted, name = match[1] == '"', match[2]
        target = next((folder / name for folder in (Path("src"), Path("include"), Path("apps"))
                       if (root / folder / name).is_file()), None)
        if target is not None and ".." not in target.parts:
            problem = edge_problem(source, target)
            if not quoted:
                problem = problem or f'write "{name}": it is our own'
            targets.add(target)
        elif quoted:
            problem = f'"{name}" is no path below src/, include/ or apps/'
        else:
            problem = foreign_problem(name, source)
        if problem:
            yield f"{source}:{number}: {problem}"


def intrinsics_in(root, source):
    for number, line in enumerate((root / source).read_text().splitlines(), 1):
        match = INCLUDE.match(line)
        if match and intrinsics_problem(match[2]):
            yield f"{source}:{number}: {intrinsics_problem(match[2])}"


def problems(root):
    graph, found = {}, []
    files = [path.relative_to(root) for folder in ("src", "include", "apps") for path in (root / folder).rglob("*")
             if path.suffix in (".h", ".cpp")]
    for source in sorted(files):
        graph[source] = set()
        found += problems_of_file(root, source, graph[source])
    for folder in OTHER_FOLDERS:
        for path in sorted((root / folder).rglob("*")):
            if path.suffix in (".h", ".cpp"):
                found += intrinsics_in(root, path.relative_to(root))
    for circle in circles(graph):
        found.append(f"{circle[0]}:1: circle of includes: {' -> '.join(map(str, circle))}")
    return found, len(files)


def main():
    if len(sys.argv) != 2:
        print(__doc__, file=sys.stderr)
        return 2
    found, count = problems(Path(sys.argv[1]).resolve())
    if count == 0:
        found.append(f"no sources found below {sys.argv[1]}")
    for problem in found:
        print(problem)
    print(f"include rule: {count} files, {len(found)} problems")
    return 1 if found else 0


if __name__ == "__main__":
    sys.exit(main())
