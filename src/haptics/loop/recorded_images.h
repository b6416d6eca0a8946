// The height images of a recording: the textures of a session share them.
//
//     section 10   ImageNumbers of each image
//     section 11   for each texture (recording_rows.h) the number of its image, or no_recorded_image
//     section 16   float samples of image 0, row by row from the top; 17 those of image 1, ...
#pragma once

#include "base/binary_file.h"
#include "haptics/loop/recording.h"
#include "proxima/result.h"
#include "proxima/touch_scene.h"

#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

namespace proxima {

/// In the order of the file.
struct ImageNumbers {
    std::uint32_t columns = 0;
    std::uint32_t rows = 0;
};
static_assert(sizeof(ImageNumbers) == 2 * sizeof(std::uint32_t));

inline constexpr std::uint32_t no_recorded_image = 0xffffffff;

/// The images of the textures of settings and objects.
class RecordedImages {
public:
    /// Images that share their storage are one.
    explicit RecordedImages(const RecordingSettings& settings);

    /// Appends the sections, whose bytes are in this object and in its images.
    void append_sections(std::vector<BinarySection>& sections) const;

    /// The images of a file with `textures` textures, each image checked. Error malformed_file.
    [[nodiscard]] static Result<RecordedImages> read(const BinaryFile& file, std::size_t textures);

    /// The image of a texture: number 0 is that of the settings, i + 1 that of object i.
    [[nodiscard]] std::optional<HeightImage> image_of(std::size_t texture) const;

private:
    RecordedImages() = default;
    void add(const SurfaceTexture* texture);

    std::vector<HeightImage> images_;
    std::vector<ImageNumbers> sizes_;        ///< of the images
    std::vector<std::uint32_t> of_textures_; ///< numbers of images
};

} // namespace proxima
