// Small scenes that ask for much are refused before assimp reads them; honest ones are read.
#include "base/text.h"
#include "code_of.h"
#include "mesh/mesh_files.h"

namespace proxima::gltf_demand_test {
namespace {

constexpr MemoryBudget ten_megabytes{.bytes = 10'000'000};

// The parts of a scene of one triangle, each to be replaced.
struct Scene {
    std::string nodes = R"({"mesh":0})";
    std::string roots = "0";
    std::string primitives = R"({"attributes":{"POSITION":0}})";
    std::string accessors = R"({"bufferView":0,"componentType":5126,"count":3,"type":"VEC3"})";
    std::string more{};
    std::string buffers = R"({"byteLength":48})";
};

std::string repeated(const std::string& text, int times)
{
    std::string all = text;
    for (int i = 1; i < times; ++i) all += "," + text;
    return all;
}

/// "0,1,2" for 3.
std::string numbered(int count)
{
    std::string all = "0";
    for (int i = 1; i < count; ++i) all += concat(",", i);
    return all;
}

std::string json_of(const Scene& scene)
{
    return concat(R"({"asset":{"version":"2.0"},"scene":0,"scenes":[{"nodes":[)", scene.roots,
                  R"(]}],"nodes":[)", scene.nodes, R"(],"meshes":[{"primitives":[)",
                  scene.primitives, R"(]}],"buffers":[)", scene.buffers,
                  R"(],"bufferViews":[{"buffer":0,"byteLength":48}],)", R"("accessors":[)",
                  scene.accessors, "]", scene.more, "}");
}

std::string glb_of(std::string json)
{
    json.resize((json.size() + 3) / 4 * 4, ' ');
    const auto number = [](std::size_t value) {
        std::string bytes;
        for (unsigned i = 0; i < 4; ++i) bytes += static_cast<char>(value >> 8U * i & 0xFFU);
        return bytes;
    };
    const float corners[12] = {0, 0, 0, 1, 0, 0, 0, 1, 0};
    const std::string data(reinterpret_cast<const char*>(corners), sizeof corners);
    const std::string parts =
        number(json.size()) + "JSON" + json + number(data.size()) + std::string("BIN\0", 4) + data;
    return "glTF" + number(2) + number(12 + parts.size()) + parts;
}

Error error_of_scene(const Scene& scene)
{
    return error_of(glb_of(json_of(scene)), MeshFormat::glb,
                    {.execution = {.budget = ten_megabytes}});
}

class GltfDemand : public ::testing::Test {
protected:
    void SetUp() override
    {
        if (!reads_scenes) GTEST_SKIP() << "built without assimp";
    }
};

TEST_F(GltfDemand, AcceptsValidScenes)
{
    const Scene scenes[] = {
        {},
        {.roots = "0,0"},
        {.nodes = R"({"children":[1,1,2]},{"children":[2,2]},{"mesh":0})"},
        {.primitives = repeated(R"({"attributes":{"POSITION":0}})", 100)},
        {.more = R"(,"extras":[[[[[[{"count":1e99}]]]]]])"},
    };
    const std::size_t triangles[] = {1, 2, 5, 100, 1};
    for (std::size_t i = 0; i < std::size(scenes); ++i) {
        const auto mesh = read_text(glb_of(json_of(scenes[i])), MeshFormat::glb,
                                    {.execution = {.budget = ten_megabytes}});
        ASSERT_TRUE(mesh) << i << ": " << describe(mesh.error());
        EXPECT_EQ(mesh->triangle_count(), triangles[i]) << i;
    }
}

TEST_F(GltfDemand, RefusesGeometryThatWouldBeReadWrong)
{
    const auto accessor = [](std::string_view type, int component, int count = 3) {
        return concat(R"({"bufferView":0,"componentType":)", component, R"(,"count":)", count,
                      R"(,"type":")", type, R"("})");
    };
    const auto requires_extension = [](std::string_view name) {
        return concat(R"(,"extensionsUsed":[")", name, R"("],"extensionsRequired":[")", name,
                      "\"]");
    };
    const std::string by_indices = R"({"attributes":{"POSITION":0},"indices":1})";
    const std::string floats = accessor("VEC3", 5126);
    const auto with_indices = [&](const std::string& indices) {
        return Scene{.primitives = by_indices, .accessors = floats + "," + indices};
    };
    struct Refused {
        Scene scene;
        std::string_view says;
    };
    const Refused refused[] = {
        {{.more = requires_extension("KHR_mesh_quantization")}, "gltfpack -noq"},
        {{.more = requires_extension("EXT_mesh_gpu_instancing")}, "EXT_mesh_gpu_instancing"},
        {{.more = requires_extension("FOO_bar")}, "FOO_bar"},
        {{.accessors = accessor("VEC3", 5123)}, "floats are needed for the positions of mesh 0"},
        {{.accessors = accessor("VEC2", 5126)}, "three numbers each"},
        {{.accessors = accessor("VEC3", 5126, 4)}, "multiple of three"},
        {with_indices(accessor("SCALAR", 5126)), "unsigned integers"},
        {with_indices(accessor("SCALAR", 5122)), "unsigned integers"},
        {with_indices(accessor("VEC3", 5125)), "single numbers"},
        {with_indices(accessor("SCALAR", 5121, 5)), "multiple of three"},
    };
    for (const Refused& each : refused) {
        const Error error = error_of_scene(each.scene);
        EXPECT_NE(error.message.find(each.says), std::string::npos) << describe(error);
    }
    const Scene read[] = {
        {.more = requires_extension("KHR_materials_unlit")},
        {.more = requires_extension("KHR_texture_transform")},
        {.more = R"(,"extensionsUsed":["EXT_mesh_gpu_instancing"])"},
        {.primitives = R"({"attributes":{"POSITION":0},"mode":5})",
         .accessors = accessor("VEC3", 5126, 4)},
        with_indices(accessor("SCALAR", 5121)),
    };
    for (const Scene& scene : read) {
        const auto mesh = read_text(glb_of(json_of(scene)), MeshFormat::glb, {});
        EXPECT_TRUE(mesh) << describe(mesh.error());
    }
}

TEST_F(GltfDemand, ReadsStripsAndFansOfOneTriangle)
{
    for (const int mode : {4, 5, 6}) {
        const Scene scene{.primitives =
                              concat(R"({"attributes":{"POSITION":0},"mode":)", mode, "}")};
        const auto mesh = read_text(glb_of(json_of(scene)), MeshFormat::glb);
        ASSERT_TRUE(mesh) << describe(mesh.error());
        EXPECT_EQ(mesh->triangle_count(), 1U) << mode;
    }
}

/// The product of the scales has no double's determinant.
TEST_F(GltfDemand, TurnsWhatTinyNodesMirror)
{
    const auto normal_of = [](const char* scale) {
        const std::string node = concat(R"({"children":[1],"scale":)", scale, "},");
        const Scene scene{.nodes = node + R"({"children":[2],"scale":[1e-37,1e-37,1e-37]},)" +
                                   R"({"children":[3],"scale":[1e-37,1e-37,1e-37]},{"mesh":0})"};
        const TriangleMesh mesh = read_text(glb_of(json_of(scene)), MeshFormat::glb).value();
        std::array<Vec3, 3> corners = mesh.triangle(TriangleId{0}).vertices;
        for (Vec3& corner : corners) corner *= 0x1p368;
        return scaled_normal({corners}).normalized();
    };
    // The triangle (0,0,0), (1,0,0), (0,1,0); mirrored in x it would face down.
    EXPECT_GT(normal_of("[1e-37,1e-37,1e-37]").z(), 0.5);
    EXPECT_GT(normal_of("[-1e-37,1e-37,1e-37]").z(), 0.5);
}

TEST_F(GltfDemand, RefusesScenesBeyondTheBudget)
{
    std::string doubling;
    for (int i = 1; i <= 30; ++i) doubling += concat(R"({"children":[)", i, ",", i, "]},");
    const std::string zeros =
        R"({"componentType":5126,"count":100000000,"type":"VEC3","sparse":{"count":1,)"
        R"("indices":{"bufferView":0,"componentType":5125},"values":{"bufferView":0}}})";
    std::string escaped = zeros;
    escaped.replace(escaped.find("count"), 5, R"(c\u006funt)");
    const std::string big_view =
        R"({"bufferView":0,"componentType":5126,"count":30000,"type":"VEC3"})";
    const Scene scenes[] = {
        {.nodes = doubling + R"({"mesh":0})"},
        {.accessors = zeros},
        {.accessors = Scene().accessors + "," + zeros},
        {.accessors = escaped},
        {.primitives = repeated(R"({"attributes":{"POSITION":0}})", 20), .accessors = big_view},
        {.primitives = repeated(R"({"attributes":{},"indices":0,"mode":0})", 10),
         .accessors = big_view},
        {.primitives = R"({"attributes":{"POSITION":0},"targets":[)" + repeated("{}", 20) + "]}",
         .accessors = big_view},
        {.accessors = R"({"bufferView":0,"componentType":5126,"count":-3,"type":"VEC3"})"},
        {.accessors =
             R"({"bufferView":0,"byteOffset":1e19,"componentType":5126,"count":3,"type":"VEC3"})"},
        {.more = R"(,"materials":[)" + repeated("{}", 1000) + "]"},
        {.more = R"(,"images":[)" + repeated("{}", 10000) + "]"},
        {.more = R"(,"animations":[{"samplers":[{"input":0,"output":0}],"channels":[)" +
                 repeated(R"({"sampler":0})", 10000) + "]}]"},
        {.nodes = R"({"mesh":0,"skin":0})",
         .primitives = repeated(R"({"attributes":{"POSITION":0}})", 100),
         .more = R"(,"skins":[{"joints":[)" + repeated("0", 100) + "]}]"},
        {.buffers = R"({"byteLength":48},{"byteLength":20000000})"},
        // 1,000 nodes that each list the 3,000 primitives of one mesh.
        {.nodes = repeated(R"({"mesh":0})", 1000),
         .roots = numbered(1000),
         .primitives = repeated(R"({"attributes":{"POSITION":0}})", 3000)},
    };
    ASSERT_TRUE(read_text(
        glb_of(json_of({.nodes = repeated(R"({"mesh":0})", 10),
                        .roots = numbered(10),
                        .primitives = repeated(R"({"attributes":{"POSITION":0}})", 3000)})),
        MeshFormat::glb, {.execution = {.budget = ten_megabytes}}));
    for (std::size_t i = 0; i < std::size(scenes); ++i) {
        const Error error = error_of_scene(scenes[i]);
        EXPECT_EQ(error.code, ErrorCode::budget_exceeded) << i << ": " << describe(error);
        EXPECT_EQ(error.message.find("assimp"), std::string::npos) << i;
    }
}

/// The bytes that a scene may need, as the message of its refusal says.
double demand_of(const Scene& scene)
{
    const std::string json = json_of(scene);
    const Error error = error_of(glb_of(json), MeshFormat::glb,
                                 {.execution = {.budget = {.bytes = 200'000 + 200 * json.size()}}});
    EXPECT_EQ(error.code, ErrorCode::budget_exceeded) << describe(error);
    const std::string_view before = "may need ";
    const std::size_t at = error.message.find(before);
    EXPECT_NE(at, std::string::npos) << error.message;
    if (at == std::string::npos) return 0;
    return 1e6 * std::stod(error.message.substr(at + before.size()));
}

TEST_F(GltfDemand, GrowsByWhateverIsAdded)
{
    // Big enough to be refused without any of the additions.
    const std::string big =
        R"({"bufferView":0,"componentType":5126,"count":1000000,"type":"VEC3"})";
    const std::string primitive = R"({"attributes":{"POSITION":0}})";
    const Scene base = {.nodes = "{}", .accessors = big};
    const double least = demand_of(base);
    const auto growth_by = [&](const auto& change) {
        Scene scene = base;
        change(scene);
        return demand_of(scene) - least;
    };
    const double node = growth_by([](Scene& s) {
        s = {"{},{}", "0,1", s.primitives, s.accessors};
    });
    EXPECT_GT(node, 0);
    EXPECT_EQ(growth_by([](Scene& s) { s.nodes = "{},{}"; }), 0) << "a node of no scene";
    EXPECT_GT(growth_by([](Scene& s) { s.nodes = R"({"mesh":0})"; }), 0);
    EXPECT_EQ(growth_by([](Scene& s) { s.nodes = R"({"mesh":1})"; }), 0) << "of no mesh";
    EXPECT_NEAR(growth_by([](Scene& s) { s.nodes = R"({"children":[1,2]},{},{})"; }), 2 * node, 1);
    EXPECT_GT(growth_by([&](Scene& s) { s.primitives = repeated(primitive, 2); }), 1e6);
    EXPECT_GT(growth_by([](Scene& s) { s.primitives = R"({"attributes":{"JOINTS_0":0}})"; }), 1e6);
    EXPECT_GT(growth_by([](Scene& s) { s.buffers += R"(,{"byteLength":77})"; }), 76);
    EXPECT_GT(growth_by([](Scene& s) { s.more = R"(,"materials":[{}])"; }), 0);
    const auto image = [&](const std::string& of) {
        return growth_by([&](Scene& s) { s.more = R"(,"images":[{)" + of + "}]"; });
    };
    EXPECT_GT(image(""), 0);
    EXPECT_NEAR(image(R"("bufferView":0)") - image(""), 48, 0.5);
    EXPECT_EQ(image(R"("bufferView":1)"), image("")) << "of no view";
    // Bones are those of the primitives of a mesh with a skin.
    const auto skinned = [&](const std::string& skin) {
        return growth_by([&](Scene& s) {
            s.nodes = R"({"mesh":0,"skin":0})";
            s.more = R"(,"skins":[{)" + skin + "}]";
        });
    };
    EXPECT_GT(skinned(R"("joints":[0])"), skinned(R"("joints":[])"));
    EXPECT_GT(skinned(R"("inverseBindMatrices":0)"), 1e6);
}

TEST_F(GltfDemand, ChannelsOfAnAnimationCopyTheKeysOfTheirSampler)
{
    const std::string big =
        R"({"bufferView":0,"componentType":5126,"count":1000000,"type":"VEC3"})";
    const auto demand = [&](const std::string& channels) {
        return demand_of(
            {.accessors = big,
             .more = R"(,"animations":[{"samplers":[{"input":0},{"input":0,"output":0}],)"
                     R"("channels":[)" +
                     channels + "]}]"});
    };
    const double none = demand("{}");
    const double first = demand(R"({"sampler":0})") - none;
    EXPECT_GT(first, 1e6);
    EXPECT_NEAR(demand(R"({"sampler":1})") - none, 2 * first, 1);
    for (const char* const wrong : {"2", "-1", "1e99", "0.5e300", "\"0\"", "null"})
        EXPECT_EQ(demand(concat(R"({"sampler":)", wrong, "}")), none) << wrong;
}

TEST_F(GltfDemand, OffsetsUpToATebibyteAreNoMatterOfMemory)
{
    const auto code = [](const std::string& offset) {
        return error_of_scene({.accessors = R"({"bufferView":0,"byteOffset":)" + offset +
                                            R"(,"componentType":5126,"count":3,"type":"VEC3"})"})
            .code;
    };
    EXPECT_EQ(code("1099511627776"), ErrorCode::malformed_file); // beyond its view
    EXPECT_EQ(code("1099511627777"), ErrorCode::budget_exceeded);
}

/// assimp's reader of glTF 1 ends the program by its assertions.
TEST_F(GltfDemand, RefusesOtherVersions)
{
    const auto of_version = [](std::string_view asset) {
        return error_of(concat("{\"asset\":", asset, R"(,"scenes":[{"nodes":[]}]})"),
                        MeshFormat::gltf);
    };
    for (const std::string_view asset :
         {R"({"version":"1.0"})", R"({"version":"3.0"})", "{}", R"({"version":20})", "2"}) {
        const Error error = of_version(asset);
        EXPECT_EQ(error.code, ErrorCode::unsupported_format) << asset << describe(error);
        EXPECT_NE(error.message.find("version"), std::string::npos) << describe(error);
    }
    EXPECT_EQ(of_version(R"({"version":"2.0"})").code, ErrorCode::malformed_file);
    std::string binary = glb_of(json_of({}));
    binary[4] = 1;
    EXPECT_EQ(error_of(binary, MeshFormat::glb).code, ErrorCode::unsupported_format);
}

/// Indices of three corners, of which one names a vertex that is not there.
TEST_F(GltfDemand, RefusesTrianglesOfVerticesThatAreNotThere)
{
    const auto with_indices = [](std::string_view indices, int count) {
        // 16-bit numbers behind the corners, which end with a zero.
        std::string glb =
            glb_of(json_of({.primitives = R"({"attributes":{"POSITION":0},"indices":1})",
                            .accessors = concat(
                                R"({"bufferView":0,"componentType":5126,"count":3,"type":"VEC3"},)",
                                R"({"bufferView":0,"byteOffset":36,"componentType":5123,"count":)",
                                count, R"(,"type":"SCALAR"})")}));
        for (std::size_t i = 0; i < indices.size(); ++i) {
            glb[glb.size() - 12 + 2 * i] = static_cast<char>(indices[i] - '0');
            glb[glb.size() - 11 + 2 * i] = 0;
        }
        return read_text(glb, MeshFormat::glb);
    };
    const auto whole = with_indices("012120", 6);
    ASSERT_TRUE(whole) << describe(whole.error());
    EXPECT_EQ(whole->triangle_count(), 2U);
    for (const std::string_view indices : {"012129", "312120"}) {
        const auto lost = with_indices(indices, 6);
        ASSERT_FALSE(lost) << indices;
        EXPECT_EQ(code_of(lost), ErrorCode::malformed_file);
        EXPECT_NE(lost.error().message.find("vertices that are not there"), std::string::npos)
            << describe(lost.error());
    }
}

/// Meshes that have as many triangles as their primitives are read, whatever these share and leave unused.
TEST_F(GltfDemand, ReadsPrimitivesOfEveryKind)
{
    const auto scene = [](std::string_view primitives) {
        return glb_of(json_of(
            {.primitives = std::string(primitives),
             .accessors = R"({"bufferView":0,"componentType":5126,"count":4,"type":"VEC3"},)"
                          R"({"bufferView":0,"byteOffset":36,"componentType":5123,"count":3,)"
                          R"("type":"SCALAR"})"}));
    };
    struct Kind {
        std::string_view primitives;
        std::size_t triangles;
    };
    // The indices are three zeros, with a vertex to spare: positions and indices overlap.
    for (
        const Kind& kind : {
            Kind{R"({"attributes":{"POSITION":0},"indices":1})", 1},
            Kind{
                R"({"attributes":{"POSITION":0},"indices":1},{"attributes":{"POSITION":0},"mode":5})",
                3},
            Kind{R"({"attributes":{"POSITION":0},"mode":6})", 2},
            Kind{
                R"({"attributes":{"POSITION":0},"indices":1},{"attributes":{"POSITION":0},"mode":0})",
                1},
            Kind{
                R"({"attributes":{"POSITION":0},"indices":1},{"attributes":{"POSITION":0},"mode":3})",
                1},
        }) {
        const auto mesh = read_text(scene(kind.primitives), MeshFormat::glb);
        ASSERT_TRUE(mesh) << kind.primitives << describe(mesh.error());
        EXPECT_EQ(mesh->triangle_count(), kind.triangles) << kind.primitives;
    }
}

TEST_F(GltfDemand, SkipsAByteOrderMarkAndTellsOfBytesOfTheFile)
{
    const std::string mark = "\xEF\xBB\xBF";
    const auto where = [](const std::string& text) {
        return error_of(text, MeshFormat::gltf).where;
    };
    EXPECT_NE(where("{\"asset\":x}").find("byte 9"), std::string::npos);
    EXPECT_NE(where(mark + "{\"asset\":x}").find("byte 12"), std::string::npos);
    const std::string json =
        R"({"asset":{"version":"2.0"},"scene":0,"scenes":[{"nodes":[0]}],"nodes":[{"mesh":0}],)"
        R"("meshes":[{"primitives":[{"attributes":{"POSITION":0}}]}],)"
        R"("buffers":[{"byteLength":36,"uri":"data:application/octet-stream;base64,)" +
        std::string(48, 'A') +
        R"("}],"bufferViews":[{"buffer":0,"byteLength":36}],)"
        R"("accessors":[{"bufferView":0,"componentType":5126,"count":3,"type":"VEC3"}]})";
    const auto mesh = read_text(mark + json, MeshFormat::gltf);
    ASSERT_TRUE(mesh) << describe(mesh.error());
    EXPECT_EQ(mesh->triangle_count(), 1U);
}

TEST_F(GltfDemand, RefusesDracoDataThatAssimpDoesNotRead)
{
    const std::string draco =
        R"({"attributes":{"POSITION":0},"indices":1,)"
        R"("extensions":{"KHR_draco_mesh_compression":{"bufferView":0,"attributes":{}}}})";
    const Error error =
        error_of_scene({.primitives = draco,
                        .accessors = R"({"componentType":5126,"count":3,"type":"VEC3"},)"
                                     R"({"componentType":5125,"count":3,"type":"SCALAR"})"});
    EXPECT_EQ(error.code, ErrorCode::unsupported_format) << describe(error);
    EXPECT_NE(error.message.find("without Draco"), std::string::npos) << describe(error);
}

TEST_F(GltfDemand, RefusesScenesThatWouldOverflowTheStack)
{
    std::string chain;
    for (int i = 1; i <= 2000; ++i) chain += concat(R"({"children":[)", i, "]},");
    EXPECT_EQ(error_of_scene({.nodes = chain + R"({"mesh":0})"}).code, ErrorCode::limit_exceeded);
    EXPECT_EQ(error_of_scene({.nodes = R"({"children":[1]},{"children":[0]})"}).code,
              ErrorCode::malformed_file);
    const std::string nested = std::string(100000, '[') + std::string(100000, ']');
    const Error error = error_of_scene({.more = R"(,"extras":)" + nested});
    EXPECT_EQ(error.code, ErrorCode::malformed_file);
    EXPECT_EQ(error.message.find("assimp"), std::string::npos) << error.message;
}

} // namespace
} // namespace proxima::gltf_demand_test
