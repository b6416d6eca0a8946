// The rows of answers, which ranks make and rank 0 writes in their order.
#pragma once

#include "base/output_file.h"
#include "cli/answer_table.h"
#include "distributed/world.h"

#include <fmt/format.h>
#include <optional>
#include <string>

namespace proxima {

class RowOutput {
public:
    /// "-" is stdout. Errors: those of answer_format, file_not_writable. Collective.
    [[nodiscard]] static Result<RowOutput> open(const std::string& path, World& world);

    /// make(format) returns the text before all rows. Collective.
    template <class Make>
    [[nodiscard]] Status write_header(const Make& make)
    {
        return world_->agree_on([&] { return write_text(is_writer() ? make(format_) : ""); });
    }

    /// make(format) returns the text of this rank's rows: those of rank 0 come first. Collective.
    template <class Make>
    [[nodiscard]] Status write(const Make& make)
    {
        fmt::memory_buffer text;
        Status status = world_->agree_on([&]() -> Status {
            text = make(format_);
            return {};
        });
        if (!status) return status;
        Status written;
        world_->stream_to_first<char>(
            text.size(),
            [&](std::size_t first, std::size_t end) {
                return std::span<const char>(text.data() + first, end - first);
            },
            [&](std::span<const char> part) {
                if (written) written = write_text({part.data(), part.size()});
            });
        return world_->agree(written);
    }

    /// The file appears. Collective.
    [[nodiscard]] Status commit();

private:
    RowOutput(World& world, AnswerFormat format) : world_(&world), format_(format) {}

    [[nodiscard]] bool is_writer() const noexcept { return world_->rank() == 0; }
    [[nodiscard]] Status write_text(std::string_view text);

    World* world_;
    AnswerFormat format_;
    std::optional<OutputFile> file_; ///< on rank 0; none for stdout
};

} // namespace proxima
