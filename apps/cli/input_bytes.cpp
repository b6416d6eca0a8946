#include "cli/input_bytes.h"

#include "base/progress.h"
#include "base/text.h"

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <fcntl.h>
#include <poll.h>
#include <sys/stat.h>
#include <system_error>
#include <unistd.h>
#include <utility>

namespace proxima {

namespace {

tl::unexpected<Error> cannot_read(int number, const std::string& name)
{
    return fail(ErrorCode::file_not_found,
                concat("cannot read this file: ", std::generic_category().message(number)), name);
}

} // namespace

Result<InputBytes> InputBytes::open(const std::string& path, Progress* progress)
{
    InputBytes input;
    input.progress_ = progress;
    const bool is_stdin = path == from_stdin;
    input.name_ = is_stdin ? "standard input" : path;
    // Without O_NONBLOCK a named pipe would wait for its writer, deaf to Ctrl-C.
    input.file_ = is_stdin ? STDIN_FILENO : ::open(path.c_str(), O_RDONLY | O_NONBLOCK | O_CLOEXEC);
    if (input.file_ < 0) return cannot_read(errno, input.name_);
    input.owned_ = !is_stdin;
    struct stat status = {};
    if (::fstat(input.file_, &status) != 0) return cannot_read(errno, input.name_);
    if (S_ISDIR(status.st_mode)) {
        return fail(ErrorCode::file_not_found, "this is a folder: name a file in it", input.name_);
    }
    if (S_ISREG(status.st_mode)) input.size_ = static_cast<std::uint64_t>(status.st_size);
    begin_stage(progress, "reading numbers", input.size_.value_or(0));
    return input;
}

InputBytes InputBytes::of_text(std::string text, std::string name)
{
    InputBytes input;
    input.size_ = text.size();
    input.text_ = std::move(text);
    input.name_ = std::move(name);
    return input;
}

InputBytes::InputBytes(InputBytes&& other) noexcept
    : file_(other.file_), owned_(std::exchange(other.owned_, false)), text_(std::move(other.text_)),
      position_(other.position_), name_(std::move(other.name_)), size_(other.size_),
      progress_(other.progress_)
{}

InputBytes::~InputBytes()
{
    if (owned_) ::close(file_);
}

Status InputBytes::wait() const
{
    constexpr int milliseconds = 50; // until somebody's Ctrl-C is seen
    while (true) {
        if (is_cancelled(progress_)) return cancelled("reading", name_);
        pollfd waiting = {file_, POLLIN, 0};
        const int ready = ::poll(&waiting, 1, milliseconds);
        if (ready > 0) return {};
        if (ready < 0 && errno != EINTR) return cannot_read(errno, name_);
    }
}

Result<std::size_t> InputBytes::read(char* bytes, std::size_t count)
{
    if (file_ < 0) {
        const std::size_t part = std::min(count, text_.size() - position_);
        std::memcpy(bytes, text_.data() + position_, part);
        position_ += part;
        return part;
    }
    std::size_t done = 0;
    while (done < count) {
        if (Status status = wait(); !status) return tl::unexpected(status.error());
        const ssize_t got = ::read(file_, bytes + done, count - done);
        if (got == 0) break;
        if (got > 0) {
            done += static_cast<std::size_t>(got);
            advance_stage(progress_, static_cast<std::uint64_t>(got));
        } else if (errno != EINTR && errno != EAGAIN) {
            return cannot_read(errno, name_);
        }
    }
    return done;
}

} // namespace proxima
