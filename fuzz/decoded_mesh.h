// Meshes and points decoded from the bytes of a fuzzer: any bytes are some mesh. Few values make
// vertices coincide, triangles lie in one plane and touch; scales and offsets make numbers round, and
// powers of two far apart make parts tiny beside others.
#pragma once

#include "proxima/triangle_mesh.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <span>
#include <utility>
#include <vector>

namespace proxima::fuzz {

/// Reads bytes from front to back; behind the end there are zeros.
class Bytes {
public:
    explicit Bytes(std::span<const std::uint8_t> bytes) noexcept : rest_(bytes) {}

    [[nodiscard]] std::size_t left() const noexcept { return rest_.size(); }

    std::uint8_t next() noexcept
    {
        if (rest_.empty()) return 0;
        const std::uint8_t byte = rest_.front();
        rest_ = rest_.subspan(1);
        return byte;
    }
    std::int8_t next_signed() noexcept { return static_cast<std::int8_t>(next()); }
    std::uint32_t next_word() noexcept
    {
        std::uint32_t word = 0;
        for (int i = 0; i < 4; ++i) word = word << 8U | next();
        return word;
    }

private:
    std::span<const std::uint8_t> rest_;
};

/// How positions are coded: the same for a mesh and the points that it is asked about.
class PositionCode {
public:
    explicit PositionCode(Bytes& bytes) noexcept
    {
        const std::uint8_t form = bytes.next();
        const int detail = form / 4 % 4;
        if (form % 4 == 3)
            kind_ = detail < 2 ? Kind::floats : detail < 3 ? Kind::powers : Kind::clusters;
        grid_ = std::ldexp(1.0, -detail * 2);
        constexpr double scales[] = {1, 1, 1, 1e-30, 1e30, 0.1, 1e-6, 3e9};
        scale_ = scales[form / 16 % 8];
        if (form >= 128) offset_ = Vec3(1e9 * scale_, -3e8 * scale_, 0);
        if (has_powers()) {
            for (double& power : powers_) power = std::ldexp(1.0, bytes.next_signed());
        }
    }

    [[nodiscard]] Vec3 next(Bytes& bytes) const noexcept
    {
        Vec3 p;
        const std::uint8_t sizes = has_powers() ? bytes.next() : 0;
        for (int axis = 0; axis < 3; ++axis)
            p[axis] = scale_ * number(bytes, sizes >> 2 * axis & 3U);
        p += offset_;
        if (kind_ != Kind::floats) {
            const std::uint8_t moved = bytes.next();
            for (int axis = 0; axis < 3; ++axis) {
                if ((moved >> axis & 1U) != 0 && moved >= 128)
                    p[axis] = std::nextafter(p[axis], moved >= 192 ? 1e300 : -1e300);
            }
        }
        return p;
    }

private:
    enum class Kind : std::uint8_t {
        grid, ///< whole numbers of a byte each, times a power of two, some moved to the next double
        floats,  ///< any floats
        powers,  ///< whole numbers times one of four powers of two each, 2^-128 to 2^127
        clusters ///< one or none of the largest of these powers, and some of a smaller one
    };

    [[nodiscard]] bool has_powers() const noexcept
    {
        return kind_ == Kind::powers || kind_ == Kind::clusters;
    }

    [[nodiscard]] double number(Bytes& bytes, unsigned size) const noexcept
    {
        switch (kind_) {
        case Kind::grid:
            return grid_ * bytes.next_signed() / 8;
        case Kind::floats:
            return any_float(bytes.next_word());
        case Kind::powers:
            return powers_[size] * bytes.next_signed();
        case Kind::clusters:
            break;
        }
        const double place = size % 2 == 0 ? 0 : *std::ranges::max_element(powers_);
        return place + powers_[size / 2] * bytes.next_signed();
    }

    /// A number of either sign, with any digits, whose size is between 2^-64 and 2^64.
    static double any_float(std::uint32_t bits) noexcept
    {
        const auto exponent = static_cast<int>(bits >> 23U & 127U) - 64;
        const double digits = 1 + std::ldexp(static_cast<double>(bits & 0x7FFFFFU), -23);
        return std::ldexp((bits >> 31U) != 0 ? -digits : digits, exponent);
    }

    Kind kind_ = Kind::grid;
    double grid_ = 1;
    double scale_ = 1;
    std::array<double, 4> powers_{};
    Vec3 offset_ = Vec3::Zero();
};

enum class Shape : std::uint8_t {
    soup,  ///< any triangles
    closed ///< the surfaces of any tetrahedra: every edge has as many triangles one way as the other
};

/// At least one triangle, at most 120; all positions are finite.
inline TriangleMesh decode_mesh(Bytes& bytes, const PositionCode& code, Shape shape = Shape::soup)
{
    const std::size_t vertex_count = 3 + bytes.next() % 62;
    const std::size_t piece_count = 1 + bytes.next() % (shape == Shape::closed ? 30 : 120);
    std::vector<Vec3> positions(vertex_count);
    for (Vec3& position : positions) position = code.next(bytes);
    const auto vertex = [&] { return static_cast<std::uint32_t>(bytes.next() % vertex_count); };
    std::vector<TriangleCorners> triangles;
    while (triangles.size() < piece_count * (shape == Shape::closed ? 4 : 1)) {
        const std::uint32_t a = vertex();
        const std::uint32_t b = vertex();
        const std::uint32_t c = vertex();
        triangles.push_back({a, b, c});
        if (shape == Shape::closed) {
            const std::uint32_t d = vertex();
            triangles.push_back({a, d, b});
            triangles.push_back({b, d, c});
            triangles.push_back({c, d, a});
        }
        if (bytes.left() == 0) break;
    }
    return *make_triangle_mesh(std::move(positions), std::move(triangles));
}

/// A point coded like the mesh's vertices, or on the mesh: a corner, or between two.
inline Vec3 decode_point(Bytes& bytes, const PositionCode& code, const TriangleMesh& mesh)
{
    const std::uint8_t form = bytes.next();
    if (form % 4 < 2) return code.next(bytes);
    const Triangle triangle =
        mesh.triangle(TriangleId{static_cast<std::uint32_t>(bytes.next() % mesh.triangle_count())});
    const Vec3& corner = triangle[form / 4 % 3];
    if (form % 4 == 2) return corner;
    return corner + bytes.next() / 255.0 * (triangle[(form / 4 + 1) % 3] - corner);
}

} // namespace proxima::fuzz
