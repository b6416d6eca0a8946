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

} // namespace proxima::detail
