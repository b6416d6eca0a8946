#include "cli/answer_table.h"

#include "base/file_extension.h"
#include "cli/npy_header.h"
#include "cli/row_text.h"

#include <array>
#include <cmath>
#include <iterator>

namespace proxima {

namespace {

constexpr std::uint64_t columns_without_signs = 8;
constexpr std::uint64_t columns_of_signs = 2;

void append_csv(fmt::memory_buffer& text, const AnswerRow& row)
{
    fmt::format_to(std::back_inserter(text), "{},{:.17g},{:.17g},{:.17g},{:.17g},{},{},{}",
                   row.index, row.distance, row.point.x(), row.point.y(), row.point.z(),
                   row.triangle, kind_name(row.kind), row.feature);
    if (row.sign) {
        fmt::format_to(std::back_inserter(text), ",{:.17g},{}", row.sign->distance,
                       name_of(row.sign->method));
    }
    text.push_back('\n');
}

void append_npy(fmt::memory_buffer& bytes, const AnswerRow& row)
{
    const std::array<double, columns_without_signs> answer = {static_cast<double>(row.index),
                                                              row.distance,
                                                              row.point.x(),
                                                              row.point.y(),
                                                              row.point.z(),
                                                              static_cast<double>(row.triangle),
                                                              static_cast<double>(row.kind),
                                                              static_cast<double>(row.feature)};
    append_row(bytes, AnswerFormat::npy, answer);
    if (!row.sign) return;
    const std::array<double, columns_of_signs> sign = {row.sign->distance,
                                                       static_cast<double>(row.sign->method)};
    append_row(bytes, AnswerFormat::npy, sign);
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
        const ClosestFeature& answer = answers[i];
        AnswerRow row{first + i,           std::sqrt(answer.squared_distance),
                      answer.point,        to_index(answer.triangle),
                      answer.feature.kind, answer.feature.id};
        if (!signs.empty()) row.sign = {signs[i].distance, signs[i].method};
        append_answer(text, format, row);
    }
    return fmt::to_string(text);
}

void append_answer(fmt::memory_buffer& text, AnswerFormat format, const AnswerRow& row)
{
    if (format == AnswerFormat::npy) {
        append_npy(text, row);
    } else {
        append_csv(text, row);
    }
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
