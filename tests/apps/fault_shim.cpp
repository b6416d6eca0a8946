// A library to be loaded before a program (LD_PRELOAD) that makes one call of the system or the
// heap fail, or kills the program there. Counting begins with main and ends with it.
//
//     FAULT_CALL    allocate | new (of C++ alone) | open | write | fsync | close | rename | stat
//                   reach (the first message of proxima-mpi: its process then waits for ever) |
//                   reduce (of MPI: it gets a wrong argument)
//     FAULT_AT      which of these calls, from 1; 0 or nothing: none
//     FAULT_ACTION  fail (no memory, a full disk, or, of stat, no permission) | kill
//     FAULT_COUNT   a file that is written at the end: how many such calls there were
#include <atomic>
#include <cerrno>
#include <csignal>
#include <cstdarg>
#include <cstddef>
#include <cstdlib>
#include <cstring>
#include <dlfcn.h>
#include <fcntl.h>
#include <new>
#include <sys/mman.h>
#include <sys/stat.h>
#include <sys/syscall.h>
#include <sys/types.h>
#include <unistd.h>

namespace {

enum class Call { none, allocate, create, open, write, fsync, close, rename, stat, reach, reduce };

struct Plan {
    Call call = Call::none;
    long at = 0;
    bool kills = false;
    const char* count_file = nullptr;
};

Plan plan;
std::atomic<bool> counting{false};
std::atomic<long> calls{0};

bool is(const char* text, const char* word)
{
    return text != nullptr && std::strcmp(text, word) == 0;
}

void read_plan()
{
    const char* const call = std::getenv("FAULT_CALL");
    const char* const at = std::getenv("FAULT_AT");
    plan.call = is(call, "allocate") ? Call::allocate
                : is(call, "new")    ? Call::create
                : is(call, "open")   ? Call::open
                : is(call, "write")  ? Call::write
                : is(call, "fsync")  ? Call::fsync
                : is(call, "close")  ? Call::close
                : is(call, "rename") ? Call::rename
                : is(call, "stat")   ? Call::stat
                : is(call, "reach")  ? Call::reach
                : is(call, "reduce") ? Call::reduce
                                     : Call::none;
    plan.at = at == nullptr ? 0 : std::atol(at);
    plan.kills = is(std::getenv("FAULT_ACTION"), "kill");
    plan.count_file = std::getenv("FAULT_COUNT");
}

/// Whether this call is to fail.
bool fails(Call call) noexcept
{
    if (!counting.load(std::memory_order_relaxed) || call != plan.call) return false;
    if (calls.fetch_add(1) + 1 != plan.at) return false;
    if (plan.kills) ::raise(SIGKILL);
    return true;
}

void write_count()
{
    if (plan.count_file == nullptr) return;
    char text[24];
    std::size_t begin = sizeof text;
    for (long rest = calls.load(); begin == sizeof text || rest != 0; rest /= 10)
        text[--begin] = static_cast<char>('0' + rest % 10);
    const long file = ::syscall(SYS_openat, AT_FDCWD, plan.count_file,
                                O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0600);
    if (file < 0) return;
    (void)!::syscall(SYS_write, file, text + begin, sizeof text - begin);
    (void)::syscall(SYS_close, file);
}

int (*true_main)(int, char**, char**) = nullptr;

#if defined(__clang__)
__attribute__((no_sanitize("function"))) // a program's main may have two parameters
#endif
int counted_main(int count, char** arguments, char** environment)
{
    read_plan();
    counting = true;
    const int status = true_main(count, arguments, environment);
    counting = false;
    write_count();
    return status;
}

template <class Function>
Function* next(const char* name) noexcept
{
    return reinterpret_cast<Function*>(::dlsym(RTLD_NEXT, name));
}

void* no_memory() noexcept
{
    errno = ENOMEM;
    return nullptr;
}

int full_disk() noexcept
{
    errno = ENOSPC;
    return -1;
}

} // namespace

/// The other forms call this one, but for those of a given alignment.
void* operator new(std::size_t size) // NOLINT(misc-new-delete-overloads): free does for all
{
    void* const memory = fails(Call::create) ? nullptr : std::malloc(size);
    if (memory == nullptr) throw std::bad_alloc();
    return memory;
}

