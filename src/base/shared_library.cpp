#include "base/shared_library.h"

#include "base/text.h"

#include <cstdlib>
#include <dlfcn.h>
#include <link.h>

namespace proxima {

namespace {

/// Where the system looks for a name without a slash.
std::string searched_folders()
{
    const char* const listed = std::getenv("LD_LIBRARY_PATH");
    const bool any = listed != nullptr && *listed != '\0';
    return concat("LD_LIBRARY_PATH (", any ? listed : "not set",
                  "), the loader's cache, /lib and /usr/lib");
}

/// Why the last library was not opened; the system says its name first.
std::string reason_without(const std::string& name)
{
    const char* const said = dlerror();
    const std::string reason = said != nullptr ? said : "no reason given";
    return reason.starts_with(name + ": ") ? reason.substr(name.size() + 2) : reason;
}

std::string path_of(void* handle, const std::string& name)
{
    link_map* map = nullptr;
    if (dlinfo(handle, RTLD_DI_LINKMAP, static_cast<void*>(&map)) != 0 || map == nullptr)
        return name;
    return map->l_name != nullptr && *map->l_name != '\0' ? map->l_name : name;
}

} // namespace

Result<SharedLibrary> SharedLibrary::open(const LibraryWanted& wanted)
{
    const std::vector<std::string> names =
        wanted.named.empty() ? wanted.names : std::vector<std::string>{wanted.named};
    std::string tried;
    bool searched = false;
    for (const std::string& name : names) {
        if (void* const handle = dlopen(name.c_str(), RTLD_NOW | RTLD_LOCAL)) {
            SharedLibrary library;
            library.handle_ = std::shared_ptr<void>(handle, [](void* open) { dlclose(open); });
            library.path_ = path_of(handle, name);
            return library;
        }
        const std::string reason = reason_without(name);
        searched = searched || name.find('/') == std::string::npos;
        tried += concat(tried.empty() ? "" : "; ", name, " (", reason, ")");
    }
    return fail(ErrorCode::file_not_found,
                concat(wanted.what, " was not found: tried ", tried,
                       searched ? concat("; looked in ", searched_folders()) : std::string(), "; ",
                       wanted.advice));
}

void* SharedLibrary::find(const char* symbol) const noexcept
{
    return dlsym(handle_.get(), symbol);
}

Status SymbolTable::finish(const std::string& advice) const
{
    if (missing_.empty()) return {};
    return fail(ErrorCode::unsupported_format, concat("lacks ", missing_, ": ", advice),
                library_.path());
}

} // namespace proxima
