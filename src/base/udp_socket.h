// Datagrams to and from other programs: IPv4, never waiting.
#pragma once

#include "proxima/result.h"

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>

namespace proxima {

/// An address and a port, both as numbers: 127.0.0.1 is 0x7f000001.
struct UdpAddress {
    std::uint32_t host = 0x7f000001;
    std::uint16_t port = 0; ///< 0: any that is free

    friend bool operator==(const UdpAddress&, const UdpAddress&) = default;
};

/// "PORT" (of this machine alone) or "A.B.C.D:PORT". Error invalid_argument.
[[nodiscard]] Result<UdpAddress> parse_udp_address(std::string_view text);

/// "A.B.C.D:PORT"
[[nodiscard]] std::string to_text(const UdpAddress& address);

/// One thread at a time.
class UdpSocket {
public:
    /// Listens there. Error invalid_argument where that cannot be: the system's reason.
    [[nodiscard]] static Result<UdpSocket> listen(const UdpAddress& address);

    UdpSocket(UdpSocket&& other) noexcept : socket_(other.socket_) { other.socket_ = -1; }
    UdpSocket& operator=(UdpSocket&& other) noexcept;
    ~UdpSocket();

    /// Where it listens, the port as given by the system.
    [[nodiscard]] UdpAddress address() const noexcept;

    struct Received {
        std::size_t size = 0; ///< of the datagram, which may be more than the buffer held
        UdpAddress from;
    };
    /// The next datagram, if one is there. noexcept, without waiting.
    [[nodiscard]] std::optional<Received> receive(std::span<std::byte> buffer) noexcept;

    /// False where the system did not take it. noexcept, without waiting.
    bool send(std::span<const std::byte> datagram, const UdpAddress& to) noexcept;

private:
    explicit UdpSocket(int socket) noexcept : socket_(socket) {}
    int socket_;
};

} // namespace proxima
