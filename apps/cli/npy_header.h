// Headers of NumPy's .npy files: what stands before the numbers.
//
//     \x93NUMPY | version 2 | length 2 or 4 | {'descr': '<f8', 'fortran_order': False, 'shape': ...
#pragma once

#include "proxima/result.h"

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace proxima {

enum class NpyOrder : std::uint8_t { rows_first, columns_first };
enum class NpyKind : std::uint8_t { real, signed_whole, unsigned_whole };

/// What an array is.
struct NpyHeader {
    NpyKind kind = NpyKind::real;
    std::size_t bytes_per_number = 8; ///< 2, 4 or 8; whole numbers also 1
    bool big_endian = false;
    NpyOrder order = NpyOrder::rows_first;
    std::vector<std::uint64_t> shape; ///< one to four numbers
    std::size_t length = 0;           ///< of the header: numbers begin after it
};

/// More than any header of an array takes.
inline constexpr std::size_t max_npy_header = 4096;

/// Whether a file that begins so is one of NumPy's arrays.
[[nodiscard]] bool is_npy(std::string_view bytes) noexcept;

/// Reads the header that `bytes` begins with: the first max_npy_header bytes of a file, or all of
/// it. Errors: malformed_file, unsupported_format (other numbers, more dimensions); `where` stays
/// empty.
[[nodiscard]] Result<NpyHeader> parse_npy_header(std::string_view bytes);

/// The number that begins at `bytes`.
[[nodiscard]] double npy_number(const NpyHeader& header, const char* bytes) noexcept;

/// The header of an array of float64; its length is a multiple of 64.
[[nodiscard]] std::string npy_header(std::span<const std::uint64_t> shape, NpyOrder order);

/// That of a table, rows first.
[[nodiscard]] std::string npy_header(std::uint64_t rows, std::uint64_t columns);

} // namespace proxima
