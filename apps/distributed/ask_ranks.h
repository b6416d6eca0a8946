// Questions that ranks ask each other, many at once.
#pragma once

#include "distributed/world.h"

#include <algorithm>
#include <cstdint>
#include <span>
#include <type_traits>
#include <vector>

namespace proxima {

/// By rank, which of one's own questions it is asked.
using AskedRanks = std::vector<std::vector<std::uint32_t>>;

/// Asks every rank the questions that it gets: make(i) returns question i, answer(questions) on the
/// rank that is asked a vector of as many answers, and take(i, answer) is called here for each.
/// make, answer and take may throw std::bad_alloc and take no part in messages. Collective.
template <class Make, class Answer, class Take>
[[nodiscard]] Status ask_ranks(const AskedRanks& asked, const Make& make, const Answer& answer,
                               const Take& take, World& world)
{
    using Question = std::invoke_result_t<Make, std::uint32_t>;
    std::vector<std::vector<Question>> outgoing(static_cast<std::size_t>(world.size()));
    Status status = world.agree_on([&]() -> Status {
        for (std::size_t r = 0; r < asked.size(); ++r) {
            outgoing[r].reserve(asked[r].size());
            for (const std::uint32_t i : asked[r]) outgoing[r].push_back(make(i));
        }
        return {};
    });
    if (!status) return status;
    const auto questions = world.exchange(std::move(outgoing));
    if (!questions) return tl::unexpected(questions.error());
    std::invoke_result_t<Answer, std::span<const Question>> answers;
    status = world.agree_on([&]() -> Status {
        // In blocks, between which somebody may ask to stop.
        constexpr std::size_t block = 4096;
        const std::span<const Question> all(questions->items);
        answers.reserve(all.size());
        for (std::size_t first = 0; first < all.size() && !world.progress().cancelled();
             first += block) {
            const auto some = answer(all.subspan(first, std::min(block, all.size() - first)));
            answers.insert(answers.end(), some.begin(), some.end());
        }
        return {};
    });
    if (!status) return status;
    const auto received = world.reply(*questions, std::move(answers));
    if (!received) return tl::unexpected(received.error());
    return world.agree_on([&]() -> Status {
        for (std::size_t r = 0; r < asked.size(); ++r) {
            for (std::size_t k = 0; k < asked[r].size(); ++k)
                take(asked[r][k], received->items[received->first[r] + k]);
        }
        return {};
    });
}

} // namespace proxima
