// Where a scene's instances are: checks of their poses, their boxes, the tree about these.
#pragma once

#include "base/parallel.h"
#include "proxima/function_ref.h"
#include "proxima/scene.h"
#include "query/scene/scene_parts.h"

#include <cstddef>
#include <vector>

namespace proxima {

/// Sets the box of an instance, empty for an empty shape. Why there is none; null where there is one.
[[nodiscard]] const char* place(const std::vector<InstancedShape>& shapes, const Instance& instance,
                                Box& box) noexcept;

/// Is told which instance cannot be placed.
using Refuse = FunctionRef<void(std::size_t instance)>;

/// Calls place_range(first, end, refuse) in parallel for all of [0, count). Errors: invalid_argument with
/// why(instance) for the lowest instance that was refused, cancelled.
[[nodiscard]] Status
place_all(std::size_t count, const Execution& execution,
          FunctionRef<void(std::size_t first, std::size_t end, Refuse refuse)> place_range,
          FunctionRef<const char*(std::size_t instance)> why);

/// Sets the tree about the rows, the first `full` of which have boxes, and what the scene knows of all of them. Error
/// cancelled.
[[nodiscard]] Status finish_scene(SceneParts& parts, const IndexParts& order, std::size_t full,
                                  const Execution& execution);

/// Error budget_exceeded.
[[nodiscard]] Status check_scene_budget(std::size_t instances, std::size_t shapes,
                                        const Execution& execution);

} // namespace proxima
