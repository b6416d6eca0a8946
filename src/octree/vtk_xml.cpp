#include "octree/vtk_xml.h"

#include "base/text.h"

#include <bit>

namespace proxima {

VtkXml::VtkXml(const std::string& type, const std::string& version)
    : text_(concat("<?xml version=\"1.0\"?>\n<VTKFile type=\"", type, R"(" version=")", version,
                   R"(" byte_order=")",
                   std::endian::native == std::endian::little ? "LittleEndian" : "BigEndian",
                   "\" header_type=\"UInt64\">\n"))
{}

void VtkXml::array(const std::string& type, const std::string& attributes,
                   std::span<const std::byte> bytes)
{
    text_ += concat(R"(<DataArray type=")", type, R"(" )", attributes,
                    R"( format="appended" offset=")", offset_, "\"/>\n");
    arrays_.push_back(bytes);
    offset_ += sizeof(std::uint64_t) + bytes.size();
}

Status VtkXml::write(const std::filesystem::path& path, Progress* progress) const
{
    auto file = OutputFile::create(path, {progress, text_.size() + offset_});
    if (!file) return tl::unexpected<Error>(file.error());
    if (auto status = file->write(text_); !status) return status;
    if (auto status = file->write("<AppendedData encoding=\"raw\">\n_"); !status) return status;
    for (const auto bytes : arrays_) {
        const std::uint64_t size = bytes.size();
        if (auto status = file->write(std::as_bytes(std::span(&size, 1))); !status) return status;
        if (auto status = file->write(bytes); !status) return status;
    }
    if (auto status = file->write("\n</AppendedData>\n</VTKFile>\n"); !status) return status;
    return file->commit();
}

} // namespace proxima
