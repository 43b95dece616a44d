#include "client/files/write_picture.h"

#include <OpenImageIO/imageio.h>
#include <fcntl.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cmath>
#include <csignal>
#include <filesystem>
#include <fstream>
#include <functional>
#include <limits>
#include <optional>

#include "tests/temp_directory.h"

namespace lucerna {
namespace {

namespace fs = std::filesystem;
using client::PictureFile;
using client::srgb8;
using ::testing::ElementsAreArray;
using ::testing::HasSubstr;

/// A temporary directory for the test.
class WritePicture : public ::testing::Test {
 protected:
  std::string path(const std::string& name) const { return (directory_ / name).string(); }
  std::size_t files() const {
    return std::distance(fs::directory_iterator(directory_), fs::directory_iterator());
  }

  const TempDirectory temp_;
  const fs::path& directory_ = temp_.path();
};

// Two rows of three pixels with different values.
const std::vector<float> kPixels = {0.0F,  0.1F,   0.2F,  0.3F, 1.5F,  1e-5F, 7.0F,  8.25F, 1e6F,
                                    0.04F, 0.125F, 0.75F, 2.0F, 0.33F, 0.66F, 0.99F, 0.01F, 0.5F};

std::vector<float> read(const std::string& path) {
  const auto file = OIIO::ImageInput::open(path);
  if (!file || file->spec().width != 3 || file->spec().height != 2) return {};
  std::vector<float> values(18);
  file->read_image(0, 0, 0, 3, OIIO::TypeDesc::FLOAT, values.data());
  return values;
}

absl::Status write(const std::string& path, double exposure_ev = 0) {
  auto file = PictureFile::create(path);
  if (!file.ok()) return file.status();
  return file->write({.width = 3, .height = 2, .rgb = kPixels}, exposure_ev);
}

TEST(Srgb, CodesOfKnownValues) {
  // From the standard's table of landmarks: code 188 is linear 0.5 (0.7354), 118 is 18% grey
  // (0.4614); 128 decodes to 0.215861; the end of the straight part, 0.0031308, codes to 10.3.
  EXPECT_EQ(srgb8(0.0F), 0);
  EXPECT_EQ(srgb8(0.0031308F), 10);
  EXPECT_EQ(srgb8(0.001F), 3);  // 12.92 * 0.255 = 3.29
  EXPECT_EQ(srgb8(0.18F), 118);
  EXPECT_EQ(srgb8(0.215861F), 128);
  EXPECT_EQ(srgb8(0.5F), 188);
  EXPECT_EQ(srgb8(1.0F), 255);
}

TEST(Srgb, ValuesBeyondTheRangeAreClamped) {
  EXPECT_EQ(srgb8(-1.0F), 0);
  EXPECT_EQ(srgb8(7.0F), 255);
  EXPECT_EQ(srgb8(std::numeric_limits<float>::infinity()), 255);
  EXPECT_EQ(srgb8(std::numeric_limits<float>::quiet_NaN()), 0);
}

TEST_F(WritePicture, ExrAndPfmKeepEveryBit) {
  for (const char* name : {"a.exr", "b.pfm", "c.EXR"}) {
    ASSERT_TRUE(write(path(name)).ok()) << write(path(name));
    EXPECT_THAT(read(path(name)), ElementsAreArray(kPixels)) << name;
  }
  EXPECT_EQ(files(), 3U);
}

TEST_F(WritePicture, ExposureIsForPngAlone) {
  ASSERT_TRUE(write(path("a.exr"), 3).ok());
  EXPECT_THAT(read(path("a.exr")), ElementsAreArray(kPixels));
  // One stop up takes 0.25 to 0.5, code 188.
  auto file = *PictureFile::create(path("b.png"));
  const std::vector<float> grey(18, 0.25F);
  ASSERT_TRUE(file.write({.width = 3, .height = 2, .rgb = grey}, 1).ok());
  EXPECT_EQ(std::lround(read(path("b.png"))[0] * 255), 188);
}

TEST_F(WritePicture, PngHasRowsFromTheTop) {
  ASSERT_TRUE(write(path("a.png")).ok());
  const std::vector<float> values = read(path("a.png"));
  ASSERT_EQ(values.size(), 18U);
  for (std::size_t i = 0; i < values.size(); ++i) {
    EXPECT_EQ(std::lround(values[i] * 255), srgb8(kPixels[i])) << i;
  }
}

TEST_F(WritePicture, FilesStoreTheDescription) {
  for (const char* name : {"a.exr", "a.png"}) {
    auto file = *PictureFile::create(path(name));
    const client::PictureView picture{
        .width = 3, .height = 2, .rgb = kPixels, .description = "a room"};
    ASSERT_TRUE(file.write(picture, 0).ok());
    const auto in = OIIO::ImageInput::open(path(name));
    ASSERT_TRUE(in) << OIIO::geterror();
    EXPECT_EQ(in->spec().get_string_attribute("ImageDescription"), "a room") << name;
  }
}

/// While it exists, files of this process hold at most 10 bytes.
class SmallFiles {
 public:
  SmallFiles() : handler_(std::signal(SIGXFSZ, SIG_IGN)) {
    getrlimit(RLIMIT_FSIZE, &before_);
    const rlimit small{10, before_.rlim_max};
    setrlimit(RLIMIT_FSIZE, &small);
  }
  ~SmallFiles() {
    setrlimit(RLIMIT_FSIZE, &before_);
    std::signal(SIGXFSZ, handler_);
  }
  SmallFiles(const SmallFiles&) = delete;
  SmallFiles& operator=(const SmallFiles&) = delete;

