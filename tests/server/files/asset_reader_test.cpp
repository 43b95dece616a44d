#include "server/files/asset_reader.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/stat.h>

#include "tests/server/files/gzip.h"
#include "tests/server/pbrt/pbrt_fixture.h"

namespace lucerna {
namespace {

using ::testing::ElementsAre;
using testing::gzipped;
using ::testing::HasSubstr;
using testing::message;
using ::testing::Not;
using testing::SceneFiles;

std::string hex(const std::string& bytes) {
  std::string result;
  for (const unsigned char c : bytes) {
    constexpr char kDigits[] = "0123456789abcdef";
    result += {kDigits[c >> 4], kDigits[c & 15]};
  }
  return result;
}

/// With openat2, and with the fallback for older kernels.
class Containment : public ::testing::TestWithParam<bool> {
 protected:
  Containment() {
    files_.write("root/a.pbrt", "inside");
    files_.write("root/sub/b.pbrt", "deeper");
    files_.write("secret.txt", "SECRET WORDS");
    std::filesystem::create_symlink("../secret.txt", files_.path() / "root/to_file");
    std::filesystem::create_symlink("../nothing.txt", files_.path() / "root/to_nothing");
    std::filesystem::create_symlink(files_.path() / "secret.txt", files_.path() / "root/absolute");
    std::filesystem::create_directory_symlink("..", files_.path() / "root/to_directory");
  }
  AssetReader reader() const {
    AssetReaderOptions options;
    options.use_openat2 = GetParam();
    return *AssetReader::open((files_.path() / "root").string(), options);
  }
  SceneFiles files_;
};
INSTANTIATE_TEST_SUITE_P(Kernels, Containment, ::testing::Bool());

TEST_P(Containment, ReadsBeneathTheRootRelativeToTheNamingFile) {
  AssetReader assets = reader();
  EXPECT_EQ(assets.read("a.pbrt")->bytes, "inside");
  EXPECT_EQ(assets.read("b.pbrt", "sub/x.pbrt")->bytes, "deeper");
  EXPECT_EQ(assets.read("../a.pbrt", "sub/x.pbrt")->name, "a.pbrt");
  EXPECT_EQ(assets.read("./sub//b.pbrt")->name, "sub/b.pbrt");
}

TEST_P(Containment, RefusesPathsOutOfTheRootWithTheSameErrorForExistingAndMissingFiles) {
  AssetReader assets = reader();
  const std::pair<std::string, std::string> kExistingAndMissing[] = {
      {"../secret.txt", "../nothing.txt"},
      {"sub/../../secret.txt", "sub/../../nothing.txt"},
      {(files_.path() / "secret.txt").string(), (files_.path() / "nothing.txt").string()},
      {(files_.path() / "root/a.pbrt").string(), (files_.path() / "root/nothing").string()},
      {"to_file", "to_nothing"},
      {"to_directory/secret.txt", "to_directory/nothing.txt"},
      {"absolute", "absolute"},
  };
  for (const auto& [existing, missing] : kExistingAndMissing) {
    for (const std::string& name : {existing, missing}) {
      const auto content = assets.read(name);
      EXPECT_EQ(content.status().code(), absl::StatusCode::kInvalidArgument) << name;
      EXPECT_EQ(message(content.status()),
                "file name \"" + name + "\" leaves the scene root, allowed: paths inside it");
    }
  }
  EXPECT_TRUE(assets.assets().empty());
}

TEST_P(Containment, MissingFilesAreNotFound) {
  AssetReader assets = reader();
  EXPECT_TRUE(absl::IsNotFound(assets.read("nothing.pbrt").status()));
  EXPECT_TRUE(absl::IsNotFound(assets.read("a.pbrt/b").status()));
  EXPECT_FALSE(assets.read("").ok());
  EXPECT_FALSE(assets.read(".").ok());
}

TEST_P(Containment, OpensOnlyRegularFilesAndDoesNotWaitForAPipe) {
  ASSERT_EQ(mkfifo((files_.path() / "root/pipe").c_str(), 0600), 0);
  AssetReader assets = reader();
  EXPECT_THAT(message(assets.read("pipe").status()), HasSubstr("not a regular file"));
  EXPECT_THAT(message(assets.read("sub").status()), HasSubstr("not a regular file"));
}

TEST_P(Containment, LinksThatStayInsideAreFollowedWhereTheKernelChecksThem) {
  std::filesystem::create_symlink("sub/b.pbrt", files_.path() / "root/inner");
  AssetReader assets = reader();
  const auto content = assets.read("inner");
  if (content.ok()) {
    EXPECT_EQ(content->bytes, "deeper");
  } else {
    EXPECT_THAT(message(content.status()), HasSubstr("leaves the scene root"));
  }
}

TEST(AssetReader, DigestsAreSha256AndKeptOncePerFileInOrder) {
  const SceneFiles files;
  files.write("b", "abc");
  files.write("a", "");
  AssetReader assets = *AssetReader::open(files.path().string());
  for (const char* name : {"b", "a", "b"}) ASSERT_TRUE(assets.read(name).ok());
  ASSERT_EQ(assets.assets().size(), 2U);
  EXPECT_EQ(assets.assets()[0].name, "b");
  EXPECT_EQ(assets.assets()[0].bytes, 3U);
  // FIPS 180-2, appendix B.1, and the digest of nothing.
  EXPECT_EQ(hex(assets.assets()[0].sha256),
            "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad");
  EXPECT_EQ(hex(assets.assets()[1].sha256),
            "e3b0c44298fc1c149afbf4c8996fb92427ae41e4649b934ca495991b7852b855");
}

TEST(AssetReader, RehashFindsChangedFiles) {
  const SceneFiles files;
  files.write("a", "one");
  files.write("b", "two");
  AssetReader assets = *AssetReader::open(files.path().string());
  ASSERT_TRUE(assets.read("a").ok() && assets.read("b").ok());
  files.write("b", "three");
  const auto now = assets.rehash(assets.assets());
  ASSERT_TRUE(now.ok());
  EXPECT_EQ((*now)[0].sha256, assets.assets()[0].sha256);
  EXPECT_NE((*now)[1].sha256, assets.assets()[1].sha256);
  EXPECT_EQ((*now)[1].bytes, 5U);
  std::filesystem::remove(files.path() / "a");
  EXPECT_TRUE(absl::IsNotFound(assets.rehash(assets.assets()).status()));
}

TEST(AssetReader, AllReadsTogetherStayBelowTheLimit) {
  const SceneFiles files;
  files.write("a", std::string(600, 'a'));
  AssetReaderOptions options;
  options.max_total_bytes = 1000;
  AssetReader assets = *AssetReader::open(files.path().string(), options);
  EXPECT_TRUE(assets.read("a").ok());
  const auto second = assets.read("a");
  EXPECT_TRUE(absl::IsResourceExhausted(second.status()));
  EXPECT_THAT(message(second.status()), HasSubstr("1000 bytes"));
}

TEST(AssetReader, UnpacksGzipWithinTheLimit) {
  const SceneFiles files;
  const std::string text(3'000'000, 'z');
  files.write("z.gz", gzipped(text));
  files.write("plain", "plain");
  files.write("cut.gz", gzipped("some text that is cut").substr(0, 24));
  AssetReader assets = *AssetReader::open(files.path().string());
  EXPECT_EQ(assets.read_unpacked("z.gz")->bytes, text);
  EXPECT_EQ(assets.read_unpacked("plain")->bytes, "plain");
  EXPECT_THAT(message(assets.read_unpacked("cut.gz").status()), HasSubstr("broken or incomplete"));

  AssetReaderOptions options;
  options.max_total_bytes = 1'000'000;
  AssetReader small = *AssetReader::open(files.path().string(), options);
  EXPECT_TRUE(absl::IsResourceExhausted(small.read_unpacked("z.gz").status()));
}

TEST(AssetReader, UnpacksAllMembersOfGzip) {
  const SceneFiles files;
  files.write("two.gz", gzipped("one ") + gzipped("two"));
  files.write("rest.gz", gzipped("one") + "rest");
  std::string broken = gzipped("some text whose checksum is wrong");
  broken[broken.size() - 6] ^= 1;
  files.write("sum.gz", broken);
  AssetReader assets = *AssetReader::open(files.path().string());
  EXPECT_EQ(assets.read_unpacked("two.gz")->bytes, "one two");
  for (const char* name : {"rest.gz", "sum.gz"}) {
    const absl::Status status = assets.read_unpacked(name).status();
    EXPECT_TRUE(absl::IsInvalidArgument(status));
    EXPECT_THAT(message(status), HasSubstr(std::string("\"") + name + "\": its gzip data"));
  }
}

// 3 MB of one letter have about 3 kB in gzip, a ratio of 1000.
TEST(AssetReader, ASmallFileCannotUnpackToAHugeOne) {
  const SceneFiles files;
  files.write("bomb.gz", gzipped(std::string(3'000'000, 'z')));
  const auto unpack = [&](std::uint64_t bytes, std::uint64_t ratio) {
    AssetReaderOptions options;
    options.max_unpacked_bytes = bytes;
    options.max_unpacked_ratio = ratio;
    return AssetReader::open(files.path().string(), options)->read_unpacked("bomb.gz").status();
  };
  const absl::Status refused = unpack(2'999'999, 64);
  EXPECT_TRUE(absl::IsResourceExhausted(refused));
  EXPECT_THAT(message(refused), HasSubstr("\"bomb.gz\""));
  EXPECT_THAT(message(refused), HasSubstr("the larger of 2999999 bytes and 64 times its size"));
  EXPECT_TRUE(unpack(3'000'000, 64).ok());
  EXPECT_TRUE(unpack(0, 1032).ok());
  EXPECT_TRUE(unpack(0, ~std::uint64_t{}).ok());
}

TEST(AssetReader, MissingRootIsAnError) {
  EXPECT_TRUE(absl::IsNotFound(AssetReader::open("/nonexistent/root").status()));
}

}  // namespace
}  // namespace lucerna
