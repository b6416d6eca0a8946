#include "thesis/object_intersections/cancellable_cells.h"

#include "base/progress.h"
#include "geometry/triangle_contact.h"
#include "thesis/object_intersections/intersect_octrees.h"

#include <algorithm>
#include <compare>
#include <cstdint>
#include <limits>
#include <span>
#include <utility>

namespace proxima {

namespace {

/// Two leaves that meet, by their records.
struct NodePair {
    std::uint32_t a = 0;
    std::uint32_t b = 0;

    // NOLINTNEXTLINE(modernize-use-nullptr): no pointer is compared
    friend constexpr auto operator<=>(const NodePair&, const NodePair&) = default;
};

/// A triangle of A, and a leaf that lists it.
struct Listing {
    TriangleId triangle{};
    std::uint32_t leaf = 0; ///< among those of A that meet leaves of B

    // NOLINTNEXTLINE(modernize-use-nullptr): no pointer is compared
    friend constexpr auto operator<=>(const Listing&, const Listing&) = default;
};

std::span<const TriangleId> triangles_of(const Octree& octree, std::uint32_t node) noexcept
{
    return octree.triangles(Cell{{}, node, CellClass::boundary});
}

/// Which triangles of B share two leaves that meet with a triangle of A. Takes memory for pairs of
/// leaves and for triangles, never for pairs of triangles, which may be all there are.
class Candidates {
public:
    /// \pre pairs ascend
    Candidates(const Octree& a, const Octree& b, std::vector<NodePair> pairs)
        : b_(b), pairs_(std::move(pairs)), last_seen_by_(b.triangle_count(), none)
    {
        for (std::size_t i = 0; i < pairs_.size(); ++i) {
            if (i > 0 && pairs_[i].a == pairs_[i - 1].a) continue;
            const auto leaf = static_cast<std::uint32_t>(first_pair_.size());
            first_pair_.push_back(i);
            for (const TriangleId id : triangles_of(a, pairs_[i].a))
                listings_.push_back({id, leaf});
        }
        first_pair_.push_back(pairs_.size());
        std::ranges::sort(listings_);
    }

    /// Calls visit(triangle of A, triangles of B) -> Flow, both ascending.
    template <class Visit>
    void visit(Visit&& visit)
    {
        std::vector<TriangleId> found;
        for (std::size_t i = 0; i < listings_.size();) {
            const TriangleId of_a = listings_[i].triangle;
            found.clear();
            for (; i < listings_.size() && listings_[i].triangle == of_a; ++i)
                add_listed_beside(listings_[i], found);
            std::ranges::sort(found);
            if (visit(of_a, found) == Flow::stop) return;
        }
    }

private:
    static constexpr std::uint32_t none = std::numeric_limits<std::uint32_t>::max();

    void add_listed_beside(const Listing& listing, std::vector<TriangleId>& found)
    {
        const std::size_t end = first_pair_[listing.leaf + std::size_t{1}];
        for (std::size_t k = first_pair_[listing.leaf]; k < end; ++k) {
            for (const TriangleId of_b : triangles_of(b_, pairs_[k].b)) {
                // Neighbouring leaves list the same triangles.
                std::uint32_t& seen_by = last_seen_by_[to_index(of_b)];
                if (std::exchange(seen_by, to_index(listing.triangle)) !=
                    to_index(listing.triangle))
                    found.push_back(of_b);
            }
        }
    }

    const Octree& b_;
    std::vector<NodePair> pairs_;
    std::vector<std::size_t> first_pair_; ///< by leaf of A, and one past the last
    std::vector<Listing> listings_;
    std::vector<std::uint32_t> last_seen_by_; ///< by triangle of B: the last of A beside it
};

} // namespace

CellIntersection intersect_by_cells(const MeshCells& a, const MeshCells& b,
                                    const RigidTransform& pose_b)
{
    return intersect_by_cells(a, b, pose_b, nullptr);
}

CellIntersection intersect_by_cells(const MeshCells& a, const MeshCells& b,
                                    const RigidTransform& pose_b, const Progress* progress)
{
    CellIntersection result;
    std::vector<NodePair> pairs;
    result.cell_tests =
        visit_intersecting_leaves(a.octree, b.octree, pose_b, [&](const LeafPair& leaves) {
            pairs.push_back({leaves.a.node, leaves.b.node});
            return is_cancelled(progress) ? Flow::stop : Flow::proceed;
        });
    result.cell_pairs = pairs.size();
    if (is_cancelled(progress)) return result;
    std::ranges::sort(pairs);
    Candidates(a.octree, b.octree, std::move(pairs))
        .visit([&](TriangleId of_a, std::span<const TriangleId> candidates) {
            if (is_cancelled(progress)) return Flow::stop;
            const Triangle triangle = a.mesh.triangle(of_a);
            for (const TriangleId of_b : candidates) {
                if (triangles_meet(triangle, pose_b(b.mesh.triangle(of_b))))
                    result.pairs.push_back({of_a, of_b});
            }
            result.triangle_tests += candidates.size();
            return Flow::proceed;
        });
    return result;
}

} // namespace proxima
