#include "thesis/proximity_octree/thesis_proximity_octree.h"

#include "base/progress.h"
#include "base/text.h"
#include "octree/reaching_edge.h"
#include "proxima/octree.h"
#include "thesis/proximity_octree/convex_surface.h"
#include "thesis/proximity_octree/grown_regions.h"
#include "thesis/proximity_octree/label_cells.h"

#include <limits>
#include <new>

namespace proxima {
namespace {

constexpr double max_coordinate = 1e100;
constexpr std::size_t max_nodes = std::size_t{1} << 31U;

Status check_options(const ThesisProximityOptions& options)
{
    if (options.max_depth < 0 || options.max_depth > max_octree_depth) {
        return fail(
            ErrorCode::invalid_argument,
            concat("the depth must be from 0 to ", max_octree_depth, ", not ", options.max_depth));
    }
    if (!(options.margin >= 0 && options.margin <= max_root_margin)) {
        return fail(ErrorCode::invalid_argument, concat("the margin must be from 0 to ",
                                                        max_root_margin, ", not ", options.margin));
    }
    if (!(options.convexity_tolerance >= 0 && options.convexity_tolerance <= 1) ||
        !(options.flat_sine >= 0 && options.flat_sine <= 1)) {
        return fail(ErrorCode::invalid_argument, "tolerances must be from 0 to 1");
    }
    return {};
}

Status check_mesh(const TriangleMesh& mesh, const Topology& topology)
{
    const auto bounds = checked_bounding_box(mesh);
    if (!bounds) return tl::unexpected(bounds.error());
    if (bounds->lower.cwiseAbs().cwiseMax(bounds->upper.cwiseAbs()).maxCoeff() > max_coordinate)
        return fail(ErrorCode::invalid_mesh, "coordinates beyond 1e100: scale the mesh down");
    const std::size_t features =
        topology.vertex_count() + topology.edge_count() + topology.triangle_count();
    if (features > std::numeric_limits<std::uint32_t>::max()) {
        return fail(ErrorCode::limit_exceeded,
                    concat("the mesh has ", features, " features: at most 2^32 - 1 can be listed"));
    }
    return {};
}

/// The tight cube, grown about its centre.
OctreeFrame grown_root(const Box& bounds, double margin)
{
    const OctreeFrame tight = tight_root(bounds, RootShape::cube);
    OctreeFrame root;
    root.lower = tight.lower - 0.5 * margin * tight.edge;
    root.lower = root.lower.cwiseMin(tight.lower);
    double edge = tight.edge.x() + margin * tight.edge.x();
    for (int axis = 0; axis < 3; ++axis)
        edge = reaching_edge(root.lower[axis], edge, tight.lower[axis] + tight.edge[axis]);
    root.edge = Vec3::Constant(edge);
    return root;
}

/// Turns levels of labelled cells into nodes and leaves, breadth first.
class OctreeWriter {
public:
    OctreeWriter(ThesisProximityOctree::Parts& parts, const FeatureNumbers& numbers)
        : parts_(parts), numbers_(numbers)
    {
        parts_.nodes.push_back(0);
    }

    /// Writes the leaves of a level and returns which of its cells split; their children are the
    /// next level, eight each. \pre cells are the level's in order
    Result<std::vector<std::uint32_t>> write(const LabelledCells& cells)
    {
        std::vector<std::uint32_t> split;
        const std::size_t level_begin = parts_.nodes.size() - cells.size();
        for (std::uint32_t cell = 0; cell < cells.size(); ++cell) {
            std::uint32_t& node = parts_.nodes[level_begin + cell];
            if (should_split(cells, cell)) {
                node = static_cast<std::uint32_t>(parts_.nodes.size() + 8 * split.size());
                split.push_back(cell);
            } else {
                node = ThesisProximityOctree::leaf_bit |
                       static_cast<std::uint32_t>(parts_.leaves.size());
                if (Status status = add_leaf(cells, cell); !status)
                    return tl::unexpected(status.error());
            }
        }
        parts_.depth_reached = depth(cells.keys.front());
        if (parts_.nodes.size() + 8 * split.size() > max_nodes) {
            return fail(ErrorCode::limit_exceeded,
                        "the octree would have more than 2^31 cells: lower the depth");
        }
        parts_.nodes.resize(parts_.nodes.size() + 8 * split.size());
        return split;
    }

private:
    [[nodiscard]] bool should_split(const LabelledCells& cells, std::uint32_t cell) const
    {
        if (depth(cells.keys[cell]) >= parts_.max_depth) return false;
        if (cells.types[cell] == CellClass::inner) return false;
        // Boundary cells by what they contain, outer ones by what they are closest to.
        const auto list = cells.types[cell] == CellClass::boundary ? cells.touching.list(cell)
                                                                   : cells.closest.list(cell);
        return std::ranges::any_of(all_feature_kinds, [&](FeatureKind kind) {
            return of_kind(list, numbers_, kind).size() > parts_.thresholds.of(kind);
        });
    }

