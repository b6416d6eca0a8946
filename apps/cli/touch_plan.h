// Which objects a device is to touch: MODEL is object 0, --object adds more; --pose, --motion and
// --material say of an object by its number where it stands, how it moves and what it is made of.
#pragma once

#include "cli/touch_texture.h"
#include "haptics/loop/recording.h"
#include "haptics/scene/scripted_scene.h"
#include "proxima/result.h"
#include "proxima/touch_scene.h"

#include <CLI/App.hpp>
#include <algorithm>
#include <numbers>
#include <string>
#include <vector>

namespace proxima {

inline constexpr double radians_per_degree = std::numbers::pi / 180;

/// As on the command line, each "N=..." but the models.
struct ObjectOptions {
    std::vector<std::string> models;
    std::vector<std::string> poses;
    std::vector<std::string> motions;
    std::vector<std::string> materials;
    std::vector<std::string> textures; ///< "N=..." or for all that is touched
    TextureImages images;              ///< that textures name, once they are read

    /// Whether a scene is asked for, and not one model at rest.
    [[nodiscard]] bool any() const
    {
        return !models.empty() || !poses.empty() || !motions.empty() || !materials.empty() ||
               std::ranges::any_of(textures, is_of_object);
    }
};

/// Adds the options; what is no pose, motion, material or texture is wrong usage.
void add_object_options(CLI::App& parser, ObjectOptions& options);

/// A scene before its models are read.
struct ScenePlan {
    std::vector<std::string> models;
    std::vector<ScriptedObject> objects; ///< fingerprints: 0 where any mesh will do
    double rotation_error = 0;           ///< of poses, see Poses
    double room = 0;                     ///< of the scene, see ScriptedScene::make
};

/// `usual` is what a material has that says less. Errors invalid_argument: too many objects, a
/// number that no object has, two words on one object.
[[nodiscard]] Result<ScenePlan> plan_scene(const std::string& model, const ObjectOptions& options,
                                           const SurfaceMaterial& usual);

/// The scene of a recording, whose poses and all it has, not those of the options; nothing of one
/// model at rest. Error invalid_argument: other models by number.
[[nodiscard]] Result<ScenePlan> plan_scene(const std::string& model, const ObjectOptions& options,
                                           const Recording& recording, const std::string& path);

} // namespace proxima
