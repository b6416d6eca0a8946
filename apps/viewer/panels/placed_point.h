// A point that a panel puts somewhere until a person puts it elsewhere.
#pragma once

#include "viewer/panel.h"

#include <string_view>

namespace proxima {

struct PlacedPoint {
    Vec3 at = Vec3::Zero();
    bool is_set = false; ///< by a person

    /// Where the panel would have it: heeded until somebody has set it.
    void place(const Vec3& to)
    {
        if (!is_set) at = to;
    }
    void set(const Vec3& to)
    {
        at = to;
        is_set = true;
    }

    /// Three numbers "NAME x", "NAME y" and "NAME z", as far as three times the models' size.
    void offer(Controls& controls, std::string_view name, const ViewModels& models);
};

} // namespace proxima
