// Scenes of objects at rest and moving, touched for many ticks, each held against every triangle.
#pragma once

#include <cstdint>

namespace proxima::soak {

/// Touches scenes of small meshes for `ticks` each, twice: by octrees, and by bodies that look at
/// all their triangles in every question. Prints a table; exit status 1 if anything was wrong.
///
///     squeezed  ticks in which moving objects left the proxy no room
///     wrong     ticks in which proxy or force differ in any bit
///     passes    ways of the proxy through a triangle, decided exactly: where objects carried it,
///               as each of them sees it, and its own moves; every triangle is asked
///     near      ticks in which it ended nearer to a triangle than its radius
///     over      ticks with more triangles near than there is room for
///     apart     how far the proxies were apart at most, of the scene's reach
[[nodiscard]] int run_scene_soak(std::uint64_t ticks, std::uint64_t seed);

} // namespace proxima::soak
