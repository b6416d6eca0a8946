#include "viewer/gl_layers.h"

namespace proxima {

Status GlLayers::show(std::span<const SceneLayer> layers)
{
    std::map<const DrawnScene*, Uploaded> kept;
    layers_.clear();
    for (const SceneLayer& layer : layers) {
        const DrawnScene* const scene = layer.scene.get();
        auto found = kept.find(scene);
        if (found == kept.end()) {
            auto before = uploaded_.extract(scene);
            if (before.empty()) {
                found =
                    kept.emplace(scene, Uploaded{layer.scene, std::make_unique<GlScene>(*scene)})
                        .first;
                ++uploads_;
                uploaded_bytes_ += found->second.gl->bytes();
            } else {
                found = kept.insert(std::move(before)).position;
            }
        }
        layers_.push_back(
            {found->second.gl.get(), layer.pose, layer.color, layer.opacity, layer.cut});
    }
    uploaded_ = std::move(kept);
    for (GLenum error = glGetError(); error != GL_NO_ERROR; error = glGetError()) {
        if (error == GL_OUT_OF_MEMORY) {
            return fail(ErrorCode::limit_exceeded,
                        "the graphics system has no memory left for this picture: show less",
                        "OpenGL");
        }
        return fail(ErrorCode::broken_invariant, "an upload failed", "OpenGL");
    }
    return {};
}

} // namespace proxima
