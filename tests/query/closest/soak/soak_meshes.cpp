#include "query/closest/soak/soak_meshes.h"

#include "index/test_meshes.h"
#include "proxima/mesh_io.h"
#include "proxima/sample_meshes.h"

#include <cmath>
#include <filesystem>
#include <numbers>
#include <random>

namespace proxima::soak {
namespace {

using namespace testing;

TriangleMesh read_if_there(const std::filesystem::path& file)
{
    if (!std::filesystem::exists(file)) return {};
    return read_mesh(file).value();
}

/// Every triangle twice, the second time after all others.
TriangleMesh twice(const TriangleMesh& mesh)
{
    std::vector<TriangleCorners> triangles(mesh.triangles().begin(), mesh.triangles().end());
    triangles.insert(triangles.end(), mesh.triangles().begin(), mesh.triangles().end());
    return mesh_of({mesh.positions().begin(), mesh.positions().end()}, std::move(triangles));
}

/// Triangles that share nothing and go through each other, from a thousandth of the whole to all.
TriangleMesh soup(std::size_t count, std::uint64_t seed)
{
    std::mt19937_64 random(seed);
    std::uniform_real_distribution<double> part(-1, 1);
    const auto anywhere = [&] { return Vec3{part(random), part(random), part(random)}; };
    std::vector<Vec3> positions;
    std::vector<TriangleCorners> triangles;
    for (std::uint32_t i = 0; i < count; ++i) {
        const Vec3 at = anywhere();
        const double size = std::pow(10.0, 1.5 * part(random) - 1.5);
        for (int corner = 0; corner < 3; ++corner) positions.emplace_back(at + size * anywhere());
        triangles.push_back({3 * i, 3 * i + 1, 3 * i + 2});
    }
    return mesh_of(std::move(positions), std::move(triangles));
}

/// Slivers a million times as long as wide, in all directions, some of them side by side.
TriangleMesh slivers(std::size_t count, std::uint64_t seed)
{
    std::mt19937_64 random(seed);
    std::uniform_real_distribution<double> part(-1, 1);
    const auto anywhere = [&] { return Vec3{part(random), part(random), part(random)}; };
    std::vector<Vec3> positions;
    std::vector<TriangleCorners> triangles;
    for (std::size_t i = 0; i < count; ++i) {
        const Vec3 from = anywhere();
        const Vec3 to = anywhere();
        const Vec3 across = 1e-6 * (to - from).cross(anywhere()).normalized() * (to - from).norm();
        const auto first = static_cast<std::uint32_t>(positions.size());
        positions.insert(positions.end(), {from, to, 0.5 * (from + to) + across});
        triangles.push_back({first, first + 1, first + 2});
        if (i % 3 != 0) continue;
        positions.emplace_back(to + 2 * across);
        triangles.push_back({first + 1, first + 3, first + 2});
    }
    return mesh_of(std::move(positions), std::move(triangles));
}

/// A closed tube about the z axis, a thousand times as long as thick.
TriangleMesh thin_cylinder(std::uint32_t rings, std::uint32_t slices)
{
    std::vector<Vec3> positions;
    std::vector<TriangleCorners> triangles;
    for (std::uint32_t i = 0; i < rings; ++i) {
        for (std::uint32_t j = 0; j < slices; ++j) {
            const double angle = 2 * std::numbers::pi * j / slices;
            positions.emplace_back(std::cos(angle), std::sin(angle), 2000.0 * i / (rings - 1));
        }
    }
    const auto at = [&](std::uint32_t i, std::uint32_t j) { return i * slices + j % slices; };
    const std::uint32_t bottom = rings * slices;
    positions.emplace_back(0, 0, 0);
    positions.emplace_back(0, 0, 2000);
    for (std::uint32_t j = 0; j < slices; ++j) {
        for (std::uint32_t i = 0; i + 1 < rings; ++i) {
            triangles.push_back({at(i, j), at(i, j + 1), at(i + 1, j + 1)});
            triangles.push_back({at(i, j), at(i + 1, j + 1), at(i + 1, j)});
        }
        triangles.push_back({bottom, at(0, j + 1), at(0, j)});
        triangles.push_back({bottom + 1, at(rings - 1, j), at(rings - 1, j + 1)});
    }
    return mesh_of(std::move(positions), std::move(triangles));
}

/// A book of pages round every edge of a fan, several of each: edges with up to eight triangles.
TriangleMesh non_manifold(std::uint64_t seed)
{
    std::mt19937_64 random(seed);
    std::uniform_real_distribution<double> part(-1, 1);
    std::vector<Vec3> positions;
    std::vector<TriangleCorners> triangles;
    for (std::uint32_t book = 0; book < 40; ++book) {
        const auto first = static_cast<std::uint32_t>(positions.size());
        for (int i = 0; i < 12; ++i) {
            positions.emplace_back(part(random) + book % 5, part(random) + 0.5 * (book % 8),
                                   part(random));
        }
        for (std::uint32_t page = 2; page < 10; ++page)
            triangles.push_back({first, first + 1, first + page});
        for (std::uint32_t page = 3; page < 12; page += 2)
            triangles.push_back({first + 2, first + page, first + (page + 3) % 12});
    }
    return mesh_of(std::move(positions), std::move(triangles));
}

} // namespace

std::vector<SoakMesh> soak_meshes(std::uint64_t seed)
{
    const std::filesystem::path shared = PROXIMA_SOURCE_DIR "/../shared/meshes";
    const auto sample = [](const char* name) {
        return SoakMesh{name, [name] { return sample_mesh(name).value(); }};
    };
    const auto file = [](const std::filesystem::path& path) {
        return SoakMesh{path.filename().string(), [path] { return read_if_there(path); }};
    };
    return {
        sample("sphere:100x100"),
        sample("icosphere:4"),
        sample("cube"),
        sample("octahedron"),
        sample("torus:60x40"),
        sample("spaceship:33000"),
        file("/usr/share/glmark2/models/bunny.obj"),
        file(shared / "fandisk.obj"),
        file(shared / "bun_zipper_res2.ply"),
        file(shared / "dragon_vrip_res3.ply"),
        {"open sphere",
         [] { return without(make_sphere(40, 60), [](std::size_t i) { return i % 5 == 0; }); }},
        {"non-manifold", [seed] { return non_manifold(seed); }},
        {"duplicated triangles", [] { return twice(make_torus(30, 20)); }},
        {"soup", [seed] { return soup(4000, seed); }},
        {"slivers", [seed] { return slivers(1500, seed); }},
        {"thin cylinder", [] { return thin_cylinder(200, 24); }},
        {"nested spheres",
         [] {
             const TriangleMesh inner =
                 moved(make_sphere(24, 36), [](const Vec3& p) { return Vec3(0.5 * p); });
             return joined(make_sphere(48, 72), inner);
         }},
        {"corners on a grid", [] { return grid_mesh(5); }},
    };
}

} // namespace proxima::soak
