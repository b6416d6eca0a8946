// The scene of a plan, and what a session says of its objects.
#pragma once

#include "cli/session.h"
#include "cli/touch_plan.h"
#include "cli/touch_session.h"
#include "proxima/result.h"

#include <memory>
#include <nlohmann/json_fwd.hpp>
#include <string>

namespace proxima {

/// Reads the models, and with `lists` builds closest-feature lists for meshes. Errors also
/// invalid_argument, naming `path`, for a model that is not the one
/// recorded.
[[nodiscard]] Result<std::unique_ptr<TouchModel>> load_touch_scene(const ScenePlan& plan,
                                                                   ForceShading shading, bool lists,
                                                                   const std::string& path,
                                                                   Session& session);

/// A material as reports print it: "K 500 N/m, B 1 N s/m, friction 0.4 and 0.3".
[[nodiscard]] std::string in_words(const SurfaceMaterial& material);

/// A line for each object; "" of one model at rest.
[[nodiscard]] std::string objects_text(const TouchModel& model, const QualityReport& quality);
/// Null of one model at rest.
[[nodiscard]] nlohmann::ordered_json objects_json(const TouchModel& model,
                                                  const QualityReport& quality);

} // namespace proxima
