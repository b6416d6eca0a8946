#include "proxima/proximity/build_proximity_octree.h"

#include "proxima/base/hash.h"
#include "proxima/base/text.h"
#include "proxima/mesh/triangle_order.h"
#include "proxima/proximity/cut_cells.h"
#include "proxima/proximity/emit_octree.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>
#include <memory>
#include <utility>

namespace proxima {

namespace {

/// All arrays of an octree that was built.
struct ProximityStorage {
    EmittedOctree cells;
    TriangleTree tree;
    GrowBuffer<TriangleRow<float>> float_rows;
    GrowBuffer<TriangleRow<double>> double_rows;
    GrowBuffer<std::uint32_t> vertex_places;
    GrowBuffer<std::uint32_t> edge_places;
};

Error cancelled()
{
    return {ErrorCode::cancelled, "building the proximity octree was cancelled", {}};
}

/// Whether a normal float holds the number exactly: by its bits, as compilers may drop the rounding
/// of a conversion there and back.
bool fits_float(double number)
{
    if (number == 0) return true;
    const auto bits = std::bit_cast<std::uint64_t>(number);
    constexpr std::uint64_t lost = (std::uint64_t{1} << 29U) - 1;
    const int exponent = std::ilogb(number);
    return (bits & lost) == 0 && exponent >= -126 && exponent <= 127;
}

/// Whether floats hold every position exactly.
bool fit_floats(const TriangleMesh& mesh)
{
    return std::ranges::all_of(mesh.positions(), [](const Vec3& p) {
        return fits_float(p[0]) && fits_float(p[1]) && fits_float(p[2]);
    });
}

/// Longest side by height beyond which a triangle's inside wants care: up to there feet are right
/// to 2^-52 times its square, of the side.
constexpr double thin_condition = 32;

bool is_thin(const Triangle& triangle)
{
    const Vec3 ab = triangle[1] - triangle[0];
    const Vec3 ac = triangle[2] - triangle[0];
    const Vec3 bc = triangle[2] - triangle[1];
    const double squared = std::max({ab.squaredNorm(), ac.squaredNorm(), bc.squaredNorm()});
    return !(squared <= thin_condition * ab.cross(ac).norm());
}

template <class Scalar>
GrowBuffer<TriangleRow<Scalar>> make_rows(const TriangleMesh& mesh, const Topology& topology,
                                          std::span<const TriangleId> order)
{
    GrowBuffer<TriangleRow<Scalar>> rows;
    rows.resize(order.size());
    for (std::size_t rank = 0; rank < order.size(); ++rank) {
        const TriangleId id = order[rank];
        const Triangle triangle = mesh.triangle(id);
        TriangleRow<Scalar>& row = rows[rank];
        row = {};
        row.triangle = index(id) | (is_thin(triangle) ? TriangleRow<Scalar>::thin_bit : 0U);
        for (int i = 0; i < 3; ++i) {
            const auto k = static_cast<std::size_t>(i);
            for (int axis = 0; axis < 3; ++axis)
                row.coordinates[axis][i] = static_cast<Scalar>(triangle[i][axis]);
            const TriangleCorners& corners = mesh.triangles()[index(id)];
            row.vertices[i] = corners[k];
            if (corners[k] > corners[(k + 1) % 3])
                row.triangle |= TriangleRow<Scalar>::side_bit << k;
            row.edges[i] = index(topology.edges(id)[k]);
        }
    }
    return rows;
}

/// Builds one octree; members are what the stages hand on.
class ProximityBuilder {
public:
    ProximityBuilder(const TriangleMesh& mesh, const Topology& topology, const Box& bounds,
                     const ProximityOptions& options)
        : mesh_(mesh), topology_(topology), bounds_(bounds), options_(options),
          frame_(make_root_frame(bounds, options.margin))
    {}

