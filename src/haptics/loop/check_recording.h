// The check that a recording can be replayed: a file may hold any numbers, under right checksums.
//
//     settings   what make_haptic_renderer takes, and no number so large or small that a product of
//                several of them overflows
//     objects    motions that never leave the bounds of their scene (object_script.h)
//     messages   motions and materials of an engine: objects that there are, finite numbers
//     ticks      positions that a device can have
//
// What a replay only compares (forces, proxies) or does not use may be anything.
#pragma once

#include "haptics/loop/recording.h"
#include "proxima/result.h"

namespace proxima {

/// Settings, objects and messages. Error malformed_file, without a place or advice, naming the first
/// field that is out of range. O(objects + messages).
[[nodiscard]] Status check_recording(const Recording& recording);

/// One tick. `number` is its place in the recording. Errors like check_recording.
[[nodiscard]] Status check_tick(const RecordedTick& tick, std::size_t number);

} // namespace proxima
