#include "mesh/surface_pieces.h"

#include "base/disjoint_sets.h"
#include "base/progress.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

namespace proxima::detail {

namespace {

class PieceFinder {
public:
    PieceFinder(const TriangleMesh& mesh, const Topology& topology, std::span<const EdgeUse> uses,
                std::span<const std::uint8_t> takes_part)
        : mesh_(mesh), topology_(topology), uses_(uses), takes_part_(takes_part)
    {
        surface_.piece_of.assign(mesh.triangle_count(), no_piece);
        surface_.turned.assign(mesh.triangle_count(), 0);
    }

    /// False where the work shall stop.
    [[nodiscard]] bool find(bool orient, StageSteps& steps)
    {
        for (std::uint32_t id = 0; id < mesh_.triangle_count(); ++id) {
            if (takes_part_[id] == 0 || !is_proper(mesh_.triangles()[id])) continue;
            if (surface_.piece_of[id] != no_piece) continue;
            if (!spread_from(id, orient, steps)) return false;
        }
        return true;
    }

    /// Turns over all of the pieces of which most are turned.
    void keep_most_as_they_are()
    {
        for (std::size_t id = 0; id < surface_.turned.size(); ++id) {
            if (surface_.piece_of[id] == no_piece) continue;
            const SurfacePiece& piece = surface_.pieces[surface_.piece_of[id]];
            if (most_are_turned(piece)) surface_.turned[id] ^= 1U;
        }
        for (SurfacePiece& piece : surface_.pieces) {
            if (most_are_turned(piece)) piece.turned = piece.triangles - piece.turned;
        }
    }

    void examine_edges()
    {
        for (std::uint32_t id = 0; id < topology_.edge_count(); ++id) {
            const std::uint32_t total = uses_[id].total();
            if (total != 0) examine_edge(EdgeId{id}, total);
        }
    }

    [[nodiscard]] SurfacePieces result() noexcept { return std::move(surface_); }

private:
    /// A neighbour across an edge of exactly two, and whether both run along it the same way.
    struct Neighbour {
        std::uint32_t triangle = no_piece;
        bool runs_same_way = false;
    };

    [[nodiscard]] static bool most_are_turned(const SurfacePiece& piece) noexcept
    {
        return piece.turned > piece.triangles - piece.turned;
    }

    /// Whether the triangle, as it is in the mesh, runs from the edge's lower vertex to the higher.
    [[nodiscard]] bool runs_forward(std::uint32_t triangle, EdgeId edge) const noexcept
    {
        const TriangleCorners& corners = mesh_.triangles()[triangle];
        const auto& edges = topology_.edges(TriangleId{triangle});
        const std::size_t side = edges[0] == edge ? 0 : edges[1] == edge ? 1 : 2;
        return corners[side] < corners[(side + 1) % 3];
    }

    /// The same, after it was turned.
    [[nodiscard]] bool runs_forward_turned(std::uint32_t triangle, EdgeId edge) const noexcept
    {
        return runs_forward(triangle, edge) != (surface_.turned[triangle] != 0);
    }

    [[nodiscard]] Neighbour across(std::uint32_t triangle, EdgeId edge) const noexcept
    {
        const EdgeUse& use = uses_[to_index(edge)];
        if (use.total() != 2) return {};
        for (const TriangleId other : topology_.triangles(edge)) {
            if (to_index(other) == triangle || !is_proper(mesh_.triangles()[to_index(other)]))
                continue;
            return {to_index(other), use.is_inconsistent()};
        }
        return {};
    }

    /// By id, so that turning triangles over, which renames their sides, changes no order.
    [[nodiscard]] std::array<Neighbour, 3> neighbours(std::uint32_t triangle) const noexcept
    {
        std::array<Neighbour, 3> all;
        const auto& edges = topology_.edges(TriangleId{triangle});
        for (std::size_t k = 0; k < 3; ++k) all[k] = across(triangle, edges[k]);
        std::ranges::sort(all, {}, &Neighbour::triangle);
        return all;
    }

    [[nodiscard]] bool spread_from(std::uint32_t first, bool orient, StageSteps& steps)
    {
        const auto number = static_cast<std::uint32_t>(surface_.pieces.size());
        SurfacePiece piece{.first_triangle = first};
        queue_.assign(1, first);
        surface_.piece_of[first] = number;
        for (std::size_t i = 0; i < queue_.size(); ++i) {
            const std::uint32_t triangle = queue_[i];
            piece.turned += surface_.turned[triangle];
            for (const Neighbour& next : neighbours(triangle)) {
                if (next.triangle == no_piece || surface_.piece_of[next.triangle] != no_piece)
                    continue;
                surface_.piece_of[next.triangle] = number;
                if (orient && next.runs_same_way) {
                    surface_.turned[next.triangle] = surface_.turned[triangle] ^ 1U;
                } else {
                    surface_.turned[next.triangle] = surface_.turned[triangle];
                }
                queue_.push_back(next.triangle);
            }
            if (!steps.done(1)) return false;
        }
        piece.triangles = static_cast<std::uint32_t>(queue_.size());
        surface_.pieces.push_back(piece);
        return true;
    }

