#include "distributed/classify_part.h"

#include "base/disjoint_sets.h"
#include "distributed/cells_near_holes.h"
#include "distributed/merge_components.h"
#include "distributed/part_borders.h"
#include "octree/cells_at_caps.h"
#include "octree/classify_cells.h"
#include "octree/empty_regions.h"
#include "octree/region_rays.h"
#include "octree/winding_line.h"
#include "octree/winding_number.h"

#include <algorithm>
#include <limits>
#include <optional>

namespace proxima {

namespace {

/// An empty cell at a border, told to the rank that has the cell beyond.
struct BorderCell {
    std::uint64_t neighbour = 0; ///< key of the cell of the same size beyond
    std::uint64_t component = 0;
};

class PartClassifier {
public:
    PartClassifier(const RoutedPart& part, const OctreeFrame& frame,
                   const OctreeParameters& parameters, const TriangleMesh& caps, GrownPart& grown,
                   World& world)
        : part_(part), caps_(caps), grown_(grown), world_(world),
          octree_(Octree::adopt(frame, parameters, part.mesh.triangle_count(),
                                grown.arrays.nodes.span(), grown.arrays.references.span(), nullptr))
    {}

    Result<ClassificationSummary> run()
    {
        Status status = world_.agree_on([&] { return find_own_regions(); });
        if (!status) return tl::unexpected(status.error());
        for (std::uint32_t i = 0; has_groups() && i < groups_->count(); ++i) {
            component_count_ = std::max(component_count_, regions_.component(i) + 1);
        }
        first_component_ = world_.sum_before(component_count_);
        status = meet_at_borders();
        if (status) status = ask();
        if (status) status = label();
        if (!status) return tl::unexpected(status.error());
        return summary();
    }

private:
    [[nodiscard]] bool is_capped() const noexcept { return caps_.triangle_count() > 0; }
    [[nodiscard]] bool has_groups() const noexcept { return groups_.has_value(); }
    [[nodiscard]] std::uint32_t outside() const noexcept { return regions_.count(); }

    /// Steps that need no other rank.
    Status find_own_regions()
    {
        windings_.emplace(1);
        if (octree_.nodes().empty() || octree_.nodes()[0].is_leaf()) return {};
        Progress* const progress = &world_.progress();
        begin_stage(progress, "empty cells", 1);
        if (count_empty_cells(octree_) >= std::numeric_limits<std::uint32_t>::max()) {
            return fail(ErrorCode::limit_exceeded,
                        "a rank has 2^32 empty cells or more: use more ranks");
        }
        groups_.emplace(octree_, octants_at_caps(octree_, caps_, progress));
        regions_ = find_regions(octree_, *groups_, is_capped(), progress);
        if (is_cancelled(progress)) return cancelled("classifying cells");
        windings_.emplace(regions_.count() + std::size_t{1});
        for (std::uint32_t group = 0; group < groups_->count(); ++group) {
            const EmptyGroup& of = (*groups_)[group];
            if (of.at_root_face && !of.is_alone) {
                windings_->unite(outside(), regions_.of_group[group], 0);
            }
        }
        if (caps_.triangle_count() <= most_caps_for_rays) {
            const RegionRays rays(octree_, part_.mesh, caps_, *groups_, regions_);
            tie_regions(rays, *windings_, Threads{1}, progress);
        }
        return {};
    }

    /// \pre the group's region is tied to the outside
    [[nodiscard]] std::int64_t winding_of(std::uint32_t group)
    {
        return windings_->find(regions_.of_group[group]).difference -
               windings_->find(outside()).difference;
    }

    /// Tells the neighbours of the cells at borders, and hears of theirs.
    Status meet_at_borders()
    {
        std::vector<std::vector<BorderCell>> outgoing(static_cast<std::size_t>(world_.size()));
        is_shared_.assign(component_count_, false);
        Status status = world_.agree_on([&]() -> Status {
            if (!has_groups()) return {};
            const PartBorders borders(octree_, *groups_, grown_);
            borders.each_face([&](std::uint32_t group, CellKey beyond) {
                const int owner = part_.forest->owner(beyond);
                if (owner == world_.rank()) return;
                const std::uint32_t component = regions_.component(group);
                is_shared_[component] = true;
                outgoing[static_cast<std::size_t>(owner)].push_back(
                    {beyond.bits, first_component_ + component});
            });
            return {};
        });
        if (!status) return status;
        const auto received = world_.exchange(std::move(outgoing));
        if (!received) return tl::unexpected(received.error());
        return world_.agree_on([&]() -> Status {
            if (!has_groups()) return {};
            const PartBorders borders(octree_, *groups_, grown_);
            for (const BorderCell& other : received->items) {
                const auto group = borders.empty_at({other.neighbour});
                if (group) meet(other, *group);
            }
            make_meetings_unique();
            return {};
        });
    }

