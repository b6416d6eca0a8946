// Height images against closed forms of splines, brute force over their cells, and each other.
#include "haptics/surface/height_image.h"

#include "code_of.h"
#include "haptics/height_images.h"
#include "haptics/surface/height_field.h"
#include "proxima/device.h"
#include "proxima/haptic_renderer.h"
#include "proxima/mesh_index.h"
#include "proxima/sample_meshes.h"

#include <Eigen/Eigenvalues>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <random>
#include <string>
#include <vector>

namespace proxima::height_image_test {
namespace {

using testing::image_of;
using testing::random_image;

constexpr double turn = 2 * std::numbers::pi;

Bump bump_of(const HeightImage& image, const Vec3& direction = Vec3::UnitZ())
{
    return {.shape = BumpShape::image,
            .amplitude = 1e-4,
            .wavelength = 0.004,
            .direction = direction,
            .image = image};
}

struct ImageSize {
    std::size_t columns;
    std::size_t rows;
};
constexpr ImageSize sizes[] = {{1, 1}, {1, 4}, {2, 1}, {2, 2}, {3, 5}, {16, 7}, {33, 40}};

/// Of a cosine with n samples per wave: the part that is left, and the most that aliases add to h and
/// to its slope. A cubic B-spline's transform is the fourth power of sinc.
struct Sampling {
    double left;
    double value;
    double slope;
};

Sampling sampling_of(double n)
{
    const auto part = [n](int m) {
        const double x = std::numbers::pi * (m + 1 / n);
        return std::pow(std::sin(x) / x, 4);
    };
    Sampling sampling{part(0), 0, 0};
    for (int m = 1; m <= 10000; ++m) {
        sampling.value += part(m) + part(-m);
        sampling.slope += turn * (part(m) * (n * m + 1) + part(-m) * (n * m - 1));
    }
    return sampling;
}

TEST(HeightImage, OfACosineIsTheGratingThatIsLeft)
{
    const std::uint64_t seed = 5;
    SCOPED_TRACE(seed);
    std::mt19937_64 random(seed);
    std::uniform_real_distribution<double> place(-0.02, 0.02);
    for (const std::size_t n : {3, 4, 8, 16, 64, 500}) {
        const Sampling sampling = sampling_of(static_cast<double>(n));
        // What the header says is left, and 33 to 97 % for 2 to 16 pixels, at the samples themselves.
        const double at_samples = 1 - (1 - std::cos(turn / static_cast<double>(n))) / 3;
        EXPECT_NEAR(sampling.left, at_samples, sampling.value + 1e-12);
        for (const bool upwards : {false, true}) {
            const auto grey = [&](double column, double row) {
                return 0.5 + 0.5 * std::cos(turn * (upwards ? 1 - row : column));
            };
            const Bump bump = bump_of(upwards ? image_of(n, n, grey) : image_of(n, 3, grey));
            Bump grating = {.shape = BumpShape::grating,
                            .amplitude = bump.amplitude,
                            .wavelength = bump.wavelength,
                            .direction = upwards ? Vec3::UnitY() : Vec3::UnitX()};
            constexpr double rounding = 1e-6; // of samples in floats
            for (int i = 0; i < 500; ++i) {
                const Vec3 p(place(random), place(random), place(random));
                const Groove groove = groove_at(bump, p);
                const Groove exact = groove_at(grating, p);
                const double h = 1 - groove.depth / bump.amplitude;
                const double expected = sampling.left * (1 - exact.depth / bump.amplitude);
                EXPECT_NEAR(h, expected, sampling.value + rounding) << n;
                const double unit = bump.amplitude / bump.wavelength;
                EXPECT_LT((groove.slope - sampling.left * exact.slope).norm(),
                          unit * (sampling.slope + rounding * static_cast<double>(n)))
                    << n;
            }
        }
    }
}

TEST(HeightImage, IsUprightAndNotMirrored)
{
    // White but for a dark pixel in the first row, second column, of four by eight.
    std::vector<float> samples(32, 1.0F);
    samples[1] = 0;
    const HeightImage image = *build_height_image(samples, 4);
    EXPECT_EQ(image.columns(), 4U);
    EXPECT_EQ(image.rows(), 8U);
    const double width = 0.004;
    const double right = 1.5 / 4 * width;
    const double up = (2 - 0.5 / 4) * width;
    struct View {
        Vec3 direction;
        Vec3 right;
        Vec3 up;
    };
    const Vec3 x = Vec3::UnitX();
    const Vec3 y = Vec3::UnitY();
    const Vec3 z = Vec3::UnitZ();
    for (const View& view : {View{z, x, y}, View{x, y, z}, View{-y, x, z}, View{y, -x, z},
                             View{-z, -x, y}, View{3 * z + x, (3 * x - z).normalized(), y}}) {
        const Bump bump = bump_of(image, 7 * view.direction);
        const Vec3 at = right * view.right + up * view.up;
        // Of a lone sample 4/9 is left in its middle.
        EXPECT_NEAR(groove_at(bump, at).depth, 2 * bump.amplitude * 4 / 9, 1e-17);
        EXPECT_NEAR(groove_at(bump, at + 0.3 * view.direction).depth, 2 * bump.amplitude * 4 / 9,
                    1e-16);
        EXPECT_LT(groove_at(bump, at).slope.norm(), 1e-12);
        EXPECT_LT(groove_at(bump, right * view.right + 0.5 * up * view.up).depth, 1e-18);
        // It falls to the right of the pixel's left, and from below it upwards.
        EXPECT_GT(groove_at(bump, at - 0.1 * width * view.right).slope.dot(view.right), 1e-3);
        EXPECT_GT(groove_at(bump, at - 0.1 * width * view.up).slope.dot(view.up), 1e-3);
    }
}

TEST(HeightImage, IsTiled)
{
    std::mt19937_64 random(3);
    std::uniform_real_distribution<double> part(0, 1);
    for (const auto& [columns, rows] : sizes) {
        const Bump bump = bump_of(random_image(columns, columns, rows));
        const double height =
            bump.wavelength * static_cast<double>(rows) / static_cast<double>(columns);
        for (int i = 0; i < 200; ++i) {
            const Vec3 p(bump.wavelength * part(random), height * part(random), 0.3);
            const Groove groove = groove_at(bump, p);
            for (const int k : {-1000, -1, 1, 1000}) {
                const Groove right = groove_at(bump, p + Vec3(k * bump.wavelength, 0, 0));
                const Groove up = groove_at(bump, p + Vec3(0, k * height, 0));
                EXPECT_NEAR(right.depth, groove.depth, 1e-14);
                EXPECT_NEAR(up.depth, groove.depth, 1e-14);
                EXPECT_LT((right.slope - groove.slope).norm(), 1e-9);
                EXPECT_LT((up.slope - groove.slope).norm(), 1e-9);
            }
        }
    }
    // Where the phase is not known there is none.
    const Bump bump = bump_of(random_image(1, 4, 4));
    EXPECT_EQ(groove_at(bump, Vec3(1e300, 0, 0)).depth, 0);
    EXPECT_EQ(groove_at(bump, Vec3(std::numeric_limits<double>::quiet_NaN(), 0, 0)).depth, 0);
}

TEST(HeightImage, SlopeIsTheGradient)
{
    std::mt19937_64 random(9);
    std::uniform_real_distribution<double> place(-0.01, 0.01);
    for (const auto& [columns, rows] : sizes) {
        const Bump bump = bump_of(random_image(columns, columns, rows), Vec3(1, -2, 0.7));
        const double steepest = bump.amplitude / bump.wavelength * bump.image->parts().slope();
        const double step = 1e-3 * bump.wavelength / static_cast<double>(columns);
        for (int i = 0; i < 500; ++i) {
            const Vec3 p(place(random), place(random), place(random));
            const Groove groove = groove_at(bump, p);
            for (Eigen::Index axis = 0; axis < 3; ++axis) {
                const double difference = groove_at(bump, p + step * Vec3::Unit(axis)).depth -
                                          groove_at(bump, p - step * Vec3::Unit(axis)).depth;
                EXPECT_NEAR(difference / (2 * step), groove.slope[axis], 1e-5 * steepest + 1e-12);
            }
        }
    }
}

TEST(HeightImage, SlopeAndCurvatureAreContinuousAtPixelsAndSeams)
{
    for (const auto& [columns, rows] : sizes) {
        const Bump bump = bump_of(random_image(columns, columns, rows));
        const HeightSamples& parts = bump.image->parts();
        const double pixel = bump.wavelength / static_cast<double>(columns);
        const double unit = bump.amplitude / (bump.wavelength * bump.wavelength);
        const double step = 1e-5 * pixel;
        // Knots are in the middles of pixels, seams between two of them.
        for (std::size_t i = 0; i <= 2 * std::max(columns, rows); ++i) {
            const double at = 0.5 * pixel * static_cast<double>(i);
            for (const Vec3& along : {Vec3(Vec3::UnitX()), Vec3(Vec3::UnitY())}) {
                const Vec3 p = at * along + 0.3 * pixel * Vec3(along.y(), along.x(), 0);
                const Vec3 before = groove_at(bump, p - step * along).slope;
                const Vec3 there = groove_at(bump, p).slope;
                const Vec3 after = groove_at(bump, p + step * along).slope;
                EXPECT_LE((after - before).norm(),
                          2 * step * unit * parts.curvature() * 1.001 + 1e-15);
                // The curvature of both sides: its own slope is at most 8 by pixels and samples.
                const double jump = (after - 2 * there + before).norm() / step;
                EXPECT_LE(jump, 1e-3 * unit * 16 * std::pow(static_cast<double>(columns), 2))
                    << columns << ' ' << rows << ' ' << i;
            }
        }
    }
}

TEST(HeightImage, SlopeAndCurvatureKeepTheirBounds)
{
    const auto smooth = [](double column, double row) {
        return 0.5 + 0.25 * std::cos(turn * column) + 0.25 * std::cos(turn * (2 * column + row));
    };
    std::vector<std::pair<HeightImage, double>> images; // by how much bounds may exceed
    images.emplace_back(image_of(64, 32, smooth), 1.3);
    images.emplace_back(image_of(64, 8, [](double c, double) { return c < 0.5 ? 1 : 0; }), 2);
    for (const auto& [columns, rows] : sizes)
        if (columns * rows > 1) images.emplace_back(random_image(7, columns, rows), 3);
    for (const auto& [image, loose] : images) {
        const HeightSamples& parts = image.parts();
        const double shape =
            static_cast<double>(image.rows()) / static_cast<double>(image.columns());
        const double step = 1e-5 / static_cast<double>(image.columns());
        double steep = 0;
        double bent = 0;
        constexpr std::size_t fine = 6; // by pixel
        for (std::size_t i = 0; i < fine * image.columns(); ++i) {
            for (std::size_t j = 0; j < fine * image.rows(); ++j) {
                const double right =
                    static_cast<double>(i) / static_cast<double>(fine * image.columns());
                const double up =
                    shape * static_cast<double>(j) / static_cast<double>(fine * image.rows());
                const ImageHeight at = height_at(parts, right, up);
                EXPECT_LE(at.value, 1 + 1e-15);
                EXPECT_GE(at.value, -1 - 1e-15);
                steep = std::max(steep, std::hypot(at.right, at.up));
                const ImageHeight beside = height_at(parts, right + step, up);
                const ImageHeight above = height_at(parts, right, up + step);
                Eigen::Matrix2d hessian;
                hessian << beside.right - at.right, above.right - at.right, beside.up - at.up,
                    above.up - at.up;
                bent = std::max(bent, hessian.operatorNorm() / step);
            }
        }
        EXPECT_LE(steep, parts.slope() * (1 + 1e-9)) << image.columns() << ' ' << image.rows();
        EXPECT_LE(bent, parts.curvature() * (1 + 1e-3)) << image.columns() << ' ' << image.rows();
        EXPECT_GE(loose * steep, parts.slope()) << image.columns() << ' ' << image.rows();
        EXPECT_GE(loose * bent, parts.curvature()) << image.columns() << ' ' << image.rows();
    }
}

TEST(HeightImage, AmplitudeIsLimitedByItsSlopeAndCurvature)
{
    const DeviceLimits omni = *find_device("omni");
    const HeightImage image = random_image(4, 20, 20);
    for (const double wavelength : {5e-4, 0.01, 0.3}) {
        Bump bump = bump_of(image);
        bump.wavelength = wavelength;
        const double a = most_amplitude(bump, 500, omni);
        const double s = image.parts().slope() / wavelength;
        const double c = image.parts().curvature() / (wavelength * wavelength);
        const double added = 500 * s * s * a * a + omni.max_force * c * a;
        EXPECT_LE(added, omni.max_stiffness * (1 + 1e-9)) << wavelength;
        EXPECT_LE(s * a, 1 + 1e-9) << wavelength;
        EXPECT_TRUE(s * a > 0.999 || added > 0.999 * omni.max_stiffness) << wavelength;
        bump.amplitude = 0.01;
        EXPECT_EQ(limited({.bump = bump}, 500, omni).bump.amplitude, std::min(a, 0.01));
        EXPECT_EQ(limited_strengths({.bump = bump}, 500, omni).amplitude, std::min(a, 0.01));
    }
    // A flat one only lowers the surface.
    Bump flat = bump_of(*build_height_image(std::vector<float>(12, 0.25F), 4));
    flat.amplitude = 0.01;
    EXPECT_EQ(limited({.bump = flat}, 500, omni).bump.amplitude, 0.01);
    EXPECT_NEAR(groove_at(flat, Vec3(0.1, 0.2, 0.3)).depth, 0.015, 1e-16);
    EXPECT_LT(groove_at(flat, Vec3(0.1, 0.2, 0.3)).slope.norm(), 1e-13);
}

TEST(HeightImage, WrongSamplesAreNamed)
{
    const auto message = [](const std::vector<float>& samples, std::size_t columns) {
        const auto image = build_height_image(samples, columns);
        if (image) return std::string();
        EXPECT_EQ(code_of(image), ErrorCode::invalid_argument);
        EXPECT_EQ(image.error().where, "height image");
        return image.error().message;
    };
    EXPECT_EQ(message({0, 1, 0.5F}, 3), "");
    EXPECT_NE(message({}, 3).find("no samples"), std::string::npos);
    EXPECT_NE(message({0, 1}, 0).find("no samples"), std::string::npos);
    EXPECT_NE(message({0, 1, 0.5F}, 2).find("3 samples are no whole number of rows of 2"),
              std::string::npos);
    EXPECT_NE(message({0, 1}, 3).find("no whole number"), std::string::npos);
    const std::size_t most = most_image_side;
    EXPECT_EQ(message(std::vector<float>(most), 1), "");
    EXPECT_EQ(message(std::vector<float>(most), most), "");
    for (const std::size_t columns : {std::size_t{1}, most + 1}) {
        EXPECT_NE(message(std::vector<float>(most + 1), columns).find("at most 2048"),
                  std::string::npos);
    }
    for (const float wrong :
         {-1e-6F, 1.0001F, std::numeric_limits<float>::quiet_NaN(),
          std::numeric_limits<float>::infinity(), -std::numeric_limits<float>::infinity()}) {
        EXPECT_NE(message({0, 0, 0, 0, 0, wrong}, 2).find("row 2, column 1"), std::string::npos)
            << wrong;
    }
}

TEST(HeightImage, IsNeededByItsShapeAndIgnoredByOthers)
{
    const auto index = build_mesh_index(*sample_mesh("cube"));
    ASSERT_TRUE(index);
    RenderOptions options;
    options.texture.bump.shape = BumpShape::image;
    const auto made =
        make_haptic_renderer(*index, {1, Vec3::Zero()}, *find_device("omni"), options);
    ASSERT_FALSE(made);
    EXPECT_NE(made.error().message.find("is an image and has none"), std::string::npos);
    const auto body = build_touch_body(*index, {.texture = options.texture});
    ASSERT_FALSE(body);
    EXPECT_EQ(body.error().message, made.error().message);
    EXPECT_EQ(groove_at(options.texture.bump, Vec3(1, 2, 3)).depth, 0);
    Bump noise = {.shape = BumpShape::noise, .amplitude = 1e-4};
    const double depth = groove_at(noise, Vec3(1, 2, 3)).depth;
    noise.image = random_image(1, 3, 3);
    EXPECT_EQ(groove_at(noise, Vec3(1, 2, 3)).depth, depth);
    EXPECT_TRUE(check_texture({.bump = noise}));
}

} // namespace
} // namespace proxima::height_image_test
