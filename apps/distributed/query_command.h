// proxima-mpi closest, rays and sign: questions to a mesh that is spread over the ranks.
#pragma once

#include "distributed/table_blocks.h"
#include "distributed/world.h"

#include <CLI/App.hpp>
#include <string>

namespace proxima {

struct QueryOptions {
    std::string model;
    TableSource table; ///< of points or rays
    std::string out;   ///< "-" for stdout
    int routing_depth = 5;
    bool is_verified = false;
};

/// The commands, and which of them was given.
class QueryCommands {
public:
    explicit QueryCommands(CLI::App& app);

    [[nodiscard]] bool is_given() const;

    /// Answers the questions and writes the answers on rank 0. Collective. \pre is_given()
    [[nodiscard]] Status run(World& world) const;

private:
    CLI::App* closest_;
    CLI::App* rays_;
    CLI::App* sign_;
    QueryOptions options_;
};

} // namespace proxima
