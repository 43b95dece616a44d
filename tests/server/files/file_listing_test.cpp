#include "server/files/file_listing.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>

#include "tests/temp_directory.h"

namespace lucerna {
namespace {

namespace fs = std::filesystem;
using ::testing::ElementsAre;
using ::testing::IsEmpty;
using ::testing::SizeIs;

class FileListingTest : public ::testing::Test {
 protected:
  void write(const std::string& name) {
    fs::create_directories((root() / name).parent_path());
    std::ofstream(root() / name) << "WorldBegin\n";
  }
  fs::path root() const { return directory_.path() / "root"; }
  FileListing list(const FileListingLimits& limits = {}) const {
    return list_files(root().string(), {".pbrt", ".pbrt.gz"}, limits);
  }

  TempDirectory directory_;
};

TEST_F(FileListingTest, NamesFilesOfTheKindRelativeToTheRootInOrder) {
  for (const char* name : {"b.pbrt", "a.pbrt", "room/scene.pbrt", "room/mesh.ply", "readme.txt",
                           "c.pbrt.gz", "mesh.ply.gz"})
    write(name);
  EXPECT_THAT(list().paths, ElementsAre("a.pbrt", "b.pbrt", "c.pbrt.gz", "room/scene.pbrt"));
  EXPECT_FALSE(list().incomplete);
}

TEST_F(FileListingTest, LeavesOutHiddenNamesAndInvalidUtf8) {
  for (const char* name : {".hidden.pbrt", ".git/a.pbrt", "\xff.pbrt", "\xc3\xa9.pbrt"})
    write(name);
  EXPECT_THAT(list().paths, ElementsAre("\xc3\xa9.pbrt"));
}

TEST_F(FileListingTest, FollowsNoLinkOutOfTheRootAndNoLinkToAFolder) {
  write("in.pbrt");
  write("../out.pbrt");
  write("../folder/deep.pbrt");
  fs::create_symlink("in.pbrt", root() / "relative.pbrt");
  fs::create_symlink(root() / "in.pbrt", root() / "absolute.pbrt");
  fs::create_symlink("../out.pbrt", root() / "leaves.pbrt");
  fs::create_directory_symlink("../folder", root() / "folder");
  fs::create_directory_symlink(".", root() / "circle");
  EXPECT_THAT(list().paths, ElementsAre("in.pbrt", "relative.pbrt"));
  EXPECT_FALSE(list().incomplete);
}

TEST_F(FileListingTest, LimitsEndTheSearchAndAreReported) {
  for (const char* name : {"a.pbrt", "b.pbrt", "c.pbrt", "1/d.pbrt", "1/2/e.pbrt"}) write(name);
  const FileListing few = list({.entries = 2});
  EXPECT_TRUE(few.incomplete);
  EXPECT_LE(few.paths.size(), 2U);
  const FileListing shallow = list({.depth = 2});
  EXPECT_TRUE(shallow.incomplete);
  EXPECT_THAT(shallow.paths, SizeIs(4));
  EXPECT_FALSE(list({.depth = 3}).incomplete);
}

TEST_F(FileListingTest, ARootThatDoesNotExistHasNoFiles) { EXPECT_THAT(list().paths, IsEmpty()); }

}  // namespace
}  // namespace lucerna
