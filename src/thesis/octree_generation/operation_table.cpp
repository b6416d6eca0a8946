#include "thesis/octree_generation/operation_table.h"

#include "base/check.h"
#include "minkowski/operation_counts.h"
#include "minkowski/scalar_vector.h"
#include "thesis/minkowski_sums/geometric_method.h"
#include "thesis/minkowski_sums/incremental_hull.h"
#include "thesis/octree_generation/overlap_index_tracking.h"
#include "thesis/octree_generation/overlap_minkowski.h"
#include "thesis/octree_generation/overlap_pairwise.h"
#include "thesis/octree_generation/overlap_separating_axis.h"
#include "thesis/octree_generation/triangle_cube_descent.h"
#include "thesis/octree_generation/triangle_cube_sum.h"

#include <array>
#include <cmath>
#include <cstddef>
#include <random>
#include <utility>

namespace proxima {
namespace {

/// A triangle near the cube of half size 1 about the origin.
struct Pair {
    Triangle triangle;
    bool general_position = false; ///< random coordinates
};

/// Makes the same pairs on every machine: the standard fixes the engine and not the distributions.
class PairSource {
public:
    [[nodiscard]] Pair next()
    {
        Pair pair;
        pair.general_position = number_ % 2 == 0;
        const double reach = number_ % 4 < 2 ? 2 : 4;
        ++number_;
        for (Vec3& vertex : pair.triangle.vertices) {
            for (double& coordinate : vertex) {
                const double part = static_cast<double>(random_() >> 11U) * 0x1p-53;
                coordinate = pair.general_position ? reach * (2 * part - 1)
                                                   : std::floor((2 * reach + 1) * part) - reach;
            }
        }
        return pair;
    }

private:
    std::mt19937_64 random_;
    unsigned number_ = 0;
};

/// Keeps the worst counts of a row.
class WorstCase {
public:
    explicit WorstCase(std::string method, std::optional<ThesisOperationCounts> thesis = {})
        : row_{std::move(method), {}, thesis}
    {}

    /// Counts what the action does.
    template <class Action>
    void measure(const Action& action)
    {
        reset_operation_counts();
        action();
        if (operation_counts().flops() > row_.counts.flops()) row_.counts = operation_counts();
    }

    [[nodiscard]] const OperationCountRow& row() const { return row_; }

private:
    OperationCountRow row_;
};

/// The rows of one overlap test: its constants and its answer.
template <class Method>
struct OverlapRows {
    WorstCase triangle;
    WorstCase depth;
    WorstCase cell;

    void measure(const Pair& pair)
    {
        std::optional<Method> test;
        triangle.measure([&] { test.emplace(pair.triangle); });
        test->set_half_size(Vec3::Constant(2));
        depth.measure([&] { test->set_half_size(Vec3::Ones()); });
        cell.measure([&] { last_answer = test->overlap(Vec3::Zero()); });
    }

    Overlap last_answer; ///< keeps the counted call from being dropped
};

/// The rows of the closed form: 17 half-spaces, followed from cell to children by additions.
struct ClosedFormRows {
    WorstCase triangle{"Fast, constants of a triangle"};
    WorstCase depth{"Fast, constants of a depth"};
    WorstCase cell{"Fast, one cell"};
    WorstCase children{"Fast, all eight children of a cell"};
    WorstCase child{"Fast, going down to a child"};

    void measure(const Pair& pair)
    {
        CornerCoordinates<Counted> corners;
        for (std::size_t j = 0; j < 3; ++j) {
            for (std::size_t k = 0; k < 3; ++k) {
                corners[j][k] = pair.triangle.vertices[j][static_cast<int>(k)];
            }
        }
        std::optional<TriangleCubeSum<Counted>> sum;
        triangle.measure([&] { sum.emplace(corners); });
        depth.measure([&] { sum->set_half_size(1); });
        cell.measure([&] { last_answer = sum->contains({0, 0, 0}) ? 1 : 0; });

        // The descent wants its root at the origin: move [-4, 4]^3 there.
        for (auto& corner : corners) {
            for (Counted& coordinate : corner) coordinate += 4;
        }
        using Descent = TriangleCubeDescent<Counted>;
        const Descent descent(corners, 8, 0);
        const Descent::Level& level = descent.root_level();
        const Descent::Cell& root = descent.root_cell();
        children.measure([&] { last_answer = Descent::half_space_octants(level, root); });
        child.measure([&] { static_cast<void>(Descent::child(level, root, 7)); });
    }

