#include "proxima/mesh_report.h"

#include "base/memory_budget.h"
#include "base/parallel.h"
#include "base/progress.h"
#include "base/text.h"
#include "geometry/exact_predicates.h"
#include "geometry/length.h"
#include "mesh/coincidence.h"
#include "mesh/duplicate_triangles.h"
#include "mesh/mesh_report_texts.h"
#include "mesh/surface_parts.h"
#include "proxima/topology.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>

namespace proxima {

namespace {

using detail::boundary_loops;
using detail::edge_uses;
using detail::EdgeUse;
using detail::face_the_same_way;
using detail::fan_counts;
using detail::first_at_position;
using detail::first_coincident;
using detail::first_duplicates;
using detail::is_closed_if_welded;
using detail::is_finite;
using detail::is_proper;
using detail::surface_components;
using detail::SurfaceComponent;

constexpr std::size_t triangles_per_task = 8192;

bool is_finite(const Vec3& position) noexcept
{
    return position.allFinite();
}

// Counts elements and remembers the first.
class Tally {
public:
    explicit Tally(std::size_t max_ids) : max_ids_(max_ids) {}

    void add(std::uint32_t id)
    {
        if (ids_.size() < max_ids_) ids_.push_back(id);
        ++count_;
    }
    [[nodiscard]] std::uint64_t count() const noexcept { return count_; }
    [[nodiscard]] const std::vector<std::uint32_t>& ids() const noexcept { return ids_; }

private:
    std::size_t max_ids_;
    std::uint64_t count_ = 0;
    std::vector<std::uint32_t> ids_;
};

} // namespace

// The steps of report_mesh; each fills its part of the report.
class MeshExaminer {
public:
    MeshExaminer(const TriangleMesh& mesh, const Topology& topology,
                 const MeshReportOptions& options)
        : mesh_(mesh), topology_(topology), options_(options)
    {}

    Result<MeshReport> examine()
    {
        if (const Status fits = check_bytes(); !fits) return tl::unexpected(fits.error());
        const std::array steps = {&MeshExaminer::examine_positions,
                                  &MeshExaminer::examine_triangles, &MeshExaminer::examine_edges,
                                  &MeshExaminer::examine_components};
        begin_stage(options_.execution.progress, "mesh report", steps.size());
        for (const auto step : steps) {
            (this->*step)();
            advance_stage(options_.execution.progress, 1);
            if (is_cancelled(options_.execution.progress)) {
                return cancelled("the mesh report");
            }
        }
        if (const Status welded = examine_welded(); !welded) return tl::unexpected(welded.error());
        std::sort(report_.findings.begin(), report_.findings.end(),
                  [](const MeshFinding& a, const MeshFinding& b) { return a.kind < b.kind; });
        report_.outlook = detail::outlook_of(report_, counts_twice_);
        return std::move(report_);
    }

private:
    [[nodiscard]] Status check_bytes() const
    {
        constexpr std::uint64_t per_item = 5 * sizeof(std::uint32_t); // of first_equal_items
        constexpr std::uint64_t per_triangle = per_item + 6 * sizeof(std::uint32_t) + 1;
        constexpr std::uint64_t per_edge = sizeof(EdgeUse);
        return check_budget(options_.execution.budget,
                            topology_.bytes() + per_edge * topology_.edge_count() +
                                per_item * mesh_.vertex_count() +
                                per_triangle * mesh_.triangle_count(),
                            "the mesh report", "raise the budget");
    }

    void examine_positions()
    {
        report_.vertices = mesh_.vertex_count();
        report_.triangles = mesh_.triangle_count();
        report_.edges = topology_.edge_count();
        if (mesh_.triangle_count() == 0) report_whole(FindingKind::no_triangles);

        Tally unreferenced(options_.max_ids);
        Tally broken(options_.max_ids);
        bool broken_in_use = false;
        for (std::uint32_t id = 0; id < mesh_.vertex_count(); ++id) {
            const Vec3& position = mesh_.positions()[id];
            const bool in_use = !topology_.triangles(VertexId{id}).empty();
            if (!in_use) unreferenced.add(id);
            if (!is_finite(position)) {
                broken.add(id);
                broken_in_use = broken_in_use || in_use;
            } else if (in_use) {
                report_.bounds.extend(position);
            }
        }
        report_elements(FindingKind::unreferenced_vertices, ElementKind::vertex, unreferenced);
        report_elements(FindingKind::non_finite_positions, ElementKind::vertex, broken,
                        broken_in_use ? Severity::error : Severity::note,
                        broken_in_use
                            ? "these vertices have a NaN or infinite coordinate and triangles use "
                              "them: no octree can be built and every query refuses the mesh"
                            : "these vertices have a NaN or infinite coordinate, but no triangle "
                              "uses them: no query ever sees them");
        examine_scale();
        find_equal_positions();
    }

