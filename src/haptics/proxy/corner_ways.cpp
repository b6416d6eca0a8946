#include "haptics/proxy/corner_ways.h"

#include "geometry/closest_point.h"
#include "haptics/surface/swept_sphere.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

namespace proxima {

namespace {

constexpr std::size_t most_faces = 12;
constexpr std::size_t most_triangles = 64; ///< that a way may come near

/// How much ways rise from their faces.
constexpr double lift = 0x1p-9;

/// How near a way comes to triangles, in gaps.
constexpr double least_room = 0.125;
/// The part of that which rounding may take: a gap is at least 16 times as thick as a skin.
constexpr double rounding_part = 0.25;

double distance_to(const Triangle& triangle, const Vec3& p) noexcept
{
    return (p - closest_point(triangle, p).point).norm();
}

/// A triangle and its distance from p.
struct CornerTriangle {
    Triangle corners;
    double distance = 0;
    TriangleId id{};
};

/// Triangles that ways may meet, the nearest first: they end most ways.
class CornerTriangles {
public:
    /// False where there are too many.
    bool add(const ContactTriangle& triangle, const Vec3& p, double gap) noexcept
    {
        const double distance = distance_to(triangle.corners, p);
        if (distance > (corner_way + 2) * gap) return true;
        if (count_ == triangles_.size()) return false;
        triangles_[count_++] = {triangle.corners, distance, triangle.id};
        return true;
    }
    void sort() noexcept
    {
        std::sort(triangles_.begin(), triangles_.begin() + static_cast<std::ptrdiff_t>(count_),
                  [](const CornerTriangle& a, const CornerTriangle& b) {
                      return a.distance != b.distance ? a.distance < b.distance : a.id < b.id;
                  });
    }
    [[nodiscard]] std::span<const CornerTriangle> all() const noexcept
    {
        return std::span(triangles_).first(count_);
    }

private:
    std::array<CornerTriangle, most_triangles> triangles_;
    std::size_t count_ = 0;
};

/// Normals to the side of p of the faces at a corner, those that share a plane once.
class CornerFaces {
public:
    /// False where there are too many.
    bool add(const Triangle& triangle, const Vec3& p) noexcept
    {
        const Vec3 upward = unit_normal(triangle);
        const Vec3 normal = upward.dot(p - triangle[0]) < 0 ? Vec3(-upward) : upward;
        const auto is_same = [&](const Vec3& other) { return normal.dot(other) > 1 - 1e-12; };
        if (normal.isZero() || std::ranges::any_of(normals(), is_same)) return true;
        if (count_ == normals_.size()) return false;
        normals_[count_++] = normal;
        return true;
    }
    [[nodiscard]] std::span<const Vec3> normals() const noexcept
    {
        return std::span(normals_).first(count_);
    }

private:
    std::array<Vec3, most_faces> normals_;
    std::size_t count_ = 0;
};

/// The best way so far.
class BestWay {
public:
    BestWay(std::span<const CornerTriangle> near, Vec3 p, Vec3 towards, double least,
            double gap) noexcept
        : near_(near), p_(std::move(p)), towards_(std::move(towards)), cosine_(least), gap_(gap)
    {}

    void offer(const Vec3& way) noexcept
    {
        const double length = way.norm();
        if (!(length > 1e-6)) return;
        const double cosine = way.dot(towards_) / length;
        if (!(cosine > cosine_)) return;
        const Vec3 motion = way * (corner_way * gap_ / length);
        if (!is_free(motion)) return;
        cosine_ = cosine;
        motion_ = motion;
    }
    [[nodiscard]] const std::optional<Vec3>& motion() const noexcept { return motion_; }

private:
    [[nodiscard]] bool is_free(const Vec3& motion) const noexcept
    {
        const auto is_met = [&](const CornerTriangle& near) {
            const double least = least_room * gap_;
            return touch_time(near.corners, least, p_, motion, rounding_part * least).has_value();
        };
        const auto is_close = [&](const CornerTriangle& near) {
            return !(distance_to(near.corners, p_ + motion) > gap_);
        };
        return std::ranges::none_of(near_, is_met) && std::ranges::none_of(near_, is_close);
    }

    std::span<const CornerTriangle> near_;
    Vec3 p_;
    Vec3 towards_;
    double cosine_;
    double gap_;
    std::optional<Vec3> motion_;
};

} // namespace

std::optional<Vec3> way_from_corner(std::span<const ContactTriangle> near, const Vec3& p,
                                    const Vec3& towards, double least, double gap) noexcept
{
    CornerTriangles triangles;
    for (const ContactTriangle& one : near)
        if (!triangles.add(one, p, gap)) return std::nullopt;
    triangles.sort();
    CornerFaces faces;
    for (const CornerTriangle& one : triangles.all())
        if (one.distance <= corner_size * gap && !faces.add(one.corners, p)) return std::nullopt;
    BestWay best(triangles.all(), p, towards, least, gap);
    const std::span<const Vec3> normals = faces.normals();
    if (normals.size() <= 3) return std::nullopt; // a corner of a room
    for (std::size_t i = 0; i < normals.size(); ++i) {
        const Vec3& n = normals[i];
        best.offer(towards - towards.dot(n) * n + lift * n);
        for (std::size_t k = 0; k < i; ++k) {
            const Vec3 line = n.cross(normals[k]);
            const double length = line.norm();
            if (!(length > 1e-6)) continue;
            best.offer(line / (line.dot(towards) < 0 ? -length : length) + lift * (n + normals[k]));
        }
    }
    return best.motion();
}

} // namespace proxima