    Result<ProximityOctree> build()
    {
        auto storage = std::make_shared<ProximityStorage>();
        if (!sort_triangles()) return tl::unexpected(cancelled());
        auto tree = build_triangle_tree(
            mesh_, order_, {.threads = options_.threads, .progress = options_.progress});
        if (!tree) return tl::unexpected(tree.error());
        storage->tree = std::move(*tree);
        if (!make_tables(*storage)) return tl::unexpected(cancelled());
        const std::uint64_t fixed = table_bytes(*storage);
        const std::uint64_t least = fixed + least_cell_bytes;
        const std::uint64_t usual =
            std::max(default_bytes_per_triangle * mesh_.triangle_count(), least + usual_cell_bytes);
        const std::uint64_t budget = options_.budget_bytes != 0 ? options_.budget_bytes : usual;
        if (budget < least) {
            return fail(ErrorCode::budget_exceeded,
                        concat("a proximity octree of ", mesh_.triangle_count(),
                               " triangles takes at least ", least, " bytes, the budget is ",
                               budget, ": raise the budget"));
        }
        make_source();
        const auto bytes = static_cast<double>(budget - fixed);
        auto forest = grow(bytes);
        if (!forest) return tl::unexpected(cancelled());
        auto cells = emit(*forest, bytes);
        if (!cells) return tl::unexpected(cancelled());
        storage->cells = std::move(*cells);
        return adopt(std::move(storage));
    }

private:
    bool sort_triangles()
    {
        const auto items = triangle_order(mesh_, bounds_, SpaceCurve::morton, options_.progress);
        if (!items) return false;
        order_.reserve(items->size());
        for (const KeyedIndex& item : *items) order_.push_back(TriangleId{item.index});
        return true;
    }

    bool make_tables(ProximityStorage& storage)
    {
        if (fit_floats(mesh_))
            storage.float_rows = make_rows<float>(mesh_, topology_, order_);
        else
            storage.double_rows = make_rows<double>(mesh_, topology_, order_);
        storage.vertex_places.resize(topology_.vertex_count());
        for (std::uint32_t i = 0; i < topology_.vertex_count(); ++i) {
            const auto star = topology_.triangles(VertexId{i});
            storage.vertex_places[i] =
                star.empty() ? place_word::none : place_of_vertex(star.front(), i);
        }
        storage.edge_places.resize(topology_.edge_count());
        for (std::uint32_t i = 0; i < topology_.edge_count(); ++i) {
            storage.edge_places[i] =
                place_of_edge(topology_.triangles(EdgeId{i}).front(), EdgeId{i});
        }
        return !is_cancelled(options_.progress);
    }

    [[nodiscard]] std::uint32_t place_of_vertex(TriangleId triangle, std::uint32_t vertex) const
    {
        const TriangleCorners& corners = mesh_.triangles()[index(triangle)];
        const auto corner = std::ranges::find(corners, vertex) - corners.begin();
        return place_word::make(index(triangle), static_cast<std::uint32_t>(corner), false);
    }

    /// The side between the first corners of its vertices, as side_of() has it.
    [[nodiscard]] std::uint32_t place_of_edge(TriangleId triangle, EdgeId edge) const
    {
        const TriangleCorners& corners = mesh_.triangles()[index(triangle)];
        const auto first = [&](std::uint32_t corner) {
            return std::ranges::find(corners, corners[corner]) - corners.begin() == corner;
        };
        std::uint32_t side = 2;
        for (std::uint32_t k = 0; k < 2; ++k)
            if (topology_.edges(triangle)[k] == edge && first(k) && first(k + 1)) side = k;
        const std::uint32_t next = side == 2 ? 0 : side + 1;
        return place_word::make(index(triangle), side, corners[side] > corners[next]);
    }

    static std::uint64_t table_bytes(const ProximityStorage& storage)
    {
        return storage.float_rows.span().size_bytes() + storage.double_rows.span().size_bytes() +
               storage.vertex_places.span().size_bytes() + storage.edge_places.span().size_bytes() +
               storage.tree.bytes();
    }

    /// One leaf without a list, and what comes with every arena.
    static constexpr std::uint64_t least_cell_bytes = 1024;

