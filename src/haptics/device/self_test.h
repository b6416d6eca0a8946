// A test of a device by itself: leads a person and the motors through steps, a tick at a time, and
// records what the device reports.
//
//     slow  ▶  fast  ▶  release  ▶  rest  ▶  six ramps  ▶  six pushes  ▶  finished
//     a hand moves it    let go   ───────── nobody touches it ─────────
//
//     ramp   the force rises until the tip moves           friction at rest
//     push   to and fro by a constant force                mass, damping, friction, delay
//
// Forces act along one axis and are at most `force_share` of the device's limit. They are zero before
// the release and after the end, once the tip is farther or faster than allowed, and in every tick
// whose input is not good. self_test_report.h computes numbers from the record.
#pragma once

#include "proxima/device.h"
#include "proxima/result.h"

#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace proxima {

enum class SelfTestStep : std::uint8_t {
    waiting, ///< for the first sample
    slow,    ///< the person moves the tip slowly
    fast,    ///< the person moves it fast
    release, ///< the person lets go in the middle, until the tip rests
    rest,    ///< nothing happens
    ramp,    ///< motors: a force that rises
    push,    ///< motors: a force to and fro
    finished ///< the force is zero, and the loop ends
};

struct SelfTestOptions {
    double tick_seconds = 1e-3;  ///< planned
    double wait_seconds = 10;    ///< at most, for the first sample
    double prepare_seconds = 3;  ///< before slow, fast and release, unless confirm() is called
    double slow_seconds = 10;    ///< of slow motion
    double fast_seconds = 4;     ///< of fast motion
    double let_go_seconds = 3;   ///< that a person has for letting go
    double release_seconds = 15; ///< at most, until the tip rests
    double rest_seconds = 1;     ///< of rest
    double force_share = 0.3;    ///< of the device's force: no force is larger
    double ramp_rate = 0.1;      ///< N/s
    double most_travel = 0.03;   ///< m from where a ramp or push began: then it is stopped
    double most_speed = 0.5;     ///< m/s, likewise
    double push_distance = 2e-3; ///< m that the first part of a push moves the tip
    double most_silence = 1;     ///< s without a sample: the test fails
};

/// Why a test ended before its time.
enum class SelfTestFault : std::uint8_t {
    none,
    no_sample,  ///< none came in wait_seconds
    not_finite, ///< a position that is not a number, or metres away
    jumped,     ///< a jump that no hand makes
    refused,    ///< the driver reported unsure input, as after it has stopped the force
    silent,     ///< nothing new for most_silence
    gone,       ///< the driver lost the device
    left,       ///< the device ended the session
    cancelled   ///< by cancel()
};

/// What happened in a tick.
struct SelfTestSample {
    double seconds = 0;           ///< of the device's clock, as tick() was given it
    double arrival = 0;           ///< s of the clock on the wall, likewise
    Vec3 position = Vec3::Zero(); ///< m, in the device's axes
    Vec3 force = Vec3::Zero();    ///< N, set in this tick
    bool fresh = true;            ///< the device reported a new sample
};

/// How a ramp or a push ended.
enum class SelfTestOutcome : std::uint8_t {
    not_done, ///< the test ended before it
    complete,
    unmoved, ///< the largest force did not move the tip
    too_far, ///< stopped: it went too far or too fast
    no_rest, ///< not begun: the tip did not rest before
    too_weak ///< not begun: friction leaves too little of the largest force
};

/// A part of the record.
struct SelfTestSegment {
    SelfTestStep step = SelfTestStep::waiting;
    int axis = 0;          ///< of a ramp or push
    double sign = 1;       ///< in which direction it began
    std::size_t begin = 0; ///< samples [begin, end)
    std::size_t end = 0;
    std::size_t lead = 0;                                ///< of these, before the force
    SelfTestOutcome outcome = SelfTestOutcome::not_done; ///< of a ramp or push
};

/// The test. tick() by the servo thread: noexcept, no allocation, no lock, O(1). step(), prepares()
/// and what they say, confirm() and cancel() by any thread; the record once the loop has ended.
class SelfTest {
public:
    /// Error invalid_argument, naming the option: not finite or negative, a share above 1.
    [[nodiscard]] static Result<SelfTest> make(const DeviceInfo& info,
                                               const SelfTestOptions& options);

    SelfTest(SelfTest&& other) noexcept;

