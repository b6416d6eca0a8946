#include "distributed/route_triangles.h"

#include "base/progress.h"
#include "distributed/local_numbers.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <limits>
#include <optional>
#include <utility>

namespace proxima {

namespace {

struct RoutedTriangle {
    std::uint32_t id = 0;         ///< in the sender's slice, and is_counted_here
    TriangleCorners corners = {}; ///< among the vertices of the same sender
};

/// A bit of RoutedTriangle::id, set on the first rank that the triangle goes to.
constexpr std::uint32_t is_counted_here = 1U << 31U;
static_assert(max_slice_triangles <= is_counted_here);

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

/// Pairs of a triangle and a cell that are cheap to send: their numbers cost no more than the
/// triangles.
constexpr double cheap_pairs_per_triangle = 8;
constexpr double cheap_pairs_per_rank = 1 << 16;
/// Cells that each rank gets at least, whatever they cost, where the options and the mesh allow it.
constexpr double cells_per_rank = 16;

/// The deepest level of at most `depth` whose cells do not make many pairs. Collective.
int cheap_depth(const CoverageSum& slice, int depth, World& world)
{
    std::array<double, 3> sums{slice.triangles, slice.widths, slice.areas};
    world.sum(sums);
    const CoverageSum whole{sums[0], sums[1], sums[2]};
    const auto ranks = static_cast<double>(world.size());
    const double most =
        std::max(cheap_pairs_per_triangle * whole.triangles, cheap_pairs_per_rank * ranks);
    while (depth > 0 && whole.pairs(depth) > most &&
           std::ldexp(1.0, 3 * (depth - 1)) >= cells_per_rank * ranks) {
        --depth;
    }
    return depth;
}

constexpr std::uint32_t none = std::numeric_limits<std::uint32_t>::max();

/// How many triangles touch the cells of each depth. Cells follow in Morton order, so that a triangle
/// was counted for a cell before iff that cell contains the bin in which it was last.
CellCounts count_cells(const CoarseBins& bins, std::size_t triangles)
{
    CellCounts counts(bins.depth);
    std::vector<std::uint32_t> last_bin(triangles, none);
    for (std::uint32_t bin = 0; bin < bins.cell_count(); ++bin) {
        if (bins.count(bin) == 0) continue;
        CellCounts::NewFrom new_from{};
        for (const std::uint32_t id : bins.triangles(bin)) {
            const std::uint32_t last = std::exchange(last_bin[id], bin);
            const int levels =
                (static_cast<int>(std::bit_width(last ^ bin)) + 2) / 3; // below a common cell
            ++new_from[last == none ? 0 : static_cast<std::size_t>(bins.depth - levels + 1)];
        }
        counts.add(bin, new_from);
    }
    return counts;
}

/// For each rank: triangles, ascending; the vertices that they use; and for each bin there, its cell,
/// how many triangles touch it, and their positions among the rank's.
struct Messages {
    std::vector<std::vector<RoutedTriangle>> triangles;
    std::vector<std::vector<Position>> vertices;
    std::vector<std::vector<std::uint32_t>> bins;

    explicit Messages(std::size_t ranks) : triangles(ranks), vertices(ranks), bins(ranks) {}
};

/// Ends of the bins that each rank gets, which begin where those of a rank before end: owners of cells
/// in Morton order ascend.
std::vector<std::size_t> ends_of_owners(const CoarseBins& bins, const RoutedForest& forest,
                                        std::size_t ranks)
{
    std::vector<std::size_t> ends(ranks);
    for (std::size_t bin = 0; bin < bins.cell_count(); ++bin) {
        if (bins.count(bin) == 0) continue;
        ends[static_cast<std::size_t>(forest.owner(bin, bins.depth))] = bin + 1;
    }
    for (std::size_t r = 1; r < ranks; ++r) ends[r] = std::max(ends[r], ends[r - 1]);
    return ends;
}

/// Packs what one rank after the other gets of a slice.
class Packer {
public:
    explicit Packer(const MeshSlice& slice)
        : slice_(slice), is_packed_(slice.mesh.triangle_count()),
          triangle_numbers_(slice.mesh.triangle_count()), vertex_numbers_(slice.mesh.vertex_count())
    {}

