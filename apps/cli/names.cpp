#include "cli/names.h"

#include <algorithm>
#include <charconv>

namespace proxima {

namespace {

std::optional<int> parse_number(std::string_view text)
{
    int value = 0;
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
    if (error != std::errc{} || end != text.data() + text.size()) return std::nullopt;
    return value;
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
    numbers.erase(std::ranges::unique(numbers).begin(), numbers.end());
    return numbers;
}

} // namespace proxima
