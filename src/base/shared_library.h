// Libraries that are opened at run time: a program that can use them runs without them too.
#pragma once

#include "proxima/result.h"

#include <memory>
#include <span>
#include <string>
#include <vector>

namespace proxima {

/// What to look for.
struct LibraryWanted {
    std::string what;               ///< "OpenHaptics' libHD"
    std::vector<std::string> names; ///< tried in this order: where the system looks, or paths
    std::string named;              ///< a path by the user: then nothing else is tried
    std::string advice;             ///< what to install, for the error
};

/// Open while it or a copy of it lives.
class SharedLibrary {
public:
    /// Errors: file_not_found (every name that was tried, with the system's reason, where the
    /// system looks, and the advice).
    [[nodiscard]] static Result<SharedLibrary> open(const LibraryWanted& wanted);

    /// The file that was opened, as the system says it.
    [[nodiscard]] const std::string& path() const noexcept { return path_; }

    /// Its address, or null.
    [[nodiscard]] void* find(const char* symbol) const noexcept;

private:
    std::shared_ptr<void> handle_;
    std::string path_;
};

/// Fills function pointers by name and keeps account of what is missing.
class SymbolTable {
public:
    explicit SymbolTable(const SharedLibrary& library) : library_(library) {}

    /// Must be there.
    template <class Function>
    void need(Function*& function, const char* name)
    {
        function = reinterpret_cast<Function*>(library_.find(name));
        if (function == nullptr) missing_ += (missing_.empty() ? "" : ", ") + std::string(name);
    }
    /// May be null.
    template <class Function>
    void want(Function*& function, const char* name)
    {
        function = reinterpret_cast<Function*>(library_.find(name));
    }

    /// Error unsupported_format: which names the library lacks, and the advice.
    [[nodiscard]] Status finish(const std::string& advice) const;

private:
    const SharedLibrary& library_;
    std::string missing_;
};

/// What a library of this project's own exports: one function.
template <class Function>
struct LibraryFunction {
    SharedLibrary library;
    Function* call = nullptr; ///< while the library is open
};

/// Errors: file_not_found, as SharedLibrary::open; unsupported_format (a library of another version).
template <class Function>
[[nodiscard]] Result<LibraryFunction<Function>> open_function(const LibraryWanted& wanted,
                                                              const char* name)
{
    auto library = SharedLibrary::open(wanted);
    if (!library) return tl::unexpected(library.error());
    LibraryFunction<Function> found{*std::move(library)};
    SymbolTable symbols(found.library);
    symbols.need(found.call, name);
    if (Status status = symbols.finish("it is of another version"); !status)
        return fail(ErrorCode::unsupported_format, describe(status.error()));
    return found;
}

} // namespace proxima
