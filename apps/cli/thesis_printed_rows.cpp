#include "cli/thesis_printed_rows.h"

#include "base/text.h"
#include "cli/text_table.h"
#include "cli/thesis_tables.h"
#include "proxima/octree.h"
#include "proxima/sample_meshes.h"
#include "thesis/octree_generation/overlap_as_printed.h"

#include <array>
#include <cmath>
#include <fmt/core.h>
#include <numbers>
#include <vector>

namespace proxima {

namespace {

/// Where the coordinates of the sphere come from.
enum class Coordinates : std::uint8_t {
    rounded, ///< the built-in's: exactly 0 where a plane of symmetry is
    plain    ///< sine and cosine as the C library has them
};

struct Hypothesis {
    std::string_view text;
    PrintedRules rules;
    Coordinates coordinates = Coordinates::rounded;
};

constexpr std::array hypotheses = {
    Hypothesis{"as printed", {}},
    Hypothesis{"as printed, plain sines", {}, Coordinates::plain},
    Hypothesis{"as printed, float32", {.width = FloatWidth::float_32}},
    Hypothesis{"as printed, ties to 1e-5", {.tie_tolerance = 1e-5}},
    Hypothesis{"v1 in the maximal list", {.first_vertex = FirstVertex::in_maximal_list}},
    Hypothesis{"v1 in neither list, both lists offered", {.offers = ListOffers::both_lists}},
    Hypothesis{"v1 in both lists", {.first_vertex = FirstVertex::in_both_lists}},
    Hypothesis{"v1 in both lists, plain sines",
               {.first_vertex = FirstVertex::in_both_lists},
               Coordinates::plain},
    Hypothesis{"all put right",
               {.first_vertex = FirstVertex::in_both_lists, .offers = ListOffers::both_lists}}};

TriangleMesh plain_sphere(const TriangleMesh& sphere, int stacks, int slices)
{
    // The built-in's vertices in its order: a pole, rings from the top, the other pole.
    std::vector<Vec3> positions = {{0, 0, 1}};
    for (int i = 1; i < stacks; ++i) {
        const double polar = std::numbers::pi * i / stacks;
        for (int j = 0; j < slices; ++j) {
            const double turn = 2 * std::numbers::pi * j / slices;
            positions.emplace_back(std::sin(polar) * std::cos(turn),
                                   std::sin(polar) * std::sin(turn), std::cos(polar));
        }
    }
    positions.emplace_back(0, 0, -1);
    return *make_triangle_mesh(std::move(positions),
                               {sphere.triangles().begin(), sphere.triangles().end()});
}

} // namespace

Status add_printed_rows(const ThesisComparisonOptions& options, ThesisComparison& comparison)
{
    constexpr int rings = 100;
    const TriangleMesh sphere = make_sphere(rings, rings);
    const TriangleMesh plain = plain_sphere(sphere, rings, rings);
    TextTable table(
        {"Depth", "Minkowski sums", "Total", "Leaves", "Occ. %", "Min-Tri", "Max-Tri", "Pointers"});
    for (const thesis::SphereRow& row : thesis::table_2_1) {
        table.add_row({to_text(row.depth), "thesis", to_text(row.total), to_text(row.leaves),
                       fmt::format("{:.1f}", row.occupied_percent), to_text(row.min_triangles),
                       to_text(row.max_triangles), to_text(row.references)});
        for (const Hypothesis& hypothesis : hypotheses) {
            const auto octree = build_octree_as_printed(
                hypothesis.coordinates == Coordinates::plain ? plain : sphere, hypothesis.rules,
                {.max_depth = row.depth,
                 .threshold = row.threshold,
                 .classification = Classification::none,
                 .execution = options.execution});
            if (!octree) return tl::unexpected(octree.error());
            const OctreeStatistics ours = octree_statistics(*octree);
            table.add_row({"", std::string(hypothesis.text), to_text(ours.total),
                           to_text(ours.leaves), fmt::format("{:.1f}", ours.occupied_percent),
                           to_text(ours.min_triangles), to_text(ours.max_triangles),
                           to_text(ours.references)});
            comparison.rows.push_back({{"depth", row.depth},
                                       {"hypothesis", hypothesis.text},
                                       {"total", ours.total},
                                       {"leaves", ours.leaves},
                                       {"occupied_percent", ours.occupied_percent},
                                       {"min_triangles", ours.min_triangles},
                                       {"max_triangles", ours.max_triangles},
                                       {"references", ours.references}});
        }
    }
    comparison.text += "By the pseudocode of section 3.2:\n\n" + table.text() + "\n";
    return {};
}

} // namespace proxima
