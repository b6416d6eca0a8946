#include "distributed/route_triangles.h"

#include "base/progress.h"
#include "base/radix_sort.h"
#include "distributed/local_numbers.h"
#include "octree/coarse_bins.h"

#include <algorithm>
#include <bit>
#include <limits>

namespace proxima {

namespace {

struct RoutedTriangle {
    std::uint64_t id = 0;
    TriangleCorners corners = {}; ///< among the vertices of the same sender
    std::uint32_t is_counted = 0; ///< 1 on the first rank that the triangle goes to
};

using Position = std::array<double, 3>;

/// Where the grid is coarse against a cell, boxes would spread over all of them.
int usable_depth(const OctreeFrame& frame, const RouteOptions& options)
{
    int depth = std::min({options.routing_depth, options.max_depth, max_routing_depth});
    const TriangleMesh none;
    const std::int32_t margin = SnappedMesh(none, frame, Threads{1}, nullptr).margin();
    while (depth > 0 && margin > (1 << (snapped_bits - depth)) / 1024) --depth;
    return depth;
}

/// The triangles of each cell of a depth; not to be used once `progress` is cancelled. Throws
/// std::bad_alloc.
CoarseBins bins_of(const TriangleMesh& mesh, const OctreeFrame& frame, int depth,
                   Progress* progress)
{
    if (mesh.triangle_count() == 0) {
        CoarseBins bins;
        bins.depth = depth;
        bins.first.assign((std::size_t{1} << (3 * depth)) + 1, 0);
        return bins;
    }
    begin_stage(progress, "routing", mesh.vertex_count() + 2 * mesh.triangle_count());
    const SnappedMesh snapped(mesh, frame, Threads{1}, progress);
    if (is_cancelled(progress)) return {};
    return bin_triangles(snapped, depth, Threads{1}, progress);
}

/// Sets `ids` to the distinct triangles of a cell at or above the depth of the bins, ascending.
void merge(const CoarseBins& bins, std::uint64_t cell, int depth, std::vector<std::uint32_t>& ids)
{
    const int shift = 3 * (bins.depth - depth);
    const std::uint32_t first = bins.first[cell << shift];
    const std::uint32_t end = bins.first[(cell + 1) << shift];
    const auto below = bins.ids.span().subspan(first, end - first);
    ids.assign(below.begin(), below.end());
    if (shift == 0) return;
    std::ranges::sort(ids);
    ids.erase(std::unique(ids.begin(), ids.end()), ids.end());
}

constexpr std::uint32_t none = std::numeric_limits<std::uint32_t>::max();

/// How many triangles touch the cells of each depth. Cells follow in Morton order, so that a triangle
/// was counted for a cell before iff it was counted for that one last.
std::vector<std::vector<CellCount>> count_cells(const CoarseBins& bins, std::size_t triangles)
{
    std::vector<std::vector<CellCount>> counts;
    std::vector<std::uint32_t> last_cell;
    for (int depth = 0; depth <= bins.depth; ++depth) {
        const int shift = 3 * (bins.depth - depth);
        last_cell.assign(triangles, none);
        auto& at_depth = counts.emplace_back();
        for (std::size_t bin = 0; bin < bins.cell_count(); ++bin) {
            const auto cell = static_cast<std::uint32_t>(bin >> shift);
            std::uint64_t count = 0;
            for (const std::uint32_t id : bins.triangles(bin)) {
                count += last_cell[id] != cell ? 1 : 0;
                last_cell[id] = cell;
            }
            if (count == 0) continue;
            if (at_depth.empty() || at_depth.back().cell != cell) at_depth.push_back({cell, 0});
            at_depth.back().triangles += count;
        }
    }
    return counts;
}

struct Messages {
    std::vector<std::vector<RoutedTriangle>> triangles;
    std::vector<std::vector<Position>> vertices;
};

/// Packs triangles of one slice for one rank after the other, with the vertices that they use.
class Packer {
public:
    explicit Packer(const MeshSlice& slice)
        : slice_(slice), is_packed_(slice.mesh.triangle_count()),
          numbers_(slice.mesh.vertex_count())
    {}

