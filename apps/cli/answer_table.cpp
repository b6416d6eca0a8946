#include "cli/answer_table.h"

#include "base/file_extension.h"
#include "cli/npy_header.h"

#include <array>
#include <cmath>
#include <fmt/format.h>
#include <iterator>

namespace proxima {

namespace {

constexpr std::uint64_t columns_without_signs = 8;
constexpr std::uint64_t columns_of_signs = 2;

void append_csv(fmt::memory_buffer& text, std::uint64_t index, const ClosestFeature& answer)
{
    fmt::format_to(std::back_inserter(text), "{},{:.17g},{:.17g},{:.17g},{:.17g},{},{},{}", index,
                   std::sqrt(answer.squared_distance), answer.point.x(), answer.point.y(),
                   answer.point.z(), static_cast<std::uint32_t>(answer.triangle),
                   kind_name(answer.feature.kind), answer.feature.id);
}

void append_csv(fmt::memory_buffer& text, const SignedDistance& sign)
{
    fmt::format_to(std::back_inserter(text), ",{:.17g},{}", sign.distance, name_of(sign.method));
}

void append_numbers(fmt::memory_buffer& bytes, std::span<const double> numbers)
{
    const auto raw = std::as_bytes(numbers);
    bytes.append(reinterpret_cast<const char*>(raw.data()),
                 reinterpret_cast<const char*>(raw.data()) + raw.size());
}

void append_npy(fmt::memory_buffer& bytes, std::uint64_t index, const ClosestFeature& answer)
{
    const std::array<double, columns_without_signs> row = {
        static_cast<double>(index),
        std::sqrt(answer.squared_distance),
        answer.point.x(),
        answer.point.y(),
        answer.point.z(),
        static_cast<double>(static_cast<std::uint32_t>(answer.triangle)),
        static_cast<double>(answer.feature.kind),
        static_cast<double>(answer.feature.id)};
    append_numbers(bytes, row);
}

void append_npy(fmt::memory_buffer& bytes, const SignedDistance& sign)
{
    const std::array<double, columns_of_signs> row = {sign.distance,
                                                      static_cast<double>(sign.method)};
    append_numbers(bytes, row);
}

} // namespace

Result<AnswerFormat> answer_format(const std::string& path)
{
    const std::string extension = lower_case_extension(path);
    if (path == "-" || extension == ".csv") return AnswerFormat::csv;
    if (extension == ".npy") return AnswerFormat::npy;
    return fail(ErrorCode::unsupported_format,
                "unknown extension: answers are .csv or .npy, or - for CSV to stdout", path);
}

std::string answer_header(AnswerFormat format, AnswerSigns signs, std::uint64_t rows)
{
    const bool has_signs = signs == AnswerSigns::present;
    if (format == AnswerFormat::npy)
        return npy_header(rows, columns_without_signs + (has_signs ? columns_of_signs : 0));
    return fmt::format("index,distance,x,y,z,triangle,kind,feature{}\n",
                       has_signs ? ",signed_distance,sign_method" : "");
}

std::string answer_rows(AnswerFormat format, std::uint64_t first,
                        std::span<const ClosestFeature> answers,
                        std::span<const SignedDistance> signs)
{
    fmt::memory_buffer text;
    for (std::size_t i = 0; i < answers.size(); ++i) {
        if (format == AnswerFormat::npy) {
            append_npy(text, first + i, answers[i]);
            if (!signs.empty()) append_npy(text, signs[i]);
        } else {
            append_csv(text, first + i, answers[i]);
            if (!signs.empty()) append_csv(text, signs[i]);
            text.push_back('\n');
        }
    }
    return fmt::to_string(text);
}

std::string_view kind_name(FeatureKind kind) noexcept
{
    switch (kind) {
    case FeatureKind::vertex:
        return "vertex";
    case FeatureKind::edge:
        return "edge";
    case FeatureKind::face:
        break;
    }
    return "face";
}

} // namespace proxima
