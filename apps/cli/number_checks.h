// Checks of numbers that options take, for the argument parser.
#pragma once

#include <CLI/CLI.hpp>
#include <cctype>
#include <cmath>
#include <fmt/core.h>
#include <string>

namespace proxima {

/// Finite, and 0 or more.
inline CLI::Validator not_negative()
{
    return {[](std::string& text) {
                double value = 0;
                const bool is_number = CLI::detail::lexical_cast(text, value);
                return is_number && value >= 0 && std::isfinite(value)
                           ? std::string()
                           : fmt::format("{} is no number from 0 up", text);
            },
            "NONNEGATIVE"};
}

/// Within the bounds, and so no NaN, which CLI::Range takes.
inline CLI::Validator number_between(double least, double most)
{
    return {[least, most](std::string& text) {
                double value = 0;
                const bool is_number = CLI::detail::lexical_cast(text, value);
                return is_number && value >= least && value <= most
                           ? std::string()
                           : fmt::format("{} is no number from {:g} to {:g}", text, least, most);
            },
            fmt::format("in [{:g} - {:g}]", least, most)};
}

/// For whole numbers: the argument parser would take 010 for eight, and 0x10 for a number.
inline CLI::Validator decimal()
{
    return {[](std::string& text) {
                if (text.find_first_of("xX") != std::string::npos)
                    return fmt::format("{} is no decimal number", text);
                double number = 0; // unlike 1-6, which some options take
                if (CLI::detail::lexical_cast(text, number) &&
                    text.find_first_of(".eEnN") != std::string::npos)
                    return fmt::format("{} is no whole number", text);
                while (text.size() > 1 && text[0] == '0' &&
                       std::isdigit(static_cast<unsigned char>(text[1])) != 0)
                    text.erase(0, 1);
                return std::string();
            },
            ""};
}

} // namespace proxima
