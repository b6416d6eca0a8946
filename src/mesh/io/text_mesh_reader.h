// What the readers of text formats share: a position in the text, the mesh so far, and one error.
#pragma once

#include "mesh/io/mesh_assembler.h"
#include "mesh/io/text_cursor.h"

#include <string>
#include <utility>

namespace proxima::detail {

/// Base of one reading of one text. Steps return false where the reading ends; error() says why.
template <class Cursor>
class TextMeshReader {
protected:
    TextMeshReader(const MeshSource& source, const ReadOptions& options)
        : source_(source), cursor_(without_byte_order_mark(source.text)), mesh_(source, options),
          progress_(options.execution.progress, source.text)
    {}

    [[nodiscard]] const Error& error() const noexcept { return error_; }

    /// False, with an error, where the watcher asks to stop.
    [[nodiscard]] bool may_continue()
    {
        if (progress_.may_continue(cursor_.position())) return true;
        error_ = cancelled("reading", source_.name).value();
        return false;
    }

    /// An error at the line of `position`.
    bool refuse_at(const char* position, ErrorCode code, std::string message)
    {
        error_ = {code, std::move(message), source_.at_line(position)};
        return false;
    }

    /// An error at the line where reading is.
    bool refuse(std::string message, ErrorCode code = ErrorCode::malformed_file)
    {
        return refuse_at(cursor_.position(), code, std::move(message));
    }

    bool refused_by_mesh()
    {
        error_ = mesh_.error();
        return false;
    }

    const MeshSource& source_;
    Cursor cursor_;
    MeshAssembler mesh_;

private:
    ReadProgress progress_;
    Error error_;
};

} // namespace proxima::detail
