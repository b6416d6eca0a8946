// The race for the closest point: what a participant offers and how it is driven.
//
//     ClosestPointPeer    an adapter: one query, its bytes; a BatchPeer also many queries at once
//     Contender           the same behind one virtual call per pass, so that what is hidden costs
//                         nothing per query
//
// A further peer is a class with these functions and one line in proximity_bench.cpp.
#pragma once

#include "bench_program.h"
#include "proxima/result.h"
#include "proxima/triangle_mesh.h"

#include <benchmark/benchmark.h>

#include <algorithm>
#include <chrono>
#include <concepts>
#include <cstddef>
#include <limits>
#include <memory>
#include <span>
#include <string>
#include <utility>
#include <vector>

namespace proxima::bench {

/// What every peer answers, in double: the distance to a point of the triangle it names.
struct PeerAnswer {
    double squared_distance = std::numeric_limits<double>::infinity();
    TriangleId triangle{};
};

/// A part of a peer's bytes, by what it is for.
struct BytePart {
    const char* name;
    std::size_t bytes;
};

/// Answers one query; may keep something from one query to the next, for the next to profit from.
template <class P>
concept ClosestPointPeer = requires(P& peer, const P& built, const Vec3& point)
{
    {
        peer.closest(point)
        } -> std::same_as<PeerAnswer>;
    {
        built.bytes()
        } -> std::convertible_to<std::size_t>; ///< of all that queries read
};

/// Answers a whole span, in whatever order is best. \pre as many answers as points
template <class P>
concept BatchPeer = ClosestPointPeer<P> &&
    requires(P& peer, std::span<const Vec3> points, std::span<PeerAnswer> answers)
{
    peer.closest(points, answers);
};

/// Tells what its bytes are made up of.
template <class P>
concept TellsByteParts = requires(const P& built)
{
    built.byte_parts();
};

/// Nanoseconds by the steady clock. Reading it waits for the instructions before it.
inline double nanoseconds_now()
{
    return std::chrono::duration<double, std::nano>(
               std::chrono::steady_clock::now().time_since_epoch())
        .count();
}

/// The least time between two readings of the clock, to be taken off what it measures.
inline double clock_overhead()
{
    double least = std::numeric_limits<double>::infinity();
    for (int i = 0; i < 10000; ++i) {
        const double start = nanoseconds_now();
        least = std::min(least, nanoseconds_now() - start);
    }
    return least;
}

/// A peer built for one mesh.
class Contender {
public:
    Contender() = default;
    Contender(const Contender&) = delete;
    Contender& operator=(const Contender&) = delete;
    virtual ~Contender() = default;

    [[nodiscard]] virtual std::size_t bytes() const = 0;
    /// What bytes() are made up of; empty where the peer does not tell.
    [[nodiscard]] virtual std::vector<BytePart> byte_parts() const = 0;
    [[nodiscard]] virtual bool takes_batches() const = 0;

    /// One query after the other.
    virtual void answer_singly(std::span<const Vec3> points, std::span<PeerAnswer> answers) = 0;
    /// All at once; one after the other where the peer takes no batches.
    virtual void answer_batch(std::span<const Vec3> points, std::span<PeerAnswer> answers) = 0;
    /// Times every query by itself and lowers its entry of `nanoseconds` where that was less. A
    /// pass goes over all queries, so that none finds the caches as its own last run left them.
    virtual void time_each(std::span<const Vec3> points, double overhead,
                           std::span<double> nanoseconds) = 0;

    std::string name;
    double build_seconds = 0; ///< the median, where it was built more than once
    std::size_t builds = 1;   ///< how many times it was built
    std::size_t at_most = 0;  ///< how many queries of a set it is asked, 0: all
};

template <ClosestPointPeer P>
class ContenderOf final : public Contender {
public:
    template <class... Arguments>
    explicit ContenderOf(Arguments&&... arguments) : peer_(std::forward<Arguments>(arguments)...)
    {}

    [[nodiscard]] std::size_t bytes() const override { return peer_.bytes(); }
    [[nodiscard]] std::vector<BytePart> byte_parts() const override
    {
        if constexpr (TellsByteParts<P>) {
            const auto parts = peer_.byte_parts();
            return {parts.begin(), parts.end()};
        } else {
            return {};
        }
    }
    [[nodiscard]] bool takes_batches() const override { return BatchPeer<P>; }

    void answer_singly(std::span<const Vec3> points, std::span<PeerAnswer> answers) override
    {
        for (std::size_t i = 0; i < points.size(); ++i) answers[i] = peer_.closest(points[i]);
    }

    void answer_batch(std::span<const Vec3> points, std::span<PeerAnswer> answers) override
    {
        if constexpr (BatchPeer<P>) {
            peer_.closest(points, answers);
        } else {
            answer_singly(points, answers);
        }
    }

    void time_each(std::span<const Vec3> points, double overhead,
                   std::span<double> nanoseconds) override
    {
        for (std::size_t i = 0; i < points.size(); ++i) {
            const double start = nanoseconds_now();
            benchmark::ClobberMemory();
            PeerAnswer answer = peer_.closest(points[i]);
            benchmark::DoNotOptimize(answer);
            nanoseconds[i] = std::min(nanoseconds[i], nanoseconds_now() - start - overhead);
        }
    }

private:
    P peer_;
};

/// Builds a peer from what its constructor takes, and times that on the processor.
template <ClosestPointPeer P, class... Arguments>
std::unique_ptr<Contender> make_contender(const char* name, Arguments&&... arguments)
{
    const double start = processor_seconds();
    auto contender = std::make_unique<ContenderOf<P>>(std::forward<Arguments>(arguments)...);
    contender->build_seconds = processor_seconds() - start;
    contender->name = name;
    return contender;
}

} // namespace proxima::bench
