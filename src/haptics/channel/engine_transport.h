// How packets come from an engine and go to it: as datagrams, or through shared memory.
#pragma once

#include "base/udp_socket.h"
#include "haptics/channel/engine_packets.h"
#include "proxima/result.h"

#include <cstddef>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>

namespace proxima {

/// One thread. receive() and send() are noexcept, never wait, and allocate nothing.
class EngineTransport {
public:
    EngineTransport() = default;
    EngineTransport(const EngineTransport&) = delete;
    EngineTransport& operator=(const EngineTransport&) = delete;
    virtual ~EngineTransport() = default;

    /// "udp:127.0.0.1:4712", "shm:NAME"
    [[nodiscard]] virtual std::string name() const = 0;

    /// The next packet, if one is there: the first bytes of it, as many as fit. The content is not
    /// checked, and does not change any more.
    [[nodiscard]] virtual std::optional<UdpSocket::Received>
    receive(std::span<std::byte> buffer) noexcept = 0;

    /// Gives the engine a touch packet. False where the system did not take it.
    virtual bool send(std::span<const std::byte, touch_packet_size> packet,
                      const UdpAddress& to) noexcept = 0;

    /// Whether the engine can no longer be heard, for good. By the servo thread.
    [[nodiscard]] virtual bool is_cut_off() const noexcept { return false; }

    /// Whether it keeps packets also while no engine is there, for the engine to read when it likes.
    [[nodiscard]] virtual bool keeps_packets() const noexcept = 0;
};

/// Opens udp:PORT, udp:ADDRESS:PORT or shm:NAME. Errors: invalid_argument (another name, what the
/// system says, a segment that another program uses).
[[nodiscard]] Result<std::unique_ptr<EngineTransport>> open_engine_transport(std::string_view name);

/// What is wrong with a name of open_engine_transport; "" for nothing.
[[nodiscard]] std::string engine_name_problem(std::string_view name);

} // namespace proxima
