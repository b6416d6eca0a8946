// Where rounding matters: certain answers of the four overlap tests are those for the exact boxes
// of cells in awkward places, however their centres and half sizes were rounded.
#include "geometry/triangle_box.h"
#include "proxima/octree.h"
#include "thesis/octree_generation/all_overlap_tests.h"

#include <gtest/gtest.h>

#include <cmath>
#include <iostream>
#include <random>
#include <string>
#include <type_traits>
#include <vector>

namespace proxima::overlap_certainty_test {
namespace {

/// How a builder might come by a cell's centre and by the half size of a depth.
enum class Rounding : std::uint8_t { middle_of_box, plane_of_next_depth, half_of_first_cell };

class Scene {
public:
    explicit Scene(unsigned seed) : random_(seed)
    {
        const double scales[] = {1, 1, 1e-30, 1e30, 1e6, 1};
        const double scale = scales[seed % 6];
        const double offset = seed % 5 == 0 ? 1e6 * scale : scale;
        for (int k = 0; k < 3; ++k) {
            frame_.edge[k] = scale * uniform(0.5, 2);
            frame_.lower[k] = seed % 3 == 0 ? -0.5 * frame_.edge[k] : offset * uniform(-1, 1);
        }
        if (seed % 2 == 0) frame_.edge.setConstant(frame_.edge.x());
    }

    [[nodiscard]] const OctreeFrame& frame() const { return frame_; }

    /// Triangles of all sizes; many touch cells of some depth, or miss them by a few roundings.
    [[nodiscard]] Triangle triangle()
    {
        const int kind = below(6);
        const double size = std::ldexp(1.0, -below(10));
        const Vec3 base = point();
        Triangle triangle;
        for (Vec3& vertex : triangle.vertices) {
            vertex = kind < 2 ? base + size * (point() - base) : grid_point(2 + below(5));
            if (kind == 3) nudge(vertex);
        }
        auto& v = triangle.vertices;
        if (kind == 4) v[2] = 0.5 * (v[0] + v[1]); // a sliver
        if (kind == 5) {                           // an edge through a corner of cells
            const Vec3 corner = grid_point(3);
            const Vec3 direction = 0.25 * (point() - point());
            v[0] = corner + direction;
            v[1] = corner - direction;
        }
        if (below(10) == 0) v[1] = v[0];
        if (below(30) == 0) v[2] = v[1] = v[0];
        for (Vec3& vertex : v) {
            vertex = vertex.cwiseMax(frame_.lower).cwiseMin(frame_.lower + frame_.edge);
        }
        return triangle;
    }

    [[nodiscard]] int below(int count)
    {
        return std::uniform_int_distribution<int>(0, count - 1)(random_);
    }

private:
    [[nodiscard]] double uniform(double low, double high)
    {
        return std::uniform_real_distribution<double>(low, high)(random_);
    }
    [[nodiscard]] Vec3 point()
    {
        return frame_.lower +
               frame_.edge.cwiseProduct(Vec3(uniform(0, 1), uniform(0, 1), uniform(0, 1)));
    }
    [[nodiscard]] Vec3 grid_point(int depth)
    {
        Vec3 corner;
        for (int k = 0; k < 3; ++k) {
            corner[k] = frame_.plane(k, static_cast<std::uint32_t>(below((1 << depth) + 1)), depth);
        }
        return corner;
    }
    void nudge(Vec3& vertex)
    {
        for (int k = 0; k < 3; ++k) {
            for (int steps = below(4); steps > 0; --steps) {
                vertex[k] = std::nextafter(vertex[k], below(2) == 0 ? -1e300 : 1e300);
            }
        }
    }

