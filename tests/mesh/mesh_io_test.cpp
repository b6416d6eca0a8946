// What the readers make of well-formed files.
#include "base/text.h"
#include "code_of.h"
#include "mesh/mesh_files.h"
#include "mesh/weld_vertices.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <random>
#include <vector>

namespace proxima::mesh_io_test {
namespace {

namespace fs = std::filesystem;
using Corners = std::vector<TriangleCorners>;

Corners corners_of(const TriangleMesh& mesh)
{
    return {mesh.triangles().begin(), mesh.triangles().end()};
}

std::vector<Vec3> positions_of(const TriangleMesh& mesh)
{
    return {mesh.positions().begin(), mesh.positions().end()};
}

TriangleMesh read_seed(const std::string& name)
{
    auto mesh = read_mesh(fs::path(PROXIMA_SOURCE_DIR) / "fuzz" / "corpus" / name);
    EXPECT_TRUE(mesh) << describe(mesh.error());
    return mesh ? std::move(*mesh) : TriangleMesh{};
}

const std::vector<Vec3> tetrahedron_positions{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1.5}};
const Corners tetrahedron_corners{{0, 2, 1}, {0, 1, 3}, {1, 2, 3}, {2, 0, 3}};

TEST(MeshIo, ReadsTheSameTetrahedronFromEveryIndexedFormat)
{
    for (const char* name : {"obj/tetrahedron.obj", "ply/tetrahedron.ply", "ply/little.ply",
                             "ply/big.ply", "off/tetrahedron.off"}) {
        SCOPED_TRACE(name);
        const TriangleMesh mesh = read_seed(name);
        EXPECT_EQ(positions_of(mesh), tetrahedron_positions);
        EXPECT_EQ(corners_of(mesh), tetrahedron_corners);
    }
}

TEST(MeshIo, WeldsStlUnlessToldNotTo)
{
    for (const char* name : {"text.stl", "binary.stl", "binary_solid.stl"}) {
        SCOPED_TRACE(name);
        const fs::path path = fs::path(PROXIMA_SOURCE_DIR) / "fuzz" / "corpus" / "stl" / name;
        const auto welded = read_mesh(path);
        ASSERT_TRUE(welded) << describe(welded.error());
        // Ids by first appearance.
        EXPECT_EQ(positions_of(*welded),
                  (std::vector<Vec3>{{0, 0, 0}, {0, 1, 0}, {1, 0, 0}, {0, 0, 1.5}}));
        EXPECT_EQ(corners_of(*welded), (Corners{{0, 1, 2}, {0, 2, 3}, {2, 1, 3}, {1, 0, 3}}));
        const auto soup = read_mesh(path, {.weld = Weld::never});
        ASSERT_TRUE(soup);
        EXPECT_EQ(soup->vertex_count(), 12U);
        EXPECT_EQ(soup->triangles()[3], (TriangleCorners{9, 10, 11}));
    }
}

// Facets of three corners and of more, in blocks that end anywhere.
TEST(MeshIo, WeldsStlInPiecesLikeAllAtOnce)
{
    for (std::uint32_t seed = 0; seed < 20; ++seed) {
        SCOPED_TRACE(seed);
        std::mt19937 random(seed);
        std::string text = "solid\n";
        const std::size_t facets = random() % 300;
        for (std::size_t facet = 0; facet < facets; ++facet) {
            text += facet % 3 == 0 ? "FACET normal 0 0 1\nOuter loop\n"
                                   : "facet normal 0 0 1 outer loop\n";
            const std::size_t corners = random() % 8 == 0 ? 3 + random() % 300 : 3;
            for (std::size_t i = 0; i < corners; ++i) {
                text += "\tvertex";
                for (int axis = 0; axis < 3; ++axis)
                    text += concat(" ", random() % 2 == 0 ? "-" : "", random() % 5);
                text += '\n';
            }
            text += "endloop endfacet\n";
        }
        text += "endsolid\n";
        const auto loose = read_text(text, MeshFormat::stl, {.weld = Weld::never});
        const auto welded = read_text(text, MeshFormat::stl);
        ASSERT_TRUE(loose && welded);
        std::vector<Vec3> positions = positions_of(*loose);
        Corners corners = corners_of(*loose);
        ASSERT_TRUE(weld_vertices(positions, corners));
        EXPECT_EQ(positions_of(*welded), positions);
        // How a polygon is cut depends on its positions alone.
        EXPECT_EQ(corners_of(*welded), corners);
    }
}

TEST(MeshIo, WeldsOtherFormatsOnRequest)
{
    constexpr std::string_view text = "v 0 0 0\nv 1 0 0\nv -0.0 0 0\nv 0 1 0\nf 1 2 4\nf 3 2 4\n";
    EXPECT_EQ(read_text(text, MeshFormat::obj)->vertex_count(), 4U);
    const auto mesh = read_text(text, MeshFormat::obj, {.weld = Weld::exact_positions});
    ASSERT_TRUE(mesh);
    EXPECT_EQ(corners_of(*mesh), (Corners{{0, 1, 2}, {0, 1, 2}}));
}

TEST(MeshIo, ReadsEveryFormOfObj)
{
    const TriangleMesh mesh = read_seed("obj/forms.obj");
    ASSERT_EQ(mesh.vertex_count(), 7U);
    EXPECT_EQ(mesh.positions()[2], Vec3(1, 1, 0));
    EXPECT_TRUE(std::isnan(mesh.positions()[4].x()));
    EXPECT_EQ(mesh.positions()[4].z(), -std::numeric_limits<double>::infinity());
    EXPECT_EQ(mesh.positions()[6], Vec3(0.30000000000000004, 1e9, -1e-30));
    EXPECT_EQ(
        corners_of(mesh),
        (Corners{{0, 1, 2}, {0, 2, 3}, {5, 4, 3}, {0, 1, 5}, {6, 5, 4}, {6, 4, 3}, {6, 3, 2}}));
}

// As editors write it at the beginning of UTF-8 texts.
TEST(MeshIo, SkipsAByteOrderMark)
{
    const std::string mark = "\xEF\xBB\xBF";
    const struct {
        MeshFormat format;
        std::string text;
    } files[] = {
        {MeshFormat::obj, "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n"},
        {MeshFormat::obj, "# made by hand\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n"},
        {MeshFormat::off, "OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n"},
        {MeshFormat::off, "3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n"},
        {MeshFormat::ply, file_content(fs::path(PROXIMA_SOURCE_DIR) / "fuzz/corpus/ply/big.ply")},
        {MeshFormat::ply, "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\n"
                          "property float y\nproperty float z\nelement face 1\n"
                          "property list uchar int vertex_indices\nend_header\n"
                          "0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n"},
        {MeshFormat::xyz, "0 0 0\n1 0 0\n0 1 0\n"},
        {MeshFormat::stl, "solid a\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\n"
                          "vertex 0 1 0\nendloop\nendfacet\nendsolid a\n"},
    };
    for (const auto& file : files) {
        const auto plain = read_text(file.text, file.format);
        ASSERT_TRUE(plain) << describe(plain.error());
        const auto marked = read_text(mark + file.text, file.format);
        ASSERT_TRUE(marked) << describe(marked.error());
        EXPECT_EQ(positions_of(*marked), positions_of(*plain));
        EXPECT_EQ(corners_of(*marked), corners_of(*plain));
        EXPECT_FALSE(read_text(mark + mark + file.text, file.format)) << "only one is a mark";
    }
    EXPECT_EQ(error_of(mark + "v 0 0 0\nf 1 2 3\n", MeshFormat::obj).where, "OBJ data:2");
    for (const char* part : {"\xEF", "\xEF\xBB", "\xEF\xBB\xBF"})
        EXPECT_EQ(error_of(part, MeshFormat::off).code, ErrorCode::malformed_file);
}

TEST(MeshIo, CutsConcavePolygonsProperly)
{
    const TriangleMesh mesh = read_seed("obj/arrow.obj");
    ASSERT_EQ(mesh.triangle_count(), 4U);
    for (std::uint32_t i = 0; i < 4; ++i) {
        EXPECT_GT(scaled_normal(mesh.triangle(TriangleId{i})).z(), 0) << i;
    }
}

TEST(MeshIo, SkipsOtherElementsOfPly)
{
    const TriangleMesh mesh = read_seed("ply/extra.ply");
    EXPECT_EQ(positions_of(mesh),
              (std::vector<Vec3>{{0, 0, 0}, {1, 0, 0.5}, {1, 1, 1}, {0, 1, 0}, {-1, 0.5, 0}}));
    EXPECT_EQ(corners_of(mesh), (Corners{{0, 1, 2}, {0, 2, 3}, {0, 1, 2}, {0, 2, 3}, {0, 3, 4}}));
    const std::vector<Vec3> floored{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1.5}};
    for (const char* name : {"ply/little_extra.ply", "ply/big_extra.ply"}) {
        const TriangleMesh binary = read_seed(name);
        EXPECT_EQ(positions_of(binary), floored) << name;
        EXPECT_EQ(binary.triangle_count(), 3U) << name;
        EXPECT_EQ(binary.triangles()[2], (TriangleCorners{0, 1, 2})) << name;
    }
}

