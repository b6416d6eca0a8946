#include "mesh/io/scene_files.h"

#include "base/memory_budget.h"
#include "base/text.h"

#include <algorithm>
#include <assimp/MemoryIOWrapper.h>
#include <memory>
#include <system_error>
#include <utility>

namespace proxima::detail {

namespace {

namespace fs = std::filesystem;

const std::uint8_t* bytes_of(std::string_view text) noexcept
{
    return reinterpret_cast<const std::uint8_t*>(text.data());
}

/// A file that was read for assimp alone.
class FileStream final : public Assimp::MemoryIOStream {
public:
    explicit FileStream(FileBytes file)
        : MemoryIOStream(bytes_of(file.text()), file.bytes.size()), file_(std::move(file))
    {}

private:
    FileBytes file_;
};

bool is_below(const fs::path& folder, const fs::path& file)
{
    return std::ranges::mismatch(folder, file).in1 == folder.end();
}

int hex_value(char digit) noexcept
{
    if (digit >= '0' && digit <= '9') return digit - '0';
    if (digit >= 'a' && digit <= 'f') return digit - 'a' + 10;
    return digit >= 'A' && digit <= 'F' ? digit - 'A' + 10 : -1;
}

/// "a b.bin" of "a%20b.bin", decoded once. A per cent sign without two digits stays.
std::string percent_decoded(std::string_view uri)
{
    std::string name;
    for (std::size_t i = 0; i < uri.size(); ++i) {
        const bool has_digits = uri[i] == '%' && uri.size() - i > 2 && hex_value(uri[i + 1]) >= 0 &&
                                hex_value(uri[i + 2]) >= 0;
        if (has_digits) {
            name += static_cast<char>(hex_value(uri[i + 1]) * 16 + hex_value(uri[i + 2]));
            i += 2;
        } else {
            name += uri[i];
        }
    }
    return name;
}

/// Whether decoding gave bytes that separate folders, or that no name has.
bool hides_separators(std::string_view uri, std::string_view decoded)
{
    const auto count = [](std::string_view text) {
        return std::ranges::count_if(text,
                                     [](char c) { return c == '/' || c == '\\' || c == '\0'; });
    };
    return count(uri) != count(decoded);
}

} // namespace

SceneFiles::SceneFiles(const MeshSource& source, std::string scene_name, fs::path folder,
                       MemoryBudget budget)
    : source_(source), scene_name_(std::move(scene_name)), folder_(std::move(folder)),
      bytes_left_(budget_bytes(budget))
{}

Result<fs::path> SceneFiles::find(const std::string& uri) const
{
    const std::string decoded = percent_decoded(uri);
    auto found = hides_separators(uri, decoded)
                     ? fail(ErrorCode::malformed_file,
                            concat("it refers to the file ", uri,
                                   ", whose name has an escaped slash, backslash or NUL: "
                                   "rename the file"),
                            source_.name)
                     : find_file(decoded);
    std::error_code error;
    if (decoded == uri || (found && fs::is_regular_file(*found, error))) return found;
    // Not every exporter encodes names.
    const auto verbatim = find_file(uri);
    return verbatim && fs::is_regular_file(*verbatim, error) ? verbatim : found;
}

Result<fs::path> SceneFiles::find_file(const std::string& name) const
{
    if (folder_.empty()) {
        return fail(ErrorCode::malformed_file,
                    concat("it refers to the file ", name,
                           ", which data in memory cannot have: read the scene by its path"),
                    source_.name);
    }
    const fs::path file(name);
    std::error_code error;
    const fs::path folder = fs::canonical(folder_, error);
    const fs::path found = error ? fs::path() : fs::weakly_canonical(folder / file, error);
    if (file.is_absolute() || error || std::ranges::find(file, "..") != file.end() ||
        !is_below(folder, found)) {
        return fail(ErrorCode::malformed_file,
                    concat("it refers to the file ", name,
                           ", which is not below the scene's folder: copy it there and name it "
                           "relative to the scene"),
                    source_.name);
    }
    return found;
}

bool SceneFiles::Exists(const char* name) const
{
    if (name == scene_name_) return true;
    const auto path = find(name);
    std::error_code error;
    return path && fs::is_regular_file(*path, error);
}

Assimp::IOStream* SceneFiles::Open(const char* name, const char* /*mode*/)
{
    if (name == scene_name_)
        return new Assimp::MemoryIOStream(bytes_of(source_.text), source_.text.size());
    const auto read = find(name).and_then([&](const fs::path& path) {
        // Links were followed when it was found. One that has come since may lead anywhere.
        return read_file(path, {.budget = {bytes_left_},
                                .advice = "raise the budget or split the mesh",
                                .follow_links = false});
    });
    if (!read) {
        error_ = read.error();
        if (error_->where != source_.name) {
            error_ = {read.error().code, "it refers to another file: " + describe(read.error()),
                      source_.name};
        }
        return nullptr;
    }
    // A budget of 0 would be the usual one.
    bytes_left_ = std::max<std::uint64_t>(bytes_left_ - read->bytes.size(), 1);
    return std::make_unique<FileStream>(*read).release();
}

void SceneFiles::Close(Assimp::IOStream* stream)
{
    delete stream;
}

} // namespace proxima::detail
