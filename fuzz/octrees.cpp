// Octrees of any triangles: every leaf lists exactly the triangles that touch it. Of closed surfaces,
// a cell without triangles is inner exactly where crossings of a line to far away say so.
#include "base/check.h"
#include "decoded_mesh.h"
#include "octree/check_octree.h"
#include "oracles/exact_winding.h"
#include "proxima/octree.h"

#include <cstddef>
#include <cstdint>
#include <vector>

namespace {

using namespace proxima;

void check_classes(const Octree& octree, const TriangleMesh& mesh)
{
    std::vector<Cell> pending = {octree.root()};
    for (int checked = 0; !pending.empty() && checked < 100;) {
        const Cell cell = pending.back();
        pending.pop_back();
        if (!octree.is_leaf(cell)) {
            for (int octant = 0; octant < 8; ++octant)
                pending.push_back(octree.child(cell, octant));
        } else if (cell.type != CellClass::boundary) {
            const auto winding = oracle::exact_winding(mesh, octree.box(cell).center());
            if (winding) PROXIMA_CHECK_EQ(cell.type == CellClass::inner, *winding >= 1);
            ++checked;
        }
    }
}

} // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size)
{
    fuzz::Bytes bytes({data, size});
    OctreeOptions options;
    const std::uint8_t form = bytes.next();
    const bool is_closed = form % 2 == 1;
    options.threshold = form / 2 % 8;
    options.subdivision = form >= 192 ? Subdivision::uniform : Subdivision::adaptive;
    options.max_depth = form / 16 % 4 + (form >= 192 ? 0 : form / 64);
    options.execution.threads = {1};
    const fuzz::PositionCode code(bytes);
    const TriangleMesh mesh =
        fuzz::decode_mesh(bytes, code, is_closed ? fuzz::Shape::closed : fuzz::Shape::soup);
    const auto octree = build_octree(mesh, options);
    PROXIMA_CHECK(octree.has_value());
    PROXIMA_CHECK(check_octree(*octree, mesh).has_value());
    if (is_closed) check_classes(*octree, mesh);
    return 0;
}
