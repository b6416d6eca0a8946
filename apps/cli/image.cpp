#include "cli/image.h"

#include "base/output_file.h"
#include "base/text.h"

#include <png.h>
#include <span>

namespace proxima {

Status write_png(const Image& image, const std::string& path, Progress* progress)
{
    png_image header = {};
    header.version = PNG_IMAGE_VERSION;
    header.width = static_cast<png_uint_32>(image.width);
    header.height = static_cast<png_uint_32>(image.height);
    header.format = PNG_FORMAT_RGB;
    png_alloc_size_t size = PNG_IMAGE_PNG_SIZE_MAX(header);
    std::vector<std::byte> file(size);
    if (png_image_write_to_memory(&header, file.data(), &size, 0, image.bytes.data(), 0, nullptr) ==
        0) {
        return fail(ErrorCode::file_not_writable, concat("PNG cannot be made: ", header.message),
                    path);
    }
    file.resize(size);
    auto output = OutputFile::create(path, {progress, size});
    if (!output) return tl::unexpected(output.error());
    if (auto status = output->write(file); !status) return status;
    return output->commit();
}

} // namespace proxima
