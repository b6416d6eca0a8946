// Feeds files with right checksums and any content to the octree loader, walks through what it
// accepts, along rays, too, and asks which cells a camera sees.
// Seeds are made by: proxima octree cube --depth 2 --save fuzz/corpus/octree/cube.pxo
#include "base/binary_file.h"
#include "exact_copy.h"
#include "proxima/cells_along_ray.h"
#include "proxima/cull.h"
#include "proxima/octree.h"
#include "proxima/octree_io.h"
#include "proxima/view_volume.h"

#include <cstddef>
#include <cstdint>
#include <cstdlib>

namespace {

using namespace proxima;

/// What a cell lists are triangles of the mesh that the file names.
void expect_exist(const Octree& octree, const Cell& cell)
{
    for (const TriangleId id : octree.triangles(cell))
        if (to_index(id) >= octree.triangle_count()) std::abort();
}

void ask(const Octree& octree)
{
    const Box root = octree.box(octree.root());
    const Vec3 size = root.extent();
    for (int i = 0; i < 27; ++i) {
        const Vec3 at =
            Eigen::Vector3i(i % 3, i / 3 % 3, i / 9).cast<double>() - Vec3(0.9, 0.8, 0.7);
        const Vec3 origin = root.center() + size.cwiseProduct(at);
        const Ray ray{.origin = origin, .direction = root.center() - origin};
        cells_along_ray(octree, ray, [&](const CellOnRay& on) noexcept {
            expect_exist(octree, on.cell);
            return Flow::proceed;
        });
        const auto volume = make_perspective_volume({.eye = origin, .forward = ray.direction});
        if (!volume) continue;
        for (const CullMode mode : {CullMode::conservative, CullMode::exact}) {
            for (const VisibleCell& seen : visible_cells(octree, *volume, mode))
                expect_exist(octree, seen.cell);
        }
    }
}

} // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size)
{
    const auto copy = proxima::testing::exact_copy(data, size);
    proxima::reseal_binary_file({copy.get(), size});
    const auto octree = proxima::load_octree({copy.get(), size}, copy, "fuzz");
    if (octree) {
        const auto statistics = proxima::octree_statistics(*octree);
        if (statistics.references != octree->references().size()) std::abort();
        ask(*octree);
    }
    return 0;
}
