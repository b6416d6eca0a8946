// The options that several subcommands have in the same words.
#pragma once

#include "proxima/geometry.h"
#include "proxima/octree.h"
#include "proxima/result.h"

#include <cstdint>
#include <string>
#include <string_view>

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

/// --lists-mb N: lists of closest features of so many 10^6 bytes at most.
CLI::Option* add_list_budget_option(CLI::App& parser, std::uint64_t& megabytes);

/// --depth N and --threshold N of the octree for cells.
void add_cell_options(CLI::App& parser, int& depth, std::uint32_t& threshold);
/// Throws where one of them is given, for commands that build no octree without other options.
void refuse_cell_options(const CLI::App& parser, std::string_view what_they_go_with);

/// The up axis that a model is drawn with: built-ins and 3DS stand on z, other files mostly on y.
[[nodiscard]] Vec3 up_axis_of_model(const std::string& model);

/// The error with the model as its place, where it named none.
[[nodiscard]] tl::unexpected<Error> at_model(Error error, const std::string& model);

} // namespace proxima
