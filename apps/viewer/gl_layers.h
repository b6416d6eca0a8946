// Layers in the graphics system's memory: each scene is uploaded when it is first shown and kept as
// long as it is; moving, colouring and cutting a layer uploads nothing.
#pragma once

#include "viewer/gl_scene.h"

#include <map>
#include <memory>
#include <span>
#include <vector>

namespace proxima {

/// All members need a current context, the destructor too.
class GlLayers {
public:
    /// Uploads what is new, drops what is gone. Error limit_exceeded where the graphics system has
    /// no memory left.
    [[nodiscard]] Status show(std::span<const SceneLayer> layers);

    [[nodiscard]] std::span<const GlLayer> layers() const noexcept { return layers_; }

    /// Scenes and bytes uploaded so far.
    [[nodiscard]] std::size_t uploads() const noexcept { return uploads_; }
    [[nodiscard]] std::size_t uploaded_bytes() const noexcept { return uploaded_bytes_; }

private:
    struct Uploaded {
        std::shared_ptr<const DrawnScene> scene; ///< keeps the address from being used again
        std::unique_ptr<GlScene> gl;
    };
    std::map<const DrawnScene*, Uploaded> uploaded_;
    std::vector<GlLayer> layers_;
    std::size_t uploads_ = 0;
    std::size_t uploaded_bytes_ = 0;
};

} // namespace proxima
