#include "octree/winding_number.h"

#include "code_of.h"
#include "octree/small_meshes.h"

#include "oracles/exact_winding.h"

#include <Eigen/Geometry>
#include <gtest/gtest.h>
#include <random>

namespace proxima::winding_number_test {
namespace {

using namespace testing;

/// Van Oosterom and Strackee as written, one arc tangent per triangle, in long double.
double plain_winding_number(const TriangleMesh& mesh, const Vec3& point)
{
    using Vector = Eigen::Matrix<long double, 3, 1>;
    long double sum = 0;
    for (std::uint32_t i = 0; i < mesh.triangle_count(); ++i) {
        const Triangle triangle = mesh.triangle(TriangleId{i});
        const Vector a = (triangle[0] - point).cast<long double>();
        const Vector b = (triangle[1] - point).cast<long double>();
        const Vector c = (triangle[2] - point).cast<long double>();
        sum +=
            2 * std::atan2(a.dot(b.cross(c)), a.norm() * b.norm() * c.norm() + a.dot(b) * c.norm() +
                                                  b.dot(c) * a.norm() + c.dot(a) * b.norm());
    }
    return static_cast<double>(sum / (4 * std::numbers::pi_v<long double>));
}

std::vector<Vec3> random_points(const Box& box, int count, unsigned seed)
{
    std::mt19937 random(seed);
    std::uniform_real_distribution<double> place(-0.5, 1.5);
    std::vector<Vec3> points;
    for (int i = 0; i < count; ++i) {
        const Vec3 part{place(random), place(random), place(random)};
        points.push_back(box.lower + box.extent().maxCoeff() * part);
    }
    return points;
}

struct NamedMesh {
    const char* name;
    TriangleMesh mesh;
};

std::vector<NamedMesh> meshes()
{
    const TriangleMesh sphere = sphere_mesh(Vec3(0.1, 0.2, 0.3), 1.0, 40, 40);
    const TriangleMesh torus = torus_mesh(1.0, 0.3, 60, 30);
    const TriangleMesh open_torus = without(torus, [](std::size_t i) { return i < 400; });
    std::mt19937 random(3);
    std::uniform_real_distribution<double> place(-1.0, 1.0);
    std::vector<Vec3> corners;
    std::vector<TriangleCorners> soup;
    for (std::uint32_t i = 0; i < 500; ++i) {
        for (int k = 0; k < 3; ++k)
            corners.emplace_back(place(random), place(random), place(random));
        soup.push_back({3 * i, 3 * i + 1, 3 * i + 2});
    }
    return {
        {"sphere", sphere},
        {"torus", torus},
        {"open torus", open_torus},
        {"without squares", moved(open_torus, [](const Vec3& p) { return Vec3(p * 0x1p-560); })},
        {"shell", joined(sphere, inverted(sphere_mesh(Vec3(0.1, 0.2, 0.3), 0.5, 20, 20)))},
        {"soup", mesh_of(corners, soup)},
        {"one triangle", mesh_of({Vec3(0, 0, 0), Vec3(1, 0, 0), Vec3(0, 1, 0)}, {{0, 1, 2}})},
        {"far away", moved(sphere, [](const Vec3& p) { return Vec3(p + Vec3(1e9, -1e9, 1e9)); })},
        {"tiny", moved(torus, [](const Vec3& p) { return Vec3(p * 1e-30); })},
        {"huge", moved(torus, [](const Vec3& p) { return Vec3(p * 1e30); })}};
}

TEST(WindingNumber, StaysWithinItsErrorOfThePlainSum)
{
    for (const NamedMesh& named : meshes()) {
        SCOPED_TRACE(named.name);
        const auto winding = build_winding_number(named.mesh);
        ASSERT_TRUE(winding);
        for (const Vec3& point : random_points(bounding_box(named.mesh), 200, 11)) {
            const double truth = plain_winding_number(named.mesh, point);
            EXPECT_NEAR(brute_winding_number(named.mesh, point), truth, 1e-12);
            for (const double accuracy : {0.3, 1e-2, 1e-4, 1e-7, 0.0}) {
                const WindingEstimate found = winding_number(*winding, point, accuracy);
                EXPECT_LE(std::abs(found.value - truth), found.error);
                EXPECT_LE(found.error, std::max(accuracy, 1e-12));
            }
        }
    }
}

TEST(WindingNumber, ExpandsFarClustersInsteadOfSummingThem)
{
    // The bound must be tight enough to be of use: far from the mesh one expansion is enough,
    // so the estimate has an error, and that error falls with the fifth power of the distance.
    const TriangleMesh mesh = torus_mesh(1.0, 0.3, 60, 30);
    const auto winding = build_winding_number(mesh).value();
    const double near = winding_number(winding, Vec3(10, 0, 0), 0.1).error;
    const double far = winding_number(winding, Vec3(1000, 0, 0), 0.1).error;
    const double fifth_power = std::pow(1.3 / 10, 5); // of its radius by the distance
    EXPECT_GT(near, fifth_power / 3);
    EXPECT_LT(near, fifth_power * 10);
    // A hundred times as far, 1e-10 times as large but for rounding.
    EXPECT_LT(far - 1e-12, near * 1e-9);
}

TEST(WindingNumber, DecidesInsideAsTheSumOfAllTriangles)
{
    for (const NamedMesh& named : meshes()) {
        SCOPED_TRACE(named.name);
        const auto winding = build_winding_number(named.mesh).value();
        int inside = 0;
        for (const Vec3& point : random_points(bounding_box(named.mesh), 500, 5)) {
            const bool truth = brute_is_inside(named.mesh, point);
            EXPECT_EQ(is_inside(winding, point), truth);
            inside += truth ? 1 : 0;
        }
        if (std::string(named.name) == "sphere") {
            EXPECT_GT(inside, 20);
        }
    }
}

TEST(WindingNumber, TellsTheSidesOfAFaceApartWhereDoublesEnd)
{
    // Beside faces, by the last bits of a coordinate: the value jumps by one there.
    int sides[2] = {};
    for (const TriangleMesh& mesh :
         {sphere_mesh(Vec3(0.1, 0.2, 0.3), 1.0, 16, 24), torus_mesh(1.0, 0.3, 24, 12),
          moved(cube_mesh(Vec3::Zero(), 1.0), [](const Vec3& p) {
              return Vec3(Eigen::AngleAxisd(0.7, Vec3(1, 2, 3).normalized()) * p);
          })}) {
        const auto winding = build_winding_number(mesh).value();
        for (std::uint32_t id = 0; id < mesh.triangle_count(); ++id) {
            const Triangle triangle = mesh.triangle(TriangleId{id});
            const Vec3 middle = (triangle[0] + triangle[1] + triangle[2]) / 3;
            for (int i = 0; i < 7; ++i) {
                Vec3 p = middle;
                if (i > 0) p[i % 3] = std::nextafter(p[i % 3], i < 4 ? HUGE_VAL : -HUGE_VAL);
                const auto truth = oracle::exact_winding(mesh, p);
                if (!truth) continue; // on the face
                ++sides[*truth];
                ASSERT_NEAR(brute_winding_number(mesh, p), *truth, 1e-12) << id << ' ' << i;
                ASSERT_NEAR(winding_number(winding, p, 0).value, *truth, 1e-12) << id << ' ' << i;
                ASSERT_EQ(is_inside(winding, p), *truth == 1) << id << ' ' << i;
            }
        }
    }
    EXPECT_GT(sides[0], 1000);
    EXPECT_GT(sides[1], 1000);
}

TEST(WindingNumber, IsThatOfOutsideAllButAtACorner)
{
    const TriangleMesh cube = cube_mesh(Vec3(0.5, 0.5, 0.5), 0.5);
    for (const double size : {1e-100, 1e-163, 1e-200, 1e-300}) {
        const Vec3 outside = size * Vec3(3, -1, 2);
        const Vec3 inside = size * Vec3(1, 1, 1);
        EXPECT_NEAR(brute_winding_number(cube, outside), 0, 1e-12) << size;
        EXPECT_NEAR(brute_winding_number(cube, inside), 1, 1e-12) << size;
    }
    // A triangle so thin that nothing of its angle is left.
    const TriangleMesh sliver =
        mesh_of({Vec3(0, 0, 0), Vec3(1, 0, 0), Vec3(1, 1e-200, 0)}, {{0, 1, 2}});
    for (const double height : {1e-200, 1e-320})
        EXPECT_NEAR(brute_winding_number(sliver, Vec3(0, 0, height)), 0, 0.5) << height;
}

TEST(WindingNumber, CountsAHalfAsInside)
{
    // The centre of the disc that closes a half sphere: exactly 1/2 by symmetry.
    const TriangleMesh sphere = sphere_mesh(Vec3::Zero(), 1.0, 32, 32);
    const TriangleMesh half = without(sphere, [&](std::size_t i) {
        return sphere.triangle(TriangleId{static_cast<std::uint32_t>(i)})[0][2] +
                   sphere.triangle(TriangleId{static_cast<std::uint32_t>(i)})[1][2] +
                   sphere.triangle(TriangleId{static_cast<std::uint32_t>(i)})[2][2] <
               0.0;
    });
    const auto winding = build_winding_number(half).value();
    EXPECT_NEAR(brute_winding_number(half, Vec3::Zero()), 0.5, 1e-13);
    EXPECT_TRUE(is_inside(winding, Vec3::Zero()));
    EXPECT_TRUE(is_inside(winding, Vec3(0, 0, 0.01)));
    EXPECT_FALSE(is_inside(winding, Vec3(0, 0, -0.01)));
}

TEST(WindingNumber, HasTheSameBitsForAnyNumberOfThreads)
{
    const TriangleMesh mesh = torus_mesh(1.0, 0.3, 120, 60);
    const auto one = build_winding_number(mesh, {.execution = {.threads = {1}}}).value();
    const auto three = build_winding_number(mesh, {.execution = {.threads = {3}}}).value();
    for (const Vec3& point : random_points(bounding_box(mesh), 200, 2)) {
        EXPECT_EQ(winding_number(one, point).value, winding_number(three, point).value);
    }
}

TEST(WindingNumber, RefusesMeshesWithoutTrianglesAndStopsOnRequest)
{
    EXPECT_EQ(code_of(build_winding_number(TriangleMesh{})), ErrorCode::invalid_mesh);
    const TriangleMesh nan = moved(cube_mesh(Vec3::Zero(), 1.0),
                                   [](const Vec3& p) { return Vec3(p[0], std::nan(""), p[2]); });
    EXPECT_EQ(code_of(build_winding_number(nan)), ErrorCode::invalid_mesh);
    Progress progress;
    progress.cancel();
    EXPECT_EQ(code_of(build_winding_number(cube_mesh(Vec3::Zero(), 1.0),
                                           {.execution = {.progress = &progress}})),
              ErrorCode::cancelled);
}

} // namespace
} // namespace proxima::winding_number_test
