// A whole file as an array of bytes, read by the system when they are touched.
#pragma once

#include "proxima/result.h"

#include <cstddef>
#include <filesystem>
#include <span>
#include <utility>

namespace proxima {

/// A read-only private memory map, aligned to a page. Another process that shortens the file while
/// it is mapped makes reads beyond its end fatal (SIGBUS).
class MappedFile {
public:
    /// Error file_not_found with the system's reason; also for what is no regular file.
    [[nodiscard]] static Result<MappedFile> open(const std::filesystem::path& path);

    MappedFile(MappedFile&& other) noexcept : bytes_(std::exchange(other.bytes_, {})) {}
    MappedFile& operator=(MappedFile&& other) noexcept
    {
        std::swap(bytes_, other.bytes_);
        return *this;
    }
    MappedFile(const MappedFile&) = delete;
    MappedFile& operator=(const MappedFile&) = delete;
    ~MappedFile();

    [[nodiscard]] std::span<const std::byte> bytes() const noexcept { return bytes_; }

private:
    explicit MappedFile(std::span<const std::byte> bytes) noexcept : bytes_(bytes) {}
    std::span<const std::byte> bytes_;
};

} // namespace proxima
