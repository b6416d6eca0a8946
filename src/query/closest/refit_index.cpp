#include "proxima/mesh_index.h"

#include "base/grow_buffer.h"
#include "base/parallel.h"
#include "base/progress.h"
#include "base/text.h"
#include "geometry/closest_point.h"
#include "index/index_parts.h"
#include "index/lists/block.h"
#include "index/lists/local_features.h"
#include "index/lists/local_region.h"
#include "index/lists/proximity_cells.h"
#include "index/lists/proximity_lists.h"
#include "index/refit_tree.h"
#include "proxima/closest_feature.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstring>
#include <memory>
#include <utility>
#include <vector>

namespace proxima {

namespace {

/// What the refitted lists have of their own. Runs and arena are those of the lists that were built,
/// however often they are refitted.
struct RefitStorage {
    GrowBuffer<std::uint64_t> table;
    GrowBuffer<std::uint64_t> nodes;
};

/// Which rows moved.
struct MovedTriangles {
    std::vector<bool> moved;
    std::size_t count = 0;
};

/// Compares the index's rows with the mesh. Null where they are of other triangles.
template <class Scalar>
std::optional<MovedTriangles> find_moved(std::span<const TriangleRow<Scalar>> rows,
                                         const TriangleMesh& mesh, const Topology& topology)
{
    MovedTriangles result;
    result.moved.resize(rows.size());
    for (std::size_t rank = 0; rank < rows.size(); ++rank) {
        const TriangleRow<Scalar>& row = rows[rank];
        const TriangleId id{row.triangle_id()};
        const TriangleCorners& corners = mesh.triangles()[to_index(id)];
        const auto& edges = topology.edges(id);
        bool moved = false;
        for (std::size_t k = 0; k < 3; ++k) {
            if (row.vertices[k] != corners[k] || row.edges[k] != to_index(edges[k]))
                return std::nullopt;
            moved = moved || row.corner(static_cast<int>(k)) != mesh.positions()[corners[k]];
        }
        result.moved[rank] = moved;
        result.count += moved ? 1 : 0;
    }
    return result;
}

/// For each position of the arena where a block begins: which of its triangles moved.
std::vector<std::uint32_t> moved_of_blocks(std::span<const std::byte> arena,
                                           const std::vector<bool>& moved)
{
    std::vector<std::uint32_t> masks(arena.size() / block_alignment + 1);
    const std::size_t end = arena.size() - block_padding;
    for (std::size_t at = 0; at < end;) {
        BlockHeader header;
        std::memcpy(&header, arena.data() + at, sizeof header);
        const BlockLayout layout =
            block_layout(header.vertices, header.triangles, header.wide != 0);
        for (std::uint32_t i = 0; i < header.triangles; ++i) {
            std::uint32_t difference = 0;
            const std::size_t size = header.wide != 0 ? 4 : 2;
            std::memcpy(&difference, arena.data() + at + layout.ranks + size * i, size);
            if (moved[header.base + difference]) masks[at / block_alignment] |= 1U << i;
        }
        at += (layout.end + block_alignment - 1) / block_alignment * block_alignment;
    }
    return masks;
}

/// A cell with the moved features that reach into it.
struct ReachedCell {
    FrameCell cube;
    std::uint64_t word = 0;
    std::size_t node = 0; ///< where the word is, or no_node for the root's
    std::vector<std::uint32_t> features;
};

constexpr std::size_t no_node = static_cast<std::size_t>(-1);

bool has_list(std::uint64_t word) noexcept
{
    return proximity_word::is_leaf(word) && word != proximity_word::search;
}

/// For each eight nodes, whether a list is left among them or below.
std::vector<bool> groups_with_lists(std::span<const std::uint64_t> nodes, std::uint64_t root)
{
    std::vector<std::uint64_t> groups; // parents before their children
    if (!proximity_word::is_leaf(root)) groups.push_back(root);
    for (std::size_t next = 0; next < groups.size(); ++next) {
        for (const std::uint64_t word : nodes.subspan(groups[next], 8))
            if (!proximity_word::is_leaf(word)) groups.push_back(word);
    }
    std::vector<bool> found(nodes.size() / 8);
    for (std::size_t i = groups.size(); i-- > 0;) {
        found[groups[i] / 8] =
            std::ranges::any_of(nodes.subspan(groups[i], 8), [&](std::uint64_t word) {
                return proximity_word::is_leaf(word) ? has_list(word) : found[word / 8];
            });
    }
    return found;
}

/// Finds leaves that features which moved may be closest in, and takes their lists away.
class LeafStaler {
public:
    /// `root` is the root's word.
    LeafStaler(const MeshIndex& old, const TriangleMesh& mesh, const LocalFeatures& features,
               std::span<std::uint64_t> nodes, std::uint64_t root, Progress* progress)
        : old_(old), mesh_(mesh), features_(features), nodes_(nodes),
          listed_(groups_with_lists(nodes, root)), progress_(progress)
    {}

