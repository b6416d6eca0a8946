// Libraries of our own that the program opens when it first needs them.
#pragma once

#include "base/shared_library.h"

#include <string>

namespace proxima {

/// The library of that name ("vdb") beside the program, where it is built, or where it is installed. `what` it is and
/// `advice` are for the error.
[[nodiscard]] LibraryWanted program_library(const std::string& name, std::string what,
                                            std::string advice);

} // namespace proxima
