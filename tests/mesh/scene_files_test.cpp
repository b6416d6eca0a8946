// A glTF of several files: what it may refer to.
#include "base/text.h"
#include "code_of.h"
#include "folder_test.h"
#include "mesh/mesh_files.h"

#include <sys/stat.h>

namespace proxima::scene_files_test {
namespace {

namespace fs = std::filesystem;

class SceneFiles : public FolderTest {
protected:
    void SetUp() override
    {
        if (!reads_scenes) GTEST_SKIP() << "built without assimp";
        FolderTest::SetUp();
        const fs::path corpus = fs::path(PROXIMA_SOURCE_DIR) / "fuzz" / "corpus";
        scene = file_content(corpus / "gltf" / "two_tetrahedra.gltf");
        const std::string glb = file_content(corpus / "glb" / "two_tetrahedra.glb");
        buffer = glb.substr(glb.size() - 72);
        fs::create_directories(path("scenes/parts"));
        for (const char* name : {"outside.bin", "scenes/buffer.bin", "scenes/parts/buffer.bin"})
            std::ofstream(path(name), std::ios::binary) << buffer;
    }

    /// The scene with `uri` as its buffer.
    [[nodiscard]] std::string scene_with(const std::string& uri) const
    {
        std::string text = scene;
        const std::size_t begin = text.find("data:");
        text.replace(begin, text.find('"', begin) - begin, uri);
        return text;
    }

    Result<TriangleMesh> read(const std::string& uri, const ReadOptions& options = {})
    {
        std::ofstream(path("scenes/scene.gltf"), std::ios::binary) << scene_with(uri);
        return read_mesh(path("scenes/scene.gltf"), options);
    }

    void expect_refused(const std::string& uri, ErrorCode code, const std::string& why)
    {
        const auto mesh = read(uri);
        ASSERT_FALSE(mesh) << uri;
        EXPECT_EQ(code_of(mesh), code) << uri;
        EXPECT_NE(mesh.error().message.find(why), std::string::npos) << describe(mesh.error());
        EXPECT_EQ(mesh.error().where, path("scenes/scene.gltf").string());
    }