    void examine_scale()
    {
        if (report_.bounds.empty()) return;
        const double extent = report_.bounds.extent().maxCoeff();
        const double reach = detail::reach_of(report_.bounds);
        if (reach > detail::largest_safe_coordinate ||
            (extent > 0.0 && extent < detail::smallest_safe_extent)) {
            report_whole(FindingKind::extreme_scale, Severity::warning,
                         concat("the mesh is ", extent, " large with coordinates up to ", reach,
                                ": areas and volumes leave the range of double, so normals, signs "
                                "and distances may be lost; scale it towards size 1"));
        }
        if (extent > 0.0 && reach >= far_from_origin_ratio * extent) {
            const int lost = static_cast<int>(std::log10(reach) - std::log10(extent));
            report_whole(FindingKind::far_from_origin, Severity::warning,
                         concat("coordinates reach ", reach, " but the mesh is only ", extent,
                                " large: about ", std::max(0, 15 - lost),
                                " of double's 16 digits are left for its shape, and all answers "
                                "are as coarse as that; move it towards the origin, best before "
                                "it was rounded"));
        }
    }

    void find_equal_positions()
    {
        same_position_ = first_at_position(mesh_);
        Tally duplicates(options_.max_ids);
        for (std::uint32_t vertex = 0; vertex < mesh_.vertex_count(); ++vertex) {
            if (same_position_[vertex] != vertex) duplicates.add(vertex);
        }
        report_elements(FindingKind::duplicate_vertices, ElementKind::vertex, duplicates);
    }

    void examine_triangles()
    {
        std::vector<std::uint8_t> without_area(mesh_.triangle_count(), 0);
        parallel_chunks(mesh_.triangle_count(), triangles_per_task, options_.execution.threads,
                        [&](std::size_t first, std::size_t end) {
                            for (std::size_t id = first; id < end; ++id) {
                                const Triangle triangle =
                                    mesh_.triangle(TriangleId{static_cast<std::uint32_t>(id)});
                                without_area[id] =
                                    is_finite(triangle) && is_degenerate(triangle) ? 1 : 0;
                            }
                        });
        Tally degenerate(options_.max_ids);
        Tally zero_area(options_.max_ids);
        for (std::uint32_t id = 0; id < mesh_.triangle_count(); ++id) {
            const Triangle triangle = mesh_.triangle(TriangleId{id});
            if (is_finite(triangle)) report_.area += 0.5 * length_of(scaled_normal(triangle));
            if (!is_proper(mesh_.triangles()[id])) {
                degenerate.add(id);
                continue;
            }
            ++proper_triangles_;
            if (without_area[id] != 0) zero_area.add(id);
        }
        report_elements(FindingKind::degenerate_triangles, ElementKind::triangle, degenerate);
        report_elements(FindingKind::zero_area_triangles, ElementKind::triangle, zero_area);
        find_equal_triangles();
    }

    void find_equal_triangles()
    {
        const std::vector<std::uint32_t> same_ids = first_duplicates(mesh_);
        const std::vector<std::uint32_t> same_positions = first_coincident(mesh_, same_position_);
        Tally duplicate(options_.max_ids);
        Tally coincident(options_.max_ids);
        // At the first triangle of each place, how many face as it does, less the others.
        std::vector<std::int32_t> surplus(mesh_.triangle_count(), 0);
        for (std::uint32_t id = 0; id < mesh_.triangle_count(); ++id) {
            if (same_ids[id] != id) {
                duplicate.add(id);
            } else if (same_positions[id] != id) {
                coincident.add(id);
            }
            const std::uint32_t first =
                same_positions[id] != id ? same_positions[id] : same_ids[id];
            const TriangleCorners corners = welded_corners(id);
            if (!is_proper(corners)) continue;
            surplus[first] += face_the_same_way(welded_corners(first), corners) ? 1 : -1;
        }
        counts_twice_ = std::any_of(surplus.begin(), surplus.end(),
                                    [](std::int32_t each) { return std::abs(each) > 1; });
        report_elements(FindingKind::duplicate_triangles, ElementKind::triangle, duplicate);
        report_elements(FindingKind::coincident_triangles, ElementKind::triangle, coincident);
    }

