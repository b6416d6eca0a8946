#include "cli/image.h"

#include "base/output_file.h"
#include "base/progress.h"
#include "base/text.h"

#include <algorithm>
#include <array>
#include <csetjmp>
#include <cstddef>
#include <png.h>
#include <string_view>

namespace proxima {

namespace {

/// Rows packed by libpng, one after another. Its errors jump out of its functions: whatever calls
/// them has nothing to destroy.
class PngPacker {
public:
    PngPacker(std::vector<std::byte>& file, const Image& image)
        : file_(file),
          png_(png_create_write_struct(PNG_LIBPNG_VER_STRING, this, keep_error, ignore_warning)),
          info_(png_ == nullptr ? nullptr : png_create_info_struct(png_))
    {
        if (info_ != nullptr && begin(image)) return;
        if (error_.front() == 0) put_error("no memory");
    }

    PngPacker(const PngPacker&) = delete;
    PngPacker& operator=(const PngPacker&) = delete;
    ~PngPacker() { png_destroy_write_struct(&png_, &info_); }

    [[nodiscard]] bool pack(const std::uint8_t* row)
    {
        if (setjmp(png_jmpbuf(png_)) != 0) return false; // NOLINT(*-err52-cpp)
        png_write_row(png_, row);
        return true;
    }

    [[nodiscard]] bool finish()
    {
        if (setjmp(png_jmpbuf(png_)) != 0) return false; // NOLINT(*-err52-cpp)
        png_write_end(png_, nullptr);
        return true;
    }

    /// Empty while all went well.
    [[nodiscard]] std::string_view error() const { return error_.data(); }

private:
    bool begin(const Image& image)
    {
        if (setjmp(png_jmpbuf(png_)) != 0) return false; // NOLINT(*-err52-cpp)
        png_set_write_fn(png_, this, add, flush);
        png_set_IHDR(png_, info_, static_cast<png_uint_32>(image.width),
                     static_cast<png_uint_32>(image.height), 8, PNG_COLOR_TYPE_RGB,
                     PNG_INTERLACE_NONE, PNG_COMPRESSION_TYPE_BASE, PNG_FILTER_TYPE_BASE);
        png_set_sRGB(png_, info_, PNG_sRGB_INTENT_PERCEPTUAL);
        png_write_info(png_, info_);
        return true;
    }

    void put_error(std::string_view text) { text.copy(error_.data(), error_.size() - 1); }

    static void add(png_structp png, png_bytep data, std::size_t count)
    {
        std::vector<std::byte>& file = static_cast<PngPacker*>(png_get_io_ptr(png))->file_;
        if (count > file.capacity() - file.size()) png_error(png, "larger than expected");
        const auto* const bytes = reinterpret_cast<const std::byte*>(data);
        file.insert(file.end(), bytes, bytes + count);
    }

    static void flush(png_structp) {}

    [[noreturn]] static void keep_error(png_structp png, png_const_charp text)
    {
        static_cast<PngPacker*>(png_get_error_ptr(png))->put_error(text);
        png_longjmp(png, 1);
    }

    static void ignore_warning(png_structp, png_const_charp) {}

    std::vector<std::byte>& file_;
    std::array<char, 80> error_ = {};
    png_structp png_;
    png_infop info_;
};

Result<std::vector<std::byte>> packed_png(const Image& image, const std::string& path,
                                          Progress* progress)
{
    png_image most = {};
    most.width = static_cast<png_uint_32>(image.width);
    most.height = static_cast<png_uint_32>(image.height);
    most.format = PNG_FORMAT_RGB;
    std::vector<std::byte> file;
    file.reserve(PNG_IMAGE_PNG_SIZE_MAX(most)); // not touched, for the most part
    PngPacker packer(file, image);
    const auto failed = [&] {
        return fail(ErrorCode::file_not_writable, concat("PNG cannot be made: ", packer.error()),
                    path);
    };
    if (!packer.error().empty()) return failed();
    constexpr std::size_t block_rows = 8;
    StageSteps steps(progress, "packing the picture", static_cast<std::uint64_t>(image.height),
                     block_rows);
    const std::size_t row_bytes = 3 * static_cast<std::size_t>(image.width);
    for (std::size_t first = 0; first < image.bytes.size(); first += row_bytes) {
        if (!packer.pack(&image.bytes[first])) return failed();
        if (!steps.done(1)) return cancelled("packing the picture", path);
    }
    steps.finish();
    if (!packer.finish()) return failed();
    return file;
}

} // namespace

Status write_png(const Image& image, const std::string& path, Progress* progress)
{
    const auto file = packed_png(image, path, progress);
    if (!file) return tl::unexpected(file.error());
    auto output = OutputFile::create(path, {progress, file->size()});
    if (!output) return tl::unexpected(output.error());
    if (auto status = output->write(*file); !status) return status;
    return output->commit();
}

} // namespace proxima
