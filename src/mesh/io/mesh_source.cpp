#include "mesh/io/mesh_source.h"

#include "base/memory_budget.h"
#include "base/progress.h"
#include "base/text.h"

#include <algorithm>
#include <cerrno>
#include <fcntl.h>
#include <new>
#include <sys/stat.h>
#include <system_error>
#include <unistd.h>

namespace proxima::detail {

namespace {

// Closes the file on every return.
class Descriptor {
public:
    explicit Descriptor(const std::filesystem::path& path) noexcept
        : value_(::open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK))
    {}
    Descriptor(const Descriptor&) = delete;
    Descriptor& operator=(const Descriptor&) = delete;
    ~Descriptor()
    {
        if (value_ >= 0) (void)::close(value_);
    }
    [[nodiscard]] int value() const noexcept { return value_; }

private:
    int value_;
};

tl::unexpected<Error> unreadable(const std::filesystem::path& path, int error_number)
{
    return fail(ErrorCode::file_not_found,
                "cannot read this file: " + std::generic_category().message(error_number),
                path.string());
}

} // namespace

std::string MeshSource::at_line(const char* position) const
{
    return concat(name, ":", 1 + std::count(text.data(), position, '\n'));
}

std::string MeshSource::at_byte(const char* position) const
{
    return concat(name, ", byte ", position - text.data());
}

Result<FileBytes> read_file(const std::filesystem::path& path, MemoryBudget budget,
                            Progress* progress)
{
    const Descriptor file(path);
    struct stat information {};
    if (file.value() < 0 || ::fstat(file.value(), &information) != 0) {
        return unreadable(path, errno);
    }
    if (S_ISDIR(information.st_mode)) {
        return fail(ErrorCode::file_not_found, "this is a folder: name a mesh file in it",
                    path.string());
    }
    if (!S_ISREG(information.st_mode)) {
        return fail(ErrorCode::file_not_found, "this is not a regular file: copy it to one first",
                    path.string());
    }
    const auto size = static_cast<std::size_t>(information.st_size);
    if (size == 0) {
        return fail(ErrorCode::malformed_file, "the file is empty: write or copy it again",
                    path.string());
    }
    if (auto status = check_budget(budget, size, "reading " + path.string(),
                                   "raise the budget or split the mesh");
        !status) {
        return tl::unexpected(status.error());
    }
    FileBytes file_bytes;
    try {
        file_bytes.bytes.resize(size);
    } catch (const std::bad_alloc&) {
        return fail(ErrorCode::budget_exceeded,
                    concat("no memory for the ", size, " bytes of this file: split the mesh"),
                    path.string());
    }
    constexpr std::size_t block = std::size_t{1} << 24U;
    StageSteps steps(progress, "loading file", size, block);
    for (std::size_t done = 0; done < size;) {
        const ssize_t count =
            ::read(file.value(), file_bytes.bytes.data() + done, std::min(block, size - done));
        if (count < 0 && errno == EINTR) continue;
        if (count < 0) return unreadable(path, errno);
        if (count == 0) {
            return fail(ErrorCode::malformed_file,
                        concat("the file shrank from ", size, " to ", done,
                               " bytes while it was read: wait until it is written"),
                        path.string());
        }
        done += static_cast<std::size_t>(count);
        if (!steps.done(static_cast<std::size_t>(count))) {
            return cancelled("reading", path.string());
        }
    }
    return file_bytes;
}

} // namespace proxima::detail
