#include "query/contacts/motion_bounds.h"

#include "geometry/length.h"
#include "index/binary_tree.h"
#include "index/slabs/block_slab.h"

#include <algorithm>
#include <cmath>

namespace proxima {

namespace {

double size_of(const Vec3& v)
{
    return v.cwiseAbs().maxCoeff();
}

/// Whether the root's box holds the mesh, which may be too large for the index's frame.
bool is_in_root(const IndexParts& index)
{
    if (index.scale() > least_index_scale) return true;
    for (std::uint32_t row = 0; row < index.triangle_count(); ++row) {
        for (const Vec3& p : index.triangle(row).vertices)
            if (!(size_of((p - index.center()) * index.scale()) <= 1)) return false;
    }
    return true;
}

/// Corners of the root's box, in the mesh's own coordinates; `unit` is the blocks'. About all triangles
/// where is_in_root() holds.
std::array<Vec3, 8> corners_around(const IndexParts& index, double unit)
{
    const RootBox& box = index.root_box();
    std::array<Vec3, 8> corners;
    for (std::size_t i = 0; i < corners.size(); ++i) {
        for (std::size_t axis = 0; axis < 3; ++axis) {
            const double at = (i >> axis & 1U) != 0 ? box.upper[axis] : box.lower[axis];
            corners[i][static_cast<int>(axis)] = index.center()[static_cast<int>(axis)] + at * unit;
        }
    }
    return corners;
}

double largest_coordinate(const std::array<Vec3, 8>& corners)
{
    double largest = 0;
    for (const Vec3& corner : corners) largest = std::max(largest, size_of(corner));
    return largest;
}

/// The first time s > 0 at which speed s + bend s^2 reaches the gap. \pre gap > 0, bend >= 0
double time_to_close(double gap, double speed, double bend)
{
    const double root = std::sqrt(speed * speed + 4 * bend * gap);
    if (speed > 0) return 2 * gap / (speed + root);
    return bend > 0 ? (root - speed) / (2 * bend) : MotionBounds::never;
}

Vec3 vector_of(const std::array<float, 3>& v)
{
    return {double{v[0]}, double{v[1]}, double{v[2]}};
}

} // namespace

// A point of B at r from the center moves, from time t to t + s, by
//     s (displacement + turn x r) + what is at most s^2 |turn| |turn x r| / 2,
// for the path of r is a circle about the turn's axis: along a direction n at most |n x axis| times that, as
// the circle lies across the axis. It never moves faster than
//     fastest = |displacement| + max |turn x r|,
// and |turn x r| does not change with time. The least of n . p over a box or a triangle after s is that at
// a corner, for all s, and n . p of a corner has its least over a time at one of its ends.
//
// Rounding. u = 2^-53, S the sum of the largest distances from the origin of A's and B's corners as given, of
// the center and its path. Sine and cosine are off by u (1 + 3 angle), R by at most u (32 + 16 angle) as a
// map, moved corners by that much of |p| + |center| and by 8 u S. This counts twice, for the poses
// before and after the step. Distances, projections of corners and of boxes, which are drawn outward by more than
// what their centers and extents as read are off, are off by 32 u S at most, and so
// is the step's own arithmetic. Together less than u S (128 + 32 angle); the margin is twice that. Lengths
// are about 1, so that squares which vanish are of what is far below the margin.
MotionBounds::MotionBounds(const IndexParts& a, const IndexParts& b,
                           const RigidMotion& motion) noexcept
    : a_(a), b_(b), motion_(motion), angle_(length_of(motion.turn)), axis_(unit_of(motion.turn))
{
    const Vec3 start = motion.start(motion.center);
    const double block_unit_a = block_unit(a);
    const double block_unit_b = block_unit(b);
    const auto corners_a = corners_around(a, block_unit_a);
    const auto corners_b = corners_around(b, block_unit_b);
    const double coordinates = size_of(start) + size_of(motion.displacement) +
                               size_of(motion.center) + largest_coordinate(corners_a) +
                               largest_coordinate(corners_b);
    constexpr int most = 1000; // so that 1 / unit is a double, too
    const int exponent = coordinates > 0 ? std::ilogb(coordinates) : 0;
    unit_ = std::ldexp(1.0, std::clamp(-exponent, -most, most));
    constexpr double no_size = 0x1p-200; // far below the margin; half extents keep their signs
    unit_a_ = std::max(no_size, block_unit_a * unit_);
    unit_b_ = std::max(no_size, block_unit_b * unit_);
    center_a_ = a.center() * unit_;
    center_b_ = b.center() * unit_;
    constexpr double root_of_three = 1.7320508075688774; // largest component to length
    margin_ = 0x1p-45 * (1 + angle_ / 4) * root_of_three * (coordinates * unit_);
    if (!is_in_root(a) || !is_in_root(b)) margin_ = never; // boxes prove nothing
    displacement_ = motion.displacement * unit_;
    double turning = 0;
    for (const Vec3& corner : corners_b) {
        const Vec3 arm = motion.start.rotation * ((corner - motion.center) * unit_);
        turning = std::max(turning, length_of(motion.turn.cross(arm)));
    }
    if (is_at_rest()) return;
    constexpr double least = std::numeric_limits<double>::min(); // products may have vanished
    fastest_ = std::max(least, (length_of(displacement_) + turning) * (1 + 0x1p-40));
    const auto diagonal = [&](const std::array<Vec3, 8>& corners) {
        return length_of((corners.back() - corners.front()) * unit_);
    };
    const auto [smaller, larger] = std::minmax({diagonal(corners_a), diagonal(corners_b)});
    size_ = smaller > 0 ? smaller : larger;
}

MovedFrame MotionBounds::frame_at(double time) const noexcept
{
    MovedFrame frame;
    frame.time = time;
    frame.pose = pose_at(motion_, time);
    frame.origin = frame.pose.rotation * center_b_ + frame.pose.translation * unit_;
    frame.turn_center = (motion_.start(motion_.center) + time * motion_.displacement) * unit_;
    return frame;
}

Along MotionBounds::along(const Vec3& direction) const noexcept
{
    // Points turn about the axis, so they are never accelerated along it.
    const double across = std::min(1.0, direction.cross(axis_).norm() + across_error);
    return {direction, direction.cross(motion_.turn), direction.dot(displacement_), across};
}

BoundedBlock MotionBounds::block_of(const IndexParts& index, double unit, const BlockBox& box,
                                    std::uint32_t reference) const noexcept
{
    BoundedBlock block;
    block.center = vector_of(box.center) * unit;
    block.half = vector_of(box.half) * unit;
    if (index.slabs().empty()) return block;
    const SlabNumbers slab = read_slab(index.slabs()[reference & ~index_leaf_bit]);
    const Vec3 normal = vector_of(slab.normal);
    const double length = normal.norm();
    if (!(length > 0)) return block;
    const double reach = normal.cwiseAbs().dot(block.half) / length;
    block.normal = normal / length;
    block.lower = reach * double{slab.lower};
    block.upper = reach * double{slab.upper};
    return block;
}

BoundedBlock MotionBounds::block_of_a(const BlockBox& box, std::uint32_t reference) const noexcept
{
    BoundedBlock block = block_of(a_, unit_a_, box, reference);
    block.center += center_a_;
    return block;
}

BoundedBlock MotionBounds::block_of_b(const BlockBox& box, std::uint32_t reference,
                                      const MovedFrame& frame) const noexcept
{
    BoundedBlock block = block_of(b_, unit_b_, box, reference);
    block.center = frame.origin + frame.pose.rotation * block.center;
    return block;
}

Triangle MotionBounds::triangle_of_a(std::uint32_t row) const noexcept
{
    return scaled(a_.triangle(row));
}

Triangle MotionBounds::triangle_of_b(std::uint32_t row, const MovedFrame& frame) const noexcept
{
    return scaled(frame.pose(b_.triangle(row)));
}

MovedTriangles MotionBounds::triangles(std::uint32_t row_a, std::uint32_t row_b,
                                       const MovedFrame& frame) const noexcept
{
    return {triangle_of_a(row_a), triangle_of_b(row_b, frame), frame.turn_center};
}

double MotionBounds::step(const Along& along, const MovedTriangles& pair) const noexcept
{
    double top = -never;
    for (const Vec3& p : pair.a.vertices) top = std::max(top, along.direction.dot(p));
    double least = never;
    for (const Vec3& p : pair.b.vertices) {
        const double gap = along.direction.dot(p) - top - margin_;
        if (!(gap > 0)) return 0;
        const Vec3 arm = p - pair.turn_center;
        const double bend = along.across * 0.5 * angle_ * motion_.turn.cross(arm).norm();
        least = std::min(least, time_to_close(gap, -along.drift - along.turning.dot(arm), bend));
    }
    return least;
}

double MotionBounds::least_within(const Along& along, const Triangle& b, const MovedFrame& frame,
                                  double within) const noexcept
{
    double least = never;
    for (const Vec3& p : b.vertices) {
        const Vec3 arm = p - frame.turn_center;
        const double height = along.direction.dot(p);
        const double bend = along.across * 0.5 * angle_ * motion_.turn.cross(arm).norm();
        const double nearer = within * (within * bend - along.drift - along.turning.dot(arm));
        least = std::min({least, height, height - nearer});
    }
    return least - margin_;
}

} // namespace proxima
