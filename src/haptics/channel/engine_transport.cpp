#include "haptics/channel/engine_transport.h"

#include "base/text.h"
#include "haptics/channel/shared_segment.h"

#include <algorithm>
#include <utility>

namespace proxima {

namespace {

constexpr std::string_view udp_prefix = "udp:";
constexpr std::string_view shm_prefix = "shm:";
constexpr std::size_t longest_name = 64;

class UdpTransport final : public EngineTransport {
public:
    explicit UdpTransport(UdpSocket socket) : socket_(std::move(socket)) {}

    [[nodiscard]] std::string name() const override
    {
        return concat(udp_prefix, to_text(socket_.address()));
    }
    [[nodiscard]] std::optional<UdpSocket::Received>
    receive(std::span<std::byte> buffer) noexcept override
    {
        return socket_.receive(buffer);
    }
    bool send(std::span<const std::byte, touch_packet_size> packet,
              const UdpAddress& to) noexcept override
    {
        return socket_.send(packet, to);
    }
    [[nodiscard]] bool keeps_packets() const noexcept override { return false; }

private:
    UdpSocket socket_;
};

class SharedMemoryTransport final : public EngineTransport {
public:
    explicit SharedMemoryTransport(SharedSegment segment) : segment_(std::move(segment)) {}

    [[nodiscard]] std::string name() const override
    {
        constexpr std::size_t before_name = std::string_view("/proxima-").size();
        return concat(shm_prefix, segment_.path().substr(before_name));
    }
    [[nodiscard]] std::optional<UdpSocket::Received>
    receive(std::span<std::byte> buffer) noexcept override
    {
        const std::uint64_t written = packets_written(segment_.bytes(), scene_ring);
        // An engine that begins anew, or that lies, may tell any number.
        const std::uint64_t behind = written - taken_;
        if (behind > scene_ring.slots) taken_ = written - scene_ring.slots;
        while (taken_ != written) {
            const std::size_t size = read_packet(segment_.bytes(), scene_ring, taken_++, buffer);
            if (size > 0) return UdpSocket::Received{size, {}};
        }
        return std::nullopt;
    }
    bool send(std::span<const std::byte, touch_packet_size> packet,
              const UdpAddress& /*to*/) noexcept override
    {
        write_packet(segment_.bytes(), touch_ring, sent_++, packet);
        return true;
    }
    [[nodiscard]] bool is_cut_off() const noexcept override { return segment_.is_cut_off(); }
    [[nodiscard]] bool keeps_packets() const noexcept override { return true; }

private:
    SharedSegment segment_;
    std::uint64_t taken_ = 0; ///< packets of the scene ring
    std::uint64_t sent_ = 0;
};

bool is_segment_name(std::string_view name)
{
    const auto is_allowed = [](char c) {
        return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') ||
               c == '_' || c == '-' || c == '.';
    };
    return !name.empty() && name.size() <= longest_name && std::ranges::all_of(name, is_allowed);
}

} // namespace

std::string engine_name_problem(std::string_view name)
{
    if (name.starts_with(udp_prefix)) {
        const auto address = parse_udp_address(name.substr(udp_prefix.size()));
        return address ? std::string() : address.error().message;
    }
    if (name.starts_with(shm_prefix) && is_segment_name(name.substr(shm_prefix.size()))) return {};
    return concat(name,
                  " is no channel: give udp:PORT, udp:ADDRESS:PORT or shm:NAME, a name of "
                  "letters, digits, '_', '-' and '.', at most ",
                  longest_name, " of them");
}

Result<std::unique_ptr<EngineTransport>> open_engine_transport(std::string_view name)
{
    if (const std::string problem = engine_name_problem(name); !problem.empty())
        return fail(ErrorCode::invalid_argument, problem);
    if (name.starts_with(udp_prefix)) {
        auto socket = UdpSocket::listen(*parse_udp_address(name.substr(udp_prefix.size())));
        if (!socket) return tl::unexpected(socket.error());
        return std::make_unique<UdpTransport>(std::move(*socket));
    }
    auto segment = SharedSegment::create(name.substr(shm_prefix.size()));
    if (!segment) return tl::unexpected(segment.error());
    return std::make_unique<SharedMemoryTransport>(std::move(*segment));
}

} // namespace proxima
