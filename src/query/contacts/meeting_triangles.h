// Which triangles of a solid meet another one, for questions about small parts of the contact.
#pragma once

#include "geometry/closest_point.h"
#include "geometry/length.h"
#include "proxima/neighbourhood.h"
#include "query/contacts/solid_parts.h"

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

namespace proxima {

/// The triangles of a solid, moved, that meet another one, in the order in which they were added.
class MeetingTriangles {
public:
    /// The solid must outlive it; without a pose it is not moved. No coordinate of the two solids, nor
    /// of the pose's translation, is above `reach`.
    MeetingTriangles(const SolidParts& solid, const std::optional<RigidTransform>& pose,
                     double reach)
        : solid_(solid), pose_(pose), back_(pose ? true_inverse(*pose) : RigidTransform{}),
          rounding_(0x1p-40 * reach), rank_(solid.mesh.triangle_count(), none)
    {}

    /// Once for each pair of triangles that meet.
    void add(TriangleId id)
    {
        std::uint32_t& rank = rank_[to_index(id)];
        if (rank == none) {
            rank = static_cast<std::uint32_t>(met_.size());
            met_.push_back({.id = id});
        }
        ++met_[rank].pairs;
    }

    struct Found {
        std::vector<Triangle> triangles; ///< moved
        std::size_t pairs = 0;           ///< how many these are in
    };
    /// Those no farther from one of the points than `near`. Looks only at triangles close to them.
    [[nodiscard]] Found near_points(std::span<const Vec3> points, double near)
    {
        ++searches_;
        ranks_.clear();
        ranks_.reserve(met_.size()); // visitors must not throw
        const Vec3 reach = Vec3::Constant((1 + 0x1p-20) * near + rounding_);
        for (const Vec3& p : points) {
            const Vec3 there = back_(p);
            const auto visit = [&](TriangleId id) noexcept {
                const std::uint32_t rank = rank_[to_index(id)];
                if (rank == none || met_[rank].found_by == searches_) return Flow::proceed;
                if (length_of(closest_point(moved(id), p).point - p) <= near) {
                    met_[rank].found_by = searches_;
                    ranks_.push_back(rank);
                }
                return Flow::proceed;
            };
            visit_triangles(solid_.index, Box{there - reach, there + reach}, visit);
        }
        std::ranges::sort(ranks_);
        Found found;
        for (const std::uint32_t rank : ranks_) {
            found.triangles.push_back(moved(met_[rank].id));
            found.pairs += met_[rank].pairs;
        }
        return found;
    }

private:
    static constexpr std::uint32_t none = ~std::uint32_t{0};
    struct Met {
        TriangleId id{};
        std::size_t pairs = 0;
        std::size_t found_by = 0; ///< the last search that found it
    };

    [[nodiscard]] Triangle moved(TriangleId id) const noexcept
    {
        const Triangle triangle = solid_.mesh.triangle(id);
        return pose_ ? (*pose_)(triangle) : triangle;
    }

    const SolidParts& solid_;
    std::optional<RigidTransform> pose_;
    RigidTransform back_;
    double rounding_;                 ///< of points that are moved back, and of closest points
    std::vector<std::uint32_t> rank_; ///< by triangle, in met_
    std::vector<Met> met_;
    std::vector<std::uint32_t> ranks_;
    std::size_t searches_ = 0;
};

} // namespace proxima
