#include "base/memory_budget.h"
#include "base/parallel.h"
#include "base/progress.h"
#include "geometry/exact_predicates.h"
#include "mesh/coincidence.h"
#include "mesh/duplicate_triangles.h"
#include "mesh/equal_items.h"
#include "mesh/near_vertices.h"
#include "mesh/nesting.h"
#include "mesh/small_components.h"
#include "mesh/surface_parts.h"
#include "mesh/surface_pieces.h"
#include "mesh/vertex_table.h"
#include "proxima/mesh_repair.h"
#include "proxima/topology.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace proxima {

namespace {

using detail::edge_uses;
using detail::EdgeUse;
using detail::find_surface_pieces;
using detail::hash_of;
using detail::is_finite;
using detail::is_proper;
using detail::sorted_corners;
using detail::SurfacePiece;
using detail::SurfacePieces;
using detail::volume_signs_of;

constexpr std::size_t triangles_per_test_task = 8192;
constexpr const char* work_name = "repairing the mesh";
constexpr double largest_weld_distance = 1e300;

// Of the arrays that are held at once, topology left out; see their types.
constexpr std::uint64_t bytes_per_triangle = 110;
constexpr std::uint64_t bytes_per_vertex = 80;

constexpr std::array<std::string_view, repair_step_count> step_names = {
    "drop_non_finite", "weld_vertices",   "drop_degenerate",
    "drop_zero_area",  "drop_duplicates", "drop_small_components",
    "orient_pieces",   "turn_outward",    "drop_unused_vertices"};

/// Asked for each item of a loop that has no other end, says whether to go on.
class Watch {
public:
    Watch(Progress* progress, const char* stage, std::uint64_t steps) noexcept
        : steps_(progress, stage, steps)
    {}

    [[nodiscard]] bool goes_on() noexcept
    {
        goes_on_ = goes_on_ && steps_.done(1);
        return goes_on_;
    }

private:
    StageSteps steps_;
    bool goes_on_ = true;
};

Status check_options(const MeshRepairOptions& options)
{
    // Written so that NaN is refused.
    if (!(options.weld_distance >= 0 && options.weld_distance <= largest_weld_distance)) {
        return fail(ErrorCode::invalid_argument, "must be a distance from 0 to 1e300",
                    "weld_distance");
    }
    if (!(options.min_component_area >= 0 && options.min_component_area <= 1)) {
        return fail(ErrorCode::invalid_argument, "must be a fraction from 0 to 1",
                    "min_component_area");
    }
    return {};
}

/// The steps of repair_mesh. Until the end triangles name the vertices of the input.
class MeshRepairer {
public:
    MeshRepairer(const TriangleMesh& mesh, const MeshRepairOptions& options)
        : mesh_(mesh), options_(options), progress_(options.execution.progress),
          triangles_(mesh.triangles().begin(), mesh.triangles().end()), ids_(mesh.triangle_count()),
          welded_away_(mesh.vertex_count(), 0)
    {
        for (std::uint32_t id = 0; id < ids_.size(); ++id) ids_[id] = TriangleId{id};
        for (std::size_t i = 0; i < repair_step_count; ++i) {
            const auto kind = static_cast<RepairStepKind>(i);
            repair_.steps[i] = {kind, is_enabled(kind), 0};
        }
    }

    Result<MeshRepair> repair()
    {
        for (const auto step : {&MeshRepairer::drop_non_finite, &MeshRepairer::weld,
                                &MeshRepairer::drop_degenerate, &MeshRepairer::drop_zero_area,
                                &MeshRepairer::drop_duplicates, &MeshRepairer::mend_surface}) {
            if (const Status done = (this->*step)(); !done) return tl::unexpected(done.error());
            if (is_cancelled(progress_)) return cancelled(work_name);
        }
        return assemble();
    }

private:
    [[nodiscard]] bool is_enabled(RepairStepKind kind) const noexcept
    {
        switch (kind) {
        case RepairStepKind::drop_non_finite:
            return options_.drop_non_finite;
        case RepairStepKind::weld_vertices:
            return options_.weld;
        case RepairStepKind::drop_degenerate:
            return options_.drop_degenerate;
        case RepairStepKind::drop_zero_area:
            return options_.drop_zero_area;
        case RepairStepKind::drop_duplicates:
            return options_.drop_duplicates;
        case RepairStepKind::drop_small_components:
            return options_.min_component_area > 0 || options_.min_component_triangles > 1;
        case RepairStepKind::orient_pieces:
            return options_.orient;
        case RepairStepKind::turn_outward:
            return options_.turn_outward;
        case RepairStepKind::drop_unused_vertices:
            break;
        }
        return options_.drop_unused_vertices;
    }

