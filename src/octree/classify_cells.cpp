#include "octree/classify_cells.h"

#include "base/disjoint_sets.h"
#include "base/memory_budget.h"
#include "base/parallel.h"
#include "base/progress.h"
#include "base/text.h"
#include "octree/cells_at_caps.h"
#include "octree/empty_cells.h"
#include "octree/empty_regions.h"
#include "octree/hole_caps.h"
#include "octree/region_rays.h"
#include "octree/winding_number.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <optional>
#include <span>
#include <utility>
#include <vector>

namespace proxima {

namespace {

/// So few winding numbers are found faster from all triangles than by sorting them first.
constexpr std::size_t few_queries = 8;
constexpr std::size_t chunk = 64;

class Classifier {
public:
    Classifier(const Octree& octree, const TriangleMesh& mesh, TriangleMesh caps,
               const Execution& execution)
        : octree_(octree), mesh_(mesh), execution_(execution), caps_(std::move(caps)),
          groups_(octree, octants_at_caps(octree, caps_, execution.progress)),
          inner_(groups_.count())
    {}

    Result<ClassificationSummary> run(std::span<OctreeNode> nodes)
    {
        begin_stage("empty cells", 1);
        areas_ = find_regions(octree_, groups_, capped(), execution_.progress);
        if (is_cancelled(execution_.progress)) return cancelled("classifying cells");
        find_region_windings();
        if (is_cancelled(execution_.progress)) return cancelled("classifying cells");
        label_cells();
        if (is_cancelled(execution_.progress)) return cancelled("classifying cells");
        write_classes(nodes);
        return summary();
    }

private:
    using GroupNumber = std::uint32_t;

    [[nodiscard]] bool capped() const noexcept { return caps_.triangle_count() > 0; }

    [[nodiscard]] Vec3 center(CellKey cell) const noexcept
    {
        return cell_box(octree_.frame(), cell).center();
    }

    void begin_stage(const char* name, std::uint64_t steps) const noexcept
    {
        proxima::begin_stage(execution_.progress, name, steps);
    }

    /// Calls body(i) for i in [0, count) on all threads.
    template <class Body>
    void for_each(const char* stage, std::size_t count, const Body& body) const
    {
        begin_stage(stage, count);
        parallel_chunks(count, chunk, execution_.threads, [&](std::size_t first, std::size_t end) {
            if (is_cancelled(execution_.progress)) return;
            for (std::size_t i = first; i < end; ++i) body(i);
            advance_stage(execution_.progress, end - first);
        });
    }

    /// The whole winding number of mesh and caps in each region: 0 where it reaches the root's
    /// faces, beyond which all is outside; elsewhere what rays from region to region make of that.
    void find_region_windings()
    {
        const std::uint32_t outside = areas_.count();
        DisjointOffsets windings(areas_.count() + 1);
        for (GroupNumber group = 0; group < groups_.count(); ++group) {
            if (groups_[group].at_root_face && !groups_[group].is_alone) {
                windings.unite(outside, areas_.of_group[group], 0);
            }
        }
        // Rounded lists may lack a triangle that a ray crosses.
        if (octree_.parameters().exact && caps_.triangle_count() <= most_caps_for_rays) {
            const RegionRays rays(octree_, mesh_, caps_, groups_, areas_);
            tie_regions(rays, windings, execution_.threads, execution_.progress);
        }
        ask_winding_numbers(outside, windings);
        if (is_cancelled(execution_.progress)) return;
        const std::int64_t winding_outside = windings.find(outside).difference;
        for (std::uint32_t region = 0; region < outside; ++region) {
            const auto found = windings.find(region);
            region_winding_.push_back(
                static_cast<std::int32_t>(found.difference - winding_outside));
        }
    }

