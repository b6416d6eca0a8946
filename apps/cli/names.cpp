#include "cli/names.h"

#include "base/file_extension.h"
#include "base/text.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstdint>
#include <filesystem>
#include <system_error>

namespace proxima {

namespace {

std::optional<int> parse_number(std::string_view text)
{
    int value = 0;
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
    if (error != std::errc{} || end != text.data() + text.size()) return std::nullopt;
    return value;
}

/// Letters to insert, drop, replace or swap with the next one, to make one word of the other.
std::size_t edits_between(std::string_view a, std::string_view b)
{
    std::vector<std::vector<std::size_t>> edits(a.size() + 1,
                                                std::vector<std::size_t>(b.size() + 1));
    for (std::size_t i = 0; i <= a.size(); ++i) {
        for (std::size_t j = 0; j <= b.size(); ++j) {
            if (i == 0 || j == 0) {
                edits[i][j] = i + j;
                continue;
            }
            const std::size_t replaced = edits[i - 1][j - 1] + (a[i - 1] == b[j - 1] ? 0 : 1);
            edits[i][j] = std::min({replaced, edits[i - 1][j] + 1, edits[i][j - 1] + 1});
            if (i > 1 && j > 1 && a[i - 1] == b[j - 2] && a[i - 2] == b[j - 1])
                edits[i][j] = std::min(edits[i][j], edits[i - 2][j - 2] + 1);
        }
    }
    return edits[a.size()][b.size()];
}

} // namespace

std::string_view method_name(OverlapMethod method) noexcept
{
    switch (method) {
    case OverlapMethod::fast:
        return "fast";
    case OverlapMethod::index_tracking:
        return "index-tracking";
    case OverlapMethod::minkowski:
        return "minkowski";
    case OverlapMethod::separating_axis:
        return "separating-axis";
    case OverlapMethod::pairwise:
        return "pairwise";
    }
    return "";
}

std::optional<OverlapMethod> find_method(std::string_view name) noexcept
{
    const auto* const found = std::ranges::find(all_methods, name, method_name);
    return found == all_methods.end() ? std::nullopt : std::optional(*found);
}

std::string method_names()
{
    std::string names;
    for (const OverlapMethod method : all_methods) {
        if (!names.empty()) names += ", ";
        names += method_name(method);
    }
    return names;
}

std::vector<std::string> split_list(std::string_view text)
{
    std::vector<std::string> parts;
    while (true) {
        const std::size_t comma = text.find(',');
        parts.emplace_back(text.substr(0, comma));
        if (comma == std::string_view::npos) return parts;
        text.remove_prefix(comma + 1);
    }
}

std::optional<std::vector<int>> parse_numbers(std::string_view text, int lowest, int highest)
{
    std::vector<int> numbers;
    for (const std::string& part : split_list(text)) {
        const std::string_view range = part;
        const std::size_t dash = range.find('-');
        const auto first = parse_number(range.substr(0, dash));
        const auto last =
            dash == std::string_view::npos ? first : parse_number(range.substr(dash + 1));
        if (!first || !last || *first > *last || *first < lowest || *last > highest) {
            return std::nullopt;
        }
        for (int number = *first; number <= *last; ++number) numbers.push_back(number);
    }
    std::ranges::sort(numbers);
    numbers.erase(std::unique(numbers.begin(), numbers.end()), numbers.end());
    return numbers;
}

std::optional<std::uint64_t> parse_whole(std::string_view text)
{
    std::uint64_t number = 0;
    const char* const last = text.data() + text.size();
    const auto [end, error] = std::from_chars(text.data(), last, number);
    if (error != std::errc() || end != last) return std::nullopt;
    return number;
}

std::optional<std::vector<double>> parse_finite_numbers(std::string_view text)
{
    std::vector<double> numbers;
    for (const std::string& part : split_list(text)) {
        const char* const end = part.data() + part.size();
        double number = 0;
        const auto parsed = std::from_chars(part.data(), end, number);
        if (parsed.ec != std::errc{} || parsed.ptr != end || !std::isfinite(number))
            return std::nullopt;
        numbers.push_back(number);
    }
    return numbers;
}

std::string similar_word(std::string_view text, const std::vector<std::string>& words)
{
    constexpr std::size_t longest = 64;
    if (text.size() > longest) return {};
    std::size_t fewest = 1 + text.size() / 4;
    std::string best;
    for (const std::string& word : words) {
        const std::size_t edits = edits_between(text, word);
        // A word begun and not finished, too.
        const bool is_start = text.size() > 2 && word.starts_with(text);
        if (edits > fewest && !is_start) continue;
        if (!best.empty() && edits >= edits_between(text, best)) continue;
        best = word;
    }
    return best;
}

Status check_extension(const std::string& path, std::string_view extension)
{
    std::error_code error;
    if (path.empty() || std::filesystem::is_character_file(path, error) ||
        lower_case_extension(path) == extension)
        return {};
    return fail(ErrorCode::unsupported_format,
                concat("would not be opened again: give it a name that ends in ", extension), path);
}

} // namespace proxima