TEST(MeshIo, ReadsTriangleStripsWithSeparatorsAndTurns)
{
    // Every second triangle of a strip is turned over, and each strip starts anew.
    const Corners expected{{0, 1, 2}, {2, 1, 3}, {2, 3, 4}, {3, 5, 4}};
    EXPECT_EQ(corners_of(read_seed("ply/strips.ply")), expected);
    EXPECT_EQ(corners_of(read_seed("ply/big_strips.ply")), expected);
    const TriangleMesh mesh = read_seed("ply/strips.ply");
    for (std::uint32_t i = 0; i < 4; ++i) {
        EXPECT_GT(scaled_normal(mesh.triangle(TriangleId{i})).z(), 0) << i;
    }
}

// Every combination of types and byte order that a PLY may use for its vertices and faces.
template <class T>
void put(std::string& bytes, T value, bool big)
{
    std::string raw(reinterpret_cast<const char*>(&value), sizeof(value));
    if (big) std::ranges::reverse(raw);
    bytes += raw;
}

void put_as(std::string& bytes, const std::string& type, double value, bool big)
{
    if (type == "char" || type == "int8") put(bytes, static_cast<std::int8_t>(value), big);
    if (type == "uchar" || type == "uint8") put(bytes, static_cast<std::uint8_t>(value), big);
    if (type == "short" || type == "int16") put(bytes, static_cast<std::int16_t>(value), big);
    if (type == "ushort" || type == "uint16") put(bytes, static_cast<std::uint16_t>(value), big);
    if (type == "int" || type == "int32") put(bytes, static_cast<std::int32_t>(value), big);
    if (type == "uint" || type == "uint32") put(bytes, static_cast<std::uint32_t>(value), big);
    if (type == "float" || type == "float32") put(bytes, static_cast<float>(value), big);
    if (type == "double" || type == "float64") put(bytes, value, big);
}

