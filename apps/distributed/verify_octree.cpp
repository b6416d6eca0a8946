#include "distributed/verify_octree.h"

#include "distributed/mesh_input.h"

#include <algorithm>

namespace proxima {

namespace {

/// Leaves in Morton order: their keys, the lengths of their lists, and the lists' ids in the whole.
struct LeafList {
    std::vector<std::uint64_t> keys;
    std::vector<std::uint64_t> lengths;
    std::vector<std::uint64_t> ids;
    const std::vector<std::uint64_t>* whole_ids = nullptr; ///< null: ids are those of the whole

    static bool should_enter(const Cell&) { return true; }
    Flow visit_leaf(const Cell& cell, std::span<const TriangleId> triangles)
    {
        keys.push_back(cell.key.bits);
        lengths.push_back(triangles.size());
        for (const TriangleId id : triangles) {
            ids.push_back(whole_ids == nullptr ? to_index(id) : (*whole_ids)[to_index(id)]);
        }
        return Flow::proceed;
    }
};

Status compare(const OctreeRunOptions& options, const Received<std::uint64_t>& keys,
               const Received<std::uint64_t>& lengths, const Received<std::uint64_t>& ids)
{
    const auto mesh = whole_mesh(options.model);
    if (!mesh) return tl::unexpected(mesh.error());
    const auto octree = build_octree(*mesh, {.max_depth = options.depth,
                                             .threshold = options.threshold,
                                             .classification = Classification::none,
                                             .execution = {.threads = {1}}});
    if (!octree) return tl::unexpected(octree.error());
    LeafList expected;
    traverse(*octree, expected);
    const auto differ = [](const char* what) {
        return fail(ErrorCode::broken_invariant,
                    concat(what, " differ from those of one process: this is a bug, report it"));
    };
    if (keys.items != expected.keys) return differ("leaves");
    if (lengths.items != expected.lengths) return differ("lengths of lists");
    if (ids.items != expected.ids) return differ("lists");
    return {};
}

} // namespace

Status verify_octree(const OctreeRunOptions& options, const RoutedPart& part,
                     const GrownCells& grown, World& world)
{
    const auto ranks = static_cast<std::size_t>(world.size());
    LeafList own;
    Status status = world.agree_on([&]() -> Status {
        own.whole_ids = &part.triangles;
        for (const Cell& cell : grown.cells) traverse_below(grown.octree, cell, own);
        return {};
    });
    if (!status) return status;
    const auto collect = [&](std::vector<std::uint64_t>& items) {
        std::vector<std::vector<std::uint64_t>> outgoing(ranks);
        outgoing[0] = std::move(items);
        return world.exchange(std::move(outgoing));
    };
    const auto keys = collect(own.keys);
    if (!keys) return tl::unexpected(keys.error());
    const auto lengths = collect(own.lengths);
    if (!lengths) return tl::unexpected(lengths.error());
    const auto ids = collect(own.ids);
    if (!ids) return tl::unexpected(ids.error());
    return world.agree_on([&]() -> Status {
        return world.rank() == 0 ? compare(options, *keys, *lengths, *ids) : Status{};
    });
}

} // namespace proxima