 private:
  void (*handler_)(int);
  rlimit before_{};
};

TEST_F(WritePicture, AFullDiskIsAnError) {
  for (const char* name : {"a.exr", "a.png", "a.pfm"}) {
    auto file = *PictureFile::create(path(name));
    absl::Status status;
    {
      const SmallFiles limit;
      status = file.write({.width = 3, .height = 2, .rgb = kPixels}, 0);
    }
    EXPECT_THAT(std::string(status.message()), HasSubstr("cannot write " + path(name))) << name;
  }
}

TEST_F(WritePicture, AnUnwrittenPictureLeavesNoFile) {
  {
    const auto file = PictureFile::create(path("a.exr"));
    ASSERT_TRUE(file.ok());
    EXPECT_FALSE(fs::exists(path("a.exr")));
    // A killed process leaves what the folder has now.
    const int unnamed = ::open(directory_.c_str(), O_TMPFILE | O_WRONLY | O_CLOEXEC, 0666);
    EXPECT_EQ(files(), unnamed >= 0 ? 0U : 1U);
    if (unnamed >= 0) ::close(unnamed);
  }
  EXPECT_EQ(files(), 0U);
}

/// Runs `f` in a process of its own, which then ends by `signal`, or with f's value.
int in_process(const std::function<int()>& f, int signal = 0) {
  const pid_t child = ::fork();
  if (child == 0) {
    const int value = f();
    if (signal != 0) std::raise(signal);
    ::_exit(value);
  }
  int status = 0;
  EXPECT_EQ(::waitpid(child, &status, 0), child);
  return WIFSIGNALED(status) ? -WTERMSIG(status) : WEXITSTATUS(status);
}

// As on a file system without unnamed files.
TEST_F(WritePicture, HiddenFilesOfKilledProcessesAreRemovedByTheNext) {
  for (const char* other : {".a.x.exr", ".a.1.png", ".b.1.exr", ".a..exr", "a.1.exr"})
    std::ofstream(path(other)) << "of another";
  std::optional<absl::StatusOr<PictureFile>> file;
  for (int i = 0; i < 2; ++i) {
    const int killed = in_process(
        [&] {
          file = PictureFile::create(path("a.exr"), false);
          return 0;
        },
        SIGKILL);
    EXPECT_EQ(killed, -SIGKILL);
    EXPECT_EQ(files(), 6U);  // the second process has removed the file of the first
  }
  // A file system with unnamed files may have them from before.
  file = PictureFile::create(path("a.exr"));
  ASSERT_TRUE(file->ok());
  ASSERT_TRUE((*file)->write({.width = 3, .height = 2, .rgb = kPixels}, 0).ok());
  EXPECT_EQ(files(), 6U);
  EXPECT_THAT(read(path("a.exr")), ElementsAreArray(kPixels));
}

TEST_F(WritePicture, HiddenFilesInUseStay) {
  auto file = *PictureFile::create(path("a.exr"), false);
  EXPECT_EQ(files(), 1U);
  const auto others = [&] {
    const auto other = PictureFile::create(path("a.exr"), false);
    return other.ok() ? static_cast<int>(files()) : 100;
  };
  EXPECT_EQ(in_process(others), 2);
  EXPECT_EQ(files(), 1U);
  ASSERT_TRUE(file.write_preview({.width = 3, .height = 2, .rgb = kPixels}, 0).ok());
  EXPECT_EQ(in_process(others), 2);
  ASSERT_TRUE(file.write({.width = 3, .height = 2, .rgb = kPixels}, 0).ok());
  EXPECT_THAT(read(path("a.exr")), ElementsAreArray(kPixels));
}

TEST_F(WritePicture, PreviewsAreReplacedOneByOne) {
  auto file = *PictureFile::create(path("a.pfm"));
  for (const double ev : {0.0, 1.0, 2.0}) {
    ASSERT_TRUE(file.write_preview({.width = 3, .height = 2, .rgb = kPixels}, ev).ok());
    EXPECT_EQ(files(), 1U);
    EXPECT_THAT(read(path("a.pfm")), ElementsAreArray(kPixels));
  }
  ASSERT_TRUE(file.write({.width = 3, .height = 2, .rgb = kPixels}, 0).ok());
  EXPECT_EQ(files(), 1U);
}

TEST_F(WritePicture, TheOldFileStaysUntilTheNewOneIsComplete) {
  std::ofstream(path("a.exr")) << "old";
  {
    const auto file = PictureFile::create(path("a.exr"));
    ASSERT_TRUE(file.ok());
  }
  EXPECT_EQ(fs::file_size(path("a.exr")), 3U);
  ASSERT_TRUE(write(path("a.exr")).ok());
  EXPECT_THAT(read(path("a.exr")), ElementsAreArray(kPixels));
  EXPECT_EQ(files(), 1U);
}

TEST_F(WritePicture, RefusesInvalidPathsBeforehand) {
  const auto refusal = [](const std::string& path) {
    const auto file = PictureFile::create(path);
    EXPECT_EQ(file.status().code(), absl::StatusCode::kInvalidArgument) << path;
    return std::string(file.status().message());
  };
  EXPECT_THAT(refusal(path("a.jpg")), HasSubstr("must be .exr, .png or .pfm"));
  EXPECT_THAT(refusal(path("a")), HasSubstr("unknown file type"));
  EXPECT_THAT(refusal(path("no/such/a.exr")), HasSubstr("No such file or directory"));
  fs::create_directory(directory_ / "d.exr");
  EXPECT_THAT(refusal(path("d.exr")), HasSubstr("it is a directory"));
}

}  // namespace
}  // namespace lucerna
