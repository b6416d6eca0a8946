#include "proxima/mesh_index.h"

#include "base/memory_budget.h"
#include "base/progress.h"
#include "base/text.h"
#include "index/index_parts.h"
#include "index/lists/cut_cells.h"
#include "index/lists/emit_lists.h"
#include "proxima/topology.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>
#include <memory>
#include <utility>

namespace proxima {

namespace {

/// Bytes per triangle that building takes at least, measured: 1.0 to 1.9 KB where lists are short.
constexpr std::uint64_t least_scratch = 800;
/// Bytes for each byte of long lists, themselves included, measured: 2 to 3.3.
constexpr std::uint64_t scratch_of_lists = 4;

/// How large the lists may become: as wanted, but of more than is usual what the budget has room for.
std::uint64_t list_bytes_of(std::uint64_t triangles, const ListOptions& options)
{
    const std::uint64_t usual = default_list_bytes(triangles);
    if (options.list_bytes == 0) return usual;
    if (options.list_bytes <= usual) return options.list_bytes;
    const std::uint64_t room = budget_bytes(options.execution.budget);
    const std::uint64_t scratch = least_scratch * triangles;
    const std::uint64_t most = room > scratch ? (room - scratch) / scratch_of_lists : 0;
    return std::clamp(most, usual, options.list_bytes);
}

/// Builds the lists of one index; members are what the stages hand on.
class ListBuilder {
public:
    /// `order` are the triangles by the ranks that lists name.
    ListBuilder(const TriangleMesh& mesh, const Topology& topology,
                std::span<const TriangleId> order, const Box& bounds, const ListOptions& options)
        : mesh_(mesh), topology_(topology), order_(order), bounds_(bounds), options_(options),
          frame_(make_root_frame(bounds, options.margin))
    {}

    Result<std::shared_ptr<const ProximityLists>> build()
    {
        const std::uint64_t budget = list_bytes_of(mesh_.triangle_count(), options_);
        if (budget < least_cell_bytes) {
            return fail(ErrorCode::budget_exceeded,
                        concat("closest-feature lists take at least ", least_cell_bytes,
                               " bytes, they may take ", budget, ": allow more"),
                        "list_bytes");
        }
        make_source();
        const auto bytes = static_cast<double>(budget);
        auto forest = grow(bytes);
        if (!forest) return cancelled("building closest-feature lists");
        auto cells = emit(*forest, bytes);
        if (!cells) return cancelled("building closest-feature lists");
        auto storage = std::make_shared<EmittedLists>(std::move(*cells));
        const ProximityArrays arrays{storage->table.span(), storage->nodes.span(),
                                     storage->runs.span(), storage->arena.span()};
        const int table_depth = storage->table_depth;
        const ProximityStatistics statistics = storage->statistics;
        return std::make_shared<const ProximityLists>(
            ProximityLists::adopt(frame_, table_depth, arrays, statistics, std::move(storage)));
    }

private:
    /// One leaf without a list, and what comes with every arena.
    static constexpr std::uint64_t least_cell_bytes = 1024;
    /// What trees take of the bytes. The table and the blocks by rank take the rest.
    static constexpr double sampled_part = 0.93;

    /// What blocks are made from.
    void make_source()
    {
        positions_.reserve(mesh_.vertex_count());
        for (const Vec3& p : mesh_.positions()) positions_.push_back(frame_.to_frame(p));
        corners_.reserve(order_.size());
        for (const TriangleId id : order_) corners_.push_back(mesh_.triangles()[to_index(id)]);
    }

    [[nodiscard]] EmitOptions emit_options() const
    {
        return {frame_.frame_half(), options_.execution};
    }

    /// Cells that a budget of so many bytes may need, and few more.
    std::optional<GrownForest> grow(double bytes)
    {
        const auto features =
            collect_local_features(mesh_, topology_, order_, frame_, options_.execution.progress);
        if (!features) return std::nullopt;
        const auto density =
            QueryDensity::sample(mesh_, bounds_, frame_, options_.execution.progress);
        if (!density) return std::nullopt;
        GrowOptions growing;
        growing.max_depth = options_.max_depth;
        growing.execution = options_.execution;
        auto top = grow_top(*features, *density, frame_.frame_half(), growing);
        if (!top) return std::nullopt;
        growing.most_work = most_work(*features, *top);
        if (!grow_sample(*features, *density, *top, bytes, growing)) return std::nullopt;
        growing.cost.price = 0.5 * price_;
        std::vector<const OpenCell*> all;
        for (const OpenCell& cell : top->open) all.push_back(&cell);
        auto below = grow_below(*features, *density, all, growing);
        if (!below) return std::nullopt;
        return join_forest(std::move(*top), std::move(*below));
    }

