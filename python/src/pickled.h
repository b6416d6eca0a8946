// What has a file format as the bytes of its file, for pickle.
#pragma once

#include "proxima/function_ref.h"

#include <cstddef>
#include <filesystem>
#include <memory>
#include <pybind11/pybind11.h>
#include <span>

namespace proxima::python {

namespace py = pybind11;

/// The bytes of the file that save(path) writes in a temporary folder.
[[nodiscard]] py::bytes bytes_of_file(FunctionRef<void(const std::filesystem::path&)> save);

/// A copy of a file's bytes, aligned as the library's loaders want it.
struct FileBytes {
    std::span<const std::byte> bytes;
    std::shared_ptr<const void> storage;
};
[[nodiscard]] FileBytes file_bytes_of(const py::bytes& pickled);

} // namespace proxima::python
