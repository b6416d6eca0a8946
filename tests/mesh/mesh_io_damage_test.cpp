// Damaged files: each is refused, or what is read is a valid mesh. Long runs are the fuzzers' work.
#include "mesh/mesh_files.h"

#include <random>

namespace proxima::mesh_io_damage_test {
namespace {

bool is_text_with_counts(const SeedFile& seed)
{
    if (seed.format == MeshFormat::off) return true;
    if (seed.format == MeshFormat::stl) return !seed.name.starts_with("stl/binary");
    return seed.format == MeshFormat::ply && seed.content.find("format ascii") != std::string::npos;
}

bool is_binary(const SeedFile& seed)
{
    return seed.name.starts_with("stl/binary") ||
           (seed.format == MeshFormat::ply && !is_text_with_counts(seed));
}

void expect_refused_or_valid(const Result<TriangleMesh>& mesh)
{
    if (!mesh) {
        EXPECT_FALSE(mesh.error().message.empty());
        EXPECT_FALSE(mesh.error().where.empty());
        EXPECT_TRUE(mesh.error().code == ErrorCode::malformed_file ||
                    mesh.error().code == ErrorCode::unsupported_format ||
                    mesh.error().code == ErrorCode::limit_exceeded ||
                    mesh.error().code == ErrorCode::budget_exceeded)
            << describe(mesh.error());
        return;
    }
    for (const TriangleCorners& corners : mesh->triangles()) {
        for (const std::uint32_t corner : corners) ASSERT_LT(corner, mesh->vertex_count());
    }
}

TEST(MeshIoDamage, EveryTruncationIsRefusedOrLosesNothing)
{
    for (const SeedFile& seed : seed_files()) {
        const auto whole = read_text(seed.content, seed.format);
        ASSERT_TRUE(whole) << seed.name << ": " << describe(whole.error());
        for (std::size_t size = 0; size < seed.content.size(); ++size) {
            SCOPED_TRACE(seed.name + " cut to " + std::to_string(size));
            // A copy, so that reading beyond the end shows under the address sanitizer.
            const std::vector<char> cut(seed.content.begin(),
                                        seed.content.begin() + static_cast<std::ptrdiff_t>(size));
            const auto mesh = read_mesh_from_memory(std::as_bytes(std::span(cut)), seed.format);
            expect_refused_or_valid(mesh);
            EXPECT_FALSE(is_binary(seed) && mesh);
            // Text may be cut within its last number or behind it, but no element may be missing.
            // Cut between two solids, an STL is a complete file of one.
            const bool ends_solid =
                seed.name == "stl/two_solids.stl" && size <= seed.content.find("solid\n");
            if (is_text_with_counts(seed) && mesh && !ends_solid) {
                EXPECT_EQ(mesh->triangle_count(), whole->triangle_count());
                EXPECT_EQ(mesh->vertex_count(), whole->vertex_count());
            }
        }
    }
}

std::string mutate(std::string content, const std::string& other, std::mt19937_64& random)
{
    constexpr std::string_view telling = "0123456789-+.eE#/\\ \n\r\t\0\x7F\xFF nan inf";
    for (auto count = 1 + random() % 4; count > 0; --count) {
        const std::size_t place = random() % (content.size() + 1);
        const char letter = random() % 2 == 0 ? telling[random() % telling.size()]
                                              : static_cast<char>(random() % 256);
        switch (random() % 6) {
        case 0:
            content.insert(place, 1, letter);
            break;
        case 1:
            content.erase(place, 1 + random() % 3);
            break;
        case 2:
            content.insert(place, content.substr(place, random() % 16));
            break;
        case 3:
            content.replace(place, random() % 8, other, random() % other.size(), random() % 32);
            break;
        case 4:
            if (place < content.size()) {
                content[place] = static_cast<char>(content[place] ^ (1 << random() % 8));
            }
            break;
        default:
            if (place < content.size()) content[place] = letter;
            break;
        }
    }
    return content;
}

TEST(MeshIoDamage, EveryMutationIsRefusedOrReadAsAValidMesh)
{
    const auto seeds = seed_files();
    for (const SeedFile& seed : seeds) {
        const int rounds = seed.format >= MeshFormat::three_ds ? 500 : 3000;
        int read = 0;
        for (int round = 0; round < rounds; ++round) {
            SCOPED_TRACE(seed.name + " with seed " + std::to_string(round));
            std::mt19937_64 random(static_cast<std::uint64_t>(round));
            const std::string damaged =
                mutate(seed.content, seeds[random() % seeds.size()].content, random);
            const std::vector<char> copy(damaged.begin(), damaged.end());
            const auto mesh =
                read_mesh_from_memory(std::as_bytes(std::span(copy)), seed.format,
                                      {.execution = {.budget = {.bytes = 10'000'000}}});
            if (!copy.empty()) expect_refused_or_valid(mesh);
            read += mesh ? 1 : 0;
        }
        EXPECT_LT(read, rounds) << seed.name << ": nothing was refused";
    }
}

// A digit that becomes a blank, or a line end that gets lost, moves all numbers behind it.
TEST(MeshIoDamage, CountedTextNoticesEveryLostOrAddedValue)
{
    for (const SeedFile& seed : seed_files()) {
        if (!is_text_with_counts(seed) || seed.name == "off/colours.off" ||
            seed.name == "off/normals.off") {
            continue; // a colour has no fixed number of components
        }
        const ReadOptions unwelded{.weld = Weld::never};
        const auto whole = read_text(seed.content, seed.format, unwelded);
        ASSERT_TRUE(whole);
        const std::size_t header = seed.content.find("end_header");
        const std::size_t begin = header == std::string::npos ? 4 : header + 11;
        for (std::size_t place = begin; place < seed.content.size(); ++place) {
            std::string damaged = seed.content;
            if (damaged[place] < '0' || damaged[place] > '9') continue;
            damaged[place] = ' ';
            const auto mesh = read_text(damaged, seed.format, unwelded);
            if (!mesh) continue;
            // Digits of a longer number, a comment, a normal or a colour: the counts still hold.
            EXPECT_EQ(mesh->vertex_count(), whole->vertex_count()) << seed.name << " at " << place;
            EXPECT_EQ(mesh->triangle_count(), whole->triangle_count())
                << seed.name << " at " << place;
        }
    }
}

TEST(MeshIoDamage, RandomBytesAreRefused)
{
    std::mt19937_64 random(5);
    for (int round = 0; round < 2000; ++round) {
        std::string bytes(1 + random() % 300, '\0');
        for (char& byte : bytes) byte = static_cast<char>(random());
        for (const MeshFormat format :
             {MeshFormat::obj, MeshFormat::ply, MeshFormat::stl, MeshFormat::off}) {
            const auto mesh = read_text(bytes, format);
            expect_refused_or_valid(mesh);
            // A comment is all that chance makes.
            EXPECT_TRUE(!mesh || mesh->vertex_count() == 0);
        }
    }
}

} // namespace
} // namespace proxima::mesh_io_damage_test
