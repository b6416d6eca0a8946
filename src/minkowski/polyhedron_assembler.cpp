#include "minkowski/polyhedron_assembler.h"

#include "base/check.h"
#include "minkowski/facet_edges.h"

#include <algorithm>

namespace proxima {

using detail::HullTriangle;
using detail::HullVertices;

namespace {

constexpr std::uint32_t no_group = no_facet;

/// Follows the border of a group of triangles: the border edge after edge `side` of `triangle`.
struct BorderEdge {
    std::uint32_t triangle;
    std::size_t side;
    friend bool operator==(const BorderEdge&, const BorderEdge&) = default;
};

} // namespace

ConvexPolyhedron PolyhedronAssembler::line(const HullVertices& vertices,
                                           std::span<const std::uint32_t> extreme)
{
    PolyhedronAssembler assembler(vertices);
    assembler.keep_vertices({extreme.begin(), extreme.end()});
    ConvexPolyhedron& result = assembler.result_;
    result.dimension_ = static_cast<int>(extreme.size()) - 1;
    if (result.dimension_ == 1) result.edges_ = {{0, 1, no_facet, no_facet}};
    assembler.gather_stars();
    return std::move(assembler.result_);
}

ConvexPolyhedron PolyhedronAssembler::polygon(const HullVertices& vertices,
                                              std::span<const std::uint32_t> loop)
{
    PolyhedronAssembler assembler(vertices);
    std::vector<std::uint32_t> extreme(loop.begin(), loop.end());
    assembler.append_loop(extreme);
    std::ranges::reverse(extreme);
    assembler.append_loop(extreme);
    std::ranges::sort(extreme);
    assembler.keep_vertices(std::move(extreme));
    assembler.keep_loops();
    assembler.result_.dimension_ = 2;
    return std::move(assembler.result_);
}

ConvexPolyhedron PolyhedronAssembler::body(const HullVertices& vertices,
                                           std::span<const HullTriangle> triangles)
{
    PolyhedronAssembler assembler(vertices);
    assembler.merge_triangles(triangles);
    std::vector<std::uint32_t> extreme;
    for (std::uint32_t v = 0; v < vertices.coordinates.size(); ++v) {
        if (assembler.is_extreme(v)) extreme.push_back(v);
    }
    assembler.keep_vertices(std::move(extreme));
    assembler.keep_loops();
    assembler.result_.dimension_ = 3;
    return std::move(assembler.result_);
}

std::vector<std::uint32_t>
PolyhedronAssembler::base_of_pyramid(const HullVertices& vertices,
                                     std::span<const HullTriangle> triangles, std::uint32_t apex)
{
    PolyhedronAssembler assembler(vertices);
    assembler.merge_triangles(triangles);
    std::vector<std::uint32_t> loop;
    for (std::size_t f = 0; f + 1 < assembler.loop_first_.size(); ++f) {
        const auto begin = assembler.loop_vertices_.begin();
        loop.assign(begin + assembler.loop_first_[f], begin + assembler.loop_first_[f + 1]);
        if (std::ranges::find(loop, apex) == loop.end()) break;
    }
    const bool a_pyramid_has_a_base = !loop.empty() && std::ranges::find(loop, apex) == loop.end();
    PROXIMA_CHECK(a_pyramid_has_a_base);
    return loop;
}

void PolyhedronAssembler::append_loop(std::span<const std::uint32_t> loop)
{
    loop_vertices_.insert(loop_vertices_.end(), loop.begin(), loop.end());
    loop_first_.push_back(static_cast<std::uint32_t>(loop_vertices_.size()));
}

bool PolyhedronAssembler::is_extreme(std::uint32_t vertex) const
{
    return groups_of_vertex_[vertex][2] != no_group;
}

void PolyhedronAssembler::find_groups(std::span<const HullTriangle> triangles)
{
    group_.assign(triangles.size(), no_group);
    std::vector<std::uint32_t> front;
    std::uint32_t groups = 0;
    for (std::uint32_t first = 0; first < triangles.size(); ++first) {
        if (group_[first] != no_group) continue;
        group_[first] = groups;
        front = {first};
        while (!front.empty()) {
            const HullTriangle& triangle = triangles[front.back()];
            front.pop_back();
            for (const std::uint32_t neighbour : triangle.neighbours) {
                if (group_[neighbour] != no_group) continue;
                const auto& corners = triangles[neighbour].vertices;
                const bool coplanar = std::ranges::all_of(corners, [&](std::uint32_t corner) {
                    return std::ranges::find(triangle.vertices, corner) !=
                               triangle.vertices.end() ||
                           detail::hull_side(input_, triangle.vertices, corner) == 0;
                });
                if (!coplanar) continue;
                group_[neighbour] = groups;
                front.push_back(neighbour);
            }
        }
        ++groups;
    }
    groups_of_vertex_.assign(input_.coordinates.size(), {no_group, no_group, no_group});
    for (std::size_t t = 0; t < triangles.size(); ++t) {
        for (const std::uint32_t vertex : triangles[t].vertices) {
            for (std::uint32_t& group : groups_of_vertex_[vertex]) {
                if (group == no_group) group = group_[t];
                if (group == group_[t]) break;
            }
        }
    }
}

void PolyhedronAssembler::merge_triangles(std::span<const HullTriangle> triangles)
{
    find_groups(triangles);
    const auto is_border = [&](const BorderEdge& edge) {
        return group_[triangles[edge.triangle].neighbours[edge.side]] != group_[edge.triangle];
    };
    const auto next_border = [&](BorderEdge edge) {
        const std::uint32_t turning = triangles[edge.triangle].vertices[(edge.side + 1) % 3];
        edge.side = (edge.side + 1) % 3;
        while (!is_border(edge)) {
            edge.triangle = triangles[edge.triangle].neighbours[edge.side];
            const auto& corners = triangles[edge.triangle].vertices;
            edge.side =
                static_cast<std::size_t>(std::ranges::find(corners, turning) - corners.begin());
        }
        return edge;
    };
    std::vector<bool> done; // groups, which are numbered by first triangle
    std::vector<std::uint32_t> loop;
    for (std::uint32_t t = 0; t < triangles.size(); ++t) {
        if (group_[t] < done.size() && done[group_[t]]) continue;
        for (std::size_t side = 0; side < 3; ++side) {
            const BorderEdge first = {t, side};
            if (!is_border(first)) continue;
            done.resize(std::max<std::size_t>(done.size(), group_[t] + 1));
            done[group_[t]] = true;
            loop.clear();
            BorderEdge edge = first;
            do {
                const std::uint32_t vertex = triangles[edge.triangle].vertices[edge.side];
                if (is_extreme(vertex)) loop.push_back(vertex);
                edge = next_border(edge);
            } while (edge != first);
            const bool at_infinity = std::ranges::all_of(
                loop, [&](std::uint32_t vertex) { return input_.is_ray(vertex); });
            if (!at_infinity) append_loop(loop);
            break;
        }
    }
}

void PolyhedronAssembler::keep_vertices(std::vector<std::uint32_t> extreme)
{
    result_.vertices_.reserve(extreme.size());
    for (const std::uint32_t vertex : extreme) {
        result_.vertices_.push_back(input_.coordinates[vertex]);
        if (!input_.is_ray(vertex)) ++result_.point_count_;
    }
    std::vector<std::uint32_t> number(input_.coordinates.size(), no_group);
    for (std::uint32_t i = 0; i < extreme.size(); ++i) number[extreme[i]] = i;
    for (std::uint32_t& vertex : loop_vertices_) vertex = number[vertex];
}

void PolyhedronAssembler::keep_loops()
{
    result_.loops_ = std::move(loop_vertices_);
    keep_facets();
    result_.edges_ = detail::edges_of_loops(
        {loop_first_, result_.loops_, result_.point_count_, result_.vertices_.size()});
    gather_stars();
}

void PolyhedronAssembler::keep_facets()
{
    const ConvexPolyhedron& polyhedron = result_;
    result_.facets_.resize(loop_first_.size() - 1);
    for (std::size_t f = 0; f < result_.facets_.size(); ++f) {
        ConvexPolyhedron::Facet& facet = result_.facets_[f];
        facet.first = loop_first_[f];
        facet.size = loop_first_[f + 1] - loop_first_[f];
        const auto loop = polyhedron.facet_loop(static_cast<std::uint32_t>(f));
        // Corners that are far apart give the normal precision. The first must be a point.
        std::size_t start = 0;
        while (polyhedron.is_ray(loop[start])) ++start;
        const std::size_t size = loop.size();
        facet.corners = {loop[start], loop[(start + size / 3) % size],
                         loop[(start + 2 * size / 3) % size]};
        const auto factors = polyhedron.normal_factors(static_cast<std::uint32_t>(f));
        const Vec3 u = factors.u.rounded();
        const Vec3 v = factors.v.rounded();
        facet.normal = u.cross(v);
        facet.tolerance = detail::normal_tolerance(u, v);
    }
}

void PolyhedronAssembler::gather_stars()
{
    std::vector<std::uint32_t>& first = result_.star_first_;
    first.assign(result_.vertices_.size() + 1, 0);
    for (const PolyhedronEdge& edge : result_.edges_) {
        ++first[edge.from + 1];
        ++first[edge.to + 1];
    }
    for (std::size_t v = 0; v + 1 < first.size(); ++v) first[v + 1] += first[v];
    result_.stars_.resize(first.back());
    std::vector<std::uint32_t> next(first.begin(), first.end() - 1);
    for (std::uint32_t e = 0; e < result_.edges_.size(); ++e) {
        const PolyhedronEdge& edge = result_.edges_[e];
        result_.stars_[next[edge.from]++] = {edge.to, e};
        result_.stars_[next[edge.to]++] = {edge.from, e};
    }
}

} // namespace proxima
