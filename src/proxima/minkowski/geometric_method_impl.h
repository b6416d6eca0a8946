// How planes are pushed, for callers of push_planes and form_edge_normals with polyhedra of their
// own; geometric_method.h explains it (thesis 3.2.1).
#pragma once

#include "proxima/minkowski/geometric_method.h"

namespace proxima {
namespace detail {

/// The vertices most extreme along one direction, with all that rounding cannot tell from them.
template <std::size_t MaxVertices, class Scalar>
class ExtremeVertices {
public:
    ExtremeVertices(const Scalar& product, double tie_tolerance) noexcept
        : tie_tolerance_(tie_tolerance)
    {
        restart(product, 0);
    }

    void offer(const Scalar& product, int vertex) noexcept
    {
        if (product > tie_above_) {
            restart(product, vertex);
        } else if (product >= tie_below_) {
            list_[count_++] = vertex;
            if (product > offset_) raise(product, vertex);
        }
    }

    [[nodiscard]] const Scalar& offset() const noexcept { return offset_; }
    [[nodiscard]] int support() const noexcept { return support_; }
    [[nodiscard]] std::span<const int> list() const noexcept { return {list_.data(), count_}; }

private:
    void restart(const Scalar& product, int vertex) noexcept
    {
        list_[0] = vertex;
        count_ = 1;
        raise(product, vertex);
    }
    void raise(const Scalar& product, int vertex) noexcept
    {
        offset_ = product;
        support_ = vertex;
        tie_above_ = Scalar(to_double(product) + tie_tolerance_);
        tie_below_ = Scalar(to_double(product) - tie_tolerance_);
    }

    double tie_tolerance_;
    Scalar offset_;
    Scalar tie_above_;
    Scalar tie_below_;
    int support_ = 0;
    std::array<int, MaxVertices> list_;
    std::size_t count_ = 0;
};

/// Collects directions and tells when two of them are not parallel.
template <class Scalar>
class DirectionSpan {
public:
    /// True once the directions given span a plane.
    [[nodiscard]] bool add(const Vector3<Scalar>& direction) noexcept
    {
        if (is_zero(direction)) return false;
        if (!has_first_) {
            first_ = direction;
            has_first_ = true;
            return false;
        }
        return !is_zero(cross(first_, direction));
    }

private:
    [[nodiscard]] static bool is_zero(const Vector3<Scalar>& vector) noexcept
    {
        return vector.x() == Scalar(0) && vector.y() == Scalar(0) && vector.z() == Scalar(0);
    }

    Vector3<Scalar> first_ = Vector3<Scalar>::Zero();
    bool has_first_ = false;
};

/// Whether listed vertices are three or more and not collinear. Directions of A come first: where A
/// is a cube they are exact, and so is then the answer, unless products underflow.
template <class Scalar>
[[nodiscard]] bool spans_facet(const SumVertices<Scalar>& vertices,
                               std::span<const int> list) noexcept
{
    if (list.size() < 3) return false;
    const auto size_a = vertices.a.size();
    const auto index_a = [&](int k) { return static_cast<std::size_t>(k) % size_a; };
    const auto index_b = [&](int k) { return static_cast<std::size_t>(k) / size_a; };
    const std::size_t first_a = index_a(list[0]);
    const std::size_t first_b = index_b(list[0]);
    DirectionSpan<Scalar> span;
    for (const int k : list) {
        const std::size_t i = index_a(k);
        if (i != first_a && span.add(vertices.a[i] - vertices.a[first_a])) return true;
    }
    for (const int k : list) {
        const std::size_t j = index_b(k);
        if (j != first_b && span.add(vertices.b[j] - vertices.b[first_b])) return true;
    }
    return false;
}

} // namespace detail

template <class Scalar>
void form_edge_normals(std::span<const Vector3<Scalar>> edges_a,
                       std::span<const Vector3<Scalar>> edges_b,
                       std::span<CandidateNormal<Scalar>> normals) noexcept
{
    const auto plain = [](const Vector3<Scalar>& v) {
        return Vec3(to_double(v.x()), to_double(v.y()), to_double(v.z()));
    };
    std::size_t next = 0;
    for (const Vector3<Scalar>& edge_a : edges_a) {
        for (const Vector3<Scalar>& edge_b : edges_b) {
            normals[next++] = {cross(edge_a, edge_b), cross_magnitude(plain(edge_a), plain(edge_b)),
                               NormalSource::edge_pair};
        }
    }
}

template <std::size_t MaxVertices, class Scalar>
int push_planes(const SumVertices<Scalar>& vertices,
                std::span<const CandidateNormal<Scalar>> normals,
                std::span<SupportPlane<Scalar>> planes) noexcept
{
    Vec3 reach = Vec3::Zero();
    for (const Vector3<Scalar>& vertex : vertices.sums) {
        for (int axis = 0; axis < 3; ++axis) {
            const double coordinate = to_double(vertex[axis]);
            if (coordinate > reach[axis]) reach[axis] = coordinate;
            if (-coordinate > reach[axis]) reach[axis] = -coordinate;
        }
    }
    int count = 0;
    for (const CandidateNormal<Scalar>& candidate : normals) {
        if (candidate.magnitude == Vec3::Zero()) continue;
        const Vector3<Scalar>& normal = candidate.direction;
        // Each product is off by less than 8 roundings of its largest terms, two by less than 16.
        const double tie_tolerance = 32 * unit_roundoff * candidate.magnitude.dot(reach);

        const Scalar first = dot(vertices.sums[0], normal);
        detail::ExtremeVertices<MaxVertices, Scalar> maximal(first, tie_tolerance);
        detail::ExtremeVertices<MaxVertices, Scalar> minimal(-first, tie_tolerance);
        for (std::size_t j = 1; j < vertices.sums.size(); ++j) {
            const Scalar product = dot(vertices.sums[j], normal);
            maximal.offer(product, static_cast<int>(j));
            minimal.offer(-product, static_cast<int>(j));
        }
        const auto is_facet = [&](std::span<const int> list) {
            return candidate.source == NormalSource::face || detail::spans_facet(vertices, list);
        };
        if (is_facet(maximal.list())) {
            planes[static_cast<std::size_t>(count++)] = {normal, maximal.offset(),
                                                         candidate.magnitude, maximal.support()};
        }
        if (is_facet(minimal.list())) {
            planes[static_cast<std::size_t>(count++)] = {-normal, minimal.offset(),
                                                         candidate.magnitude, minimal.support()};
        }
    }
    return count;
}

} // namespace proxima