    void meet(const BorderCell& other, std::uint32_t group)
    {
        const std::uint32_t component = regions_.component(group);
        is_shared_[component] = true;
        meetings_.push_back({other.component, first_component_ + component});
        if (meetings_.size() < unique_size_) return;
        make_meetings_unique();
        unique_size_ = std::max(unique_size_, 2 * meetings_.size());
    }

    void make_meetings_unique()
    {
        std::ranges::sort(meetings_);
        meetings_.erase(std::unique(meetings_.begin(), meetings_.end()), meetings_.end());
    }

    /// Counts the winding numbers of regions that nothing ties to the outside, on all ranks together.
    Status ask()
    {
        std::vector<std::uint32_t> own;
        std::vector<CellKey> cells;
        Status status = world_.agree_on([&]() -> Status {
            for (std::uint32_t region = 0; region < regions_.count(); ++region) {
                if (windings_->find(region).smallest != region) continue;
                if (are_tied(*windings_, region, outside())) continue;
                own.push_back(region);
                cells.push_back(regions_.start[region]);
            }
            return {};
        });
        if (!status) return status;
        const auto asked = world_.all_gather(cells);
        if (!asked) return tl::unexpected(asked.error());
        std::vector<std::int64_t> counts;
        status = world_.agree_on([&] { return count(*asked, counts); });
        if (!status) return status;
        world_.sum(counts);
        const std::size_t first = asked->first[static_cast<std::size_t>(world_.rank())];
        for (std::size_t i = 0; i < own.size(); ++i) {
            windings_->unite(outside(), own[i], counts[first + i]);
        }
        return {};
    }

    /// This rank's part of the winding numbers; of its own regions also what the caps add.
    Status count(const Received<CellKey>& asked, std::vector<std::int64_t>& counts)
    {
        StageSteps steps(&world_.progress(), "regions", asked.items.size(), 16);
        const auto own = static_cast<std::size_t>(world_.rank());
        const int deepest = octree_.parameters().max_depth;
        for (std::size_t i = 0; i < asked.items.size(); ++i) {
            const WindingLine line = winding_line(octree_.frame(), deepest, asked.items[i]);
            counts.push_back(count_crossings(octree_, part_.mesh, line));
            if (i >= asked.first[own] && i < asked.first[own + 1]) {
                counts[i] += count_crossings(octree_.frame(), deepest, caps_, line);
            }
            if (!steps.done(1)) return cancelled("classifying cells");
        }
        return {};
    }

    Status label()
    {
        std::vector<Vec3> near;
        Status status = world_.agree_on([&]() -> Status {
            if (!has_groups()) return {};
            inner_.assign(groups_->count(), 0);
            for (std::uint32_t i = 0; i < groups_->count(); ++i) {
                const EmptyGroup& group = (*groups_)[i];
                if (group.is_alone) near.push_back(center(group.first_cell()));
            }
            return {};
        });
        if (!status) return status;
        const auto near_inner = inside_near_holes(part_, near, world_);
        if (!near_inner) return tl::unexpected(near_inner.error());
        return world_.agree_on([&] { return label_groups(*near_inner); });
    }

    Status label_groups(const std::vector<bool>& near_inner)
    {
        if (!has_groups()) return {};
        std::optional<WindingNumber> cap_winding;
        if (is_capped()) {
            auto built =
                build_winding_number(caps_, {{.threads = {1}, .progress = &world_.progress()}});
            if (!built) return tl::unexpected(built.error());
            cap_winding = std::move(*built);
        }
        StageSteps steps(&world_.progress(), "classes", groups_->count());
        std::size_t near = 0;
        for (std::uint32_t i = 0; i < groups_->count(); ++i) {
            const EmptyGroup& group = (*groups_)[i];
            if (group.is_alone) {
                inner_[i] = near_inner[near++] ? group.octants : std::uint8_t{0};
            } else {
                inner_[i] = inner_octants(group, winding_of(i), cap_winding);
            }
            OctreeNode& node = grown_.arrays.nodes[group.record];
            node.packed |= std::uint32_t{inner_[i]} << 8U;
            if (!steps.done(1)) return cancelled("classifying cells");
        }
        return {};
    }

