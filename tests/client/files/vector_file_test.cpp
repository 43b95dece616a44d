// Files of points and normals.  The bytes of NPY files equal those of numpy 1.24.

#include <OpenImageIO/imageio.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <limits>
#include <numeric>
#include <vector>

#include "client/files/csv_file.h"
#include "client/files/map_file.h"
#include "client/files/npy_file.h"
#include "client/files/open_vectors.h"
#include "tests/temp_directory.h"

namespace lucerna::client {
namespace {

namespace fs = std::filesystem;
using ::testing::ElementsAre;
using ::testing::HasSubstr;

class VectorFileTest : public ::testing::Test {
 protected:
  std::string path(const std::string& name) const { return (directory_.path() / name).string(); }
  std::string write(const std::string& name, const std::string& bytes) const {
    std::ofstream(path(name), std::ios::binary) << bytes;
    return path(name);
  }
  /// The message without the name of the file.
  std::string refusal(const std::string& path, VectorKind kind = VectorKind::kPoints) const {
    const auto file = open_vectors(path, kind);
    EXPECT_EQ(file.status().code(), absl::StatusCode::kInvalidArgument) << file.status();
    const std::string message(file.status().message());
    EXPECT_TRUE(message.starts_with(path)) << message;
    return message.substr(path.size());
  }
  std::vector<double> all(VectorFile& file) const {
    std::vector<double> values(file.rows() * file.columns());
    EXPECT_TRUE(file.read(0, values).ok());
    return values;
  }

