#include "octree/classify_cells.h"

#include "base/disjoint_sets.h"
#include "base/fixed_stack.h"
#include "base/memory_budget.h"
#include "base/parallel.h"
#include "base/progress.h"
#include "base/text.h"
#include "octree/empty_cells.h"
#include "octree/hole_caps.h"
#include "octree/region_rays.h"
#include "octree/winding_number.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <optional>
#include <utility>
#include <vector>

namespace proxima {

namespace {

/// So few winding numbers are found faster from all triangles than by sorting them first.
constexpr std::size_t few_queries = 8;
constexpr std::size_t chunk = 64;
/// Each ray looks at every cap; of more caps, a region's winding number is asked for.
constexpr std::size_t most_caps_for_rays = 20'000;

/// What is known of one empty cell.
enum class Label : std::uint8_t { outer, inner };

/// Whether the closed box may touch the triangle: false only if its box or plane is clear of it.
bool may_touch(const Triangle& triangle, const Box& box) noexcept
{
    const Box bounds = bounding_box(triangle);
    if ((bounds.lower.array() > box.upper.array()).any() ||
        (bounds.upper.array() < box.lower.array()).any()) {
        return false;
    }
    const Vec3 size = (box.upper - box.lower).cwiseMax(bounds.upper - bounds.lower);
    const double unit = size.maxCoeff() > 0.0 ? 1.0 / size.maxCoeff() : 1.0;
    const Vec3 normal =
        ((triangle[1] - triangle[0]) * unit).cross((triangle[2] - triangle[0]) * unit);
    const double reach = normal.cwiseAbs().dot(0.5 * unit * (box.upper - box.lower));
    const double distance = std::abs(normal.dot((box.center() - triangle[0]) * unit));
    constexpr double slack = 1e-9; // far above rounding: an extra touch only costs time
    return distance <= reach + slack * normal.norm();
}

bool touches_root_face(CellKey key) noexcept
{
    const std::uint32_t last = (1U << depth(key)) - 1;
    for (const std::uint32_t at : cell_coordinates(key)) {
        if (at == 0 || at == last) return true;
    }
    return false;
}

class Classifier {
public:
    Classifier(const Octree& octree, const TriangleMesh& mesh, TriangleMesh caps,
               const ClassifyOptions& options)
        : octree_(octree), mesh_(mesh), options_(options), caps_(std::move(caps)),
          cells_(collect_empty_cells(octree)), components_(cells_.keys.size()),
          regions_(caps_.triangle_count() > 0 ? cells_.keys.size() : 0),
          at_cap_(caps_.triangle_count() > 0 ? cells_.keys.size() : 0),
          labels_(cells_.keys.size(), Label::outer)
    {}

    Result<Octree> run()
    {
        begin_stage("empty cells", 1);
        if (capped()) mark_cells_at_caps();
        unite_cells();
        if (is_cancelled(options_.execution.progress)) return cancelled("classifying cells");
        number_regions();
        find_region_windings();
        if (is_cancelled(options_.execution.progress)) return cancelled("classifying cells");
        label_cells();
        if (is_cancelled(options_.execution.progress)) return cancelled("classifying cells");
        summarise();
        return make_octree();
    }

private:
    using CellNumber = std::uint32_t;

    [[nodiscard]] bool capped() const noexcept { return caps_.triangle_count() > 0; }
    [[nodiscard]] DisjointSets& regions() noexcept { return capped() ? regions_ : components_; }
    [[nodiscard]] bool at_cap(CellNumber cell) const noexcept { return capped() && at_cap_[cell]; }

    [[nodiscard]] Vec3 center(CellNumber cell) const noexcept
    {
        return cell_box(octree_.frame(), cells_.keys[cell]).center();
    }

    void begin_stage(const char* name, std::uint64_t steps) const noexcept
    {
        proxima::begin_stage(options_.execution.progress, name, steps);
    }

    /// Calls body(i) for i in [0, count) on all threads.
    template <class Body>
    void for_each(const char* stage, std::size_t count, const Body& body) const
    {
        begin_stage(stage, count);
        parallel_chunks(count, chunk, options_.execution.threads,
                        [&](std::size_t first, std::size_t end) {
                            if (is_cancelled(options_.execution.progress)) return;
                            for (std::size_t i = first; i < end; ++i) body(i);
                            advance_stage(options_.execution.progress, end - first);
                        });
    }

