#include "base/output_file.h"

#include "base/check.h"
#include "base/progress.h"

#include <atomic>
#include <cerrno>
#include <csignal>
#include <cstring>
#include <ctime>
#include <fcntl.h>
#include <optional>
#include <pthread.h>
#include <string>
#include <sys/stat.h>
#include <system_error>
#include <unistd.h>
#include <vector>

namespace proxima {

namespace {

namespace fs = std::filesystem;

constexpr std::size_t buffer_size = std::size_t{1} << 18U;
constexpr int max_links = 40;

std::string reason(int error_number)
{
    return std::generic_category().message(error_number);
}

tl::unexpected<Error> not_writable(const fs::path& path, const std::string& why)
{
    return fail(ErrorCode::file_not_writable, "cannot write this file: " + why, path.string());
}

// Beyond a file-size limit the kernel raises SIGXFSZ, which ends the process, unless it is blocked;
// then write() fails with EFBIG like on a full disk and the pending signal is taken back.
class FileSizeSignalBlock {
public:
    FileSizeSignalBlock() noexcept
    {
        sigemptyset(&signal_);
        sigaddset(&signal_, SIGXFSZ);
        pthread_sigmask(SIG_BLOCK, &signal_, &before_);
    }
    FileSizeSignalBlock(const FileSizeSignalBlock&) = delete;
    FileSizeSignalBlock& operator=(const FileSizeSignalBlock&) = delete;
    ~FileSizeSignalBlock() { pthread_sigmask(SIG_SETMASK, &before_, nullptr); }

    void take_back() const noexcept
    {
        const timespec no_wait{};
        (void)sigtimedwait(&signal_, nullptr, &no_wait);
    }

private:
    sigset_t signal_{};
    sigset_t before_{};
};

// 0 or the errno of the failure.
int write_all(int descriptor, const char* data, std::size_t size) noexcept
{
    const FileSizeSignalBlock block;
    while (size > 0) {
        const ssize_t written = ::write(descriptor, data, size);
        if (written < 0) {
            const int error_number = errno;
            if (error_number == EINTR) continue;
            if (error_number == EFBIG) block.take_back();
            return error_number;
        }
        data += written;
        size -= static_cast<std::size_t>(written);
    }
    return 0;
}

bool is_below_device_folders(const fs::path& path)
{
    const std::string text = fs::absolute(path).lexically_normal().string();
    return text.starts_with("/dev/") || text.starts_with("/proc/");
}

// The file that `path` stands for once symbolic links are followed; it need not exist.
std::optional<fs::path> follow_links(fs::path path)
{
    for (int link = 0; link < max_links; ++link) {
        std::error_code error;
        if (!fs::is_symlink(fs::symlink_status(path, error))) return path;
        const fs::path target = fs::read_symlink(path, error);
        if (error) return std::nullopt;
        path = path.parent_path() / target;
    }
    return std::nullopt;
}

fs::path temporary_beside(const fs::path& path)
{
    static std::atomic<unsigned> counter{0};
    const unsigned number = counter.fetch_add(1, std::memory_order_relaxed);
    return path.parent_path() /
           concat(".proxima-", static_cast<long>(getpid()), "-", number, ".tmp");
}

} // namespace

struct OutputFile::State {
    fs::path name;        ///< as the caller said it, for messages
    fs::path destination; ///< links followed
    fs::path temporary;   ///< empty: the destination is written directly
    int descriptor = -1;
    int error_number = 0; ///< of the first failed write
    Progress* progress = nullptr;
    bool stopped = false; ///< by progress
    std::vector<char> buffer;

    State() = default;
    State(const State&) = delete;
    State& operator=(const State&) = delete;
    ~State() { discard(); }

    void discard() noexcept
    {
        if (descriptor >= 0) (void)::close(descriptor);
        descriptor = -1;
        if (!temporary.empty()) (void)::unlink(temporary.c_str());
        temporary.clear();
    }

    Status open_directly()
    {
        descriptor = ::open(destination.c_str(), O_WRONLY | O_APPEND | O_CLOEXEC | O_NOCTTY);
        if (descriptor < 0) return not_writable(name, reason(errno));
        return {};
    }