    /// The command for a reading: its force alone, |force| <= largest_force(). `seconds` counts on
    /// the device's clock: the time, or, for a device whose time is its ticks, ticks; `arrival` is
    /// the time of the reading.
    DeviceCommand tick(const DeviceReading& reading, double seconds, double arrival) noexcept;

    /// Whether the force is zero and the loop may end.
    [[nodiscard]] bool has_ended() const noexcept { return ending_ > 8; }

    /// The step, and whether it waits for the person: prepare_seconds, or confirm().
    [[nodiscard]] SelfTestStep step() const noexcept { return step_.load(); }
    [[nodiscard]] bool prepares() const noexcept { return prepares_.load(); }
    void confirm() noexcept { confirmed_.store(true); }

    /// Ends the test: zero force from the next tick on.
    void cancel() noexcept { cancelled_.store(true); }

    [[nodiscard]] double largest_force() const noexcept { return largest_force_; } ///< N
    [[nodiscard]] SelfTestFault fault() const noexcept { return fault_; }
    [[nodiscard]] const SelfTestOptions& options() const noexcept { return options_; }
    /// Whether the tip came to rest after it was released.
    [[nodiscard]] bool rested() const noexcept { return rested_; }
    [[nodiscard]] const std::vector<SelfTestSample>& samples() const noexcept { return samples_; }
    [[nodiscard]] const std::vector<SelfTestSegment>& segments() const noexcept
    {
        return segments_;
    }
    [[nodiscard]] const InputReport& input() const noexcept { return input_.report(); }

private:
    SelfTest(DeviceInput input, const SelfTestOptions& options, double largest_force);

    [[nodiscard]] SelfTestFault fault_of(const DeviceReading& reading,
                                         InputCondition condition) noexcept;
    void end(SelfTestFault fault) noexcept;
    void begin(SelfTestStep step) noexcept;
    void begin_motor_segment() noexcept;
    void end_segment(SelfTestOutcome outcome) noexcept;
    void drop_segment() noexcept;
    void follow_person() noexcept;
    void wait_for_rest() noexcept;
    void bridge_gap() noexcept;
    [[nodiscard]] bool is_motor() const noexcept
    {
        return step() == SelfTestStep::ramp || step() == SelfTestStep::push;
    }
    void watch_rest(const Vec3& position) noexcept;
    [[nodiscard]] bool is_too_far(const Vec3& position) const noexcept;
    [[nodiscard]] double force_of_ramp(const Vec3& position) noexcept;
    [[nodiscard]] double force_of_push(const Vec3& position) noexcept;
    [[nodiscard]] double force_of_step(const Vec3& position) noexcept;

    DeviceInput input_;
    SelfTestOptions options_;
    double largest_force_;
    std::vector<SelfTestSample> samples_;   ///< never grows beyond what was reserved
    std::vector<SelfTestSegment> segments_; ///< likewise
    std::atomic<SelfTestStep> step_{SelfTestStep::waiting};
    std::atomic<bool> prepares_{false};
    std::atomic<bool> confirmed_{false};
    std::atomic<bool> cancelled_{false};
    SelfTestFault fault_ = SelfTestFault::none;

    std::uint64_t ticks_ = 0;  ///< of the step, without those of preparing
    std::uint64_t ending_ = 0; ///< ticks since the end
    std::uint64_t sample_ = 0;
    std::uint64_t silence_ = 0; ///< ticks without a good sample
    bool placed_ = false;
    bool rested_ = false;

    int motor_segment_ = 0;    ///< of twelve: ramps, then pushes
    bool settles_ = false;     ///< a ramp or push waits for rest
    Vec3 rest_ = Vec3::Zero(); ///< where the tip has been for still_ ticks
    std::uint64_t still_ = 0;
    Vec3 begun_at_ = Vec3::Zero();     ///< the tip, when the ramp or push began
    std::array<Vec3, 9> recent_{};     ///< positions of the last ticks, for the speed
    std::array<double, 3> moved_by_{}; ///< N, the largest force that a ramp of an axis took
    std::uint64_t first_part_ = 0;     ///< ticks of a push's first part, 0 while it lasts
    double push_force_ = 0;
    int restless_ = 0; ///< times that the tip moved after it had come to rest
    int gaps_ = 0;     ///< in the input, during ramps and pushes
};

} // namespace proxima