    /// Asks for the winding number in one region of each set that is not tied to the outside.
    void ask_winding_numbers(std::uint32_t outside, DisjointOffsets& windings)
    {
        std::vector<std::uint32_t> asked;
        for (std::uint32_t region = 0; region < outside; ++region) {
            const bool first = windings.find(region).smallest == region;
            if (first && !are_tied(windings, region, outside)) asked.push_back(region);
        }
        std::size_t direct = 0;
        for (GroupNumber group = 0; group < groups_.count(); ++group) {
            direct += groups_[group].is_alone ? 1 : 0;
        }
        if (asked.size() + direct > few_queries) {
            auto built = build_winding_number(mesh_, {execution_});
            if (!built) return; // cancelled
            winding_ = std::move(*built);
        }
        if (capped()) {
            auto built = build_winding_number(caps_, {execution_});
            if (!built) return; // cancelled
            cap_winding_ = std::move(*built);
        }
        std::vector<std::int64_t> found(asked.size());
        for_each("regions", asked.size(), [&](std::size_t i) {
            const Vec3 point = center(areas_.start[asked[i]]);
            double sum = winding_ ? winding_number(*winding_, point, 0.2).value
                                  : brute_winding_number(mesh_, point);
            if (cap_winding_) sum += winding_number(*cap_winding_, point, 0.2).value;
            found[i] = std::lround(sum);
        });
        for (std::size_t i = 0; i < asked.size(); ++i) windings.unite(outside, asked[i], found[i]);
    }

    [[nodiscard]] bool is_inner(GroupNumber group, const Vec3& point) const
    {
        if (groups_[group].is_alone) {
            return winding_ ? is_inside(*winding_, point) : brute_is_inside(mesh_, point);
        }
        return is_inside_but_for(*cap_winding_, point, region_winding_[areas_.of_group[group]]);
    }

    void label_cells()
    {
        if (!capped()) {
            for (GroupNumber group = 0; group < groups_.count(); ++group) {
                const bool inner = region_winding_[areas_.of_group[group]] >= 1;
                inner_[group] = inner ? groups_[group].octants : std::uint8_t{0};
            }
            return;
        }
        for_each("cells near holes", groups_.count(), [&](std::size_t i) {
            const auto group = static_cast<GroupNumber>(i);
            std::uint32_t inner = 0;
            for (std::uint32_t bits = groups_[group].octants; bits != 0; bits &= bits - 1) {
                const CellKey cell = child(groups_[group].parent, std::countr_zero(bits));
                if (is_inner(group, center(cell))) inner |= bits & (~bits + 1U);
            }
            inner_[group] = static_cast<std::uint8_t>(inner);
        });
    }

    /// Counts components and those that leaked.
    [[nodiscard]] ClassificationSummary summary() const
    {
        struct Component {
            std::uint64_t leaves = 0;
            bool has_inner = false;
            bool has_outer = false; // or reaches the root's faces, beyond which all is outside
        };
        std::vector<Component> components;
        for (GroupNumber number = 0; number < groups_.count(); ++number) {
            const EmptyGroup& group = groups_[number];
            const std::uint32_t at = areas_.component(number);
            if (at == components.size()) components.emplace_back();
            Component& component = components[at];
            component.leaves += leaves_of(group);
            component.has_inner = component.has_inner || inner_[number] != 0;
            component.has_outer =
                component.has_outer || inner_[number] != group.octants || group.at_root_face;
        }
        ClassificationSummary summary;
        summary.components = static_cast<std::uint32_t>(components.size());
        for (const Component& component : components) {
            if (component.has_inner && component.has_outer) {
                ++summary.leaked_components;
                summary.leaked_leaves += component.leaves;
            }
        }
        return summary;
    }

    [[nodiscard]] std::uint64_t leaves_of(const EmptyGroup& group) const noexcept
    {
        const std::uint64_t cells = count_octants(group.octants);
        if (octree_.parameters().subdivision == Subdivision::adaptive) return cells;
        return cells << (3 * (octree_.parameters().max_depth - depth(group.parent) - 1));
    }