    /// For the cells of meshes so small that bytes per triangle would not do.
    static constexpr std::uint64_t usual_cell_bytes = 65536;

    /// What blocks are made from.
    void make_source()
    {
        positions_.reserve(mesh_.vertex_count());
        for (const Vec3& p : mesh_.positions()) positions_.push_back(frame_.to_frame(p));
        corners_.reserve(order_.size());
        for (const TriangleId id : order_) corners_.push_back(mesh_.triangles()[index(id)]);
    }

    [[nodiscard]] EmitOptions emit_options() const
    {
        return {frame_.frame_half(), options_.threads, options_.progress};
    }

    /// Cells that a budget of so many bytes may need, and few more.
    std::optional<GrownForest> grow(double bytes)
    {
        const auto features =
            collect_local_features(mesh_, topology_, order_, frame_, options_.progress);
        if (!features) return std::nullopt;
        const auto density = QueryDensity::sample(mesh_, bounds_, frame_, options_.progress);
        if (!density) return std::nullopt;
        GrowOptions growing;
        growing.max_depth = options_.max_depth;
        growing.threads = options_.threads;
        growing.progress = options_.progress;
        auto top = grow_top(*features, *density, frame_.frame_half(), growing);
        if (!top) return std::nullopt;
        if (!grow_sample(*features, *density, *top, bytes, growing)) return std::nullopt;
        growing.cost.price = 0.5 * price_;
        std::vector<const OpenCell*> all;
        for (const OpenCell& cell : top->open) all.push_back(&cell);
        auto below = grow_below(*features, *density, all, growing);
        if (!below) return std::nullopt;
        return join_forest(std::move(*top), std::move(*below));
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
            if (static_cast<std::uint32_t>(i) * 2654435761U % (stride << 16U) >= 1U << 16U)
                continue;
            cells.push_back(&top.open[i]);
            sampled += list;
        }
        price_ = 1.0 / static_cast<double>(mesh_.triangle_count());
        sample_price_ = price_;
        if (cells.empty()) return true;
        // The table and the blocks by rank take the rest.
        sample_share_ = 0.95 * bytes * sampled / all;
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

    /// Raises price_, at which the sample takes so much, until it takes its share. False where
    /// cancelled.
    bool find_price(double taken)
    {
        double low = price_;
        double high = price_;
        while (taken > sample_share_) {
            low = high;
            high *= 4;
            const auto there = sample_bytes(high);
            if (!there) return false;
            taken = *there;
        }
        for (int halvings = 0; halvings < 5 && high > low; ++halvings) {
            const double middle = std::sqrt(low * high);
            const auto there = sample_bytes(middle);
            if (!there) return false;
            (*there > sample_share_ ? low : high) = middle;
            if (std::abs(*there - sample_share_) < 0.01 * sample_share_) break;
        }
        price_ = high;
        return true;
    }

    /// What the sample takes at a price. Null where cancelled.
    std::optional<double> sample_bytes(double price)
    {
        cut_trees(sample_, price);
        return emitted_bytes(sample_, {positions_, corners_}, emit_options());
    }

    /// Cut to the budget: what blocks really take is known only when they are made. The sample
    /// tells by how much to raise the price where it is not enough.
    std::optional<EmittedOctree> emit(GrownForest& forest, double bytes)
    {
        double low = 0; // too large there
        double high = std::numeric_limits<double>::infinity();
        for (int tries = 0;; ++tries) {
            cut_cells(forest, price_);
            auto octree = emit_octree(forest, {positions_, corners_}, emit_options());
            if (!octree || forest.top.cells[0].ended != 0) return octree;
            const double used = static_cast<double>(octree->bytes()) / bytes;
            const bool is_enough = used > 0.9 || price_ <= sample_price_ || tries >= 3;
            if (used <= 1 && is_enough) return octree;
            (used > 1 ? low : high) = price_;
            sample_share_ *= 0.97 / used;
            price_ = sample_price_;
            if (!sample_.empty()) {
                const auto taken = sample_bytes(price_);
                if (!taken || !find_price(*taken)) return std::nullopt;
            }
            if (low > 0 && high < std::numeric_limits<double>::infinity())
                price_ = tries < 2 ? std::sqrt(low * high) : high;
            else
                price_ = std::max(price_, low * (1.1 + tries * tries)); // where the sample misleads
        }
    }

