#include "proxima/topology.h"

#include "base/memory_budget.h"
#include "base/progress.h"
#include "base/text.h"
#include "mesh/edge_numbers.h"

#include <algorithm>
#include <utility>

namespace proxima {

namespace {

constexpr std::uint64_t topology_stages = 3;

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

} // namespace

// The steps of build_topology, in the order of their calls there.
class PROXIMA_HIDDEN TopologyBuilder {
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

    // Edges, numbered where their first side stands.
    Status list_edges()
    {
        begin_stage(options_.execution.progress, "numbering edges", mesh_.triangle_count());
        Result<EdgeNumbers> numbers = number_edges(mesh_, options_.execution.progress);
        if (!numbers) return tl::unexpected(numbers.error());
        if (Status fits = check_bytes(numbers->first_sides.size()); !fits) return fits;
        topology_.triangle_edges_ = std::move(numbers->triangle_edges);
        topology_.edge_vertices_.reserve(numbers->first_sides.size());
        for (const std::uint32_t side : numbers->first_sides) {
            const TriangleCorners& corners = mesh_.triangles()[side / 3];
            const std::size_t corner = side % 3;
            const auto [low, high] =
                std::minmax(corners[corner], corners[corner == 2 ? 0 : corner + 1]);
            topology_.edge_vertices_.push_back({VertexId{low}, VertexId{high}});
        }
        return {};
    }

    void list_edge_triangles()
    {
        fill_rows(
            topology_.edge_count(),
            [&](auto&& visit) {
                for (std::uint32_t id = 0; id < topology_.triangle_count(); ++id) {
                    const auto [a, b, c] = topology_.triangle_edges_[id];
                    if (a != no_edge) visit(to_index(a), TriangleId{id});
                    if (b != no_edge && b != a) visit(to_index(b), TriangleId{id});
                    if (c != no_edge && c != a && c != b) visit(to_index(c), TriangleId{id});
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
                    visit(to_index(low), EdgeId{id});
                    visit(to_index(high), EdgeId{id});
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
        const std::uint64_t per_side = 2 * sizeof(TriangleId);
        const std::uint64_t per_edge =
            sizeof(EdgeVertices) + sizeof(std::uint32_t) + 2 * sizeof(EdgeId);
        return check_budget(options_.execution.budget,
                            per_vertex * mesh_.vertex_count() +
                                (3 * per_side + edge_number_bytes) * mesh_.triangle_count() +
                                per_edge * edges,
                            "the topology", "raise the budget");
    }

    void advance() const noexcept { advance_stage(options_.execution.progress, 1); }

    const TriangleMesh& mesh_;
    const TopologyOptions& options_;
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
    TopologyBuilder builder(mesh, options);
    if (const Status fits = builder.check_limits(); !fits) return tl::unexpected(fits.error());
    if (const Status listed = builder.list_edges(); !listed) return tl::unexpected(listed.error());
    begin_stage(options.execution.progress, "topology", topology_stages);
    builder.list_stars();
    if (is_cancelled(options.execution.progress)) return cancelled("building the topology");
    builder.list_edge_triangles();
    if (is_cancelled(options.execution.progress)) return cancelled("building the topology");
    builder.list_vertex_edges();
    return builder.result();
}

} // namespace proxima
