// What a command of proxima-mpi begins with: the slices of its mesh, and the box of the whole.
#pragma once

#include "distributed/mesh_slice.h"
#include "distributed/world.h"

#include <string>

namespace proxima {

/// This rank's slice of a model: a binary little-endian .ply file, torus:NxM, or vertices as a .npy
/// file, with one of `triangles`, which is empty else. Collective.
[[nodiscard]] Result<MeshSlice> load_slice(const std::string& model, const std::string& triangles,
                                           World& world);

/// The box of the whole mesh. Error invalid_mesh where a coordinate is NaN, infinite or too large
/// for exact arithmetic. Collective.
[[nodiscard]] Result<Box> whole_box(const MeshSlice& slice, World& world);

/// All of the model, on one process, for comparisons.
[[nodiscard]] Result<TriangleMesh> whole_mesh(const std::string& model);

} // namespace proxima