    [[nodiscard]] bool does(RepairStepKind kind) const noexcept
    {
        return repair_.step(kind).enabled;
    }

    [[nodiscard]] std::uint64_t& count_of(RepairStepKind kind) noexcept
    {
        return repair_.steps[static_cast<std::size_t>(kind)].count;
    }

    [[nodiscard]] Triangle triangle(std::size_t i) const noexcept
    {
        const auto [a, b, c] = triangles_[i];
        return {{mesh_.positions()[a], mesh_.positions()[b], mesh_.positions()[c]}};
    }

    /// Keeps the triangles whose flags are not set; returns how many others there were.
    std::uint64_t drop(std::span<const std::uint8_t> flags)
    {
        std::size_t kept = 0;
        for (std::size_t i = 0; i < triangles_.size(); ++i) {
            if (flags[i] != 0) continue;
            triangles_[kept] = triangles_[i];
            ids_[kept++] = ids_[i];
        }
        const std::size_t dropped = triangles_.size() - kept;
        triangles_.resize(kept);
        ids_.resize(kept);
        return dropped;
    }

    /// Drops the triangles that a test of their own says are wrong.
    template <class IsWrong>
    void drop_where(RepairStepKind kind, const IsWrong& is_wrong)
    {
        if (!does(kind)) return;
        begin_stage(progress_, "dropping triangles", 1);
        std::vector<std::uint8_t> wrong(triangles_.size(), 0);
        parallel_chunks(triangles_.size(), triangles_per_test_task, options_.execution.threads,
                        [&](std::size_t first, std::size_t end) {
                            for (std::size_t i = first; i < end; ++i)
                                wrong[i] = is_wrong(i) ? 1 : 0;
                        });
        count_of(kind) = drop(wrong);
        advance_stage(progress_, 1);
    }

    Status drop_non_finite()
    {
        drop_where(RepairStepKind::drop_non_finite,
                   [&](std::size_t i) { return !is_finite(triangle(i)); });
        return {};
    }

    /// Vertices that triangles use and that have a position.
    [[nodiscard]] std::vector<std::uint8_t> weldable_vertices() const
    {
        std::vector<std::uint8_t> weldable(mesh_.vertex_count(), 0);
        for (const TriangleCorners& corners : triangles_) {
            for (const std::uint32_t corner : corners)
                weldable[corner] = mesh_.positions()[corner].allFinite() ? 1 : 0;
        }
        return weldable;
    }

    Status weld()
    {
        if (!does(RepairStepKind::weld_vertices)) return {};
        std::vector<std::uint8_t> weldable = weldable_vertices();
        std::vector<std::uint32_t> becomes = vertices_at_one_position(weldable);
        if (is_cancelled(progress_)) return cancelled(work_name);
        if (options_.weld_distance > 0) {
            for (std::uint32_t vertex = 0; vertex < becomes.size(); ++vertex)
                if (becomes[vertex] != vertex) weldable[vertex] = 0;
            const auto near =
                near_vertices(mesh_.positions(), weldable, options_.weld_distance, progress_);
            if (!near) return cancelled(work_name);
            for (std::uint32_t& vertex : becomes) vertex = (*near)[vertex];
        }
        for (std::uint32_t vertex = 0; vertex < becomes.size(); ++vertex) {
            if (becomes[vertex] == vertex) continue;
            welded_away_[vertex] = 1;
            ++count_of(RepairStepKind::weld_vertices);
        }
        for (TriangleCorners& corners : triangles_) {
            for (std::uint32_t& corner : corners) corner = becomes[corner];
        }
        return {};
    }

    [[nodiscard]] std::vector<std::uint32_t>
    vertices_at_one_position(std::span<const std::uint8_t> weldable)
    {
        const std::span<const Vec3> positions = mesh_.positions();
        Watch watch(progress_, "welding vertices", positions.size());
        return first_equal_items(
            static_cast<std::uint32_t>(positions.size()),
            [&](std::uint32_t vertex) { return watch.goes_on() && weldable[vertex] != 0; },
            [&](std::uint32_t vertex) { return VertexTable::hash(positions[vertex]); },
            [&](std::uint32_t a, std::uint32_t b) { return positions[a] == positions[b]; });
    }

    Status drop_degenerate()
    {
        drop_where(RepairStepKind::drop_degenerate,
                   [&](std::size_t i) { return !is_proper(triangles_[i]); });
        return {};
    }

    Status drop_zero_area()
    {
        drop_where(RepairStepKind::drop_zero_area, [&](std::size_t i) {
            const Triangle one = triangle(i);
            return is_proper(triangles_[i]) && is_finite(one) && is_degenerate(one);
        });
        return {};
    }

