// Reading the same files with our readers and with assimp, by turns in one run.
//
//     PROXIMA_BENCH_MESH=dragon_vrip.ply mesh_io_bench --benchmark_enable_random_interleaving=true
//         --benchmark_repetitions=5
//
// Without the variable a procedural mesh of 871,200 triangles stands in. It is written to every
// format first, so each row reads one mesh: vertices, triangles and a hash of the positions in file
// order are printed, and a faster wrong answer shows. Assimp's are floats, so its hash is its own.
#include "base/text.h"
#include "instruction_set.h"
#include "proxima/mesh_io.h"

#include <assimp/Importer.hpp>
#include <assimp/postprocess.h>
#include <assimp/scene.h>
#include <benchmark/benchmark.h>
#include <bit>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <string>
#include <unistd.h>

namespace {

namespace fs = std::filesystem;
using namespace proxima;

// Order-dependent, so that renumbering shows; 52 bits, so that a counter can hold it.
class Hash {
public:
    void add(double value) noexcept { mix(std::bit_cast<std::uint64_t>(value)); }
    void mix(std::uint64_t bits) noexcept
    {
        value_ = (value_ ^ bits) * 0x9E3779B97F4A7C15U;
        value_ ^= value_ >> 29U;
    }
    [[nodiscard]] double value() const noexcept { return static_cast<double>(value_ >> 12U); }

private:
    std::uint64_t value_ = 0;
};

TriangleMesh bumpy_grid()
{
    constexpr std::uint32_t side = 660;
    std::vector<Vec3> positions;
    std::vector<TriangleCorners> triangles;
    for (std::uint32_t i = 0; i <= side; ++i) {
        for (std::uint32_t j = 0; j <= side; ++j) {
            // Seven digits, as scanned models have.
            const double height = std::round(1e6 * std::sin(0.05 * i) * std::cos(0.03 * j)) / 1e7;
            positions.emplace_back(i / 8192.0, j / 8192.0, height);
        }
    }
    const auto vertex = [](std::uint32_t i, std::uint32_t j) { return i * (side + 1) + j; };
    for (std::uint32_t i = 0; i < side; ++i) {
        for (std::uint32_t j = 0; j < side; ++j) {
            triangles.push_back({vertex(i, j), vertex(i + 1, j), vertex(i + 1, j + 1)});
            triangles.push_back({vertex(i, j), vertex(i + 1, j + 1), vertex(i, j + 1)});
        }
    }
    return *make_triangle_mesh(std::move(positions), std::move(triangles));
}

void read_by_proxima(benchmark::State& state, const fs::path& path)
{
    TriangleMesh mesh;
    for ([[maybe_unused]] auto iteration : state) {
        auto read = read_mesh(path);
        if (!read) {
            state.SkipWithError(describe(read.error()).c_str());
            return;
        }
        mesh = std::move(*read);
        benchmark::ClobberMemory();
    }
    Hash hash;
    for (const Vec3& position : mesh.positions()) {
        for (const double value : position) hash.add(value);
    }
    for (const TriangleCorners& corners : mesh.triangles()) {
        for (const std::uint32_t corner : corners) hash.mix(corner);
    }
    state.counters["vertices"] = static_cast<double>(mesh.vertex_count());
    state.counters["triangles"] = static_cast<double>(mesh.triangle_count());
    state.counters["hash"] = hash.value();
}

// Joined: vertices at one position made one, as our reader of STL does. Assimp joins none whose
// normals differ, so they go first.
enum class AssimpSteps : std::uint8_t { none, joined };

template <AssimpSteps Steps>
void read_by_assimp(benchmark::State& state, const fs::path& path)
{
    double vertices = 0;
    double triangles = 0;
    Hash hash;
    for ([[maybe_unused]] auto iteration : state) {
        Assimp::Importer importer;
        importer.SetPropertyInteger(AI_CONFIG_PP_RVC_FLAGS, aiComponent_NORMALS);
        constexpr unsigned joining = aiProcess_RemoveComponent | aiProcess_JoinIdenticalVertices;
        const aiScene* scene =
            importer.ReadFile(path.string(), Steps == AssimpSteps::joined ? joining : 0);
        if (scene == nullptr) {
            state.SkipWithError(importer.GetErrorString());
            return;
        }
        state.PauseTiming();
        vertices = 0;
        triangles = 0;
        hash = {};
        for (unsigned i = 0; i < scene->mNumMeshes; ++i) {
            const aiMesh& mesh = *scene->mMeshes[i];
            vertices += mesh.mNumVertices;
            triangles += mesh.mNumFaces;
            for (unsigned v = 0; v < mesh.mNumVertices; ++v) {
                for (unsigned axis = 0; axis < 3; ++axis) hash.add(mesh.mVertices[v][axis]);
            }
        }
        state.ResumeTiming();
    }
    state.counters["vertices"] = vertices;
    state.counters["triangles"] = triangles;
    state.counters["hash"] = hash.value();
}

// Removes the files on every way out of main.
struct Folder {
    fs::path path = fs::temp_directory_path() / concat("proxima_mesh_io_bench_", ::getpid());
    Folder() { fs::create_directories(path); }
    Folder(const Folder&) = delete;
    Folder& operator=(const Folder&) = delete;
    ~Folder()
    {
        std::error_code ignored;
        fs::remove_all(path, ignored);
    }
};

void add_rows(const std::string& name, const fs::path& path)
{
    const auto add = [&](const char* reader, void (*read)(benchmark::State&, const fs::path&)) {
        benchmark::RegisterBenchmark(concat(name, "/", reader).c_str(), read, path)
            ->Unit(benchmark::kMillisecond);
    };
    add("proxima", read_by_proxima);
    add("assimp", read_by_assimp<AssimpSteps::none>);
    if (path.extension() == ".stl") add("assimp-joined", read_by_assimp<AssimpSteps::joined>);
}

} // namespace

int main(int argc, char** argv)
{
    benchmark::Initialize(&argc, argv);
    if (!proxima::bench::use_instruction_set_asked_for()) return 2;
    const char* given = std::getenv("PROXIMA_BENCH_MESH");
    TriangleMesh mesh;
    if (given == nullptr) {
        mesh = bumpy_grid();
    } else {
        auto read = read_mesh(given);
        if (!read) {
            (void)std::fprintf(stderr, "%s\n", describe(read.error()).c_str());
            return 1;
        }
        mesh = std::move(*read);
        add_rows("given", given);
    }
    const Folder folder;
    const struct {
        const char* name;
        const char* file;
        WriteOptions options;
    } variants[] = {
        {"ply_ascii", "ascii.ply", {.ply = PlyEncoding::ascii}},
        {"ply_binary", "binary.ply", {}},
        {"obj", "mesh.obj", {}},
        {"stl_ascii", "ascii.stl", {.stl = StlEncoding::ascii}},
        {"stl_binary", "binary.stl", {}},
    };
    for (const auto& variant : variants) {
        const fs::path path = folder.path / variant.file;
        if (auto status = write_mesh(mesh, path, variant.options); !status) {
            (void)std::fprintf(stderr, "%s\n", describe(status.error()).c_str());
            return 1;
        }
        add_rows(variant.name, path);
    }
    benchmark::RunSpecifiedBenchmarks();
    return 0;
}