    std::mt19937 random_;
    OctreeFrame frame_;
};

struct Tally {
    std::int64_t cells = 0;
    std::int64_t uncertain = 0;
    std::int64_t differing = 0;
};

template <class Method>
class OverlapCertainty : public ::testing::Test {
protected:
    /// Follows the triangle from the root as a builder does and compares all certain answers.
    void descend(const Scene& scene, const Triangle& triangle, Rounding rounding, int max_depth,
                 std::size_t max_cells)
    {
        const OctreeFrame& frame = scene.frame();
        Method test(triangle);
        std::vector<CellKey> cells = {CellKey{}};
        for (int level = 0; level <= max_depth && !cells.empty(); ++level) {
            const Vec3 half = half_size(frame, level, rounding);
            test.set_half_size(half);
            std::vector<CellKey> touched;
            for (const CellKey cell : cells) {
                const Box box = cell_box(frame, cell);
                const Overlap answer = test.overlap(centre(frame, cell, rounding));
                const bool expected = triangle_overlaps_box(triangle, box);
                ++tally.cells;
                tally.uncertain += answer.certain ? 0 : 1;
                tally.differing += answer.overlaps != expected ? 1 : 0;
                if (answer.certain) {
                    ASSERT_EQ(answer.overlaps, expected)
                        << "level " << level << " cell " << cell.bits;
                }
                if (expected && touched.size() < max_cells) touched.push_back(cell);
            }
            cells.clear();
            for (const CellKey cell : touched) {
                for (int i = 0; i < 8; ++i) cells.push_back(child(cell, i));
            }
        }
    }

    Tally tally;

private:
    [[nodiscard]] static Vec3 centre(const OctreeFrame& frame, CellKey cell, Rounding rounding)
    {
        if (rounding != Rounding::plane_of_next_depth) return cell_box(frame, cell).center();
        const auto at = cell_coordinates(cell);
        Vec3 result;
        for (int k = 0; k < 3; ++k) {
            result[k] = frame.plane(k, 2 * at[static_cast<std::size_t>(k)] + 1, depth(cell) + 1);
        }
        return result;
    }

    [[nodiscard]] static Vec3 half_size(const OctreeFrame& frame, int level, Rounding rounding)
    {
        if (rounding == Rounding::half_of_first_cell) {
            return 0.5 * cell_box(frame, cell_key({0, 0, 0}, level)).extent();
        }
        return std::ldexp(0.5, -level) * frame.edge;
    }
};

TYPED_TEST_SUITE(OverlapCertainty, testing::AllOverlapTests, testing::OverlapTestNames);

TYPED_TEST(OverlapCertainty, CertainAnswersAreExactInDegeneratePositions)
{
    for (unsigned seed = 0; seed < 60; ++seed) {
        Scene scene(seed);
        for (int i = 0; i < 20; ++i) {
            const Triangle triangle = scene.triangle();
            for (const Rounding rounding : {Rounding::middle_of_box, Rounding::plane_of_next_depth,
                                            Rounding::half_of_first_cell}) {
                this->descend(scene, triangle, rounding, 8, 6);
                if (this->HasFatalFailure()) {
                    FAIL() << "seed " << seed << " triangle " << i << " rounding "
                           << static_cast<int>(rounding);
                }
            }
        }
    }
    std::cout << this->tally.cells << " cells, " << this->tally.uncertain << " uncertain, "
              << this->tally.differing << " of them differing from the exact answer\n";
    EXPECT_GT(this->tally.uncertain, 0);
}

/// In general position nearly every answer is certain.
TYPED_TEST(OverlapCertainty, RandomTrianglesAreNearlyAlwaysCertain)
{
    Scene scene(1);
    std::mt19937 random(3);
    std::uniform_real_distribution<double> part(0, 1);
    for (int i = 0; i < 300; ++i) {
        Triangle triangle;
        for (Vec3& vertex : triangle.vertices) {
            vertex = scene.frame().lower + scene.frame().edge.cwiseProduct(
                                               Vec3{part(random), part(random), part(random)});
        }
        this->descend(scene, triangle, Rounding::middle_of_box, 6, 40);
    }
    std::cout << this->tally.cells << " cells, " << this->tally.uncertain << " uncertain\n";
    EXPECT_EQ(this->tally.uncertain, 0);
    EXPECT_EQ(this->tally.differing, 0);
}

} // namespace
} // namespace proxima::overlap_certainty_test
