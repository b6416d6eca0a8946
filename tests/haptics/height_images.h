// Images of tests of textures.
#pragma once

#include "proxima/touch_scene.h"

#include <cstddef>
#include <cstdint>
#include <functional>
#include <random>
#include <vector>

namespace proxima::testing {

/// Of grey(column, row), both at the pixels' middles, from 0 to 1 across the picture.
inline HeightImage image_of(std::size_t columns, std::size_t rows,
                            const std::function<double(double, double)>& grey)
{
    std::vector<float> samples;
    for (std::size_t row = 0; row < rows; ++row) {
        for (std::size_t column = 0; column < columns; ++column) {
            samples.push_back(static_cast<float>(
                grey((static_cast<double>(column) + 0.5) / static_cast<double>(columns),
                     (static_cast<double>(row) + 0.5) / static_cast<double>(rows))));
        }
    }
    return *build_height_image(samples, columns);
}

/// Grey values at random, from black to white where there are a few.
inline HeightImage random_image(std::uint64_t seed, std::size_t columns, std::size_t rows)
{
    std::mt19937_64 random(seed);
    std::uniform_real_distribution<float> grey(0, 1);
    std::vector<float> samples(columns * rows);
    for (float& sample : samples) sample = grey(random);
    samples.front() = 0;
    samples.back() = 1;
    return *build_height_image(samples, columns);
}

} // namespace proxima::testing