TEST(MeshIo, ReadsEveryNumberTypeOfPly)
{
    const std::vector<std::string> types{"char",  "uchar",  "short",   "ushort", "int",   "uint",
                                         "float", "double", "int8",    "uint8",  "int16", "uint16",
                                         "int32", "uint32", "float32", "float64"};
    int files = 0;
    for (const std::string& vertex : types) {
        for (const std::string& count : types) {
            for (const std::string& index : types) {
                for (const int encoding : {0, 1, 2}) {
                    const bool big = encoding == 2;
                    std::string text = "ply\nformat ";
                    text += encoding == 0 ? "ascii"
                            : big         ? "binary_big_endian"
                                          : "binary_little_endian";
                    text +=
                        concat(" 1.0\nelement vertex 4\nproperty ", vertex, " x\nproperty ", vertex,
                               " y\nproperty ", vertex, " z\nelement face 1\nproperty list ", count,
                               " ", index, files % 2 == 0 ? " vertex_index" : " vertex_indices",
                               "\nend_header\n");
                    ++files;
                    const double coordinates[] = {0, 0, 0, 100, 0, 0, 100, 7, 0, 1, 9, 0};
                    const double face[] = {4, 0, 1, 2, 3};
                    for (std::size_t i = 0; i < 12; ++i) {
                        if (encoding == 0) {
                            text += concat(coordinates[i], i % 3 == 2 ? "\n" : " ");
                        } else {
                            put_as(text, vertex, coordinates[i], big);
                        }
                    }
                    for (std::size_t i = 0; i < 5; ++i) {
                        if (encoding == 0) {
                            text += concat(face[i], i == 4 ? "\n" : " ");
                        } else {
                            put_as(text, i == 0 ? count : index, face[i], big);
                        }
                    }
                    const auto mesh = read_text(text, MeshFormat::ply);
                    ASSERT_TRUE(mesh) << describe(mesh.error()) << "\n" << text;
                    ASSERT_EQ(positions_of(*mesh),
                              (std::vector<Vec3>{{0, 0, 0}, {100, 0, 0}, {100, 7, 0}, {1, 9, 0}}));
                    ASSERT_EQ(corners_of(*mesh), (Corners{{0, 1, 2}, {0, 2, 3}}));
                }
            }
        }
    }
    EXPECT_EQ(files, 3 * 16 * 16 * 16);
}

