// Answers of proxima closest as files: a row per point, as CSV or as NumPy's .npy.
//
//     index,distance,x,y,z,triangle,kind,feature[,signed_distance,sign_method]
//     0,0.5,1,0.25,0,7,edge,11[,-0.5,pseudonormal]
//
// In .npy all columns are float64; kind is 0 (vertex), 1 (edge), 2 (face), sign_method 0
// (on_surface), 1 (pseudonormal), 2 (winding_number).
#pragma once

#include "proxima/closest_feature.h"
#include "proxima/result.h"
#include "proxima/signed_distance.h"

#include <cstdint>
#include <fmt/format.h>
#include <optional>
#include <span>
#include <string>
#include <string_view>

namespace proxima {

enum class AnswerFormat : std::uint8_t { csv, npy };

/// Whether answers have the two columns of signs.
enum class AnswerSigns : std::uint8_t { absent, present };

/// By extension; "-" is CSV. Error unsupported_format.
[[nodiscard]] Result<AnswerFormat> answer_format(const std::string& path);

/// The header line, or the header of .npy for `rows` answers.
[[nodiscard]] std::string answer_header(AnswerFormat format, AnswerSigns signs, std::uint64_t rows);

/// One row. Its ids may have 64 bits; .npy holds them exactly up to 2^53.
struct AnswerRow {
    std::uint64_t index = 0;
    double distance = 0;
    Vec3 point = Vec3::Zero();
    std::uint64_t triangle = 0;
    FeatureKind kind = FeatureKind::vertex;
    std::uint64_t feature = 0;

    struct Sign {
        double distance = 0;
        SignMethod method = SignMethod::on_surface;
    };
    std::optional<Sign> sign = {};
};

/// Numbers of CSV have 17 significant digits.
void append_answer(fmt::memory_buffer& text, AnswerFormat format, const AnswerRow& row);

/// The rows of answers that begin with number `first`.
/// \pre as many signs as answers, or none
[[nodiscard]] std::string answer_rows(AnswerFormat format, std::uint64_t first,
                                      std::span<const ClosestFeature> answers,
                                      std::span<const SignedDistance> signs);

/// "vertex", "edge", "face".
[[nodiscard]] std::string_view kind_name(FeatureKind kind) noexcept;

} // namespace proxima