    Status drop_duplicates()
    {
        if (!does(RepairStepKind::drop_duplicates)) return {};
        const auto count = static_cast<std::uint32_t>(triangles_.size());
        Watch watch(progress_, "finding duplicate triangles", count);
        const std::vector<std::uint32_t> first = first_equal_items(
            count, [&](std::uint32_t i) { return watch.goes_on() && is_proper(triangles_[i]); },
            [&](std::uint32_t i) { return hash_of(sorted_corners(triangles_[i])); },
            [&](std::uint32_t a, std::uint32_t b) {
                return sorted_corners(triangles_[a]) == sorted_corners(triangles_[b]);
            });
        if (is_cancelled(progress_)) return cancelled(work_name);
        const auto wrong =
            detail::redundant_triangles(mesh_.positions(), triangles_, first, options_.execution);
        if (!wrong) return tl::unexpected(wrong.error());
        count_of(RepairStepKind::drop_duplicates) = drop(*wrong);
        return {};
    }

    /// The steps that look at neighbours.
    Status mend_surface()
    {
        turned_.assign(triangles_.size(), 0);
        const bool by_piece =
            does(RepairStepKind::orient_pieces) || does(RepairStepKind::turn_outward);
        if (!by_piece && !does(RepairStepKind::drop_small_components)) return {};
        const auto surface = surface_mesh();
        if (!surface) return tl::unexpected(surface.error());
        const auto topology = build_topology(*surface, {.execution = options_.execution});
        if (!topology) return tl::unexpected(topology.error());
        const std::vector<EdgeUse> uses = edge_uses(*surface, *topology);

        std::vector<std::uint8_t> kept(triangles_.size(), 1);
        if (does(RepairStepKind::drop_small_components)) {
            count_of(RepairStepKind::drop_small_components) =
                detail::drop_small_components(*surface, *topology, options_.min_component_triangles,
                                              options_.min_component_area, kept);
        }
        if (is_cancelled(progress_)) return cancelled(work_name);
        if (by_piece) {
            Status oriented = orient(*surface, *topology, uses, kept);
            if (!oriented) return oriented;
        }
        drop_all_but(kept);
        return {};
    }

    /// The triangles with the vertices that they use.
    [[nodiscard]] Result<TriangleMesh> surface_mesh() const
    {
        std::vector<TriangleCorners> renamed = triangles_;
        std::vector<Vec3> positions;
        for (const VertexId vertex : rename_used(renamed))
            positions.push_back(mesh_.position(vertex));
        return make_triangle_mesh(std::move(positions), std::move(renamed));
    }

    /// Numbers the vertices that triangles use from 0, in their order; returns them.
    [[nodiscard]] std::vector<VertexId> rename_used(std::vector<TriangleCorners>& triangles) const
    {
        std::vector<std::uint32_t> number(mesh_.vertex_count(), 0);
        for (const TriangleCorners& corners : triangles) {
            for (const std::uint32_t corner : corners) number[corner] = 1;
        }
        if (!options_.drop_unused_vertices) {
            for (std::size_t vertex = 0; vertex < number.size(); ++vertex)
                number[vertex] = 1 - welded_away_[vertex];
        }
        std::vector<VertexId> kept;
        for (std::uint32_t vertex = 0; vertex < number.size(); ++vertex) {
            if (number[vertex] == 0) continue;
            number[vertex] = static_cast<std::uint32_t>(kept.size());
            kept.push_back(VertexId{vertex});
        }
        for (TriangleCorners& corners : triangles) {
            for (std::uint32_t& corner : corners) corner = number[corner];
        }
        return kept;
    }

    void drop_all_but(std::span<const std::uint8_t> kept)
    {
        std::vector<std::uint8_t> wrong(kept.size());
        std::size_t count = 0;
        for (std::size_t i = 0; i < kept.size(); ++i) {
            wrong[i] = 1 - kept[i];
            if (kept[i] != 0) turned_[count++] = turned_[i];
        }
        turned_.resize(count);
        drop(wrong);
    }

    Status orient(const TriangleMesh& surface, const Topology& topology,
                  std::span<const EdgeUse> uses, std::span<const std::uint8_t> takes_part)
    {
        auto found = find_surface_pieces(surface, topology, uses, takes_part,
                                         does(RepairStepKind::orient_pieces), progress_);
        if (!found) return cancelled(work_name);
        repair_.pieces = found->pieces.size();
        for (const SurfacePiece& piece : found->pieces) {
            repair_.closed_pieces += piece.closed ? 1U : 0U;
            if (!does(RepairStepKind::orient_pieces)) continue;
            count_of(RepairStepKind::orient_pieces) += piece.turned;
            repair_.unorientable_edges += piece.unmatched_edges;
            repair_.unorientable_pieces += piece.unmatched_edges > 0 ? 1U : 0U;
        }
        if (does(RepairStepKind::turn_outward)) {
            turn_outward(surface, topology, *found);
            if (is_cancelled(progress_)) return cancelled(work_name);
        }
        turned_ = std::move(found->turned);
        return {};
    }

