// Walks along the arcs of one Gaussian map through the regions of another.
//
//          .-----w-----.        from the region of v across the edge (v, w), whose facets lie on
//     a ---|--v--x-----|-- b    either side of the arc from a to b, into the region of w; or
//          '-----------'        through a facet's normal that lies on the arc
#pragma once

#include "minkowski/facet_maker.h"
#include "minkowski/facet_sign.h"
#include "minkowski/gaussian_map.h"

#include <algorithm>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

namespace proxima::detail {

/// Walks the arcs of one map ("ours") through the regions of another ("theirs").
template <class Scalar>
class ArcWalk {
public:
    ArcWalk(const ConvexPolyhedron& ours, const ConvexPolyhedron& theirs)
        : ours_(ours), theirs_(theirs)
    {}

    /// An edge with its facets as seen by one who goes from the facet `from` to the facet `to`.
    struct Arc {
        std::uint32_t from;
        std::uint32_t to;
        Displacement along; ///< the edge, with `from` at its left
    };
    [[nodiscard]] Arc arc(const PolyhedronEdge& edge, std::uint32_t from) const
    {
        Displacement along = ours_.direction(edge);
        if (from == edge.left) return {edge.left, edge.right, along};
        std::swap(along.from, along.to);
        return {edge.right, edge.left, along};
    }

    /// Goes along the arc from the face that theirs has at its start. crossing(edge, out) is called
    /// for every edge of theirs whose arc is crossed, until it returns false; out is +1 if the edge
    /// runs the way the walk goes, -1 if against it. Returns the vertex of theirs where the walk
    /// ends. `position` is where to look first in the loop of a facet at the start, and where to look
    /// next time: neighbouring arcs leave by neighbouring vertices.
    template <class Crossing>
    std::uint32_t walk(const Arc& arc, const SupportFace& start, std::size_t& position,
                       Crossing crossing) const
    {
        std::uint32_t at = foremost(arc.to, start, position);
        while (true) {
            const PolyhedronNeighbour* exit = nullptr;
            std::uint32_t through = no_facet;
            for (const PolyhedronNeighbour& next : theirs_.neighbours(at)) {
                const Displacement step = {theirs_.vertex(at), theirs_.vertex(next.vertex)};
                if (normal_sign<Scalar>(ours_, arc.to, step) <= 0) continue;
                const PolyhedronEdge& edge = theirs_.edges()[next.edge];
                const bool forward = edge.from == at;
                const std::uint32_t left = forward ? edge.left : edge.right;
                const std::uint32_t right = forward ? edge.right : edge.left;
                const int left_sign = normal_sign<Scalar>(theirs_, left, arc.along);
                if (left_sign < 0) continue;
                const int right_sign = normal_sign<Scalar>(theirs_, right, arc.along);
                if (right_sign > 0) continue;
                if (left_sign > 0 && right_sign < 0) {
                    if (!crossing(next.edge, forward ? 1 : -1)) return at;
                    exit = &next;
                } else {
                    through = left_sign == 0 ? left : right;
                }
                break;
            }
            if (exit != nullptr) {
                at = exit->vertex;
            } else if (through != no_facet) {
                const auto loop = theirs_.facet_loop(through);
                auto here = static_cast<std::size_t>(std::ranges::find(loop, at) - loop.begin());
                at = foremost(arc.to, {2, at, through}, here);
            } else {
                return at;
            }
        }
    }

private:
    /// The vertex of a face of theirs that is farthest along the normal of our facet: uphill along
    /// the loop from a position in it.
    [[nodiscard]] std::uint32_t foremost(std::uint32_t our_facet, const SupportFace& face,
                                         std::size_t& position) const
    {
        if (face.dimension == 0) return face.vertex;
        const FaceVertices vertices(theirs_, face);
        const auto loop = vertices.view().vertices;
        const auto is_higher = [&](std::size_t from, std::size_t to) {
            const Displacement step = {theirs_.vertex(loop[from]), theirs_.vertex(loop[to])};
            return normal_sign<Scalar>(ours_, our_facet, step) > 0;
        };
        position %= loop.size();
        const auto after = [&](std::size_t i) { return i + 1 == loop.size() ? 0 : i + 1; };
        const auto before = [&](std::size_t i) { return (i == 0 ? loop.size() : i) - 1; };
        while (is_higher(position, after(position))) position = after(position);
        while (is_higher(position, before(position))) position = before(position);
        return loop[position];
    }

    const ConvexPolyhedron& ours_;
    const ConvexPolyhedron& theirs_;
};

/// The edges around each facet, in the order of its loop.
class FacetGraph {
public:
    explicit FacetGraph(const ConvexPolyhedron& polyhedron)
        : first_(polyhedron.facet_count() + 1, 0), edges_(2 * polyhedron.edges().size())
    {
        for (const PolyhedronEdge& edge : polyhedron.edges()) {
            ++first_[edge.left + 1];
            ++first_[edge.right + 1];
        }
        for (std::size_t f = 0; f + 1 < first_.size(); ++f) first_[f + 1] += first_[f];
        std::vector<std::uint32_t> next(first_.begin(), first_.end() - 1);
        for (std::uint32_t e = 0; e < polyhedron.edges().size(); ++e) {
            edges_[next[polyhedron.edges()[e].left]++] = e;
            edges_[next[polyhedron.edges()[e].right]++] = e;
        }
        std::vector<std::uint32_t> position(polyhedron.vertex_count(), 0);
        for (std::uint32_t f = 0; f < polyhedron.facet_count(); ++f) {
            const auto loop = polyhedron.facet_loop(f);
            if (loop.size() <= 4) continue; // no matter
            for (std::uint32_t i = 0; i < loop.size(); ++i) position[loop[i]] = i;
            const auto start_of = [&](std::uint32_t e) {
                const PolyhedronEdge& edge = polyhedron.edges()[e];
                return position[edge.left == f ? edge.from : edge.to];
            };
            std::ranges::sort(edges_.begin() + first_[f], edges_.begin() + first_[f + 1], {},
                              start_of);
        }
    }

    [[nodiscard]] std::span<const std::uint32_t> edges(std::uint32_t facet) const noexcept
    {
        return std::span(edges_).subspan(first_[facet], first_[facet + 1] - first_[facet]);
    }

private:
    std::vector<std::uint32_t> first_;
    std::vector<std::uint32_t> edges_;
};

} // namespace proxima::detail
