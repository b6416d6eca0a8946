#include "proxima/topology.h"

#include "base/memory_budget.h"
#include "base/parallel.h"
#include "base/progress.h"
#include "base/text.h"

#include <algorithm>

namespace proxima {

namespace {

// Side k of triangle t is number 3 t + k; the sides of an edge are found by its lower vertex.
using Side = std::uint32_t;
constexpr Side no_side = std::numeric_limits<Side>::max();

constexpr std::size_t vertices_per_task = 4096;
constexpr std::size_t topology_task = 16384;
constexpr std::uint64_t topology_stages = 5;

std::size_t task_count(std::size_t items, std::size_t per_task) noexcept
{
    return (items + per_task - 1) / per_task;
}

std::uint32_t corner_after(const TriangleCorners& corners, std::size_t corner) noexcept
{
    return corners[corner == 2 ? 0 : corner + 1];
}

// Rows of a variable length: `for_each(visit)` calls visit(row, item) twice over, in the same
// order; items keep that order within their row.
template <class Item, class ForEach>
void fill_rows(std::size_t rows, const ForEach& for_each, std::vector<std::uint32_t>& first,
               std::vector<Item>& items)
{
    first.assign(rows + 1, 0);
    for_each([&](std::size_t row, Item) { ++first[row]; });
    std::uint32_t total = 0;
    for (std::uint32_t& entry : first) {
        const std::uint32_t count = entry;
        entry = total;
        total += count;
    }
    items.resize(total);
    for_each([&](std::size_t row, Item item) { items[first[row]++] = item; });
    std::shift_right(first.begin(), first.end(), 1);
    first[0] = 0;
}

// The lowest side of the same edge, for all sides whose lower vertex is given.
class SideMatcher {
public:
    explicit SideMatcher(std::span<Side> first_sides) : first_sides_(first_sides) {}

    void match(std::uint32_t vertex, std::span<const TriangleId> star,
               std::span<const TriangleCorners> triangles)
    {
        found_.clear();
        for (const TriangleId triangle : star) {
            const TriangleCorners& corners = triangles[index(triangle)];
            for (std::size_t k = 0; k < 3; ++k) {
                const auto [low, high] = std::minmax({corners[k], corner_after(corners, k)});
                const Side side = 3 * index(triangle) + static_cast<Side>(k);
                if (low != vertex) continue;
                if (low == high) {
                    first_sides_[side] = no_side;
                } else {
                    found_.push_back({high, side});
                }
            }
        }
        if (found_.size() <= short_list) {
            search_short();
        } else {
            search_sorted();
        }
    }

private:
    struct Found {
        std::uint32_t high;
        Side side;
        friend bool operator<(const Found& a, const Found& b) noexcept
        {
            return a.high != b.high ? a.high < b.high : a.side < b.side;
        }
    };
    static constexpr std::size_t short_list = 24;

    void search_short() noexcept
    {
        for (const Found& each : found_) {
            const auto first = std::find_if(found_.begin(), found_.end(), [&](const Found& other) {
                return other.high == each.high;
            });
            first_sides_[each.side] = first->side;
        }
    }

    void search_sorted()
    {
        std::sort(found_.begin(), found_.end());
        Found first = found_.front();
        for (const Found& each : found_) {
            if (each.high != first.high) first = each;
            first_sides_[each.side] = first.side;
        }
    }

    std::span<Side> first_sides_;
    std::vector<Found> found_;
};

} // namespace

// The steps of build_topology, in the order of their calls there.
class TopologyBuilder {
public:
    TopologyBuilder(const TriangleMesh& mesh, const TopologyOptions& options)
        : mesh_(mesh), options_(options)
    {
        topology_.vertex_count_ = mesh.vertex_count();
    }

    [[nodiscard]] Status check_limits() const
    {
        if (mesh_.triangle_count() > max_topology_triangles) {
            return fail(ErrorCode::limit_exceeded,
                        concat("a topology has at most ", max_topology_triangles,
                               " triangles, this mesh has ", mesh_.triangle_count()));
        }
        return check_bytes(0);
    }

    void list_stars()
    {
        const std::span<const TriangleCorners> triangles = mesh_.triangles();
        fill_rows(
            mesh_.vertex_count(),
            [&](auto&& visit) {
                for (std::uint32_t triangle = 0; triangle < triangles.size(); ++triangle) {
                    const auto [a, b, c] = triangles[triangle];
                    visit(a, TriangleId{triangle});
                    if (b != a) visit(b, TriangleId{triangle});
                    if (c != a && c != b) visit(c, TriangleId{triangle});
                }
            },
            topology_.star_first_, topology_.star_triangles_);
        advance();
    }

    void match_sides()
    {
        first_sides_.resize(3 * mesh_.triangle_count());
        parallel_for(
            task_count(mesh_.vertex_count(), vertices_per_task), options_.execution.threads,
            [&](std::size_t task) {
                if (is_cancelled(options_.execution.progress)) return;
                SideMatcher matcher(first_sides_);
                const std::size_t begin = task * vertices_per_task;
                const std::size_t end = std::min(begin + vertices_per_task, mesh_.vertex_count());
                for (std::size_t vertex = begin; vertex < end; ++vertex) {
                    const auto id = static_cast<std::uint32_t>(vertex);
                    matcher.match(id, topology_.triangles(VertexId{id}), mesh_.triangles());
                }
            });
        advance();
    }

