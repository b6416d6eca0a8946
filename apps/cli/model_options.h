// The options that several subcommands have in the same words.
#pragma once

#include "cli/octree_picture.h"
#include "proxima/octree.h"
#include "proxima/result.h"

#include <cstdint>
#include <string>

namespace CLI {
class App;
class Option;
} // namespace CLI

namespace proxima {

/// What MODEL may be.
enum class ModelKinds {
    meshes,
    meshes_and_octrees,
    meshes_and_indexes,
    meshes_octrees_and_indexes
};

/// MODEL, required: a file or a built-in.
void add_model_option(CLI::App& parser, std::string& model, ModelKinds kinds = ModelKinds::meshes);

/// --method NAME.
void add_method_option(CLI::App& parser, OverlapMethod& method);

/// --budget-mb N, of 10^6 bytes; `description` says of what, and what is used without it.
CLI::Option* add_budget_option(CLI::App& parser, std::uint64_t& megabytes,
                               const std::string& description);

/// The up axis that a model is drawn with: built-ins stand on z, files mostly on y.
[[nodiscard]] UpAxis up_axis_of_model(const std::string& model);

/// The error with the model as its place, where it named none.
[[nodiscard]] tl::unexpected<Error> at_model(Error error, const std::string& model);

} // namespace proxima
