#include "mesh/small_components.h"

#include "base/disjoint_sets.h"
#include "geometry/length.h"
#include "mesh/surface_parts.h"

#include <algorithm>
#include <vector>

namespace proxima::detail {

namespace {

/// Joins the proper triangles at an edge.
void unite_at(const TriangleMesh& mesh, const Topology& topology, EdgeId edge, DisjointSets& sets)
{
    TriangleId previous = no_triangle;
    for (const TriangleId one : topology.triangles(edge)) {
        if (!is_proper(mesh.triangles()[to_index(one)])) continue;
        if (previous != no_triangle) sets.unite(to_index(previous), to_index(one));
        previous = one;
    }
}

/// By which areas are computed: squares of larger and smaller meshes may not be doubles.
double scale_for_areas(const TriangleMesh& mesh)
{
    double longest = 0; // along an axis
    for (std::uint32_t i = 0; i < mesh.triangle_count(); ++i) {
        const Triangle one = mesh.triangle(TriangleId{i});
        if (is_finite(one)) longest = std::max(longest, bounding_box(one).extent().maxCoeff());
    }
    return unit_scale(longest);
}

} // namespace

std::uint64_t drop_small_components(const TriangleMesh& mesh, const Topology& topology,
                                    std::uint64_t min_triangles, double min_area,
                                    std::span<std::uint8_t> kept)
{
    const auto count = static_cast<std::uint32_t>(mesh.triangle_count());
    DisjointSets sets(count);
    for (std::uint32_t edge = 0; edge < topology.edge_count(); ++edge)
        unite_at(mesh, topology, EdgeId{edge}, sets);

    struct Size {
        std::uint64_t triangles = 0;
        double area = 0;
    };
    std::vector<Size> sizes(count); // of each set at its lowest triangle
    const double scale = scale_for_areas(mesh);
    double largest = 0;
    for (std::uint32_t i = 0; i < count; ++i) {
        Size& size = sizes[sets.find(i)];
        ++size.triangles;
        const Triangle one = mesh.triangle(TriangleId{i});
        if (is_finite(one))
            size.area += length_of((scale * (one[1] - one[0])).cross(scale * (one[2] - one[0])));
        largest = std::max(largest, size.area);
    }
    std::uint64_t dropped = 0;
    for (std::uint32_t i = 0; i < count; ++i) {
        if (!is_proper(mesh.triangles()[i])) continue;
        const std::uint32_t first = sets.find(i);
        const bool small =
            sizes[first].triangles < min_triangles || sizes[first].area < min_area * largest;
        if (!small) continue;
        kept[i] = 0;
        dropped += first == i ? 1 : 0;
    }
    return dropped;
}

} // namespace proxima::detail
