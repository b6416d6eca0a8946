// Everything in this layer that takes long stops when asked to, and leaves nothing behind.
#include "cancellation.h"
#include "mesh/mesh_files.h"
#include "proxima/mesh_io.h"
#include "proxima/sample_meshes.h"

#include <array>

namespace proxima::cancellation_test {
namespace {

using testing::cancel_at_every_stage;
using testing::files_in;

class Cancellation : public FolderTest {};

/// 79,600 triangles: several megabytes in every format.
const TriangleMesh& large_mesh()
{
    static const TriangleMesh mesh = make_sphere(200, 200);
    return mesh;
}

TEST_F(Cancellation, StopsReadingAtEveryStage)
{
    const struct {
        const char* file;
        WriteOptions options;
    } variants[] = {{"ascii.ply", {.ply = PlyEncoding::ascii}},
                    {"binary.ply", {}},
                    {"mesh.obj", {}},
                    {"mesh.off", {}},
                    {"ascii.stl", {.stl = StlEncoding::ascii}},
                    {"binary.stl", {}}};
    for (const auto& variant : variants) {
        ASSERT_TRUE(write_mesh(large_mesh(), path(variant.file), variant.options));
    }
    const auto before = files_in(path("."));
    for (const auto& file : before) {
        const std::string& name = file.first;
        for (const Weld weld : {Weld::never, Weld::exact_positions}) {
            SCOPED_TRACE(name + (weld == Weld::never ? "" : ", welded"));
            cancel_at_every_stage(
                [&](Progress& progress) {
                    return read_mesh(path(name),
                                     {.weld = weld, .execution = {.progress = &progress}});
                },
                [] { return true; }, weld == Weld::never ? 2 : 3);
        }
    }
}

TEST_F(Cancellation, StopsWritingAtEveryStage)
{
    for (const char* const name : {"a.obj", "a.ply", "a.stl", "a.off"}) {
        SCOPED_TRACE(name);
        std::ofstream(path(name)) << "old";
        const auto before = files_in(path("."));
        cancel_at_every_stage(
            [&](Progress& progress) {
                return write_mesh(large_mesh(), path(name), {.execution = {.progress = &progress}});
            },
            [&] { return files_in(path(".")) == before; }, 4);
    }
}

TEST(CancellationOfSamples, StopsAtEveryStageOfEveryShape)
{
    for (const char* const name :
         {"sphere:100x100", "icosphere:5", "torus:100x100", "spaceship:40000"}) {
        SCOPED_TRACE(name);
        cancel_at_every_stage(
            [&](Progress& progress) {
                return sample_mesh(name, {.execution = {.progress = &progress}});
            },
            [] { return true; }, 3);
    }
}

TEST(CancellationOfSamples, ProgressDoesNotChangeTheMesh)
{
    Progress progress;
    const auto watched = sample_mesh("spaceship:40000", {.execution = {.progress = &progress}});
    const auto alone = sample_mesh("spaceship:40000");
    ASSERT_TRUE(watched && alone);
    EXPECT_TRUE(std::ranges::equal(watched->positions(), alone->positions()));
    EXPECT_TRUE(std::ranges::equal(watched->triangles(), alone->triangles()));
    EXPECT_STREQ(progress.stage(), "making mesh");
    EXPECT_GT(progress.fraction(), 0.8);
}

} // namespace
} // namespace proxima::cancellation_test