TEST(MeshIo, ReadsTheVariantsOfOff)
{
    const TriangleMesh colours = read_seed("off/colours.off");
    EXPECT_EQ(positions_of(colours),
              (std::vector<Vec3>{{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}}));
    EXPECT_EQ(corners_of(colours), (Corners{{0, 1, 2}, {0, 2, 3}, {0, 1, 2}}));
    EXPECT_EQ(read_seed("off/normals.off").triangle_count(), 1U);
    EXPECT_EQ(read_seed("off/bare.off").triangle_count(), 1U);
}

TEST(MeshIo, KeepsDoublesAndDegenerateTriangles)
{
    const auto mesh = read_text(
        "v 0.30000000000000004 1000000000.123 -0\nv 1 2 3\nf 1 1 2\nf 2 2 2\n", MeshFormat::obj);
    ASSERT_TRUE(mesh);
    EXPECT_EQ(mesh->positions()[0].x(), 0.30000000000000004);
    EXPECT_EQ(mesh->positions()[0].y(), 1e9 + 0.123);
    EXPECT_TRUE(std::signbit(mesh->positions()[0].z()));
    EXPECT_EQ(corners_of(*mesh), (Corners{{0, 0, 1}, {1, 1, 1}}));
}

TEST(MeshIo, PlacesTheMeshesOfAScene)
{
    if (!reads_scenes) GTEST_SKIP() << "built without assimp";
    for (const char* name : {"gltf/two_tetrahedra.gltf", "glb/two_tetrahedra.glb"}) {
        SCOPED_TRACE(name);
        const TriangleMesh mesh = read_seed(name);
        ASSERT_EQ(mesh.vertex_count(), 8U);
        ASSERT_EQ(mesh.triangle_count(), 8U);
        EXPECT_EQ(mesh.positions()[3], Vec3(10, 0, 1.5));
        EXPECT_EQ(mesh.positions()[5], Vec3(8, 0, 0)); // (1,0,0) scaled by (-2,2,2)
        // The mirrored copy still faces outward: both volumes are positive.
        double volumes[2] = {0, 0};
        for (std::uint32_t i = 0; i < 8; ++i) {
            const Triangle t = mesh.triangle(TriangleId{i});
            volumes[i / 4] += t[0].cross(t[1]).dot(t[2]) / 6;
        }
        EXPECT_DOUBLE_EQ(volumes[0], 0.25);
        EXPECT_DOUBLE_EQ(volumes[1], 2);
    }
}

