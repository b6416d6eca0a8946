// Headers of NumPy's .npy files: what stands before the numbers.
//
//     \x93NUMPY | version 2 | length 2 or 4 | {'descr': '<f8', 'fortran_order': False, 'shape': ...
#pragma once

#include "proxima/result.h"

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>

namespace proxima {

enum class NpyOrder : std::uint8_t { rows_first, columns_first };

/// A table of little-endian floats.
struct NpyHeader {
    std::size_t bytes_per_number = 8; ///< 4 or 8
    NpyOrder order = NpyOrder::rows_first;
    std::uint64_t rows = 0;
    std::uint64_t columns = 0;
    std::size_t length = 0; ///< of the header: numbers begin after it
};

/// More than any header of a table takes.
inline constexpr std::size_t max_npy_header = 4096;

/// Reads the header that `bytes` begins with: the first max_npy_header bytes of a file, or all of
/// it. Errors: malformed_file, unsupported_format (not float32 or float64, big-endian, not two
/// dimensions); `where` stays empty.
[[nodiscard]] Result<NpyHeader> parse_npy_header(std::string_view bytes);

/// The header of a table of float64, rows first; its length is a multiple of 64.
[[nodiscard]] std::string npy_header(std::uint64_t rows, std::uint64_t columns);

} // namespace proxima
