// Facets of a Minkowski sum from those parts of A and B that make them.
#pragma once

#include "base/check.h"
#include "minkowski/face_sum.h"
#include "minkowski/gaussian_map.h"
#include "minkowski/sum_assembler.h"

#include <algorithm>
#include <array>
#include <cstdint>
#include <span>

namespace proxima::detail {

/// The vertices of a face, for FaceView.
class FaceVertices {
public:
    FaceVertices(const ConvexPolyhedron& polyhedron, const SupportFace& face)
        : polyhedron_(polyhedron), face_(face)
    {
        if (face.dimension == 0) ends_[0] = face.vertex;
        if (face.dimension == 1) {
            const PolyhedronEdge& edge = polyhedron.edges()[face.item];
            ends_ = {edge.from, edge.to};
        }
    }

    [[nodiscard]] FaceView view() const
    {
        const auto size = static_cast<std::size_t>(face_.dimension) + 1;
        return {&polyhedron_, face_.dimension == 2 ? polyhedron_.facet_loop(face_.item)
                                                   : std::span(ends_).first(size)};
    }

private:
    const ConvexPolyhedron& polyhedron_;
    SupportFace face_;
    std::array<std::uint32_t, 2> ends_{};
};

/// Sums facets and edges of A and B into the facets of the sum.
class FacetMaker {
public:
    FacetMaker(SumAssembler& sum, bool holds_line) : sum_(sum), holds_line_(holds_line) {}

    /// Facet `facet` of A and B's face along its normal.
    void add_facet_of_a(std::uint32_t facet, const SupportFace& face_b)
    {
        const SumFacet source = face_b.dimension == 2
                                    ? SumFacet{FacetOrigin::both, 1, facet, face_b.item}
                                    : SumFacet{FacetOrigin::a, 1, facet, no_facet};
        add(source, {2, first_point(sum_.a(), sum_.a().facet_loop(facet)), facet}, face_b);
    }

    /// Facet `facet` of B and A's face along its normal, which is no facet.
    void add_facet_of_b(std::uint32_t facet, const SupportFace& face_a)
    {
        add({FacetOrigin::b, 1, no_facet, facet}, face_a,
            {2, first_point(sum_.b(), sum_.b().facet_loop(facet)), facet});
    }

    /// An edge of A swept along one of B; the outward normal is turn (edge a x edge b).
    void add_swept(std::uint32_t edge_a, std::uint32_t edge_b, int turn)
    {
        const PolyhedronEdge& a = sum_.a().edges()[edge_a];
        const PolyhedronEdge& b = sum_.b().edges()[edge_b];
        const SumFacet source = {FacetOrigin::swept, static_cast<std::int8_t>(turn), edge_a,
                                 edge_b};
        if (holds_line_) {
            sum_.add_half_space(source, {SumCorner::Kind::point, a.from, b.from});
            return;
        }
        const bool a_ends = !sum_.a().is_ray(a.to);
        const bool b_ends = !sum_.b().is_ray(b.to);
        auto& corners = sum_.corners();
        const std::size_t begin = corners.size();
        corners.push_back({SumCorner::Kind::point, a.from, b.from});
        corners.push_back(a_ends ? SumCorner{SumCorner::Kind::point, a.to, b.from}
                                 : SumCorner{SumCorner::Kind::ray_of_a, a.to, 0});
        if (a_ends && b_ends) corners.push_back({SumCorner::Kind::point, a.to, b.to});
        corners.push_back(b_ends ? SumCorner{SumCorner::Kind::point, a.from, b.to}
                                 : SumCorner{SumCorner::Kind::ray_of_b, 0, b.to});
        if (turn < 0)
            std::reverse(corners.begin() + static_cast<std::ptrdiff_t>(begin), corners.end());
        sum_.add_facet(source);
    }

private:
    static std::uint32_t first_point(const ConvexPolyhedron& polyhedron,
                                     std::span<const std::uint32_t> loop)
    {
        for (const std::uint32_t vertex : loop) {
            if (!polyhedron.is_ray(vertex)) return vertex;
        }
        return 0;
    }

    void add(const SumFacet& source, const SupportFace& face_a, const SupportFace& face_b)
    {
        if (holds_line_) {
            sum_.add_half_space(source, {SumCorner::Kind::point, face_a.vertex, face_b.vertex});
            return;
        }
        auto& corners = sum_.corners();
        if (face_b.dimension == 0 || face_a.dimension == 0) {
            const bool moves_a = face_b.dimension == 0;
            const auto loop =
                moves_a ? sum_.a().facet_loop(face_a.item) : sum_.b().facet_loop(face_b.item);
            for (const std::uint32_t vertex : loop) {
                if (moves_a) {
                    corners.push_back(
                        sum_.a().is_ray(vertex)
                            ? SumCorner{SumCorner::Kind::ray_of_a, vertex, 0}
                            : SumCorner{SumCorner::Kind::point, vertex, face_b.vertex});
                } else {
                    corners.push_back(
                        sum_.b().is_ray(vertex)
                            ? SumCorner{SumCorner::Kind::ray_of_b, 0, vertex}
                            : SumCorner{SumCorner::Kind::point, face_a.vertex, vertex});
                }
            }
        } else {
            const auto normal = source.origin == FacetOrigin::b ? sum_.b().normal_factors(source.b)
                                                                : sum_.a().normal_factors(source.a);
            const FaceVertices vertices_a(sum_.a(), face_a);
            const FaceVertices vertices_b(sum_.b(), face_b);
            PROXIMA_CHECK(append_face_sum(vertices_a.view(), vertices_b.view(), normal, corners));
        }
        sum_.add_facet(source);
    }

    SumAssembler& sum_;
    bool holds_line_;
};

} // namespace proxima::detail
