// Where triangles meet against CGAL's exact kernel: the same ends, and their places to an ulp or
// two.
#include "geometry/exact_predicates.h"
#include "geometry/triangle_contact.h"
#include "geometry/triangle_intersection.h"

#include <gtest/gtest.h>

#include <CGAL/Exact_predicates_exact_constructions_kernel.h>
#include <CGAL/intersections.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <vector>

namespace proxima::triangle_contact_cgal_test {
namespace {

using Kernel = CGAL::Exact_predicates_exact_constructions_kernel;
using Point = Kernel::Point_3;
using Points = std::vector<Point>;

Point exact(const Vec3& p)
{
    return {p.x(), p.y(), p.z()};
}

Kernel::Triangle_3 exact(const Triangle& t)
{
    return {exact(t[0]), exact(t[1]), exact(t[2])};
}

Kernel::Segment_3 exact_side(const Triangle& t, TrianglePart part)
{
    const int first = number_of(part);
    return {exact(t[first]), exact(t[(first + 1) % 3])};
}

/// The ends of what CGAL finds, each once.
struct Ends {
    Points points;
    void operator()(const Point& p) { points = {p}; }
    void operator()(const Kernel::Segment_3& s) { points = {s.source(), s.target()}; }
    void operator()(const Kernel::Triangle_3& t) { points = {t[0], t[1], t[2]}; }
    void operator()(const Points& polygon) { points = polygon; }
};

template <class Shape, class Other>
Points cgal_ends(const Shape& shape, const Other& other)
{
    Ends ends;
    const auto found = CGAL::intersection(shape, other);
    if (found) boost::apply_visitor([&](const auto& part) { ends(part); }, *found);
    return ends.points;
}

/// A degenerate triangle that is a segment is its first and last corner here.
Points cgal_ends(const Triangle& a, const Triangle& b)
{
    const auto segment = [](const Triangle& t) {
        return Kernel::Segment_3(exact(t[0]), exact(t[2]));
    };
    if (!is_degenerate(a) && !is_degenerate(b)) return cgal_ends(exact(a), exact(b));
    if (!is_degenerate(a)) return cgal_ends(exact(a), segment(b));
    if (!is_degenerate(b)) return cgal_ends(segment(a), exact(b));
    return cgal_ends(segment(a), segment(b));
}

/// The one point that two parts have in common, exactly.
Point exact_point(const Triangle& a, const Triangle& b, const MeetingParts& parts)
{
    if (is_corner(parts.of_a)) return exact(a[number_of(parts.of_a)]);
    if (is_corner(parts.of_b)) return exact(b[number_of(parts.of_b)]);
    Points found;
    if (parts.of_b == TrianglePart::inside) {
        found = cgal_ends(exact_side(a, parts.of_a), exact(b).supporting_plane());
    } else if (parts.of_a == TrianglePart::inside) {
        found = cgal_ends(exact_side(b, parts.of_b), exact(a).supporting_plane());
    } else {
        found = cgal_ends(exact_side(a, parts.of_a), exact_side(b, parts.of_b));
    }
    EXPECT_EQ(found.size(), 1U);
    return found.at(0);
}

class Pairs {
public:
    explicit Pairs(std::uint64_t seed) : random_(seed) {}

    void next(Triangle& a, Triangle& b)
    {
        const double far = below(3) == 0 ? 1000 * number() : 0;
        const double scale = std::pow(10.0, std::uniform_real_distribution(-20.0, 20.0)(random_));
        whole_ = below(3) == 0;
        for (Triangle* t : {&a, &b}) {
            for (Vec3& corner : t->vertices) corner = scale * (point() + Vec3(far, 0, -far));
        }
        const auto midpoint = [](const Vec3& p, const Vec3& q) { return Vec3(0.5 * (p + q)); };
        switch (below(8)) {
        case 0:
            b.vertices[0] = a[1];
            break;
        case 1:
            b.vertices[0] = a[1], b.vertices[2] = a[0];
            break;
        case 2:
            b.vertices[1] = midpoint(a[0], a[2]);
            break;
        case 3: { // in one plane, along an axis
            const int axis = below(3);
            for (int i = 0; i < 3; ++i) {
                a.vertices[static_cast<std::size_t>(i)][axis] =
                    b.vertices[static_cast<std::size_t>(i)][axis] = far;
            }
            break;
        }
        case 4: // a segment, if exactly so
            b.vertices[1] = below(2) == 0 ? b[0] : midpoint(b[0], b[2]);
            break;
        case 5: // all but in one plane
            for (Vec3& corner : b.vertices)
                corner = a[0] + number() * (a[1] - a[0]) + number() * (a[2] - a[0]);
            break;
        default:
            break;
        }
    }

private:
    int below(int count) { return std::uniform_int_distribution<int>(0, count - 1)(random_); }
    double number() { return std::uniform_real_distribution<double>(-1, 1)(random_); }
    Vec3 point()
    {
        if (whole_) return Eigen::Vector3i{below(5), below(5), below(5)}.cast<double>();
        return {number(), number(), number()};
    }

    std::mt19937_64 random_;
    bool whole_ = false;
};

TEST(TriangleIntersectionAgainstCgal, HasTheSameEnds)
{
    constexpr std::uint64_t seed = 31;
    SCOPED_TRACE(::testing::Message() << "seed " << seed);
    Pairs generate(seed);
    std::array<int, 7> sizes{};
    double worst = 0;
    for (int i = 0; i < 20'000; ++i) {
        Triangle a;
        Triangle b;
        generate.next(a, b);
        const auto is_point = [](const Triangle& t) { return t[0] == t[2]; };
        if (is_point(a) || is_point(b)) continue;
        if (is_degenerate(a) && !(exact_side(a, TrianglePart::side_2).has_on(exact(a[1]))))
            continue;
        if (is_degenerate(b) && !(exact_side(b, TrianglePart::side_2).has_on(exact(b[1]))))
            continue;
        const TriangleIntersection found = intersect(a, b);
        ASSERT_EQ(triangles_meet(a, b), !found.empty()) << "case " << i;
        Points expected = cgal_ends(a, b);
        Points ends;
        double size = 0;
        for (const Triangle& t : {a, b}) {
            for (const Vec3& corner : t.vertices)
                size = std::max(size, corner.cwiseAbs().maxCoeff());
        }
        for (const MeetingParts& parts : found.ends()) {
            ends.push_back(exact_point(a, b, parts));
            const Vec3 place = meeting_point(a, b, parts);
            const Point& truth = ends.back();
            for (int axis = 0; axis < 3; ++axis) {
                const double off = CGAL::to_double(Kernel::FT(place[axis]) - truth[axis]);
                worst = std::max(worst, std::abs(off) / size);
            }
        }
        std::sort(expected.begin(), expected.end());
        std::sort(ends.begin(), ends.end());
        ASSERT_EQ(ends, expected) << "case " << i;
        ++sizes.at(ends.size());
    }
    EXPECT_LE(worst, 4 * 0x1p-53);
    // All kinds must have come.
    for (const int count : sizes) EXPECT_GT(count, 20);
}

} // namespace
} // namespace proxima::triangle_contact_cgal_test
