// Any words as the arguments of proxima, up to where a command would run: done, or one line on stderr
// and the status of wrong usage or of a bad input. The bytes are words with a newline after each.
#include "base/check.h"
#include "cli/command_line.h"
#include "cli/commands.h"

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

namespace {

using namespace proxima;

/// The command with its options, which does nothing.
template <AddCommand Add>
Command without_its_work(CLI::App& app)
{
    Command command = Add(app);
    // The work owns what the options are read into.
    command.run = [work = std::move(command.run)](Session& /*session*/) { return Status(); };
    return command;
}

} // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size)
{
    // All but those of the viewer.
    static constexpr AddCommand commands[] = {
        without_its_work<add_octree_command>,       without_its_work<add_compare_command>,
        without_its_work<add_minkowski_command>,    without_its_work<add_index_command>,
        without_its_work<add_proximity_command>,    without_its_work<add_closest_command>,
        without_its_work<add_sdf_command>,          without_its_work<add_patch_command>,
        without_its_work<add_raycast_command>,      without_its_work<add_cull_command>,
        without_its_work<add_intersect_command>,    without_its_work<add_contacts_command>,
        without_its_work<add_contact_time_command>, without_its_work<add_deviation_command>,
        without_its_work<add_scene_command>,        without_its_work<add_touch_command>,
        without_its_work<add_tables_command>,       without_its_work<add_check_command>,
        without_its_work<add_repair_command>};
    std::istringstream lines(std::string(reinterpret_cast<const char*>(data), size));
    std::vector<std::string> words = {"proxima"};
    for (std::string word; std::getline(lines, word) && words.size() < 64;) {
        word.erase(std::ranges::find(word, '\0'), word.end());
        if (word.starts_with("--json")) word = "--json=-"; // any other would be opened
        words.push_back(word);
    }
    std::vector<char*> arguments;
    arguments.reserve(words.size() + 1);
    for (std::string& word : words) arguments.push_back(word.data());
    arguments.push_back(nullptr);
    const int status =
        run_command_line(static_cast<int>(words.size()), arguments.data(), "fuzz", commands);
    PROXIMA_CHECK(status >= 0 && status <= 2);
    return 0;
}
