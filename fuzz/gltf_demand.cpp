// Any text as the JSON of a glTF: what an independent reader takes is taken, with the same values,
// and what it would make assimp allocate is found out in time.
#include "mesh/io/gltf_demand.h"
#include "base/check.h"
#include "mesh/io/json_text.h"

#include <nlohmann/json.hpp>

#include <cstddef>
#include <cstdint>
#include <string_view>
#include <vector>

namespace {

using namespace proxima;
using detail::JsonText;

int nesting(std::string_view text)
{
    int depth = 0;
    int deepest = 0;
    for (const char c : text) {
        if (c == '[' || c == '{') deepest = std::max(deepest, ++depth);
        if (c == ']' || c == '}') --depth;
    }
    return deepest;
}

/// Members of an object come in any order here, and the last of a name counts.
void expect_same(const JsonText& json, JsonText::Id id, const nlohmann::json& truth)
{
    const JsonText::Value& value = json[id];
    switch (value.kind) {
    case JsonText::Kind::word:
        PROXIMA_CHECK(truth.is_boolean() || truth.is_null());
        break;
    case JsonText::Kind::number:
        PROXIMA_CHECK(truth.is_number() && value.number == truth.get<double>());
        break;
    case JsonText::Kind::string:
        PROXIMA_CHECK(truth.is_string() && value.text == truth.get_ref<const std::string&>());
        break;
    case JsonText::Kind::array: {
        const std::vector<JsonText::Id> children = json.children(id);
        PROXIMA_CHECK(truth.is_array() && children.size() == truth.size());
        for (std::size_t i = 0; i < children.size(); ++i) expect_same(json, children[i], truth[i]);
        break;
    }
    case JsonText::Kind::object: {
        PROXIMA_CHECK(truth.is_object());
        for (const JsonText::Id child : json.children(id))
            PROXIMA_CHECK(truth.contains(json[child].key));
        for (const auto& [key, member] : truth.items()) {
            const auto found = json.member(id, key);
            PROXIMA_CHECK(found.has_value());
            std::size_t named = 0;
            for (const JsonText::Id child : json.children(id)) named += json[child].key == key;
            if (named == 1) expect_same(json, *found, member);
        }
        break;
    }
    }
}

} // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size)
{
    const std::string_view text(reinterpret_cast<const char*>(data), size);
    const detail::MeshSource source{"fuzz", text};
    const MemoryBudget budget{64'000'000};
    const auto json = JsonText::parse(source, text, budget);
    const auto truth = nlohmann::json::parse(text, nullptr, false);
    const bool is_readable = !truth.is_discarded() && (truth.is_object() || truth.is_array());
    if (is_readable && nesting(text) <= JsonText::max_nesting) PROXIMA_CHECK(json.has_value());
    if (!json) {
        PROXIMA_CHECK(!json.error().message.empty());
        PROXIMA_CHECK(!json.error().where.empty());
    } else if (is_readable) {
        expect_same(*json, JsonText::root(), truth);
    }
    const auto demand = check_gltf_demand(source, text, budget);
    if (!demand) {
        PROXIMA_CHECK(!demand.error().message.empty());
    } else {
        PROXIMA_CHECK(json.has_value());
    }
    return 0;
}
