// Recordings of tools: read back as they were written, replayed bit for bit, and refused where forged.
#include "haptics/tool/tool_recording.h"

#include "base/binary_file.h"
#include "code_of.h"
#include "exact_copy.h"
#include "folder_test.h"
#include "haptics/tool/tool_bench.h"
#include "proxima/sample_meshes.h"

#include <array>
#include <cmath>
#include <cstring>
#include <fstream>
#include <gtest/gtest.h>
#include <iterator>
#include <limits>
#include <span>
#include <vector>

namespace proxima::testing::tool_recording_test {
namespace {

class ToolRecordings : public FolderTest {
protected:
    static MeshIndex tool() { return index_of(box_mesh({0.01, 0.006, 0.004})); }
    static ToolObject object()
    {
        return {index_of(moved(*sample_mesh("icosphere:3"),
                               [](const Vec3& p) { return Vec3(0.03 * p); })),
                {}};
    }
    static ToolRenderer renderer_for(const ToolRecordingSettings& settings)
    {
        const ToolObject touched = object();
        return make_tool_renderer(tool(), std::span(&touched, 1), settings.map, settings.device(),
                                  settings.render)
            .value();
    }
    /// A session in contact, with a sample that is no number and one that came late.
    static ToolRecording session()
    {
        ToolRecording recording;
        ToolRecordingSettings& settings = recording.settings;
        settings.model_fingerprint = object().index.mesh_fingerprint();
        settings.tool_fingerprint = tool().mesh_fingerprint();
        settings.map = {1.5, Vec3(0.001, 0.002, -0.001)};
        settings.render.torsional_damping = 1e-3;
        settings.render.force.stiffness = 600;
        settings.max_torque = 0.1;
        ToolRenderer renderer = renderer_for(settings);
        for (int i = 0; i < 400; ++i) {
            DeviceState state;
            state.pose = pose_at({4e-5 * i, 0, 0.035 - 5e-5 * i}, {0, 2e-3 * i, 3e-3 * i});
            if (i == 150) state.pose.translation.x() = std::numeric_limits<double>::quiet_NaN();
            if (i == 200) state.condition = InputCondition::silent;
            recording.ticks.push_back(recorded(state, renderer.tick(state, 1e-3)));
        }
        return recording;
    }
    static std::vector<std::byte> bytes_of(const std::filesystem::path& path)
    {
        std::ifstream file(path, std::ios::binary);
        const std::vector<char> chars{std::istreambuf_iterator<char>(file), {}};
        std::vector<std::byte> bytes(chars.size());
        std::memcpy(bytes.data(), chars.data(), chars.size());
        return bytes;
    }
    /// Reads a file after one of its numbers was changed, with right checksums.
    static Result<ToolRecording> forged(const std::vector<std::byte>& file, double before,
                                        double after)
    {
        const auto copy = testing::exact_copy(file.data(), file.size());
        bool found = false;
        for (std::size_t at = 0; at + sizeof before <= file.size() && !found; at += sizeof before) {
            found = std::memcmp(copy.get() + at, &before, sizeof before) == 0;
            if (found) std::memcpy(copy.get() + at, &after, sizeof after);
        }
        EXPECT_TRUE(found) << before;
        const std::span<std::byte> bytes(copy.get(), file.size());
        reseal_binary_file(bytes);
        return load_tool_recording(bytes, copy, "forged.pxt");
    }
};

TEST_F(ToolRecordings, AreReadAsTheyWereWrittenAndReplayWithoutADifference)
{
    const ToolRecording written = session();
    const std::filesystem::path file_path = path("session.pxt");
    ASSERT_TRUE(save_tool_recording(written, file_path).has_value());
    const auto read = load_tool_recording(file_path);
    ASSERT_TRUE(read.has_value()) << read.error().message;
    EXPECT_EQ(read->settings.tool_fingerprint, written.settings.tool_fingerprint);
    EXPECT_EQ(read->settings.model_fingerprint, written.settings.model_fingerprint);
    ASSERT_EQ(read->ticks.size(), written.ticks.size());
    ToolRenderer renderer = renderer_for(read->settings);
    int touching = 0;
    for (std::size_t i = 0; i < read->ticks.size(); ++i) {
        const DeviceState state = device_state(read->ticks[i]);
        const ToolTick& tick = renderer.tick(state, read->settings.tick_seconds);
        ASSERT_TRUE(same_response(recorded(state, tick), written.ticks[i])) << i;
        touching += tick.contact_count > 0 ? 1 : 0;
    }
    EXPECT_GT(touching, 50);
    // A response that differs is seen.
    RecordedToolTick other = written.ticks.back();
    other.torque[1] = std::nextafter(other.torque[1], 1.0);
    EXPECT_FALSE(same_response(other, written.ticks.back()));
    // Saving the same session twice gives the same bytes.
    const std::filesystem::path again = path("again.pxt");
    ASSERT_TRUE(save_tool_recording(*read, again).has_value());
    EXPECT_EQ(bytes_of(again), bytes_of(file_path));
}

/// Files of version 1 have 24 numbers: their sessions had no guard.
TEST_F(ToolRecordings, TheGuardIsPartOfTheSessionAndOffInOlderFiles)
{
    ToolRecording recording = session();
    const std::filesystem::path file_path = path("session.pxt");
    for (const Guard guard : {Guard::off, Guard::observe, Guard::on}) {
        recording.settings.render.guard = guard;
        ASSERT_TRUE(save_tool_recording(recording, file_path).has_value());
        const auto read = load_tool_recording(file_path);
        ASSERT_TRUE(read.has_value()) << read.error().message;
        EXPECT_EQ(read->settings.render.guard, guard);
    }
    const FileFormat format = {{'P', 'X', 'T', 'O', 'O', 'L', '\r', '\n'}, 2, "recording"};
    const auto file = BinaryFile::open(file_path, format, {});
    ASSERT_TRUE(file.has_value());
    const auto meshes = file->section<std::uint64_t>(1);
    const auto numbers = file->section<double>(2);
    const auto ticks = file->section<RecordedToolTick>(3);
    ASSERT_TRUE(meshes && numbers && ticks);
    ASSERT_EQ(numbers->size(), 25U);
    for (const std::uint32_t version : {1U, 2U}) {
        const FileFormat written = {format.magic, version, format.name};
        for (const std::size_t count : {24U, 25U}) {
            const std::array<BinarySection, 3> sections = {
                {{1, sizeof(std::uint64_t), std::as_bytes(std::span(*meshes))},
                 {2, sizeof(double), std::as_bytes(std::span(*numbers).first(count))},
                 {3, sizeof(RecordedToolTick), std::as_bytes(std::span(*ticks))}}};
            ASSERT_TRUE(write_binary_file(path("other.pxt"), written, sections).has_value());
            const auto read = load_tool_recording(path("other.pxt"));
            ASSERT_EQ(read.has_value(), count == 23 + version) << version << ' ' << count;
            if (read) {
                EXPECT_EQ(read->settings.render.guard, version == 1 ? Guard::off : Guard::on);
                EXPECT_EQ(read->ticks.size(), recording.ticks.size());
            }
        }
    }
}

TEST_F(ToolRecordings, ForgedNumbersAreNamed)
{
    ToolRecording recording;
    ToolRecordingSettings& settings = recording.settings;
    // Numbers that the file has once.
    settings.tick_seconds = 0.00125;
    settings.map.units_per_metre = 1.0625;
    settings.render.force.stiffness = 501.5;
    settings.render.clearance = 1.75e-5;
    settings.render.max_moves = 7;
    settings.render.max_work = 777;
    settings.render.guard = Guard::observe; // 2
    settings.render.static_friction = settings.render.dynamic_friction = 0.25;
    const std::filesystem::path file_path = path("session.pxt");
    ASSERT_TRUE(save_tool_recording(recording, file_path).has_value());
    const std::vector<std::byte> file = bytes_of(file_path);
    ASSERT_TRUE(forged(file, 777, 778).has_value());
    const double nan = std::numeric_limits<double>::quiet_NaN();
    for (const auto& [name, value] :
         {std::pair("tick_seconds", 0.00125), std::pair("units_per_metre", 1.0625),
          std::pair("stiffness", 501.5), std::pair("clearance", 1.75e-5),
          std::pair("max_moves", 7.0), std::pair("max_work", 777.0), std::pair("guard", 2.0)}) {
        for (const double bad : {nan, -1.0, 1e308}) {
            const auto read = forged(file, value, bad);
            ASSERT_FALSE(read.has_value()) << name << " " << bad;
            EXPECT_EQ(code_of(read), ErrorCode::malformed_file);
            EXPECT_NE(read.error().message.find(name), std::string::npos) << read.error().message;
            EXPECT_EQ(read.error().where, "forged.pxt");
        }
    }
}

} // namespace
} // namespace proxima::testing::tool_recording_test
