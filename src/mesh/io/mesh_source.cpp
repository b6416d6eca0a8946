#include "mesh/io/mesh_source.h"

#include "base/text.h"

#include <algorithm>

namespace proxima::detail {

std::string MeshSource::at_line(const char* position) const
{
    return concat(name, ":", 1 + std::count(text.data(), position, '\n'));
}

std::string MeshSource::at_byte(const char* position) const
{
    return concat(name, ", byte ", position - text.data());
}

Status MeshSource::check_line_ends() const
{
    // Blanks and line ends behind the last line tell nothing.
    const std::string_view lines = text.substr(0, text.find_last_not_of(" \t\r\n") + 1);
    if (lines.find('\n') != std::string_view::npos || lines.find('\r') == std::string_view::npos) {
        return {};
    }
    return fail(ErrorCode::malformed_file,
                "line ends are single carriage returns: convert them to line feeds", name);
}

} // namespace proxima::detail
