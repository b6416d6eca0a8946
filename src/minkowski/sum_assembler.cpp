#include "minkowski/sum_assembler.h"

#include "base/check.h"
#include "geometry/exact_predicates.h"
#include "minkowski/facet_edges.h"

#include <algorithm>
#include <bit>

namespace proxima {

namespace {

constexpr std::uint32_t no_number = no_facet;

/// Numbers pairs by first appearance.
class PairNumbers {
public:
    explicit PairNumbers(std::size_t most)
        : slots_(std::bit_ceil(std::max<std::size_t>(2 * most, 16)), Slot{0, no_number}),
          shift_(64 - std::countr_zero(slots_.size()))
    {}

    /// The pair's number, and whether it is new.
    std::pair<std::uint32_t, bool> add(std::uint32_t a, std::uint32_t b)
    {
        const std::uint64_t key = std::uint64_t{a} << 32U | b;
        // Fibonacci hashing [knuth-1998].
        std::size_t position = (key * 0x9E3779B97F4A7C15U) >> static_cast<unsigned>(shift_);
        while (slots_[position].number != no_number) {
            if (slots_[position].key == key) return {slots_[position].number, false};
            position = (position + 1) & (slots_.size() - 1);
        }
        slots_[position] = {key, count_};
        return {count_++, true};
    }

private:
    struct Slot {
        std::uint64_t key;
        std::uint32_t number;
    };
    std::vector<Slot> slots_;
    int shift_;
    std::uint32_t count_ = 0;
};

bool same_direction(const Vec3& p, const Vec3& q)
{
    const Displacement u = {Vec3::Zero(), p};
    const Displacement v = {Vec3::Zero(), q};
    return are_parallel(u, v) && point_same_way(u, v);
}

} // namespace

SumAssembler::SumAssembler(const ConvexPolyhedron& a, const ConvexPolyhedron& b)
    : parts_(std::make_shared<MinkowskiSum::Parts>())
{
    parts_->a = a;
    parts_->b = b;
    parts_->loop_first = {0};
}

void SumAssembler::add_facet(const SumFacet& facet)
{
    const auto first = corners_.begin() + parts_->loop_first.back();
    const auto point = std::find_if(first, corners_.end(), [](const SumCorner& corner) {
        return corner.kind == SumCorner::Kind::point;
    });
    PROXIMA_CHECK(point != corners_.end());
    parts_->facets.push_back(facet);
    parts_->supports.push_back(*point);
    parts_->loop_first.push_back(static_cast<std::uint32_t>(corners_.size()));
}

void SumAssembler::drop_corners()
{
    corners_.resize(parts_->loop_first.back());
}

void SumAssembler::add_half_space(const SumFacet& facet, const SumCorner& support)
{
    drop_corners();
    parts_->facets.push_back(facet);
    parts_->supports.push_back(support);
    parts_->loop_first.push_back(parts_->loop_first.back());
}

void SumAssembler::number_corners()
{
    // A ray of both operands counts as A's.
    const auto in_a = [&](const SumCorner& corner) {
        const auto rays = a().rays();
        const auto found = std::ranges::find_if(
            rays, [&](const Vec3& ray) { return same_direction(ray, b().vertex(corner.b)); });
        if (found == rays.end()) return corner;
        const auto ray = a().points().size() + static_cast<std::size_t>(found - rays.begin());
        return SumCorner{SumCorner::Kind::ray_of_a, static_cast<std::uint32_t>(ray), 0};
    };
    // Every point is a corner of three facets, mostly of four, or of two where the sum is flat.
    PairNumbers points(corners_.size() / 3);
    std::vector<SumCorner> rays;
    std::vector<SumCorner> rays_of_b; // as they count
    const std::size_t points_of_a = a().points().size();
    const std::size_t points_of_b = b().points().size();
    for (std::size_t v = points_of_b; v < b().vertex_count(); ++v)
        rays_of_b.push_back(in_a({SumCorner::Kind::ray_of_b, 0, static_cast<std::uint32_t>(v)}));
    std::vector<std::uint32_t> numbers_a(a().rays().size(), no_number);
    std::vector<std::uint32_t> numbers_b(b().rays().size(), no_number);
    std::vector<std::uint32_t>& loops = parts_->loops;
    loops.resize(corners_.size());
    for (std::size_t i = 0; i < corners_.size(); ++i) {
        SumCorner corner = corners_[i];
        if (corner.kind == SumCorner::Kind::point) {
            const auto [number, is_new] = points.add(corner.a, corner.b);
            if (is_new) parts_->corners.push_back(corner);
            loops[i] = number;
            continue;
        }
        if (corner.kind == SumCorner::Kind::ray_of_b) corner = rays_of_b[corner.b - points_of_b];
        std::uint32_t& number = corner.kind == SumCorner::Kind::ray_of_a
                                    ? numbers_a[corner.a - points_of_a]
                                    : numbers_b[corner.b - points_of_b];
        if (number == no_number) {
            number = static_cast<std::uint32_t>(rays.size());
            rays.push_back(corner);
        }
        loops[i] = no_number - number; // its number from above
    }
    parts_->point_count = parts_->corners.size();
    parts_->corners.insert(parts_->corners.end(), rays.begin(), rays.end());
    const auto first_ray = static_cast<std::uint32_t>(parts_->point_count);
    if (rays.empty()) return;
    for (std::uint32_t& vertex : loops) {
        if (no_number - vertex < rays.size()) vertex = first_ray + (no_number - vertex);
    }
}

MinkowskiSum SumAssembler::finish() &&
{
    PROXIMA_CHECK(!parts_->facets.empty());
    number_corners();
    parts_->edges = detail::edges_of_loops(
        {parts_->loop_first, parts_->loops, parts_->point_count, parts_->corners.size()});
    parts_->dimension = parts_->facets.size() == 2 ? 2 : 3;
    return MinkowskiSum(std::move(parts_));
}

MinkowskiSum SumAssembler::finish_with_line() &&
{
    parts_->holds_line = true;
    parts_->dimension = 3;
    return MinkowskiSum(std::move(parts_));
}

MinkowskiSum SumAssembler::finish_line(const std::vector<SumCorner>& ends) &&
{
    parts_->corners = ends;
    for (const SumCorner& corner : ends) {
        if (corner.kind == SumCorner::Kind::point) ++parts_->point_count;
    }
    parts_->dimension = static_cast<int>(ends.size()) - 1;
    if (parts_->dimension == 1) parts_->edges = {{0, 1, no_facet, no_facet}};
    return MinkowskiSum(std::move(parts_));
}

} // namespace proxima
