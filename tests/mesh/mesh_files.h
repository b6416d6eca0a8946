// Mesh data for the tests of reading and writing: from text, and the small files that also seed the
// fuzzers.
#pragma once

#include "folder_test.h"
#include "proxima/mesh_io.h"

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <gtest/gtest.h>
#include <iterator>
#include <string>
#include <string_view>
#include <vector>

namespace proxima {

inline Result<TriangleMesh> read_text(std::string_view text, MeshFormat format,
                                      const ReadOptions& options = {})
{
    return read_mesh_from_memory(std::as_bytes(std::span(text)), format, options);
}

/// The error of data that must not be read.
inline Error error_of(std::string_view text, MeshFormat format, const ReadOptions& options = {})
{
    const auto mesh = read_text(text, format, options);
    EXPECT_FALSE(mesh) << "was read: " << text.substr(0, 200);
    return mesh ? Error{} : mesh.error();
}

inline std::string file_content(const std::filesystem::path& path)
{
    std::ifstream file(path, std::ios::binary);
    return {std::istreambuf_iterator<char>(file), {}};
}

/// Whether this build reads 3DS, glTF and GLB.
#ifdef PROXIMA_WITH_ASSIMP
inline constexpr bool reads_scenes = true;
#else
inline constexpr bool reads_scenes = false;
#endif

struct SeedFile {
    std::string name;
    MeshFormat format{};
    std::string content;
};

/// All seeds of formats that this build reads, by name.
inline std::vector<SeedFile> seed_files()
{
    std::vector<SeedFile> seeds;
    const std::filesystem::path folder =
        std::filesystem::path(PROXIMA_SOURCE_DIR) / "fuzz" / "corpus";
    for (const auto& entry : std::filesystem::recursive_directory_iterator(folder)) {
        const auto format = format_of_path(entry.path());
        if (!entry.is_regular_file() || !format) continue;
        if (!reads_scenes && *format >= MeshFormat::three_ds) continue;
        seeds.push_back({entry.path().lexically_relative(folder).string(), *format,
                         file_content(entry.path())});
    }
    std::ranges::sort(seeds, {}, &SeedFile::name);
    EXPECT_GE(seeds.size(), 17U);
    return seeds;
}

} // namespace proxima
