// The files of a scene as assimp sees them: the scene itself, which is in memory, and those beside
// it that it refers to. A glTF may come from anywhere, and names files as it likes.
//
//     scene.gltf, "uri": "parts/buffer.bin"    below the scene's folder: read
//     "a%20b.bin"                              "a b.bin"; where that is absent, the name as it is
//     "/etc/passwd", "../x", a link to there   refused, "%2e%2e/x" and "a%2fb" too
//     a pipe, a device, a folder               refused, not waited for
#pragma once

#include "base/input_file.h"
#include "mesh/io/mesh_source.h"

#include <assimp/IOSystem.hpp>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>

namespace proxima::detail {

class SceneFiles final : public Assimp::IOSystem {
public:
    /// `folder` is empty for a scene in memory, which may not refer to files. `source` must live as
    /// long as this. All files together may take the budget.
    SceneFiles(const MeshSource& source, std::string scene_name, std::filesystem::path folder,
               MemoryBudget budget);

    [[nodiscard]] bool Exists(const char* name) const override;
    [[nodiscard]] char getOsSeparator() const override { return '/'; }
    Assimp::IOStream* Open(const char* name, const char* mode) override;
    void Close(Assimp::IOStream* stream) override;

    /// Why the last file that assimp asked for was not opened; nothing where all were.
    [[nodiscard]] const std::optional<Error>& error() const noexcept { return error_; }

private:
    [[nodiscard]] Result<std::filesystem::path> find(const std::string& uri) const;
    [[nodiscard]] Result<std::filesystem::path> find_file(const std::string& name) const;

    const MeshSource& source_;
    std::string scene_name_;
    std::filesystem::path folder_;
    std::uint64_t bytes_left_;
    std::optional<Error> error_;
};

} // namespace proxima::detail
