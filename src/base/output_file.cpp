#include "base/output_file.h"

#include "base/check.h"
#include "base/progress.h"
#include "base/signal_block.h"

#include <atomic>
#include <cerrno>
#include <chrono>
#include <csignal>
#include <cstring>
#include <dirent.h>
#include <fcntl.h>
#include <memory>
#include <mutex>
#include <optional>
#include <set>
#include <string>
#include <sys/file.h>
#include <sys/stat.h>
#include <system_error>
#include <thread>
#include <unistd.h>
#include <vector>

namespace proxima {

namespace {

namespace fs = std::filesystem;

constexpr std::size_t buffer_size = std::size_t{1} << 18U;
constexpr int max_links = 40;

// As in `cat pipe & proxima ... --out pipe`: the reader may be a little later than the writer.
constexpr std::chrono::milliseconds wait_for_reader{10};
constexpr int max_waits_for_reader = 300;

std::string reason(int error_number)
{
    return std::generic_category().message(error_number);
}

tl::unexpected<Error> not_writable(const fs::path& path, const std::string& why)
{
    return fail(ErrorCode::file_not_writable, "cannot write this file: " + why, path.string());
}

// Writes all of it by write_some(data, size). 0 or the errno of the failure. Beyond a file-size limit the
// kernel raises SIGXFSZ, which would end the process; blocked, it lets write() fail like on a full disk.
template <class WriteSome>
int write_all(const char* data, std::size_t size, const WriteSome& write_some) noexcept
{
    const SignalBlock block(SIGXFSZ);
    while (size > 0) {
        const ssize_t written = write_some(data, size);
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
    // What lies in shared memory are files like others.
    return (text.starts_with("/dev/") && !text.starts_with("/dev/shm/")) ||
           text.starts_with("/proc/");
}

// Temporary files are called .proxima-PROCESS-NUMBER.tmp, and locked while somebody writes them.
// So one that can be locked belongs to nobody: its process was killed. A process's number alone
// would not tell, as another machine that shares the folder may have that process.
constexpr std::string_view temporary_prefix = ".proxima-";
constexpr std::string_view temporary_suffix = ".tmp";

fs::path folder_of(const fs::path& path)
{
    const fs::path folder = path.parent_path();
    return folder.empty() ? fs::path(".") : folder;
}

fs::path temporary_beside(const fs::path& path)
{
    static std::atomic<unsigned> counter{0};
    const unsigned number = counter.fetch_add(1, std::memory_order_relaxed);
    return path.parent_path() /
           concat(temporary_prefix, static_cast<long>(getpid()), "-", number, temporary_suffix);
}

// Two numbers with a hyphen between them, and what every such name has before and behind them.
bool is_temporary_name(std::string_view name)
{
    if (!name.starts_with(temporary_prefix) || !name.ends_with(temporary_suffix)) return false;
    name.remove_prefix(temporary_prefix.size());
    if (name.size() <= temporary_suffix.size()) return false;
    name.remove_suffix(temporary_suffix.size());
    const std::size_t hyphen = name.find('-');
    if (hyphen == std::string_view::npos) return false;
    const auto is_number = [](std::string_view text) {
        return !text.empty() && text.find_first_not_of("0123456789") == std::string_view::npos &&
               (text.size() == 1 || text.front() != '0');
    };
    return is_number(name.substr(0, hyphen)) && is_number(name.substr(hyphen + 1));
}

// Removes the file where it is one's own and no process writes it.
void remove_if_abandoned(const fs::path& path) noexcept
{
    constexpr int flags = O_NOFOLLOW | O_NONBLOCK | O_CLOEXEC | O_NOCTTY;
    int descriptor = ::open(path.c_str(), O_RDONLY | flags);
    if (descriptor < 0 && errno == EACCES) descriptor = ::open(path.c_str(), O_WRONLY | flags);
    if (descriptor < 0) return;
    struct stat status {};
    if (::fstat(descriptor, &status) == 0 && S_ISREG(status.st_mode) &&
        status.st_uid == ::geteuid() && ::flock(descriptor, LOCK_EX | LOCK_NB) == 0) {
        (void)::unlink(path.c_str());
    }
    (void)::close(descriptor);
}

// Once for each folder and process: a folder may hold millions of files.
void remove_abandoned_files(const fs::path& folder)
{
    static std::mutex mutex;
    static std::set<fs::path> seen;
    std::error_code error;
    const fs::path name = fs::canonical(folder, error);
    if (error) return;
    const std::lock_guard lock(mutex);
    if (!seen.insert(name).second) return;
    DIR* const entries = ::opendir(name.c_str());
    if (entries == nullptr) return;
    const std::unique_ptr<DIR, int (*)(DIR*)> closing(entries, ::closedir);
    while (const dirent* const entry = ::readdir(entries)) {
        if (is_temporary_name(entry->d_name)) remove_if_abandoned(name / entry->d_name);
    }
}

// A new file that this process has locked, or -1 and errno. Where the file system has no locks,
// nobody takes the file for abandoned either.
int create_locked(const fs::path& path, mode_t mode) noexcept
{
    const int descriptor = ::open(path.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, mode);
    if (descriptor < 0) return -1;
    const bool is_locked = ::flock(descriptor, LOCK_EX | LOCK_NB) == 0;
    struct stat status {};
    // Somebody may have looked at the file before it was locked.
    const bool is_taken = (!is_locked && errno == EWOULDBLOCK) ||
                          (::fstat(descriptor, &status) == 0 && status.st_nlink == 0);
    if (!is_taken) return descriptor;
    (void)::close(descriptor);
    errno = EEXIST;
    return -1;
}

// What the file that is replaced allowed, as far as the new one is for the same people.
void keep_permissions(int descriptor, const struct stat& replaced) noexcept
{
    constexpr mode_t for_owner = 0700;
    constexpr mode_t for_group = 0070;
    constexpr mode_t for_others = 0007;
    mode_t mode = replaced.st_mode & (for_owner | for_group | for_others);
    struct stat created {};
    if (::fstat(descriptor, &created) != 0) return;
    if (created.st_gid != replaced.st_gid &&
        ::fchown(descriptor, static_cast<uid_t>(-1), replaced.st_gid) != 0) {
        // The new file's group may do what everybody may.
        mode = (mode & ~for_group) | ((mode & for_others) << 3U);
    }
    (void)::fchmod(descriptor, mode);
}

// 0 or the errno of the failure. Some file systems cannot wait for the disk, and say so.
int wait_for_disk(int descriptor) noexcept
{
    if (::fsync(descriptor) == 0 || errno == EINVAL || errno == ENOTSUP) return 0;
    return errno;
}

int wait_for_disk(const fs::path& folder) noexcept
{
    const int descriptor = ::open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
    if (descriptor < 0) return 0; // a folder that may be written, but not read
    const int error_number = wait_for_disk(descriptor);
    (void)::close(descriptor);
    return error_number;
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

    Status open_directly(bool is_pipe)
    {
        constexpr int flags = O_WRONLY | O_APPEND | O_CLOEXEC | O_NOCTTY;
        // Opening a pipe without a reader would wait for one for ever.
        descriptor = ::open(destination.c_str(), flags | O_NONBLOCK);
        for (int i = 0; is_pipe && descriptor < 0 && errno == ENXIO; ++i) {
            if (is_cancelled(progress)) return cancelled("writing", name.string());
            if (i == max_waits_for_reader) {
                return not_writable(name, "no program reads this pipe: start its reader first");
            }
            std::this_thread::sleep_for(wait_for_reader);
            descriptor = ::open(destination.c_str(), flags | O_NONBLOCK);
        }
        if (descriptor < 0 || ::fcntl(descriptor, F_SETFL, O_APPEND) != 0)
            return not_writable(name, reason(errno));
        return {};
    }

    Status open_temporary(const struct stat* existing)
    {
        remove_abandoned_files(folder_of(destination));
        const bool is_own = existing != nullptr && existing->st_uid == ::geteuid();
        do {
            temporary = temporary_beside(destination);
            descriptor = create_locked(temporary, is_own ? 0600 : 0666);
        } while (descriptor < 0 && errno == EEXIST);
        if (descriptor >= 0) {
            if (is_own) keep_permissions(descriptor, *existing);
            return {};
        }
        const int error_number_of_open = errno;
        const fs::path folder = destination.parent_path();
        std::error_code error;
        if (!folder.empty() && !fs::is_directory(folder, error)) {
            fs::path above = folder;
            while (!above.empty() && !fs::exists(above, error)) above = above.parent_path();
            if (!above.empty() && !fs::is_directory(above, error)) {
                return not_writable(
                    name, concat(above.string(), " is not a folder: choose another place"));
            }
            return not_writable(name, concat("the folder ", folder.string(),
                                             " does not exist: create it or choose another"));
        }
        return not_writable(name, reason(error_number_of_open) +
                                      ": choose a folder that you may write to");
    }

    void flush() noexcept
    {
        stopped = stopped || is_cancelled(progress);
        if (!failed()) {
            error_number =
                write_all(buffer.data(), buffer.size(), [this](const char* data, std::size_t size) {
                    return ::write(descriptor, data, size);
                });
        }
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
        return not_writable(name, reason(error_number) +
                                      (temporary.empty() ? "" : ": nothing of it was kept"));
    }
};

OutputFile::OutputFile(std::unique_ptr<State> state) noexcept : state_(std::move(state)) {}
OutputFile::OutputFile(OutputFile&&) noexcept = default;
OutputFile& OutputFile::operator=(OutputFile&&) noexcept = default;
OutputFile::~OutputFile() = default;

bool OutputFile::is_direct() const noexcept
{
    PROXIMA_CHECK(state_ != nullptr);
    return state_->temporary.empty();
}

std::optional<fs::path> linked_file(fs::path path)
{
    for (int link = 0; link <= max_links; ++link) {
        std::error_code error;
        if (!fs::is_symlink(fs::symlink_status(path, error))) return path;
        const fs::path target = fs::read_symlink(path, error);
        if (error) return std::nullopt;
        path = path.parent_path() / target;
    }
    return std::nullopt;
}

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
    // Links that lead nowhere are looked at below. Those that the system does not follow, as another user's in
    // a folder like /tmp, are not followed here either.
    if (!exists && errno != ENOENT && errno != ENOTDIR && errno != ELOOP) {
        const bool is_long = errno == ENAMETOOLONG;
        return not_writable(path, reason(errno) + (is_long ? ": give it a shorter name"
                                                           : ": choose another place"));
    }
    if (exists && S_ISDIR(existing.st_mode)) return not_writable(path, "it is a folder");
    if (exists && (!S_ISREG(existing.st_mode) || is_below_device_folders(path))) {
        const bool is_pipe = S_ISFIFO(existing.st_mode);
        if (auto status = state->open_directly(is_pipe); !status)
            return tl::unexpected(status.error());
    } else {
        if (exists && ::access(path.c_str(), W_OK) != 0) return not_writable(path, reason(errno));
        const auto target = linked_file(path);
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

Status OutputFile::overwrite(std::uint64_t offset, std::span<const std::byte> bytes)
{
    PROXIMA_CHECK(state_ != nullptr);
    state_->flush();
    if (state_->temporary.empty() && !state_->failed()) state_->error_number = ESPIPE;
    if (!state_->failed()) {
        state_->error_number = write_all(reinterpret_cast<const char*>(bytes.data()), bytes.size(),
                                         [&](const char* data, std::size_t size) {
                                             const auto at = static_cast<off_t>(offset);
                                             const ssize_t written =
                                                 ::pwrite(state_->descriptor, data, size, at);
                                             if (written > 0)
                                                 offset += static_cast<std::uint64_t>(written);
                                             return written;
                                         });
    }
    return state_->status();
}

Status OutputFile::commit()
{
    PROXIMA_CHECK(state_ != nullptr);
    const std::unique_ptr<State> state = std::move(state_);
    state->flush();
    const bool is_replacing = !state->temporary.empty();
    if (is_replacing && !state->failed()) state->error_number = wait_for_disk(state->descriptor);
    // Closing may tell of an error too. Until the file has its name, a second descriptor keeps it
    // locked.
    const int descriptor = std::exchange(state->descriptor, -1);
    if (is_replacing) state->descriptor = ::fcntl(descriptor, F_DUPFD_CLOEXEC, 0);
    if (::close(descriptor) != 0 && state->error_number == 0) state->error_number = errno;
    if (auto status = state->status(); !status) return status;
    if (!is_replacing) return {};
    if (::rename(state->temporary.c_str(), state->destination.c_str()) != 0) {
        return not_writable(state->name, reason(errno));
    }
    state->temporary.clear();
    if (const int error_number = wait_for_disk(folder_of(state->destination)); error_number != 0) {
        return not_writable(state->name, reason(error_number) +
                                             ": the file has been replaced, but its folder "
                                             "may not be on the disk");
    }
    return {};
}

} // namespace proxima
