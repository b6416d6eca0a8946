// The far field. With R from a cluster's centre to the eye, s from the centre to a point of the
// surface and n its normal, the solid angle is minus the integral of n . grad_s 1/|R - s|, and
//
//     n . grad_s 1/|R - s| =  n.R / R^3                                          order 1
//                          + (3 (s.R)(n.R) - (s.n) R^2) / R^5                    order 2
//                          + (15 (s.R)^2 (n.R) - ... ) / (2 R^7)                 order 3
//                          + ...
//
// where order l is the gradient of the solid harmonic s^l P_l / R^(l+1), at most l s^(l-1) /
// R^(l+1) long, because P_n^2 + (1 - x^2) P_n'^2 / (n (n + 1)) <= 1. Orders 4 and up thus sum to at
// most (s^3 / R^5) (4 - 3t) / (1 - t)^2 with t = s / R, and with radius r >= s the integral is at
// most
//
//     r (integral of s^2) / R^5 * (4 - 3t) / (1 - t)^2,   t = r / R.
//
// Only symmetric trace-free parts of the moments matter: derivatives of 1/R are such tensors.
#include "octree/winding_number.h"

#include "base/parallel.h"
#include "base/progress.h"
#include "mesh/triangle_order.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <span>

namespace proxima {

namespace {

constexpr std::uint32_t leaf_triangles = 16;

// Moments, built from triangles and moved from child to parent centres.

/// Indices of xx yy zz xy xz yz, and of xxx yyy zzz xxy xxz xyy yyz xzz yzz xyz.
using Quadrupole = std::array<double, 6>;
using Octupole = std::array<double, 10>;

/// Adds sym(a b).
void add_product(Quadrupole& q, const Vec3& a, const Vec3& b) noexcept
{
    q[0] += a[0] * b[0];
    q[1] += a[1] * b[1];
    q[2] += a[2] * b[2];
    q[3] += 0.5 * (a[0] * b[1] + a[1] * b[0]);
    q[4] += 0.5 * (a[0] * b[2] + a[2] * b[0]);
    q[5] += 0.5 * (a[1] * b[2] + a[2] * b[1]);
}

/// Adds weight sym(q a).
void add_product(Octupole& o, const Quadrupole& q, const Vec3& a, double weight) noexcept
{
    const Vec3 b = weight * a;
    const Vec3 third = b / 3.0;
    o[0] += q[0] * b[0];
    o[1] += q[1] * b[1];
    o[2] += q[2] * b[2];
    o[3] += third[1] * q[0] + 2.0 * third[0] * q[3];
    o[4] += third[2] * q[0] + 2.0 * third[0] * q[4];
    o[5] += third[0] * q[1] + 2.0 * third[1] * q[3];
    o[6] += third[2] * q[1] + 2.0 * third[1] * q[5];
    o[7] += third[0] * q[2] + 2.0 * third[2] * q[4];
    o[8] += third[1] * q[2] + 2.0 * third[2] * q[5];
    o[9] += third[0] * q[5] + third[1] * q[4] + third[2] * q[3];
}

void remove_traces(WindingCluster& cluster) noexcept
{
    Quadrupole& q = cluster.quadrupole;
    const double mean = (q[0] + q[1] + q[2]) / 3.0;
    for (std::size_t i = 0; i < 3; ++i) q[i] -= mean;
    Octupole& o = cluster.octupole;
    const Vec3 trace(o[0] + o[5] + o[7], o[1] + o[3] + o[8], o[2] + o[4] + o[6]);
    add_product(o, {1.0, 1.0, 1.0, 0.0, 0.0, 0.0}, trace, -0.6);
}

/// The data of a cluster that is needed only while its parents are made.
struct Extent {
    Box box;             ///< in the mesh's coordinates
    double area = 0.0;   ///< in units, as below
    double second = 0.0; ///< integral of squared distances to the centre
};

Eigen::Map<Vec3> vector_in(std::array<double, 3>& numbers) noexcept
{
    return Eigen::Map<Vec3>(numbers.data());
}
Vec3 vector_of(const std::array<double, 3>& numbers) noexcept
{
    return Vec3(numbers.data());
}

/// Moments of one leaf from its triangles.
void fill_leaf(WindingCluster& cluster, Extent& extent, const TriangleMesh& mesh,
               std::span<const std::uint32_t> ids, double unit) noexcept
{
    Vec3 weighted = Vec3::Zero();
    const Vec3 origin = mesh.triangle(TriangleId{ids.front()})[0];
    for (const std::uint32_t id : ids) {
        const Triangle triangle = mesh.triangle(TriangleId{id});
        for (const Vec3& vertex : triangle.vertices) extent.box.extend(vertex);
        const Vec3 a = (triangle[1] - triangle[0]) * unit;
        const Vec3 b = (triangle[2] - triangle[0]) * unit;
        const double area = 0.5 * a.cross(b).norm();
        const Vec3 centroid = (triangle[0] - origin) * unit + (a + b) / 3.0;
        extent.area += area;
        weighted += area * centroid;
    }
    const Vec3 center =
        extent.area > 0.0 ? Vec3(origin + weighted / (extent.area * unit)) : extent.box.center();
    vector_in(cluster.center) = center;
    for (const std::uint32_t id : ids) {
        const Triangle triangle = mesh.triangle(TriangleId{id});
        std::array<Vec3, 3> s;
        for (std::size_t i = 0; i < 3; ++i) {
            s[i] = (triangle.vertices[i] - center) * unit;
            cluster.radius = std::max(cluster.radius, s[i].norm());
        }
        const Vec3 normal = 0.5 * (s[1] - s[0]).cross(s[2] - s[0]);
        const Vec3 sum = s[0] + s[1] + s[2];
        vector_in(cluster.dipole) += normal;
        add_product(cluster.quadrupole, sum / 3.0, normal);
        Quadrupole squares{}; // mean of s s over the triangle
        for (const Vec3& corner : s) add_product(squares, corner, corner / 12.0);
        add_product(squares, sum, sum / 12.0);
        add_product(cluster.octupole, squares, normal, 1.0);
        extent.second += normal.norm() * (squares[0] + squares[1] + squares[2]);
    }
    remove_traces(cluster);
}

/// Adds a child's moments to its parent's, whose centre is known.
void add_child(WindingCluster& parent, Extent& extent, const WindingCluster& child,
               const Extent& child_extent, double unit) noexcept
{
    const Vec3 shift = (vector_of(child.center) - vector_of(parent.center)) * unit;
    const Vec3 dipole = vector_of(child.dipole);
    vector_in(parent.dipole) += dipole;
    for (std::size_t i = 0; i < 6; ++i) parent.quadrupole[i] += child.quadrupole[i];
    add_product(parent.quadrupole, shift, dipole);
    for (std::size_t i = 0; i < 10; ++i) parent.octupole[i] += child.octupole[i];
    add_product(parent.octupole, child.quadrupole, shift, 2.0);
    Quadrupole squares{};
    add_product(squares, shift, shift);
    add_product(parent.octupole, squares, dipole, 1.0);
    parent.radius = std::max(parent.radius, child.radius + shift.norm());
    extent.second += child_extent.second + child_extent.area * shift.squaredNorm();
}

void fill_parent(WindingCluster& parent, Extent& extent, const WindingCluster& left,
                 const Extent& left_extent, const WindingCluster& right, const Extent& right_extent,
                 double unit) noexcept
{
    extent.area = left_extent.area + right_extent.area;
    extent.box = left_extent.box;
    extent.box.extend(right_extent.box.lower);
    extent.box.extend(right_extent.box.upper);
    const double part = extent.area > 0.0 ? right_extent.area / extent.area : 0.5;
    const Vec3 from = vector_of(left.center);
    const Vec3 center = from + part * (vector_of(right.center) - from);
    vector_in(parent.center) = center;
    add_child(parent, extent, left, left_extent, unit);
    add_child(parent, extent, right, right_extent, unit);
    const Vec3 corner = (center - extent.box.lower).cwiseMax(extent.box.upper - center);
    parent.radius = std::min(parent.radius, (corner * unit).norm());
    remove_traces(parent);
}

// Topology: halves of Morton ranges, cut where the codes' highest bit changes.

/// Appends the cluster of items [begin, end) and all below it, parents first.
void append_clusters(std::vector<WindingCluster>& clusters, std::span<const KeyedIndex> items,
                     std::uint32_t begin, std::uint32_t end)
{
    const std::size_t self = clusters.size();
    clusters.emplace_back();
    clusters[self].first = begin;
    clusters[self].count = end - begin;
    if (end - begin > leaf_triangles) {
        std::uint32_t middle = begin + (end - begin) / 2;
        const std::uint64_t difference = items[begin].key ^ items[end - 1].key;
        if (difference != 0) {
            const std::uint64_t bit = std::bit_floor(difference);
            const auto split = std::partition_point(
                items.begin() + begin, items.begin() + end,
                [bit](const KeyedIndex& item) { return (item.key & bit) == 0; });
            middle = static_cast<std::uint32_t>(split - items.begin());
        }
        append_clusters(clusters, items, begin, middle);
        append_clusters(clusters, items, middle, end);
    }
    clusters[self].next = static_cast<std::uint32_t>(clusters.size());
}

/// The power of two that brings lengths near `size` to about 1.
double unit_for(double size) noexcept
{
    if (!(size > 0.0)) return 1.0;
    return std::ldexp(1.0, std::clamp(-std::ilogb(size), -1000, 1000));
}

/// The triangles by id, as the search of clusters takes them.
auto triangles_of(const TriangleMesh& mesh) noexcept
{
    return [&mesh](std::uint32_t id) { return mesh.triangle(TriangleId{id}); };
}

} // namespace

Result<WindingNumber> build_winding_number(const TriangleMesh& mesh, const WindingOptions& options)
{
    if (const auto status = checked_bounding_box(mesh); !status) {
        return tl::unexpected<Error>(status.error());
    }
    const Box bounds = bounding_box(mesh);
    if (!bounds.extent().allFinite()) {
        return fail(ErrorCode::invalid_mesh, "the mesh is too large for its extent to be a number");
    }
    WindingNumber winding;
    winding.mesh_ = &mesh;
    auto& [clusters, order, unit] = winding.storage_;
    unit = unit_for(bounds.extent().maxCoeff());
    {
        const auto items =
            triangle_order(mesh, bounds, SpaceCurve::morton, options.execution.progress);
        if (!items) return cancelled("building the winding number");
        order.reserve(items->size());
        for (const KeyedIndex& item : *items) order.push_back(item.index);
        append_clusters(clusters, *items, 0, static_cast<std::uint32_t>(items->size()));
    }
    begin_stage(options.execution.progress, "winding number", mesh.triangle_count());
    const WindingClusters view = winding.clusters();
    std::vector<Extent> extents(clusters.size());
    constexpr std::size_t chunk = 256;
    parallel_chunks(clusters.size(), chunk, options.execution.threads,
                    [&, &made = clusters](std::size_t first, std::size_t end) {
                        if (is_cancelled(options.execution.progress)) return;
                        for (std::size_t i = first; i < end; ++i) {
                            if (!view.is_leaf(i)) continue;
                            fill_leaf(made[i], extents[i], mesh,
                                      view.order.subspan(made[i].first, made[i].count), view.unit);
                            advance_stage(options.execution.progress, made[i].count);
                        }
                    });
    if (is_cancelled(options.execution.progress)) return cancelled("building the winding number");
    for (std::size_t i = clusters.size(); i-- > 0;) {
        if (!view.is_leaf(i)) {
            const std::size_t left = i + 1;
            const std::size_t right = clusters[left].next;
            fill_parent(clusters[i], extents[i], clusters[left], extents[left], clusters[right],
                        extents[right], view.unit);
        }
    }
    for (std::size_t i = 0; i < clusters.size(); ++i) {
        constexpr double outward = 1.0 + 1e-9; // rounding of the bound itself
        clusters[i].radius *= outward;
        clusters[i].remainder =
            outward * winding::inverse_sphere * clusters[i].radius * extents[i].second;
    }
    return winding;
}

WindingEstimate winding_number(const WindingNumber& of, const Vec3& point, double accuracy) noexcept
{
    const auto triangle_at = triangles_of(of.mesh());
    double tolerance = accuracy / 16.0;
    while (tolerance > winding::rounding_error) {
        const WindingEstimate found =
            winding::estimate(of.clusters(), triangle_at, point, tolerance);
        if (found.error <= accuracy) return found;
        tolerance /= 16.0;
    }
    return winding::estimate(of.clusters(), triangle_at, point, 0.0);
}

bool is_inside(const WindingNumber& of, const Vec3& point) noexcept
{
    return is_inside(of.clusters(), triangles_of(of.mesh()), point);
}

bool is_inside_but_for(const WindingNumber& caps, const Vec3& point, int whole) noexcept
{
    return winding::exceeds(caps.clusters(), triangles_of(caps.mesh()), point, -1.0,
                            static_cast<double>(whole));
}

double brute_winding_number(const TriangleMesh& mesh, const Vec3& point) noexcept
{
    const double unit = unit_for(bounding_box(mesh).extent().maxCoeff());
    SolidAngleSum sum;
    for (std::size_t i = 0; i < mesh.triangle_count(); ++i)
        sum.add(mesh.triangle(TriangleId{static_cast<std::uint32_t>(i)}), point, unit);
    return sum.winding();
}

bool brute_is_inside(const TriangleMesh& mesh, const Vec3& point) noexcept
{
    return brute_winding_number(mesh, point) >= winding::inside_limit;
}

} // namespace proxima
