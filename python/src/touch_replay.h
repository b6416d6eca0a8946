// Recorded sessions of touching, felt again.
#pragma once

#include <filesystem>
#include <pybind11/pybind11.h>

namespace proxima::python {

/// TouchRenderer.replay().
[[nodiscard]] pybind11::object replay(const std::filesystem::path& path,
                                      const pybind11::object& model,
                                      const pybind11::object& progress);

} // namespace proxima::python
