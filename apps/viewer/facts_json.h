// A panel's numbers as JSON.
#pragma once

#include "viewer/panel.h"

#include <nlohmann/json.hpp>
#include <span>

namespace proxima {

/// Values by name; a list in order where several facts, of one model each, have the same name.
[[nodiscard]] inline nlohmann::ordered_json facts_json(std::span<const PanelFact> facts)
{
    auto json = nlohmann::ordered_json::object();
    for (const PanelFact& fact : facts) {
        if (!json.contains(fact.name)) {
            json[fact.name] = fact.value;
            continue;
        }
        auto& values = json[fact.name];
        if (!values.is_array()) values = nlohmann::ordered_json::array({values});
        values.push_back(fact.value);
    }
    return json;
}

} // namespace proxima