    void turn_outward(const TriangleMesh& surface, const Topology& topology, SurfacePieces& found)
    {
        begin_stage(progress_, "turning pieces outward", 2);
        const std::vector<int> volume_signs = volume_signs_of(surface, found);
        advance_stage(progress_, 1);
        const std::vector<std::uint8_t> is_cavity =
            cavities(surface, topology, found, volume_signs);
        std::vector<std::uint8_t> to_turn(volume_signs.size(), 0);
        for (std::size_t number = 0; number < volume_signs.size(); ++number) {
            const int wanted = is_cavity[number] != 0 ? -1 : 1;
            to_turn[number] = volume_signs[number] == -wanted ? 1 : 0;
            count_of(RepairStepKind::turn_outward) += to_turn[number];
            repair_.cavities += is_cavity[number];
        }
        for (std::size_t i = 0; i < found.turned.size(); ++i) {
            const std::uint32_t piece = found.piece_of[i];
            if (piece != detail::no_piece) found.turned[i] ^= to_turn[piece];
        }
        advance_stage(progress_, 1);
    }

    /// 1 for closed pieces with volume inside an odd number of other closed surfaces.
    [[nodiscard]] std::vector<std::uint8_t> cavities(const TriangleMesh& surface,
                                                     const Topology& topology,
                                                     const SurfacePieces& found,
                                                     std::span<const int> volume_signs) const
    {
        std::vector<std::uint8_t> none(volume_signs.size(), 0);
        const auto has_volume = [](int sign) { return sign != 0; };
        if (!options_.keep_cavities || std::ranges::none_of(volume_signs, has_volume)) return none;
        const detail::ClosedSurfaces closed =
            detail::closed_surfaces_of(surface, topology, found, volume_signs);
        if (closed.count < 2) return none;
        static_assert(no_surface == detail::no_piece);
        std::vector<std::uint8_t> nested = nested_surfaces(surface, closed.surface_of, closed.count,
                                                           options_.execution.threads, progress_);
        nested.resize(volume_signs.size()); // those of pieces
        return nested;
    }

    Result<MeshRepair> assemble()
    {
        begin_stage(progress_, "making mesh", 1);
        for (std::size_t i = 0; i < triangles_.size(); ++i)
            if (turned_[i] != 0) std::swap(triangles_[i][1], triangles_[i][2]);
        repair_.original_vertices = rename_used(triangles_);
        const std::uint64_t welded = repair_.step(RepairStepKind::weld_vertices).count;
        count_of(RepairStepKind::drop_unused_vertices) =
            mesh_.vertex_count() - welded - repair_.original_vertices.size();
        std::vector<Vec3> positions;
        positions.reserve(repair_.original_vertices.size());
        for (const VertexId vertex : repair_.original_vertices)
            positions.push_back(mesh_.position(vertex));
        auto mesh = make_triangle_mesh(std::move(positions), std::move(triangles_));
        if (!mesh) return tl::unexpected(mesh.error());
        repair_.mesh = std::move(*mesh);
        repair_.original_triangles = std::move(ids_);
        repair_.turned = std::move(turned_);
        advance_stage(progress_, 1);
        return std::move(repair_);
    }

    const TriangleMesh& mesh_;
    const MeshRepairOptions& options_;
    Progress* progress_;
    std::vector<TriangleCorners> triangles_; ///< those that are left
    std::vector<TriangleId> ids_;            ///< theirs in the input
    std::vector<std::uint8_t> turned_;       ///< by triangle that is left
    std::vector<std::uint8_t> welded_away_;  ///< by vertex of the input
    MeshRepair repair_;
};

} // namespace

std::string_view name_of(RepairStepKind kind) noexcept
{
    return step_names[static_cast<std::size_t>(kind)];
}

Result<MeshRepair> repair_mesh(const TriangleMesh& mesh, const MeshRepairOptions& options)
{
    if (const Status valid = check_options(options); !valid) return tl::unexpected(valid.error());
    const std::uint64_t near_bytes =
        options.weld_distance > 0 ? near_vertices_bytes(mesh.vertex_count()) : 0;
    const Status fits = check_budget(options.execution.budget,
                                     bytes_per_triangle * mesh.triangle_count() +
                                         bytes_per_vertex * mesh.vertex_count() + near_bytes,
                                     work_name, "raise the budget");
    if (!fits) return tl::unexpected(fits.error());
    return MeshRepairer(mesh, options).repair();
}

} // namespace proxima
