// A JSON text as values, so that it can be judged before a reader that trusts it takes it.
//
//     {"a": [1, 2], "b": 3}
//     values:  object | "a" array | 1 | 2 | "b" 3        each before what it contains;
//     end:        5          4      3   4     5          `end` is where its successor would be
#pragma once

#include "mesh/io/mesh_source.h"

#include <cstdint>
#include <deque>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace proxima::detail {

/// The values of one JSON text, which must outlive it.
class JsonText {
public:
    using Id = std::uint32_t;
    enum class Kind : std::uint8_t { word, number, string, array, object };

    struct Value {
        std::string_view key;  ///< of a member; escapes are resolved
        std::string_view text; ///< of a string; escapes are resolved
        double number = 0;
        Id end = 0;
        Kind kind = Kind::word; ///< word: true, false or null
    };

    /// Arrays and objects may lie this deep in each other: readers descend by recursion.
    static constexpr int max_nesting = 512;

    /// Takes `text`, a part of source.text. Errors: malformed_file, budget_exceeded.
    [[nodiscard]] static Result<JsonText> parse(const MeshSource& source, std::string_view text,
                                                MemoryBudget budget);

    [[nodiscard]] static constexpr Id root() noexcept { return 0; }
    [[nodiscard]] const Value& operator[](Id id) const noexcept { return values_[id]; }

    /// The elements of an array, or the members of an object; none of anything else.
    [[nodiscard]] std::vector<Id> children(Id id) const;
    /// The first member of that name; nothing where there is none or `id` is no object.
    [[nodiscard]] std::optional<Id> member(Id id, std::string_view key) const;
    /// That member's number, or `otherwise`.
    [[nodiscard]] double number(Id id, std::string_view key, double otherwise) const;

private:
    friend class JsonParser;

    std::vector<Value> values_;
    std::deque<std::string> resolved_; // strings that had escapes
};

} // namespace proxima::detail