    ProximityOctree adopt(std::shared_ptr<ProximityStorage> storage)
    {
        const ProximityArrays arrays{storage->cells.table.span(),   storage->cells.nodes.span(),
                                     storage->cells.runs.span(),    storage->cells.arena.span(),
                                     storage->float_rows.span(),    storage->double_rows.span(),
                                     storage->vertex_places.span(), storage->edge_places.span()};
        const int table_depth = storage->cells.table_depth;
        const ProximityStatistics statistics = storage->cells.statistics;
        const TriangleTree* const tree = &storage->tree;
        return ProximityOctree::adopt(frame_, table_depth, arrays, tree, statistics,
                                      mesh_fingerprint(mesh_), std::move(storage));
    }

    const TriangleMesh& mesh_;
    const Topology& topology_;
    Box bounds_;
    const ProximityOptions& options_;
    RootFrame frame_;
    std::vector<TriangleId> order_;
    std::vector<Vec3> positions_;                       ///< in the frame
    std::vector<std::array<std::uint32_t, 3>> corners_; ///< vertices by rank
    double price_ = 0;                                  ///< of a byte, for the budget at hand
    std::vector<GrownTree> sample_;                     ///< some trees
    double sample_price_ = 0;                           ///< at which they were grown
    double sample_share_ = 0;                           ///< what they may take
};

Status check_options(const TriangleMesh& mesh, const Topology& topology,
                     const ProximityOptions& options)
{
    if (!(options.margin >= 0 && options.margin <= 1e3)) {
        return fail(ErrorCode::invalid_argument, "margin must be 0 to 1000", "margin");
    }
    if (options.max_depth < 0 || options.max_depth > max_proximity_depth) {
        return fail(ErrorCode::invalid_argument, concat("depth must be 0 to ", max_proximity_depth),
                    "max_depth");
    }
    if (mesh.triangle_count() > max_proximity_triangles) {
        return fail(ErrorCode::limit_exceeded,
                    concat("a proximity octree takes at most ", max_proximity_triangles,
                           " triangles, the mesh has ", mesh.triangle_count(),
                           ": split or simplify it"));
    }
    if (topology.triangle_count() != mesh.triangle_count() ||
        topology.vertex_count() != mesh.vertex_count()) {
        return fail(ErrorCode::invalid_argument, "the topology is another mesh's", "topology");
    }
    return {};
}

} // namespace

std::uint64_t mesh_fingerprint(const TriangleMesh& mesh)
{
    const std::uint64_t positions = hash_bytes(std::as_bytes(mesh.positions()), 0);
    return hash_bytes(std::as_bytes(mesh.triangles()), positions);
}

Result<ProximityOctree> build_proximity_octree(const TriangleMesh& mesh, const Topology& topology,
                                               const ProximityOptions& options)
{
    const auto bounds = checked_bounding_box(mesh);
    if (!bounds) return tl::unexpected(bounds.error());
    if (!(bounds->extent().maxCoeff() < 1e150)) {
        return fail(ErrorCode::limit_exceeded, "the mesh is more than 1e150 across: scale it");
    }
    if (const Status status = check_options(mesh, topology, options); !status)
        return tl::unexpected(status.error());
    return ProximityBuilder(mesh, topology, *bounds, options).build();
}

Result<ProximityOctree> build_proximity_octree(const TriangleMesh& mesh,
                                               const ProximityOptions& options)
{
    TopologyOptions topology_options;
    topology_options.threads = options.threads;
    topology_options.progress = options.progress;
    const auto topology = build_topology(mesh, topology_options);
    if (!topology) return tl::unexpected(topology.error());
    return build_proximity_octree(mesh, *topology, options);
}

} // namespace proxima
