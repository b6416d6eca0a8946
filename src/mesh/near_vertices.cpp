#include "mesh/near_vertices.h"

#include "base/progress.h"
#include "geometry/length.h"
#include "mesh/equal_items.h"

#include <array>
#include <bit>
#include <cmath>
#include <limits>
#include <numeric>

namespace proxima {

namespace {

constexpr std::uint32_t no_vertex = std::numeric_limits<std::uint32_t>::max();

/// Intervals along an axis, as doubles: none of them overflows, however small the distance.
class AxisCells {
public:
    explicit AxisCells(double distance) noexcept : distance_(distance), edge_(2 * distance) {}

    [[nodiscard]] double cell(double x) const noexcept
    {
        return (is_alone(x) ? x : std::floor(x / edge_)) + 0.0; // -0 becomes 0
    }

    /// The cells of all doubles within the distance of x. Rounding is monotone, so that they lie
    /// between those of x - distance and x + distance: two, three where the sums were rounded.
    struct Range {
        std::array<double, 3> cells{};
        std::size_t count = 0;
    };
    [[nodiscard]] Range cells_near(double x) const noexcept
    {
        Range range;
        if (is_alone(x)) {
            range.cells[range.count++] = cell(x);
            return range;
        }
        const double last = std::floor((x + distance_) / edge_);
        double next = std::floor((x - distance_) / edge_);
        while (next <= last && range.count < range.cells.size()) {
            range.cells[range.count++] = next + 0.0;
            next =
                std::max(next + 1, std::nextafter(next, std::numeric_limits<double>::infinity()));
        }
        return range;
    }

private:
    /// Whether no other double is within the distance of x.
    [[nodiscard]] bool is_alone(double x) const noexcept
    {
        return x - distance_ == x && x + distance_ == x;
    }

    double distance_;
    double edge_;
};

/// The vertices kept so far, by the hashes of their cells. What shares a hash is only looked at in
/// vain.
class KeptVertices {
public:
    KeptVertices(std::span<const Vec3> positions, double distance)
        : positions_(positions), distance_(distance), cells_(distance),
          heads_(std::bit_ceil(positions.size() + 1), no_vertex), next_(positions.size(), no_vertex)
    {}

    /// The nearest within the distance, the lowest of several; no_vertex where there is none.
    [[nodiscard]] std::uint32_t nearest(const Vec3& position) const noexcept
    {
        const auto x = cells_.cells_near(position.x());
        const auto y = cells_.cells_near(position.y());
        const auto z = cells_.cells_near(position.z());
        Nearest found{no_vertex, distance_};
        for (std::size_t i = 0; i < x.count; ++i) {
            for (std::size_t j = 0; j < y.count; ++j) {
                for (std::size_t k = 0; k < z.count; ++k)
                    look_at(slot(x.cells[i], y.cells[j], z.cells[k]), position, found);
            }
        }
        return found.vertex;
    }

    void keep(std::uint32_t vertex) noexcept
    {
        const Vec3& position = positions_[vertex];
        std::uint32_t& head = heads_[slot(cells_.cell(position.x()), cells_.cell(position.y()),
                                          cells_.cell(position.z()))];
        next_[vertex] = head;
        head = vertex;
    }

private:
    struct Nearest {
        std::uint32_t vertex;
        double distance;
    };

    [[nodiscard]] std::size_t slot(double x, double y, double z) const noexcept
    {
        std::uint64_t hash = 0;
        for (const double cell : {x, y, z})
            hash = mix_bits(hash, std::bit_cast<std::uint64_t>(cell));
        return hash & (heads_.size() - 1);
    }

    void look_at(std::size_t slot, const Vec3& position, Nearest& found) const noexcept
    {
        for (std::uint32_t vertex = heads_[slot]; vertex != no_vertex; vertex = next_[vertex]) {
            const double apart = length_of(positions_[vertex] - position);
            if (apart < found.distance || (apart == found.distance && vertex < found.vertex))
                found = {vertex, apart};
        }
    }

    std::span<const Vec3> positions_;
    double distance_;
    AxisCells cells_;
    std::vector<std::uint32_t> heads_; ///< by slot: the vertex kept last
    std::vector<std::uint32_t> next_;  ///< by vertex: the one kept before it in its slot
};

} // namespace

std::uint64_t near_vertices_bytes(std::uint64_t vertex_count) noexcept
{
    return (std::bit_ceil(vertex_count + 1) + 2 * vertex_count) * sizeof(std::uint32_t);
}

std::optional<std::vector<std::uint32_t>> near_vertices(std::span<const Vec3> positions,
                                                        std::span<const std::uint8_t> takes_part,
                                                        double distance, Progress* progress)
{
    StageSteps steps(progress, "joining near vertices", positions.size());
    std::vector<std::uint32_t> becomes(positions.size());
    std::iota(becomes.begin(), becomes.end(), 0U);
    KeptVertices kept(positions, distance);
    for (std::uint32_t vertex = 0; vertex < positions.size(); ++vertex) {
        if (!steps.done(1)) return std::nullopt;
        if (takes_part[vertex] == 0) continue;
        const std::uint32_t nearest = kept.nearest(positions[vertex]);
        if (nearest == no_vertex) {
            kept.keep(vertex);
        } else {
            becomes[vertex] = nearest;
        }
    }
    return becomes;
}

} // namespace proxima
