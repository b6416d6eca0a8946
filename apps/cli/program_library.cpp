#include "cli/program_library.h"

#include "base/text.h"

#include <filesystem>

namespace proxima {

Result<SharedLibrary> open_program_library(const std::string& name, const std::string& what,
                                           const std::string& advice)
{
    const std::string file = concat("libproxima_", name, "-" PROXIMA_LIBRARY_VERSION ".so");
    std::error_code unknown;
    const std::filesystem::path folder =
        std::filesystem::read_symlink("/proc/self/exe", unknown).parent_path();
    return SharedLibrary::open(
        {.what = what,
         .names = {folder / file, folder / PROXIMA_LIBRARY_FOLDER / "proxima" / file},
         .named = {},
         .advice = advice});
}

} // namespace proxima
