// What the readers say about files that they refuse, and when they stop.
#include "base/text.h"
#include "code_of.h"
#include "mesh/mesh_files.h"
#include "proxima/sample_meshes.h"

namespace proxima::mesh_io_errors_test {
namespace {

namespace fs = std::filesystem;

TEST(MeshIoErrors, NameTheLineOrByteAndTheElement)
{
    const std::string head = "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty "
                             "float y\nproperty float z\nelement face 2\nproperty list uchar int "
                             "vertex_indices\nend_header\n";
    const std::string vertices = "0 0 0\n1 0 0\n0 1 0\n";
    const std::string facet =
        "facet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 "
        "0\nendloop\nendfacet\n";
    const struct {
        MeshFormat format;
        std::string text;
        std::string where;
        std::string part;
    } cases[] = {
        {MeshFormat::ply, head + vertices + "3 0 1 2\n3 0 1 3\n", ":14", "face 1 uses vertex 3"},
        {MeshFormat::ply, head + vertices + "3 0 1 2\n3 0 -1 2\n", ":14", "uses vertex -1"},
        {MeshFormat::ply, head + vertices + "3 0 1 2\n", "", "face 1 of 2"},
        {MeshFormat::ply, head + vertices + "3 0 1\n3 0 1 2\n", ":13", "fewer values"},
        {MeshFormat::ply, head + vertices + "3 0 1 2 3\n3 0 1 2\n", ":13", "more values"},
        {MeshFormat::ply, head + vertices + "2 0 1\n3 0 1 2\n", ":13", "2 corners"},
        {MeshFormat::ply, head + vertices + "3 0 1 2\n3 0 1 2\n3 0 1 2\n", ":15", "more data"},
        {MeshFormat::ply, head + "0 0 0\n1 zero 0\n0 1 0\n3 0 1 2\n3 0 1 2\n", ":11", "vertex 1"},
        {MeshFormat::ply, "ply\nformat ascii 1.0\nelement vertex x\n", ":3", "element NAME COUNT"},
        {MeshFormat::ply, "ply\nformat ascii 2.0\nend_header\n", ":2", "1.0"},
        {MeshFormat::ply, "ply\nformat ascii 1.0\nproperty float x\n", ":3", "before the first"},
        {MeshFormat::ply, "ply\nformat ascii 1.0\n", "", "end_header"},
        {MeshFormat::ply, "ply 1\nformat ascii 1.0\n", ":1", "starts with the line"},
        {MeshFormat::ply, "ply\nelement vertex 0\nend_header\n", ":3", "no format line"},
        {MeshFormat::ply, "ply\nformat ascii 1.0\nformat ascii 1.0\n", ":3", "second format"},
        {MeshFormat::ply, "ply\nformat text 1.0\n", ":2", "\"text\""},
        {MeshFormat::ply, "ply\nformat ascii 1.0\nsurprise\n", ":3", "no keyword"},
        {MeshFormat::ply, "ply\nformat ascii 1.0\nelement vertex -1\n", ":3", "0 or more"},
        {MeshFormat::ply, "ply\nformat ascii 1.0\nelement vertex 1\nelement vertex 1\n", ":4",
         "second element"},
        {MeshFormat::ply, "ply\nformat ascii 1.0\nelement vertex 1\nproperty real x\n", ":4",
         "\"real\" is no PLY"},
        {MeshFormat::ply, "ply\nformat ascii 1.0\nelement vertex 1\nproperty list real int x\n",
         ":4", "\"real\" is no PLY"},
        {MeshFormat::ply, "ply\nformat ascii 1.0\nelement vertex 1\nproperty float\n", ":4",
         "no name"},
        {MeshFormat::ply, "ply\nformat ascii 1.0\nelement vertex 1\nproperty float x y\n", ":4",
         "more words"},
        {MeshFormat::ply, "ply\nformat ascii 1.0\nend_header x\n", ":3", "alone"},
        {MeshFormat::obj, "v 0 0 0\nf 0 1 1\n", ":2", "vertex 0"},
        {MeshFormat::obj, "v 0 0 0\nf -2 1 1\n", ":2", "vertex -2"},
        {MeshFormat::obj, "v 0 0 0\nf 1 1\n", ":2", "2 corners"},
        {MeshFormat::obj, "v 0 0\n", ":1", "2 numbers"},
        {MeshFormat::obj, "v 0 0 0\nf 1 1 1x\n", ":2", "not an index"},
        {MeshFormat::obj, "v 0 0 0\nf 1 1 9\ng g\nv 0 0 0\n", ":2", "a face uses vertex 9"},
        {MeshFormat::obj, "v 0 0 0\nf 1 1 9\nl 1 1\n", ":2", "a face uses vertex 9"},
        {MeshFormat::obj, "v 0 0 0\nface 1 1 1\n", ":2", "\"face\""},
        {MeshFormat::obj, "v 0 0 0\nsurf 0 1 0 1 1 2 3\n", ":2", "free-form"},
        {MeshFormat::off, "OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 3\n", ":6", "uses vertex 3"},
        {MeshFormat::off, "OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n1\n", ":7", "more data"},
        {MeshFormat::off, "OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 x\n3 0 1 2\n", ":5", "vertex 2"},
        {MeshFormat::off, "OFF\n3 1 0\n0 0 0\n1 0\n0 1 0\n3 0 1 2\n", ":4",
         "vertex 1 has not the 3"},
        {MeshFormat::off, "OFF\n3 1 0\n0 0 0\n1 0 0 7\n0 1 0\n3 0 1 2\n", ":4",
         "vertex 1 has not the 3"},
        {MeshFormat::off, "NOFF\n3 1 0\n0.0 0.0 0.0 0.0 0.0 1.0\n1 0 0\n0 1 0 0 0 1\n3 0 1 2\n",
         ":4", "vertex 1 has not the 6"},
        {MeshFormat::off, "OFF\n3\n0 0 0\n1 0 0\n0 1 0\n", ":2", "the counts"},
        {MeshFormat::off, "OFF\n3 -1 0\n0 0 0\n1 0 0\n0 1 0\n", ":2", "the counts"},
        {MeshFormat::off, "OFF\n3 1 0 x\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n", ":2", "the counts"},
        {MeshFormat::off, "OFF\n3 3 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n", ":2",
         "promises 3 vertices and 3 faces"},
        {MeshFormat::off, "4OFF\n3 1 0\n", ":1", "4OFF"},
        {MeshFormat::off, "OFF BINARY\n", ":1", "binary"},
        {MeshFormat::stl,
         "solid\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nendloop", ":6",
         "2 corners"},
        {MeshFormat::stl, "solid\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\n", ":5", "cut off"},
        {MeshFormat::stl, "solid\n" + facet + facet + "facet normal 0 0 1\nouter loop\nendloop",
         ":18", "facet 2 has 0 corners"},
        {MeshFormat::stl, "solid\nfacets\n", ":2", "\"facets\""},
        {MeshFormat::stl, "something else", "", "14"},
    };
    for (const auto& test : cases) {
        const Error error = error_of(test.text, test.format);
        const std::string name = concat(format_name(test.format), " data");
        EXPECT_TRUE(error.code == ErrorCode::malformed_file ||
                    error.code == ErrorCode::unsupported_format);
        if (!test.where.empty()) {
            EXPECT_EQ(error.where, concat(name, test.where)) << test.text;
        }
        EXPECT_NE(error.message.find(test.part), std::string::npos) << error.message;
    }
}

// Of such a file a reader would see one line.
TEST(MeshIoErrors, RefuseSingleCarriageReturnsAsLineEnds)
{
    const std::pair<MeshFormat, std::string> files[] = {
        {MeshFormat::xyz, "1 2 3\n4 5 6\n7 8 9\n"},
        {MeshFormat::obj, "# four\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n"},
        {MeshFormat::obj, "o part\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n"},
        {MeshFormat::off, "# by hand\nOFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n"},
        {MeshFormat::ply, "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\n"
                          "property float y\nproperty float z\nelement face 1\nproperty list "
                          "uchar int vertex_indices\nend_header\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n"},
        {MeshFormat::stl, "solid part\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\n"
                          "vertex 0 1 0\nendloop\nendfacet\nendsolid\n"},
    };
    const auto with_ends = [](const std::string& text, std::string_view end) {
        std::string result;
        for (const char letter : text) {
            if (letter == '\n') {
                result += end;
            } else {
                result += letter;
            }
        }
        return result;
    };
    const ReadOptions points_too{.primitives = Primitives::points_and_lines};
    for (const auto& [format, text] : files) {
        const std::string returns = with_ends(text, "\r");
        // Some editors end such a file by a line feed.
        for (const std::string& bad :
             {returns, returns + "\n", returns.substr(0, returns.size() - 1)}) {
            const Error error = error_of(bad, format, points_too);
            EXPECT_EQ(error.code, ErrorCode::malformed_file);
            EXPECT_EQ(error.where, concat(format_name(format), " data"));
            EXPECT_NE(error.message.find("single carriage returns"), std::string::npos)
                << describe(error);
        }
        const auto as_is = read_text(text, format, points_too);
        ASSERT_TRUE(as_is) << describe(as_is.error());
        for (const char* const end : {"\r\n", "\r\r\n", "\n\r"}) {
            if (format == MeshFormat::ply && end == std::string_view("\r\r\n")) continue;
            const auto mesh = read_text(with_ends(text, end), format, points_too);
            ASSERT_TRUE(mesh) << describe(mesh.error());
            EXPECT_EQ(mesh->vertex_count(), as_is->vertex_count());
            EXPECT_EQ(mesh->triangle_count(), as_is->triangle_count());
        }
    }
    const auto one_line = read_text("1 2 3\r", MeshFormat::xyz, points_too);
    ASSERT_TRUE(one_line) << describe(one_line.error());
    EXPECT_EQ(one_line->vertex_count(), 1U);
    EXPECT_TRUE(read_text("# a\rb\n1 2 3\n", MeshFormat::xyz, points_too));
}

// A binary body may have any bytes.
TEST(MeshIoErrors, TakeCarriageReturnsInBinaryFiles)
{
    std::string stl(84 + 50, '\0');
    stl[0] = 's';
    stl[80] = 1;
    for (std::size_t corner = 1; corner < 4; ++corner) {
        for (std::size_t i = 0; i < 12; ++i) stl[84 + 12 * corner + i] = '\r';
    }
    const auto mesh = read_text(stl, MeshFormat::stl);
    ASSERT_TRUE(mesh) << describe(mesh.error());
    EXPECT_EQ(mesh->triangle_count(), 1U);
    const auto ply = read_text("ply\nformat binary_little_endian 1.0\nelement vertex 1\nproperty "
                               "char x\nproperty char y\nproperty char z\nend_header\n\r\r\r",
                               MeshFormat::ply);
    ASSERT_TRUE(ply) << describe(ply.error());
    EXPECT_EQ(ply->vertex_count(), 1U);
}

TEST(MeshIoErrors, TakeOneLineEndBehindBinaryPly)
{
    const std::string text =
        file_content(fs::path(PROXIMA_SOURCE_DIR) / "fuzz/corpus/ply/little.ply");
    for (const char* end : {"\n", "\r\n"})
        EXPECT_TRUE(read_text(text + end, MeshFormat::ply)) << end;
    for (const char* end : {"\n\n", "\r", " "})
        EXPECT_FALSE(read_text(text + end, MeshFormat::ply)) << end;
}

TEST(MeshIoErrors, TakeTextPlyWithoutALastLineEnd)
{
    const auto ply = read_text("ply\nformat ascii 1.0\nelement vertex 1\nproperty int x\n"
                               "property int y\nproperty int z\nend_header\n0 0 0",
                               MeshFormat::ply);
    ASSERT_TRUE(ply) << describe(ply.error());
    EXPECT_EQ(ply->vertex_count(), 1U);
}

TEST(MeshIoErrors, RefusePlyHeadersOfTooManyLines)
{
    std::string elements = "ply\nformat ascii 1.0\n";
    std::string properties = elements + "element vertex 0\n";
    for (int i = 0; i < 10'100; ++i) {
        if (i < 1'100) elements += concat("element a", i, " 0\n");
        properties += concat("property int a", i, "\n");
    }
    for (const std::string& text : {elements, properties}) {
        const Error error = error_of(text + "end_header\n", MeshFormat::ply);
        EXPECT_EQ(error.code, ErrorCode::limit_exceeded);
        EXPECT_NE(error.message.find("more than"), std::string::npos) << error.message;
    }
}

TEST(MeshIoErrors, CountTheNumbersOfObjVertices)
{
    for (const char* numbers : {"0 0 0", "0 0 0 1", "0 0 0 1 1 1", "0 0 0 1 1 1 0.5"})
        EXPECT_TRUE(read_text(concat("v ", numbers, "\n"), MeshFormat::obj)) << numbers;
    for (const char* numbers : {"0 0", "0 0 0 1 1", "0 0 0 1 1 1 1 1"})
        EXPECT_FALSE(read_text(concat("v ", numbers, "\n"), MeshFormat::obj)) << numbers;
}

TEST(MeshIoErrors, PassOverContinuedStatementsOfAnyLineEnd)
{
    for (const std::string end : {"\n", "\r\n"}) {
        const std::string text = "v 0 0 0" + end + "v 1 0 0" + end + "v 0 1 0" + end + "vn 0 0 \\" +
                                 end + " 1" + end + "f 1 2 3" + end;
        EXPECT_TRUE(read_text(text, MeshFormat::obj)) << text;
    }
}

TEST(MeshIoErrors, NameTheByteOfBinaryPly)
{
    std::string text = file_content(fs::path(PROXIMA_SOURCE_DIR) / "fuzz/corpus/ply/little.ply");
    text[text.size() - 1] = 1; // the high byte of the last index
    const Error error = error_of(text, MeshFormat::ply);
    EXPECT_EQ(error.where, concat("PLY data, byte ", text.size()));
    EXPECT_NE(error.message.find("face 3"), std::string::npos);
}

TEST(MeshIoErrors, RefuseBinaryStlThatIsLongerThanItsCount)
{
    std::string text = file_content(fs::path(PROXIMA_SOURCE_DIR) / "fuzz/corpus/stl/binary.stl");
    text[80] = 3; // of 4 triangles
    const Error error = error_of(text, MeshFormat::stl);
    EXPECT_EQ(error.code, ErrorCode::malformed_file);
    EXPECT_NE(error.message.find("3 triangles"), std::string::npos) << error.message;
}

// No small file makes a reader take gigabytes: the promise is refused before memory is taken.
TEST(MeshIoErrors, RefuseCountsThatTheFileCannotHold)
{
    const auto ply = [](const char* format, const char* vertices, const char* faces,
                        const char* rest) {
        return concat("ply\nformat ", format, " 1.0\nelement vertex ", vertices,
                      "\nproperty char x\nproperty char y\nproperty char z\nelement face ", faces,
                      "\nproperty list uint char vertex_indices\nend_header\n", rest);
    };
    std::string stl(84, ' ');
    stl[80] = stl[81] = stl[82] = stl[83] = '\xFF';
    const std::pair<MeshFormat, std::string> files[] = {
        {MeshFormat::ply, ply("ascii", "4000000000", "0", "")},
        {MeshFormat::ply, ply("ascii", "999999999999999999", "0", "")},
        {MeshFormat::ply, ply("ascii", "99999999999999999999999", "0", "")},
        {MeshFormat::ply, ply("binary_little_endian", "0", "2000000000", "")},
        {MeshFormat::ply, ply("binary_little_endian", "1", "1", "abc\xFF\xFF\xFF\xFF")},
        {MeshFormat::ply, ply("binary_big_endian", "1", "1", "abc\x7F\xFF\xFF\xFF")},
        {MeshFormat::ply, ply("ascii", "1", "1", "0 0 0\n1000000 0")},
        {MeshFormat::off, "OFF\n4000000000 1 0\n"},
        {MeshFormat::off, "OFF\n1 4000000000 0\n0 0 0\n"},
        {MeshFormat::off, "OFF\n-1 1 0\n"},
        {MeshFormat::off, "OFF\n3 1 0\n0 0 0\n0 0 0\n0 0 0\n1000000 0 1 2\n"},
        {MeshFormat::stl, stl},
    };
    for (const auto& [format, text] : files) {
        // Any allocation by the promised counts would exceed this.
        const Error error = error_of(text, format, {.execution = {.budget = {.bytes = 100'000}}});
        EXPECT_EQ(error.code, ErrorCode::malformed_file) << describe(error) << "\n" << text;
    }
}

TEST(MeshIoErrors, RefuseFacesBeyondTheLimit)
{
    constexpr std::size_t too_many = (std::size_t{1} << 20U) + 1;
    std::string obj = "v 0 0 0\nf";
    std::string off = concat("OFF\n1 1 0\n0 0 0\n", too_many);
    std::string ply =
        concat("ply\nformat ascii 1.0\nelement vertex 1\nproperty int x\nproperty int "
               "y\nproperty int z\nelement face 1\nproperty list int int "
               "vertex_index\nend_header\n0 0 0\n",
               too_many);
    for (std::size_t i = 0; i < too_many; ++i) {
        obj += " 1";
        off += " 0";
        ply += " 0";
    }
    EXPECT_EQ(error_of(obj, MeshFormat::obj).code, ErrorCode::limit_exceeded);
    EXPECT_EQ(error_of(off, MeshFormat::off).code, ErrorCode::limit_exceeded);
    EXPECT_EQ(error_of(ply, MeshFormat::ply).code, ErrorCode::limit_exceeded);
}

TEST(MeshIoErrors, RespectTheMemoryBudget)
{
    std::string obj;
    for (int i = 0; i < 20'000; ++i) obj += "v 1 1 1\nf 1 1 1 1\n";
    EXPECT_TRUE(read_text(obj, MeshFormat::obj, {.execution = {.budget = {.bytes = 20'000'000}}}));
    const Error error =
        error_of(obj, MeshFormat::obj, {.execution = {.budget = {.bytes = 1'000'000}}});
    EXPECT_EQ(error.code, ErrorCode::budget_exceeded);
    EXPECT_NE(error.message.find("OBJ data"), std::string::npos);
}

// A reader holds the text and the arrays of the mesh at its end, and that of STL a table of vertices, too. A smaller budget is refused.
TEST(MeshIoErrors, RefuseBudgetsBelowTheTextAndTheArrays)
{
    const TriangleMesh mesh = make_icosphere(5);
    std::string obj;
    std::string off = concat("OFF\n", mesh.vertex_count(), " ", mesh.triangle_count(), " 0\n");
    std::string stl = "solid\n";
    for (const Vec3& p : mesh.positions()) {
        const std::string line = concat(p[0], " ", p[1], " ", p[2], "\n");
        off += line;
        obj += "v " + line;
    }
    for (const TriangleCorners& c : mesh.triangles()) {
        off += concat("3 ", c[0], " ", c[1], " ", c[2], "\n");
        obj += concat("f ", c[0] + 1, " ", c[1] + 1, " ", c[2] + 1, "\n");
        stl += "facet normal 0 0 0\nouter loop\n";
        for (const std::uint32_t corner : c) {
            const Vec3& p = mesh.positions()[corner];
            stl += concat("vertex ", p[0], " ", p[1], " ", p[2], "\n");
        }
        stl += "endloop\nendfacet\n";
    }
    stl += "endsolid\n";
    const std::pair<MeshFormat, std::string> files[] = {
        {MeshFormat::obj, obj}, {MeshFormat::off, off}, {MeshFormat::stl, stl}};
    for (const auto& [format, text] : files) {
        const auto read_within = [&, &of = text, &as = format](std::uint64_t bytes) {
            return read_text(of, as, {.execution = {.budget = {.bytes = bytes}}});
        };
        std::uint64_t least = text.size() + mesh.vertex_count() * sizeof(Vec3) +
                              mesh.triangle_count() * sizeof(TriangleCorners);
        if (format == MeshFormat::stl) least += mesh.vertex_count() * sizeof(std::uint32_t);
        const auto refused = read_within(least - 1);
        ASSERT_FALSE(refused) << format_name(format);
        EXPECT_EQ(code_of(refused), ErrorCode::budget_exceeded);
        const auto read = read_within(8 * least);
        ASSERT_TRUE(read) << describe(read.error());
        EXPECT_EQ(read->vertex_count(), mesh.vertex_count());
        EXPECT_EQ(read->triangle_count(), mesh.triangle_count());
    }
}

TEST(MeshIoErrors, StopOnRequest)
{
    for (const SeedFile& seed : seed_files()) {
        Progress progress;
        progress.cancel();
        const auto mesh =
            read_text(seed.content, seed.format, {.execution = {.progress = &progress}});
        ASSERT_FALSE(mesh) << seed.name;
        EXPECT_EQ(code_of(mesh), ErrorCode::cancelled) << seed.name;
    }
}

} // namespace
} // namespace proxima::mesh_io_errors_test
