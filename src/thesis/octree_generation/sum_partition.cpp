#include "thesis/octree_generation/sum_partition.h"

#include "thesis/octree_generation/convex_cell.h"

#include <algorithm>
#include <limits>
#include <optional>
#include <utility>

namespace proxima {

using detail::ConvexCell;
using detail::PolygonCorners;

namespace {

/// What a leaf of n facets costs: all for a point inside, half of them for one outside; cells that
/// hold boundary are about half inside.
double leaf_cost(std::size_t n)
{
    return n == 0 ? 0 : (3 * static_cast<double>(n) + 1) / 4;
}

/// The axis of a normal that is parallel to one.
std::optional<int> parallel_axis(const Vec3& normal)
{
    for (int axis = 0; axis < 3; ++axis)
        if (normal[(axis + 1) % 3] == 0 && normal[(axis + 2) % 3] == 0) return axis;
    return std::nullopt;
}

} // namespace

/// Splits cells from the bounding box on.
class PartitionBuilder {
    /// The part of a facet in a cell.
    struct Piece {
        std::uint32_t facet = 0;
        PolygonCorners corners;
    };

public:
    PartitionBuilder(const MinkowskiSum& sum, const PartitionOptions& options) : options_(options)
    {
        for (std::uint32_t vertex = 0; vertex < sum.point_count(); ++vertex)
            partition_.bounds_.extend(sum.position(vertex));
        const double size = partition_.bounds_.extent().maxCoeff();
        const double reach = partition_.bounds_.lower.cwiseAbs()
                                 .cwiseMax(partition_.bounds_.upper.cwiseAbs())
                                 .maxCoeff();
        tolerance_ = 1e-10 * size + 1e-14 * reach;
        for (std::uint32_t facet = 0; facet < sum.facet_count(); ++facet) {
            partition_.planes_.push_back(sum.half_space(facet));
            // The box's own planes are compared before any other.
            if (parallel_axis(partition_.planes_.back().normal)) continue;
            Piece piece = {facet, {}};
            for (const std::uint32_t vertex : sum.facet_loop(facet))
                piece.corners.push_back(sum.position(vertex));
            all_.push_back(std::move(piece));
        }
    }

    [[nodiscard]] SumPartition run()
    {
        const ConvexCell cell(partition_.bounds_);
        volume_ = cell.volume();
        partition_.root_ = all_.empty() ? SumPartition::inside : grow(cell, std::move(all_), 0);
        return std::move(partition_);
    }

private:
    using Child = SumPartition::Child;

    /// A plane to split a cell by, and what that promises.
    struct Candidate {
        HalfSpace plane;
        std::optional<std::uint32_t> facet;
        double cost = std::numeric_limits<double>::infinity();
    };

    [[nodiscard]] Child grow(const ConvexCell& cell, std::vector<Piece> pieces, int depth)
    {
        partition_.depth_ = std::max(partition_.depth_, depth);
        const double volume = cell.volume();
        const double cost_of_leaf = leaf_cost(pieces.size());
        // A split costs at least one evaluation.
        const auto saving = [&](double cost) { return (cost_of_leaf - cost) * volume / volume_; };
        if (depth == options_.max_depth || !(saving(1) > options_.min_saving))
            return add_leaf(std::move(pieces));
        const Candidate best = best_split(cell, volume, pieces);
        if (!(saving(best.cost) > options_.min_saving)) return add_leaf(std::move(pieces));

        const auto index = static_cast<Child>(partition_.splits_.size());
        partition_.splits_.push_back({best.plane, parallel_axis(best.plane.normal).value_or(-1),
                                      SumPartition::outside, SumPartition::outside});
        const Child within = grow_part(cell, pieces, best, best.plane, depth + 1);
        partition_.splits_[static_cast<std::size_t>(index)].within = within;
        if (!best.facet) {
            const Child beyond =
                grow_part(cell, pieces, best, detail::opposite(best.plane), depth + 1);
            partition_.splits_[static_cast<std::size_t>(index)].beyond = beyond;
        }
        return index;
    }