    Status add_leaf(const LabelledCells& cells, std::uint32_t cell)
    {
        ThesisLeaf leaf;
        leaf.type = cells.types[cell];
        leaf.first = static_cast<std::uint32_t>(parts_.labels.size());
        for (const FeatureKind kind : all_feature_kinds) {
            const auto closest = of_kind(cells.closest.list(cell), numbers_, kind);
            const auto touching = of_kind(cells.touching.list(cell), numbers_, kind);
            const auto k = static_cast<std::size_t>(kind);
            leaf.closest[k] = static_cast<std::uint32_t>(closest.size());
            leaf.touching[k] = static_cast<std::uint32_t>(touching.size());
            const std::uint32_t zero = numbers_.first(kind);
            for (const std::uint32_t number : touching) parts_.labels.push_back(number - zero);
            auto next_touching = touching.begin();
            for (const std::uint32_t number : closest) {
                if (next_touching != touching.end() && *next_touching == number) {
                    ++next_touching;
                } else {
                    parts_.labels.push_back(number - zero);
                }
            }
        }
        parts_.leaves.push_back(leaf);
        if (parts_.labels.size() <= std::numeric_limits<std::uint32_t>::max()) return {};
        return fail(ErrorCode::limit_exceeded,
                    "the lists would have more than 2^32 labels: lower the depth");
    }

    ThesisProximityOctree::Parts& parts_;
    const FeatureNumbers& numbers_;
};

std::uint64_t bytes_of(const ThesisProximityOctree::Parts& parts) noexcept
{
    return parts.nodes.size() * sizeof(std::uint32_t) + parts.leaves.size() * sizeof(ThesisLeaf) +
           parts.labels.size() * sizeof(std::uint32_t);
}

Result<ThesisProximityOctree> build(const TriangleMesh& mesh, const Topology& topology,
                                    const ThesisProximityOptions& options)
{
    if (Status status = check_options(options); !status) return tl::unexpected(status.error());
    if (Status status = check_mesh(mesh, topology); !status) return tl::unexpected(status.error());
    Progress* const progress = options.execution.progress;
    const auto surface = check_convex_surface(
        mesh, topology, {options.convexity_tolerance, options.flat_sine, options.execution});
    if (!surface) return tl::unexpected(surface.error());

    ThesisProximityOctree::Parts parts;
    parts.frame = grown_root(bounding_box(mesh), options.margin);
    parts.max_depth = options.max_depth;
    parts.thresholds = options.thresholds;
    parts.margin = options.margin;
    parts.features = {topology.vertex_count(), topology.edge_count(), topology.triangle_count()};
    parts.fingerprint = mesh_fingerprint(mesh);
    const auto regions = grow_regions(mesh, topology, *surface, parts.frame, {options.execution});
    if (!regions) return tl::unexpected(regions.error());

    const FeatureNumbers numbers(topology);
    const CellLabeller labeller(mesh, topology, *regions, parts.frame);
    OctreeWriter writer(parts, numbers);
    LabelledCells level = labeller.root();
    while (true) {
        const auto split = writer.write(level);
        if (!split) return tl::unexpected(split.error());
        if (split->empty()) break;
        if (is_cancelled(progress)) return cancelled("building the proximity octree");
        const std::uint64_t held = regions->bytes() + bytes_of(parts) + level.bytes();
        auto children = labeller.children(level, *split, {held, options.execution});
        if (!children) return tl::unexpected(children.error());
        level = std::move(*children);
    }
    return ThesisProximityOctree(std::move(parts));
}

} // namespace

std::uint64_t ThesisProximityOctree::bytes() const noexcept
{
    return bytes_of(*parts_);
}

std::optional<ThesisCell> ThesisProximityOctree::locate(const Vec3& point) const noexcept
{
    if (!cell_box(frame(), CellKey{}).contains(point)) return std::nullopt;
    std::array<std::uint32_t, 3> coordinates = {};
    CellKey key;
    std::uint32_t node = parts_->nodes[0];
    for (int level = 1; (node & leaf_bit) == 0; ++level) {
        unsigned octant = 0;
        for (int axis = 0; axis < 3; ++axis) {
            std::uint32_t& coordinate = coordinates[static_cast<std::size_t>(axis)];
            coordinate *= 2;
            if (point[axis] < frame().plane(axis, coordinate + 1, level)) continue;
            ++coordinate;
            octant |= 1U << static_cast<unsigned>(axis);
        }
        key = child(key, static_cast<int>(octant));
        node = parts_->nodes[node + octant];
    }
    return ThesisCell{key, node & ~leaf_bit};
}

Result<ThesisProximityOctree> build_thesis_proximity_octree(const TriangleMesh& mesh,
                                                            const Topology& topology,
                                                            const ThesisProximityOptions& options)
{
    try {
        return build(mesh, topology, options);
    } catch (const std::bad_alloc&) {
        return fail(ErrorCode::budget_exceeded,
                    "memory ran out: lower the depth, raise the thresholds or set a budget");
    }
}

Result<ThesisProximityOctree> build_thesis_proximity_octree(const TriangleMesh& mesh,
                                                            const ThesisProximityOptions& options)
{
    const auto topology = build_topology(mesh, {.execution = options.execution});
    if (!topology) return tl::unexpected(topology.error());
    return build_thesis_proximity_octree(mesh, *topology, options);
}

bool fits_mesh(const ThesisProximityOctree& octree, const TriangleMesh& mesh,
               const Topology& topology)
{
    const FeatureCounts& features = octree.features();
    if (features.vertices != mesh.vertex_count() || features.edges != topology.edge_count() ||
        features.faces != mesh.triangle_count())
        return false;
    if (octree.parts().fingerprint != mesh_fingerprint(mesh)) return false;
    for (std::uint32_t t = 0; t < mesh.triangle_count(); ++t) {
        for (const EdgeId edge : topology.edges(TriangleId{t}))
            if (edge == no_edge || topology.triangles(edge).size() != 2) return false;
    }
    bool are_used = true;
    octree.for_each_leaf([&](const ThesisCell& cell) {
        for (const std::uint32_t id : octree.closest(cell, FeatureKind::vertex))
            are_used = are_used && !topology.triangles(VertexId{id}).empty();
    });
    return are_used;
}

} // namespace proxima
