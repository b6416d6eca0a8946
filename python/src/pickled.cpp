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
        py::module_::import("os").attr("path").attr("join")(folder.attr("name"), "pickled");
    save(path.cast<std::filesystem::path>());
    const py::object file = py::module_::import("io").attr("FileIO")(path);
    py::bytes bytes = file.attr("readall")();
    file.attr("close")();
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