    std::string scene;
    std::string buffer;
};

TEST_F(SceneFiles, AreReadBelowTheFolderOfTheScene)
{
    fs::create_symlink("parts/buffer.bin", path("scenes/link.bin"));
    for (const char* uri :
         {"buffer.bin", "./buffer.bin", "parts/buffer.bin", "parts//./buffer.bin", "link.bin"}) {
        const auto mesh = read(uri);
        ASSERT_TRUE(mesh) << uri << ": " << describe(mesh.error());
        EXPECT_EQ(mesh->triangle_count(), 8U) << uri;
    }
}

TEST_F(SceneFiles, MayHaveAnyName)
{
    // Such as one that the scene itself might have.
    for (const char* const name : {"scene.glb", "scene.3ds", "other.gltf"}) {
        std::ofstream(path("scenes") / name, std::ios::binary) << buffer;
        const auto mesh = read(name);
        ASSERT_TRUE(mesh) << name << ": " << describe(mesh.error());
        EXPECT_EQ(mesh->triangle_count(), 8U) << name;
    }
    std::ofstream(path("scenes/scene.gltf"), std::ios::binary) << buffer;
    std::ofstream(path("scenes/other.gltf"), std::ios::binary) << scene_with("scene.gltf");
    const auto mesh = read_mesh(path("scenes/other.gltf"));
    ASSERT_TRUE(mesh) << describe(mesh.error());
    EXPECT_EQ(mesh->triangle_count(), 8U);
    const auto without = bounding_box(read("buffer.bin").value());
    EXPECT_EQ(bounding_box(*mesh).lower, without.lower);
    EXPECT_EQ(bounding_box(*mesh).upper, without.upper);
}

TEST_F(SceneFiles, MayHaveEncodedNames)
{
    fs::create_directories(path("scenes/all parts"));
    for (const char* name : {"sp ace.bin", "all parts/\u00e4.bin", "50%.bin", "half%20.bin",
                             "%zz.bin", "a%2Fb.bin", "100%25.bin"})
        std::ofstream(path("scenes") / name, std::ios::binary) << buffer;
    for (const char* uri : {"sp%20ace.bin", "sp ace.bin", "all%20parts/%c3%A4.bin", "%62uffer.bin",
                            "50%25.bin", "50%.bin", "half%2520.bin", "half%20.bin", "%zz.bin",
                            "%25zz.bin", "a%2Fb.bin", "100%2525.bin", "100%25.bin"}) {
        const auto mesh = read(uri);
        ASSERT_TRUE(mesh) << uri << ": " << describe(mesh.error());
        EXPECT_EQ(mesh->triangle_count(), 8U) << uri;
    }
}

TEST_F(SceneFiles, AreTheDecodedNameWhereBothExist)
{
    std::ofstream(path("scenes/a b.bin"), std::ios::binary) << buffer;
    std::ofstream(path("scenes/a%20b.bin"), std::ios::binary) << "short";
    EXPECT_TRUE(read("a%20b.bin"));
    EXPECT_FALSE(read("a%2520b.bin"));
}

TEST_F(SceneFiles, AreRefusedElsewhereByEncodedNamesToo)
{
    fs::create_symlink("../outside.bin", path("scenes/sym link.bin"));
    const std::string why = "not below the scene's folder";
    expect_refused("%2e%2e/outside.bin", ErrorCode::malformed_file, why);
    expect_refused("..%2foutside.bin", ErrorCode::malformed_file, "escaped slash");
    expect_refused("%2e%2e%2foutside.bin", ErrorCode::malformed_file, "escaped slash");
    expect_refused("parts%2F..%2Fbuffer.bin", ErrorCode::malformed_file, "escaped slash");
    expect_refused("%2Fetc/passwd", ErrorCode::malformed_file, "escaped slash");
    expect_refused("%2Fdev%2Fzero", ErrorCode::malformed_file, "escaped slash");
    expect_refused("%5c%5Chost", ErrorCode::malformed_file, "escaped slash");
    expect_refused("buffer.bin%00", ErrorCode::malformed_file, "NUL");
    expect_refused("%00", ErrorCode::malformed_file, "NUL");
    expect_refused("sym%20link.bin", ErrorCode::malformed_file, why);
    // Decoded once.
    expect_refused("%252e%252e%252foutside.bin", ErrorCode::file_not_found, "%2e%2e%2foutside.bin");
    expect_refused("%zz", ErrorCode::file_not_found, "%zz");
    expect_refused("%2", ErrorCode::file_not_found, "%2");
    expect_refused("%", ErrorCode::file_not_found, "%");
}

TEST_F(SceneFiles, AreFoundFromTheFolderThatTheProgramRunsIn)
{
    std::ofstream(path("scenes/scene.gltf"), std::ios::binary) << scene_with("buffer.bin");
    const fs::path before = fs::current_path();
    fs::current_path(path("scenes"));
    const auto mesh = read_mesh("scene.gltf");
    fs::current_path(before);
    ASSERT_TRUE(mesh) << describe(mesh.error());
    EXPECT_EQ(mesh->triangle_count(), 8U);
}

TEST_F(SceneFiles, AreRefusedElsewhere)
{
    fs::create_symlink("../outside.bin", path("scenes/link.bin"));
    fs::create_directory_symlink("..", path("scenes/up"));
    const std::string why = "not below the scene's folder";
    expect_refused("../outside.bin", ErrorCode::malformed_file, why);
    expect_refused("parts/../buffer.bin", ErrorCode::malformed_file, why);
    expect_refused(path("scenes/buffer.bin").string(), ErrorCode::malformed_file, why);
    expect_refused("link.bin", ErrorCode::malformed_file, why);
    expect_refused("up/outside.bin", ErrorCode::malformed_file, why);
    expect_refused("/dev/zero", ErrorCode::malformed_file, why);
}

TEST_F(SceneFiles, AreRegularFiles)
{
    ASSERT_EQ(::mkfifo(path("scenes/pipe").c_str(), 0600), 0);
    expect_refused("pipe", ErrorCode::file_not_found, "not a regular file");
    expect_refused("%70ipe", ErrorCode::file_not_found, "not a regular file");
    expect_refused("parts", ErrorCode::file_not_found, "folder");
    expect_refused("missing.bin", ErrorCode::file_not_found, "missing.bin");
}

TEST_F(SceneFiles, FitTheBudget)
{
    fs::resize_file(path("scenes/buffer.bin"), 500'000'000); // a file with a hole
    const auto mesh = read("buffer.bin", {.execution = {.budget = {.bytes = 100'000'000}}});
    ASSERT_FALSE(mesh);
    EXPECT_EQ(code_of(mesh), ErrorCode::budget_exceeded) << describe(mesh.error());
}

TEST_F(SceneFiles, FitTheBudgetTogether)
{
    // Each of two files does; they end in holes.
    fs::resize_file(path("scenes/buffer.bin"), 40'000'000);
    fs::copy_file(path("scenes/buffer.bin"), path("scenes/second.bin"));
    const std::string positions = R"("buffer":0,"byteOffset":24)";
    const std::size_t at = scene.find(positions);
    ASSERT_NE(at, std::string::npos);
    scene.replace(at, 10, R"("buffer":1)");
    const auto read_within = [&](std::uint64_t bytes) {
        return read(R"(buffer.bin"},{"byteLength":72,"uri":"second.bin)",
                    {.execution = {.budget = {.bytes = bytes}}});
    };
    EXPECT_TRUE(read_within(100'000'000));
    const auto mesh = read_within(60'000'000);
    ASSERT_FALSE(mesh);
    EXPECT_EQ(code_of(mesh), ErrorCode::budget_exceeded) << describe(mesh.error());
}

TEST_F(SceneFiles, AreNotForScenesInMemory)
{
    const fs::path before = fs::current_path();
    fs::current_path(path("scenes"));
    const Error error = error_of(scene_with("buffer.bin"), MeshFormat::gltf);
    fs::current_path(before);
    EXPECT_EQ(error.code, ErrorCode::malformed_file);
    EXPECT_NE(error.message.find("by its path"), std::string::npos) << error.message;
}

} // namespace
} // namespace proxima::scene_files_test
