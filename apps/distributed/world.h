// All processes of a run: what one of them cannot do ends the work of all, with one message.
#pragma once

#include "base/progress.h"
#include "base/text.h"
#include "proxima/result.h"

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <map>
#include <mpi.h>
#include <new>
#include <span>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

namespace proxima {

/// What came from all ranks: those of rank r are items [first[r], first[r + 1]).
template <class T>
struct Received {
    std::vector<T> items;
    std::vector<std::size_t> first;
};

/// The ranks of MPI_COMM_WORLD. Every member function is collective where nothing else is said: all
/// ranks call it in the same order.
class World {
public:
    /// Throws std::runtime_error where the ranks cannot reach each other within these seconds.
    explicit World(double seconds);

    // Not collective.
    [[nodiscard]] int rank() const noexcept { return rank_; }
    [[nodiscard]] int size() const noexcept { return size_; }

    /// This rank's work; not collective. What cancels it on one rank stops all at the next agreement.
    [[nodiscard]] Progress& progress() noexcept { return progress_; }

    /// Processor time of this rank's work in agree_on(), without messages and waiting. Not collective.
    [[nodiscard]] double work_seconds() const noexcept { return work_seconds_; }

    /// Bytes that this rank sent to others, but for messages of a few numbers. Not collective.
    [[nodiscard]] std::uint64_t sent_bytes() const noexcept { return sent_bytes_; }

    /// Messages that had these bytes; each rank that gets an item of all_gather counts. Not collective.
    [[nodiscard]] std::uint64_t sent_messages() const noexcept { return sent_messages_; }

    /// On all ranks, the error of the lowest rank that has one.
    [[nodiscard]] Status agree(const Status& status) const;

    /// Calls make(), which returns a Status and takes no part in messages; memory that runs out is
    /// an error like others. Error cancelled where somebody asked to stop meanwhile.
    template <class Make>
    [[nodiscard]] Status agree_on(const Make& make)
    {
        return agree_on_done([&]() -> Status {
            Status status = make();
            if (status && progress_.cancelled()) status = cancelled("the work");
            return status;
        });
    }

    /// As agree_on(), but a request to stop makes no error of it: for steps that cannot be undone, such as
    /// the replacement of a file.
    template <class Make>
    [[nodiscard]] Status agree_on_done(const Make& make)
    {
        Status status;
        const double start = processor_seconds();
        try {
            status = make();
        } catch (const std::bad_alloc&) {
            status = fail(ErrorCode::budget_exceeded,
                          concat("memory ran out on rank ", rank_, " of ", size_,
                                 ": use more machines, or fewer ranks on each"));
        }
        work_seconds_ += processor_seconds() - start;
        return agree(status);
    }

    /// Sends outgoing[r] to rank r and gives it back to the system; what arrives keeps its order.
    template <class T>
    [[nodiscard]] Result<Received<T>> exchange(std::vector<std::vector<T>>&& outgoing)
    {
        static_assert(std::is_trivially_copyable_v<T>);
        return exchange_items<T>(outgoing);
    }

    /// Sends answers[i] back to where received.items[i] came from: there answers have the order of
    /// the items that were sent. Takes the answers.
    template <class T, class Answer>
    [[nodiscard]] Result<Received<Answer>> reply(const Received<T>& received,
                                                 std::vector<Answer>&& answers)
    {
        std::vector<std::vector<Answer>> outgoing(static_cast<std::size_t>(size_));
        const Status status = agree_on([&]() -> Status {
            for (std::size_t r = 0; r < outgoing.size(); ++r) {
                const auto from = answers.begin();
                outgoing[r].assign(from + static_cast<std::ptrdiff_t>(received.first[r]),
                                   from + static_cast<std::ptrdiff_t>(received.first[r + 1]));
            }
            std::vector<Answer>().swap(answers);
            return {};
        });
        if (!status) return tl::unexpected(status.error());
        return exchange(std::move(outgoing));
    }

    /// The items of all ranks, on all ranks.
    template <class T>
    [[nodiscard]] Result<Received<T>> all_gather(const std::vector<T>& items)
    {
        static_assert(std::is_trivially_copyable_v<T>);
        const auto ranks = static_cast<std::size_t>(size_);
        const std::uint64_t own = items.size();
        std::vector<std::uint64_t> sizes(ranks);
        MPI_Allgather(&own, 1, MPI_UINT64_T, sizes.data(), 1, MPI_UINT64_T, MPI_COMM_WORLD);
        std::vector<int> counts(ranks), offsets(ranks);
        Received<T> received;
        const Status status = agree_on([&]() -> Status {
            std::size_t total = 0;
            for (std::size_t r = 0; r < ranks; ++r) {
                if (sizes[r] > most_items - total) return too_many();
                received.first.push_back(total);
                offsets[r] = static_cast<int>(total);
                counts[r] = static_cast<int>(sizes[r]);
                total += sizes[r];
            }
            received.first.push_back(total);
            received.items.resize(total);
            return {};
        });
        if (!status) return tl::unexpected(status.error());
        MPI_Datatype type = item_type(sizeof(T));
        MPI_Allgatherv(items.data(), static_cast<int>(own), type, received.items.data(),
                       counts.data(), offsets.data(), type, MPI_COMM_WORLD);
        sent_bytes_ += own * sizeof(T) * (ranks - 1);
        if (own > 0) sent_messages_ += ranks - 1;
        return received;
    }

    /// Everything from all ranks, on rank 0; nothing elsewhere.
    template <class T>
    [[nodiscard]] Result<Received<T>> collect(std::vector<T> items)
    {
        std::vector<std::vector<T>> outgoing(static_cast<std::size_t>(size_));
        outgoing[0] = std::move(items);
        return exchange(std::move(outgoing));
    }

