// A stand-in for Force Dimension's libdhd.so: polled, metres, -1 where something fails. STUB_LEAN leaves
// functions out that older versions lack.
#include "stub_hand.h"

namespace {

stub::Hand hand;
bool is_open = false;
const char* last_error = "communication error (stub)";

} // namespace

extern "C" {

stub::State stub_state;

int dhdGetDeviceCount()
{
    return 1;
}
int dhdOpenID(char)
{
    stub_state = {};
    hand = {};
    last_error = "communication error (stub)";
    stub::read_environment(stub_state);
    if (stub_state.fail_open != stub::never) return -1;
    is_open = true;
    ++stub_state.open_devices;
    return 0;
}
int dhdClose(char)
{
    is_open = false;
    last_error = "no error (stub)";
    --stub_state.open_devices;
    return 0;
}
const char* dhdGetSystemName(char)
{
    constexpr const char* names[] = {"omega.3 (stub)", "sigma.7 (stub)", "FALCON", "delta.3"};
    return names[stub_state.model];
}
int dhdGetPosition(double* x, double* y, double* z, char)
{
    ++stub_state.ticks;
    if (!is_open || stub::unplugged(stub_state)) return -1;
    stub::move(hand, stub_state);
    *x = stub::said(hand, stub_state, 0);
    *y = stub::said(hand, stub_state, 1);
    *z = stub::said(hand, stub_state, 2);
    return 0;
}
int dhdGetLinearVelocity(double* x, double* y, double* z, char)
{
    if (!is_open || stub::unplugged(stub_state)) return -1;
    *x = hand.speed[0];
    *y = hand.speed[1];
    *z = hand.speed[2];
    return 0;
}
#ifndef STUB_LEAN
bool dhdHasWrist(char)
{
    return stub_state.wrist != stub::never;
}
int dhdGetOrientationFrame(double frame[3][3], char)
{
    if (!is_open || stub::unplugged(stub_state)) return -1;
    for (int row = 0; row < 3; ++row) {
        for (int column = 0; column < 3; ++column)
            frame[row][column] = stub::turned(stub_state, row, column);
    }
    return 0;
}
#endif
int dhdSetForce(double x, double y, double z, char)
{
    if (!is_open) ++stub_state.forces_outside;
    if (stub::unplugged(stub_state)) return -1;
    const double force[3] = {x, y, z};
    stub::take_force(hand, stub_state, force, 12);
    return 0;
}
int dhdEnableForce(unsigned char on, char)
{
    if (stub_state.fail_enable != stub::never) return -1;
    stub_state.forces_enabled += on != 0 ? 1 : -1;
    return 0;
}
int dhdGetButton(int, char)
{
    return stub::buttons(stub_state);
}
const char* dhdErrorGetLastStr()
{
    return last_error;
}
#ifndef STUB_LEAN
unsigned int dhdGetButtonMask(char)
{
    return static_cast<unsigned int>(stub::buttons(stub_state));
}
int dhdGetSerialNumber(unsigned short* number, char)
{
    *number = 1234;
    return 0;
}
void dhdGetSDKVersion(int* a, int* b, int* c, int* d)
{
    *a = 3;
    *b = 17;
    *c = 6;
    *d = 1;
}
#endif
}
