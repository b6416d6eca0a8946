#include "base/mapped_file.h"

#include "base/text.h"

#include <cerrno>
#include <fcntl.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <system_error>
#include <unistd.h>

namespace proxima {

namespace {

tl::unexpected<Error> cannot_open(const std::filesystem::path& path, int reason)
{
    return fail(ErrorCode::file_not_found,
                concat("cannot be read: ", std::generic_category().message(reason)), path.string());
}

/// Closes a descriptor when it goes out of scope; the map stays.
struct Descriptor {
    int number = -1;
    explicit Descriptor(int opened) noexcept : number(opened) {}
    Descriptor(const Descriptor&) = delete;
    Descriptor& operator=(const Descriptor&) = delete;
    ~Descriptor()
    {
        if (number >= 0) (void)::close(number);
    }
};

} // namespace

Result<MappedFile> MappedFile::open(const std::filesystem::path& path)
{
    // Without blocking, so that a pipe is refused instead of waited for.
    const Descriptor file(::open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK));
    if (file.number < 0) return cannot_open(path, errno);
    struct stat status {};
    if (::fstat(file.number, &status) != 0) return cannot_open(path, errno);
    if (S_ISDIR(status.st_mode)) return cannot_open(path, EISDIR);
    if (!S_ISREG(status.st_mode)) {
        return fail(ErrorCode::file_not_found, "is no regular file", path.string());
    }
    if (status.st_size == 0) return MappedFile({});
    const auto size = static_cast<std::size_t>(status.st_size);
    void* const address = ::mmap(nullptr, size, PROT_READ, MAP_PRIVATE, file.number, 0);
    if (address == MAP_FAILED) return cannot_open(path, errno);
    return MappedFile({static_cast<const std::byte*>(address), size});
}

MappedFile::~MappedFile()
{
    if (!bytes_.empty()) {
        (void)::munmap(const_cast<std::byte*>(bytes_.data()), bytes_.size());
    }
}

} // namespace proxima
