#include "base/input_file.h"

#include "base/grow_buffer.h"
#include "base/memory_budget.h"
#include "base/progress.h"
#include "base/text.h"

#include <algorithm>
#include <cerrno>
#include <fcntl.h>
#include <new>
#include <sys/mman.h>
#include <sys/stat.h>
#include <system_error>
#include <unistd.h>
#include <utility>

namespace proxima {

namespace {

constexpr std::size_t alignment = 128;

tl::unexpected<Error> unreadable(const std::filesystem::path& path, int error_number)
{
    return fail(ErrorCode::file_not_found,
                concat("cannot read this file: ", std::generic_category().message(error_number)),
                path.string());
}

/// Closes a descriptor when it goes out of scope; a map of the file stays.
class Descriptor {
public:
    explicit Descriptor(int value) noexcept : value_(value) {}
    Descriptor(Descriptor&& other) noexcept : value_(std::exchange(other.value_, -1)) {}
    Descriptor& operator=(Descriptor&& other) noexcept
    {
        std::swap(value_, other.value_);
        return *this;
    }
    ~Descriptor()
    {
        if (value_ >= 0) (void)::close(value_);
    }
    [[nodiscard]] int value() const noexcept { return value_; }

private:
    int value_;
};

// Without blocking, so that a pipe is refused instead of waited for.
constexpr int flags_of_file = O_RDONLY | O_CLOEXEC | O_NONBLOCK;

/// Less than 0 and errno, ELOOP or ENOTDIR where a part of the path is a link. \pre it is absolute
Descriptor open_without_links(const std::filesystem::path& path)
{
    Descriptor folder(::open("/", O_PATH | O_DIRECTORY | O_CLOEXEC));
    for (const auto& part : path.parent_path().relative_path()) {
        if (folder.value() < 0) break;
        folder = Descriptor(
            ::openat(folder.value(), part.c_str(), O_PATH | O_DIRECTORY | O_NOFOLLOW | O_CLOEXEC));
    }
    if (folder.value() < 0) return folder;
    return Descriptor(
        ::openat(folder.value(), path.filename().c_str(), flags_of_file | O_NOFOLLOW));
}

Result<FileBytes> map(const std::filesystem::path& path, const Descriptor& file, std::size_t size)
{
    void* const address = ::mmap(nullptr, size, PROT_READ, MAP_PRIVATE, file.value(), 0);
    if (address == MAP_FAILED) return unreadable(path, errno);
    const auto unmap = [size](const void* first) noexcept {
        (void)::munmap(const_cast<void*>(first), size);
    };
    return FileBytes{{static_cast<const std::byte*>(address), size},
                     std::shared_ptr<const void>(address, unmap)};
}

Result<FileBytes> read(const std::filesystem::path& path, const Descriptor& file, std::size_t size,
                       const FileReadOptions& options)
{
    if (Status status =
            check_budget(options.budget, size, "reading " + path.string(), options.advice);
        !status)
        return tl::unexpected(status.error());
    auto memory = std::make_shared<GrowBuffer<std::byte>>();
    std::byte* first = nullptr;
    try {
        first = aligned_bytes(*memory, size, alignment);
    } catch (const std::bad_alloc&) {
        return fail(ErrorCode::budget_exceeded,
                    concat("no memory for the ", size, " bytes of this file: ", options.advice),
                    path.string());
    }
    constexpr std::size_t block = std::size_t{1} << 24U;
    StageSteps steps(options.progress, "loading file", size, block);
    for (std::size_t done = 0; done < size;) {
        const ssize_t count = ::read(file.value(), first + done, std::min(block, size - done));
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
    return FileBytes{{first, size}, std::move(memory)};
}

} // namespace

Result<FileBytes> read_file(const std::filesystem::path& path, const FileReadOptions& options)
{
    const Descriptor file = options.follow_links ? Descriptor(::open(path.c_str(), flags_of_file))
                                                 : open_without_links(path);
    struct stat information {};
    if (file.value() < 0 || ::fstat(file.value(), &information) != 0) {
        return unreadable(path, errno);
    }
    if (S_ISDIR(information.st_mode)) {
        return fail(ErrorCode::file_not_found, "this is a folder: name a file in it",
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
    return options.access == FileAccess::map ? map(path, file, size)
                                             : read(path, file, size, options);
}

} // namespace proxima