    Status open_temporary(const struct stat* existing)
    {
        do {
            temporary = temporary_beside(destination);
            descriptor = ::open(temporary.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0666);
        } while (descriptor < 0 && errno == EEXIST);
        if (descriptor >= 0) {
            if (existing != nullptr) (void)::fchmod(descriptor, existing->st_mode & 07777U);
            return {};
        }
        const int error_number_of_open = errno;
        temporary.clear();
        const fs::path folder = destination.parent_path();
        std::error_code error;
        if (!folder.empty() && !fs::is_directory(folder, error)) {
            return not_writable(name, concat("the folder ", folder.string(),
                                             " does not exist: create it or choose another"));
        }
        return not_writable(name, reason(error_number_of_open) +
                                      ": choose a folder that you may write to");
    }

    void flush() noexcept
    {
        stopped = stopped || is_cancelled(progress);
        if (!failed()) error_number = write_all(descriptor, buffer.data(), buffer.size());
        if (progress != nullptr) progress->advance(buffer.size());
        buffer.clear();
    }

    [[nodiscard]] bool failed() const noexcept { return stopped || error_number != 0; }

    [[nodiscard]] Status status() const
    {
        if (stopped) {
            return cancelled("writing", name.string());
        }
        if (error_number == 0) return {};
        return not_writable(name, reason(error_number) + ": nothing was kept");
    }
};

OutputFile::OutputFile(std::unique_ptr<State> state) noexcept : state_(std::move(state)) {}
OutputFile::OutputFile(OutputFile&&) noexcept = default;
OutputFile& OutputFile::operator=(OutputFile&&) noexcept = default;
OutputFile::~OutputFile() = default;

Result<OutputFile> OutputFile::create(const fs::path& path, const OutputOptions& options)
{
    if (options.progress != nullptr) options.progress->begin_stage("writing", options.bytes);
    auto state = std::make_unique<State>();
    state->name = path;
    state->progress = options.progress;
    state->destination = path;
    if (path.filename().empty()) return not_writable(path, "this is not the name of a file");

    struct stat existing {};
    const bool exists = ::stat(path.c_str(), &existing) == 0;
    if (exists && S_ISDIR(existing.st_mode)) return not_writable(path, "it is a folder");
    if (exists && (!S_ISREG(existing.st_mode) || is_below_device_folders(path))) {
        if (auto status = state->open_directly(); !status) return tl::unexpected(status.error());
    } else {
        if (exists && ::access(path.c_str(), W_OK) != 0) return not_writable(path, reason(errno));
        const auto target = follow_links(path);
        if (!target) return not_writable(path, "its symbolic links lead nowhere");
        state->destination = *target;
        if (auto status = state->open_temporary(exists ? &existing : nullptr); !status) {
            return tl::unexpected(status.error());
        }
    }
    state->buffer.reserve(buffer_size);
    return OutputFile(std::move(state));
}

Status OutputFile::write(std::string_view text)
{
    PROXIMA_CHECK(state_ != nullptr);
    while (!text.empty() && !state_->failed()) {
        const std::size_t part = std::min(text.size(), buffer_size - state_->buffer.size());
        state_->buffer.insert(state_->buffer.end(), text.begin(), text.begin() + part);
        text.remove_prefix(part);
        if (state_->buffer.size() == buffer_size) state_->flush();
    }
    return state_->status();
}

Status OutputFile::write(std::span<const std::byte> bytes)
{
    return write(std::string_view(reinterpret_cast<const char*>(bytes.data()), bytes.size()));
}

Status OutputFile::commit()
{
    PROXIMA_CHECK(state_ != nullptr);
    const std::unique_ptr<State> state = std::move(state_);
    state->flush();
    const int descriptor = std::exchange(state->descriptor, -1);
    if (::close(descriptor) != 0 && state->error_number == 0) state->error_number = errno;
    if (auto status = state->status(); !status) return status;
    if (state->temporary.empty()) return {};
    if (::rename(state->temporary.c_str(), state->destination.c_str()) != 0) {
        return not_writable(state->name, reason(errno));
    }
    state->temporary.clear();
    return {};
}

} // namespace proxima