    /// Descends with each cap to the empty cells that it may touch.
    void mark_cells_at_caps()
    {
        if (octree_.nodes()[0].is_leaf()) return;
        for (std::uint32_t i = 0;
             i < caps_.triangle_count() && !is_cancelled(options_.execution.progress); ++i) {
            const Triangle cap = caps_.triangle(TriangleId{i});
            FixedStack<Cell, 7 * max_octree_depth + 1> pending;
            pending.push(octree_.root());
            while (!pending.empty()) {
                const Cell parent = pending.pop();
                const std::uint32_t empty = empty_octants(octree_, parent.node);
                for (int octant = 0; octant < 8; ++octant) {
                    const Cell child = octree_.child(parent, octant);
                    const bool is_empty = (empty >> static_cast<unsigned>(octant) & 1U) != 0;
                    if (!is_empty && octree_.is_leaf(child)) continue;
                    if (!may_touch(cap, octree_.box(child))) continue;
                    if (is_empty) {
                        at_cap_[cells_.number(parent.node, empty, octant)] = true;
                    } else {
                        pending.push(child);
                    }
                }
            }
        }
    }

    void unite_cells()
    {
        const auto meet = [this](CellNumber a, CellNumber b) {
            components_.unite(a, b);
            if (capped() && !at_cap_[a] && !at_cap_[b]) regions_.unite(a, b);
        };
        EmptyFaces(octree_, cells_, meet, options_.execution.progress).visit_all();
    }

    /// Regions without caps, by their smallest cells; each starts at its largest.
    void number_regions()
    {
        const std::size_t count = cells_.keys.size();
        areas_.of_cell.assign(count, EmptyRegions::none);
        for (CellNumber cell = 0; cell < count; ++cell) {
            if (at_cap(cell)) continue;
            const CellNumber smallest = regions().find(cell);
            std::uint32_t& region = areas_.of_cell[cell];
            if (smallest == cell) {
                region = static_cast<std::uint32_t>(areas_.start.size());
                areas_.start.push_back(cell);
            } else {
                region = areas_.of_cell[smallest];
            }
            CellNumber& start = areas_.start[region];
            if (cells_.keys[cell] < cells_.keys[start]) start = cell;
        }
    }