    unsigned last_answer = 0; ///< keeps the counted calls from being dropped
};

} // namespace

std::vector<OperationCountRow> count_operations(const OperationCountOptions& options)
{
    PROXIMA_CHECK_GT(options.pairs, 0);
    using ThesisRow = ThesisOperationCounts;
    OverlapRows<BasicSeparatingAxisTest<Counted>> separating_axis{
        WorstCase("Separating axes, constants of a triangle"),
        WorstCase("Separating axes, constants of a depth"),
        WorstCase("Separating-axis-based intersection", ThesisRow{13, {}, 83}),
        {}};
    OverlapRows<BasicMinkowskiTest<Counted>> minkowski{
        WorstCase("Minkowski sum, constants of a triangle"),
        WorstCase("Minkowski sum, constants of a depth"),
        WorstCase("Minkowski-sum-based intersection", ThesisRow{26, {}, 130}),
        {}};
    OverlapRows<BasicIndexTrackingTest<Counted>> index_tracking{
        WorstCase("Index tracking, constants of a triangle"),
        WorstCase("Index tracking, constants of a depth after the first"),
        WorstCase("Index-tracking-based intersection"),
        {}};
    OverlapRows<BasicPairwiseTest<Counted>> pairwise{
        WorstCase("Pairwise, constants of a triangle"),
        WorstCase("Pairwise, constants of a depth"),
        WorstCase("Pairwise intersection", ThesisRow{138, {}, 930}),
        {}};
    OverlapRows<BasicMinkowskiTest<Counted>> general_position{
        minkowski.triangle,
        minkowski.depth,
        WorstCase("Minkowski-sum-based intersection, general position"),
        {}};
    WorstCase geometric_general("Geometric method, general position");
    WorstCase geometric("Geometric method", ThesisRow{312, 27, 1713});
    WorstCase hull("Incremental convex hull method", ThesisRow{440, 60, 3040});

    ClosedFormRows fast;
    PairSource source;
    for (int i = 0; i < options.pairs; ++i) {
        const Pair pair = source.next();
        separating_axis.measure(pair);
        minkowski.measure(pair);
        if (pair.general_position) general_position.measure(pair);
        index_tracking.measure(pair);
        pairwise.measure(pair);
        fast.measure(pair);

        const auto features = triangle_features<Counted>(pair.triangle);
        const Vector3<Counted> half = to_scalar<Counted>(Vec3::Ones());
        const auto find_sum = [&] { static_cast<void>(geometric_sum(features, half)); };
        geometric.measure(find_sum);
        if (pair.general_position) geometric_general.measure(find_sum);

        std::array<Vector3<Counted>, 8> cube;
        for (int k = 0; k < 8; ++k) cube[static_cast<std::size_t>(k)] = cube_vertex(k, half);
        std::array<Vector3<Counted>, 24> sums;
        form_sum_vertices<Counted>(cube, features.vertices, sums);
        hull.measure([&] { static_cast<void>(incremental_hull<Counted>(sums)); });
    }
    std::vector<OperationCountRow> rows;
    for (const WorstCase* worst : {&separating_axis.cell,
                                   &minkowski.cell,
                                   &pairwise.cell,
                                   &geometric,
                                   &hull,
                                   &general_position.cell,
                                   &geometric_general,
                                   &index_tracking.cell,
                                   &index_tracking.depth,
                                   &fast.cell,
                                   &fast.children,
                                   &fast.child,
                                   &fast.depth,
                                   &fast.triangle,
                                   &separating_axis.depth,
                                   &separating_axis.triangle,
                                   &minkowski.depth,
                                   &minkowski.triangle,
                                   &pairwise.depth,
                                   &pairwise.triangle,
                                   &index_tracking.triangle}) {
        rows.push_back(worst->row());
    }
    return rows;
}

} // namespace proxima
