#include "index/signs/sign_parts.h"

#include <algorithm>
#include <utility>

namespace proxima {

std::uint64_t SignParts::bytes() const noexcept
{
    return arrays_.rows.size_bytes() + arrays_.sides.size_bytes() +
           arrays_.vertex_sides.size_bytes() + arrays_.vertices.size_bytes() +
           arrays_.edges.size_bytes() + arrays_.edge_lists.size_bytes() +
           arrays_.winding.clusters.size_bytes() + arrays_.winding.order.size_bytes();
}

SignParts SignParts::adopt(const SignArrays& arrays, std::shared_ptr<const void> storage) noexcept
{
    SignParts parts;
    parts.arrays_ = arrays;
    parts.is_local_ = !arrays.sides.empty() &&
                      std::ranges::find(arrays.sides, SurfaceSides::doubtful) == arrays.sides.end();
    parts.storage_ = std::move(storage);
    return parts;
}

} // namespace proxima
