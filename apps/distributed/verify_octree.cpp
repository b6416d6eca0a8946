#include "distributed/verify_octree.h"

#include "distributed/mesh_input.h"

#include <algorithm>

namespace proxima {

namespace {

/// Leaves in Morton order: their keys and classes, the lengths of their lists, and the lists' ids in
/// the whole.
struct LeafList {
    std::vector<std::uint64_t> keys;
    std::vector<std::uint8_t> classes;
    std::vector<std::uint64_t> lengths;
    std::vector<std::uint64_t> ids;
    const OctreePart* part = nullptr; ///< null: ids are those of the whole

    static bool should_enter(const Cell&) { return true; }
    Flow visit_leaf(const Cell& cell, std::span<const TriangleId> triangles)
    {
        keys.push_back(cell.key.bits);
        classes.push_back(static_cast<std::uint8_t>(cell.type));
        lengths.push_back(triangles.size());
        for (const TriangleId id : triangles) {
            ids.push_back(part == nullptr ? to_index(id) : part->whole_id(id));
        }
        return Flow::proceed;
    }
};

Status compare(const OctreeRunOptions& options, const OctreeParameters& parameters,
               const LeafList& found, Progress& progress)
{
    const auto mesh = whole_mesh(options.model);
    if (!mesh) return tl::unexpected(mesh.error());
    const auto octree = build_octree(*mesh, {.max_depth = options.depth,
                                             .threshold = options.threshold,
                                             .execution = {.threads = {1}, .progress = &progress}});
    if (!octree) return tl::unexpected(octree.error());
    LeafList expected;
    traverse(*octree, expected);
    const auto differ = [](const char* what) {
        return fail(ErrorCode::broken_invariant,
                    concat(what, " differ from those of one process: this is a bug, report it"));
    };
    if (found.keys != expected.keys) return differ("leaves");
    if (found.lengths != expected.lengths) return differ("lengths of lists");
    if (found.ids != expected.ids) return differ("lists");
    if (found.classes != expected.classes) return differ("classes");
    if (parameters != octree->parameters()) return differ("counts of regions");
    return {};
}

} // namespace

Status verify_octree(const OctreeRunOptions& options, const OctreePart& part, World& world)
{
    LeafList own;
    Status status = world.agree_on([&]() -> Status {
        own.part = &part;
        for (const Cell& cell : part.cells) traverse_below(part.octree, cell, own);
        return {};
    });
    if (!status) return status;
    LeafList found;
    auto keys = world.collect(std::move(own.keys));
    if (!keys) return tl::unexpected(keys.error());
    auto classes = world.collect(std::move(own.classes));
    if (!classes) return tl::unexpected(classes.error());
    auto lengths = world.collect(std::move(own.lengths));
    if (!lengths) return tl::unexpected(lengths.error());
    auto ids = world.collect(std::move(own.ids));
    if (!ids) return tl::unexpected(ids.error());
    return world.agree_on([&]() -> Status {
        if (world.rank() != 0) return {};
        found.keys = std::move(keys->items);
        found.classes = std::move(classes->items);
        found.lengths = std::move(lengths->items);
        found.ids = std::move(ids->items);
        return compare(options, part.octree.parameters(), found, world.progress());
    });
}

} // namespace proxima
