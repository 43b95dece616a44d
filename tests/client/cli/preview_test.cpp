#include "client/cli/preview.h"

#include <OpenImageIO/imageio.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cstring>
#include <filesystem>

#include "client/terminal/session.h"
#include "tests/temp_directory.h"
#include "tests/tev_receiver.h"

namespace lucerna {
namespace {

namespace fs = std::filesystem;
using cli::CommandError;
using cli::Preview;
using client::PictureFile;
using ::testing::Each;

/// Row `y` of a picture of 3 x 2 pixels with this value in each.
v1::Tile row(std::uint32_t y, double value) {
  v1::Tile tile;
  tile.mutable_rect()->set_y0(y);
  tile.mutable_rect()->set_x1(3);
  tile.mutable_rect()->set_y1(y + 1);
  tile.set_image_width(3);
  tile.set_image_height(2);
  tile.set_block_count(2);
  const std::vector<double> sums(9, 2 * value), deviations(9, 0);
  tile.mutable_sum()->assign(reinterpret_cast<const char*>(sums.data()), 72);
  tile.mutable_deviation()->assign(reinterpret_cast<const char*>(deviations.data()), 72);
  return tile;
}

class PreviewTest : public ::testing::Test {
 protected:
  std::string path(const std::string& name) const { return (directory_.path() / name).string(); }
  void create(const std::vector<std::string>& names) {
    for (const std::string& name : names) files_.push_back(*PictureFile::create(path(name)));
  }
  void add(Preview& preview, const v1::Tile& tile) {
    ASSERT_TRUE(assembler_.add(tile).ok());
    preview.update(tile, assembler_);
  }
  /// The codes of the PNG, empty before its first version.  Every version is a whole file.
  std::vector<std::uint8_t> codes(const std::string& name) const {
    if (!fs::exists(path(name))) return {};
    const auto file = OIIO::ImageInput::open(path(name));
    EXPECT_TRUE(file) << OIIO::geterror();
    if (!file) return {};
    std::vector<std::uint8_t> result(18);
    EXPECT_TRUE(file->read_image(0, 0, 0, 3, OIIO::TypeDesc::UINT8, result.data()));
    return result;
  }
  bool becomes(const std::string& name, std::uint8_t first, std::uint8_t second) const {
    std::vector<std::uint8_t> expected(18, first);
    std::fill(expected.begin() + 9, expected.end(), second);
    return TevReceiver::wait_for([&] { return codes(name) == expected; });
  }
  std::size_t entries() const {
    return static_cast<std::size_t>(
        std::distance(fs::directory_iterator(directory_.path()), fs::directory_iterator()));
  }

  const TempDirectory directory_;
  std::vector<PictureFile> files_;
  client::PictureAssembler assembler_;
};

TEST_F(PreviewTest, RedrawsPngsAndNoOtherFiles) {
  create({"a.exr", "b.png", "c.PNG"});
  Preview preview({.redraw_s = 0.1}, {path("a.exr"), path("b.png"), path("c.PNG")});
  ASSERT_TRUE(preview);
  preview.begin(files_, 1);
  add(preview, row(1, 0.25));
  // One stop up makes 0.5 of 0.25, code 188; missing tiles are black.
  EXPECT_TRUE(becomes("b.png", 0, 188));
  EXPECT_TRUE(becomes("c.PNG", 0, 188));
  add(preview, row(0, 0.5));
  EXPECT_TRUE(becomes("b.png", 255, 188));
  add(preview, row(1, 0));
  EXPECT_TRUE(becomes("b.png", 255, 0));
  preview.files_done();
  EXPECT_FALSE(fs::exists(path("a.exr")));
  const client::Picture picture = assembler_.picture().value();
  for (PictureFile& file : files_) {
    ASSERT_TRUE(file.write({.width = 3, .height = 2, .rgb = picture.pixels}, 0).ok());
  }
  preview.finish();
  EXPECT_TRUE(becomes("b.png", 188, 0));
  EXPECT_EQ(entries(), 3U);
}

TEST_F(PreviewTest, DrawsTheNewestOfTilesThatComeFasterThanItDraws) {
  create({"b.png"});
  Preview preview({.redraw_s = 0.1}, {path("b.png")});
  preview.begin(files_, 0);
  for (const double value : {1.0, 0.5, 0.0, 0.25}) {
    add(preview, row(0, 1 - value));
    add(preview, row(1, value));
  }
  add(preview, row(0, 0.25));
  EXPECT_TRUE(becomes("b.png", 137, 137));
  preview.files_done();
}

TEST_F(PreviewTest, LastPreviewOfAnInterruptedRenderStays) {
  create({"b.png"});
  {
    Preview preview({.redraw_s = 0.1}, {path("b.png")});
    preview.begin(files_, 0);
    add(preview, row(0, 0.25));
    EXPECT_TRUE(becomes("b.png", 137, 0));
  }
  files_.clear();
  EXPECT_TRUE(becomes("b.png", 137, 0));
  EXPECT_EQ(entries(), 1U);
}

TEST_F(PreviewTest, WithoutKeepingOnlyFinishedPicturesStay) {
  create({"whole.png", "half.png"});
  for (PictureFile& file : files_) file.keep_no_preview();
  Preview preview({.redraw_s = 0.1}, {path("whole.png"), path("half.png")});
  preview.begin(files_, 0);
  add(preview, row(0, 0.25));
  EXPECT_TRUE(becomes("half.png", 137, 0));
  preview.files_done();
  const std::vector<float> pixels(18, 0.25F);
  ASSERT_TRUE(files_[0].write({.width = 3, .height = 2, .rgb = pixels}, 0).ok());
  files_.clear();
  EXPECT_TRUE(becomes("whole.png", 137, 137));
  EXPECT_FALSE(fs::exists(path("half.png")));
  EXPECT_EQ(entries(), 1U);
}

TEST_F(PreviewTest, EachPictureHasItsOwnImageInTev) {
  const TevReceiver viewer;
  Preview preview({.tev = viewer.address()}, {path("1.exr")});
  ASSERT_TRUE(preview);
  for (const char* name : {"1.exr", "2.exr"}) {
    files_.clear();
    create({name});
    assembler_ = client::PictureAssembler();
    preview.begin(files_, 0);
    add(preview, row(0, 5));
    add(preview, row(1, 5));
    preview.files_done();
    preview.finish();
  }
  for (const char* name : {"1.exr", "2.exr"}) {
    ASSERT_TRUE(TevReceiver::wait_for([&] { return viewer.images()[path(name)].updates == 2; }));
    EXPECT_THAT(viewer.images()[path(name)].rgb, Each(5.0F));
  }
}

TEST_F(PreviewTest, IsOffByDefault) {
  create({"b.png"});
  Preview preview({}, {path("b.png")});
  EXPECT_FALSE(preview);
  preview.begin(files_, 0);
  add(preview, row(0, 1));
  preview.files_done();
  preview.finish();
  EXPECT_FALSE(fs::exists(path("b.png")));
}

TEST_F(PreviewTest, RefusesWrongOptions) {
  EXPECT_THROW(Preview({.redraw_s = 2}, {path("a.exr")}), CommandError);
  EXPECT_THROW(Preview({.tev = "localhost:x"}, {path("a.exr")}), CommandError);
}

}  // namespace
}  // namespace lucerna
