// How long parts of a mesh that moves rigidly are sure to stay away from parts of one that stands still.
//
//     n . x     A's part ---|   gap   |--- B's part     a direction n keeps the two apart until B has
//                          top       least              come nearer along n by the gap
//
// Lengths are taken times unit(), a power of two that makes the largest coordinate about 1.
#pragma once

#include "index/index_parts.h"
#include "proxima/geometry.h"
#include "proxima/time_of_contact.h"
#include "query/distance/distance_search.h"

#include <array>
#include <cstdint>
#include <limits>

namespace proxima {

/// B at a time.
struct MovedFrame {
    double time = 0;
    RigidTransform pose;             ///< as pose_at says, not scaled
    Vec3 origin = Vec3::Zero();      ///< where the center of B's index is
    Vec3 turn_center = Vec3::Zero(); ///< about which B turns
};

/// A block of A or B with its slab, along the axes of its own mesh.
struct BoundedBlock {
    Vec3 center = Vec3::Zero(); ///< moved, if it is B's
    Vec3 half = Vec3::Zero();
    Vec3 normal = Vec3::Zero(); ///< of the slab, of length 1; zero where there is none
    double lower = 0;
    double upper = 0;
};

/// A direction of length 1 from A to B, and what B's motion is along it.
struct Along {
    Vec3 direction;
    Vec3 turning; ///< a point at r from the center moves by drift + r . turning a unit of time
    double drift;
    double across; ///< sine of the angle between direction and axis
};

/// Two triangles, B's moved, and from where B turns.
struct MovedTriangles {
    Triangle a;
    Triangle b;
    Vec3 turn_center;
};

class PROXIMA_HIDDEN MotionBounds {
public:
    static constexpr double never = std::numeric_limits<double>::infinity();
    static constexpr double across_error = 0x1p-48; ///< of Along::across, at most
    static constexpr double rigid = 1 + 0x1p-20; ///< the pose may be no rotation by rigid_tolerance

    /// What it is given must outlive it. \pre the indexes are not empty
    MotionBounds(const IndexParts& a, const IndexParts& b, const RigidMotion& motion) noexcept;

    [[nodiscard]] MovedFrame frame_at(double time) const noexcept;
    [[nodiscard]] Along along(const Vec3& direction) const noexcept;

    [[nodiscard]] BoundedBlock block_of_a(const BlockBox& box,
                                          std::uint32_t reference) const noexcept;
    [[nodiscard]] BoundedBlock block_of_b(const BlockBox& box, std::uint32_t reference,
                                          const MovedFrame& frame) const noexcept;
    [[nodiscard]] MovedTriangles triangles(std::uint32_t row_a, std::uint32_t row_b,
                                           const MovedFrame& frame) const noexcept;
    [[nodiscard]] Triangle triangle_of_a(std::uint32_t row) const noexcept;
    [[nodiscard]] Triangle triangle_of_b(std::uint32_t row, const MovedFrame& frame) const noexcept;

    /// How long triangles are sure to be apart along a direction, roundings included. 0 where nothing can
    /// be said.
    [[nodiscard]] double step(const Along& along, const MovedTriangles& pair) const noexcept;

    /// Where a point of B is along the direction: least of now and after a time, less the margin. A
    /// triangle of B whose corners are all above a triangle of A stays so for as long.
    [[nodiscard]] double least_within(const Along& along, const Triangle& b,
                                      const MovedFrame& frame, double within) const noexcept;

    /// Whether B does not move at all.
    [[nodiscard]] bool is_at_rest() const noexcept
    {
        return motion_.displacement.isZero(0) && motion_.turn.isZero(0);
    }
    /// The diagonal of the smaller mesh's box, or of the other one's where that mesh is a point, and
    /// the way of the fastest point over the whole motion: above 0 but where B is at rest, and where
    /// both are points the diagonal is 0.
    [[nodiscard]] double size() const noexcept { return size_; }
    [[nodiscard]] double fastest() const noexcept { return fastest_; }
    /// The time in which the fastest point moves as far as roundings let nothing be said.
    [[nodiscard]] double rounding() const noexcept { return fastest_ > 0 ? margin_ / fastest_ : 1; }
    [[nodiscard]] const IndexParts& a() const noexcept { return a_; }
    [[nodiscard]] const IndexParts& b() const noexcept { return b_; }
    /// Units of indexes A and B.
    [[nodiscard]] double unit_a() const noexcept { return unit_a_; }
    [[nodiscard]] double unit_b() const noexcept { return unit_b_; }
    [[nodiscard]] const Vec3& center_a() const noexcept { return center_a_; }
    [[nodiscard]] const Vec3& displacement() const noexcept { return displacement_; }
    [[nodiscard]] const Vec3& turn() const noexcept { return motion_.turn; }
    [[nodiscard]] const Vec3& axis() const noexcept { return axis_; } ///< of length 1, or 0
    [[nodiscard]] double angle() const noexcept { return angle_; }
    /// By which a gap that is computed may be too large: infinite where boxes do not hold a mesh.
    [[nodiscard]] double margin() const noexcept { return margin_; }

private:
    [[nodiscard]] BoundedBlock block_of(const IndexParts& index, double unit, const BlockBox& box,
                                        std::uint32_t reference) const noexcept;
    [[nodiscard]] Triangle scaled(const Triangle& t) const noexcept
    {
        return {{Vec3(t[0] * unit_), Vec3(t[1] * unit_), Vec3(t[2] * unit_)}};
    }

    const IndexParts& a_;
    const IndexParts& b_;
    const RigidMotion& motion_;
    double angle_;
    Vec3 axis_; ///< of length 1, or 0
    double unit_ = 1;
    double unit_a_ = 1;
    double unit_b_ = 1;
    double margin_ = 0;
    double size_ = 0;
    Vec3 center_a_ = Vec3::Zero();
    Vec3 center_b_ = Vec3::Zero();
    Vec3 displacement_ = Vec3::Zero();
    double fastest_ = 0;
};

} // namespace proxima
