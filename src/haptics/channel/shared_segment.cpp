#include "haptics/channel/shared_segment.h"

#include "base/text.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <cerrno>
#include <chrono>
#include <cstring>
#include <fcntl.h>
#include <sys/file.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <thread>
#include <unistd.h>
#include <utility>

namespace proxima {

namespace {

constexpr PacketMagic segment_magic = {'P', 'X', 'S', 'M'};
constexpr std::uint32_t endianness = 0x01020304;
constexpr std::uint32_t is_open = 1;
constexpr std::size_t word = sizeof(std::uint64_t);
constexpr std::size_t flags_offset = 8; ///< of the word that holds endianness and flags

/// Memory that another process may write to at any time is read and written by whole words.
std::atomic_ref<std::uint64_t> word_at(std::span<const std::byte> segment,
                                       std::size_t offset) noexcept
{
    // The segment is mapped for writing; readers only load.
    auto* const at = const_cast<std::byte*>(segment.data() + offset);
    return std::atomic_ref(*reinterpret_cast<std::uint64_t*>(at));
}
static_assert(std::atomic_ref<std::uint64_t>::is_always_lock_free);

std::size_t slot_of(const RingLayout& ring, std::uint64_t number) noexcept
{
    return ring.offset + std::size_t{ring.slot_size} * (number % ring.slots);
}

/// The header as the owner writes it, up to the counts.
std::array<std::byte, 64> header_of_owner(std::uint32_t flags) noexcept
{
    std::array<std::byte, 64> bytes{};
    PacketWriter writer(bytes);
    for (const char letter : segment_magic) writer.put(static_cast<std::uint8_t>(letter));
    writer.put(engine_version);
    writer.put(static_cast<std::uint16_t>(segment_header_size));
    writer.put(endianness);
    writer.put(flags);
    writer.put(std::uint64_t{segment_size});
    writer.put(static_cast<std::uint64_t>(getpid()));
    for (const RingLayout& ring : {touch_ring, scene_ring}) {
        writer.put(ring.offset);
        writer.put(ring.slot_size);
        writer.put(ring.slots);
        writer.put(ring.count_offset);
    }
    return bytes;
}

/// Opens or closes a segment: whoever sees that it is open sees what was written before.
void store_flags(std::span<std::byte> segment, std::uint32_t flags) noexcept
{
    std::uint64_t bits = 0;
    std::memcpy(&bits, header_of_owner(flags).data() + flags_offset, word);
    word_at(segment, flags_offset).store(bits, std::memory_order_release);
}

/// Takes the owner's lock. An engine that looks whether a segment has an owner holds it for a moment.
bool lock_as_owner(int file)
{
    constexpr int attempts = 100;
    constexpr auto pause = std::chrono::milliseconds(1);
    for (int attempt = 0; attempt < attempts; ++attempt) {
        if (flock(file, LOCK_EX | LOCK_NB) == 0) return true;
        std::this_thread::sleep_for(pause);
    }
    return false;
}

tl::unexpected<Error> refused(const std::string& path, const std::string& why)
{
    return fail(ErrorCode::invalid_argument, why, path);
}

tl::unexpected<Error> system_refused(const std::string& path, const char* what)
{
    return refused(path, concat(what, ": ", std::strerror(errno)));
}

/// Whether an object of that name is a segment of ours, of any version, or one that was not finished:
/// it is empty, or has its size and no header.
bool is_segment(int file, std::size_t size)
{
    if (size == 0) return true;
    PacketMagic magic{};
    return pread(file, magic.data(), magic.size(), 0) == ssize_t{magic.size()} &&
           (magic == segment_magic || (size == segment_size && magic == PacketMagic{}));
}

} // namespace

void write_packet(std::span<std::byte> segment, const RingLayout& ring, std::uint64_t number,
                  std::span<const std::byte> packet) noexcept
{
    const std::size_t slot = slot_of(ring, number);
    word_at(segment, slot).store(2 * number + 1, std::memory_order_relaxed);
    std::atomic_thread_fence(std::memory_order_release);
    for (std::size_t at = 0; at < packet.size(); at += word) {
        std::uint64_t bits = 0;
        std::memcpy(&bits, packet.data() + at, std::min(word, packet.size() - at));
        word_at(segment, slot + word + at).store(bits, std::memory_order_relaxed);
    }
    word_at(segment, slot).store(2 * number + 2, std::memory_order_release);
    word_at(segment, ring.count_offset).store(number + 1, std::memory_order_release);
}

std::size_t read_packet(std::span<const std::byte> segment, const RingLayout& ring,
                        std::uint64_t number, std::span<std::byte> buffer) noexcept
{
    const std::size_t slot = slot_of(ring, number);
    const std::uint64_t there = 2 * number + 2;
    if (word_at(segment, slot).load(std::memory_order_acquire) != there) return 0;
    const auto copy_word = [&](std::size_t at) {
        const std::uint64_t bits =
            word_at(segment, slot + word + at).load(std::memory_order_relaxed);
        std::memcpy(buffer.data() + at, &bits, std::min(word, buffer.size() - at));
    };
    copy_word(0);
    // From the copy, which nobody else can change.
    const std::size_t told =
        std::to_integer<std::size_t>(buffer[6]) | std::to_integer<std::size_t>(buffer[7]) << 8U;
    const std::size_t size = std::min<std::size_t>(told, ring.slot_size - word);
    for (std::size_t at = word; at < std::min(size, buffer.size()); at += word) copy_word(at);
    std::atomic_thread_fence(std::memory_order_acquire);
    return word_at(segment, slot).load(std::memory_order_relaxed) == there ? size : 0;
}

std::uint64_t packets_written(std::span<const std::byte> segment, const RingLayout& ring) noexcept
{
    return word_at(segment, ring.count_offset).load(std::memory_order_acquire);
}

Result<SharedSegment> SharedSegment::create(std::string_view name)
{
    SharedSegment segment;
    const std::string path = concat("/proxima-", name);
    constexpr int attempts = 8;
    for (int attempt = 0; attempt < attempts; ++attempt) {
        const int file = shm_open(path.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, S_IRUSR | S_IWUSR);
        if (file < 0) return system_refused(path, "cannot make shared memory");
        segment.file_ = file;
        if (!lock_as_owner(file))
            return refused(path, "is in use by another program that runs: give another name");
        struct stat there {};
        if (fstat(file, &there) != 0) return system_refused(path, "cannot look at shared memory");
        if (there.st_nlink > 0) {
            if (there.st_uid != geteuid() ||
                !is_segment(file, static_cast<std::size_t>(there.st_size)))
                return refused(path, "exists and is no segment of ours: give another name");
            segment.path_ = path; // from here on errors remove the name
            if (fchmod(file, S_IRUSR | S_IWUSR) != 0 ||
                (std::size_t(there.st_size) != segment_size &&
                 ftruncate(file, off_t{segment_size}) != 0))
                return system_refused(path, "cannot set up shared memory");
            break;
        }
        // Its last owner removed the name between our two calls: there is a new one to be made.
        close(file);
        segment.file_ = -1;
    }
    if (segment.file_ < 0) return refused(path, "is removed again and again by other programs");
    // Pages that are not there yet would be missed only when they are written.
    errno = posix_fallocate(segment.file_, 0, off_t{segment_size});
    if (errno != 0) return system_refused(path, "there is no room for shared memory");
    void* const memory =
        mmap(nullptr, segment_size, PROT_READ | PROT_WRITE, MAP_SHARED, segment.file_, 0);
    if (memory == MAP_FAILED) return system_refused(path, "cannot map shared memory");
    segment.bytes_ = {static_cast<std::byte*>(memory), segment_size};
    segment.guard_ = TruncationGuard(segment.bytes_);
    // A stale segment may hold anything. It is opened last: from then on an engine may begin.
    store_flags(segment.bytes_, 0);
    std::memset(memory, 0, segment_size);
    const auto header = header_of_owner(0);
    std::memcpy(segment.bytes_.data(), header.data(), header.size());
    store_flags(segment.bytes_, is_open);
    return segment;
}

SharedSegment::SharedSegment(SharedSegment&& other) noexcept
    : path_(std::exchange(other.path_, {})), file_(std::exchange(other.file_, -1)),
      bytes_(std::exchange(other.bytes_, {})), guard_(std::move(other.guard_))
{}

SharedSegment& SharedSegment::operator=(SharedSegment&& other) noexcept
{
    std::swap(path_, other.path_);
    std::swap(file_, other.file_);
    std::swap(bytes_, other.bytes_);
    std::swap(guard_, other.guard_);
    return *this;
}

SharedSegment::~SharedSegment()
{
    if (!bytes_.empty()) {
        store_flags(bytes_, 0);
        guard_ = {};
        munmap(bytes_.data(), bytes_.size());
    }
    // Where somebody removed the name, it may be that of another owner's segment.
    struct stat there {};
    if (!path_.empty() && fstat(file_, &there) == 0 && there.st_nlink > 0)
        shm_unlink(path_.c_str());
    if (file_ >= 0) close(file_); // and with it the lock
}

} // namespace proxima
