#include "proxima/sample_meshes.h"

#include "code_of.h"
#include "geometry/exact_predicates.h"
#include "mesh/unit_circle.h"
#include "proxima/topology.h"

#include <gtest/gtest.h>
#include <xxhash.h>

#include <algorithm>
#include <cmath>
#include <random>

namespace proxima::sample_meshes_test {
namespace {

// Every edge has two triangles in opposite directions and every triangle an area.
void expect_closed(const TriangleMesh& mesh)
{
    const auto topology = build_topology(mesh);
    ASSERT_TRUE(topology);
    for (std::uint32_t id = 0; id < topology->edge_count(); ++id) {
        const auto [low, high] = topology->vertices(EdgeId{id});
        const auto both = topology->triangles(EdgeId{id});
        ASSERT_EQ(both.size(), 2U);
        int directions = 0;
        for (const TriangleId triangle : both) {
            const TriangleCorners& corners = mesh.triangles()[to_index(triangle)];
            for (std::size_t k = 0; k < 3; ++k) {
                const auto from = corners[k];
                const auto to = corners[(k + 1) % 3];
                if (from == to_index(low) && to == to_index(high)) ++directions;
                if (from == to_index(high) && to == to_index(low)) --directions;
            }
        }
        ASSERT_EQ(directions, 0) << "edge " << id;
    }
    for (std::uint32_t id = 0; id < mesh.triangle_count(); ++id) {
        ASSERT_FALSE(is_degenerate(mesh.triangle(TriangleId{id}))) << "triangle " << id;
    }
    for (std::uint32_t id = 0; id < mesh.vertex_count(); ++id) {
        ASSERT_FALSE(topology->triangles(VertexId{id}).empty()) << "vertex " << id;
    }
}

std::int64_t euler_characteristic(const TriangleMesh& mesh)
{
    const auto topology = build_topology(mesh);
    return static_cast<std::int64_t>(mesh.vertex_count() + mesh.triangle_count()) -
           static_cast<std::int64_t>(topology->edge_count());
}

double volume(const TriangleMesh& mesh)
{
    double sum = 0.0;
    for (std::uint32_t id = 0; id < mesh.triangle_count(); ++id) {
        const Triangle triangle = mesh.triangle(TriangleId{id});
        sum += triangle[0].dot(triangle[1].cross(triangle[2])) / 6.0;
    }
    return sum;
}

TEST(SampleMeshes, SphereHasTheCountsOfTheThesis)
{
    const TriangleMesh big = make_sphere(100, 100);
    EXPECT_EQ(big.triangle_count(), 19800U);
    EXPECT_EQ(big.vertex_count(), 9902U);
    const TriangleMesh small = make_sphere(50, 50);
    EXPECT_EQ(small.triangle_count(), 4900U);
    EXPECT_EQ(small.vertex_count(), 2452U);
    EXPECT_EQ(build_topology(small)->edge_count(), 7350U);
}

TEST(SampleMeshes, SphereIsARoundClosedOutwardSphere)
{
    for (const auto& [stacks, slices] :
         {std::pair(2, 3), {2, 8}, {3, 3}, {7, 11}, {50, 50}, {100, 100}}) {
        SCOPED_TRACE(stacks * 1000 + slices);
        const TriangleMesh mesh = make_sphere(stacks, slices);
        EXPECT_EQ(mesh.triangle_count(), static_cast<std::size_t>(2 * slices * (stacks - 1)));
        expect_closed(mesh);
        EXPECT_EQ(euler_characteristic(mesh), 2);
        for (const Vec3& position : mesh.positions()) EXPECT_NEAR(position.norm(), 1.0, 1e-11);
        for (std::uint32_t id = 0; id < mesh.triangle_count(); ++id) {
            const Triangle triangle = mesh.triangle(TriangleId{id});
            EXPECT_GT(scaled_normal(triangle).dot(triangle[0] + triangle[1] + triangle[2]), 0.0);
        }
    }
}

TEST(SampleMeshes, SphereStartsAtTheTopAndKeepsItsDiagonals)
{
    const int stacks = 5;
    const int slices = 8;
    const TriangleMesh mesh = make_sphere(stacks, slices);
    EXPECT_EQ(mesh.positions().front(), Vec3(0, 0, 1));
    EXPECT_EQ(mesh.positions().back(), Vec3(0, 0, -1));
    const auto vertex = [&](int ring, int slice) {
        return VertexId{static_cast<std::uint32_t>(1 + (ring - 1) * slices + slice % slices)};
    };
    const auto topology = build_topology(mesh);
    for (int i = 1; i + 1 < stacks; ++i) {
        for (int j = 0; j < slices; ++j) {
            EXPECT_NE(topology->find_edge(vertex(i, j), vertex(i + 1, j + 1)), no_edge);
            EXPECT_EQ(topology->find_edge(vertex(i, j + 1), vertex(i + 1, j)), no_edge);
        }
    }
    const Vec3& second_ring = mesh.position(vertex(2, 1));
    const CirclePoint latitude = unit_circle(2, 10);
    const CirclePoint longitude = unit_circle(1, 8);
    EXPECT_EQ(second_ring, Vec3(on_circle_grid(latitude.sine * longitude.cosine),
                                on_circle_grid(latitude.sine * longitude.sine), latitude.cosine));
}

TEST(SampleMeshes, SphereIsExactOnTheAxes)
{
    const TriangleMesh mesh = make_sphere(100, 100);
    for (int axis = 0; axis < 3; ++axis) {
        for (const double sign : {1.0, -1.0}) {
            const Vec3 pole = sign * Vec3::Unit(axis);
            EXPECT_EQ(std::count(mesh.positions().begin(), mesh.positions().end(), pole), 1);
        }
    }
    for (const Vec3& position : mesh.positions()) {
        for (const double coordinate : position) {
            EXPECT_FALSE(coordinate == 0.0 && std::signbit(coordinate));
            EXPECT_TRUE(coordinate == 0.0 || std::abs(coordinate) > 1e-6);
        }
    }
}

// No triangle of it crosses a coordinate plane, so a closed octant is touched by vertices: this is
// the count that all methods must find at depth 1.
TEST(SampleMeshes, SphereTouchesAllOctantsAlike)
{
    const TriangleMesh mesh = make_sphere(100, 100);
    for (unsigned octant = 0; octant < 8; ++octant) {
        const Vec3 signs((octant & 1U) != 0 ? 1 : -1, (octant & 2U) != 0 ? 1 : -1,
                         (octant & 4U) != 0 ? 1 : -1);
        std::size_t touching = 0;
        std::size_t inside = 0;
        for (std::uint32_t id = 0; id < mesh.triangle_count(); ++id) {
            const Triangle triangle = mesh.triangle(TriangleId{id});
            const auto in_octant = [&](const Vec3& p) {
                return (p.cwiseProduct(signs).array() >= 0.0).all();
            };
            const auto& corners = triangle.vertices;
            touching += std::any_of(corners.begin(), corners.end(), in_octant) ? 1U : 0U;
            inside += std::all_of(corners.begin(), corners.end(), in_octant) ? 1U : 0U;
        }
        EXPECT_EQ(touching, 2799U) << octant;
        EXPECT_EQ(inside, 2475U) << octant;
    }
}

TEST(SampleMeshes, IcosphereIsARoundClosedOutwardSphere)
{
    std::size_t triangles = 20;
    for (int level = 0; level <= 4; ++level, triangles *= 4) {
        SCOPED_TRACE(level);
        const TriangleMesh mesh = make_icosphere(level);
        EXPECT_EQ(mesh.triangle_count(), triangles);
        EXPECT_EQ(mesh.vertex_count(), triangles / 2 + 2);
        expect_closed(mesh);
        for (const Vec3& position : mesh.positions()) EXPECT_NEAR(position.norm(), 1.0, 1e-15);
        for (std::uint32_t id = 0; id < mesh.triangle_count(); ++id) {
            const Triangle triangle = mesh.triangle(TriangleId{id});
            EXPECT_GT(scaled_normal(triangle).dot(triangle[0]), 0.0);
        }
    }
    const TriangleMesh once = make_icosphere(1);
    EXPECT_EQ(std::count(once.positions().begin(), once.positions().end(), Vec3(0, 0, 1)), 1);
    EXPECT_EQ(std::count(once.positions().begin(), once.positions().end(), Vec3(-1, 0, 0)), 1);
}

TEST(SampleMeshes, CubeOctahedronAndTorusHaveTheirShapes)
{
    const TriangleMesh cube = make_cube();
    expect_closed(cube);
    EXPECT_EQ(cube.triangle_count(), 12U);
    EXPECT_DOUBLE_EQ(volume(cube), 8.0);
    EXPECT_EQ(bounding_box(cube).lower, Vec3(-1, -1, -1));
    EXPECT_EQ(bounding_box(cube).upper, Vec3(1, 1, 1));

    const TriangleMesh octahedron = make_octahedron();
    expect_closed(octahedron);
    EXPECT_EQ(octahedron.triangle_count(), 8U);
    EXPECT_DOUBLE_EQ(volume(octahedron), 4.0 / 3.0);

    const TriangleMesh torus = make_torus(80, 40);
    expect_closed(torus);
    EXPECT_EQ(torus.triangle_count(), 6400U);
    EXPECT_EQ(euler_characteristic(torus), 0);
    const double pi = std::acos(-1.0);
    // Between two of 80 rings of 40 corners, the ring's area moves along a chord.
    const double ring = 40 * 0.5 * 0.25 * std::sin(2 * pi / 40);
    EXPECT_NEAR(volume(torus), ring * 80 * std::sin(2 * pi / 80), 1e-12);
    expect_closed(make_torus(3, 3));
    EXPECT_GT(volume(make_torus(3, 3)), 0.0);
}

TEST(SampleMeshes, SpaceshipHasExactlyTheRequestedTriangles)
{
    std::vector<std::size_t> sizes = {min_spaceship_triangles, 33000};
    for (std::size_t extra = 2; extra <= 40; extra += 2) {
        sizes.push_back(min_spaceship_triangles + extra);
    }
    std::mt19937 random(7);
    for (int k = 0; k < 30; ++k) sizes.push_back(1300 + 2 * (random() % 20000));
    for (const std::size_t size : sizes) {
        SCOPED_TRACE(size);
        const auto ship = make_spaceship(size);
        ASSERT_TRUE(ship);
        EXPECT_EQ(ship->triangle_count(), size);
        expect_closed(*ship);
        EXPECT_GT(volume(*ship), 1.5);
        EXPECT_LT(volume(*ship), 2.5);
        const Vec3 extent = bounding_box(*ship).extent();
        EXPECT_NEAR(extent.x(), 4.26, 0.1);
        EXPECT_NEAR(extent.y(), 3.17, 0.1);
        EXPECT_NEAR(extent.z(), 1.4, 0.1);
    }
}

TEST(SampleMeshes, SpaceshipTrianglesAreOfVeryUnevenSizes)
{
    const auto ship = make_spaceship(33000);
    std::vector<double> areas;
    for (std::uint32_t id = 0; id < ship->triangle_count(); ++id) {
        areas.push_back(0.5 * scaled_normal(ship->triangle(TriangleId{id})).norm());
    }
    std::sort(areas.begin(), areas.end());
    EXPECT_GT(areas[areas.size() * 99 / 100] / areas[areas.size() / 100], 1000.0);
}

TEST(SampleMeshes, SpaceshipRefusesImpossibleTriangleCounts)
{
    for (const std::size_t size :
         {std::size_t{0}, std::size_t{12}, min_spaceship_triangles - 2, std::size_t{33001}}) {
        const auto ship = make_spaceship(size);
        ASSERT_FALSE(ship) << size;
        EXPECT_EQ(code_of(ship), ErrorCode::invalid_argument);
        EXPECT_NE(ship.error().message.find("even number"), std::string::npos);
    }
    EXPECT_EQ(code_of(make_spaceship(max_sample_triangles + 2)), ErrorCode::limit_exceeded);
}

TEST(SampleMeshes, NamesAreDistinguishedFromFiles)
{
    for (const char* name : {"cube", "octahedron", "sphere:100x100", "sphere:x", "sphere",
                             "icosphere:3", "torus:9x9", "spaceship:33000", "cube:3"}) {
        EXPECT_TRUE(is_sample_mesh_name(name)) << name;
    }
    for (const char* name :
         {"", ":", "cube.obj", "spheres:3x3", "Cube", "./cube", "C:\\sphere", "sphere.ply"}) {
        EXPECT_FALSE(is_sample_mesh_name(name)) << name;
    }
}

TEST(SampleMeshes, NamesMakeTheMeshes)
{
    EXPECT_EQ(sample_mesh("sphere:100x100")->triangle_count(), 19800U);
    EXPECT_EQ(sample_mesh("sphere:3x5")->triangle_count(), 20U);
    EXPECT_EQ(sample_mesh("icosphere:2")->triangle_count(), 320U);
    EXPECT_EQ(sample_mesh("cube")->triangle_count(), 12U);
    EXPECT_EQ(sample_mesh("octahedron")->triangle_count(), 8U);
    EXPECT_EQ(sample_mesh("torus:5x7")->triangle_count(), 70U);
    EXPECT_EQ(sample_mesh("spaceship:2000")->triangle_count(), 2000U);
}

TEST(SampleMeshes, RefuseBadSizesAndNameTheAllowedOnes)
{
    const auto expect_error = [](const char* name, ErrorCode code, const char* words) {
        const auto mesh = sample_mesh(name);
        ASSERT_FALSE(mesh) << name;
        EXPECT_EQ(code_of(mesh), code) << name;
        EXPECT_NE(mesh.error().message.find(words), std::string::npos)
            << name << " said: " << mesh.error().message;
        EXPECT_EQ(mesh.error().where, name);
    };
    using enum ErrorCode;
    for (const char* name :
         {"sphere", "sphere:", "sphere:100", "sphere:1x100", "sphere:100x2", "sphere:100x",
          "sphere:x100", "sphere:-3x5", "sphere:3x5 ", "sphere: 3x5", "sphere:+3x5", "sphere:3X5",
          "sphere:3x5x7", "sphere:3.5x4", "sphere:99999999999999999999999x3"}) {
        expect_error(name, invalid_argument, "sphere:STACKSxSLICES with at least 2 stacks");
    }
    expect_error("icosphere", invalid_argument, "icosphere:N with N from 0");
    expect_error("icosphere:12", invalid_argument, "to 11");
    expect_error("icosphere:4294967297", invalid_argument, "to 11");
    expect_error("torus:2x9", invalid_argument, "torus:NxM with at least 3");
    expect_error("torus:9x2", invalid_argument, "torus:NxM with at least 3");
    expect_error("cube:3", invalid_argument, "cube alone");
    expect_error("octahedron:", invalid_argument, "octahedron alone");
    expect_error("spaceship", invalid_argument, "even number from 1300");
    expect_error("spaceship:1001", invalid_argument, "even number");
    expect_error("teapot", invalid_argument, "sphere:STACKSxSLICES, icosphere:N, cube");
    expect_error("sphere:100000x100000", limit_exceeded, "at most 134217728");
    expect_error("sphere:18446744073709551615x18446744073709551615", limit_exceeded, "at most");
    expect_error("sphere:2x4294967297", limit_exceeded, "at most");
    expect_error("torus:4294967296x4294967296", limit_exceeded, "at most");
    expect_error("spaceship:134217730", limit_exceeded, "at most");
}

// The same bits on every machine and with every compiler: recorded values.
TEST(SampleMeshes, HaveTheSameBitsEverywhere)
{
    const auto hash = [](const char* name) {
        const auto mesh = sample_mesh(name);
        const auto bytes = std::as_bytes(mesh->positions());
        const auto corners = std::as_bytes(mesh->triangles());
        return XXH3_64bits_withSeed(corners.data(), corners.size(),
                                    XXH3_64bits(bytes.data(), bytes.size()));
    };
    EXPECT_EQ(hash("cube"), 0x0BF096C992CF2022U);
    EXPECT_EQ(hash("octahedron"), 0x877EE304D2BEDE31U);
    EXPECT_EQ(hash("sphere:100x100"), 0xEAE4486245660D0DU);
    EXPECT_EQ(hash("sphere:50x50"), 0x48A29AC6C92A0664U);
    EXPECT_EQ(hash("icosphere:4"), 0xDFCCA302C007643CU);
    EXPECT_EQ(hash("torus:40x20"), 0x68E58F4B11FDC55DU);
    EXPECT_EQ(hash("spaceship:33000"), 0x361020314FAE0B83U);
    EXPECT_EQ(hash("spaceship:250000"), 0xC2053AFDBF0CA4A9U);
}

} // namespace
} // namespace proxima::sample_meshes_test
