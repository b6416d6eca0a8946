// Cones of features, held against a search over all features of the mesh.
#include "geometry/exact_predicates.h"
#include "proxima/sample_meshes.h"
#include "query/closest/brute_force.h"
#include "viewer/panels/local_cone.h"

#include <Eigen/LU>
#include <array>
#include <cmath>
#include <gtest/gtest.h>
#include <numbers>
#include <random>

namespace proxima::local_cone_test {
namespace {

struct Shape {
    const char* name;
    TriangleMesh mesh;
    Topology topology;
};

Shape shape(const char* name, TriangleMesh mesh)
{
    Topology topology = build_topology(mesh).value();
    return {name, std::move(mesh), std::move(topology)};
}

Shape shape(const char* name, std::vector<Vec3> positions, std::vector<TriangleCorners> triangles)
{
    return shape(name, make_triangle_mesh(std::move(positions), std::move(triangles)).value());
}

/// A torus without every sixth triangle.
Shape torn_torus()
{
    const TriangleMesh whole = make_torus(10, 8);
    std::vector<TriangleCorners> triangles;
    for (std::size_t i = 0; i < whole.triangles().size(); ++i)
        if (i % 6 != 5) triangles.push_back(whole.triangles()[i]);
    const auto positions = whole.positions();
    return shape("torn torus", {positions.begin(), positions.end()}, std::move(triangles));
}

/// A flat square of four, and a square of two that bends up at its diagonal.
Shape flat_square()
{
    return shape("flat square", {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}, {0.5, 0.5, 0}},
                 {{0, 1, 4}, {1, 2, 4}, {2, 3, 4}, {3, 0, 4}});
}

/// Three pages at one spine.
Shape book()
{
    return shape("book", {{0, 0, 0}, {0, 0, 1}, {1, 0.2, 0.5}, {-1, 0.3, 0.4}, {0.1, 1, 0.5}},
                 {{0, 1, 2}, {0, 1, 3}, {0, 1, 4}});
}

/// An L from above, pushed up: one of its edges and no vertex is bent inward alone.
Shape bracket()
{
    std::vector<Vec3> positions;
    constexpr std::array<std::array<double, 2>, 6> outline = {
        {{0, 0}, {2, 0}, {2, 1}, {1, 1}, {1, 2}, {0, 2}}};
    for (const double z : {0.0, 1.0})
        for (const auto& at : outline) positions.emplace_back(at[0], at[1], z);
    std::vector<TriangleCorners> triangles;
    for (std::uint32_t i = 0; i < 6; ++i) {
        const std::uint32_t next = (i + 1) % 6;
        triangles.push_back({i, next, next + 6});
        triangles.push_back({i, next + 6, i + 6});
    }
    for (const TriangleCorners& t :
         std::initializer_list<TriangleCorners>{{0, 1, 2}, {0, 2, 3}, {0, 3, 4}, {0, 4, 5}}) {
        triangles.push_back({t[0], t[2], t[1]});
        triangles.push_back({t[0] + 6, t[1] + 6, t[2] + 6});
    }
    return shape("bracket", std::move(positions), std::move(triangles));
}

std::vector<Shape> all_shapes()
{
    std::vector<Shape> shapes;
    shapes.push_back(shape("icosphere", make_icosphere(1)));
    shapes.push_back(shape("torus", make_torus(10, 8)));
    shapes.push_back(shape("spaceship", sample_mesh("spaceship:1300").value()));
    shapes.push_back(torn_torus());
    shapes.push_back(flat_square());
    shapes.push_back(book());
    shapes.push_back(bracket());
    return shapes;
}

/// Whether the direction is a sum of these, none of them taken away but for rounding.
bool is_sum(const Vec3& direction, const std::array<Vec3, 3>& parts, int free = 3)
{
    Eigen::Matrix3d matrix;
    for (int k = 0; k < 3; ++k) matrix.col(k) = parts[static_cast<std::size_t>(k)];
    if (std::abs(matrix.determinant()) < 1e-12) return false;
    const Vec3 weights = matrix.inverse() * direction;
    for (int k = 0; k < 3; ++k)
        if (k < free ? weights[k] < -1e-6 : std::abs(weights[k]) > 1e-6) return false;
    return true;
}

bool holds(const Shape& of, const LocalCone& cone, const Feature& feature, const Vec3& direction)
{
    const auto& corners = cone.corners;
    if (feature.kind == FeatureKind::edge) {
        const auto [p, q] = of.topology.vertices(EdgeId{feature.id});
        const Vec3 along = of.mesh.position(q) - of.mesh.position(p);
        for (std::size_t i = 0; i + 1 < corners.size() / 2; ++i) {
            if (is_sum(direction, {corners[i].direction, corners[i + 1].direction, along}, 2))
                return true;
        }
        return false;
    }
    Vec3 middle = Vec3::Zero();
    for (const ConeCorner& corner : corners) middle += corner.direction;
    for (std::size_t i = 0; i < corners.size(); ++i) {
        const Vec3& next = corners[(i + 1) % corners.size()].direction;
        if (is_sum(direction, {middle, corners[i].direction, next})) return true;
    }
    return false;
}

std::size_t count_of(const Shape& of, FeatureKind kind)
{
    return kind == FeatureKind::vertex ? of.mesh.vertex_count()
           : kind == FeatureKind::edge ? of.topology.edge_count()
                                       : of.mesh.triangle_count();
}

TEST(LocalCone, ContainsEveryPointWhoseClosestFeatureItIs)
{
    constexpr unsigned seed = 20;
    std::mt19937 random(seed);
    std::uniform_real_distribution<double> any(-1.0, 1.0);
    std::array<int, 2> seen = {}; // outside, behind
    for (const Shape& of : all_shapes()) {
        for (int i = 0; i < 4000; ++i) {
            // Near a vertex, where vertices and edges have their share.
            const std::size_t near = static_cast<std::size_t>(random()) % of.mesh.vertex_count();
            const auto spread = 0.2 * std::abs(any(random));
            const Vec3 p =
                of.mesh.positions()[near] + spread * Vec3(any(random), any(random), any(random));
            const ClosestFeature closest = closest_feature_by_brute_force(of.mesh, of.topology, p);
            if (closest.feature.kind == FeatureKind::face) continue;
            const auto cone = local_cone(of.mesh, of.topology, closest.feature);
            ASSERT_TRUE(cone) << describe(cone.error());
            if (cone->shape == ConeShape::flat) continue; // by rounding
            ASSERT_EQ(cone->shape, ConeShape::solid)
                << of.name << " seed " << seed << " point " << i;
            const Vec3 direction = (p - closest.point).normalized();
            EXPECT_TRUE(holds(of, *cone, closest.feature, direction))
                << of.name << " seed " << seed << " point " << i << " feature "
                << closest.feature.id;
            ++seen[cone->side == ConeSide::behind ? 1 : 0];
        }
    }
    EXPECT_GT(seen[0], 3000);
    EXPECT_GT(seen[1], 100);
}

TEST(LocalCone, ContainsNoOtherPoints)
{
    constexpr unsigned seed = 21;
    std::mt19937 random(seed);
    std::uniform_real_distribution<double> part(0.0, 1.0);
    std::array<int, 4> seen = {}; // of each kind of cone
    for (const Shape& of : all_shapes()) {
        for (const FeatureKind kind : {FeatureKind::vertex, FeatureKind::edge, FeatureKind::face}) {
            for (std::uint32_t id = 0; id < count_of(of, kind); id += 1 + id / 60) {
                const auto cone = local_cone(of.mesh, of.topology, {kind, id});
                ASSERT_TRUE(cone) << describe(cone.error());
                ++seen[static_cast<std::size_t>(cone->shape)];
                if (cone->shape == ConeShape::empty) continue;
                const auto& corners = cone->corners;
                const std::size_t i = static_cast<std::size_t>(random()) % corners.size();
                const ConeCorner& one = corners[i];
                const ConeCorner& next = corners[std::min(i + 1, corners.size() - 1)];
                const double weight = part(random);
                EXPECT_NEAR(one.direction.norm(), 1.0, 1e-12);
                // Within the feature: at its ends others may be nearer.
                Vec3 base = Vec3::Zero();
                for (const ConeCorner& corner : corners)
                    base += corner.base / static_cast<double>(corners.size());
                const Vec3 direction =
                    (weight * one.direction + (1.0 - weight) * next.direction).normalized();
                constexpr double away = 1e-4; // less than any other part is
                const double distance = std::sqrt(
                    closest_feature_by_brute_force(of.mesh, of.topology, base + away * direction)
                        .squared_distance);
                EXPECT_NEAR(distance, away, 1e-11) << of.name << " seed " << seed << " kind "
                                                   << static_cast<int>(kind) << " id " << id;
            }
        }
    }
    for (const int count : seen) EXPECT_GT(count, 0);
}

TEST(LocalCone, DistinguishesConvexFromConcaveFeatures)
{
    const Shape of = bracket();
    // The edge that stands in the L's corner, from (1, 1, 0) to (1, 1, 1).
    const EdgeId inner = of.topology.find_edge(VertexId{3}, VertexId{9});
    const auto edge = local_cone(of.mesh, of.topology, {FeatureKind::edge, to_index(inner)});
    ASSERT_TRUE(edge);
    EXPECT_EQ(edge->shape, ConeShape::solid);
    EXPECT_EQ(edge->side, ConeSide::behind);
    for (const ConeCorner& corner : edge->corners) {
        EXPECT_LE(corner.direction.x(), 1e-12);
        EXPECT_LE(corner.direction.y(), 1e-12);
    }
    // Straight up and down there is but the L at its ends; all other corners are bent outward.
    for (std::uint32_t v = 0; v < of.mesh.vertex_count(); ++v) {
        const auto vertex = local_cone(of.mesh, of.topology, {FeatureKind::vertex, v});
        ASSERT_TRUE(vertex);
        EXPECT_EQ(vertex->shape, v % 6 == 3 ? ConeShape::line : ConeShape::solid) << v;
        EXPECT_EQ(vertex->side, ConeSide::outside);
    }
    const Shape square = flat_square();
    const auto line = local_cone(square.mesh, square.topology, {FeatureKind::vertex, 4});
    ASSERT_TRUE(line);
    EXPECT_EQ(line->shape, ConeShape::line);
    EXPECT_EQ(line->corners[0].direction, Vec3::UnitZ());
}

TEST(LocalCone, OfVerticesWithThousandsOfTrianglesComparesEachPairOfEdgesAFewTimes)
{
    // Triangles round a point: of a disc, of a cone, and of a disc's border, as caps of cylinders
    // have them, with a wall below.
    constexpr std::uint32_t count = 2000;
    constexpr std::uint64_t pairs = std::uint64_t{count} * (count - 1) / 2;
    std::vector<Vec3> circle;
    for (std::uint32_t i = 0; i < count; ++i) {
        const double angle = 2.0 * std::numbers::pi * i / count;
        circle.emplace_back(std::cos(angle), std::sin(angle), 0.0);
    }
    const auto fan_from = [&](const Vec3& middle) {
        std::vector<Vec3> positions = circle;
        positions.push_back(middle);
        std::vector<TriangleCorners> triangles;
        for (std::uint32_t i = 0; i < count; ++i) triangles.push_back({i, (i + 1) % count, count});
        return shape("fan", std::move(positions), std::move(triangles));
    };
    std::vector<Vec3> positions = circle;
    positions.emplace_back(1.0, 0.0, -1.0);
    std::vector<TriangleCorners> triangles;
    for (std::uint32_t i = 1; i + 1 < count; ++i) triangles.push_back({0, i, i + 1});
    triangles.push_back({1, 0, count});
    triangles.push_back({0, count - 1, count});
    const Shape disc = fan_from({0, 0, 0});
    const Shape spike = fan_from({0, 0, 1});
    const Shape cap = shape("cap", std::move(positions), std::move(triangles));
    struct Case {
        const Shape& of;
        std::uint32_t vertex;
        ConeShape shape;
        std::size_t corners;
    };
    for (const Case& tried :
         {Case{disc, count, ConeShape::line, 1}, Case{spike, count, ConeShape::solid, count},
          Case{cap, 0, ConeShape::solid, 3}}) {
        const auto cone =
            local_cone(tried.of.mesh, tried.of.topology, {FeatureKind::vertex, tried.vertex});
        ASSERT_TRUE(cone) << describe(cone.error());
        EXPECT_EQ(cone->shape, tried.shape) << tried.of.name;
        EXPECT_EQ(cone->corners.size(), tried.corners) << tried.of.name;
        EXPECT_LT(cone->comparisons, 40 * pairs) << tried.of.name;
    }
}

TEST(LocalCone, RefusesFeaturesWithoutACone)
{
    const Shape of =
        shape("flawed", {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {2, 0, 0}, {5, 5, 5}, {0, 0, 0}},
              {{0, 1, 2}, {0, 1, 3}, {0, 5, 2}});
    const auto code = [&](FeatureKind kind, std::uint32_t id) {
        const auto cone = local_cone(of.mesh, of.topology, {kind, id});
        return cone ? ErrorCode{} : cone.error().code;
    };
    EXPECT_EQ(code(FeatureKind::face, 1), ErrorCode::invalid_mesh);
    EXPECT_EQ(code(FeatureKind::vertex, 4), ErrorCode::invalid_argument);
    const EdgeId none = of.topology.find_edge(VertexId{0}, VertexId{5});
    EXPECT_EQ(code(FeatureKind::edge, to_index(none)), ErrorCode::invalid_mesh);
    const EdgeId line = of.topology.find_edge(VertexId{1}, VertexId{3});
    EXPECT_EQ(code(FeatureKind::edge, to_index(line)), ErrorCode::invalid_mesh);
    for (const FeatureKind kind : {FeatureKind::vertex, FeatureKind::edge, FeatureKind::face})
        EXPECT_EQ(code(kind, 100), ErrorCode::invalid_argument);
}

} // namespace
} // namespace proxima::local_cone_test
