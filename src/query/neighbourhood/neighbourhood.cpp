#include "proxima/neighbourhood.h"

#include "base/check.h"
#include "geometry/triangle_box.h"
#include "index/index_parts.h"
#include "index/triangle_lanes.h"
#include "index/visit_near.h"
#include "proxima/octree.h"
#include "query/closest/feature_distance.h"
#include "query/contact/triangles_in_box.h"
#include "query/neighbourhood/incident_triangles.h"

#include <algorithm>
#include <array>

namespace proxima {

namespace {

/// Appends to a caller's buffer until it is full.
template <class Item>
class BufferWriter {
public:
    explicit BufferWriter(std::span<Item> buffer) noexcept : buffer_(buffer) {}

    /// False where it is full.
    bool add(const Item& item) noexcept
    {
        if (result_.written == buffer_.size()) {
            result_.complete = false;
            return false;
        }
        buffer_[result_.written++] = item;
        return true;
    }
    [[nodiscard]] std::span<Item> written() const noexcept
    {
        return buffer_.first(result_.written);
    }
    [[nodiscard]] const Neighbourhood& result() const noexcept { return result_; }

private:
    std::span<Item> buffer_;
    Neighbourhood result_;
};

/// Adds the unmarked triangles at the triangle's vertices; false where it is full.
bool add_neighbours(const TriangleMesh& mesh, const Topology& topology, TriangleId triangle,
                    NeighbourhoodScratch& scratch, BufferWriter<TriangleId>& found) noexcept
{
    for (const std::uint32_t corner : mesh.triangles()[to_index(triangle)]) {
        const VertexId vertex{corner};
        if (!scratch.mark(vertex)) continue;
        for (const TriangleId neighbour : topology.triangles(vertex)) {
            if (scratch.mark(neighbour) && !found.add(neighbour)) return false;
        }
    }
    return true;
}

/// Of the nearest of its features, scaled.
template <class Scalar>
double squared_distance_of(const TriangleRow<Scalar>& row, const Vec3& p, const RowScale& scale)
{
    NearestFeature nearest;
    offer_row(row, p, scale, nearest);
    return nearest.squared;
}

/// Calls visit(row, squared) for the triangles within a limit; it returns the limit from then on,
/// negative to end. Squared distances and limits are scaled.
template <class Scalar, class Visit>
void visit_rows(const IndexParts& index, std::span<const TriangleRow<Scalar>> rows, const Vec3& p,
                double limit, const Visit& visit) noexcept
{
    const RowScale scale{index.scale(), index.unscale()};
    // Distances are rounded as coordinates are, which may be far from the origin.
    const double reach = 2 + index.scale() * index.center().cwiseAbs().maxCoeff();
    NearWalk walk(index, {p, p}, limit);
    while (const IndexLeaf* const leaf = walk.next_leaf()) {
        const auto group = rows.subspan(leaf->first_row, leaf->count);
        std::array<double, 8> squared;
        triangle_distances(group, p, scale.up, squared);
        for (std::size_t i = 0; i < group.size() && limit >= 0; ++i) {
            if (squared[i] > triangle_distance_limit(limit, reach)) continue;
            const double found = squared_distance_of(group[i], p, scale);
            if (found <= limit) limit = visit(group[i], found);
        }
        walk.shrink(limit);
    }
}

/// Calls visit(row, squared) as visit_rows does, for an index with rows of floats or of doubles. The
/// radius is in the mesh's unit.
template <class Visit>
void visit_within(const IndexParts& index, const Vec3& p, double radius,
                  const Visit& visit) noexcept
{
    if (!p.allFinite() || !(radius >= 0)) return;
    const double limit = radius * index.scale() * (radius * index.scale());
    if (index.double_rows().empty()) {
        visit_rows(index, index.float_rows(), p, limit, visit);
    } else {
        visit_rows(index, index.double_rows(), p, limit, visit);
    }
}

/// Calls visit(row, squared) for the triangles within the radius; it returns Flow.
template <class Visit>
void visit_all_within(const IndexParts& index, const Vec3& p, double radius,
                      const Visit& visit) noexcept
{
    const double limit = radius * index.scale() * (radius * index.scale());
    visit_within(index, p, radius, [&](const auto& row, double squared) {
        return visit(row, squared) == Flow::stop ? -1.0 : limit;
    });
}

/// Comes before all triangles in the order of answers.
constexpr NearTriangle before_all{-1, TriangleId{0}};

/// Fills the buffer with the triangles within the radius that come next after `last`, in order. How
/// many; squared distances are scaled. \pre the buffer is not empty
std::size_t nearest_after(const IndexParts& index, const Vec3& p, double radius,
                          const NearTriangle& last, std::span<NearTriangle> buffer) noexcept
{
    const double limit = radius * index.scale() * (radius * index.scale());
    std::size_t count = 0;
    // A heap with the farthest at its top.
    const auto begin = buffer.begin();
    const auto end = [&] { return begin + static_cast<std::ptrdiff_t>(count); };
    const auto farthest = [&] {
        return count == buffer.size() ? buffer.front().squared_distance : limit;
    };
    visit_within(index, p, radius, [&](const auto& row, double squared) {
        const NearTriangle found{squared, TriangleId{row.triangle_id()}};
        if (!(last < found)) return farthest();
        if (count == buffer.size()) {
            if (!(found < buffer.front())) return farthest();
            std::pop_heap(begin, end());
            --count;
        }
        buffer[count++] = found;
        std::push_heap(begin, end());
        return farthest();
    });
    std::sort_heap(begin, end());
    return count;
}

/// Squared distance of a side with its ends, scaled.
template <class Scalar>
double closed_distance(const TriangleRow<Scalar>& row, std::size_t side, const Vec3& p,
                       const RowScale& scale) noexcept
{
    Vec3 from = row.corner(static_cast<int>(side));
    Vec3 to = row.corner(side == 2 ? 0 : static_cast<int>(side) + 1);
    if (row.backward(side)) std::swap(from, to);
    const double inside = foot_between(from, to, p, scale).squared;
    const double at_ends =
        std::min(squared_distance(from, p, scale), squared_distance(to, p, scale));
    return inside <= at_ends ? inside : at_ends;
}

} // namespace

std::span<const TriangleId> incident_triangles(const Topology& topology, const Feature& feature,
                                               const TriangleId& face) noexcept
{
    switch (feature.kind) {
    case FeatureKind::vertex:
        return topology.triangles(VertexId{feature.id});
    case FeatureKind::edge:
        return topology.triangles(EdgeId{feature.id});
    case FeatureKind::face:
        break;
    }
    return {&face, 1};
}

NeighbourhoodScratch::NeighbourhoodScratch(const TriangleMesh& mesh)
    : vertices_(mesh.vertex_count(), 0), triangles_(mesh.triangle_count(), 0)
{}

void NeighbourhoodScratch::begin() noexcept
{
    if (++round_ != 0) return;
    std::ranges::fill(vertices_, 0U);
    std::ranges::fill(triangles_, 0U);
    round_ = 1;
}

Neighbourhood collect_rings(const TriangleMesh& mesh, const Topology& topology,
                            const Feature& feature, int rings, NeighbourhoodScratch& scratch,
                            std::span<TriangleId> buffer, std::span<std::size_t> ring_ends) noexcept
{
    PROXIMA_CHECK_EQ(scratch.triangle_count(), mesh.triangle_count());
    PROXIMA_CHECK_EQ(scratch.vertex_count(), mesh.vertex_count());
    PROXIMA_CHECK_GE(rings, 0);
    scratch.begin();
    BufferWriter<TriangleId> found(buffer);
    std::size_t ring_begin = 0;
    const auto end_ring = [&](int ring) {
        std::ranges::sort(found.written().subspan(ring_begin));
        const auto at = static_cast<std::size_t>(ring);
        if (at < ring_ends.size()) ring_ends[at] = found.result().written;
    };

    const TriangleId face{feature.id};
    for (const TriangleId triangle : incident_triangles(topology, feature, face)) {
        if (scratch.mark(triangle) && !found.add(triangle)) break;
    }
    end_ring(0);
    for (int ring = 1; ring <= rings; ++ring) {
        const std::span<const TriangleId> last = found.written().subspan(ring_begin);
        if (last.empty()) { // so are all that follow
            if (static_cast<std::size_t>(ring) < ring_ends.size()) {
                const auto wanted = std::min(ring_ends.size(), static_cast<std::size_t>(rings) + 1);
                std::ranges::fill(ring_ends.first(wanted).subspan(static_cast<std::size_t>(ring)),
                                  found.result().written);
            }
            break;
        }
        ring_begin = found.result().written;
        if (found.result().complete) {
            for (const TriangleId triangle : last) {
                if (!add_neighbours(mesh, topology, triangle, scratch, found)) break;
            }
        }
        end_ring(ring);
    }
    return found.result();
}

Neighbourhood collect_triangles(const MeshIndex& index, const Vec3& p, double radius,
                                std::span<TriangleId> buffer) noexcept
{
    BufferWriter<TriangleId> found(buffer);
    visit_all_within(index.parts(), p, radius, [&](const auto& row, double) {
        return found.add(TriangleId{row.triangle_id()}) ? Flow::proceed : Flow::stop;
    });
    std::ranges::sort(found.written());
    return found.result();
}

void visit_triangles(const MeshIndex& index, const Vec3& p, double radius,
                     FunctionRef<Flow(TriangleId, double)> visitor) noexcept
{
    const IndexParts& parts = index.parts();
    const RowScale scale{parts.scale(), parts.unscale()};
    visit_all_within(parts, p, radius, [&](const auto& row, double squared) {
        return visitor(TriangleId{row.triangle_id()}, scale.unscale_squared(squared));
    });
}

Neighbourhood collect_triangles(const MeshIndex& index, const Box& box,
                                std::span<TriangleId> buffer) noexcept
{
    BufferWriter<TriangleId> found(buffer);
    visit_triangles(index, box,
                    [&](TriangleId id) { return found.add(id) ? Flow::proceed : Flow::stop; });
    std::ranges::sort(found.written());
    return found.result();
}

void visit_triangles(const MeshIndex& index, const Box& box,
                     FunctionRef<Flow(TriangleId)> visitor) noexcept
{
    visit_triangles_in_box(index.parts(), box, [&](TriangleId id, const Triangle& triangle) {
        // No more of the box than may matter: that is finite.
        const Box own = bounding_box(triangle);
        const Box common{own.lower.cwiseMax(box.lower), own.upper.cwiseMin(box.upper)};
        return !triangle_overlaps_box(triangle, common) || visitor(id) == Flow::proceed;
    });
}

Neighbourhood collect_nearest(const MeshIndex& index, const Vec3& p, std::span<NearTriangle> buffer,
                              double radius) noexcept
{
    const IndexParts& parts = index.parts();
    const RowScale scale{parts.scale(), parts.unscale()};
    Neighbourhood result;
    if (buffer.empty()) {
        visit_within(parts, p, radius, [&](const auto&, double) {
            result.complete = false;
            return -1.0;
        });
        return result;
    }
    result.written = nearest_after(parts, p, radius, before_all, buffer);
    result.complete = result.written < buffer.size() || buffer.size() == parts.triangle_count();
    for (NearTriangle& one : buffer.first(result.written))
        one.squared_distance = scale.unscale_squared(one.squared_distance);
    return result;
}

void visit_nearest(const MeshIndex& index, const Vec3& p, std::span<NearTriangle> batch,
                   FunctionRef<Flow(TriangleId, double)> visitor, double radius) noexcept
{
    PROXIMA_CHECK(!batch.empty());
    const IndexParts& parts = index.parts();
    const RowScale scale{parts.scale(), parts.unscale()};
    NearTriangle last = before_all;
    std::size_t count = batch.size();
    while (count == batch.size()) {
        count = nearest_after(parts, p, radius, last, batch);
        for (const NearTriangle& one : batch.first(count)) {
            if (visitor(one.triangle, scale.unscale_squared(one.squared_distance)) == Flow::stop)
                return;
            last = one;
        }
    }
}

Neighbourhood collect_features(const MeshIndex& index, const Vec3& p, double radius,
                               std::span<NearestFeature> buffer) noexcept
{
    const IndexParts& parts = index.parts();
    const RowScale scale{parts.scale(), parts.unscale()};
    const double limit = radius * scale.up * (radius * scale.up);
    BufferWriter<NearestFeature> found(buffer);
    // Each feature is offered by the lowest of its triangles alone: that one is as near.
    visit_all_within(parts, p, radius, [&](const auto& row, double squared) {
        const std::uint32_t id = row.triangle_id();
        const auto offer = [&](double at, FeatureKind kind, std::uint32_t feature) {
            return !(at <= limit) || found.add({scale.unscale_squared(at), {kind, feature}});
        };
        const auto is_lowest = [&](std::uint32_t word) { return incidence::triangle(word) == id; };
        if (!offer(squared, FeatureKind::face, id)) return Flow::stop;
        for (std::size_t k = 0; k < 3; ++k) {
            const std::uint32_t vertex = row.vertices[k];
            if (corner_of(row, vertex) == k && is_lowest(parts.vertex_incidences()[vertex]) &&
                !offer(squared_distance(row.corner(static_cast<int>(k)), p, scale),
                       FeatureKind::vertex, vertex)) {
                return Flow::stop;
            }
            const std::uint32_t edge = row.edges[k];
            const bool met = edge == to_index(no_edge) ||
                             std::find(row.edges, row.edges + k, edge) != row.edges + k;
            if (!met && is_lowest(parts.edge_incidences()[edge]) &&
                !offer(closed_distance(row, k, p, scale), FeatureKind::edge, edge)) {
                return Flow::stop;
            }
        }
        return Flow::proceed;
    });
    std::ranges::sort(found.written(), {}, &NearestFeature::feature);
    return found.result();
}

} // namespace proxima