    [[nodiscard]] TriangleCorners welded_corners(std::uint32_t id) const noexcept
    {
        const auto [a, b, c] = mesh_.triangles()[id];
        return {same_position_[a], same_position_[b], same_position_[c]};
    }

    void examine_edges()
    {
        uses_ = edge_uses(mesh_, topology_);
        Tally boundary(options_.max_ids);
        Tally branching(options_.max_ids);
        Tally inconsistent(options_.max_ids);
        double shortest = std::numeric_limits<double>::infinity();
        for (std::uint32_t id = 0; id < topology_.edge_count(); ++id) {
            const EdgeUse use = uses_[id];
            if (use.total() == 1) boundary.add(id);
            if (use.total() > 2) branching.add(id);
            if (use.is_inconsistent()) inconsistent.add(id);
            open_edges_ += use.is_open() ? 1U : 0U;
            proper_edges_ += use.total() > 0 ? 1U : 0U;

            const auto [low, high] = topology_.vertices(EdgeId{id});
            const double length = length_of(mesh_.position(high) - mesh_.position(low));
            if (!std::isfinite(length)) continue;
            shortest = std::min(shortest, length);
            report_.max_edge_length = std::max(report_.max_edge_length, length);
        }
        if (std::isfinite(shortest)) report_.min_edge_length = shortest;
        report_.closed = open_edges_ == 0 && proper_edges_ > 0;
        report_.consistently_oriented = inconsistent.count() == 0;
        report_elements(FindingKind::boundary_edges, ElementKind::edge, boundary);
        report_elements(FindingKind::non_manifold_edges, ElementKind::edge, branching);
        report_elements(FindingKind::inconsistent_edges, ElementKind::edge, inconsistent);
        if (boundary.count() > 0) report_.boundary_loops = boundary_loops(topology_, uses_);
        examine_fans();
    }

    void examine_fans()
    {
        const std::vector<std::uint8_t> fans = fan_counts(mesh_, topology_);
        Tally touching(options_.max_ids);
        for (std::uint32_t vertex = 0; vertex < mesh_.vertex_count(); ++vertex) {
            if (fans[vertex] > 0) ++proper_vertices_;
            if (fans[vertex] > 1) touching.add(vertex);
        }
        report_elements(FindingKind::non_manifold_vertices, ElementKind::vertex, touching);
    }

    void examine_components()
    {
        const double scale =
            report_.bounds.empty() ? 1.0 : detail::unit_scale(detail::reach_of(report_.bounds));
        const std::vector<SurfaceComponent> components =
            surface_components(mesh_, topology_, uses_);
        report_.components = components.size();
        Tally inward(options_.max_ids);
        std::uint64_t outward = 0;
        bool sealed = report_.closed;
        double volume = 0.0;
        for (const SurfaceComponent& component : components) {
            sealed = sealed && component.sealed;
            const double ratio = scale / component.volume.scale;
            volume += component.volume.volume * ratio * ratio * ratio;
            if (!component.sealed) continue;
            const int sign = component.volume.sign();
            if (sign > 0) ++outward;
            if (sign < 0) inward.add(component.first_triangle);
        }
        if (sealed) {
            report_.signed_volume = volume / 6 / scale / scale / scale;
            report_.orientation = inward.count() == 0 ? Orientation::outward
                                  : outward == 0      ? Orientation::inward
                                                      : Orientation::mixed;
            if (inward.count() + outward < components.size()) {
                report_.orientation = Orientation::undefined;
            }
        }
        const bool cavities = volume > 0.0;
        report_elements(
            FindingKind::inward_components, ElementKind::component, inward,
            cavities ? Severity::note : Severity::warning,
            cavities ? "these closed parts face inwards: right for cavities inside of another "
                       "part, else they are inside out and nothing counts as inside of them"
                     : "these closed parts are inside out: octree, closest features, rays and "
                       "intersection do not mind, but signed distances are positive within them "
                       "as well, and no cell there is an inner one; turn their triangles");

        report_.euler_characteristic = proper_vertices_ - proper_edges_ + proper_triangles_;
        const bool manifold = report_.find(FindingKind::non_manifold_edges) == nullptr &&
                              report_.find(FindingKind::non_manifold_vertices) == nullptr;
        if (report_.closed && report_.consistently_oriented && manifold) {
            report_.genus =
                static_cast<std::int64_t>(report_.components) - report_.euler_characteristic / 2;
        }
    }

