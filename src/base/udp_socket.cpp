#include "base/udp_socket.h"

#include "base/text.h"

#include <array>
#include <cerrno>
#include <charconv>
#include <cstring>
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

namespace proxima {

namespace {

sockaddr_in system_address(const UdpAddress& address) noexcept
{
    sockaddr_in result{};
    result.sin_family = AF_INET;
    result.sin_addr.s_addr = htonl(address.host);
    result.sin_port = htons(address.port);
    return result;
}

UdpAddress our_address(const sockaddr_in& address) noexcept
{
    return {ntohl(address.sin_addr.s_addr), ntohs(address.sin_port)};
}

/// A decimal number up to `most` at the front of text, taken off it.
std::optional<std::uint32_t> take_number(std::string_view& text, std::uint32_t most)
{
    std::uint32_t number = 0;
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
    if (error != std::errc() || number > most) return std::nullopt;
    text.remove_prefix(static_cast<std::size_t>(end - text.data()));
    return number;
}

std::optional<UdpAddress> read_address(std::string_view text)
{
    UdpAddress address;
    if (text.find(':') != std::string_view::npos) {
        address.host = 0;
        for (const char after : {'.', '.', '.', ':'}) {
            const auto part = take_number(text, 255);
            if (!part || text.empty() || text.front() != after) return std::nullopt;
            text.remove_prefix(1);
            address.host = address.host << 8U | *part;
        }
    }
    const auto port = take_number(text, 65535);
    if (!port || !text.empty()) return std::nullopt;
    address.port = static_cast<std::uint16_t>(*port);
    return address;
}

} // namespace

Result<UdpAddress> parse_udp_address(std::string_view text)
{
    const auto address = read_address(text);
    if (address) return *address;
    return fail(ErrorCode::invalid_argument,
                concat(text, " is no address: give PORT or A.B.C.D:PORT"));
}

std::string to_text(const UdpAddress& address)
{
    return concat(address.host >> 24U, '.', address.host >> 16U & 255U, '.',
                  address.host >> 8U & 255U, '.', address.host & 255U, ':', address.port);
}

Result<UdpSocket> UdpSocket::listen(const UdpAddress& address)
{
    UdpSocket made(::socket(AF_INET, SOCK_DGRAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0));
    const sockaddr_in wanted = system_address(address);
    if (made.socket_ < 0 ||
        bind(made.socket_, reinterpret_cast<const sockaddr*>(&wanted), sizeof wanted) != 0) {
        return fail(ErrorCode::invalid_argument,
                    concat("cannot listen there: ", std::strerror(errno)), to_text(address));
    }
    return made;
}

UdpSocket& UdpSocket::operator=(UdpSocket&& other) noexcept
{
    std::swap(socket_, other.socket_);
    return *this;
}

UdpSocket::~UdpSocket()
{
    if (socket_ >= 0) close(socket_);
}

UdpAddress UdpSocket::address() const noexcept
{
    sockaddr_in address{};
    socklen_t size = sizeof address;
    getsockname(socket_, reinterpret_cast<sockaddr*>(&address), &size);
    return our_address(address);
}

std::optional<UdpSocket::Received> UdpSocket::receive(std::span<std::byte> buffer) noexcept
{
    sockaddr_in from{};
    socklen_t size = sizeof from;
    const ssize_t got = recvfrom(socket_, buffer.data(), buffer.size(), MSG_DONTWAIT | MSG_TRUNC,
                                 reinterpret_cast<sockaddr*>(&from), &size);
    if (got < 0) return std::nullopt;
    return Received{static_cast<std::size_t>(got), our_address(from)};
}

bool UdpSocket::send(std::span<const std::byte> datagram, const UdpAddress& to) noexcept
{
    const sockaddr_in address = system_address(to);
    const ssize_t sent =
        sendto(socket_, datagram.data(), datagram.size(), MSG_DONTWAIT | MSG_NOSIGNAL,
               reinterpret_cast<const sockaddr*>(&address), sizeof address);
    return sent == static_cast<ssize_t>(datagram.size());
}

} // namespace proxima
