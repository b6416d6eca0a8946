// Libraries of our own that the program opens when it first needs them.
#pragma once

#include "base/shared_library.h"
#include "proxima/result.h"

#include <string>

namespace proxima {

/// Opens the library of that name ("vdb") beside the program, where it is built, or where it is installed. `what` it is and
/// `advice` are for the error. Errors: file_not_found.
[[nodiscard]] Result<SharedLibrary>
open_program_library(const std::string& name, const std::string& what, const std::string& advice);

} // namespace proxima
