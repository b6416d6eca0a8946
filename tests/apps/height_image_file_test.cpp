// Heights from PNG files and arrays: values as they are stored, and one clear error for what is wrong.
#include "cli/height_image_file.h"

#include "cli/npy_header.h"
#include "code_of.h"
#include "folder_test.h"

#include <gtest/gtest.h>
#include <png.h>

#include <algorithm>
#include <cstring>
#include <fstream>
#include <limits>
#include <random>
#include <string>
#include <vector>

namespace proxima::height_image_file_test {
namespace {

class HeightImageFile : public FolderTest {
protected:
    [[nodiscard]] Result<HeightImage> read(const std::string& bytes) const
    {
        const auto path = folder() / "height.image";
        std::ofstream(path, std::ios::binary) << bytes;
        return read_height_image(path.string());
    }
    /// The message of a file that is refused, after what it is refused for.
    [[nodiscard]] std::string refusal(const std::string& bytes, ErrorCode code) const
    {
        const auto image = read(bytes);
        if (image) return "it was read";
        EXPECT_EQ(code_of(image), code) << image.error().message;
        EXPECT_NE(image.error().where.find("height.image"), std::string::npos);
        return image.error().message;
    }
};

/// A PNG of libpng's, of one of its formats.
std::string png_of(png_uint_32 columns, png_uint_32 rows, png_uint_32 format, const void* samples,
                   const void* colours = nullptr, png_uint_32 colour_count = 0)
{
    png_image header = {};
    header.version = PNG_IMAGE_VERSION;
    header.width = columns;
    header.height = rows;
    header.format = format;
    header.colormap_entries = colour_count;
    png_alloc_size_t size = PNG_IMAGE_PNG_SIZE_MAX(header);
    std::string bytes(size, '\0');
    EXPECT_NE(png_image_write_to_memory(&header, bytes.data(), &size, 0, samples, 0, colours), 0)
        << header.message;
    bytes.resize(size);
    return bytes;
}

template <class T>
std::vector<T> random_samples(std::size_t count, std::uint64_t seed)
{
    std::mt19937_64 random(seed);
    std::vector<T> samples(count);
    for (T& sample : samples) sample = static_cast<T>(random());
    samples.front() = 0;
    samples.back() = static_cast<T>(-1); // the largest
    return samples;
}

template <class T>
void expect_samples(const Result<HeightImage>& image, std::size_t columns,
                    const std::vector<T>& samples)
{
    ASSERT_TRUE(image) << describe(image.error());
    EXPECT_EQ(image->columns(), columns);
    ASSERT_EQ(image->samples().size(), samples.size());
    const auto white = static_cast<double>(static_cast<T>(-1));
    for (std::size_t i = 0; i < samples.size(); ++i)
        EXPECT_NEAR(image->samples()[i], samples[i] / white, 1e-7) << i;
    EXPECT_EQ(image->samples().front(), 0);
    EXPECT_EQ(image->samples().back(), 1);
}

TEST_F(HeightImageFile, HasTheGreyValuesOfAPng)
{
    const auto bytes = random_samples<std::uint8_t>(35, 1);
    expect_samples(read(png_of(7, 5, PNG_FORMAT_GRAY, bytes.data())), 7, bytes);
    const auto words = random_samples<std::uint16_t>(35, 2);
    expect_samples(read(png_of(5, 7, PNG_FORMAT_LINEAR_Y, words.data())), 5, words);
    const auto large = random_samples<std::uint8_t>(most_image_side * most_image_side, 3);
    const auto image =
        read(png_of(most_image_side, most_image_side, PNG_FORMAT_GRAY, large.data()));
    ASSERT_TRUE(image);
    EXPECT_EQ(image->rows(), most_image_side);
}

TEST_F(HeightImageFile, RefusesOtherPictures)
{
    const auto bytes = random_samples<std::uint8_t>(4096, 4);
    for (const auto format : {PNG_FORMAT_RGB, PNG_FORMAT_GA, PNG_FORMAT_RGBA}) {
        EXPECT_NE(refusal(png_of(4, 4, static_cast<png_uint_32>(format), bytes.data()),
                          ErrorCode::unsupported_format)
                      .find("not a grey one"),
                  std::string::npos);
    }
    const std::vector<std::uint8_t> dots(16, 1);
    EXPECT_NE(refusal(png_of(4, 4, PNG_FORMAT_RGB_COLORMAP, dots.data(), bytes.data(), 7),
                      ErrorCode::unsupported_format)
                  .find("not a grey one"),
              std::string::npos);
    for (const bool wide : {false, true}) {
        const auto message =
            refusal(png_of(wide ? 2049 : 1, wide ? 1 : 2049, PNG_FORMAT_GRAY, bytes.data()),
                    ErrorCode::invalid_argument);
        EXPECT_NE(message.find("may be 2048 x 2048: scale it down"), std::string::npos) << message;
    }
    EXPECT_NE(refusal("P5 2 2 255 abcd", ErrorCode::unsupported_format).find("neither a PNG nor"),
              std::string::npos);
    EXPECT_FALSE(read(""));
    EXPECT_EQ(code_of(read_height_image((folder() / "none.png").string())),
              ErrorCode::file_not_found);
    EXPECT_EQ(code_of(read_height_image(folder().string())), ErrorCode::file_not_found);
}

TEST_F(HeightImageFile, RefusesEveryTruncationAndSurvivesEveryByte)
{
    const auto bytes = random_samples<std::uint8_t>(35, 5);
    const std::string png = png_of(7, 5, PNG_FORMAT_GRAY, bytes.data());
    std::string npy = npy_header(5, 7);
    const std::vector<double> heights(35, 0.5);
    npy.append(reinterpret_cast<const char*>(heights.data()), 8 * heights.size());
    std::size_t refused = 0;
    for (const std::string& whole : {png, npy}) {
        ASSERT_TRUE(read(whole));
        for (std::size_t size = 0; size < whole.size(); ++size)
            ASSERT_FALSE(read(whole.substr(0, size))) << size;
        for (std::size_t i = 0; i < whole.size(); ++i) {
            for (const char value : {'\0', '\1', '\x7f', '\xff'}) {
                std::string damaged = whole;
                damaged[i] = value;
                const auto image = read(damaged);
                if (image) continue;
                ++refused;
                EXPECT_FALSE(image.error().message.empty());
            }
        }
    }
    EXPECT_GT(refused, 4 * png.size() / 2);
    EXPECT_FALSE(read(npy + '\0'));
}

template <class T>
std::string array_of(const std::string& kind, const std::string& shape,
                     const std::vector<T>& numbers, bool columns_first = false)
{
    std::string header = "{'descr': '" + kind +
                         "', 'fortran_order': " + (columns_first ? "True" : "False") +
                         ", 'shape': " + shape + ", }";
    header.resize(117, ' ');
    header += '\n';
    std::string bytes = "\x93NUMPY";
    bytes += '\1';
    bytes += '\0';
    bytes += static_cast<char>(header.size());
    bytes += '\0';
    bytes += header;
    return bytes.append(reinterpret_cast<const char*>(numbers.data()), sizeof(T) * numbers.size());
}

TEST_F(HeightImageFile, HasTheNumbersOfAnArray)
{
    const auto bytes = random_samples<std::uint8_t>(6, 6);
    expect_samples(read(array_of("|u1", "(2, 3)", bytes)), 3, bytes);
    const auto words = random_samples<std::uint16_t>(6, 7);
    expect_samples(read(array_of("<u2", "(3, 2)", words)), 2, words);
    const std::vector<float> floats = {0, 0.25F, 1, 0.5F, 0.75F, 0.125F};
    auto image = read(array_of("<f4", "(2, 3)", floats));
    ASSERT_TRUE(image) << describe(image.error());
    EXPECT_TRUE(std::ranges::equal(image->samples(), floats));
    image = read(array_of("<f8", "(2, 3)", std::vector<double>(floats.begin(), floats.end())));
    ASSERT_TRUE(image) << describe(image.error());
    EXPECT_TRUE(std::ranges::equal(image->samples(), floats));
    image = read(array_of("<f4", "(2, 3)", floats, true));
    ASSERT_TRUE(image) << describe(image.error());
    EXPECT_TRUE(
        std::ranges::equal(image->samples(), std::vector<float>{0, 1, 0.75F, 0.25F, 0.5F, 0.125F}));
}

TEST_F(HeightImageFile, RefusesOtherArrays)
{
    const std::vector<float> six(6, 0.5F);
    const auto message = [&](const std::string& shape, const std::vector<float>& numbers,
                             ErrorCode code = ErrorCode::malformed_file) {
        return refusal(array_of("<f4", shape, numbers), code);
    };
    EXPECT_NE(message("(6,)", six).find("1 dimensions"), std::string::npos);
    EXPECT_NE(message("(1, 2, 3)", six).find("3 dimensions"), std::string::npos);
    EXPECT_NE(message("(0, 3)", {}).find("no samples"), std::string::npos);
    EXPECT_NE(message("(2, 4)", six).find("write the file again"), std::string::npos);
    EXPECT_NE(
        message("(4611686018427387904, 4)", six, ErrorCode::invalid_argument).find("scale it down"),
        std::string::npos);
    EXPECT_NE(message("(1, 2049)", std::vector<float>(2049), ErrorCode::invalid_argument)
                  .find("scale it down"),
              std::string::npos);
    for (const float wrong : {-0.001F, 1.001F, std::numeric_limits<float>::quiet_NaN(),
                              std::numeric_limits<float>::infinity()}) {
        std::vector<float> numbers = six;
        numbers[4] = wrong;
        EXPECT_NE(message("(2, 3)", numbers).find("row 1, column 1"), std::string::npos) << wrong;
    }
    EXPECT_NE(refusal(array_of("<i2", "(2, 3)", std::vector<std::int16_t>(6, 1)),
                      ErrorCode::unsupported_format)
                  .find("not uint8 or uint16"),
              std::string::npos);
    EXPECT_NE(refusal(array_of("<u4", "(2, 3)", std::vector<std::uint32_t>(6, 1)),
                      ErrorCode::unsupported_format)
                  .find("not uint8 or uint16"),
              std::string::npos);
}

} // namespace
} // namespace proxima::height_image_file_test
