#include "code_of.h"
#include "mesh/mesh_files.h"

#include <array>
#include <bit>
#include <cmath>
#include <cstring>
#include <limits>
#include <random>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

namespace proxima::mesh_writers_test {
namespace {

namespace fs = std::filesystem;

class MeshWriterTest : public FolderTest {};

TriangleMesh mesh_of(std::vector<Vec3> positions, std::vector<TriangleCorners> triangles)
{
    return *make_triangle_mesh(std::move(positions), std::move(triangles));
}

// All magnitudes, special values, decimal-looking numbers.
double any_double(std::mt19937_64& random)
{
    switch (random() % 6) {
    case 0:
        return std::bit_cast<double>(random());
    case 1:
        return 0.1 * static_cast<double>(random() % 100) + 0.2;
    case 2:
        return -0.0;
    case 3:
        return 1e9 + static_cast<double>(random() % 1000) / 1000;
    case 4:
        return std::numeric_limits<double>::denorm_min() * static_cast<double>(random() % 9);
    default:
        return static_cast<double>(random() % 7) - 3;
    }
}

TriangleMesh any_mesh(std::uint64_t seed, bool finite)
{
    std::mt19937_64 random(seed);
    const std::size_t count = random() % 50;
    std::vector<Vec3> positions;
    std::vector<TriangleCorners> triangles;
    const auto value = [&] {
        double result = any_double(random);
        while (finite && !std::isfinite(result)) result = any_double(random);
        return result;
    };
    for (std::size_t i = 0; i < count; ++i) positions.emplace_back(value(), value(), value());
    const auto vertex = [&] { return static_cast<std::uint32_t>(random() % count); };
    for (std::size_t i = count == 0 ? 0 : random() % 80; i > 0; --i) {
        triangles.push_back({vertex(), vertex(), vertex()});
    }
    return mesh_of(std::move(positions), std::move(triangles));
}

// Same bits; NaNs by being NaN.
void expect_same(const Vec3& read, const Vec3& written)
{
    for (int axis = 0; axis < 3; ++axis) {
        if (std::isnan(written[axis])) {
            EXPECT_TRUE(std::isnan(read[axis]));
        } else {
            EXPECT_EQ(std::bit_cast<std::uint64_t>(read[axis]),
                      std::bit_cast<std::uint64_t>(written[axis]))
                << read[axis] << " for " << written[axis];
        }
    }
}

TEST_F(MeshWriterTest, IndexedFormatsReadBackToTheSameBits)
{
    const std::pair<std::string, WriteOptions> variants[] = {
        {"mesh.obj", {}},
        {"ascii.ply", {.ply = PlyEncoding::ascii}},
        {"binary.ply", {.ply = PlyEncoding::binary}},
        {"mesh.off", {}},
    };
    for (std::uint64_t seed = 0; seed < 60; ++seed) {
        const TriangleMesh written = any_mesh(seed, false);
        for (const auto& [name, options] : variants) {
            SCOPED_TRACE(name + " with seed " + std::to_string(seed));
            const auto status = write_mesh(written, path(name), options);
            ASSERT_TRUE(status) << describe(status.error());
            const auto read = read_mesh(path(name));
            ASSERT_TRUE(read) << describe(read.error());
            ASSERT_EQ(read->vertex_count(), written.vertex_count());
            ASSERT_TRUE(std::ranges::equal(read->triangles(), written.triangles()));
            for (std::size_t i = 0; i < written.vertex_count(); ++i) {
                expect_same(read->positions()[i], written.positions()[i]);
            }
        }
    }
    EXPECT_EQ(entries(), 4);
}

TEST_F(MeshWriterTest, StlReadsBackCornerByCorner)
{
    for (std::uint64_t seed = 0; seed < 60; ++seed) {
        SCOPED_TRACE(seed);
        const TriangleMesh written = any_mesh(seed, false);
        ASSERT_TRUE(write_mesh(written, path("ascii.stl"), {.stl = StlEncoding::ascii}));
        const auto read = read_mesh(path("ascii.stl"), {.weld = Weld::never});
        ASSERT_TRUE(read) << describe(read.error());
        ASSERT_EQ(read->triangle_count(), written.triangle_count());
        for (std::uint32_t i = 0; i < written.triangle_count(); ++i) {
            for (int corner = 0; corner < 3; ++corner) {
                expect_same(read->triangle(TriangleId{i})[corner],
                            written.triangle(TriangleId{i})[corner]);
            }
        }
    }
}

TEST_F(MeshWriterTest, BinaryStlRoundsToFloat)
{
    const TriangleMesh written =
        mesh_of({{0.1, 0.30000000000000004, -0.0}, {1e-50, 3e38, 1}, {-HUGE_VAL, std::nan(""), 2}},
                {{0, 1, 2}});
    ASSERT_TRUE(write_mesh(written, path("mesh.stl")));
    EXPECT_EQ(fs::file_size(path("mesh.stl")), 134U);
    const auto read = read_mesh(path("mesh.stl"), {.weld = Weld::never});
    ASSERT_TRUE(read);
    for (std::size_t i = 0; i < 3; ++i) {
        Vec3 rounded;
        for (int axis = 0; axis < 3; ++axis) {
            // Without volatile, g++ 12 takes the way to float and back for no change at all when it
            // makes vectors of these three.
            const volatile float narrow = static_cast<float>(written.positions()[i][axis]);
            rounded[axis] = narrow;
        }
        expect_same(read->positions()[i], rounded);
    }
}

TEST_F(MeshWriterTest, RefusesWhatBinaryStlCannotHold)
{
    const TriangleMesh mesh = mesh_of({{0, 0, 0}, {1e39, 0, 0}, {0, 1, 0}}, {{0, 1, 2}});
    const auto status = write_mesh(mesh, path("mesh.stl"));
    ASSERT_FALSE(status);
    EXPECT_EQ(code_of(status), ErrorCode::limit_exceeded);
    EXPECT_EQ(entries(), 0);
    EXPECT_TRUE(write_mesh(mesh, path("mesh.stl"), {.stl = StlEncoding::ascii}));
}

TEST_F(MeshWriterTest, WritesUnitNormalsOfAnyScale)
{
    for (const double scale : {1e-160, 1.0, 1e150, 1e-300}) {
        const double height = scale == 1e-300 ? 1 : scale; // and one that is thin
        const TriangleMesh mesh =
            mesh_of({{0, 0, 0}, {scale, 0, 0}, {0, height, 0}}, {{0, 1, 2}, {0, 0, 1}});
        ASSERT_TRUE(write_mesh(mesh, path("mesh.stl"), {.stl = StlEncoding::ascii}));
        const std::string text = file_content(path("mesh.stl"));
        EXPECT_NE(text.find("facet normal 0 0 1\n"), std::string::npos) << text;
        EXPECT_NE(text.find("facet normal 0 0 0\n"), std::string::npos) << text;
    }
}

TEST_F(MeshWriterTest, WritesNormalsOfBinaryStl)
{
    // A face that looks along -x, and a slanted one.
    const TriangleMesh mesh =
        mesh_of({{0, 0, 0}, {0, 0, 1}, {0, 1, 0}, {1, 2, 0}, {0, -2, 1}}, {{0, 1, 2}, {0, 3, 4}});
    ASSERT_TRUE(write_mesh(mesh, path("mesh.stl")));
    const std::string bytes = file_content(path("mesh.stl"));
    ASSERT_EQ(bytes.size(), 184U);
    const auto normal_at = [&](std::size_t offset) {
        std::array<float, 3> normal{};
        std::memcpy(normal.data(), bytes.data() + offset, sizeof normal);
        return normal;
    };
    EXPECT_EQ(normal_at(84), (std::array<float, 3>{-1, 0, 0}));
    const auto slanted = normal_at(134); // (1, 2, 0) x (0, -2, 1) = (2, -1, -2)
    EXPECT_FLOAT_EQ(slanted[0], 2.0F / 3);
    EXPECT_FLOAT_EQ(slanted[1], -1.0F / 3);
    EXPECT_FLOAT_EQ(slanted[2], -2.0F / 3);
}

TEST_F(MeshWriterTest, NamesTheFormatsItWrites)
{
    const TriangleMesh mesh = any_mesh(1, true);
    for (const char* name : {"mesh.3ds", "mesh.glb", "mesh.txt", "mesh"}) {
        const auto status = write_mesh(mesh, path(name));
        ASSERT_FALSE(status);
        EXPECT_EQ(code_of(status), ErrorCode::unsupported_format);
        EXPECT_NE(status.error().message.find(".ply"), std::string::npos);
    }
    EXPECT_EQ(entries(), 0);
}

TEST_F(MeshWriterTest, LeavesNothingBehindWhenItCannotWrite)
{
    std::vector<Vec3> positions(100'000, Vec3(0.1, 0.2, 0.3));
    const TriangleMesh mesh = mesh_of(std::move(positions), {{0, 1, 2}});
    EXPECT_EQ(code_of(write_mesh(mesh, path("missing/mesh.ply"))), ErrorCode::file_not_writable);

    Progress progress;
    progress.cancel();
    EXPECT_EQ(code_of(write_mesh(mesh, path("mesh.ply"), {.execution = {.progress = &progress}})),
              ErrorCode::cancelled);
    EXPECT_EQ(entries(), 0);

    // A disk that fills up, and a limit on file sizes in a child of its own.
    fs::create_symlink("/dev/full", path("full.obj"));
    EXPECT_EQ(code_of(write_mesh(mesh, path("full.obj"))), ErrorCode::file_not_writable);
    const pid_t child = ::fork();
    ASSERT_GE(child, 0);
    if (child == 0) {
        const rlimit limit{65536, 65536};
        (void)::setrlimit(RLIMIT_FSIZE, &limit);
        int result = 0;
        for (const char* name : {"mesh.obj", "mesh.ply"}) {
            const auto status = write_mesh(mesh, path(name));
            if (status || status.error().code != ErrorCode::file_not_writable) result = 1;
        }
        ::_exit(result);
    }
    int status = 0;
    ASSERT_EQ(::waitpid(child, &status, 0), child);
    EXPECT_EQ(status, 0);
    EXPECT_EQ(entries(), 1);
}

} // namespace
} // namespace proxima::mesh_writers_test