    [[nodiscard]] Child grow_part(const ConvexCell& cell, const std::vector<Piece>& pieces,
                                  const Candidate& split, const HalfSpace& half_space, int depth)
    {
        const ConvexCell part = cell.within(half_space);
        if (part.is_empty()) return SumPartition::outside;
        std::vector<Piece> kept;
        for (const Piece& piece : pieces) {
            if (split.facet == piece.facet) continue;
            PolygonCorners corners = detail::clipped(piece.corners, widened(half_space));
            if (!corners.empty()) kept.push_back({piece.facet, std::move(corners)});
        }
        if (kept.empty()) return is_inside(part.middle(), pieces, split);
        return grow(part, std::move(kept), depth);
    }

    [[nodiscard]] HalfSpace widened(const HalfSpace& half_space) const
    {
        return {half_space.normal, half_space.offset + tolerance_};
    }

    /// Where a part of a cell that no facet meets lies: the cell's facets tell of all its points.
    [[nodiscard]] Child is_inside(const Vec3& point, const std::vector<Piece>& pieces,
                                  const Candidate& split) const
    {
        const bool inside = std::ranges::all_of(pieces, [&](const Piece& piece) {
            return split.facet == piece.facet ||
                   detail::distance_beyond(partition_.planes_[piece.facet], point) <= 0;
        });
        return inside ? SumPartition::inside : SumPartition::outside;
    }

    [[nodiscard]] Child add_leaf(std::vector<Piece> pieces)
    {
        // Large pieces decide most points.
        std::ranges::stable_sort(pieces, [](const Piece& a, const Piece& b) {
            return detail::area(a.corners) > detail::area(b.corners);
        });
        const auto first = static_cast<std::uint32_t>(partition_.references_.size());
        for (const Piece& piece : pieces) partition_.references_.push_back(piece.facet);
        partition_.leaves_.push_back({first, static_cast<std::uint32_t>(pieces.size())});
        return SumPartition::first_leaf - static_cast<Child>(partition_.leaves_.size() - 1);
    }

    [[nodiscard]] Candidate best_split(const ConvexCell& cell, double volume,
                                       const std::vector<Piece>& pieces) const
    {
        Candidate best;
        const auto offer = [&](Candidate candidate) {
            candidate.cost = cost(cell, volume, pieces, candidate);
            if (candidate.cost < best.cost) best = candidate;
        };
        for (const std::size_t i : largest(pieces))
            offer({partition_.planes_[pieces[i].facet], pieces[i].facet});
        const Box bounds = cell.bounds();
        for (int axis = 0; axis < 3; ++axis) {
            for (const double offset : offsets(bounds, pieces, axis))
                offer({{Vec3::Unit(axis), offset}, std::nullopt});
        }
        return best;
    }

    /// Expected evaluations with the split and two leaves.
    [[nodiscard]] double cost(const ConvexCell& cell, double volume,
                              const std::vector<Piece>& pieces, const Candidate& candidate) const
    {
        const double within = cell.volume_within(candidate.plane) / volume;
        if (candidate.facet) return 1 + within * leaf_cost(pieces.size() - 1);
        std::size_t count_within = 0;
        std::size_t count_beyond = 0;
        for (const Piece& piece : pieces) {
            bool is_within = false;
            bool is_beyond = false;
            for (const Vec3& corner : piece.corners) {
                const double distance = detail::distance_beyond(candidate.plane, corner);
                is_within = is_within || distance <= tolerance_;
                is_beyond = is_beyond || distance >= -tolerance_;
            }
            count_within += is_within ? 1 : 0;
            count_beyond += is_beyond ? 1 : 0;
        }
        return 1 + within * leaf_cost(count_within) + (1 - within) * leaf_cost(count_beyond);
    }

    /// The pieces whose facets' planes are tried.
    [[nodiscard]] static std::vector<std::size_t> largest(const std::vector<Piece>& pieces)
    {
        std::vector<std::pair<double, std::size_t>> order;
        for (std::size_t i = 0; i < pieces.size(); ++i)
            order.emplace_back(-detail::area(pieces[i].corners), i);
        const std::size_t count = pieces.size() > many ? few_tried : order.size();
        std::ranges::partial_sort(order, order.begin() + static_cast<std::ptrdiff_t>(count));
        std::vector<std::size_t> result;
        for (std::size_t i = 0; i < count; ++i) result.push_back(order[i].second);
        return result;
    }

