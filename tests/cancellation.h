// Cancelling work at moments that can be repeated.
#pragma once

#include "code_of.h"
#include "proxima/execution.h"
#include "proxima/result.h"

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <gtest/gtest.h>
#include <iterator>
#include <map>
#include <string>
#include <string_view>
#include <vector>

namespace proxima::testing {

/// Runs work(progress) again and again, cancelled at its first report, its second, fourth and so
/// on, until a run ends before. Each but the last says `cancelled`, and is_unchanged() holds after
/// it. At least `least_runs` were cancelled.
template <class Work, class IsUnchanged>
void cancel_at_every_stage(const Work& work, const IsUnchanged& is_unchanged, int least_runs = 2)
{
    int runs = 0;
    for (std::uint64_t reports = 1;; reports *= 2) {
        Progress progress;
        progress.cancel_after(reports);
        const auto result = work(progress);
        // The last report of all comes when there is nothing left to stop.
        if (result && reports > 1) break;
        ++runs;
        ASSERT_FALSE(result) << "not stopped at the first report";
        EXPECT_EQ(code_of(result), ErrorCode::cancelled) << describe(result.error());
        EXPECT_TRUE(progress.cancelled());
        EXPECT_TRUE(is_unchanged()) << "after report " << reports;
    }
    EXPECT_GE(runs, least_runs);
}

/// Runs work(progress), on one thread, again and again, cancelled at each of its reports. At all of those of the stage
/// but the last it was not yet done, and each brought it on about as far as the others did.
template <class Work>
void expect_even_progress(const char* stage, const Work& work)
{
    std::vector<double> fractions;
    bool is_done = false;
    for (std::uint64_t reports = 1; !is_done; ++reports) {
        Progress progress;
        progress.cancel_after(reports);
        is_done = work(progress).has_value();
        if (!is_done && progress.stage() == std::string_view(stage))
            fractions.push_back(progress.fraction());
    }
    ASSERT_GE(fractions.size(), 4U) << stage;
    EXPECT_EQ(fractions.front(), 0);
    EXPECT_EQ(fractions.back(), 1);
    const double most = 1.5 / static_cast<double>(fractions.size() - 1);
    for (std::size_t i = 1; i < fractions.size(); ++i) {
        EXPECT_GT(fractions[i], fractions[i - 1]) << stage << ' ' << i;
        EXPECT_LT(fractions[i], fractions[i - 1] + most) << stage << ' ' << i;
    }
}

/// The names and contents of a folder's files.
inline std::map<std::string, std::string> files_in(const std::filesystem::path& folder)
{
    std::map<std::string, std::string> files;
    for (const auto& entry : std::filesystem::directory_iterator(folder)) {
        std::ifstream file(entry.path(), std::ios::binary);
        files[entry.path().filename()] = {std::istreambuf_iterator<char>(file), {}};
    }
    return files;
}

} // namespace proxima::testing