    void examine_edge(EdgeId edge, std::uint32_t total)
    {
        // How often each piece runs forward, less backward.
        ways_.clear();
        for (const TriangleId triangle : topology_.triangles(edge)) {
            const std::uint32_t piece = surface_.piece_of[to_index(triangle)];
            if (piece != no_piece)
                ways_.emplace_back(piece, runs_forward_turned(to_index(triangle), edge) ? 1 : -1);
        }
        std::ranges::sort(ways_);
        for (std::size_t i = 0; i < ways_.size();) {
            SurfacePiece& piece = surface_.pieces[ways_[i].first];
            std::int64_t balance = 0;
            const std::uint32_t number = ways_[i].first;
            for (; i < ways_.size() && ways_[i].first == number; ++i) balance += ways_[i].second;
            if (balance == 0) continue;
            piece.closed = false;
            if (total == 2) ++piece.unmatched_edges;
        }
    }

    const TriangleMesh& mesh_;
    const Topology& topology_;
    std::span<const EdgeUse> uses_;
    std::span<const std::uint8_t> takes_part_;
    SurfacePieces surface_;
    std::vector<std::uint32_t> queue_;
    std::vector<std::pair<std::uint32_t, int>> ways_; ///< of one edge: piece, and 1 or -1
};

} // namespace

std::optional<SurfacePieces> find_surface_pieces(const TriangleMesh& mesh, const Topology& topology,
                                                 std::span<const EdgeUse> uses,
                                                 std::span<const std::uint8_t> takes_part,
                                                 bool orient, Progress* progress)
{
    StageSteps steps(progress, "orienting triangles", mesh.triangle_count());
    PieceFinder finder(mesh, topology, uses, takes_part);
    if (!finder.find(orient, steps)) return std::nullopt;
    finder.keep_most_as_they_are();
    finder.examine_edges();
    return finder.result();
}

std::vector<int> volume_signs_of(const TriangleMesh& mesh, const SurfacePieces& surface)
{
    // Turning a triangle over negates its term exactly: the sign of a piece turned over as a whole
    // is that of the piece negated, whatever was rounded.
    static_assert(no_piece == no_surface_sum);
    std::vector<VolumeSum> sums = scaled_sums(mesh, surface.piece_of, surface.pieces.size());
    std::vector<bool> finite(surface.pieces.size(), true);
    for (std::uint32_t id = 0; id < mesh.triangle_count(); ++id) {
        const std::uint32_t number = surface.piece_of[id];
        if (number == no_piece || !surface.pieces[number].closed) continue;
        const Triangle triangle = mesh.triangle(TriangleId{id});
        if (!is_finite(triangle)) {
            finite[number] = false;
            continue;
        }
        const TriangleId first{surface.pieces[number].first_triangle};
        sums[number].add(triangle, mesh.triangle(first)[0], surface.turned[id] != 0);
    }
    std::vector<int> signs;
    for (std::size_t number = 0; number < sums.size(); ++number) {
        signs.push_back(finite[number] ? sums[number].sign() : 0);
    }
    return signs;
}

ClosedSurfaces closed_surfaces_of(const TriangleMesh& mesh, const Topology& topology,
                                  const SurfacePieces& pieces, std::span<const int> volume_signs)
{
    ClosedSurfaces closed;
    closed.count = static_cast<std::uint32_t>(pieces.pieces.size());
    closed.surface_of.assign(mesh.triangle_count(), no_piece);
    const auto is_left = [&](std::uint32_t id) {
        const std::uint32_t piece = pieces.piece_of[id];
        return piece != no_piece && !pieces.pieces[piece].closed;
    };
    DisjointSets sets(mesh.triangle_count());
    std::vector<std::uint8_t> is_open(mesh.triangle_count(), 0);
    for (std::uint32_t edge = 0; edge < topology.edge_count(); ++edge) {
        std::uint32_t last = no_piece;
        std::uint32_t count = 0;
        for (const TriangleId triangle : topology.triangles(EdgeId{edge})) {
            if (!is_left(to_index(triangle))) continue;
            if (count++ > 0) sets.unite(last, to_index(triangle));
            last = to_index(triangle);
        }
        if (count % 2 != 0) is_open[last] = 1;
    }
    for (std::uint32_t id = 0; id < mesh.triangle_count(); ++id) {
        if (is_left(id) && (is_open[id] != 0 || !is_finite(mesh.triangle(TriangleId{id}))))
            is_open[sets.find(id)] = 1;
    }
    for (std::uint32_t id = 0; id < mesh.triangle_count(); ++id) {
        const std::uint32_t piece = pieces.piece_of[id];
        if (is_left(id)) {
            const std::uint32_t first = sets.find(id); // at most id
            if (is_open[first] != 0) continue;
            closed.surface_of[id] = first == id ? closed.count++ : closed.surface_of[first];
        } else if (piece != no_piece && volume_signs[piece] != 0) {
            closed.surface_of[id] = piece;
        }
    }
    return closed;
}

} // namespace proxima::detail
