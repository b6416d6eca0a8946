// The XML files of VTK with raw binary arrays behind the text.
//
//     <VTKFile ...> ... <DataArray ... format="appended" offset="0"/> ... <AppendedData>_
//     8 bytes: size, array 0 | 8 bytes: size, array 1 | ... </AppendedData></VTKFile>
#pragma once

#include "base/output_file.h"
#include "proxima/result.h"

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <vector>

namespace proxima {

/// Collects arrays and the text that refers to them, then writes both.
class VtkXml {
public:
    /// `type` names the data set, for example "UnstructuredGrid".
    VtkXml(const std::string& type, const std::string& version);

    void text(const std::string& markup) { text_ += markup; }

    /// A DataArray element; `bytes` must live until write(). `attributes` goes into the element.
    void array(const std::string& type, const std::string& attributes,
               std::span<const std::byte> bytes);

    /// Errors: file_not_writable, cancelled.
    [[nodiscard]] Status write(const std::filesystem::path& path, Progress* progress) const;

private:
    std::string text_;
    std::vector<std::span<const std::byte>> arrays_;
    std::uint64_t offset_ = 0;
};

} // namespace proxima
