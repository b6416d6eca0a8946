#include "cli/program_library.h"

#include "base/text.h"

#include <filesystem>
#include <utility>

namespace proxima {

LibraryWanted program_library(const std::string& name, std::string what, std::string advice)
{
    const std::string file = concat("libproxima_", name, "-" PROXIMA_LIBRARY_VERSION ".so");
    std::error_code unknown;
    const std::filesystem::path folder =
        std::filesystem::read_symlink("/proc/self/exe", unknown).parent_path();
    return {.what = std::move(what),
            .names = {folder / file, folder / PROXIMA_LIBRARY_FOLDER / "proxima" / file},
            .named = {},
            .advice = std::move(advice)};
}

} // namespace proxima