    // Decides whether the mesh would be closed if vertices at equal positions were joined.
    Status examine_welded()
    {
        if (report_.closed || report_.find(FindingKind::duplicate_vertices) == nullptr) return {};
        const Result<bool> closed =
            is_closed_if_welded(mesh_, same_position_, {.execution = options_.execution});
        if (!closed) return tl::unexpected(closed.error());
        report_.closed_if_welded = *closed;
        return {};
    }

    void report_whole(FindingKind kind)
    {
        report_whole(kind, detail::usual_severity(kind), detail::usual_meaning(kind));
    }

    void report_whole(FindingKind kind, Severity severity, std::string meaning)
    {
        report_.findings.push_back(
            {kind, severity, ElementKind::mesh, 1, {}, {}, std::move(meaning)});
    }

    void report_elements(FindingKind kind, ElementKind element, const Tally& tally)
    {
        report_elements(kind, element, tally, detail::usual_severity(kind),
                        detail::usual_meaning(kind));
    }

    void report_elements(FindingKind kind, ElementKind element, const Tally& tally,
                         Severity severity, std::string meaning)
    {
        if (tally.count() == 0) return;
        std::vector<Vec3> positions;
        for (const std::uint32_t id : tally.ids()) positions.push_back(position_of(element, id));
        report_.findings.push_back({kind, severity, element, tally.count(), tally.ids(),
                                    std::move(positions), std::move(meaning)});
    }

    [[nodiscard]] Vec3 position_of(ElementKind element, std::uint32_t id) const noexcept
    {
        if (element == ElementKind::vertex) return mesh_.positions()[id];
        if (element == ElementKind::edge) {
            const auto [low, high] = topology_.vertices(EdgeId{id});
            return 0.5 * mesh_.position(low) + 0.5 * mesh_.position(high);
        }
        const Triangle triangle = mesh_.triangle(TriangleId{id});
        return triangle[0] / 3.0 + triangle[1] / 3.0 + triangle[2] / 3.0;
    }

    const TriangleMesh& mesh_;
    const Topology& topology_;
    const MeshReportOptions& options_;
    MeshReport report_;
    std::vector<std::uint32_t> same_position_; ///< the first vertex at the position of each
    bool counts_twice_ = false; ///< triangles of one place do not cancel out in winding numbers
    std::vector<EdgeUse> uses_;
    std::uint64_t open_edges_ = 0;
    std::int64_t proper_edges_ = 0;
    std::int64_t proper_vertices_ = 0;
    std::int64_t proper_triangles_ = 0;
};

const MeshFinding* MeshReport::find(FindingKind kind) const noexcept
{
    const auto found = std::find_if(findings.begin(), findings.end(),
                                    [&](const MeshFinding& each) { return each.kind == kind; });
    return found == findings.end() ? nullptr : &*found;
}

Result<MeshReport> report_mesh(const TriangleMesh& mesh, const MeshReportOptions& options)
{
    const Result<Topology> topology = build_topology(mesh, {.execution = options.execution});
    if (!topology) return tl::unexpected(topology.error());
    return report_mesh(mesh, *topology, options);
}

Result<MeshReport> report_mesh(const TriangleMesh& mesh, const Topology& topology,
                               const MeshReportOptions& options)
{
    return MeshExaminer(mesh, topology, options).examine();
}

} // namespace proxima
