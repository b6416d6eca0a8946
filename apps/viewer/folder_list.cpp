#include "viewer/folder_list.h"

#include "base/progress.h"
#include "base/text.h"
#include "proxima/mesh_io.h"
#include "proxima/sample_meshes.h"

#include <algorithm>
#include <cstdlib>
#include <system_error>
#include <tuple>

namespace proxima {
namespace {

namespace fs = std::filesystem;

tl::unexpected<Error> no_folder(const fs::path& folder, const std::error_code& error)
{
    return fail(ErrorCode::file_not_found, concat("this folder cannot be read: ", error.message()),
                folder.string());
}

} // namespace

Result<FolderList> list_folder(const fs::path& folder, const Progress* progress)
{
    std::error_code error;
    FolderList list;
    list.folder = fs::weakly_canonical(folder, error);
    if (error) return no_folder(folder, error);
    fs::directory_iterator entry(list.folder, error);
    for (; !error && entry != fs::directory_iterator(); entry.increment(error)) {
        if (is_cancelled(progress)) return cancelled("listing the folder");
        if (list.entries.size() == FolderList::most_entries) {
            list.is_whole = false;
            break;
        }
        const std::string name = entry->path().filename().string();
        if (name.starts_with('.')) continue;
        std::error_code unknown; // what cannot be asked is no model
        if (entry->is_directory(unknown)) {
            list.entries.push_back({name, true});
        } else if (format_of_path(name) && entry->is_regular_file(unknown)) {
            const std::uintmax_t bytes = entry->file_size(unknown);
            list.entries.push_back({name, false, unknown ? 0 : bytes});
        }
    }
    if (error) return no_folder(folder, error);
    std::ranges::sort(list.entries, {}, [](const FolderEntry& one) {
        return std::tuple(!one.is_folder, std::string_view(one.name));
    });
    return list;
}

fs::path typed_path(std::string_view typed, const fs::path& folder)
{
    constexpr std::string_view around = " \t\r\n\"'";
    const std::size_t first = typed.find_first_not_of(around);
    if (first == std::string_view::npos) return {};
    typed = typed.substr(first, typed.find_last_not_of(around) - first + 1);
    if (is_sample_mesh_name(typed)) return typed;
    const char* const home = std::getenv("HOME");
    if (home != nullptr && (typed == "~" || typed.starts_with("~/")))
        return fs::path(home) / fs::path(typed.substr(std::min<std::size_t>(2, typed.size())));
    return folder / typed;
}

} // namespace proxima
