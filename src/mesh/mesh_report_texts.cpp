#include "mesh/mesh_report_texts.h"

#include "base/text.h"

#include <algorithm>
#include <array>

namespace proxima {

namespace {

struct Words {
    std::string_view name;
    Severity severity;
    std::string_view meaning; ///< empty where it depends on measured values
};

// By FindingKind.
constexpr std::array<Words, 15> finding_words = {{
    {"no_triangles", Severity::error,
     "there is nothing to build an octree from, and so nothing to query"},
    {"non_finite_positions", Severity::error, ""},
    {"extreme_scale", Severity::warning, ""},
    {"far_from_origin", Severity::warning, ""},
    {"unreferenced_vertices", Severity::note,
     "no triangle uses these vertices: no query ever sees them, they only take memory"},
    {"duplicate_vertices", Severity::warning,
     "these vertices lie exactly on earlier ones without being the same vertex, so the triangles "
     "around them are not neighbours: octree, rays and intersection do not mind, but closest "
     "features may name any of the copies and the seams between them count as boundary; weld them"},
    {"degenerate_triangles", Severity::warning,
     "a triangle with the same vertex twice is a segment or a point: the octree and closest "
     "features keep it as that, rays pass through it, signs and winding numbers do not count it"},
    {"zero_area_triangles", Severity::warning,
     "a triangle whose corners lie on one line has no normal: the octree and closest features "
     "keep it as a segment, rays pass through it, its face takes no part in signs"},
    {"duplicate_triangles", Severity::warning,
     "these triangles have the vertices of an earlier one: octree lists and intersection pairs "
     "hold both, and rays and closest features name the lower id; those that face each other "
     "cancel out in winding numbers, those that face one way spoil signs and inner and outer cells "
     "there"},
    {"coincident_triangles", Severity::warning,
     "these triangles lie exactly on an earlier one with vertices of their own: octree lists and "
     "intersection pairs hold both, and rays and closest features name the lower id; those that "
     "face each other cancel out in winding numbers, those that face one way spoil signs and inner "
     "and outer cells there"},
    {"boundary_edges", Severity::warning,
     "the surface has holes or an open border: octree, closest features, rays and intersection "
     "are as good as ever, but inside and outside rest on winding numbers, which blur near a hole, "
     "and containment is a guess"},
    {"non_manifold_edges", Severity::warning,
     "three or more triangles share an edge: octree, closest features, rays and intersection take "
     "all of them, but signs near it need winding numbers and walks across it have no one next "
     "triangle"},
    {"non_manifold_vertices", Severity::warning,
     "parts of the surface touch in nothing but a vertex: all queries work, but the sign of a "
     "point nearest to it needs a winding number"},
    {"inconsistent_edges", Severity::warning,
     "neighbouring triangles face opposite ways across these edges: octree, closest features, "
     "rays and intersection do not mind, but normals, signs and inner and outer cells contradict "
     "themselves; orient the triangles the same way"},
    {"inward_components", Severity::warning, ""},
}};

const Words& words(FindingKind kind) noexcept
{
    return finding_words[static_cast<std::size_t>(kind)];
}

QueryOutlook expect(QueryKind query, Outlook outlook, std::string_view reason)
{
    return {query, outlook, std::string(reason)};
}

/// The name of a finding in words: "no triangles".
std::string spaced(std::string_view name)
{
    std::string text(name);
    std::replace(text.begin(), text.end(), '_', ' ');
    return text;
}

bool any(const MeshReport& report, std::initializer_list<FindingKind> kinds) noexcept
{
    return std::any_of(kinds.begin(), kinds.end(),
                       [&](FindingKind kind) { return report.find(kind) != nullptr; });
}

} // namespace

std::string_view name_of(FindingKind kind) noexcept
{
    return words(kind).name;
}

std::string_view name_of(Severity severity) noexcept
{
    constexpr std::array<std::string_view, 3> names = {"note", "warning", "error"};
    return names[static_cast<std::size_t>(severity)];
}

std::string_view name_of(ElementKind element) noexcept
{
    constexpr std::array<std::string_view, 5> names = {"mesh", "vertex", "edge", "triangle",
                                                       "component"};
    return names[static_cast<std::size_t>(element)];
}

std::string_view name_of(QueryKind query) noexcept
{
    constexpr std::array<std::string_view, 6> names = {"octree", "cell_classes", "closest_feature",
                                                       "sign",   "rays",         "intersection"};
    return names[static_cast<std::size_t>(query)];
}

std::string_view name_of(Outlook outlook) noexcept
{
    constexpr std::array<std::string_view, 3> names = {"works", "with_care", "refused"};
    return names[static_cast<std::size_t>(outlook)];
}

std::string_view name_of(Orientation orientation) noexcept
{
    constexpr std::array<std::string_view, 4> names = {"undefined", "outward", "inward", "mixed"};
    return names[static_cast<std::size_t>(orientation)];
}

Severity detail::usual_severity(FindingKind kind) noexcept
{
    return words(kind).severity;
}

double detail::reach_of(const Box& box) noexcept
{
    return std::max(box.lower.cwiseAbs().maxCoeff(), box.upper.cwiseAbs().maxCoeff());
}

std::string detail::usual_meaning(FindingKind kind)
{
    return std::string(words(kind).meaning);
}

std::vector<QueryOutlook> detail::outlook_of(const MeshReport& report, bool counts_twice)
{
    using enum FindingKind;
    using enum QueryKind;
    using enum Outlook;
    constexpr std::array<QueryKind, 6> queries = {octree, cell_classes, closest_feature,
                                                  sign,   rays,         intersection};
    std::vector<QueryOutlook> all;
    const auto refusal =
        std::find_if(report.findings.begin(), report.findings.end(),
                     [](const MeshFinding& each) { return each.severity == Severity::error; });
    if (refusal != report.findings.end()) {
        for (const QueryKind query : queries) {
            all.push_back(expect(query, refused, spaced(name_of(refusal->kind))));
        }
        return all;
    }
    constexpr std::string_view rescale = "scale the mesh towards size 1 first";
    const bool ill_scaled = any(report, {extreme_scale});
    const bool sided = report.closed && report.consistently_oriented && !counts_twice &&
                       report.orientation != Orientation::inward;
    const bool branching = any(report, {non_manifold_edges, non_manifold_vertices});

    all.push_back(expect(octree, works, "any triangles will do"));
    if (sided) {
        all.push_back(expect(cell_classes, works, "closed and consistently oriented"));
        all.push_back(
            branching || report.orientation == Orientation::undefined
                ? expect(sign, with_care, "winding numbers decide where several sheets meet")
                : expect(sign, works, "the nearest feature's normal decides"));
    } else {
        const std::string_view reason =
            report.orientation == Orientation::inward && report.closed
                ? "inside out: turn all triangles"
            : !report.closed ? "open: winding numbers decide, they blur near holes"
            : counts_twice   ? "doubled triangles count twice in winding numbers"
                             : "triangles face both ways: orient them the same way";
        all.push_back(expect(cell_classes, with_care, reason));
        all.push_back(expect(sign, with_care, reason));
    }
    all.push_back(any(report, {duplicate_vertices})
                      ? expect(closest_feature, with_care,
                               "distances hold; the feature may be any of several equal vertices")
                      : expect(closest_feature, works, "any triangles will do"));
    all.push_back(any(report, {degenerate_triangles, zero_area_triangles})
                      ? expect(rays, with_care, "triangles without area are never hit")
                      : expect(rays, works, "any triangles will do"));
    all.push_back(report.closed && !any(report, {non_manifold_edges})
                      ? expect(intersection, works, "pairs and containment")
                      : expect(intersection, with_care,
                               "pairs hold; containment goes by winding numbers where an odd "
                               "number of triangles share an edge"));
    const bool too_large = detail::reach_of(report.bounds) > detail::largest_safe_coordinate;
    for (QueryOutlook& each : all) {
        if (too_large && (each.query == octree || each.query == cell_classes)) {
            each = expect(each.query, refused, rescale);
        } else if (ill_scaled && each.outlook == works) {
            each = expect(each.query, with_care, rescale);
        }
    }
    std::sort(all.begin(), all.end(),
              [](const QueryOutlook& a, const QueryOutlook& b) { return a.query < b.query; });
    return all;
}

} // namespace proxima