    void pack(const std::vector<std::uint32_t>& ids, std::vector<RoutedTriangle>& triangles,
              std::vector<Position>& vertices)
    {
        triangles.reserve(ids.size());
        for (const std::uint32_t id : ids) {
            RoutedTriangle& triangle = triangles.emplace_back();
            triangle.id = slice_.first_triangle + id;
            triangle.is_counted = is_packed_[id] ? 0 : 1;
            is_packed_[id] = true;
            for (std::size_t k = 0; k < 3; ++k)
                triangle.corners[k] = numbers_.number_of(slice_.mesh.triangles()[id][k]);
        }
        const std::vector<std::uint32_t> used = numbers_.take();
        vertices.reserve(used.size());
        for (const std::uint32_t vertex : used) {
            const Vec3& at = slice_.mesh.positions()[vertex];
            vertices.push_back({at[0], at[1], at[2]});
        }
    }

private:
    const MeshSlice& slice_;
    std::vector<bool> is_packed_; ///< for an earlier rank
    LocalNumbers numbers_;        ///< of vertices in the rank's message
};

Result<Messages> pack_all(const MeshSlice& slice, const CoarseBins& bins,
                          const RoutedForest& forest, std::size_t ranks, Progress* progress)
{
    // Owners of cells in Morton order ascend, so that a triangle's last one tells repeats.
    std::vector<std::vector<std::uint32_t>> ids(ranks);
    std::vector<std::uint32_t> last_owner(slice.mesh.triangle_count(), none);
    for (std::size_t cell = 0; cell < bins.cell_count(); ++cell) {
        if (bins.count(cell) == 0) continue;
        const auto owner = static_cast<std::uint32_t>(forest.owner(cell, bins.depth));
        for (const std::uint32_t id : bins.triangles(cell)) {
            if (last_owner[id] != owner) ids[owner].push_back(id);
            last_owner[id] = owner;
        }
    }
    Messages messages{std::vector<std::vector<RoutedTriangle>>(ranks),
                      std::vector<std::vector<Position>>(ranks)};
    Packer packer(slice);
    StageSteps steps(progress, "packing", bins.ids.size());
    const auto bits = static_cast<unsigned>(std::bit_width(slice.mesh.triangle_count()));
    for (std::size_t r = 0; r < ranks; ++r) {
        const auto key_of = [](std::uint32_t id) { return std::uint64_t{id}; };
        if (!radix_sort(ids[r], bits, key_of, steps)) return cancelled("routing triangles");
        packer.pack(ids[r], messages.triangles[r], messages.vertices[r]);
        std::vector<std::uint32_t>().swap(ids[r]);
    }
    return messages;
}

Status unpack(const Received<RoutedTriangle>& triangles, const Received<Position>& vertices,
              RoutedPart& part)
{
    std::vector<Vec3> positions;
    positions.reserve(vertices.items.size());
    for (const Position& at : vertices.items) positions.emplace_back(at[0], at[1], at[2]);
    std::vector<TriangleCorners> corners;
    corners.reserve(triangles.items.size());
    part.triangles.reserve(triangles.items.size());
    for (std::size_t r = 0; r + 1 < triangles.first.size(); ++r) {
        const auto shift = static_cast<std::uint32_t>(vertices.first[r]);
        for (std::size_t i = triangles.first[r]; i < triangles.first[r + 1]; ++i) {
            const RoutedTriangle& triangle = triangles.items[i];
            part.triangles.push_back(triangle.id);
            part.is_counted.push_back(triangle.is_counted != 0);
            corners.push_back({triangle.corners[0] + shift, triangle.corners[1] + shift,
                               triangle.corners[2] + shift});
        }
    }
    auto mesh = make_triangle_mesh(std::move(positions), std::move(corners));
    if (!mesh) return tl::unexpected(mesh.error());
    part.mesh = std::move(*mesh);
    return {};
}

/// Fills the lists of part.keys.
Status list_triangles(const OctreeFrame& frame, int routing_depth, Progress* progress,
                      RoutedPart& part)
{
    const CoarseBins bins = bins_of(part.mesh, frame, routing_depth, progress);
    if (is_cancelled(progress)) return cancelled("routing triangles");
    std::vector<std::uint32_t> ids;
    part.first.push_back(0);
    for (const CellKey key : part.keys) {
        const int level = depth(key);
        merge(bins, key.bits ^ (std::uint64_t{1} << (3 * level)), level, ids);
        for (const std::uint32_t id : ids) part.lists.push_back(TriangleId{id});
        part.first.push_back(part.lists.size());
    }
    return {};
}

} // namespace

Result<RoutedPart> route_triangles(MeshSlice slice, const OctreeFrame& frame,
                                   const RouteOptions& options, World& world)
{
    const int routing_depth = usable_depth(frame, options);
    CoarseBins bins;
    std::vector<std::vector<CellCount>> counts;
    Status status = world.agree_on([&]() -> Status {
        bins = bins_of(slice.mesh, frame, routing_depth, &world.progress());
        if (is_cancelled(&world.progress())) return cancelled("routing triangles");
        counts = count_cells(bins, slice.mesh.triangle_count());
        return {};
    });
    if (!status) return tl::unexpected(status.error());
    auto forest = std::make_unique<RoutedForest>();
    status = forest->build(counts, options.threshold, world);
    if (!status) return tl::unexpected(status.error());

    Messages messages;
    status = world.agree_on([&]() -> Status {
        auto packed = pack_all(slice, bins, *forest, static_cast<std::size_t>(world.size()),
                               &world.progress());
        if (!packed) return tl::unexpected(packed.error());
        messages = std::move(*packed);
        slice = MeshSlice{};
        bins = CoarseBins{};
        return {};
    });
    if (!status) return tl::unexpected(status.error());
    auto triangles = world.exchange(std::move(messages.triangles));
    if (!triangles) return tl::unexpected(triangles.error());
    auto vertices = world.exchange(std::move(messages.vertices));
    if (!vertices) return tl::unexpected(vertices.error());
    RoutedPart part;
    status = world.agree_on([&]() -> Status {
        auto unpacked = unpack(*triangles, *vertices, part);
        if (!unpacked) return unpacked;
        *triangles = {};
        *vertices = {};
        part.keys = forest->cells();
        return list_triangles(frame, routing_depth, &world.progress(), part);
    });
    if (!status) return tl::unexpected(status.error());
    part.forest = std::move(forest);
    return part;
}

} // namespace proxima