    /// The children of a split cell that have lists, are reached, and no nearer feature hides.
    void split(const ReachedCell& cell, std::vector<ReachedCell>& children) const
    {
        std::vector<std::uint8_t> masks(cell.features.size());
        find_children_in_reach(features_, cell.features, cell.cube, masks.data());
        for (int octant = 0; octant < 8; ++octant) {
            ReachedCell one;
            one.cube = child(cell.cube, octant);
            one.node = cell.word + static_cast<std::size_t>(octant);
            one.word = nodes_[one.node];
            const bool is_listed =
                proximity_word::is_leaf(one.word) ? has_list(one.word) : listed_[one.word / 8];
            if (!is_listed) continue;
            for (std::size_t k = 0; k < masks.size(); ++k)
                if ((masks[k] >> octant & 1) != 0) one.features.push_back(cell.features[k]);
            if (one.features.empty()) continue;
            drop_hidden(one);
            if (!one.features.empty()) children.push_back(std::move(one));
        }
    }

    /// All leaves below a cell.
    void visit(const ReachedCell& cell) const
    {
        if (is_cancelled(progress_)) return;
        if (proximity_word::is_leaf(cell.word)) {
            if (cell.node != no_node) nodes_[cell.node] = proximity_word::search;
            return;
        }
        std::vector<ReachedCell> children;
        split(cell, children);
        for (const ReachedCell& one : children) visit(one);
    }

private:
    /// With r the distance from the cell's centre c to its corners: a feature is farther than what
    /// was closest to any point of the cell if it is farther from c than that by more than 2 r.
    /// What was closest and moved itself makes its leaf stale anyway.
    void drop_hidden(ReachedCell& cell) const
    {
        const RootFrame& frame = old_.parts().lists()->frame();
        Vec3 center;
        for (int axis = 0; axis < 3; ++axis) {
            center[axis] =
                static_cast<double>(cell.cube.center[axis]) / frame.scale + frame.center[axis];
        }
        const double known = std::sqrt(closest_feature(old_, center).value().squared_distance);
        const double radius = static_cast<double>(cell.cube.half) / frame.scale * std::sqrt(3.0);
        const double limit = (known + 2 * radius) * (1 + 1e-9) + 1e-9 * frame.half;
        std::erase_if(cell.features, [&](std::uint32_t feature) {
            const auto ranks = features_.triangles(features_.features[feature]);
            const Triangle triangle = mesh_.triangle(old_.ids()[ranks.front()]);
            return (closest_point(triangle, center).point - center).norm() > limit;
        });
    }

