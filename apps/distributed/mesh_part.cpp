#include "distributed/mesh_part.h"

#include "base/morton_code.h"
#include "distributed/local_numbers.h"
#include "distributed/mesh_input.h"
#include "distributed/order_by_key.h"
#include "distributed/routed_forest.h"
#include "index/build_part_index.h"
#include "index/index_parts.h"
#include "index/row_tables.h"

#include <algorithm>
#include <cmath>

namespace proxima {

namespace {

/// Cells that each rank gets at least, where there are as many triangles.
constexpr std::uint64_t cells_per_rank = 64;

struct SentVertex {
    WholeFeature name;
    std::array<double, 3> position = {};
};

struct SentTriangle {
    std::uint64_t id = 0;
    std::array<std::uint32_t, 3> corners = {}; ///< among the vertices of the same sender
    std::array<std::uint32_t, 3> edges = {};   ///< among its edges, or no_edge
};

struct PartMessages {
    std::vector<std::vector<SentTriangle>> triangles;
    std::vector<std::vector<SentVertex>> vertices;
    std::vector<std::vector<WholeFeature>> edges;

    explicit PartMessages(std::size_t ranks) : triangles(ranks), vertices(ranks), edges(ranks) {}
};

/// The cell of that depth that has the middle of a triangle's box, by its Morton index.
std::uint64_t cell_of(const Triangle& triangle, const OctreeFrame& frame, int depth) noexcept
{
    const Vec3 middle = bounding_box(triangle).center();
    const double cells = std::ldexp(1.0, depth);
    std::array<std::uint32_t, 3> at{};
    for (std::size_t axis = 0; axis < 3; ++axis) {
        const auto k = static_cast<Eigen::Index>(axis);
        const double cell = (middle[k] - frame.lower[k]) / frame.edge[k] * cells;
        at[axis] = static_cast<std::uint32_t>(std::clamp(cell, 0.0, cells - 1));
    }
    return morton_code(at);
}

/// How many triangles each cell of each depth has; every triangle is in one cell of a depth. Throws
/// std::bad_alloc.
CellCounts count_cells(const std::vector<std::uint64_t>& cells, int depth)
{
    CellCounts counts(depth);
    const auto order = order_by_key(cells.size(), [&](std::uint32_t t) { return cells[t]; });
    each_group(order, [&](std::span<const KeyedIndex> group) {
        counts.add(group.front().key, {group.size()});
    });
    return counts;
}

/// Sorts the slice's triangles by the rank that owns their cells. Throws std::bad_alloc.
PartMessages pack(const MeshSlice& slice, const SliceFeatures& features,
                  const std::vector<int>& owners, std::size_t ranks)
{
    PartMessages messages(ranks);
    std::vector<std::vector<std::uint32_t>> ids(ranks);
    for (std::uint32_t t = 0; t < owners.size(); ++t)
        ids[static_cast<std::size_t>(owners[t])].push_back(t);
    LocalNumbers vertices(features.vertices.size());
    LocalNumbers edges(features.edges.size());
    for (std::size_t r = 0; r < ranks; ++r) {
        for (const std::uint32_t t : ids[r]) {
            for (const std::uint32_t vertex : slice.mesh.triangles()[t]) vertices.add(vertex);
            for (const EdgeId edge : features.triangle_edges[t])
                if (edge != no_edge) edges.add(to_index(edge));
        }
        messages.vertices[r].reserve(vertices.number());
        vertices.each([&](std::uint32_t vertex) {
            const Vec3& at = slice.mesh.positions()[vertex];
            messages.vertices[r].push_back({features.vertices[vertex], {at[0], at[1], at[2]}});
        });
        messages.edges[r].reserve(edges.number());
        edges.each([&](std::uint32_t edge) { messages.edges[r].push_back(features.edges[edge]); });
        for (const std::uint32_t t : ids[r]) {
            SentTriangle& sent = messages.triangles[r].emplace_back();
            sent.id = slice.first_triangle + t;
            for (std::size_t k = 0; k < 3; ++k) {
                sent.corners[k] = vertices.number_of(slice.mesh.triangles()[t][k]);
                const EdgeId edge = features.triangle_edges[t][k];
                sent.edges[k] = edge == no_edge ? to_index(edge) : edges.number_of(to_index(edge));
            }
        }
        vertices.clear();
        edges.clear();
    }
    return messages;
}

struct ReceivedPart {
    Received<SentTriangle> triangles;
    Received<SentVertex> vertices;
    Received<WholeFeature> edges;
};

Result<ReceivedPart> send(PartMessages messages, World& world)
{
    auto triangles = world.exchange(std::move(messages.triangles));
    if (!triangles) return tl::unexpected(triangles.error());
    auto vertices = world.exchange(std::move(messages.vertices));
    if (!vertices) return tl::unexpected(vertices.error());
    auto edges = world.exchange(std::move(messages.edges));
    if (!edges) return tl::unexpected(edges.error());
    return ReceivedPart{std::move(*triangles), std::move(*vertices), std::move(*edges)};
}

/// The distinct items, ascending by id, and which of them each item is. Throws std::bad_alloc.
template <class T, class IdOf>
std::vector<std::uint32_t> join(std::vector<T>& items, const IdOf& id_of)
{
    std::vector<T> distinct;
    std::vector<std::uint32_t> numbers(items.size());
    for (const KeyedIndex& at :
         order_by_key(items.size(), [&](std::uint32_t i) { return id_of(items[i]); })) {
        if (distinct.empty() || id_of(distinct.back()) != at.key)
            distinct.push_back(items[at.index]);
        numbers[at.index] = static_cast<std::uint32_t>(distinct.size() - 1);
    }
    items = std::move(distinct);
    return numbers;
}

/// The part's mesh, and its edges.
struct Assembled {
    TriangleMesh mesh;
    EdgeNumbers edges;
};

Result<Assembled> assemble_part(ReceivedPart received, MeshPart& part)
{
    auto& triangles = received.triangles;
    auto& vertices = received.vertices.items;
    const auto vertex_numbers = join(vertices, [](const SentVertex& v) { return v.name.id; });
    const auto edge_numbers =
        join(received.edges.items, [](const WholeFeature& edge) { return edge.id; });
    part.edges = std::move(received.edges.items);
    std::vector<Vec3> positions;
    for (const SentVertex& vertex : vertices) {
        part.vertices.push_back(vertex.name);
        positions.emplace_back(vertex.position[0], vertex.position[1], vertex.position[2]);
    }
    std::vector<SentVertex>().swap(vertices);
    std::vector<TriangleCorners> corners;
    Assembled assembled;
    assembled.edges.first_sides.resize(part.edges.size());
    for (std::size_t r = 0; r + 1 < triangles.first.size(); ++r) {
        for (std::size_t i = triangles.first[r]; i < triangles.first[r + 1]; ++i) {
            const SentTriangle& sent = triangles.items[i];
            part.triangles.push_back(sent.id);
            TriangleCorners& own = corners.emplace_back();
            auto& own_edges = assembled.edges.triangle_edges.emplace_back();
            for (std::size_t k = 0; k < 3; ++k) {
                own[k] = vertex_numbers[received.vertices.first[r] + sent.corners[k]];
                own_edges[k] = sent.edges[k] == to_index(no_edge)
                                   ? no_edge
                                   : EdgeId{edge_numbers[received.edges.first[r] + sent.edges[k]]};
            }
        }
    }
    for (std::size_t t = corners.size(); t-- > 0;) {
        for (std::size_t k = 3; k-- > 0;) {
            const EdgeId edge = assembled.edges.triangle_edges[t][k];
            if (edge == no_edge) continue;
            assembled.edges.first_sides[to_index(edge)] = static_cast<std::uint32_t>(3 * t + k);
        }
    }
    auto mesh = make_triangle_mesh(std::move(positions), std::move(corners));
    if (!mesh) return tl::unexpected(mesh.error());
    assembled.mesh = std::move(*mesh);
    return assembled;
}

/// Winding numbers of the part, which name triangles by their rows.
Status take_winding(const TriangleMesh& mesh, MeshPart& part, Progress& progress)
{
    auto winding =
        build_winding_number(mesh, {.execution = {.threads = {1}, .progress = &progress}});
    if (!winding) return tl::unexpected(winding.error());
    part.winding = std::move(*winding).release();
    std::vector<std::uint32_t> rows(mesh.triangle_count());
    for (std::uint32_t row = 0; row < rows.size(); ++row)
        rows[to_index(part.index.parts().id(row))] = row;
    for (std::uint32_t& number : part.winding.order) number = rows[number];
    return {};
}

Result<ReceivedPart> share_triangles(MeshSlice slice, const SliceFeatures& features,
                                     const OctreeFrame& frame, int depth, World& world)
{
    std::vector<std::uint64_t> cells; // by triangle
    CellCounts counts(depth);
    Status status = world.agree_on([&]() -> Status {
        const auto count = static_cast<std::uint32_t>(slice.mesh.triangle_count());
        cells.reserve(count);
        for (std::uint32_t t = 0; t < count; ++t)
            cells.push_back(cell_of(slice.mesh.triangle(TriangleId{t}), frame, depth));
        counts = count_cells(cells, depth);
        return {};
    });
    if (!status) return tl::unexpected(status.error());
    const auto ranks = static_cast<std::uint64_t>(world.size());
    const std::uint64_t threshold = slice.whole_triangles / (cells_per_rank * ranks);
    RoutedForest forest;
    status = forest.build(
        counts, static_cast<std::uint32_t>(std::clamp<std::uint64_t>(threshold, 1, 1U << 30U)),
        world);
    if (!status) return tl::unexpected(status.error());
    PartMessages messages(0);
    status = world.agree_on([&]() -> Status {
        std::vector<int> owners(cells.size());
        for (std::size_t t = 0; t < cells.size(); ++t) owners[t] = forest.owner(cells[t], depth);
        messages = pack(slice, features, owners, ranks);
        slice = MeshSlice{};
        return {};
    });
    if (!status) return tl::unexpected(status.error());
    return send(std::move(messages), world);
}

} // namespace

Result<MeshPart> make_mesh_part(MeshSlice slice, const PartOptions& options, World& world)
{
    MeshPart part;
    const auto box = whole_box(slice, world);
    if (!box) return tl::unexpected(box.error());
    part.whole_box = *box;
    part.whole_triangles = slice.whole_triangles;
    const bool are_floats = world.min(has_floats(slice.mesh) ? 1 : 0) == 1;
    const IndexFrame frame = index_frame(*box, are_floats);
    part.scale = frame.scale;
    auto features = number_features(slice, world);
    if (!features) return tl::unexpected(features.error());
    part.unbalanced_edges = features->unbalanced_edges;
    auto received = share_triangles(std::move(slice), *features, tight_root(*box, RootShape::cube),
                                    options.routing_depth, world);
    if (!received) return tl::unexpected(received.error());
    *features = {};
    Box own;
    const Status status = world.agree_on([&]() -> Status {
        if (received->triangles.items.empty()) return {};
        const auto assembled = assemble_part(std::move(*received), part);
        if (!assembled) return tl::unexpected(assembled.error());
        own = bounding_box(assembled->mesh);
        auto index =
            build_part_index(assembled->mesh, frame, assembled->edges,
                             {.execution = {.threads = {1}, .progress = &world.progress()}});
        if (!index) return tl::unexpected(index.error());
        part.index = *index;
        if (part.is_closed() || !options.has_winding_if_open) return {};
        return take_winding(assembled->mesh, part, world.progress());
    });
    if (!status) return tl::unexpected(status.error());
    using Ends = std::array<double, 6>;
    const auto ends = world.all_gather(std::vector<Ends>{
        {own.lower[0], own.lower[1], own.lower[2], own.upper[0], own.upper[1], own.upper[2]}});
    if (!ends) return tl::unexpected(ends.error());
    for (const Ends& at : ends->items)
        part.boxes.push_back({{at[0], at[1], at[2]}, {at[3], at[4], at[5]}});
    return part;
}

} // namespace proxima
