#include "arrays.h"
#include "bindings.h"
#include "index_methods.h"
#include "proxima/cells_along_ray.h"
#include "proxima/cull.h"
#include "proxima/octree.h"
#include "run.h"
#include "unlocked.h"

#include <algorithm>
#include <string>
#include <vector>

namespace proxima::python {

namespace {

/// The first position of a cell among those of the deepest level, along the Morton curve.
std::uint64_t begin_of(CellKey key)
{
    const auto levels = static_cast<unsigned>(max_octree_depth - depth(key));
    return key.bits << (3 * levels);
}

/// The rows of leaves in Octree.leaves().
class LeafRows {
public:
    explicit LeafRows(const Octree& octree) { traverse(octree, *this); }

    [[nodiscard]] static bool should_enter(const Cell&) { return true; }
    Flow visit_leaf(const Cell& cell, std::span<const TriangleId>)
    {
        begins_.push_back(begin_of(cell.key));
        return Flow::proceed;
    }

    [[nodiscard]] std::int32_t row(const Cell& cell) const
    {
        return static_cast<std::int32_t>(std::ranges::lower_bound(begins_, begin_of(cell.key)) -
                                         begins_.begin());
    }

private:
    std::vector<std::uint64_t> begins_; ///< ascending
};

py::array visible_cells(const Octree& octree, const py::object& planes, bool exact)
{
    const ViewVolume volume = volume_of(planes);
    std::vector<std::int32_t> rows;
    {
        const Unlocked unlocked;
        const LeafRows leaves(octree);
        visible_cells(octree, volume, exact ? CullMode::exact : CullMode::conservative,
                      [&](const VisibleCell& cell) {
                          rows.push_back(leaves.row(cell.cell));
                          return Flow::proceed;
                      });
    }
    return array_of<std::int32_t>(std::span<const std::int32_t>(rows));
}

py::object along_rays(const Octree& octree, const py::object& origins, const py::object& directions,
                      const py::object& progress)
{
    const PointsArgument from(origins, "origins");
    const PointsArgument along(directions, "directions");
    if (from.size() != along.size()) {
        refuse("directions", "must be as many as origins, " + std::to_string(from.size()) +
                                 ", are " + std::to_string(along.size()));
    }
    std::vector<std::size_t> first{0};
    std::vector<std::int32_t> rows;
    std::vector<double> enter;
    std::vector<double> exit;
    std::vector<double> chord;
    std::vector<double> weight;
    run(progress, Duration::lengthy, [&](Progress* watched) -> Status {
        watched->begin_stage("cells along rays", from.size());
        const LeafRows leaves(octree);
        const Box root = octree.box(octree.root());
        for (std::size_t i = 0; i < from.size(); ++i) {
            if (watched->cancelled()) return fail(ErrorCode::cancelled, "the search was cancelled");
            const Ray ray{.origin = from.points()[i], .direction = along.points()[i]};
            if (!is_valid(ray)) {
                return fail(ErrorCode::invalid_argument,
                            "ray " + std::to_string(i) +
                                " is not finite or has no direction: leave it out",
                            "origins, directions");
            }
            if (!(root.lower - ray.origin).allFinite() || !(root.upper - ray.origin).allFinite()) {
                return fail(ErrorCode::invalid_argument,
                            "ray " + std::to_string(i) +
                                " is so far from the octree that their distance is no number",
                            "origins");
            }
            cells_along_ray(octree, ray, [&](const CellOnRay& at) {
                rows.push_back(leaves.row(at.cell));
                enter.push_back(at.enter);
                exit.push_back(at.exit);
                chord.push_back(at.chord);
                weight.push_back(at.penetration);
                return Flow::proceed;
            });
            first.push_back(rows.size());
            watched->advance(1);
        }
        return {};
    });
    const auto column = [](const std::vector<double>& values) {
        return array_of<double>(std::span<const double>(values));
    };
    return result_type("CellsOnRays")(array_of<std::int64_t>(std::span<const std::size_t>(first)),
                                      array_of<std::int32_t>(std::span<const std::int32_t>(rows)),
                                      column(enter), column(exit), column(chord), column(weight));
}

} // namespace

void bind_octree_cells(py::class_<Octree>& octree)
{
    octree
        .def(
            "visible", &visible_cells, py::arg("planes"), py::kw_only(), py::arg("exact") = false,
            R"(The leaves in a view volume, empty ones included: rows of leaves(), (m,) int32, ascending.

    planes  (k, 4) floats as in Index.visible
    exact   True: exactly those whose closed box has a point in common with the volume

Occlusion is not tested. O(leaves), about 20 ns each.)")
        .def(
            "along_rays", &along_rays, py::arg("origins"), py::arg("directions"), py::kw_only(),
            py::arg("progress") = py::none(),
            R"(The leaves that rays pass through, in order, and the stretch of the ray in each, as CellsOnRays.

    origins     (n, 3) floats
    directions  (n, 3) floats, of any length but 0

Leaves touched in a point alone are left out; stretches join without a gap. O(leaves), and about 0.1 us a cell. Raises
InvalidInput for a ray that is not finite or has no direction.)");
}

} // namespace proxima::python
