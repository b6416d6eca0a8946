// --only LIST: some of what is numbered as in the thesis.
#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace CLI {
class App;
}

namespace proxima {

class OnlyOption {
public:
    /// `what` is one of them in a word: "table".
    OnlyOption(std::string_view what, std::vector<std::string_view> numbers)
        : what_(what), numbers_(std::move(numbers))
    {}

    /// An unknown number is wrong usage, and the message names those there are. \pre *this outlives
    /// the parser's run
    void add_to(CLI::App& parser);

    /// Whether it was named; all are, where none was.
    [[nodiscard]] bool wants(std::string_view number) const;

private:
    std::string_view what_;
    std::vector<std::string_view> numbers_;
    std::vector<std::string> wanted_;
};

} // namespace proxima
