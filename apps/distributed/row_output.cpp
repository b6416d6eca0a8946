#include "distributed/row_output.h"

#include <cstdio>

namespace proxima {

namespace {

constexpr const char* to_stdout = "-";

} // namespace

Result<RowOutput> RowOutput::open(const std::string& path, World& world)
{
    const auto format = answer_format(path);
    if (!format) return tl::unexpected(format.error());
    RowOutput output(world, *format);
    const Status status = world.agree_on([&]() -> Status {
        if (!output.is_writer() || path == to_stdout) return {};
        auto file = OutputFile::create(path);
        if (!file) return tl::unexpected(file.error());
        output.file_.emplace(std::move(*file));
        return {};
    });
    if (!status) return tl::unexpected(status.error());
    return output;
}

Status RowOutput::write_text(std::string_view text)
{
    if (!is_writer()) return {};
    if (file_) return file_->write(text);
    if (std::fwrite(text.data(), 1, text.size(), stdout) == text.size()) return {};
    return fail(ErrorCode::file_not_writable, "stdout takes no more rows");
}

Status RowOutput::commit()
{
    return world_->agree_on_done([&]() -> Status {
        if (!is_writer()) return {};
        if (file_) return file_->commit();
        if (std::fflush(stdout) == 0) return {};
        return fail(ErrorCode::file_not_writable, "stdout takes no more rows");
    });
}

} // namespace proxima
