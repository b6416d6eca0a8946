#include "thesis/octree_generation/convex_cell.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace proxima::detail {
namespace {

double tetrahedron(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& d)
{
    return std::abs((b - a).cross(c - a).dot(d - a)) / 6;
}

/// Calls visit for each point where the polygon's sides cross the plane.
template <class Visit>
void visit_crossings(const PolygonCorners& polygon, const HalfSpace& plane, Visit visit)
{
    for (std::size_t i = 0; i < polygon.size(); ++i) {
        const Vec3& from = polygon[i];
        const Vec3& to = polygon[(i + 1) % polygon.size()];
        const double d = distance_beyond(plane, from);
        const double e = distance_beyond(plane, to);
        if (d == 0) visit(from);
        if ((d < 0 && e > 0) || (d > 0 && e < 0)) visit(Vec3(from + d / (d - e) * (to - from)));
    }
}

/// Calls visit for each corner of the part of a convex polygon in the half-space.
template <class Visit>
void visit_clipped(const PolygonCorners& polygon, const HalfSpace& half_space, Visit visit)
{
    double d = distance_beyond(half_space, polygon[0]);
    const double first = d;
    for (std::size_t i = 0; i < polygon.size(); ++i) {
        const bool is_last = i + 1 == polygon.size();
        const Vec3& from = polygon[i];
        const Vec3& to = polygon[is_last ? 0 : i + 1];
        const double e = is_last ? first : distance_beyond(half_space, to);
        if (d <= 0) visit(from);
        if ((d < 0 && e > 0) || (d > 0 && e < 0)) visit(Vec3(from + d / (d - e) * (to - from)));
        d = e;
    }
}

} // namespace

PolygonCorners clipped(const PolygonCorners& polygon, const HalfSpace& half_space)
{
    PolygonCorners result;
    visit_clipped(polygon, half_space, [&](const Vec3& corner) { result.push_back(corner); });
    return result;
}

double area(const PolygonCorners& polygon) noexcept
{
    Vec3 sum = Vec3::Zero();
    for (std::size_t i = 2; i < polygon.size(); ++i)
        sum += (polygon[i - 1] - polygon[0]).cross(polygon[i] - polygon[0]);
    return 0.5 * sum.norm();
}

ConvexCell::ConvexCell(const Box& box)
{
    for (int axis = 0; axis < 3; ++axis) {
        const int u = (axis + 1) % 3;
        const int w = (axis + 2) % 3;
        for (const Vec3& side : {box.lower, box.upper}) {
            PolygonCorners face(4, box.lower);
            for (std::size_t i = 0; i < 4; ++i) {
                face[i][axis] = side[axis];
                face[i][u] = i == 1 || i == 2 ? box.upper[u] : box.lower[u];
                face[i][w] = i >= 2 ? box.upper[w] : box.lower[w];
            }
            faces_.push_back(std::move(face));
        }
    }
}

double ConvexCell::volume() const
{
    if (is_empty()) return 0;
    double sum = 0;
    for (const PolygonCorners& face : faces_) {
        for (std::size_t i = 2; i < face.size(); ++i)
            sum += tetrahedron(face[0], face[i - 1], face[i], faces_[0][0]);
    }
    return sum;
}

double ConvexCell::volume_within(const HalfSpace& half_space) const
{
    // Sums pyramids from an apex on the cut; the cut itself then adds none.
    bool is_beyond = false;
    bool is_cut = false;
    Vec3 apex = Vec3::Zero();
    for (const PolygonCorners& face : faces_) {
        visit_crossings(face, half_space, [&](const Vec3& point) {
            apex = point;
            is_cut = true;
        });
        is_beyond = is_beyond || distance_beyond(half_space, face[0]) > 0;
        if (is_cut) break;
    }
    if (!is_cut) return is_beyond ? 0 : volume();
    double sum = 0;
    for (const PolygonCorners& face : faces_) {
        std::size_t count = 0;
        Vec3 first = Vec3::Zero();
        Vec3 last = Vec3::Zero();
        visit_clipped(face, half_space, [&](const Vec3& corner) {
            if (count == 0) first = corner;
            if (count >= 2) sum += tetrahedron(first, last, corner, apex);
            last = corner;
            ++count;
        });
    }
    return sum;
}

ConvexCell ConvexCell::within(const HalfSpace& half_space) const
{
    ConvexCell result;
    PolygonCorners cut;
    for (const PolygonCorners& face : faces_) {
        PolygonCorners part = clipped(face, half_space);
        if (part.size() >= 3) result.faces_.push_back(std::move(part));
        visit_crossings(face, half_space, [&](const Vec3& point) { cut.push_back(point); });
    }
    if (result.faces_.empty() || cut.size() < 3) return result;
    // The cut's corners in the order of their angles about its middle.
    Vec3 middle = Vec3::Zero();
    for (const Vec3& point : cut) middle += point / static_cast<double>(cut.size());
    const Vec3 u = half_space.normal.unitOrthogonal();
    const Vec3 w = half_space.normal.cross(u);
    const auto angle = [&](const Vec3& point) {
        return std::atan2(w.dot(point - middle), u.dot(point - middle));
    };
    std::ranges::sort(cut, [&](const Vec3& p, const Vec3& q) { return angle(p) < angle(q); });
    result.faces_.push_back(std::move(cut));
    return result;
}

Vec3 ConvexCell::middle() const
{
    // Weighted by area, so that slivers and doubled corners do not pull it to the boundary.
    Vec3 sum = Vec3::Zero();
    double weight = 0;
    for (const PolygonCorners& face : faces_) {
        Vec3 middle = Vec3::Zero();
        for (const Vec3& corner : face) middle += corner / static_cast<double>(face.size());
        const double face_area = area(face);
        sum += face_area * middle;
        weight += face_area;
    }
    return weight > 0 ? Vec3(sum / weight) : faces_[0][0];
}

Box ConvexCell::bounds() const
{
    Box box;
    for (const PolygonCorners& face : faces_)
        for (const Vec3& corner : face) box.extend(corner);
    return box;
}

} // namespace proxima::detail
