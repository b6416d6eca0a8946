// What is shown as binary glTF, for other programs.
#pragma once

#include "proxima/execution.h"
#include "proxima/result.h"
#include "viewer/scene.h"

#include <filesystem>

namespace proxima {

/// Surfaces and lines of the scene, a node each, by their names, as opaque as they are drawn.
/// Errors as write_glb: limit_exceeded, file_not_writable, cancelled.
[[nodiscard]] Status export_scene(const DrawnScene& scene, const std::filesystem::path& path,
                                  Progress* progress = nullptr);

} // namespace proxima
