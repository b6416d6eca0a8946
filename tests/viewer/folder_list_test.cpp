#include "viewer/folder_list.h"

#include "code_of.h"
#include "folder_test.h"

#include <fstream>

namespace proxima::folder_list_test {
namespace {

class FolderListTest : public FolderTest {
protected:
    void write(const std::string& name, const std::string& text) const
    {
        std::ofstream(path(name)) << text;
    }

    [[nodiscard]] std::vector<std::string> names() const
    {
        const auto list = list_folder(folder());
        EXPECT_TRUE(list) << describe(list.error());
        std::vector<std::string> all;
        for (const FolderEntry& entry : list->entries)
            all.push_back(entry.name + (entry.is_folder ? "/" : ""));
        return all;
    }
};

TEST_F(FolderListTest, ListsOnlyFoldersAndModels)
{
    EXPECT_TRUE(names().empty());
    write("b.OBJ", "four");
    write("a.ply", "");
    write("notes.txt", "");
    write(".hidden.obj", "");
    std::filesystem::create_directory(path("z"));
    std::filesystem::create_directory(path(".git"));
    std::filesystem::create_directory(path("models.obj")); // a folder, whatever its name
    std::filesystem::create_symlink("nowhere", path("gone.stl"));
    EXPECT_EQ(names(), (std::vector<std::string>{"models.obj/", "z/", "a.ply", "b.OBJ"}));
    EXPECT_EQ(list_folder(folder())->entries[3].bytes, 4U);
    EXPECT_TRUE(list_folder(folder())->is_whole);
    EXPECT_EQ(list_folder(path("z") / "..")->folder, std::filesystem::canonical(folder()));
}

TEST_F(FolderListTest, ReportsWhichFolderCannotBeRead)
{
    const auto list = list_folder(path("none"));
    ASSERT_FALSE(list);
    EXPECT_EQ(code_of(list), ErrorCode::file_not_found);
    EXPECT_NE(describe(list.error()).find("none"), std::string::npos);
    Progress progress;
    progress.cancel();
    write("a.ply", "");
    EXPECT_EQ(code_of(list_folder(folder(), &progress)), ErrorCode::cancelled);
}

TEST_F(FolderListTest, StopsAfterTheMostEntries)
{
    for (std::size_t i = 0; i <= FolderList::most_entries; ++i)
        std::filesystem::create_symlink("x", path(std::to_string(i) + ".obj"));
    EXPECT_TRUE(list_folder(folder())->is_whole) << "links to nothing are no models";
    const std::string model = path("model.ply").string();
    write("model.ply", "");
    std::filesystem::create_directory(path("many"));
    for (std::size_t i = 0; i <= FolderList::most_entries; ++i)
        std::filesystem::create_symlink(model, path("many") / (std::to_string(i) + ".obj"));
    const auto list = list_folder(path("many"));
    ASSERT_TRUE(list);
    EXPECT_FALSE(list->is_whole);
    EXPECT_EQ(list->entries.size(), FolderList::most_entries);
}

TEST(TypedPath, ExpandsHomeAndRelativePaths)
{
    ::setenv("HOME", "/home/somebody", 1);
    EXPECT_EQ(typed_path("a.obj", "/models"), "/models/a.obj");
    EXPECT_EQ(typed_path(" \"my bunny.obj\"\n", "/models"), "/models/my bunny.obj");
    EXPECT_EQ(typed_path("/tmp/a.obj", "/models"), "/tmp/a.obj");
    EXPECT_EQ(typed_path("~/a.obj", "/models"), "/home/somebody/a.obj");
    EXPECT_EQ(typed_path("~", "/models").lexically_normal(), "/home/somebody/");
    EXPECT_EQ(typed_path("~x/a.obj", "/models"), "/models/~x/a.obj");
    EXPECT_EQ(typed_path("icosphere:4", "/models"), "icosphere:4");
    EXPECT_EQ(typed_path("  ", "/models"), "");
}

} // namespace
} // namespace proxima::folder_list_test