// NOLINTBEGIN(*-reserved-identifier,readability-identifier-naming): the names of the system's library
extern "C" {

void* __libc_malloc(std::size_t);
void* __libc_calloc(std::size_t, std::size_t);
void* __libc_realloc(void*, std::size_t);
void* __libc_memalign(std::size_t, std::size_t);

void* malloc(std::size_t size) noexcept
{
    return fails(Call::allocate) ? no_memory() : __libc_malloc(size);
}

void* calloc(std::size_t count, std::size_t size) noexcept
{
    return fails(Call::allocate) ? no_memory() : __libc_calloc(count, size);
}

void* realloc(void* memory, std::size_t size) noexcept
{
    return fails(Call::allocate) ? no_memory() : __libc_realloc(memory, size);
}

void* memalign(std::size_t alignment, std::size_t size) noexcept
{
    return fails(Call::allocate) ? no_memory() : __libc_memalign(alignment, size);
}

void* aligned_alloc(std::size_t alignment, std::size_t size) noexcept
{
    return fails(Call::allocate) ? no_memory() : __libc_memalign(alignment, size);
}

int posix_memalign(void** memory, std::size_t alignment, std::size_t size) noexcept
{
    if (fails(Call::allocate)) return ENOMEM;
    void* const found = __libc_memalign(alignment, size);
    if (found == nullptr) return ENOMEM;
    *memory = found;
    return 0;
}

void* mmap(void* address, std::size_t size, int protection, int flags, int file,
           off_t offset) noexcept
{
    if ((flags & MAP_ANONYMOUS) != 0 && fails(Call::allocate)) {
        errno = ENOMEM;
        return MAP_FAILED;
    }
    return next<decltype(mmap)>("mmap")(address, size, protection, flags, file, offset);
}

int open(const char* path, int flags, ...)
{
    std::va_list arguments;
    va_start(arguments, flags);
    const mode_t mode = (flags & O_CREAT) != 0 ? va_arg(arguments, mode_t) : 0;
    va_end(arguments);
    if (fails(Call::open)) return full_disk();
    return static_cast<int>(::syscall(SYS_openat, AT_FDCWD, path, flags, mode));
}

ssize_t write(int file, const void* bytes, std::size_t count)
{
    if (file != STDERR_FILENO && fails(Call::write)) return full_disk();
    return ::syscall(SYS_write, file, bytes, count);
}

int fsync(int file)
{
    return fails(Call::fsync) ? full_disk() : static_cast<int>(::syscall(SYS_fsync, file));
}

int close(int file)
{
    const bool is_failing = fails(Call::close);
    const auto status = static_cast<int>(::syscall(SYS_close, file));
    return is_failing ? full_disk() : status;
}

int rename(const char* from, const char* to) noexcept
{
    return fails(Call::rename) ? full_disk() : static_cast<int>(::syscall(SYS_rename, from, to));
}

int stat(const char* path, struct stat* status) noexcept
{
    if (!fails(Call::stat)) return next<int(const char*, struct stat*)>("stat")(path, status);
    errno = EACCES;
    return -1;
}

// Open MPI's handles are pointers.

int MPI_Ialltoall(const void* sent, int sent_count, void* sent_type, void* received,
                  int received_count, void* received_type, void* ranks, void* request)
{
    if (fails(Call::reach)) {
        for (;;) ::pause();
    }
    return next<decltype(MPI_Ialltoall)>("MPI_Ialltoall")(
        sent, sent_count, sent_type, received, received_count, received_type, ranks, request);
}

int MPI_Allreduce(const void* sent, void* received, int count, void* type, void* operation,
                  void* ranks)
{
    return next<decltype(MPI_Allreduce)>("MPI_Allreduce")(
        sent, received, fails(Call::reduce) ? -1 : count, type, operation, ranks);
}

int __libc_start_main(int (*main)(int, char**, char**), int count, char** arguments,
                      void (*initialise)(), void (*finish)(), void (*finish_loader)(), void* stack)
{
    true_main = main;
    return next<decltype(__libc_start_main)>("__libc_start_main")(
        counted_main, count, arguments, initialise, finish, finish_loader, stack);
}

} // extern "C"
// NOLINTEND(*-reserved-identifier,readability-identifier-naming)