    /// Below its topmost cells a mesh takes up to about 120 times its features; where many triangles are in the same
    /// place, without a limit, the square of them.
    static double most_work(const LocalFeatures& features, const GrownTop& top)
    {
        constexpr double of_all = 1024;
        double open = 1;
        for (const OpenCell& cell : top.open) open += static_cast<double>(cell.features.size());
        return of_all * static_cast<double>(features.features.size()) / open;
    }

    /// Every sixteenth part of the octree, at a price at which it takes at least its share of the
    /// bytes, and price_ where it takes just that. False where cancelled.
    bool grow_sample(const LocalFeatures& features, const QueryDensity& density,
                     const GrownTop& top, double bytes, GrowOptions growing)
    {
        constexpr std::size_t stride = 16;
        std::vector<const OpenCell*> cells;
        double all = 0;
        double sampled = 0;
        for (std::size_t i = 0; i < top.open.size(); ++i) {
            const auto list = static_cast<double>(top.open[i].features.size());
            all += list;
            // Scattered, or a regular mesh would have what is alike in the sample.
            const std::uint32_t scattered = static_cast<std::uint32_t>(i) * 2654435761U;
            if (scattered % (stride << 16U) >= 1U << 16U) continue;
            cells.push_back(&top.open[i]);
            sampled += list;
        }
        // Four times of what the usual budget comes to on scanned meshes.
        price_ = 0x1p-8 / static_cast<double>(mesh_.triangle_count());
        sample_price_ = price_;
        if (cells.empty()) return true;
        sample_share_ = sampled_part * bytes * sampled / all;
        double last = 0;
        for (int tries = 0; tries < 16; ++tries, price_ /= 4) {
            growing.cost.price = price_;
            auto trees = grow_below(features, density, cells, growing);
            if (!trees) return false;
            sample_ = std::move(*trees);
            sample_price_ = price_;
            const auto taken = sample_bytes(price_);
            if (!taken) return false;
            // Enough, or no cheaper price makes more of it: all fits.
            if (*taken >= sample_share_) return find_price(*taken);
            if (tries > 0 && *taken < 1.01 * last) break;
            last = *taken;
        }
        return true;
    }

    /// Changes price_, at which the sample takes so much, until it takes its share: between two
    /// prices where bytes are a power of the price. False where cancelled.
    bool find_price(double taken)
    {
        struct Sample {
            double price = 0; ///< 0: not known
            double over = 0;  ///< logarithm of bytes over the share
        };
        Sample low;  // takes too much
        Sample high; // does not
        for (int tries = 0; tries < 10; ++tries) {
            const double over = std::log(taken / sample_share_);
            (over > 0 ? low : high) = {price_, over};
            if (over <= 0 && (over > -0.01 || price_ <= sample_price_)) return true;
            if (low.price == 0) {
                price_ = std::max(price_ / 2, sample_price_);
            } else if (high.price == 0) {
                price_ *= 2;
            } else {
                // Not too near an end, which may be where the curve is steep.
                const double part = std::clamp(low.over / (low.over - high.over), 0.2, 0.8);
                price_ = low.price * std::pow(high.price / low.price, part);
                if (high.price < 1.01 * low.price) break;
            }
            const auto there = sample_bytes(price_);
            if (!there) return false;
            taken = *there;
        }
        if (high.price > 0) price_ = high.price;
        return true;
    }

    /// What the sample takes at a price. Null where cancelled.
    std::optional<double> sample_bytes(double price)
    {
        (void)cut_trees(sample_, price, options_.execution.threads);
        return emitted_bytes(sample_, {positions_, corners_}, emit_options());
    }