    /// What a rank gets of the bins [first, end).
    void pack(const CoarseBins& bins, std::size_t first, std::size_t end, std::size_t rank,
              Messages& messages)
    {
        const std::size_t pairs = bins.first[end] - bins.first[first];
        for (const std::uint32_t id : bins.ids.span().subspan(bins.first[first], pairs))
            triangle_numbers_.add(id);
        const std::uint32_t triangle_count = triangle_numbers_.number();
        pack_vertices(messages.vertices[rank]);
        pack_triangles(triangle_count, messages.triangles[rank]);
        pack_bins(bins, first, end, messages.bins[rank]);
        triangle_numbers_.clear();
        vertex_numbers_.clear();
    }

private:
    void pack_vertices(std::vector<Position>& vertices)
    {
        triangle_numbers_.each([&](std::uint32_t id) {
            for (const std::uint32_t corner : slice_.mesh.triangles()[id])
                vertex_numbers_.add(corner);
        });
        vertices.reserve(vertex_numbers_.number());
        vertex_numbers_.each([&](std::uint32_t vertex) {
            const Vec3& at = slice_.mesh.positions()[vertex];
            vertices.push_back({at[0], at[1], at[2]});
        });
    }

    void pack_triangles(std::size_t count, std::vector<RoutedTriangle>& triangles)
    {
        triangles.resize(count);
        auto next = triangles.begin();
        triangle_numbers_.each([&](std::uint32_t id) {
            RoutedTriangle& triangle = *next++;
            triangle.id = is_packed_[id] ? id : id | is_counted_here;
            is_packed_[id] = true;
            for (std::size_t k = 0; k < 3; ++k)
                triangle.corners[k] = vertex_numbers_.number_of(slice_.mesh.triangles()[id][k]);
        });
    }

    void pack_bins(const CoarseBins& bins, std::size_t first, std::size_t end,
                   std::vector<std::uint32_t>& packed)
    {
        std::size_t headers = 0;
        for (std::size_t bin = first; bin < end; ++bin) headers += bins.count(bin) > 0 ? 2 : 0;
        packed.reserve(headers + bins.first[end] - bins.first[first]);
        for (std::size_t bin = first; bin < end; ++bin) {
            if (bins.count(bin) == 0) continue;
            packed.push_back(static_cast<std::uint32_t>(bin));
            packed.push_back(bins.count(bin));
            for (const std::uint32_t id : bins.triangles(bin))
                packed.push_back(triangle_numbers_.number_of(id));
        }
    }

