// The triangles of a mesh index whose boxes meet a box.
#pragma once

#include "index/index_parts.h"
#include "index/visit_rows.h"
#include "proxima/geometry.h"
#include "proxima/mesh_index.h"

#include <cstdint>

namespace proxima {

/// Calls visitor(TriangleId, const Triangle&) -> bool for every triangle whose box and `box`, both
/// closed, have a point in common, each once, in no particular order, until it returns false. No
/// allocation, thread safe. About 1 us, and 20 ns per triangle. \pre box is finite or empty
template <class Visitor>
void visit_triangles_in_box(const IndexParts& index, const Box& box, Visitor&& visitor)
{
    if (box.empty()) return;
    // In the index's units: its planes are evaluated here as rays do, up to rounding of floats,
    // which blocks heed; this adds more than that.
    constexpr double slack = 0x1p-20;
    const Vec3 lower = (box.lower - index.center()) * index.scale() - Vec3::Constant(slack);
    const Vec3 upper = (box.upper - index.center()) * index.scale() + Vec3::Constant(slack);
    const auto meets = [](const Box& one, const Box& other) {
        return (one.lower.array() <= other.upper.array()).all() &&
               (other.lower.array() <= one.upper.array()).all();
    };
    visit_rows(
        index,
        [&](const Vec3& below, const Vec3& above) {
            return (below.array() <= upper.array()).all() && (lower.array() <= above.array()).all();
        },
        [&](std::uint32_t row) {
            const Triangle triangle = index.triangle(row);
            return meets(bounding_box(triangle), box) && !visitor(index.id(row), triangle)
                       ? Flow::stop
                       : Flow::proceed;
        });
}

} // namespace proxima
