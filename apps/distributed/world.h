// All processes of a run: what one of them cannot do ends the work of all, with one message.
#pragma once

#include "base/text.h"
#include "proxima/result.h"

#include <cstddef>
#include <cstdint>
#include <limits>
#include <mpi.h>
#include <new>
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

/// The ranks of MPI_COMM_WORLD. Every member function but rank(), size() and sent_bytes() is
/// collective: all ranks call it in the same order.
class World {
public:
    World();

    [[nodiscard]] int rank() const noexcept { return rank_; }
    [[nodiscard]] int size() const noexcept { return size_; }

    /// Bytes that this rank sent to others by exchange().
    [[nodiscard]] std::uint64_t sent_bytes() const noexcept { return sent_bytes_; }

    /// On all ranks, the error of the lowest rank that has one.
    [[nodiscard]] Status agree(const Status& status) const;

    /// Calls make(), which returns a Status and takes no part in messages; memory that runs out is
    /// an error like others.
    template <class Make>
    [[nodiscard]] Status agree_on(const Make& make) const
    {
        Status status;
        try {
            status = make();
        } catch (const std::bad_alloc&) {
            status = fail(ErrorCode::budget_exceeded,
                          concat("memory ran out on rank ", rank_, " of ", size_,
                                 ": use more machines, or fewer ranks on each"));
        }
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

    [[nodiscard]] std::uint64_t sum(std::uint64_t value) const;
    [[nodiscard]] std::uint64_t max(std::uint64_t value) const;
    [[nodiscard]] std::uint64_t min(std::uint64_t value) const;
    /// The sum over the ranks below this one.
    [[nodiscard]] std::uint64_t sum_before(std::uint64_t value) const;
    /// The values of all ranks, on all of them.
    template <class T>
    [[nodiscard]] std::vector<T> share(const T& value) const
    {
        static_assert(std::is_trivially_copyable_v<T>);
        std::vector<T> values(static_cast<std::size_t>(size_));
        MPI_Allgather(&value, sizeof(T), MPI_BYTE, values.data(), sizeof(T), MPI_BYTE,
                      MPI_COMM_WORLD);
        return values;
    }
    /// The values of all ranks, on rank 0; empty elsewhere.
    [[nodiscard]] std::vector<std::uint64_t> gather(std::uint64_t value) const;

private:
    template <class T>
    [[nodiscard]] Result<Received<T>> exchange_items(std::vector<std::vector<T>>& outgoing)
    {
        const auto ranks = static_cast<std::size_t>(size_);
        std::vector<int> counts(ranks), offsets(ranks), in_counts(ranks), in_offsets(ranks);
        std::vector<T> sent;
        Received<T> received;
        Status status = agree_on([&]() -> Status {
            std::size_t total = 0;
            for (std::size_t r = 0; r < ranks; ++r) {
                if (total + outgoing[r].size() > most_items) return too_many();
                offsets[r] = static_cast<int>(total);
                counts[r] = static_cast<int>(outgoing[r].size());
                total += outgoing[r].size();
                if (static_cast<int>(r) != rank_) sent_bytes_ += outgoing[r].size() * sizeof(T);
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
        MPI_Datatype type = MPI_DATATYPE_NULL;
        MPI_Type_contiguous(static_cast<int>(sizeof(T)), MPI_BYTE, &type);
        MPI_Type_commit(&type);
        MPI_Alltoallv(sent.data(), counts.data(), offsets.data(), type, received.items.data(),
                      in_counts.data(), in_offsets.data(), type, MPI_COMM_WORLD);
        MPI_Type_free(&type);
        return received;
    }

    static constexpr std::size_t most_items = std::numeric_limits<int>::max();
    [[nodiscard]] static tl::unexpected<Error> too_many();

    int rank_ = 0;
    int size_ = 1;
    std::uint64_t sent_bytes_ = 0;
};

/// The most memory that this process had so far, in 10^6 bytes; 0 where the system does not say.
[[nodiscard]] std::uint64_t peak_megabytes();

} // namespace proxima
