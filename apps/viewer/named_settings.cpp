#include "viewer/named_settings.h"

#include "base/text.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <optional>
#include <type_traits>

namespace proxima {
namespace {

std::string joined(std::span<const std::string_view> words)
{
    std::string text;
    for (const std::string_view word : words) text += concat(text.empty() ? "" : ", ", word);
    return text;
}

template <class T>
std::optional<T> parse(std::string_view text)
{
    T value{};
    const char* const end = text.data() + text.size();
    const auto [stopped, error] = std::from_chars(text.data(), end, value);
    if (error != std::errc{} || stopped != end) return std::nullopt;
    return value;
}

using Settings = std::map<std::string, std::string, std::less<>>;

/// Whether values are given to controls, or only compared with what these may have.
enum class SettingUse : std::uint8_t { apply, check };

/// Gives each setting to the control of its name, once.
class SettingControls final : public Controls {
public:
    SettingControls(Settings& settings, SettingUse use) : settings_(settings), use_(use) {}

    bool toggle(std::string_view name, bool& value) override
    {
        const auto text = take(name);
        if (!text) return false;
        if (*text != "on" && *text != "off") return refuse(name, *text, "on or off");
        return give(*text == "on", value);
    }
    bool number(std::string_view name, int& value, int least, int most) override
    {
        return take_number(name, value, least, most);
    }
    bool number(std::string_view name, double& value, double least, double most) override
    {
        return take_number(name, value, least, most);
    }
    bool choice(std::string_view name, std::size_t& value,
                std::span<const std::string_view> words) override
    {
        const auto text = take(name);
        if (!text) return false;
        const auto found = std::ranges::find(words, *text);
        if (found == words.end()) return refuse(name, *text, joined(words));
        return give(static_cast<std::size_t>(found - words.begin()), value);
    }
    bool text(std::string_view name, std::string& value) override
    {
        auto text = take(name);
        if (!text) return false;
        return give(std::move(*text), value);
    }
    bool button(std::string_view name) override
    {
        const auto text = take(name);
        if (!text) return false;
        if (*text != "press") return refuse(name, *text, "press: it is a button");
        return use_ == SettingUse::apply;
    }

    void begin_condition(std::string_view words, bool is_met) override
    {
        unmet_ = is_met ? "" : std::string(words);
    }
    void end_condition() override { unmet_.clear(); }

    /// What a setting needs that no control took although there is one of its name; else empty.
    [[nodiscard]] std::string missing_condition(const std::string& name) const
    {
        const auto found = needed_.find(name);
        return found == needed_.end() ? "" : found->second;
    }
    [[nodiscard]] bool took_any() const noexcept { return took_any_; }
    [[nodiscard]] const std::optional<Error>& error() const noexcept { return error_; }
    [[nodiscard]] const std::string& names() const noexcept { return names_; }

private:
    std::optional<std::string> take(std::string_view name)
    {
        names_ += concat(names_.empty() ? "" : ", ", name);
        const auto found = settings_.find(name);
        if (found == settings_.end()) return std::nullopt;
        if (!unmet_.empty()) {
            needed_[found->first] = unmet_;
            return std::nullopt;
        }
        std::string text = std::move(found->second);
        settings_.erase(found);
        took_any_ = true;
        return text;
    }

    template <class T>
    bool take_number(std::string_view name, T& value, T least, T most)
    {
        const auto text = take(name);
        if (!text) return false;
        const auto number = parse<T>(*text);
        if (!number || !(*number >= least && *number <= most)) {
            constexpr const char* kind = std::is_integral_v<T> ? "a whole number" : "a number";
            return refuse(name, *text, concat(kind, " from ", least, " to ", most));
        }
        return give(*number, value);
    }

    template <class T>
    bool give(T wanted, T& value)
    {
        if (use_ == SettingUse::check) return false;
        value = std::move(wanted);
        return true;
    }

    bool refuse(std::string_view name, const std::string& text, const std::string& wanted)
    {
        if (!error_) {
            error_ = Error{ErrorCode::invalid_argument,
                           concat('"', text, "\" does not fit \"", name, "\": ", wanted),
                           {}};
        }
        return false;
    }

    Settings& settings_;
    SettingUse use_;
    bool took_any_ = false;
    std::optional<Error> error_;
    std::string names_;
    std::string unmet_; ///< the present condition
    std::map<std::string, std::string> needed_;
};

/// Writes down what is offered.
class ListingControls final : public Controls {
public:
    bool toggle(std::string_view name, bool& value) override
    {
        return add(name, value ? "on" : "off", "on, off");
    }
    bool number(std::string_view name, int& value, int least, int most) override
    {
        return add(name, to_text(value), concat(least, " to ", most));
    }
    bool number(std::string_view name, double& value, double least, double most) override
    {
        return add(name, to_text(value), concat(least, " to ", most));
    }
    bool choice(std::string_view name, std::size_t& value,
                std::span<const std::string_view> words) override
    {
        return add(name, std::string(value < words.size() ? words[value] : ""), joined(words));
    }
    bool text(std::string_view name, std::string& value) override
    {
        return add(name, value, "any words");
    }
    bool button(std::string_view name) override { return add(name, std::nullopt, "press"); }
    void begin_condition(std::string_view words, bool /*is_met*/) override { condition_ = words; }
    void end_condition() override { condition_.clear(); }

    std::vector<ControlDescription> controls;

private:
    bool add(std::string_view name, std::optional<std::string> value, std::string values)
    {
        controls.push_back({std::string(name), std::move(value), std::move(values), condition_});
        return false;
    }

    std::string condition_;
};

Status use_settings(const std::vector<std::string>& settings,
                    const std::function<void(Controls&)>& offer, SettingUse use)
{
    Settings left;
    for (const std::string& setting : settings) {
        const std::size_t sign = setting.find('=');
        if (sign == std::string::npos || sign == 0) {
            return fail(ErrorCode::invalid_argument,
                        concat('"', setting, "\" is no setting: write NAME=VALUE"));
        }
        const std::string name = setting.substr(0, sign);
        if (!left.emplace(name, setting.substr(sign + 1)).second) {
            return fail(ErrorCode::invalid_argument,
                        concat('"', name, "\" is set twice: leave one out"));
        }
    }
    while (!left.empty()) {
        SettingControls controls(left, use);
        offer(controls);
        if (controls.error()) return tl::unexpected(*controls.error());
        if (controls.took_any()) continue;
        const std::string& name = left.begin()->first;
        if (const std::string needed = controls.missing_condition(name); !needed.empty()) {
            return fail(ErrorCode::invalid_argument,
                        concat('"', name, "\" has no effect here: it needs ", needed));
        }
        return fail(ErrorCode::invalid_argument,
                    concat('"', name, "\" is no setting here: they are ", controls.names()));
    }
    return {};
}

} // namespace

Status apply_settings(const std::vector<std::string>& settings,
                      const std::function<void(Controls&)>& offer)
{
    return use_settings(settings, offer, SettingUse::apply);
}

Status check_settings(const std::vector<std::string>& settings,
                      const std::function<void(Controls&)>& offer)
{
    return use_settings(settings, offer, SettingUse::check);
}

std::string ControlDescription::text() const
{
    return concat(name, value ? concat(" = ", *value) : "", " (", values, ")",
                  needs.empty() ? "" : concat(", needs ", needs));
}

std::vector<ControlDescription> describe_controls(const std::function<void(Controls&)>& offer)
{
    ListingControls listing;
    offer(listing);
    return listing.controls;
}

} // namespace proxima
