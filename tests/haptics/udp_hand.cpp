// A device in a program of its own: sends where its hand is to `proxima touch MODEL --device
// udp:PORT`, a thousand times a second, and makes the force from the contact planes that come back.
#include "base/udp_socket.h"
#include "haptics/device/remote_servo.h"
#include "lab/simulated_hand.h"

#include <chrono>
#include <cmath>
#include <cstdlib>
#include <iostream>
#include <thread>

int main(int argc, char** argv)
{
    const auto to = proxima::parse_udp_address(argc > 1 ? argv[1] : "4711");
    auto socket = proxima::UdpSocket::listen({});
    if (!to || !socket) {
        std::cerr << describe(to ? socket.error() : to.error()) << '\n';
        return 1;
    }
    const int ticks = argc > 2 ? std::atoi(argv[2]) : 5000;
    proxima::SimulatedHand hand({}, proxima::Vec3(0, 0, 0.06));
    proxima::RemoteServo servo(3.3);
    proxima::StatePacket state;
    std::array<std::byte, proxima::reply_packet_size> buffer{};
    double largest = 0;
    int replies = 0;
    const auto begin = std::chrono::steady_clock::now();
    for (int tick = 0; tick < ticks; ++tick) {
        std::this_thread::sleep_until(begin + std::chrono::milliseconds(tick));
        const proxima::DeviceState now = hand.state();
        state.session = 1;
        ++state.sequence;
        state.nanoseconds = std::uint64_t(tick) * 1'000'000;
        for (int i = 0; i < 3; ++i) state.position[i] = now.pose.translation[i];
        for (int i = 0; i < 3; ++i) state.velocity[i] = now.velocity[i];
        socket->send(encode(state), *to);
        while (const auto received = socket->receive(buffer)) {
            proxima::ReplyPacket reply;
            const auto datagram = std::span(buffer).first(std::min(received->size, buffer.size()));
            if (decode(datagram, reply) != proxima::PacketFault::none) continue;
            servo.take(reply, 1e-3 * tick);
            ++replies;
        }
        const proxima::Vec3 force = servo.force(now.pose.translation, now.velocity, 1e-3 * tick);
        largest = std::max(largest, force.norm());
        // Down by 40 mm in a second, with the tremor that hands have.
        const double tremor = 2e-5 * std::sin(0.07 * tick);
        hand.step(force, proxima::Vec3(tremor, 0, 0.06 - 0.04 * std::min(1e-3 * tick, 1.0)));
    }
    state.flags = proxima::StatePacket::leaving;
    ++state.sequence;
    socket->send(encode(state), *to);
    std::cout << replies << " replies, at most " << largest << " N\n";
}
