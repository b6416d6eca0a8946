// The settings that panels offer, independent of the user interface: a window draws widgets, the
// command line takes --set NAME=VALUE, and tests set values directly. A name has the same meaning
// in all of them.
//
//     void CullingPanel::offer(Controls& controls) {
//         controls.number("field of view", degrees_, 5.0, 120.0);
//         choose(controls, "mode", mode_, {"conservative", "exact"});
//         const OfferedIf with_plane(controls, "cut plane=on", cut_);
//         controls.number("cut at", cut_at_, -1.0, 1.0);
//     }
#pragma once

#include <array>
#include <cstddef>
#include <span>
#include <string>
#include <string_view>
#include <type_traits>

namespace proxima {

class Controls {
public:
    Controls() = default;
    Controls(const Controls&) = delete;
    Controls& operator=(const Controls&) = delete;
    virtual ~Controls() = default;

    /// Each returns true if the person has changed the value since the last call. Values stay in
    /// their range.
    virtual bool toggle(std::string_view name, bool& value) = 0;
    virtual bool number(std::string_view name, int& value, int least, int most) = 0;
    virtual bool number(std::string_view name, double& value, double least, double most) = 0;
    virtual bool choice(std::string_view name, std::size_t& value,
                        std::span<const std::string_view> words) = 0;
    /// One line of text. It counts as changed when editing ends, not at every key.
    virtual bool text(std::string_view name, std::string& value) = 0;
    /// True if it was pressed since the last call.
    virtual bool button(std::string_view name) = 0;

    /// What is offered from here to end_condition() has an effect only under a condition, in the
    /// words of a person: "cut plane=on". Where it is not met no value changes. Conditions do not
    /// nest.
    virtual void begin_condition(std::string_view words, bool is_met) = 0;
    virtual void end_condition() = 0;
};

/// A condition for what is offered in this scope.
class OfferedIf {
public:
    OfferedIf(Controls& controls, std::string_view words, bool is_met) : controls_(controls)
    {
        controls_.begin_condition(words, is_met);
    }
    OfferedIf(const OfferedIf&) = delete;
    OfferedIf& operator=(const OfferedIf&) = delete;
    ~OfferedIf() { controls_.end_condition(); }

private:
    Controls& controls_;
};

/// A choice between the values 0, 1, ... of an enum.
template <class Enum, std::size_t N>
bool choose(Controls& controls, std::string_view name, Enum& value,
            const std::array<std::string_view, N>& words)
{
    static_assert(std::is_enum_v<Enum>);
    auto number = static_cast<std::size_t>(value);
    if (!controls.choice(name, number, words)) return false;
    value = static_cast<Enum>(number);
    return true;
}

} // namespace proxima
