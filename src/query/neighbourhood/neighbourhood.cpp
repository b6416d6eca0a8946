#include "query/neighbourhood/neighbourhood.h"

#include "base/check.h"
#include "index/triangle_lanes.h"

#include <algorithm>
#include <array>

namespace proxima {

namespace {

/// Appends to a caller's buffer until it is full.
template <class Item>
class BufferWriter {
public:
    explicit BufferWriter(std::span<Item> buffer) noexcept : buffer_(buffer) {}

    /// False where there is no room.
    bool add(const Item& item) noexcept
    {
        if (result_.count == buffer_.size()) {
            result_.complete = false;
            return false;
        }
        buffer_[result_.count++] = item;
        return true;
    }
    [[nodiscard]] std::span<Item> written() const noexcept { return buffer_.first(result_.count); }
    [[nodiscard]] const Neighbourhood& result() const noexcept { return result_; }

private:
    std::span<Item> buffer_;
    Neighbourhood result_;
};

/// Adds the unmarked triangles at the triangle's vertices; false where there is no room.
bool add_neighbours(const TriangleMesh& mesh, const Topology& topology, TriangleId triangle,
                    NeighbourhoodScratch& scratch, BufferWriter<TriangleId>& found) noexcept
{
    for (const std::uint32_t corner : mesh.triangles()[index(triangle)]) {
        const VertexId vertex{corner};
        if (!scratch.mark(vertex)) continue;
        for (const TriangleId neighbour : topology.triangles(vertex)) {
            if (scratch.mark(neighbour) && !found.add(neighbour)) return false;
        }
    }
    return true;
}

/// Calls visit(id, squared) for the triangles within the radius; it returns Flow.
template <class Visit>
void visit_triangles(const SurfaceSearch& search, const Vec3& p, double radius,
                     const Visit& visit) noexcept
{
    if (!p.allFinite() || !(radius >= 0)) return;
    const double limit = radius * radius;
    const double scale = search.tree().scale();
    const double lane_limit = triangle_distance_limit(limit * scale * scale, search.tree().reach());
    visit_within(search.tree(), {p, p}, limit, [&](RankRange ranks) noexcept {
        const std::span<const TriangleId> ids = search.triangles(ranks);
        std::array<double, TriangleTree::width> squared;
        triangle_distances(search.mesh(), ids, p, scale, squared);
        for (std::size_t i = 0; i < ids.size(); ++i) {
            if (squared[i] > lane_limit) continue;
            NearestFeature nearest;
            offer_triangle(search.mesh(), search.topology(), ids[i], p, {scale, 1 / scale},
                           nearest);
            const double found = nearest.squared / scale / scale;
            if (!(found <= limit)) continue;
            if (visit(ids[i], found) == Flow::stop) return Flow::stop;
        }
        return Flow::proceed;
    });
}

/// Squared distance of the closed edge.
double closed_distance(const SurfaceSearch& search, EdgeId edge, const Vec3& p) noexcept
{
    const EdgeVertices& ends = search.topology().vertices(edge);
    const Vec3& from = search.mesh().position(ends[0]);
    const Vec3& to = search.mesh().position(ends[1]);
    const double inside = foot_between(from, to, p, {}).squared;
    const double at_ends = std::min(squared_distance(from, p), squared_distance(to, p));
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
        const auto place = static_cast<std::size_t>(ring);
        if (place < ring_ends.size()) ring_ends[place] = found.result().count;
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
                                  found.result().count);
            }
            break;
        }
        ring_begin = found.result().count;
        if (found.result().complete) {
            for (const TriangleId triangle : last) {
                if (!add_neighbours(mesh, topology, triangle, scratch, found)) break;
            }
        }
        end_ring(ring);
    }
    return found.result();
}

Neighbourhood collect_triangles(const SurfaceSearch& search, const Vec3& p, double radius,
                                std::span<TriangleId> buffer) noexcept
{
    BufferWriter<TriangleId> found(buffer);
    visit_triangles(search, p, radius, [&](TriangleId id, double) {
        return found.add(id) ? Flow::proceed : Flow::stop;
    });
    std::ranges::sort(found.written());
    return found.result();
}

Neighbourhood collect_features(const SurfaceSearch& search, const Vec3& p, double radius,
                               std::span<NearestFeature> buffer) noexcept
{
    const double limit = radius * radius;
    const TriangleMesh& mesh = search.mesh();
    const Topology& topology = search.topology();
    BufferWriter<NearestFeature> found(buffer);
    // Each feature is offered by the lowest of its triangles alone: that one is as near.
    visit_triangles(search, p, radius, [&](TriangleId id, double squared) {
        const auto offer = [&](double at, FeatureKind kind, std::uint32_t feature) {
            return !(at <= limit) || found.add({at, {kind, feature}});
        };
        if (!offer(squared, FeatureKind::face, index(id))) return Flow::stop;
        const TriangleCorners& corners = mesh.triangles()[index(id)];
        const std::array<EdgeId, 3>& edges = topology.edges(id);
        for (std::size_t k = 0; k < 3; ++k) {
            const VertexId vertex{corners[k]};
            const bool repeated =
                std::find(corners.begin(), corners.begin() + k, corners[k]) != corners.begin() + k;
            if (!repeated && topology.triangles(vertex).front() == id &&
                !offer(squared_distance(mesh.position(vertex), p), FeatureKind::vertex,
                       index(vertex))) {
                return Flow::stop;
            }
            const EdgeId edge = edges[k];
            const bool met = edge == no_edge ||
                             std::find(edges.begin(), edges.begin() + k, edge) != edges.begin() + k;
            if (!met && topology.triangles(edge).front() == id &&
                !offer(closed_distance(search, edge, p), FeatureKind::edge, index(edge))) {
                return Flow::stop;
            }
        }
        return Flow::proceed;
    });
    std::ranges::sort(found.written(), {}, &NearestFeature::feature);
    return found.result();
}

} // namespace proxima
