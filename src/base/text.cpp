#include "base/text.h"

#include <charconv>

namespace proxima {

namespace {

struct Appender {
    std::string& text;

    void operator()(std::string_view part) const { text += part; }
    void operator()(bool part) const { text += part ? "true" : "false"; }
    void operator()(char part) const { text += part; }
    template <class Number>
    void operator()(Number part) const
    {
        std::array<char, 32> buffer{}; // -1.7976931348623157e+308 has 24
        text.append(buffer.data(),
                    std::to_chars(buffer.data(), buffer.data() + buffer.size(), part).ptr);
    }
};

} // namespace

std::string join_parts(std::span<const TextPart> parts)
{
    std::string text;
    for (const TextPart& part : parts) std::visit(Appender{text}, part);
    return text;
}

} // namespace proxima