    /// Where an axis is tried: at even steps and, of few pieces, just beside some of their corners,
    /// where few facets are enough on one side.
    [[nodiscard]] std::vector<double> offsets(const Box& bounds, const std::vector<Piece>& pieces,
                                              int axis) const
    {
        const double lower = bounds.lower[axis];
        const double upper = bounds.upper[axis];
        std::vector<double> result;
        for (std::size_t step = 1; step < few_tried; ++step)
            result.push_back(lower + (upper - lower) * static_cast<double>(step) / few_tried);
        if (pieces.size() > many) return result;
        std::vector<double> corners;
        for (const Piece& piece : pieces)
            for (const Vec3& corner : piece.corners) corners.push_back(corner[axis]);
        std::ranges::sort(corners);
        const auto is_close = [&](double a, double b) { return b - a <= 4 * tolerance_; };
        corners.erase(std::unique(corners.begin(), corners.end(), is_close), corners.end());
        const std::size_t stride = corners.size() / max_corners_tried + 1;
        for (std::size_t i = 0; i < corners.size(); i += stride) {
            for (const double offset : {corners[i] - 3 * tolerance_, corners[i] + 3 * tolerance_})
                if (offset > lower && offset < upper) result.push_back(offset);
        }
        return result;
    }

    static constexpr std::size_t many = 17; ///< pieces; above only few splits are tried
    static constexpr std::size_t few_tried = 4;
    static constexpr std::size_t max_corners_tried = 8; ///< per axis

    PartitionOptions options_;
    SumPartition partition_;
    std::vector<Piece> all_;
    double tolerance_ = 0;
    double volume_ = 0; ///< of the bounding box
};

template <class Count>
bool SumPartition::find(const Vec3& point, Count count) const noexcept
{
    for (int axis = 0; axis < 3; ++axis) {
        count.comparison();
        if (!(point[axis] >= bounds_.lower[axis])) return false;
        count.comparison();
        if (!(point[axis] <= bounds_.upper[axis])) return false;
    }
    Child at = root_;
    while (at >= 0) {
        const Split& split = splits_[static_cast<std::size_t>(at)];
        bool is_within = false;
        if (split.axis >= 0) { // facets' own planes of this kind are the box's, so these face up
            count.comparison();
            is_within = point[split.axis] <= split.plane.offset;
        } else {
            count.dot_product();
            is_within = split.plane.normal.dot(point) <= split.plane.offset;
        }
        at = is_within ? split.within : split.beyond;
    }
    if (at == outside || at == inside) return at == inside;
    const Leaf& leaf = leaves_[static_cast<std::size_t>(first_leaf - at)];
    for (const std::uint32_t facet : std::span(references_).subspan(leaf.first, leaf.count)) {
        count.dot_product();
        if (!(planes_[facet].normal.dot(point) <= planes_[facet].offset)) return false;
    }
    return true;
}

namespace {

struct CountNothing {
    void comparison() const noexcept {}
    void dot_product() const noexcept {}
};

struct CountAll {
    PartitionEvaluations* evaluations;

    void comparison() const noexcept { ++evaluations->comparisons; }
    void dot_product() const noexcept { ++evaluations->dot_products; }
};

} // namespace

bool SumPartition::contains(const Vec3& point) const noexcept
{
    return find(point, CountNothing());
}

bool SumPartition::contains(const Vec3& point, PartitionEvaluations& evaluations) const noexcept
{
    return find(point, CountAll{&evaluations});
}

Result<SumPartition> partition_sum(const MinkowskiSum& sum, const PartitionOptions& options)
{
    if (!sum.is_bounded()) {
        return fail(ErrorCode::invalid_argument,
                    "The sum is unbounded; only bounded ones can be partitioned.");
    }
    if (sum.dimension() != 3) {
        return fail(ErrorCode::invalid_argument,
                    "The sum is flat; only ones with a volume can be partitioned.");
    }
    return PartitionBuilder(sum, options).run();
}

} // namespace proxima