  const TempDirectory directory_;
};

/// The output of numpy.save(): the header, padded with spaces to 128 bytes, and the numbers.
std::string npy(const std::string& dictionary, const std::string& numbers) {
  std::string text = dictionary + std::string(117 - dictionary.size(), ' ') + "\n";
  return std::string("\x93NUMPY\x01\x00v\x00", 10) + text + numbers;
}

template <std::size_t n>
std::string bytes(const char (&literal)[n]) {
  return {literal, n - 1};
}

// 0, 1.5, -2, 3, 4, 5 as float32.
const std::string kFloats =
    bytes("\x00\x00\x00\x00\x00\x00\xc0?\x00\x00\x00\xc0\x00\x00@@\x00\x00\x80@\x00\x00\xa0@");
// 0.1, 1e8 + 0.25, -2, 0, 0, 1 as float64.
const std::string kDoubles = bytes(
    "\x9a\x99\x99\x99\x99\x99\xb9?\x00\x00\x00\x01\x84\xd7\x97"
    "A\x00\x00\x00\x00\x00\x00\x00\xc0\x00\x00\x00\x00\x00\x00\x00\x00"
    "\x00\x00\x00\x00\x00\x00\x00\x00\x00\x00\x00\x00\x00\x00\xf0?");

TEST_F(VectorFileTest, NpyOfFloatsAndDoubles) {
  auto narrow = open_vectors(
      write("a.npy", npy("{'descr': '<f4', 'fortran_order': False, 'shape': (2, 3), }", kFloats)),
      VectorKind::kPoints);
  ASSERT_TRUE(narrow.ok()) << narrow.status();
  EXPECT_EQ((*narrow)->rows(), 2U);
  EXPECT_EQ((*narrow)->columns(), 3U);
  EXPECT_EQ((*narrow)->window(), nullptr);
  EXPECT_THAT(all(**narrow), ElementsAre(0, 1.5, -2, 3, 4, 5));
  std::vector<double> second(3);
  ASSERT_TRUE((*narrow)->read(1, second).ok());
  EXPECT_THAT(second, ElementsAre(3, 4, 5));

  auto wide = open_vectors(
      write("b.NPY", npy("{'descr': '<f8', 'fortran_order': False, 'shape': (1, 6), }", kDoubles)),
      VectorKind::kPoints);
  ASSERT_TRUE(wide.ok()) << wide.status();
  EXPECT_THAT(all(**wide), ElementsAre(0.1, 1e8 + 0.25, -2, 0, 0, 1));
}

TEST_F(VectorFileTest, UnsupportedNpyIsRefusedWithTheReason) {
  const auto of = [&](const std::string& dictionary, const std::string& numbers) {
    return refusal(write("a.npy", npy(dictionary, numbers)));
  };
  const std::string good = "{'descr': '<f4', 'fortran_order': False, 'shape': (2, 3), }";
  EXPECT_EQ(of("{'descr': '>f8', 'fortran_order': False, 'shape': (1, 3), }", kFloats),
            ": descr = >f8, allowed: <f4 or <f8, little-endian floats");
  EXPECT_THAT(of("{'descr': '<i4', 'fortran_order': False, 'shape': (2, 3), }", kFloats),
              HasSubstr("descr = <i4"));
  EXPECT_THAT(of("{'descr': [('x', '<f4'), ('y', '<f4')], 'fortran_order': False, 'shape': (3,), }",
                 kFloats),
              HasSubstr("descr = [('x', '<f4'), ('y', '<f4')], allowed"));
  EXPECT_THAT(of("{'descr': '<f4', 'fortran_order': True, 'shape': (2, 3), }", kFloats),
              HasSubstr("fortran_order = True, allowed: False"));
  EXPECT_EQ(of("{'descr': '<f4', 'fortran_order': False, 'shape': (3, 2), }", kFloats),
            ": shape = (3, 2), allowed: (n, 3) or (n, 6)");
  EXPECT_THAT(of("{'descr': '<f4', 'fortran_order': False, 'shape': (6,), }", kFloats),
              HasSubstr("shape = (6), allowed"));
  EXPECT_THAT(of("{'descr': '<f4', 'fortran_order': False, 'shape': (1, 3, 2), }", kFloats),
              HasSubstr("shape = (1, 3, 2), allowed"));
  EXPECT_EQ(of(good, kFloats.substr(1)), ": holds 23 bytes of numbers, its shape has 2 rows of 12");
  EXPECT_EQ(of(good, kFloats + "x"), ": holds 25 bytes of numbers, its shape has 2 rows of 12");
  // 2^64 / 12 rows and more: the size in bytes overflows.
  EXPECT_THAT(
      of("{'descr': '<f4', 'fortran_order': False, 'shape': (6148914691236517206, 3), }", kFloats),
      HasSubstr("holds 24 bytes of numbers"));
  for (const char* odd : {"{'descr': '<f4', 'shape': (2, 3), }", "[1, 2]", "{'descr': '<f4",
                          "{'descr': '<f4', 'fortran_order': No, 'shape': (2, 3), }",
                          "{'descr': '<f4', 'fortran_order': False, 'shape': (-2, 3), }"}) {
    EXPECT_THAT(of(odd, kFloats), HasSubstr("has no valid NumPy header")) << odd;
  }
  EXPECT_EQ(refusal(write("a.npy", "x,y,z\n1,2,3\n")), ": is not an NPY file");
  EXPECT_EQ(refusal(write("a.npy", "")), ": is not an NPY file");
  EXPECT_EQ(refusal(write("a.npy", npy(good, "").substr(0, 60))), ": ends within its header");
  std::string version = npy(good, kFloats);
  version[6] = 9;
  EXPECT_THAT(refusal(write("a.npy", version)), HasSubstr("is of version 9"));
  EXPECT_EQ(refusal(path("none.npy")), ": cannot be read");
}

TEST_F(VectorFileTest, NpyHeadersEqualThoseOfNumpy) {
  EXPECT_EQ(npy_header(2, 3),
            npy("{'descr': '<f4', 'fortran_order': False, 'shape': (2, 3), }", ""));
  // Longer headers too: the numbers begin at a multiple of 64.
  EXPECT_EQ(npy_header(100'000'000'000, 10).size() % 64, 0U);
  EXPECT_EQ(npy_header(100'000'000'000, 10).back(), '\n');
}

TEST_F(VectorFileTest, CsvIsReadFromAnyRowOn) {
  std::string text = "\xef\xbb\xbf# desks\r\nX,y,z,nx,ny,nz\r\n";
  for (int i = 0; i < 5000; ++i) {
    text += std::to_string(i) + ", 0.1,-2 ,0,0,1\n";
    if (i % 700 == 0) text += "\n# a comment\n";
  }
  auto file = open_vectors(write("a.csv", text), VectorKind::kPoints);
  ASSERT_TRUE(file.ok()) << file.status();
  EXPECT_EQ((*file)->rows(), 5000U);
  EXPECT_EQ((*file)->columns(), 6U);
  for (const std::uint64_t first : {0U, 1U, 1023U, 1024U, 4999U, 700U, 701U, 702U, 2048U}) {
    std::vector<double> row(6);
    ASSERT_TRUE((*file)->read(first, row).ok()) << first;
    EXPECT_THAT(row, ElementsAre(first, 0.1, -2, 0, 0, 1)) << first;
  }
  std::vector<double> many(std::size_t{6} * 3000);
  ASSERT_TRUE((*file)->read(1500, many).ok());
  EXPECT_EQ(many[6 * 2999], 4499);

  auto normals = open_vectors(write("n.csv", "nx,ny,nz\n0,0,1\n0,1,nan"), VectorKind::kNormals);
  ASSERT_TRUE(normals.ok()) << normals.status();
  EXPECT_EQ((*normals)->rows(), 2U);
  auto empty = open_vectors(write("e.csv", "x,y,z\n"), VectorKind::kPoints);
  ASSERT_TRUE(empty.ok()) << empty.status();
  EXPECT_EQ((*empty)->rows(), 0U);
}

TEST_F(VectorFileTest, CsvErrorsNameTheLine) {
  EXPECT_EQ(refusal(write("a.csv", "1,2,3\n\n1,2,3,0,0,1\n")),
            ":3: 6 columns, but 3 in the lines before");
  EXPECT_EQ(refusal(write("a.csv", "1,2\n")), ":1: 2 columns, must be 3 or 6: x,y,z[,nx,ny,nz]");
  EXPECT_EQ(refusal(path("none.csv")), ": cannot be read");
  // Numbers are parsed when they are read.
  const std::string name = write("a.csv", "x,y,z\n1,2,3\n4,oops,6\n");
  auto file = *open_vectors(name, VectorKind::kPoints);
  std::vector<double> rows(6);
  EXPECT_EQ(file->read(0, rows).message(), name + ":3: column 2: \"oops\" is not a number");
  rows.resize(3);
  EXPECT_TRUE(file->read(0, rows).ok());
  EXPECT_EQ(file->read(1, rows).message(), name + ":3: column 2: \"oops\" is not a number");
}

/// Channel c of the texel at (x, y) is 1000 c + 40 y + x.
struct ChannelPicture {
  int width = 40, height = 70;
  std::vector<std::string> channels;
  int tile = 0;
  int x = 0, y = 0;
  OIIO::TypeDesc type = OIIO::TypeDesc::FLOAT;
  std::vector<OIIO::TypeDesc> types = {};

  OIIO::ImageSpec spec() const {
    OIIO::ImageSpec spec(width, height, static_cast<int>(channels.size()), type);
    spec.channelnames = channels;
    spec.channelformats = types;
    spec.tile_width = spec.tile_height = tile;
    spec.x = x;
    spec.y = y;
    return spec;
  }
  void write(OIIO::ImageOutput& file) const {
    std::vector<float> values;
    for (int v = 0; v < height; ++v) {
      for (int u = 0; u < width; ++u) {
        for (std::size_t c = 0; c < channels.size(); ++c)
          values.push_back(static_cast<float>(1000 * c + 40 * v + u));
      }
    }
    ASSERT_TRUE(file.write_image(OIIO::TypeDesc::FLOAT, values.data())) << file.geterror();
  }
  std::string write(const std::string& path) const {
    const auto file = OIIO::ImageOutput::create("openexr");
    EXPECT_TRUE(file->open(path, spec())) << file->geterror();
    write(*file);
    EXPECT_TRUE(file->close());
    return path;
  }
};

TEST_F(VectorFileTest, MapsAreReadFromAnyTexelOn) {
  for (const int tile : {0, 16}) {
    // In another order, and with an extra channel.
    const ChannelPicture picture{
        .channels = {"B.P.X", "B.P.Y", "N.Z", "N.Y", "N.X", "mask", "B.P.Z"},
        .tile = tile,
        .x = 5,
        .y = -3};
    auto file = open_vectors(picture.write(path("a.exr")), VectorKind::kPoints);
    ASSERT_TRUE(file.ok()) << file.status();
    ASSERT_NE((*file)->window(), nullptr);
    EXPECT_EQ((*file)->window()->width, 40);
    EXPECT_EQ((*file)->window()->height, 70);
    EXPECT_EQ((*file)->window()->x, 5);
    EXPECT_EQ((*file)->window()->y, -3);
    EXPECT_EQ((*file)->rows(), 2800U);
    ASSERT_EQ((*file)->columns(), 6U);
    // Across the ends of two rows.
    std::vector<double> values(std::size_t{6} * 90);
    ASSERT_TRUE((*file)->read(35, values).ok());
    for (int i = 0; i < 90; ++i) {
      const double texel = 35 + i;
      EXPECT_THAT(
          std::vector<double>(values.begin() + 6L * i, values.begin() + 6L * (i + 1)),
          ElementsAre(texel, 1000 + texel, 6000 + texel, 4000 + texel, 3000 + texel, 2000 + texel));
    }
    std::vector<double> last(6);
    ASSERT_TRUE((*file)->read(2799, last).ok());
    EXPECT_EQ(last[0], 2799);
  }
}

TEST_F(VectorFileTest, ChannelsOfMapsByTheirNames) {
  const auto columns = [&](std::vector<std::string> channels, VectorKind kind) {
    const auto file = open_vectors(ChannelPicture{.channels = channels}.write(path("a.exr")), kind);
    EXPECT_TRUE(file.ok()) << file.status();
    std::vector<double> row((*file)->columns());
    EXPECT_TRUE((*file)->read(0, row).ok());
    return row;
  };
  const auto points = VectorKind::kPoints, normals = VectorKind::kNormals;
  EXPECT_THAT(columns({"R", "G", "B"}, points), ElementsAre(0, 1000, 2000));
  EXPECT_THAT(columns({"X", "Y", "Z"}, normals), ElementsAre(0, 1000, 2000));
  EXPECT_THAT(columns({"R", "G", "B", "P.R", "P.G", "P.B"}, points), ElementsAre(3000, 4000, 5000));
  EXPECT_THAT(columns({"P.X", "P.Y", "P.Z", "N.X", "N.Y", "N.Z"}, normals),
              ElementsAre(3000, 4000, 5000));
  EXPECT_THAT(
      columns({"Position.X", "Position.Y", "Position.Z", "Normal.X", "Normal.Y", "Normal.Z"},
              points),
      ElementsAre(0, 1000, 2000, 3000, 4000, 5000));
  EXPECT_THAT(refusal(ChannelPicture{.channels = {"P.X", "P.Y", "A"}}.write(path("a.exr"))),
              HasSubstr("; must have P.X, P.Y, P.Z, or X, Y, Z, or R, G, B"));
  EXPECT_THAT(refusal(ChannelPicture{.channels = {"Y"}}.write(path("a.exr")), normals),
              HasSubstr("has channels Y; must have N.X, N.Y, N.Z"));
}

TEST_F(VectorFileTest, SixteenBitsAreEnoughForNormalsAlone) {
  const auto half = OIIO::TypeDesc::HALF, whole = OIIO::TypeDesc::FLOAT;
  ChannelPicture both{.channels = {"P.X", "P.Y", "P.Z", "N.X", "N.Y", "N.Z"}};
  both.types = {whole, whole, whole, half, half, half};
  EXPECT_TRUE(open_vectors(both.write(path("a.exr")), VectorKind::kPoints).ok());
  both.types = {whole, half, whole, half, half, half};
  EXPECT_THAT(refusal(both.write(path("a.exr"))),
              HasSubstr("channel P.Y is of type half, must be float"));
}

TEST_F(VectorFileTest, MapsOfSeveralParts) {
  const ChannelPicture points{.channels = {"P.X", "P.Y", "P.Z"}},
      normals{.channels = {"N.X", "N.Y", "N.Z"}};
  auto specs = std::vector{points.spec(), normals.spec()};
  specs[0].attribute("name", "points");
  specs[1].attribute("name", "normals");
  const auto out = OIIO::ImageOutput::create("openexr");
  ASSERT_TRUE(out->open(path("a.exr"), 2, specs.data())) << out->geterror();
  points.write(*out);
  ASSERT_TRUE(out->open(path("a.exr"), specs[1], OIIO::ImageOutput::AppendSubimage));
  normals.write(*out);
  ASSERT_TRUE(out->close());
  auto file = open_vectors(path("a.exr"), VectorKind::kPoints);
  ASSERT_TRUE(file.ok()) << file.status();
  std::vector<double> row(6);
  ASSERT_TRUE((*file)->read(41, row).ok());
  EXPECT_THAT(row, ElementsAre(41, 1041, 2041, 41, 1041, 2041));
}

TEST_F(VectorFileTest, InvalidMapsAreRefused) {
  EXPECT_THAT(refusal(write("a.exr", "x,y,z\n1,2,3\n")), HasSubstr("is not an OpenEXR file"));
  EXPECT_THAT(refusal(path("none.exr")), HasSubstr("No such file"));
  const std::string good = ChannelPicture{.channels = {"R", "G", "B"}}.write(path("a.exr"));
  fs::resize_file(good, fs::file_size(good) / 2);
  auto file = open_vectors(good, VectorKind::kPoints);
  if (!file.ok()) return;
  std::vector<double> values((*file)->rows() * 3);
  EXPECT_THAT((*file)->read(0, values).message(), HasSubstr(good));
  EXPECT_THAT(refusal(path("a.txt")), HasSubstr("must be .npy, .csv or .exr"));
}

TEST_F(VectorFileTest, MapsAreWrittenRowByRow) {
  const MapWindow window{.x = 5,
                         .y = -3,
                         .width = 2,
                         .height = 3,
                         .full_x = 0,
                         .full_y = 0,
                         .full_width = 9,
                         .full_height = 8};
  const std::string name = path("out.part");
  auto out = MapWriter::create(name, window, {"light.Y", "R", "G", "B"}, "by two servers");
  ASSERT_TRUE(out.ok()) << out.status();
  for (int row = 0; row < 3; ++row) {
    std::vector<float> values(8);
    std::iota(values.begin(), values.end(), static_cast<float>(100 * row));
    ASSERT_TRUE((*out)->write_row(values).ok());
  }
  ASSERT_TRUE((*out)->close().ok());
  fs::rename(name, path("out.exr"));
  const auto in = OIIO::ImageInput::open(path("out.exr"));
  ASSERT_TRUE(in);
  const OIIO::ImageSpec& spec = in->spec();
  EXPECT_THAT(spec.channelnames, ElementsAre("R", "G", "B", "light.Y"));
  EXPECT_EQ(spec.y, -3);
  EXPECT_EQ(spec.full_width, 9);
  EXPECT_EQ(spec.get_string_attribute("ImageDescription"), "by two servers");
  std::vector<float> values(24);
  ASSERT_TRUE(in->read_image(0, 0, 0, 4, OIIO::TypeDesc::FLOAT, values.data()));
  EXPECT_EQ(values[0], 1);                // R of the first texel
  EXPECT_EQ(values[3], 0);                // its light.Y
  EXPECT_EQ(values[2 * 8 + 4 + 2], 207);  // B of the last
  EXPECT_EQ(MapWriter::create(path("no/such/place"), window, {"Y"}, "").status().code(),
            absl::StatusCode::kUnknown);
}

}  // namespace
}  // namespace lucerna::client