    /// The whole winding number of mesh and caps in each region: 0 where it reaches the root's
    /// faces, beyond which all is outside; elsewhere what rays from region to region make of that.
    void find_region_windings()
    {
        const auto outside = static_cast<std::uint32_t>(areas_.start.size());
        DisjointOffsets windings(areas_.start.size() + 1);
        for (CellNumber cell = 0; cell < cells_.keys.size(); ++cell) {
            if (!at_cap(cell) && touches_root_face(cells_.keys[cell])) {
                windings.unite(outside, areas_.of_cell[cell], 0);
            }
        }
        // Rounded lists may lack a triangle that a ray crosses.
        if (octree_.parameters().exact && caps_.triangle_count() <= most_caps_for_rays) {
            const RegionRays rays(octree_, mesh_, caps_, cells_, areas_);
            tie_regions(rays, windings, options_.execution.threads, options_.execution.progress);
        }
        ask_winding_numbers(outside, windings);
        if (is_cancelled(options_.execution.progress)) return;
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
        const auto direct = static_cast<std::size_t>(std::ranges::count(at_cap_, true));
        if (asked.size() + direct > few_queries) {
            auto built = build_winding_number(mesh_, {options_.execution});
            if (!built) return; // cancelled
            winding_ = std::move(*built);
        }
        if (capped()) {
            auto built = build_winding_number(caps_, {options_.execution});
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

    void label_cells()
    {
        const std::size_t count = cells_.keys.size();
        if (!capped()) {
            for (CellNumber cell = 0; cell < count; ++cell) {
                labels_[cell] =
                    region_winding_[areas_.of_cell[cell]] >= 1 ? Label::inner : Label::outer;
            }
            return;
        }
        for_each("cells near holes", count, [&](std::size_t i) {
            const auto cell = static_cast<CellNumber>(i);
            const Vec3 point = center(cell);
            bool inside = false;
            if (at_cap_[cell]) {
                inside = winding_ ? is_inside(*winding_, point) : brute_is_inside(mesh_, point);
            } else {
                inside =
                    is_inside_but_for(*cap_winding_, point, region_winding_[areas_.of_cell[cell]]);
            }
            labels_[cell] = inside ? Label::inner : Label::outer;
        });
    }

    /// Counts components and those that leaked.
    void summarise()
    {
        struct Component {
            std::uint64_t leaves = 0;
            bool has_inner = false;
            bool has_outer = false; // or reaches the root's faces, beyond which all is outside
        };
        std::vector<Component> found(cells_.keys.size());
        for (CellNumber cell = 0; cell < cells_.keys.size(); ++cell) {
            const CellKey key = cells_.keys[cell];
            Component& component = found[components_.find(cell)];
            component.leaves += leaves_of(key);
            const bool inner = labels_[cell] == Label::inner;
            component.has_inner = component.has_inner || inner;
            component.has_outer = component.has_outer || !inner || touches_root_face(key);
        }
        for (const Component& component : found) {
            if (component.leaves == 0) continue;
            ++summary_.components;
            if (component.has_inner && component.has_outer) {
                ++summary_.leaked_components;
                summary_.leaked_leaves += component.leaves;
            }
        }
    }

    [[nodiscard]] std::uint64_t leaves_of(CellKey key) const noexcept
    {
        if (octree_.parameters().subdivision == Subdivision::adaptive) return 1;
        return std::uint64_t{1} << (3 * (octree_.parameters().max_depth - depth(key)));
    }

    Result<Octree> make_octree()
    {
        struct Storage {
            std::vector<OctreeNode> nodes;
            Octree source; // keeps the references
        };
        auto storage = std::make_shared<Storage>();
        storage->source = octree_;
        storage->nodes.assign(octree_.nodes().begin(), octree_.nodes().end());
        for (std::uint32_t record = 0; record < storage->nodes.size(); ++record) {
            const OctreeNode node = octree_.nodes()[record];
            if (node.is_leaf() || node.is_empty()) continue;
            const std::uint32_t empty = empty_octants(octree_, record);
            std::uint32_t inner = 0;
            CellNumber cell = cells_.first_of[record];
            for (std::uint32_t bits = empty; bits != 0; bits &= bits - 1) {
                if (labels_[cell++] == Label::inner) inner |= bits & (~bits + 1U);
            }
            set_inner(storage->nodes, record, inner);
            for (std::uint32_t bits = empty & node.recorded_mask(); bits != 0; bits &= bits - 1) {
                const std::uint32_t below = (bits & (~bits + 1U)) - 1;
                set_all_below(storage->nodes,
                              node.first + static_cast<std::uint32_t>(
                                               std::popcount(node.recorded_mask() & below)),
                              (inner & (below + 1)) != 0 ? 0xFFU : 0U);
            }
        }
        OctreeParameters parameters = octree_.parameters();
        parameters.classified = true;
        parameters.classification = summary_;
        return Octree::adopt(octree_.frame(), parameters, octree_.triangle_count(), storage->nodes,
                             octree_.references(), storage);
    }

    static void set_inner(std::vector<OctreeNode>& nodes, std::uint32_t record, std::uint32_t inner)
    {
        nodes[record].packed = (nodes[record].packed & ~0xFF00U) | inner << 8U;
    }

    /// Gives all cells below an empty record of a uniform octree its class.
    static void set_all_below(std::vector<OctreeNode>& nodes, std::uint32_t record,
                              std::uint32_t inner)
    {
        if (nodes[record].is_leaf()) return;
        set_inner(nodes, record, inner);
        for (std::uint32_t i = 0; i < 8; ++i) set_all_below(nodes, nodes[record].first + i, inner);
    }

    const Octree& octree_;
    const TriangleMesh& mesh_;
    const ClassifyOptions& options_;
    TriangleMesh caps_;
    EmptyCells cells_;
    DisjointSets components_;  ///< cells that share faces
    DisjointSets regions_;     ///< the same, parted by caps; unused without caps
    std::vector<bool> at_cap_; ///< cells that a cap may touch
    std::vector<Label> labels_;
    EmptyRegions areas_;                       ///< the sets of regions(), numbered
    std::vector<std::int32_t> region_winding_; ///< of mesh and caps
    std::optional<WindingNumber> winding_;     ///< absent where few queries are needed
    std::optional<WindingNumber> cap_winding_;
    ClassificationSummary summary_;
};

} // namespace

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
    const std::uint64_t cells = count_empty_cells(octree);
    if (cells >= std::numeric_limits<std::uint32_t>::max()) {
        return fail(ErrorCode::limit_exceeded, concat(cells, " empty cells, at most 2^32 - 2: "
                                                             "lower the depth"));
    }
    // Nodes and their first cells; keys, sets, regions and counts of cells; edges of the mesh.
    const std::uint64_t needed =
        octree.nodes().size() * 12 + cells * 48 + mesh.triangle_count() * 100;
    if (const Status status =
            check_budget(options.execution.budget, needed, "classifying the cells",
                         "lower the depth or raise the budget");
        !status) {
        return tl::unexpected<Error>(status.error());
    }
    auto caps = hole_caps(mesh, options.execution.progress);
    if (!caps) return tl::unexpected<Error>(caps.error());
    return Classifier(octree, mesh, std::move(*caps), options).run();
}

} // namespace proxima