    // Edges get their numbers where their first side stands.
    Status number_edges()
    {
        const std::size_t tasks = task_count(first_sides_.size(), 3 * topology_task);
        std::vector<std::uint32_t> first_edge(tasks + 1, 0);
        parallel_for(tasks, options_.execution.threads, [&](std::size_t task) {
            std::uint32_t count = 0;
            for_sides(task, [&](Side side) { count += first_sides_[side] == side ? 1U : 0U; });
            first_edge[task + 1] = count;
        });
        for (std::size_t task = 0; task < tasks; ++task) first_edge[task + 1] += first_edge[task];

        const std::size_t edges = first_edge.back();
        if (Status fits = check_bytes(edges); !fits) return fits;
        topology_.edge_vertices_.resize(edges);
        topology_.triangle_edges_.resize(mesh_.triangle_count());
        parallel_for(tasks, options_.execution.threads, [&](std::size_t task) {
            std::uint32_t next = first_edge[task];
            for_sides(task, [&](Side side) {
                if (first_sides_[side] != side) return;
                const TriangleCorners& corners = mesh_.triangles()[side / 3];
                const auto [low, high] =
                    std::minmax({corners[side % 3], corner_after(corners, side % 3)});
                topology_.edge_vertices_[next] = {VertexId{low}, VertexId{high}};
                edge_of(side) = EdgeId{next++};
            });
        });
        parallel_for(tasks, options_.execution.threads, [&](std::size_t task) {
            for_sides(task, [&](Side side) {
                const Side first = first_sides_[side];
                if (first != side) edge_of(side) = first == no_side ? no_edge : edge_of(first);
            });
        });
        first_sides_ = {};
        advance();
        return {};
    }

    void list_edge_triangles()
    {
        fill_rows(
            topology_.edge_count(),
            [&](auto&& visit) {
                for (std::uint32_t id = 0; id < topology_.triangle_count(); ++id) {
                    const auto [a, b, c] = topology_.triangle_edges_[id];
                    if (a != no_edge) visit(index(a), TriangleId{id});
                    if (b != no_edge && b != a) visit(index(b), TriangleId{id});
                    if (c != no_edge && c != a && c != b) visit(index(c), TriangleId{id});
                }
            },
            topology_.edge_first_, topology_.edge_triangles_);
        advance();
    }

    void list_vertex_edges()
    {
        fill_rows(
            mesh_.vertex_count(),
            [&](auto&& visit) {
                for (std::uint32_t id = 0; id < topology_.edge_count(); ++id) {
                    const auto [low, high] = topology_.edge_vertices_[id];
                    visit(index(low), EdgeId{id});
                    visit(index(high), EdgeId{id});
                }
            },
            topology_.vertex_edges_first_, topology_.vertex_edges_);
        advance();
    }

    [[nodiscard]] Topology result() noexcept { return std::move(topology_); }

private:
    // What the arrays take when there are so many edges; with 0 edges, what is needed to count.
    [[nodiscard]] Status check_bytes(std::size_t edges) const
    {
        const std::uint64_t per_vertex = 2 * sizeof(std::uint32_t);
        const std::uint64_t per_side = sizeof(Side) + 2 * sizeof(TriangleId) + sizeof(EdgeId);
        const std::uint64_t per_edge =
            sizeof(EdgeVertices) + sizeof(std::uint32_t) + 2 * sizeof(EdgeId);
        return check_budget(options_.execution.budget,
                            per_vertex * mesh_.vertex_count() +
                                3 * per_side * mesh_.triangle_count() + per_edge * edges,
                            "the topology", "raise the budget");
    }

    template <class Visit>
    void for_sides(std::size_t task, const Visit& visit) const
    {
        const std::size_t begin = task * 3 * topology_task;
        const std::size_t end = std::min(begin + 3 * topology_task, first_sides_.size());
        for (std::size_t side = begin; side < end; ++side) visit(static_cast<Side>(side));
    }

    [[nodiscard]] EdgeId& edge_of(Side side) noexcept
    {
        return topology_.triangle_edges_[side / 3][side % 3];
    }

    void advance() const noexcept { advance_stage(options_.execution.progress, 1); }

    const TriangleMesh& mesh_;
    const TopologyOptions& options_;
    std::vector<Side> first_sides_;
    Topology topology_;
};

EdgeId Topology::find_edge(VertexId a, VertexId b) const noexcept
{
    if (a == b) return no_edge;
    const auto at_a = edges(a);
    const auto at_b = edges(b);
    const bool shorter = at_a.size() <= at_b.size();
    const VertexId from = shorter ? a : b;
    const VertexId to = shorter ? b : a;
    for (const EdgeId edge : shorter ? at_a : at_b) {
        if (other_end(edge, from) == to) return edge;
    }
    return no_edge;
}

std::uint64_t Topology::bytes() const noexcept
{
    const auto size = [](const auto& items) { return items.size() * sizeof(items[0]); };
    return size(edge_vertices_) + size(edge_first_) + size(edge_triangles_) +
           size(triangle_edges_) + size(star_first_) + size(star_triangles_) +
           size(vertex_edges_first_) + size(vertex_edges_);
}

Result<Topology> build_topology(const TriangleMesh& mesh, const TopologyOptions& options)
{
    const auto cancelled = [] {
        return fail(ErrorCode::cancelled, "topology: stopped on request");
    };
    TopologyBuilder builder(mesh, options);
    if (const Status fits = builder.check_limits(); !fits) return tl::unexpected(fits.error());
    begin_stage(options.execution.progress, "topology", topology_stages);
    builder.list_stars();
    if (is_cancelled(options.execution.progress)) return cancelled();
    builder.match_sides();
    if (is_cancelled(options.execution.progress)) return cancelled();
    if (const Status fits = builder.number_edges(); !fits) return tl::unexpected(fits.error());
    if (is_cancelled(options.execution.progress)) return cancelled();
    builder.list_edge_triangles();
    if (is_cancelled(options.execution.progress)) return cancelled();
    builder.list_vertex_edges();
    return builder.result();
}

} // namespace proxima