    /// Sets the octants of inner cells. \pre no inner octants are set in the nodes
    void write_classes(std::span<OctreeNode> nodes) const
    {
        for (GroupNumber group = 0; group < groups_.count(); ++group) {
            OctreeNode& node = nodes[groups_[group].record];
            const std::uint32_t inner = inner_[group];
            node.packed |= inner << 8U;
            for (std::uint32_t bits = inner & node.recorded_mask(); bits != 0; bits &= bits - 1) {
                const std::uint32_t below = (bits & (~bits + 1U)) - 1;
                set_all_below(nodes, node.first + count_octants(node.recorded_mask() & below));
            }
        }
    }

    /// Makes all cells below an empty record of a uniform octree inner.
    static void set_all_below(std::span<OctreeNode> nodes, std::uint32_t record)
    {
        OctreeNode& node = nodes[record];
        if (node.is_leaf()) return;
        node.packed |= 0xFF00U;
        for (std::uint32_t i = 0; i < 8; ++i) set_all_below(nodes, node.first + i);
    }

    const Octree& octree_;
    const TriangleMesh& mesh_;
    const Execution& execution_;
    TriangleMesh caps_;
    EmptyGroups groups_;                       ///< cells that a cap may touch are alone
    std::vector<std::uint8_t> inner_;          ///< the octants of each group that are inner
    EmptyRegions areas_;                       ///< groups that share faces
    std::vector<std::int32_t> region_winding_; ///< of mesh and caps
    std::optional<WindingNumber> winding_;     ///< absent where few queries are needed
    std::optional<WindingNumber> cap_winding_;
};

OctreeNode without_classes(OctreeNode node) noexcept
{
    return node.is_leaf() ? node : OctreeNode{node.first, node.packed & ~0xFF00U};
}

} // namespace

Result<ClassificationSummary> classify_nodes(const Octree& octree, std::span<OctreeNode> nodes,
                                             const TriangleMesh& mesh, const Execution& execution)
{
    const std::uint64_t cells = count_empty_cells(octree);
    if (cells >= std::numeric_limits<std::uint32_t>::max()) {
        return fail(ErrorCode::limit_exceeded, concat(cells, " empty cells, at most 2^32 - 2: "
                                                             "lower the depth"));
    }
    // At most: nodes, copied, numbered and masked; groups, their sets and regions; edges of the mesh.
    const std::uint64_t needed =
        octree.nodes().size() * 13 + cells * 48 + mesh.triangle_count() * 100;
    if (const Status status = check_budget(execution.budget, needed, "classifying the cells",
                                           "lower the depth or raise the budget");
        !status) {
        return tl::unexpected<Error>(status.error());
    }
    auto caps = hole_caps(mesh, execution.progress);
    if (!caps) return tl::unexpected<Error>(caps.error());
    return Classifier(octree, mesh, std::move(*caps), execution).run(nodes);
}

Result<Octree> classify_cells(const Octree& octree, const TriangleMesh& mesh,
                              const ClassifyOptions& options)
{
    if (const auto status = checked_bounding_box(mesh); !status) {
        return tl::unexpected<Error>(status.error());
    }
    if (mesh.triangle_count() != octree.triangle_count()) {
        return fail(ErrorCode::invalid_argument,
                    concat("the octree was built from ", octree.triangle_count(),
                           " triangles, the mesh has ", mesh.triangle_count()));
    }
    if (!bounding_box(mesh).extent().allFinite()) {
        return fail(ErrorCode::invalid_mesh, "the mesh is too large for its extent to be a number");
    }
    struct Storage {
        std::vector<OctreeNode> nodes;
        Octree source; // keeps the references
    };
    const auto storage = std::make_shared<Storage>();
    storage->source = octree;
    storage->nodes.assign(octree.nodes().begin(), octree.nodes().end());
    for (OctreeNode& node : storage->nodes) node = without_classes(node);
    const auto summary = classify_nodes(octree, storage->nodes, mesh, options.execution);
    if (!summary) return tl::unexpected<Error>(summary.error());
    return Octree::adopt(octree.frame(), classified(octree.parameters(), *summary),
                         octree.triangle_count(), storage->nodes, octree.references(), storage);
}

} // namespace proxima