    const MeshIndex& old_;
    const TriangleMesh& mesh_; ///< as it is
    const LocalFeatures& features_;
    std::span<std::uint64_t> nodes_;
    std::vector<bool> listed_; ///< as groups_with_lists has them
    Progress* progress_;
};

/// Takes away the lists that hold a triangle that moved. Runs are looked at entry by entry.
void drop_moved_lists(const ProximityArrays& arrays, const std::vector<std::uint32_t>& moved,
                      std::span<std::uint64_t> words)
{
    for (std::uint64_t& word : words) {
        if (!has_list(word)) continue;
        const std::uint32_t position = proximity_word::position(word);
        bool stale = false;
        if (proximity_word::is_block(word)) {
            stale = (moved[position] & proximity_word::mask(word)) != 0;
        } else {
            const auto run =
                arrays.runs.subspan(position + std::size_t{1}, arrays.runs[position].position);
            stale = std::ranges::any_of(run, [&](const RunEntry& entry) {
                return (moved[entry.position] & entry.mask) != 0;
            });
        }
        if (stale) word = proximity_word::search;
    }
}

/// Takes away the lists of leaves that features which moved reach now. False where cancelled.
bool drop_reached_lists(const LeafStaler& staler, ReachedCell root, const RefitOptions& options)
{
    // A few levels one after the other, then cells in parallel: each writes words of its own.
    std::vector<ReachedCell> cells;
    cells.push_back(std::move(root));
    for (int level = 0; level < 3; ++level) {
        std::vector<ReachedCell> next;
        for (ReachedCell& cell : cells) {
            if (proximity_word::is_leaf(cell.word)) {
                next.push_back(std::move(cell));
            } else {
                staler.split(cell, next);
            }
        }
        cells = std::move(next);
    }
    begin_stage(options.execution.progress, "leaves that triangles moved into", cells.size());
    parallel_for(cells.size(), options.execution.threads, [&](std::size_t i) {
        staler.visit(cells[i]);
        advance_stage(options.execution.progress, 1);
    });
    return !is_cancelled(options.execution.progress);
}

/// Features that have a triangle that moved.
std::vector<std::uint32_t> moved_features(const LocalFeatures& features,
                                          const std::vector<bool>& moved)
{
    std::vector<std::uint32_t> list;
    for (std::uint32_t i = 0; i < features.features.size(); ++i) {
        const auto ranks = features.triangles(features.features[i]);
        if (std::ranges::any_of(ranks, [&](std::uint32_t rank) { return moved[rank]; }))
            list.push_back(i);
    }
    return list;
}

std::uint64_t searched_words(std::span<const std::uint64_t> words)
{
    return static_cast<std::uint64_t>(std::ranges::count(words, proximity_word::search));
}

Status check_input(const MeshIndex& index, const TriangleMesh& mesh, const Topology& topology)
{
    if (mesh.triangle_count() != index.triangle_count() ||
        mesh.vertex_count() != index.vertex_count() ||
        topology.triangle_count() != mesh.triangle_count() ||
        topology.edge_count() != index.edge_count()) {
        return fail(ErrorCode::invalid_argument,
                    "the index is of other triangles: only vertices may have moved", "mesh");
    }
    const auto bounds = checked_bounding_box(mesh);
    if (!bounds) return tl::unexpected(bounds.error());
    if (index.parts().lists() == nullptr) return {};
    const RootFrame& frame = index.parts().lists()->frame();
    if (!frame.contains(bounds->lower) || !frame.contains(bounds->upper)) {
        return fail(ErrorCode::invalid_argument,
                    "vertices moved out of the root of the lists: build them again", "mesh");
    }
    return {};
}

/// The lists that are left. \pre the index has some
Result<std::shared_ptr<const ProximityLists>>
refit_lists(const MeshIndex& index, const TriangleMesh& mesh, const Topology& topology,
            const MovedTriangles& moved, const RefitOptions& options)
{
    const ProximityLists& lists = *index.parts().lists();
    const ProximityArrays& old = lists.arrays();
    auto storage = std::make_shared<RefitStorage>();
    storage->nodes.resize(old.nodes.size());
    std::ranges::copy(old.nodes, storage->nodes.begin());
    const std::span<std::uint64_t> nodes{storage->nodes.data(), storage->nodes.size()};
    auto root = root_word(old);
    if (!root) return tl::unexpected(root.error());
    ProximityStatistics counts = lists.statistics();
    if (moved.count > 0) {
        const std::vector<std::uint32_t> of_blocks = moved_of_blocks(old.arena, moved.moved);
        drop_moved_lists(old, of_blocks, nodes);
        drop_moved_lists(old, of_blocks, {&*root, 1});
    }
    // Where all moved, nothing is left to look at: to find that cell by cell takes as long as building.
    if (moved.count > 0 && std::ranges::any_of(nodes, has_list)) {
        const auto features = collect_local_features(mesh, topology, index.ids(), lists.frame(),
                                                     options.execution.progress);
        if (!features) return cancelled("refitting the mesh index");
        const LeafStaler staler(index, mesh, *features, nodes, *root, options.execution.progress);
        ReachedCell cell;
        cell.cube = {{0, 0, 0}, static_cast<float>(lists.frame().frame_half())};
        cell.word = *root;
        cell.node = no_node;
        cell.features = moved_features(*features, moved.moved);
        // A root that is a leaf has all triangles in its list.
        if (!drop_reached_lists(staler, std::move(cell), options))
            return cancelled("refitting the mesh index");
    }
    storage->table.resize(old.table.size());
    fill_table(*root, nodes, lists.table_depth(), {storage->table.data(), storage->table.size()});
    const std::uint64_t searched =
        nodes.empty() ? searched_words({&*root, 1}) : searched_words(nodes);
    counts.stale_leaves += searched - counts.searched_leaves;
    counts.searched_leaves = searched;
    const ProximityArrays arrays{storage->table.span(), storage->nodes.span(), old.runs, old.arena};
    return std::make_shared<const ProximityLists>(
        ProximityLists::adopt(lists.frame(), lists.table_depth(), arrays, counts,
                              std::move(storage), lists.shared_storage()));
}

} // namespace

Result<MeshIndex> refit_index(const MeshIndex& index, const TriangleMesh& mesh,
                              const Topology& topology, const RefitOptions& options)
{
    if (const Status status = check_input(index, mesh, topology); !status)
        return tl::unexpected(status.error());
    const IndexParts& parts = index.parts();
    const auto moved = parts.double_rows().empty()
                           ? find_moved(parts.float_rows(), mesh, topology)
                           : find_moved(parts.double_rows(), mesh, topology);
    if (!moved) {
        return fail(ErrorCode::invalid_argument,
                    "the index is of other triangles: only vertices may have moved", "mesh");
    }
    const auto refitted =
        refit_tree(parts, mesh, options.execution.threads, options.execution.progress);
    if (!refitted) return tl::unexpected(refitted.error());
    if (parts.lists() == nullptr) return make_mesh_index(*refitted);
    auto lists = refit_lists(index, mesh, topology, *moved, options);
    if (!lists) return tl::unexpected(lists.error());
    return make_mesh_index(refitted->adopt_lists(std::move(*lists)));
}

} // namespace proxima
