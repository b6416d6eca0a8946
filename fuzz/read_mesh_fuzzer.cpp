// Reads any bytes as a mesh of one format: refused with a reason, or a mesh that keeps its
// promises.
#include "base/check.h"
#include "proxima/mesh_io.h"

#include <cstddef>
#include <cstdint>

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size)
{
    using namespace proxima;
    constexpr auto format = MeshFormat::PROXIMA_FUZZED_FORMAT;
    const std::uint64_t budget = 256'000'000;
    const auto mesh = read_mesh_from_memory(
        std::as_bytes(std::span(data, size)), format,
        {.weld = size % 2 == 0 ? Weld::by_format : Weld::exact_positions,
         .primitives = size % 3 == 0 ? Primitives::points_and_lines : Primitives::triangles,
         .execution = {.budget = {.bytes = budget}}});
    if (!mesh) {
        PROXIMA_CHECK(!mesh.error().message.empty());
        PROXIMA_CHECK(!mesh.error().where.empty());
        return 0;
    }
    for (const TriangleCorners& corners : mesh->triangles()) {
        for (const std::uint32_t corner : corners) PROXIMA_CHECK_LT(corner, mesh->vertex_count());
    }
    // A byte of text makes at most one triangle; scenes repeat their meshes.
    if (format < MeshFormat::three_ds) PROXIMA_CHECK_LE(mesh->triangle_count(), size);
    return 0;
}
