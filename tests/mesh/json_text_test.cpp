// The JSON reader against a writer of random texts, and what it refuses.
#include "base/text.h"
#include "code_of.h"
#include "mesh/io/json_text.h"

#include <gtest/gtest.h>
#include <random>

namespace proxima::detail::json_text_test {
namespace {

Result<JsonText> parsed(std::string_view text, MemoryBudget budget = {})
{
    return JsonText::parse({"test", text}, text, budget);
}

TEST(JsonText, ListsValuesBeforeWhatTheyContain)
{
    const auto json = parsed(R"({"a": [1, -2.5e1], "b": 3, "a": 4})");
    ASSERT_TRUE(json) << describe(json.error());
    const auto list = json->member(JsonText::root(), "a");
    ASSERT_EQ(list, 1U);
    EXPECT_EQ(json->children(*list), (std::vector<JsonText::Id>{2, 3}));
    EXPECT_EQ((*json)[3].number, -25);
    EXPECT_EQ((*json)[0].end, 6U);
    EXPECT_EQ((*json)[1].end, 4U);
    EXPECT_EQ(json->number(JsonText::root(), "b", 0), 3);
    EXPECT_EQ(json->number(JsonText::root(), "c", 7), 7);
    EXPECT_EQ(json->number(JsonText::root(), "a", 7), 7); // the first of two, no number
    EXPECT_FALSE(json->member(*list, "a"));
    EXPECT_TRUE(json->children(2).empty());
}

TEST(JsonText, ResolvesEscapes)
{
    const auto json = parsed(R"({"c\u006funt": "\"\\\/\b\f\n\r\t\u00e9\u20AC"})");
    ASSERT_TRUE(json) << describe(json.error());
    const auto member = json->member(JsonText::root(), "count");
    ASSERT_TRUE(member);
    EXPECT_EQ((*json)[*member].text, "\"\\/\b\f\n\r\t\xC3\xA9\xE2\x82\xAC");
}

TEST(JsonText, TakesAnyWhiteSpace)
{
    EXPECT_TRUE(parsed("\r\n{\r\n\t\"a\"\r: [1,\r\n2 ]\r\n}\r\n"));
}

TEST(JsonText, RefusesDamage)
{
    for (const char* text :
         {"",      " ",   "{",        "[",         "[1",        "[1,",         "[1,]",
          "[1 2]", "[1}", R"({"a"})", R"({"a":})", R"({"a":1)", R"({"a":1,})", R"({"a" 1})",
          "{a:1}", "{,}", R"("a)",    R"("\x")",   R"("\u12")", R"("\u00zz")", R"("\)",
          "tru",   "nan", "+1",       "-",         "{} {}",     "1 2",         "]"}) {
        const auto json = parsed(text);
        ASSERT_FALSE(json) << text;
        EXPECT_EQ(code_of(json), ErrorCode::malformed_file) << text;
        EXPECT_FALSE(json.error().where.empty()) << text;
    }
}

TEST(JsonText, LimitsNestingAndMemory)
{
    const auto nested = [](int depth) {
        const auto size = static_cast<std::size_t>(depth);
        return std::string(size, '[') + std::string(size, ']');
    };
    const std::string deepest = nested(JsonText::max_nesting);
    EXPECT_TRUE(parsed(deepest));
    const std::string too_deep = nested(JsonText::max_nesting + 1);
    EXPECT_EQ(code_of(parsed(too_deep)), ErrorCode::malformed_file);
    EXPECT_EQ(code_of(parsed("[1,2,3,4]", {.bytes = 3 * sizeof(JsonText::Value)})),
              ErrorCode::budget_exceeded);
}

// Random values in the one form that written() makes of them.
std::string random_json(std::mt19937& random, int depth)
{
    const auto kind = random() % (depth > 0 ? 5U : 3U);
    if (kind == 0) return to_text(static_cast<double>(random()) / 1024);
    if (kind == 1) return concat("\"s", random() % 100, "\"");
    if (kind == 2) return "word";
    const bool is_object = kind == 3;
    std::string text = is_object ? "{" : "[";
    for (auto left = random() % 4; left > 0; --left) {
        if (is_object) text += concat("\"k", random() % 9, "\":");
        text += random_json(random, depth - 1);
        if (left > 1) text += ",";
    }
    return text + (is_object ? "}" : "]");
}

std::string written(const JsonText& json, JsonText::Id id)
{
    const JsonText::Value& value = json[id];
    if (value.kind == JsonText::Kind::number) return to_text(value.number);
    if (value.kind == JsonText::Kind::string) return concat("\"", value.text, "\"");
    if (value.kind == JsonText::Kind::word) return "word";
    const bool is_object = value.kind == JsonText::Kind::object;
    std::string text = is_object ? "{" : "[";
    for (const JsonText::Id child : json.children(id)) {
        if (text.size() > 1) text += ",";
        if (is_object) text += concat("\"", json[child].key, "\":");
        text += written(json, child);
    }
    return text + (is_object ? "}" : "]");
}

TEST(JsonText, ParsesWhatItWrites)
{
    for (unsigned seed = 0; seed < 2000; ++seed) {
        SCOPED_TRACE(concat("seed ", seed));
        std::mt19937 random(seed);
        const std::string expected = random_json(random, 6);
        // The same with other words and spaces.
        std::string text;
        constexpr const char* words[] = {"true", "false", "null"};
        constexpr const char* spaces[] = {"", "", " ", "\n\t"};
        for (std::size_t i = 0; i < expected.size(); ++i) {
            const bool is_word = expected.compare(i, 4, "word") == 0;
            text += is_word ? words[random() % 3] : std::string(1, expected[i]);
            if (is_word) i += 3;
            const bool splits = std::string_view("{}[],:").find(expected[i]) != std::string::npos;
            if (splits) text += spaces[random() % 4];
        }
        const auto json = parsed(text);
        ASSERT_TRUE(json) << describe(json.error()) << '\n' << text;
        ASSERT_EQ(written(*json, JsonText::root()), expected);
        // Whatever is cut off is missed.
        const std::size_t cut = random() % (text.find_last_not_of(" \n\t") + 1);
        const auto damaged = parsed(std::string_view(text).substr(0, cut));
        const bool is_prefix_number = text.find_first_of("{[\"") == std::string::npos;
        ASSERT_TRUE(is_prefix_number || !damaged) << text.substr(0, cut);
    }
}

} // namespace
} // namespace proxima::detail::json_text_test
