// The nasty meshes, all operations on each: a quick selection of what `scripts/soak nasty` does.
#include "lab/nasty_check.h"

#include "folder_test.h"

#include <gtest/gtest.h>
#include <map>

namespace proxima::nasty_corpus_test {
namespace {

using namespace testing;

class NastyCorpus : public FolderTest {};

TEST_F(NastyCorpus, IsAnsweredRightOrRefusedInWords)
{
    const std::vector<std::string> names = nasty_operations();
    std::map<std::string, std::uint64_t> comparisons;
    std::map<std::string, int> refusals;
    for (const oracle::NastyMesh& nasty : oracle::nasty_corpus(60)) {
        const std::vector<NastyOutcome> outcomes =
            check_nasty(nasty, {.queries = 8, .ticks = 20, .folder = folder()});
        for (std::size_t i = 0; i < names.size(); ++i) {
            EXPECT_EQ(outcomes[i].wrong, "") << nasty.name << ": " << names[i];
            comparisons[names[i]] += outcomes[i].comparisons;
            refusals[names[i]] += outcomes[i].refusal.empty() ? 0 : 1;
        }
    }
    for (const std::string& name : names) {
        EXPECT_GT(comparisons[name], 20U) << name;
        if (name != "convex polyhedron") {
            EXPECT_EQ(refusals[name], 0) << name;
        }
    }
}

} // namespace
} // namespace proxima::nasty_corpus_test