TEST(MeshIo, RefusesScenesBeyondTheBudgetBeforeAssimpAllocates)
{
    if (!reads_scenes) GTEST_SKIP() << "built without assimp";
    const fs::path corpus = fs::path(PROXIMA_SOURCE_DIR) / "fuzz" / "corpus";
    std::string gltf = file_content(corpus / "gltf" / "two_tetrahedra.gltf");
    gltf.replace(gltf.find("\"count\":4"), 9, "\"count\": 4e9");
    EXPECT_EQ(
        error_of(gltf, MeshFormat::gltf, {.execution = {.budget = {.bytes = 100'000'000}}}).code,
        ErrorCode::budget_exceeded);
    const std::string glb = file_content(corpus / "glb" / "two_tetrahedra.glb");
    for (const std::size_t length_byte : {11U, 15U}) { // of the file, of its first part
        std::string damaged = glb;
        damaged[length_byte] = '\x7F';
        const Error error = error_of(damaged, MeshFormat::glb);
        EXPECT_EQ(error.code, ErrorCode::malformed_file);
        EXPECT_EQ(error.message.find("assimp"), std::string::npos) << error.message;
    }
}

TEST(MeshIo, WeldsThreeDsByFormat)
{
    if (!reads_scenes) GTEST_SKIP() << "built without assimp";
    const TriangleMesh mesh = read_seed("3ds/tetrahedron.3ds");
    EXPECT_EQ(mesh.vertex_count(), 4U);
    EXPECT_EQ(mesh.triangle_count(), 4U);
    // In the file's own coordinates: assimp turns them.
    std::vector<Vec3> positions(mesh.positions().begin(), mesh.positions().end());
    const auto before = [](const Vec3& p, const Vec3& q) {
        return std::lexicographical_compare(p.begin(), p.end(), q.begin(), q.end());
    };
    std::ranges::sort(positions, before);
    EXPECT_EQ(positions,
              (std::vector<Vec3>{Vec3(0, 0, 0), Vec3(0, 0, 1.5), Vec3(0, 1, 0), Vec3(1, 0, 0)}));
}

/// assimp takes the last vertex for one that is not there.
TEST(MeshIo, RefusesFacesOfThreeDsWithVerticesThatAreNotThere)
{
    if (!reads_scenes) GTEST_SKIP() << "built without assimp";
    const std::vector<SeedFile> seeds = seed_files();
    const auto seed = std::ranges::find(seeds, "3ds/tetrahedron.3ds", &SeedFile::name);
    ASSERT_NE(seed, seeds.end());
    std::string text = seed->content;
    const std::size_t faces = text.find(" A"); // the chunk's kind, 0x4120
    ASSERT_NE(faces, std::string::npos);
    text[faces + 8] = 9; // the first corner of face 0, behind length and number
    const Error error = error_of(text, MeshFormat::three_ds);
    EXPECT_EQ(error.code, ErrorCode::malformed_file);
    EXPECT_NE(error.message.find("face 0 of object"), std::string::npos) << describe(error);
    EXPECT_NE(error.message.find("uses vertex 9 of 4"), std::string::npos) << describe(error);
}

/// Chunks in chunks are no reason to run out of stack.
TEST(MeshIo, RefusesThreeDsOfNestedChunks)
{
    if (!reads_scenes) GTEST_SKIP() << "built without assimp";
    constexpr std::uint32_t depth = 1'000'000;
    std::string text;
    for (std::uint32_t i = 0; i < depth; ++i) {
        text += i == 0 ? "MM" : "==";
        const std::uint32_t length = 6 * (depth - i);
        for (unsigned byte = 0; byte < 4; ++byte) text += static_cast<char>(length >> 8 * byte);
    }
    EXPECT_EQ(error_of(text, MeshFormat::three_ds).code, ErrorCode::malformed_file);
}

