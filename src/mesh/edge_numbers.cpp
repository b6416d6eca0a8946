#include "mesh/edge_numbers.h"

#include "base/grow_buffer.h"
#include "base/progress.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <limits>
#include <span>
#include <unordered_map>
#include <utility>

namespace proxima {

namespace {

constexpr std::uint32_t none = std::numeric_limits<std::uint32_t>::max();
constexpr std::size_t triangles_per_report = 65536;

/// The edges met so far, found by their ends. Those with the same lower vertex are a chain, the
/// latest first: meshes tend to name neighbours soon after each other.
class EdgeTable {
public:
    EdgeTable(std::size_t vertices, std::size_t sides) : heads_(vertices, none)
    {
        links_.resize(sides); // pages that are never written cost nothing
    }

    /// The edge between two vertices, or `added` where it is new: then it is added under that
    /// number. \pre low < high; numbers are added in ascending order from 0 on
    std::uint32_t find_or_add(std::uint32_t low, std::uint32_t high, std::uint32_t added)
    {
        std::uint32_t& head = heads_[low];
        std::size_t length = 0;
        for (std::uint32_t edge = head; edge != none; edge = links_[edge].next) {
            if (links_[edge].high == high) return edge;
            ++length;
        }
        // No longer, so that the time is linear even where all edges meet at one vertex.
        if (length == longest_chain) {
            const std::uint64_t ends = std::uint64_t{low} << 32U | high;
            return beyond_.try_emplace(ends, added).first->second;
        }
        links_[added] = {high, std::exchange(head, added)};
        return added;
    }

private:
    static constexpr std::size_t longest_chain = 32;

    struct Link {
        std::uint32_t high;
        std::uint32_t next; ///< edge of the chain, or none
    };
    struct MixBits {
        std::size_t operator()(std::uint64_t ends) const noexcept
        {
            ends = (ends ^ ends >> 32U) * 0x9E3779B97F4A7C15U;
            return ends ^ ends >> 29U;
        }
    };

    std::vector<std::uint32_t> heads_; ///< by lower vertex
    GrowBuffer<Link> links_;           ///< by edge
    std::unordered_map<std::uint64_t, std::uint32_t, MixBits> beyond_;
};

} // namespace

Result<EdgeNumbers> number_edges(const TriangleMesh& mesh, Progress* progress)
{
    const std::span<const TriangleCorners> triangles = mesh.triangles();
    EdgeTable table(mesh.vertex_count(), 3 * triangles.size());
    EdgeNumbers numbers;
    numbers.triangle_edges.reserve(triangles.size());
    numbers.first_sides.resize(3 * triangles.size() + 1);
    std::uint32_t count = 0;
    for (std::size_t begin = 0; begin < triangles.size(); begin += triangles_per_report) {
        if (is_cancelled(progress)) return cancelled("numbering the edges");
        const std::size_t end = std::min(triangles.size(), begin + triangles_per_report);
        for (std::size_t id = begin; id < end; ++id) {
            std::array<EdgeId, 3> edges{};
            for (std::size_t k = 0; k < 3; ++k) {
                const auto [low, high] =
                    std::minmax(triangles[id][k], triangles[id][k == 2 ? 0 : k + 1]);
                edges[k] = no_edge;
                if (low == high) continue;
                const std::uint32_t edge = table.find_or_add(low, high, count);
                numbers.first_sides[count] = static_cast<std::uint32_t>(3 * id + k);
                count += edge == count ? 1U : 0U;
                edges[k] = EdgeId{edge};
            }
            numbers.triangle_edges.push_back(edges);
        }
        advance_stage(progress, end - begin);
    }
    numbers.first_sides.resize(count);
    numbers.first_sides.shrink_to_fit();
    return numbers;
}

} // namespace proxima
