#include "pickled.h"

#include <cstdlib>
#include <cstring>
#include <new>
#include <pybind11/stl/filesystem.h>
#include <string_view>

namespace proxima::python {

py::bytes bytes_of_file(FunctionRef<void(const std::filesystem::path&)> save)
{
    const py::object folder = py::module_::import("tempfile").attr("TemporaryDirectory")();
    const py::object path =
        py::module_::import("pathlib").attr("Path")(folder.attr("name"), "pickled");
    py::bytes bytes;
    try {
        save(path.cast<std::filesystem::path>());
        bytes = path.attr("read_bytes")();
    } catch (...) {
        folder.attr("cleanup")();
        throw;
    }
    folder.attr("cleanup")();
    return bytes;
}

FileBytes file_bytes_of(const py::bytes& pickled)
{
    const std::string_view content = pickled;
    constexpr std::size_t alignment = 128;
    const std::size_t size = (content.size() + alignment - 1) / alignment * alignment;
    const std::shared_ptr<void> storage(std::aligned_alloc(alignment, size), std::free);
    if (storage == nullptr) throw std::bad_alloc();
    std::memcpy(storage.get(), content.data(), content.size());
    return {{static_cast<const std::byte*>(storage.get()), content.size()}, storage};
}

} // namespace proxima::python