#ifndef PROXIMA_WITH_ASSIMP
TEST(MeshIo, NamesTheOptionThatReadsScenes)
{
    for (const MeshFormat format : {MeshFormat::three_ds, MeshFormat::gltf, MeshFormat::glb}) {
        const Error error = error_of("glTF", format);
        EXPECT_EQ(error.code, ErrorCode::unsupported_format);
        EXPECT_NE(error.message.find("PROXIMA_WITH_ASSIMP"), std::string::npos);
    }
}
#endif

TEST(MeshIo, ReadsWellKnownMeshes)
{
    const fs::path shared = fs::path(PROXIMA_SOURCE_DIR) / ".." / "shared" / "meshes";
    const struct {
        fs::path path;
        std::size_t triangles;
        std::size_t vertices;
    } files[] = {
        {shared / "bun_zipper_res2.ply", 16301, 8171},
        {shared / "dragon_vrip_res3.ply", 47794, 22998},
        {shared / "fandisk.obj", 12946, 6475},
        {"/usr/share/glmark2/models/bunny.obj", 69666, 34835},
    };
    std::string absent;
    for (const auto& file : files) {
        if (!fs::exists(file.path)) {
            absent.append(" ").append(file.path.string());
            continue;
        }
        const auto mesh = read_mesh(file.path);
        ASSERT_TRUE(mesh) << describe(mesh.error());
        EXPECT_EQ(mesh->triangle_count(), file.triangles) << file.path;
        EXPECT_EQ(mesh->vertex_count(), file.vertices) << file.path;
    }
    if (!absent.empty()) GTEST_SKIP() << "not there:" << absent;
}

class MeshFileTest : public FolderTest {};

TEST_F(MeshFileTest, ReportsWhichFilesCannotBeOpened)
{
    EXPECT_EQ(code_of(read_mesh(path("missing.ply"))), ErrorCode::file_not_found);
    EXPECT_EQ(read_mesh(path("missing.ply")).error().where, path("missing.ply").string());
    fs::create_directory(path("folder.ply"));
    EXPECT_EQ(code_of(read_mesh(path("folder.ply"))), ErrorCode::file_not_found);
    EXPECT_NE(read_mesh(path(".")).error().message.find("folder"), std::string::npos);
    std::ofstream(path("mesh.abc")) << "1 2 3\n";
    const Error unknown = read_mesh(path("mesh.abc")).error();
    EXPECT_EQ(unknown.code, ErrorCode::unsupported_format);
    EXPECT_NE(unknown.message.find(".obj, .ply, .stl, .off, .xyz, .3ds, .gltf, .glb"),
              std::string::npos);
    std::ofstream(path("empty.off")).flush();
    EXPECT_EQ(code_of(read_mesh(path("empty.off"))), ErrorCode::malformed_file);
    fs::create_symlink("/dev/zero", path("endless.ply"));
    EXPECT_EQ(code_of(read_mesh(path("endless.ply"))), ErrorCode::file_not_found);
}

TEST_F(MeshFileTest, AcceptsExtensionsInAnyCase)
{
    std::ofstream(path("MESH.Obj")) << "v 0 0 0\nf 1 1 1\n";
    EXPECT_TRUE(read_mesh(path("MESH.Obj")));
}

TEST_F(MeshFileTest, NamesFileAndLine)
{
    std::ofstream(path("mesh.obj")) << "v 0 0 0\nv 1 0 0\n\nf 1 2 3\n";
    const Error error = read_mesh(path("mesh.obj")).error();
    EXPECT_EQ(error.where, path("mesh.obj").string() + ":4");
    EXPECT_NE(error.message.find("vertex 3"), std::string::npos) << error.message;
}

TEST(MeshIo, ReportsProgress)
{
    std::string obj;
    for (int i = 0; i < 400'000; ++i) obj += "v 1 1 1\n";
    Progress progress;
    ASSERT_TRUE(read_text(obj, MeshFormat::obj, {.execution = {.progress = &progress}}));
    EXPECT_STREQ(progress.stage(), "reading mesh");
    EXPECT_GT(progress.fraction(), 0.5);
}

} // namespace
} // namespace proxima::mesh_io_test
