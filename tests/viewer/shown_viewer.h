// A viewer without a window, for tests of what it shows.
#pragma once

#include "viewer/named_settings.h"
#include "viewer/viewer.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <gtest/gtest.h>
#include <string>
#include <string_view>
#include <vector>

namespace proxima {

inline constexpr ViewSize shown_size = {.width = 400, .height = 300};

/// A viewer that shows what the settings say, at rest.
class Shown {
public:
    Shown(std::vector<std::string> models, std::string_view panel,
          const std::vector<std::string>& settings = {})
    {
        viewer.resize(shown_size);
        EXPECT_TRUE(viewer.choose_panel(panel));
        viewer.open(std::move(models));
        const Status done = viewer.finish();
        EXPECT_TRUE(done) << describe(done.error());
        set(settings);
    }

    void set(const std::vector<std::string>& settings)
    {
        const Status applied =
            apply_settings(settings, [&](Controls& controls) { viewer.offer(controls); });
        EXPECT_TRUE(applied) << describe(applied.error());
        const Status done = viewer.finish();
        EXPECT_TRUE(done) << describe(done.error());
    }

    /// Whether all that is drawn is inside of the picture.
    [[nodiscard]] bool is_all_in_view() const
    {
        const View view(viewer.camera(), shown_size);
        return std::ranges::all_of(positions_of(scene()), [&](const Vec3& position) {
            const ScreenPoint at = view.project(position);
            return view.depth(position) > 0 && at.x > 0 && at.x < shown_size.width && at.y > 0 &&
                   at.y < shown_size.height;
        });
    }

    [[nodiscard]] std::string fact(std::string_view name) const
    {
        const auto found = std::ranges::find(viewer.facts(), name, &PanelFact::name);
        return found == viewer.facts().end() ? "" : found->value;
    }

    [[nodiscard]] double number(std::string_view name) const
    {
        const std::string text = fact(name);
        double value = std::nan("");
        std::from_chars(text.data(), text.data() + text.size(), value);
        return value;
    }

    [[nodiscard]] DrawnScene scene() const { return flattened(viewer.layers(), viewer.backdrop()); }

    /// Triangles of all surfaces of a name.
    [[nodiscard]] std::size_t triangles(std::string_view name) const
    {
        std::size_t count = 0;
        for (const SceneSurface& surface : scene().surfaces)
            if (surface.name == name) count += surface.triangles.size();
        return count;
    }
    [[nodiscard]] std::size_t segments(std::string_view name) const
    {
        std::size_t count = 0;
        for (const SceneLines& lines : scene().lines)
            if (lines.name == name) count += lines.segments.size();
        return count;
    }

    Viewer viewer;
};

} // namespace proxima