    const MeshSlice& slice_;
    std::vector<bool> is_packed_;   ///< for an earlier rank
    LocalNumbers triangle_numbers_; ///< in the rank's message
    LocalNumbers vertex_numbers_;   ///< likewise
};

Result<Messages> pack_all(const MeshSlice& slice, const CoarseBins& bins,
                          const RoutedForest& forest, std::size_t ranks, Progress* progress)
{
    const std::vector<std::size_t> ends = ends_of_owners(bins, forest, ranks);
    Messages messages(ranks);
    Packer packer(slice);
    StageSteps steps(progress, "packing", bins.ids.size());
    std::size_t first = 0;
    for (std::size_t r = 0; r < ranks; ++r) {
        packer.pack(bins, first, ends[r], r, messages);
        if (!steps.done(bins.first[ends[r]] - bins.first[first]))
            return cancelled("routing triangles");
        first = ends[r];
    }
    return messages;
}

/// Puts what was received into one mesh. `whole_triangles` is the size of the whole mesh, from which each
/// sender's first triangle follows.
Status unpack(const Received<RoutedTriangle>& triangles, const Received<Position>& vertices,
              std::uint64_t whole_triangles, RoutedPart& part)
{
    const auto ranks = static_cast<int>(triangles.first.size() - 1);
    std::vector<Vec3> positions;
    positions.reserve(vertices.items.size());
    for (const Position& at : vertices.items) positions.emplace_back(at[0], at[1], at[2]);
    std::vector<TriangleCorners> corners;
    corners.reserve(triangles.items.size());
    part.triangles.reserve(triangles.items.size());
    for (std::size_t r = 0; r + 1 < triangles.first.size(); ++r) {
        const std::uint64_t first = share_of(whole_triangles, static_cast<int>(r), ranks).first;
        const auto shift = static_cast<std::uint32_t>(vertices.first[r]);
        for (std::size_t i = triangles.first[r]; i < triangles.first[r + 1]; ++i) {
            const RoutedTriangle& triangle = triangles.items[i];
            part.triangles.push_back(first + (triangle.id & ~is_counted_here));
            part.is_counted.push_back((triangle.id & is_counted_here) != 0);
            corners.push_back({triangle.corners[0] + shift, triangle.corners[1] + shift,
                               triangle.corners[2] + shift});
        }
    }
    auto mesh = make_triangle_mesh(std::move(positions), std::move(corners));
    if (!mesh) return tl::unexpected(mesh.error());
    part.mesh = std::move(*mesh);
    return {};
}

/// Fills the lists of part.keys from the bins that came from each rank, which are in Morton order.
Status list_triangles(const Received<std::uint32_t>& bins,
                      const std::vector<std::size_t>& triangles, int routing_depth,
                      RoutedPart& part, Progress* progress)
{
    StageSteps steps(progress, "unpacking", bins.items.size());
    std::vector<std::size_t> next(bins.first.begin(), bins.first.end() - 1); // by rank
    std::vector<std::uint32_t> ids;
    part.lists.reserve(bins.items.size());
    part.first.push_back(0);
    for (const CellKey key : part.keys) {
        const int level = depth(key);
        const std::uint64_t cell = key.bits ^ (std::uint64_t{1} << (3 * level));
        const std::uint64_t end = (cell + 1) << (3 * (routing_depth - level));
        for (std::size_t r = 0; r < next.size(); ++r) {
            ids.clear();
            int bin_count = 0;
            for (; next[r] < bins.first[r + 1] && bins.items[next[r]] < end; ++bin_count) {
                const std::uint32_t* const in_bin = &bins.items[next[r]] + 2;
                ids.insert(ids.end(), in_bin, in_bin + in_bin[-1]);
                next[r] += 2 + in_bin[-1];
            }
            if (bin_count > 1) {
                std::ranges::sort(ids);
                ids.erase(std::unique(ids.begin(), ids.end()), ids.end());
            }
            // Slices ascend.
            const auto shift = static_cast<std::uint32_t>(triangles[r]);
            for (const std::uint32_t id : ids) part.lists.push_back(TriangleId{id + shift});
        }
        if (!steps.done(part.lists.size() - part.first.back()))
            return cancelled("routing triangles");
        part.first.push_back(part.lists.size());
    }
    return {};
}

} // namespace

Result<RoutedPart> route_triangles(MeshSlice slice, const OctreeFrame& frame,
                                   const RouteOptions& options, World& world)
{
    Progress* const progress = &world.progress();
    std::optional<SnappedMesh> snapped;
    CoverageSum coverage;
    Status status = world.agree_on([&]() -> Status {
        begin_stage(progress, "routing",
                    slice.mesh.vertex_count() + 2 * slice.mesh.triangle_count());
        snapped.emplace(slice.mesh, frame, Threads{1}, progress);
        if (!is_cancelled(progress)) coverage = sum_coverage(*snapped);
        return {};
    });
    if (!status) return tl::unexpected(status.error());
    const int routing_depth = cheap_depth(coverage, usable_depth(frame, options), world);
    CoarseBins bins;
    CellCounts counts(routing_depth);
    status = world.agree_on([&]() -> Status {
        auto binned = bin_triangles(*snapped, routing_depth, Threads{1}, progress);
        if (!binned) return tl::unexpected(binned.error());
        bins = std::move(*binned);
        snapped.reset();
        if (is_cancelled(progress)) return cancelled("routing triangles");
        counts = count_cells(bins, slice.mesh.triangle_count());
        return {};
    });
    if (!status) return tl::unexpected(status.error());
    auto forest = std::make_unique<RoutedForest>();
    status = forest->build(counts, options.threshold, world);
    if (!status) return tl::unexpected(status.error());

    const std::uint64_t whole_triangles = slice.whole_triangles;
    Messages messages(0);
    status = world.agree_on([&]() -> Status {
        auto packed =
            pack_all(slice, bins, *forest, static_cast<std::size_t>(world.size()), progress);
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
    const auto listed = world.exchange(std::move(messages.bins));
    if (!listed) return tl::unexpected(listed.error());
    RoutedPart part;
    status = world.agree_on([&]() -> Status {
        auto unpacked = unpack(*triangles, *vertices, whole_triangles, part);
        if (!unpacked) return unpacked;
        const std::vector<std::size_t> first = std::move(triangles->first);
        *triangles = {};
        *vertices = {};
        part.keys = forest->cells();
        return list_triangles(*listed, first, routing_depth, part, progress);
    });
    if (!status) return tl::unexpected(status.error());
    part.forest = std::move(forest);
    return part;
}

} // namespace proxima
