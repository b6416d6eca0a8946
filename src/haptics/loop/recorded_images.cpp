#include "haptics/loop/recorded_images.h"

#include "base/text.h"

#include <algorithm>
#include <span>
#include <string>

namespace proxima {

namespace {

enum ImageSection : std::uint32_t {
    image_sizes_section = 10,
    images_of_textures_section = 11,
    first_image_section = 16
};

tl::unexpected<Error> wrong_images(const std::string& what)
{
    return fail(ErrorCode::malformed_file, concat(what, ": record the session again"));
}

/// Image `number` of a file. Its bytes are in memory already: nothing is taken for what sizes say.
Result<HeightImage> read_image(const BinaryFile& file, std::uint32_t number,
                               const ImageNumbers& size)
{
    const std::string of = concat("image ", number, ": ");
    const auto samples = file.section<float>(first_image_section + number);
    if (!samples) return tl::unexpected(samples.error());
    if (samples->size() != std::uint64_t{size.columns} * size.rows) {
        return wrong_images(concat(of, "there are ", samples->size(), " samples of ", size.columns,
                                   " x ", size.rows));
    }
    auto image = build_height_image(*samples, size.columns);
    if (!image) return wrong_images(of + image.error().message);
    return image;
}

} // namespace

RecordedImages::RecordedImages(const RecordingSettings& settings)
{
    add(&settings.render.texture);
    for (const ScriptedObject& object : settings.objects)
        add(object.texture ? &*object.texture : nullptr);
}

void RecordedImages::add(const SurfaceTexture* texture)
{
    of_textures_.push_back(no_recorded_image);
    if (texture == nullptr || texture->bump.shape != BumpShape::image || !texture->bump.image)
        return;
    const HeightImage& image = *texture->bump.image;
    const auto known = std::ranges::find_if(
        images_, [&](const HeightImage& other) { return &other.parts() == &image.parts(); });
    of_textures_.back() = static_cast<std::uint32_t>(known - images_.begin());
    if (known != images_.end()) return;
    images_.push_back(image);
    sizes_.push_back(
        {static_cast<std::uint32_t>(image.columns()), static_cast<std::uint32_t>(image.rows())});
}

void RecordedImages::append_sections(std::vector<BinarySection>& sections) const
{
    sections.push_back(
        {image_sizes_section, sizeof(ImageNumbers), std::as_bytes(std::span(sizes_))});
    sections.push_back(
        binary_section(images_of_textures_section, std::span<const std::uint32_t>(of_textures_)));
    for (std::uint32_t i = 0; i < images_.size(); ++i)
        sections.push_back(binary_section(first_image_section + i, images_[i].samples()));
}

Result<RecordedImages> RecordedImages::read(const BinaryFile& file, std::size_t textures)
{
    const auto sizes = file.section<ImageNumbers>(image_sizes_section);
    if (!sizes) return tl::unexpected(sizes.error());
    const auto of_textures = file.section<std::uint32_t>(images_of_textures_section);
    if (!of_textures) return tl::unexpected(of_textures.error());
    if (of_textures->size() != textures || sizes->size() > textures) {
        return wrong_images(concat("there are ", sizes->size(), " images and ", of_textures->size(),
                                   " numbers of images, for ", textures, " textures"));
    }
    RecordedImages result;
    for (std::uint32_t i = 0; i < sizes->size(); ++i) {
        auto image = read_image(file, i, (*sizes)[i]);
        if (!image) return tl::unexpected(image.error());
        result.images_.push_back(std::move(*image));
    }
    result.sizes_.assign(sizes->begin(), sizes->end());
    result.of_textures_.assign(of_textures->begin(), of_textures->end());
    for (std::size_t i = 0; i < textures; ++i) {
        const std::uint32_t number = result.of_textures_[i];
        if (number == no_recorded_image || number < sizes->size()) continue;
        return wrong_images(
            concat("texture ", i, ": its image is ", number, ", and there are ", sizes->size()));
    }
    return result;
}

std::optional<HeightImage> RecordedImages::image_of(std::size_t texture) const
{
    const std::uint32_t number = of_textures_[texture];
    if (number == no_recorded_image) return std::nullopt;
    return images_[number];
}

} // namespace proxima
