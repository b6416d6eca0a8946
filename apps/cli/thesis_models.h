// The scanned models that the thesis measures: where they are, or where to get them.
#pragma once

#include "cli/thesis_tables.h"

#include <filesystem>
#include <optional>
#include <string>

namespace proxima {

/// The folder "shared/meshes" beside the checkout that the running program was built in; empty
/// where there is none, as for an installed program.
[[nodiscard]] std::string usual_model_folder();

/// The model's file in that folder, if it is there.
[[nodiscard]] std::optional<std::filesystem::path> file_of(const thesis::Model& model,
                                                           const std::string& folder);

/// "there is no F; it is in A of the Stanford 3D Scanning Repository, ADDRESS: ..."
[[nodiscard]] std::string how_to_get(const thesis::Model& model, const std::string& folder);

} // namespace proxima
