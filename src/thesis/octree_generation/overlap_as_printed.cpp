#include "thesis/octree_generation/overlap_as_printed.h"

#include "octree/build_octree_with.h"
#include "thesis/octree_generation/build_with_test.h"

#include <Eigen/Geometry>

#include <cmath>
#include <span>

namespace proxima {

namespace {

/// At most the 24 sums of vertices.
class VertexList {
public:
    void clear() noexcept { count_ = 0; }
    void add(std::size_t vertex) noexcept { list_[count_++] = static_cast<std::uint8_t>(vertex); }
    [[nodiscard]] std::span<const std::uint8_t> list() const noexcept
    {
        return std::span(list_).first(count_);
    }

private:
    std::array<std::uint8_t, 24> list_{};
    std::size_t count_ = 0;
};

template <class Vector>
bool spans_facet(const std::array<Vector, 24>& sums, std::span<const std::uint8_t> list) noexcept
{
    if (list.size() < 3) return false;
    const Vector along = sums[list[1]] - sums[list[0]];
    for (const std::uint8_t vertex : list.subspan(2)) {
        const Vector other = sums[vertex] - sums[list[0]];
        if (along.cross(other).squaredNorm() > 0) return true;
    }
    return false;
}

} // namespace

template <class Real>
AsPrintedTest<Real>::AsPrintedTest(const Triangle& triangle, const PrintedRules& rules) noexcept
    : rules_(rules)
{
    for (std::size_t i = 0; i < 3; ++i) vertices_[i] = triangle.vertices[i].cast<Real>();
}

template <class Real>
void AsPrintedTest<Real>::push(const Vector& normal, const std::array<Vector, 24>& sums) noexcept
{
    VertexList maximal;
    VertexList minimal;
    Real largest = sums[0].dot(normal);
    Real smallest = largest;
    if (rules_.first_vertex != FirstVertex::in_neither_list) maximal.add(0);
    if (rules_.first_vertex == FirstVertex::in_both_lists) minimal.add(0);
    const Real tolerance = static_cast<Real>(rules_.tie_tolerance);
    for (std::size_t j = 1; j < sums.size(); ++j) {
        const Real product = sums[j].dot(normal);
        bool joined = true;
        if (std::abs(largest - product) <= tolerance) {
            maximal.add(j);
        } else if (largest < product) {
            maximal.clear();
            maximal.add(j);
            largest = product;
        } else {
            joined = false;
        }
        if (joined && rules_.offers == ListOffers::one_list) continue;
        if (std::abs(smallest - product) <= tolerance) {
            minimal.add(j);
        } else if (smallest > product) {
            minimal.clear();
            minimal.add(j);
            smallest = product;
        }
    }
    if (spans_facet(sums, maximal.list()))
        planes_[count_++] = {normal, normal.dot(sums[maximal.list()[0]])};
    if (spans_facet(sums, minimal.list())) {
        const Vector opposite = -normal;
        planes_[count_++] = {opposite, opposite.dot(sums[minimal.list()[0]])};
    }
}

template <class Real>
void AsPrintedTest<Real>::set_half_size(const Vec3& half_size) noexcept
{
    const Vector& half = half_size.cast<Real>();
    std::array<Vector, 24> sums;
    for (std::size_t j = 0; j < 3; ++j) {
        for (std::size_t i = 0; i < 8; ++i) {
            const Vector corner((i & 1U) != 0 ? half.x() : -half.x(),
                                (i & 2U) != 0 ? half.y() : -half.y(),
                                (i & 4U) != 0 ? half.z() : -half.z());
            sums[i + 8 * j] = corner + vertices_[j];
        }
    }
    const std::array<Vector, 3> edges = {vertices_[1] - vertices_[0], vertices_[2] - vertices_[0],
                                         vertices_[2] - vertices_[1]};
    count_ = 0;
    push(edges[0].cross(edges[1]), sums);
    for (int axis = 0; axis < 3; ++axis) push(Vector::Unit(axis), sums);
    for (int axis = 0; axis < 3; ++axis) {
        for (const Vector& edge : edges) push(Vector::Unit(axis).cross(edge), sums);
    }
}

template <class Real>
Overlap AsPrintedTest<Real>::overlap(const Vec3& centre) const noexcept
{
    const Vector& point = centre.cast<Real>();
    for (const Plane& plane : std::span(planes_).first(count_))
        if (plane.normal.dot(point) > plane.offset) return {false, false};
    return {true, false};
}

template class AsPrintedTest<float>;
template class AsPrintedTest<double>;

namespace {

template <class Real>
Result<Octree> build_on(const TriangleMesh& mesh, const PrintedRules& rules,
                        const OctreeOptions& options)
{
    const auto find = [&](const TriangleMesh& checked, const OctreeFrame& frame,
                          const OctreeOptions& used, GrowLimits& limits) {
        return build_with_test<AsPrintedTest<Real>>(
            checked, frame, used, Exactness::rounded, limits,
            [&](const Triangle& triangle) { return AsPrintedTest<Real>(triangle, rules); });
    };
    return build_octree_with(mesh, options,
                             {.method = OverlapMethod::minkowski, .is_exact = false, .find = find});
}

} // namespace

Result<Octree> build_octree_as_printed(const TriangleMesh& mesh, const PrintedRules& rules,
                                       const OctreeOptions& options)
{
    return rules.width == FloatWidth::float_32 ? build_on<float>(mesh, rules, options)
                                               : build_on<double>(mesh, rules, options);
}

} // namespace proxima