    /// Cut to the budget: what blocks really take is known only when they are made. The sample
    /// tells by how much to raise the price where it is not enough.
    std::optional<EmittedLists> emit(GrownForest& forest, double bytes)
    {
        const Threads threads = options_.execution.threads;
        std::optional<EmittedLists> best;
        double low = 0;  // too large there
        double high = 0; // not too large there; 0: not known
        for (int tries = 0;; ++tries) {
            const double modelled = cut_cells(forest, price_, threads);
            if (tries == 0 && !sample_.empty()) {
                // Now it is known what part of all the sample is.
                sample_share_ =
                    sampled_part * bytes * cut_trees(sample_, price_, threads) / modelled;
                const auto taken = sample_bytes(price_);
                if (!taken || !find_price(*taken)) return std::nullopt;
                (void)cut_cells(forest, price_, threads);
            }
            auto octree = emit_lists(forest, {positions_, corners_}, emit_options());
            if (!octree) return std::nullopt;
            const double used = octree->part_of(bytes);
            if (used <= 1 && (!best || octree->bytes() > best->bytes())) best = std::move(octree);
            const double best_used = best ? best->part_of(bytes) : 0;
            const int most_tries = best_used > 0.5 ? 2 : 8;
            if (best && (best_used > 0.9 || price_ <= sample_price_ || tries >= most_tries))
                return best;
            GrownCell& root = forest.top.cells[0];
            if (used > 1 && root.ended != 0) {
                // Even one list is too large: none.
                root.searched = 1;
                return best ? std::move(best)
                            : emit_lists(forest, {positions_, corners_}, emit_options());
            }
            (used > 1 ? low : high) = price_;
            sample_share_ *= 0.97 / used;
            if (!sample_.empty()) {
                const auto taken = sample_bytes(price_);
                if (!taken || !find_price(*taken)) return std::nullopt;
            }
            // Where the sample misleads, or there is none.
            if (used > 1) price_ = std::max(price_, low * (1.1 + tries * tries));
            if (low > 0 && high > 0 && !(price_ > low && price_ < high))
                price_ = std::sqrt(low) * std::sqrt(high);
        }
    }

    const TriangleMesh& mesh_;
    const Topology& topology_;
    std::span<const TriangleId> order_;
    Box bounds_;
    const ListOptions& options_;
    RootFrame frame_;
    std::vector<Vec3> positions_;                       ///< in the frame
    std::vector<std::array<std::uint32_t, 3>> corners_; ///< vertices by rank
    double price_ = 0;                                  ///< of a byte, for the budget at hand
    std::vector<GrownTree> sample_;                     ///< some trees
    double sample_price_ = 0;                           ///< at which they were grown
    double sample_share_ = 0;                           ///< what they may take
};

Status check_options(const IndexParts& index, const ListOptions& options)
{
    if (!(options.margin >= 0 && options.margin <= max_list_margin)) {
        return fail(ErrorCode::invalid_argument,
                    concat("margin must be 0 to ", max_list_margin, ", not ", options.margin),
                    "margin");
    }
    if (options.max_depth < 0 || options.max_depth > max_list_depth) {
        return fail(ErrorCode::invalid_argument, concat("depth must be 0 to ", max_list_depth),
                    "max_depth");
    }
    if (index.triangle_count() > max_listed_triangles) {
        return fail(ErrorCode::limit_exceeded,
                    concat("closest-feature lists take at most ", max_listed_triangles,
                           " triangles, the mesh has ", index.triangle_count(),
                           ": split or simplify it"));
    }
    const std::uint64_t lists = std::min(list_bytes_of(index.triangle_count(), options),
                                         default_list_bytes(index.triangle_count()));
    return check_budget(options.execution.budget, least_scratch * index.triangle_count() + lists,
                        "building closest-feature lists", "raise the budget or lower list_bytes");
}

/// The mesh's box, where squared distances, and those of parts of 1e-10 of it, are numbers.
Result<Box> checked_bounds(const TriangleMesh& mesh)
{
    constexpr double most_extent = 1e150;
    constexpr double least_extent = 1e-140;
    Result<Box> bounds = checked_bounding_box(mesh);
    const double extent = bounds ? bounds->extent().maxCoeff() : 0;
    if (bounds && !(extent < most_extent)) {
        return fail(ErrorCode::invalid_mesh,
                    "the mesh is too large for squared distances to be numbers: scale it down");
    }
    if (extent > 0 && extent < least_extent) {
        return fail(ErrorCode::invalid_mesh,
                    concat("the mesh is ", extent,
                           " large: squared distances would be 0; scale it towards size 1"));
    }
    return bounds;
}

} // namespace

Result<MeshIndex> with_lists(const MeshIndex& index, const ListOptions& options)
{
    if (const Status status = check_options(index.parts(), options); !status)
        return tl::unexpected(status.error());
    const auto mesh = mesh_of(index);
    if (!mesh) return tl::unexpected(mesh.error());
    const auto bounds = checked_bounds(*mesh);
    if (!bounds) return tl::unexpected(bounds.error());
    const auto topology = build_topology(*mesh, {.execution = options.execution});
    if (!topology) return tl::unexpected(topology.error());
    auto lists = ListBuilder(*mesh, *topology, index.ids(), *bounds, options).build();
    if (!lists) return tl::unexpected(lists.error());
    return make_mesh_index(index.parts().adopt_lists(std::move(*lists)));
}

} // namespace proxima
