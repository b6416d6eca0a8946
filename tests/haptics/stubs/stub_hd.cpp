// A stand-in for OpenHaptics' libHD.so: its functions by their public reference, a scheduler thread
// at 1,000 Hz (or as a test sets it), millimetres, errors where the real one has them. STUB_OLD leaves
// functions out, STUB_LEAN one that may be missing.
#include "stub_hand.h"

#include <atomic>
#include <chrono>
#include <cstring>
#include <mutex>
#include <thread>

namespace {

constexpr unsigned int comm_error = 0x0302;
constexpr unsigned int exceeded_max_force = 0x0201;
constexpr unsigned int frame_error = 0x0402;
constexpr unsigned int illegal_begin = 0x0400;
constexpr unsigned int bad_handle = 0x0104;
constexpr unsigned int invalid_value = 0x0101;
constexpr unsigned int device_fault = 0x0300;
constexpr unsigned int the_device = 7;
constexpr double most = 3.3;

struct ErrorInfo {
    unsigned int code;
    int internal_code;
    unsigned int device;
};

using Callback = unsigned int (*)(void*);

stub::Hand hand;
unsigned int error = 0;
bool in_frame = false;
std::atomic<bool> running{false};
Callback callback = nullptr;
void* context = nullptr;
std::thread scheduler;

} // namespace

extern "C" {

stub::State stub_state;

unsigned int hdInitDevice(const char* name)
{
    stub_state = {};
    hand = {};
    error = 0;
    stub::read_environment(stub_state);
    const bool known = name == nullptr || std::strcmp(name, "Left") == 0;
    if (!known || stub_state.fail_open != stub::never) {
        error = known ? device_fault : bad_handle;
        return 0xFFFFFFFF;
    }
    ++stub_state.open_devices;
    return the_device;
}
void hdDisableDevice(unsigned int)
{
    --stub_state.open_devices;
}
void hdMakeCurrentDevice(unsigned int device)
{
    if (device != the_device) error = bad_handle;
}
#ifndef STUB_OLD
void hdBeginFrame(unsigned int)
{
    if (in_frame) error = illegal_begin;
    in_frame = true;
    ++stub_state.ticks;
    if (stub::unplugged(stub_state)) error = comm_error;
    stub::move(hand, stub_state);
}
void hdEndFrame(unsigned int)
{
    if (!in_frame) error = frame_error;
    if (stub_state.ticks == stub_state.write_fault) error = device_fault;
    if (stub_state.ticks == stub_state.write_refusal) error = invalid_value;
    in_frame = false;
}
#endif
ErrorInfo hdGetError()
{
    const ErrorInfo result = {error, error == 0 ? 0 : -42, the_device};
    error = 0;
    return result;
}
const char* hdGetErrorString(unsigned int code)
{
    switch (code) {
    case comm_error:
        return "Communication error";
    case exceeded_max_force:
        return "Exceeded max force";
    case device_fault:
        return "Device fault";
    case bad_handle:
        return "Bad handle";
    case invalid_value:
        return "Invalid value";
    default:
        return "Other error";
    }
}
void hdEnable(unsigned int what)
{
    stub_state.forces_enabled += what == 0x4000 ? 1 : 0;
}
void hdDisable(unsigned int what)
{
    stub_state.forces_enabled -= what == 0x4000 ? 1 : 0;
}
void hdGetIntegerv(unsigned int what, int* value)
{
    *value = what == 0x2000 ? stub::buttons(stub_state) : 0;
}
void hdGetDoublev(unsigned int what, double* value)
{
    const bool is_limit = what == 0x2551 || what == 0x2602 || what == 0x2603 || what == 0x2609;
    if (is_limit && stub_state.no_limits != stub::never) {
        error = invalid_value;
        return;
    }
    switch (what) {
    case 0x2052: // the transform, column after column, mm
        if (!in_frame) error = frame_error;
        for (int i = 0; i < 16; ++i) value[i] = i % 5 == 0 ? 1 : 0;
        for (int column = 0; column < 3; ++column) {
            for (int row = 0; row < 3; ++row)
                value[4 * column + row] = stub::turned(stub_state, row, column);
            value[12 + column] = 1e3 * stub::said(hand, stub_state, column);
        }
        break;
    case 0x2051:
        for (int i = 0; i < 3; ++i) value[i] = 1e3 * hand.speed[i];
        break;
    case 0x2602:
        *value = 0.7;
        break; // N/mm
    case 0x2603:
        *value = most;
        break; // N
    case 0x2609:
        *value = 0.005;
        break; // N s/mm
    case 0x2551: {
        const double box[6] = {-120, -100, -105, 110, 130, 140};
        std::memcpy(value, box, sizeof box);
        break;
    }
    default:
        *value = 0;
    }
}
void hdSetDoublev(unsigned int what, const double* value)
{
    if (what != 0x2700) return;
    if (!in_frame) {
        error = frame_error;
        ++stub_state.forces_outside;
    }
    stub::take_force(hand, stub_state, value, most);
    if (stub_state.ticks == stub_state.force_error) error = exceeded_max_force;
}
const char* hdGetString(unsigned int what)
{
    switch (what) {
    case 0x2500:
        return "3.40";
    case 0x2501:
        return "Stub Omni";
    case 0x2502:
        return "1.2.3";
    case 0x2503:
        return "Proxima's tests";
    case 0x2504:
        return "S-0042";
    default:
        return nullptr;
    }
}
void hdSetSchedulerRate(unsigned long rate)
{
    if (rate != 500 && rate != 1000) error = invalid_value;
}
void hdStartScheduler()
{
    if (stub_state.fail_start != stub::never) {
        error = device_fault;
        return;
    }
    running = true;
    scheduler = std::thread([] {
        auto next = std::chrono::steady_clock::now();
        while (running.load()) {
            next += std::chrono::microseconds(stub_state.period);
            std::this_thread::sleep_until(next);
            if (stub_state.ticks >= stub_state.stall) continue;
            if (callback != nullptr && callback(context) == 0) callback = nullptr;
        }
    });
}
void hdStopScheduler()
{
    running = false;
    if (scheduler.joinable()) scheduler.join();
}
unsigned long hdScheduleAsynchronous(Callback called, void* with, unsigned short)
{
    context = with;
    callback = called;
    return 1;
}
void hdUnschedule(unsigned long)
{
    callback = nullptr;
}
#ifndef STUB_LEAN
unsigned int hdCheckCalibration()
{
    return stub_state.needs_hands == stub::never ? 0x5000 : 0x5002;
}
#endif
}