    /// Has rank 0 take the items of all ranks, in the order of the ranks and at most 4 MiB at a time:
    /// part(first, end) returns this rank's as a span, which take(items) gets there.
    template <class T, class Part, class Take>
    void stream_to_first(std::size_t count, const Part& part, const Take& take)
    {
        static_assert(std::is_trivially_copyable_v<T>);
        constexpr std::size_t block = (std::size_t{1} << 22U) / sizeof(T);
        const auto counts = gather(count);
        if (rank_ != 0) {
            for (std::size_t first = 0; first < count; first += block)
                send_to_first(std::as_bytes(part(first, std::min(count, first + block))));
            return;
        }
        for (std::size_t first = 0; first < count; first += block)
            take(part(first, std::min(count, first + block)));
        std::vector<T> items;
        for (std::size_t rank = 1; rank < counts.size(); ++rank) {
            for (std::size_t first = 0; first < counts[rank]; first += block) {
                items.resize(std::min<std::size_t>(block, counts[rank] - first));
                receive(static_cast<int>(rank), std::as_writable_bytes(std::span(items)));
                take(std::span<const T>(items));
            }
        }
    }

    /// Replaces numbers by their sums over the ranks, the same bits on all of them.
    void sum(std::span<std::int64_t> values);
    void sum(std::span<double> values);

    [[nodiscard]] std::uint64_t sum(std::uint64_t value) const;
    [[nodiscard]] double max(double value) const;
    [[nodiscard]] std::uint64_t max(std::uint64_t value) const;
    [[nodiscard]] std::uint64_t min(std::uint64_t value) const;
    /// The sum over the ranks below this one.
    [[nodiscard]] std::uint64_t sum_before(std::uint64_t value) const;
    /// The values of all ranks, on rank 0; empty elsewhere.
    [[nodiscard]] std::vector<std::uint64_t> gather(std::uint64_t value) const;

    /// Rank 0's value, on all ranks.
    [[nodiscard]] std::uint64_t from_first(std::uint64_t value) const;

    /// The error that names a file where this rank's hash of it is not that of rank 0.
    [[nodiscard]] Status expect_same(std::uint64_t hash, const std::string& file) const;

private:
    /// The type by which MPI sends items of so many bytes. Made once for each size, since Open MPI
    /// dies where it makes one and memory runs out.
    [[nodiscard]] MPI_Datatype item_type(std::size_t bytes);

    /// A message to rank 0, which receives it. At most 2^31 bytes; each waits for the other. Not
    /// collective.
    void send_to_first(std::span<const std::byte> bytes);
    static void receive(int rank, std::span<std::byte> bytes);

    template <class T>
    [[nodiscard]] Result<Received<T>> exchange_items(std::vector<std::vector<T>>& outgoing)
    {
        const auto ranks = static_cast<std::size_t>(size_);
        Received<T> received;
        if (ranks == 1) { // what stays is not copied
            const Status status = agree_on([&]() -> Status {
                received.first = {0, outgoing[0].size()};
                received.items = std::move(outgoing[0]);
                return {};
            });
            if (!status) return tl::unexpected(status.error());
            return received;
        }
        std::vector<int> counts(ranks), offsets(ranks), in_counts(ranks), in_offsets(ranks);
        std::vector<T> sent;
        Status status = agree_on([&]() -> Status {
            std::size_t total = 0;
            for (std::size_t r = 0; r < ranks; ++r) {
                if (total + outgoing[r].size() > most_items) return too_many();
                offsets[r] = static_cast<int>(total);
                counts[r] = static_cast<int>(outgoing[r].size());
                total += outgoing[r].size();
                if (static_cast<int>(r) == rank_ || outgoing[r].empty()) continue;
                sent_bytes_ += outgoing[r].size() * sizeof(T);
                ++sent_messages_;
            }
            sent.reserve(total);
            for (auto& items : outgoing) {
                sent.insert(sent.end(), items.begin(), items.end());
                std::vector<T>().swap(items);
            }
            return {};
        });
        if (!status) return tl::unexpected(status.error());
        MPI_Alltoall(counts.data(), 1, MPI_INT, in_counts.data(), 1, MPI_INT, MPI_COMM_WORLD);
        status = agree_on([&]() -> Status {
            std::size_t total = 0;
            for (std::size_t r = 0; r < ranks; ++r) {
                received.first.push_back(total);
                in_offsets[r] = static_cast<int>(total);
                total += static_cast<std::size_t>(in_counts[r]);
                if (total > most_items) return too_many();
            }
            received.first.push_back(total);
            received.items.resize(total);
            return {};
        });
        if (!status) return tl::unexpected(status.error());
        MPI_Datatype type = item_type(sizeof(T));
        MPI_Alltoallv(sent.data(), counts.data(), offsets.data(), type, received.items.data(),
                      in_counts.data(), in_offsets.data(), type, MPI_COMM_WORLD);
        return received;
    }

    /// Counts a message to another rank, where there is one.
    void count_sent(std::size_t bytes);

    /// The processor time that the calling thread has taken so far.
    [[nodiscard]] static double processor_seconds() noexcept;

    static constexpr std::size_t most_items = std::numeric_limits<int>::max();
    [[nodiscard]] static tl::unexpected<Error> too_many();

    int rank_ = 0;
    int size_ = 1;
    std::uint64_t sent_bytes_ = 0;
    std::uint64_t sent_messages_ = 0;
    double work_seconds_ = 0;
    std::map<std::size_t, MPI_Datatype> item_types_; ///< by size
    Progress progress_;
};

/// The most memory that this process had so far, in 10^6 bytes; 0 where the system does not say.
[[nodiscard]] std::uint64_t peak_megabytes();

} // namespace proxima
