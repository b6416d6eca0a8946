#include "proxima/proximity/triangle_row.h"

#include "proxima/geometry/closest_point.h"
#include "proxima/mesh/topology.h"

namespace proxima {

namespace {

/// The side from corner i to corner k, looked at from its vertex with the lower id, so that both
/// its triangles see the same numbers.
struct Side {
    int low = 0;
    int high = 0;
};

template <class Scalar>
Side side_of(const TriangleRow<Scalar>& row, int i) noexcept
{
    const int k = i == 2 ? 0 : i + 1;
    return row.vertices[i] < row.vertices[k] ? Side{i, k} : Side{k, i};
}

/// The inside, where the foot of the perpendicular is strictly within; not otherwise.
template <class Scalar>
void offer_inside(const TriangleRow<Scalar>& row, std::uint32_t rank, const Vec3& p,
                  const std::array<Vec3, 3>& corners, FeatureDistance& best) noexcept
{
    std::array<double, 3> weights{};
    Vec3 difference;
    if (row.thin()) [[unlikely]] {
        const TrianglePoint found = closest_point(Triangle{corners}, p);
        if (found.part != TrianglePart::inside) return;
        weights = found.weights;
        difference = p - found.point;
    } else {
        const Vec3 ab = corners[1] - corners[0];
        const Vec3 ac = corners[2] - corners[0];
        const Vec3 ap = p - corners[0];
        const double bb = ab.dot(ab);
        const double bc = ab.dot(ac);
        const double cc = ac.dot(ac);
        const double inverse = 1 / (bb * cc - bc * bc);
        const double pb = ap.dot(ab);
        const double pc = ap.dot(ac);
        double v = (cc * pb - bc * pc) * inverse;
        double w = (bb * pc - bc * pb) * inverse;
        if (!(v > 0 && w > 0 && v + w < 1)) return;
        // Once more with what is left: the first try may be off by the square of the condition.
        difference = ap - v * ab - w * ac;
        const double left_b = difference.dot(ab);
        const double left_c = difference.dot(ac);
        v += (cc * left_b - bc * left_c) * inverse;
        w += (bb * left_c - bc * left_b) * inverse;
        if (!(v > 0 && w > 0 && v + w < 1)) return;
        difference = ap - v * ab - w * ac;
        weights = {1 - v - w, v, w};
    }
    const FeatureDistance inside{
        difference.squaredNorm(), {FeatureKind::face, row.triangle_id()}, rank, weights};
    if (inside.before(best)) best = inside;
}

} // namespace

template <class Scalar>
FeatureDistance closest_of_row(const TriangleRow<Scalar>& row, std::uint32_t rank,
                               const Vec3& p) noexcept
{
    const std::array<Vec3, 3> corners = {row.corner(0), row.corner(1), row.corner(2)};
    FeatureDistance best;
    for (int i = 0; i < 3; ++i) {
        const auto k = static_cast<std::size_t>(i);
        FeatureDistance vertex{
            (p - corners[k]).squaredNorm(), {FeatureKind::vertex, row.vertices[i]}, rank, {}};
        vertex.weights[k] = 1;
        if (i == 0 || vertex.before(best)) best = vertex;
    }
    for (int i = 0; i < 3; ++i) {
        const Side side = side_of(row, i);
        const Vec3& from = corners[static_cast<std::size_t>(side.low)];
        const Vec3 along = corners[static_cast<std::size_t>(side.high)] - from;
        const Vec3 difference = p - from;
        const double length = along.dot(along);
        const double part = difference.dot(along);
        if (!(part > 0 && part < length)) continue;
        const double t = part / length;
        FeatureDistance edge{
            (difference - t * along).squaredNorm(), {FeatureKind::edge, row.edges[i]}, rank, {}};
        if (!edge.before(best)) continue;
        edge.weights[static_cast<std::size_t>(side.low)] = 1 - t;
        edge.weights[static_cast<std::size_t>(side.high)] = t;
        best = edge;
    }
    offer_inside(row, rank, p, corners, best);
    return best;
}

template FeatureDistance closest_of_row(const TriangleRow<float>& row, std::uint32_t rank,
                                        const Vec3& p) noexcept;
template FeatureDistance closest_of_row(const TriangleRow<double>& row, std::uint32_t rank,
                                        const Vec3& p) noexcept;

} // namespace proxima
