#include "cli/height_image_file.h"

#include "base/input_file.h"
#include "base/text.h"
#include "cli/npy_header.h"

#include <algorithm>
#include <csetjmp>
#include <cstring>
#include <png.h>
#include <span>
#include <string_view>
#include <utility>
#include <vector>

namespace proxima {

namespace {

constexpr std::uint64_t most_file_bytes = 64'000'000;
constexpr std::size_t signature_bytes = 8;

bool is_png(std::span<const std::byte> bytes) noexcept
{
    return bytes.size() >= signature_bytes &&
           png_sig_cmp(reinterpret_cast<png_const_bytep>(bytes.data()), 0, signature_bytes) == 0;
}

Status check_sides(std::uint64_t columns, std::uint64_t rows, const std::string& path)
{
    if (columns == 0 || rows == 0) {
        return fail(ErrorCode::malformed_file,
                    concat("the picture is ", columns, " x ", rows, ": it has no samples"), path);
    }
    if (columns <= most_image_side && rows <= most_image_side) return {};
    return fail(ErrorCode::invalid_argument,
                concat("the picture is ", columns, " x ", rows, " and may be ", most_image_side,
                       " x ", most_image_side, ": scale it down"),
                path);
}

/// The grey values of a PNG in memory. libpng leaves its functions by longjmp where a file is wrong:
/// those that call it have nothing that would have to be destroyed.
class PngGreys {
public:
    PngGreys(std::span<const std::byte> bytes, const std::string& path) : bytes_(bytes), path_(path)
    {}
    PngGreys(const PngGreys&) = delete;
    PngGreys& operator=(const PngGreys&) = delete;
    ~PngGreys() { png_destroy_read_struct(&png_, &info_, nullptr); }

    Result<HeightImage> read()
    {
        png_ = png_create_read_struct(PNG_LIBPNG_VER_STRING, this, on_error, on_warning);
        if (png_ != nullptr) info_ = png_create_info_struct(png_);
        if (info_ == nullptr) return refuse("no memory for it");
        if (!read_header()) return refuse(message_);
        if (Status status = check_header(); !status) return tl::unexpected(status.error());
        const std::size_t row_bytes = columns_ * (bits_ > 8 ? 2 : 1);
        content_.resize(rows_ * row_bytes);
        for (std::size_t row = 0; row < rows_; ++row)
            starts_.push_back(content_.data() + row * row_bytes);
        if (!read_rows()) return refuse(message_);
        return build_height_image(samples(), columns_);
    }

private:
    [[nodiscard]] tl::unexpected<Error> refuse(std::string_view why) const
    {
        return fail(ErrorCode::malformed_file, concat("this PNG cannot be read: ", why), path_);
    }

    [[nodiscard]] Status check_header() const
    {
        if (png_get_color_type(png_, info_) != PNG_COLOR_TYPE_GRAY ||
            png_get_valid(png_, info_, PNG_INFO_tRNS) != 0) {
            return fail(
                ErrorCode::unsupported_format,
                "this picture is not a grey one: save it in grey, without colours, a palette "
                "or transparency",
                path_);
        }
        return check_sides(columns_, rows_, path_);
    }

    bool read_header()
    {
        if (setjmp(png_jmpbuf(png_)) != 0) return false; // NOLINT: how libpng reports errors
        png_set_read_fn(png_, this, on_read);
        // Long sides are refused with our own words.
        png_set_user_limits(png_, PNG_UINT_31_MAX, PNG_UINT_31_MAX);
        png_read_info(png_, info_);
        columns_ = png_get_image_width(png_, info_);
        rows_ = png_get_image_height(png_, info_);
        bits_ = png_get_bit_depth(png_, info_);
        return true;
    }

    bool read_rows()
    {
        if (setjmp(png_jmpbuf(png_)) != 0) return false; // NOLINT: how libpng reports errors
        if (bits_ < 8) png_set_expand_gray_1_2_4_to_8(png_);
        png_set_interlace_handling(png_);
        png_read_update_info(png_, info_);
        png_read_image(png_, starts_.data());
        png_read_end(png_, nullptr);
        return true;
    }

