#include "distributed/mesh_input.h"

#include "proxima/mesh_io.h"
#include "proxima/sample_meshes.h"

#include <algorithm>
#include <limits>

namespace proxima {

Result<Box> whole_box(const MeshSlice& slice, World& world)
{
    constexpr double infinity = std::numeric_limits<double>::infinity();
    std::array<double, 6> ends; // lower corner, and the upper one negated
    ends.fill(infinity);
    const Status status = world.agree_on([&]() -> Status {
        for (std::size_t i = 0; i < slice.mesh.vertex_count(); ++i) {
            const Vec3& at = slice.mesh.positions()[i];
            if (!at.allFinite()) {
                return fail(ErrorCode::invalid_mesh,
                            concat("vertex ", slice.vertices[i],
                                   " has a NaN or infinite coordinate: repair the mesh"),
                            slice.name);
            }
            for (std::size_t axis = 0; axis < 3; ++axis) {
                const double value = at[static_cast<Eigen::Index>(axis)];
                ends[axis] = std::min(ends[axis], value);
                ends[3 + axis] = std::min(ends[3 + axis], -value);
            }
        }
        return {};
    });
    if (!status) return tl::unexpected(status.error());
    MPI_Allreduce(MPI_IN_PLACE, ends.data(), 6, MPI_DOUBLE, MPI_MIN, MPI_COMM_WORLD);
    if (*std::ranges::min_element(ends) < -1e100) {
        return fail(ErrorCode::invalid_mesh,
                    "coordinates beyond 1e100 would overflow exact arithmetic: scale the mesh",
                    slice.name);
    }
    Box box;
    box.lower = {ends[0], ends[1], ends[2]};
    box.upper = {-ends[3], -ends[4], -ends[5]};
    return box;
}

Result<MeshSlice> load_slice(const std::string& model, const std::string& triangles, World& world)
{
    if (!triangles.empty()) {
        if (model.ends_with(".npy")) return read_npy_slice(model, triangles, world);
        return fail(
            ErrorCode::invalid_argument,
            "--triangles goes with vertices in a .npy file: leave it out, or name that file",
            model);
    }
    if (const auto size = torus_size(model)) return make_torus_slice(*size, world);
    if (model.ends_with(".ply")) return read_ply_slice(model, world);
    return fail(ErrorCode::unsupported_format,
                "proxima-mpi takes binary little-endian .ply files, torus:NxM, and .npy files of "
                "vertices with --triangles",
                model);
}

Result<TriangleMesh> whole_mesh(const std::string& model)
{
    if (is_sample_mesh_name(model)) return sample_mesh(model);
    return read_mesh(model, {.weld = Weld::never});
}

} // namespace proxima