    [[nodiscard]] std::uint8_t inner_octants(const EmptyGroup& group, std::int64_t winding,
                                             const std::optional<WindingNumber>& caps) const
    {
        if (!caps) return winding >= 1 ? group.octants : std::uint8_t{0};
        std::uint32_t inner = 0;
        for (std::uint32_t bits = group.octants; bits != 0; bits &= bits - 1) {
            const CellKey cell = child(group.parent, std::countr_zero(bits));
            const bool is_inner = is_inside_but_for(*caps, center(cell), static_cast<int>(winding));
            if (is_inner) inner |= bits & (~bits + 1U);
        }
        return static_cast<std::uint8_t>(inner);
    }

    Result<ClassificationSummary> summary()
    {
        std::vector<ComponentPart> components;
        std::vector<ComponentPart> shared;
        ClassificationSummary own;
        const Status status = world_.agree_on([&]() -> Status {
            for (std::uint64_t i = 0; i < component_count_; ++i) {
                components.push_back({first_component_ + i});
            }
            for (std::uint32_t i = 0; has_groups() && i < groups_->count(); ++i) {
                const EmptyGroup& group = (*groups_)[i];
                const bool has_outer = inner_[i] != group.octants || group.at_root_face;
                components[regions_.component(i)].add({0, count_octants(group.octants),
                                                       inner_[i] != 0 ? 1U : 0U,
                                                       has_outer ? 1U : 0U});
            }
            for (std::size_t i = 0; i < components.size(); ++i) {
                if (is_shared_[i]) {
                    shared.push_back(components[i]);
                } else {
                    count_component(components[i], own);
                }
            }
            return {};
        });
        if (!status) return tl::unexpected(status.error());
        return join_components(std::move(meetings_), std::move(shared), own, world_);
    }

    [[nodiscard]] Vec3 center(CellKey cell) const noexcept
    {
        return cell_box(octree_.frame(), cell).center();
    }

    const RoutedPart& part_;
    const TriangleMesh& caps_;
    GrownPart& grown_;
    World& world_;
    Octree octree_;                     ///< of grown_, whose nodes get classes at the end
    std::optional<EmptyGroups> groups_; ///< nothing where the part has no empty cells
    EmptyRegions regions_;
    std::optional<DisjointOffsets> windings_; ///< of regions, and the outside
    std::uint64_t first_component_ = 0;
    std::uint32_t component_count_ = 0;
    std::vector<bool> is_shared_; ///< components that may go on in other ranks
    std::vector<ComponentMeeting> meetings_;
    std::size_t unique_size_ = std::size_t{1} << 16U;
    std::vector<std::uint8_t> inner_; ///< octants of each group
};

/// \pre no leaf contains the cell, unless it is the cell
Cell cell_at(const Octree& octree, CellKey key) noexcept
{
    Cell cell = octree.root();
    for (int level = depth(key) - 1; level >= 0 && !octree.is_leaf(cell); --level) {
        cell = octree.child(cell, static_cast<int>(key.bits >> (3 * level) & 7U));
    }
    return cell;
}

} // namespace

Result<ClassificationSummary> classify_part(const RoutedPart& part, const OctreeFrame& frame,
                                            const OctreeParameters& parameters,
                                            const TriangleMesh& caps, GrownPart& grown,
                                            World& world)
{
    auto summary = PartClassifier(part, frame, parameters, caps, grown, world).run();
    if (!summary) return summary;
    const Octree octree =
        Octree::adopt(frame, classified(parameters, *summary), part.mesh.triangle_count(),
                      grown.arrays.nodes.span(), grown.arrays.references.span(), nullptr);
    for (Cell& cell : grown.cells) cell = cell_at(octree, cell.key);
    return summary;
}

} // namespace proxima