    [[nodiscard]] std::vector<float> samples() const
    {
        std::vector<float> result(columns_ * rows_);
        for (std::size_t i = 0; i < result.size(); ++i) {
            result[i] = bits_ > 8 ? static_cast<float>(content_[2 * i] << 8 | content_[2 * i + 1]) /
                                        65535.0F
                                  : static_cast<float>(content_[i]) / 255.0F;
        }
        return result;
    }

    static void on_read(png_structp png, png_bytep to, std::size_t count)
    {
        auto* const self = static_cast<PngGreys*>(png_get_io_ptr(png));
        if (count > self->bytes_.size()) png_error(png, "it is cut off");
        std::memcpy(to, self->bytes_.data(), count);
        self->bytes_ = self->bytes_.subspan(count);
    }

    [[noreturn]] static void on_error(png_structp png, png_const_charp message)
    {
        auto* const self = static_cast<PngGreys*>(png_get_error_ptr(png));
        std::strncpy(self->message_, message, sizeof self->message_ - 1);
        png_longjmp(png, 1);
    }
    static void on_warning(png_structp /*png*/, png_const_charp /*message*/) {}

    std::span<const std::byte> bytes_; ///< that are left
    const std::string& path_;
    png_structp png_ = nullptr;
    png_infop info_ = nullptr;
    char message_[128] = {};
    std::size_t columns_ = 0;
    std::size_t rows_ = 0;
    unsigned bits_ = 0;
    std::vector<png_byte> content_;
    std::vector<png_bytep> starts_; ///< of the rows
};

Result<HeightImage> read_array(std::string_view bytes, const std::string& path)
{
    const auto refuse = [&](ErrorCode code, std::string message) {
        return fail(code, std::move(message), path);
    };
    const auto header = parse_npy_header(bytes.substr(0, max_npy_header));
    if (!header) return refuse(header.error().code, header.error().message);
    if (header->shape.size() != 2) {
        return refuse(ErrorCode::malformed_file,
                      concat("the array has ", header->shape.size(),
                             " dimensions: heights are of shape (rows, columns)"));
    }
    const auto [rows, columns] = std::pair(header->shape[0], header->shape[1]);
    if (Status status = check_sides(columns, rows, path); !status)
        return tl::unexpected(status.error());
    const std::size_t step = header->bytes_per_number;
    const std::uint64_t present = bytes.size() - header->length;
    if (present != rows * columns * step) {
        return refuse(ErrorCode::malformed_file,
                      concat("the header says ", rows, " x ", columns, " numbers of ", step,
                             " bytes, ", present, " bytes follow: write the file again"));
    }
    const bool whole = header->kind != NpyKind::real;
    if (whole && (step > 2 || header->kind == NpyKind::signed_whole)) {
        return refuse(
            ErrorCode::unsupported_format,
            "the array has whole numbers that are not uint8 or uint16: heights are these, "
            "or floats from 0 to 1");
    }
    const double white = !whole ? 1 : step == 1 ? 255 : 65535;
    const bool rows_first = header->order == NpyOrder::rows_first;
    std::vector<float> samples(rows * columns);
    for (std::uint64_t row = 0; row < rows; ++row) {
        for (std::uint64_t column = 0; column < columns; ++column) {
            const std::uint64_t at = rows_first ? row * columns + column : column * rows + row;
            const double value = npy_number(*header, bytes.data() + header->length + at * step);
            if (!(value >= 0 && value <= white)) {
                return refuse(ErrorCode::malformed_file,
                              concat("the number in row ", row, ", column ", column, " is ", value,
                                     " and must be from 0, the deepest, to 1, the surface: scale "
                                     "the heights"));
            }
            samples[row * columns + column] = static_cast<float>(value / white);
        }
    }
    return build_height_image(samples, columns);
}

} // namespace

Result<HeightImage> read_height_image(const std::string& path, Progress* progress)
{
    const auto file = read_file(
        path,
        {.budget = {most_file_bytes}, .progress = progress, .advice = "scale the picture down"});
    if (!file) return tl::unexpected(file.error());
    if (is_png(file->bytes)) return PngGreys(file->bytes, path).read();
    if (is_npy(file->text())) return read_array(file->text(), path);
    return fail(ErrorCode::unsupported_format,
                "this is neither a PNG nor an array of NumPy's: save it as one of them", path);
}

} // namespace proxima
