// What the library answers about the whole mesh, on one process, for --verify.
#pragma once

#include "proxima/mesh_index.h"
#include "proxima/result.h"

#include <bit>
#include <cstdint>
#include <string>
#include <string_view>

namespace proxima {

[[nodiscard]] inline bool is_same(double a, double b) noexcept
{
    return std::bit_cast<std::uint64_t>(a) == std::bit_cast<std::uint64_t>(b);
}

/// The error of an answer that is not the library's: of "the feature" of "point" 7, say.
[[nodiscard]] tl::unexpected<Error> answer_differs(std::string_view what, std::string_view question,
                                                   std::uint64_t row);

/// The index of a whole model.
[[nodiscard]] Result<MeshIndex> index_of_whole(const std::string& model);

} // namespace proxima
