#include "distributed/world.h"

#include <ctime>
#include <fstream>
#include <stdexcept>
#include <string>

namespace proxima {

World::World(double seconds)
{
    MPI_Comm_rank(MPI_COMM_WORLD, &rank_);
    MPI_Comm_size(MPI_COMM_WORLD, &size_);
    // Where memory ran out in MPI_Init, Open MPI may go on with ranks that listen where others do not
    // send: each would wait for ever.
    // Static: where this throws, the request still has them.
    static const std::vector<int> sent(static_cast<std::size_t>(size_));
    static std::vector<int> received(sent.size());
    MPI_Request request = MPI_REQUEST_NULL;
    MPI_Ialltoall(sent.data(), 1, MPI_INT, received.data(), 1, MPI_INT, MPI_COMM_WORLD, &request);
    int is_done = 0;
    for (const double start = MPI_Wtime(); is_done == 0 && MPI_Wtime() < start + seconds;)
        MPI_Test(&request, &is_done, MPI_STATUS_IGNORE);
    // NOLINTNEXTLINE(clang-analyzer-optin.mpi.MPI-Checker): MPI_Test has ended the request
    if (is_done != 0) return;
    throw std::runtime_error("it cannot reach all other ranks: memory may have run out while MPI "
                             "started");
}

Status World::agree(const Status& status) const
{
    int first = status ? size_ : rank_;
    MPI_Allreduce(MPI_IN_PLACE, &first, 1, MPI_INT, MPI_MIN, MPI_COMM_WORLD);
    if (first == size_) return {};
    Error error = first == rank_ ? status.error() : Error{};
    int code = static_cast<int>(error.code);
    MPI_Bcast(&code, 1, MPI_INT, first, MPI_COMM_WORLD);
    error.code = static_cast<ErrorCode>(code);
    for (std::string* const text : {&error.message, &error.where}) {
        auto length = static_cast<std::uint64_t>(text->size());
        MPI_Bcast(&length, 1, MPI_UINT64_T, first, MPI_COMM_WORLD);
        text->resize(length);
        MPI_Bcast(text->data(), static_cast<int>(length), MPI_CHAR, first, MPI_COMM_WORLD);
    }
    return tl::unexpected(error);
}

namespace {

/// On all ranks the bits that rank 0 has.
void sum_numbers(void* values, std::size_t count, MPI_Datatype type, int rank)
{
    MPI_Reduce(rank == 0 ? MPI_IN_PLACE : values, values, static_cast<int>(count), type, MPI_SUM, 0,
               MPI_COMM_WORLD);
    MPI_Bcast(values, static_cast<int>(count), type, 0, MPI_COMM_WORLD);
}

} // namespace

void World::sum(std::span<std::int64_t> values)
{
    sum_numbers(values.data(), values.size(), MPI_INT64_T, rank_);
    count_sent(values.size_bytes());
}

void World::sum(std::span<double> values)
{
    sum_numbers(values.data(), values.size(), MPI_DOUBLE, rank_);
    count_sent(values.size_bytes());
}

void World::count_sent(std::size_t bytes)
{
    if (size_ == 1) return;
    sent_bytes_ += bytes;
    ++sent_messages_;
}

MPI_Datatype World::item_type(std::size_t bytes)
{
    const auto [at, is_new] = item_types_.try_emplace(bytes, MPI_DATATYPE_NULL);
    if (is_new) {
        MPI_Type_contiguous(static_cast<int>(bytes), MPI_BYTE, &at->second);
        MPI_Type_commit(&at->second);
    }
    return at->second;
}

void World::send_to_first(std::span<const std::byte> bytes)
{
    MPI_Send(bytes.data(), static_cast<int>(bytes.size()), MPI_BYTE, 0, 0, MPI_COMM_WORLD);
    count_sent(bytes.size());
}

void World::receive(int rank, std::span<std::byte> bytes)
{
    MPI_Recv(bytes.data(), static_cast<int>(bytes.size()), MPI_BYTE, rank, 0, MPI_COMM_WORLD,
             MPI_STATUS_IGNORE);
}

std::uint64_t World::sum(std::uint64_t value) const
{
    MPI_Allreduce(MPI_IN_PLACE, &value, 1, MPI_UINT64_T, MPI_SUM, MPI_COMM_WORLD);
    return value;
}

double World::max(double value) const
{
    MPI_Allreduce(MPI_IN_PLACE, &value, 1, MPI_DOUBLE, MPI_MAX, MPI_COMM_WORLD);
    return value;
}

std::uint64_t World::max(std::uint64_t value) const
{
    MPI_Allreduce(MPI_IN_PLACE, &value, 1, MPI_UINT64_T, MPI_MAX, MPI_COMM_WORLD);
    return value;
}

std::uint64_t World::min(std::uint64_t value) const
{
    MPI_Allreduce(MPI_IN_PLACE, &value, 1, MPI_UINT64_T, MPI_MIN, MPI_COMM_WORLD);
    return value;
}

std::uint64_t World::sum_before(std::uint64_t value) const
{
    std::uint64_t before = 0;
    MPI_Exscan(&value, &before, 1, MPI_UINT64_T, MPI_SUM, MPI_COMM_WORLD);
    return rank_ == 0 ? 0 : before;
}

std::vector<std::uint64_t> World::gather(std::uint64_t value) const
{
    std::vector<std::uint64_t> values(rank_ == 0 ? static_cast<std::size_t>(size_) : 0);
    MPI_Gather(&value, 1, MPI_UINT64_T, values.data(), 1, MPI_UINT64_T, 0, MPI_COMM_WORLD);
    return values;
}

std::uint64_t World::from_first(std::uint64_t value) const
{
    MPI_Bcast(&value, 1, MPI_UINT64_T, 0, MPI_COMM_WORLD);
    return value;
}

Status World::expect_same(std::uint64_t hash, const std::string& file) const
{
    Status status;
    if (from_first(hash) != hash) {
        status = fail(ErrorCode::malformed_file,
                      concat("rank ", rank_,
                             " reads another content of this file than rank 0: give all ranks the "
                             "same file, and leave it as it is"),
                      file);
    }
    return agree(status);
}

double World::processor_seconds() noexcept
{
    timespec now{};
    clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
    return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

tl::unexpected<Error> World::too_many()
{
    return fail(ErrorCode::limit_exceeded,
                "a rank would send or receive more than 2^31 items at once: use more ranks");
}

std::uint64_t peak_megabytes()
{
    std::ifstream status("/proc/self/status");
    for (std::string word; status >> word;) {
        std::uint64_t kilobytes = 0;
        if (word == "VmHWM:" && status >> kilobytes) return kilobytes * 1024 / 1'000'000;
    }
    return 0;
}

} // namespace proxima
