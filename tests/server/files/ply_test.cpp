#include "server/files/ply.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cstring>
#include <limits>
#include <string>

#include "tests/server/pbrt/pbrt_fixture.h"

namespace lucerna {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using testing::message;

const std::string kQuadHeader =
    "element vertex 4\nproperty float x\nproperty float y\nproperty float z\n"
    "element face 1\nproperty list uchar int vertex_indices\nend_header\n";

std::string ascii(const std::string& rest) { return "ply\nformat ascii 1.0\n" + rest; }

std::string ply_error(const std::string& bytes) { return message(parse_ply(bytes).status()); }

template <typename T>
std::string raw(T value, bool big_endian) {
  std::string bytes(sizeof(T), '\0');
  std::memcpy(bytes.data(), &value, sizeof(T));
  if (big_endian) std::reverse(bytes.begin(), bytes.end());
  return bytes;
}

std::string binary_quad(bool big_endian, float last = 7) {
  std::string bytes = "ply\nformat binary_";
  bytes += big_endian ? "big" : "little";
  bytes += "_endian 1.0\n" + kQuadHeader;
  for (const float n : {0.F, 0.F, 0.F, 1.F, 0.F, 0.F, 1.F, 2.F, 0.F, 0.F, 2.F, last})
    bytes += raw(n, big_endian);
  bytes += raw(std::uint8_t{4}, big_endian);
  for (const int i : {0, 1, 2, 3}) bytes += raw(i, big_endian);
  return bytes;
}

TEST(Ply, AsciiAndBothBinariesGiveTheSameMeshWithQuadsSplit) {
  const std::string text = ascii(kQuadHeader) + "0 0 0\n1 0 0\n1 2 0\r\n0 2 7\n4 0 1 2 3\n";
  for (const std::string& bytes : {text, binary_quad(false), binary_quad(true)}) {
    const auto mesh = testing::value_of(parse_ply(bytes));
    EXPECT_THAT(mesh.positions,
                ElementsAre(Vec3(0, 0, 0), Vec3(1, 0, 0), Vec3(1, 2, 0), Vec3(0, 2, 7)));
    EXPECT_THAT(mesh.indices, ElementsAre(0, 1, 2, 0, 2, 3));
    EXPECT_THAT(mesh.quads, ElementsAre(0));
    EXPECT_TRUE(mesh.normals.empty());
  }
}

/// A strip of `n` triangles with all properties of vertices, in types of several sizes.  `plain`:
/// the faces have no other property, and indices of four bytes.
std::string binary_strip(int n, bool big_endian, bool plain) {
  std::string bytes =
      "ply\nformat binary_" + std::string(big_endian ? "big" : "little") +
      "_endian 1.0\nelement vertex " + std::to_string(n + 2) +
      "\nproperty uchar flags\nproperty double x\nproperty float y\nproperty short z\n"
      "property float nx\nproperty double ny\nproperty float nz\n"
      "property float v\nproperty float u\nelement face " +
      std::to_string(n) + "\nproperty list uchar " + (plain ? "uint" : "ushort") +
      " vertex_indices\n" + (plain ? "" : "property int face_indices\n") + "end_header\n";
  for (int i = 0; i < n + 2; ++i) {
    bytes += raw(std::uint8_t{7}, big_endian) + raw(i + 0.25, big_endian) +
             raw(float(i % 2), big_endian) + raw(std::int16_t(-i), big_endian) +
             raw(0.5F, big_endian) + raw(0.25, big_endian) + raw(float(i), big_endian) +
             raw(i + 0.5F, big_endian) + raw(i * 2.F, big_endian);
  }
  for (int i = 0; i < n; ++i) {
    bytes += raw(std::uint8_t{3}, big_endian);
    for (int k = 0; k < 3; ++k)
      bytes +=
          plain ? raw(std::uint32_t(i + k), big_endian) : raw(std::uint16_t(i + k), big_endian);
    if (!plain) bytes += raw(i * 3, big_endian);
  }
  return bytes;
}

TEST(Ply, BulkReadsAllPropertiesInBothByteOrders) {
  constexpr int kTriangles = 20000;  // more than one block of rows
  for (const bool big_endian : {false, true})
    for (const bool plain : {false, true}) {
      const auto mesh = testing::value_of(parse_ply(binary_strip(kTriangles, big_endian, plain)));
      ASSERT_EQ(mesh.positions.size(), kTriangles + 2U);
      ASSERT_EQ(mesh.indices.size(), 3U * kTriangles);
      for (int i = 0; i < kTriangles + 2; i += 101) {
        EXPECT_EQ(mesh.positions[i], Vec3(i + 0.25, i % 2, -i));
        EXPECT_EQ(mesh.normals[i], Vec3f(0.5F, 0.25F, float(i)));
        EXPECT_EQ(mesh.uv[i], (Vec2f{i * 2.F, i + 0.5F}));
      }
      for (int i = 0; i < kTriangles; i += 101) EXPECT_EQ(mesh.indices[3 * i + 2], i + 2U);
    }
}

TEST(Ply, BulkNamesTheFirstBadRow) {
  std::string bytes = binary_strip(20000, false, true);
  const std::size_t header = bytes.find("end_header\n") + 11;
  constexpr std::size_t kRow = 1 + 8 + 4 + 2 + 4 + 8 + 4 + 4 + 4;
  std::string broken = bytes;
  const double infinite = std::numeric_limits<double>::infinity();
  std::memcpy(&broken[header + 17000 * kRow + 1], &infinite, 8);
  EXPECT_EQ(ply_error(broken), "PLY: vertex 17000 is not finite");
  const std::uint32_t beyond = 20002;
  std::memcpy(&bytes[header + 20002 * kRow + 13 * 12345 + 1], &beyond, 4);
  EXPECT_EQ(ply_error(bytes), "PLY: face 12345 uses vertex 20002, but there are 20002 vertices");
}

TEST(Ply, TextureCoordinatesHaveSeveralNames) {
  for (const auto& [u, v] :
       {std::pair{"u", "v"}, {"s", "t"}, {"texture_u", "texture_v"}, {"texture_s", "texture_t"}}) {
    const auto mesh = testing::value_of(parse_ply(
        ascii(std::string("element vertex 3\nproperty float ") + v +
              "\nproperty float x\nproperty float y\nproperty float z\nproperty float " + u +
              "\nelement face 1\nproperty list uchar int vertex_indices\nend_header\n"
              "0.5 0 0 0 0.25\n0 1 0 0 1\n1 0 1 0 0\n3 0 1 2\n")));
    EXPECT_THAT(mesh.uv, ElementsAre(Vec2f{0.25F, 0.5F}, Vec2f{1, 0}, Vec2f{0, 1}));
  }
  const auto half = testing::value_of(
      parse_ply(ascii("element vertex 3\nproperty float x\nproperty float y\nproperty float z\n"
                      "property float u\nelement face 1\nproperty list uchar int vertex_indices\n"
                      "end_header\n0 0 0 1\n1 0 0 1\n0 1 0 1\n3 0 1 2\n")));
  EXPECT_TRUE(half.uv.empty());
  const auto broken =
      testing::value_of(parse_ply(ascii("element vertex 1\nproperty float x\nproperty float y\n"
                                        "property float z\nproperty float u\nproperty float v\n"
                                        "element face 0\nproperty list uchar int vertex_indices\n"
                                        "end_header\n0 0 0 1 nan\n")));
  EXPECT_EQ(broken.mended_uv, 1U);
  EXPECT_THAT(broken.uv, ElementsAre(Vec2f{0, 0}));
}

TEST(Ply, OtherPropertiesElementsAndTypesAreSkipped) {
  const auto mesh = testing::value_of(parse_ply(ascii(
      "comment anything\nobj_info anything\n"
      "element camera 1\nproperty list uint8 float32 matrix\nproperty double zoom\n"
      "element vertex 3\nproperty uchar red\nproperty double x\nproperty short y\nproperty int8 z\n"
      "property float nx\nproperty float ny\nproperty float nz\n"
      "element face 1\nproperty float quality\nproperty list uint uint vertex_index\nend_header\n"
      "3 1 2 3 0.5\n"
      "255 0.1 0 0 0 0 2\n0 1 0 0 0 0 2\n0 0 1 -5 0 0 2\n"
      "0.25 3 2 1 0\n")));
  EXPECT_EQ(mesh.positions[0], Vec3(0.1, 0, 0));
  EXPECT_EQ(mesh.positions[2], Vec3(0, 1, -5));
  EXPECT_EQ(mesh.normals[1], Vec3f(0, 0, 2));
  EXPECT_THAT(mesh.indices, ElementsAre(2, 1, 0));
}

TEST(Ply, FacesMayComeBeforeVertices) {
  const std::string header =
      "element face 1\nproperty list uchar int vertex_indices\n"
      "element vertex 3\nproperty float x\nproperty float y\nproperty float z\nend_header\n";
  EXPECT_TRUE(parse_ply(ascii(header) + "3 0 1 2\n0 0 0 1 0 0 0 1 0").ok());
  EXPECT_EQ(ply_error(ascii(header) + "3 0 1 3\n0 0 0 1 0 0 0 1 0"),
            "PLY: a face uses vertex 3, but there are 3 vertices");
}

TEST(Ply, ErrorsNameTheElement) {
  const std::string four = "0 0 0 1 0 0 1 1 0 0 1 0 ";
  EXPECT_EQ(ply_error(ascii(kQuadHeader) + four + "5 0 1 2 3"),
            "PLY: face 0: the data end or do not contain a number");
  EXPECT_EQ(ply_error(ascii(kQuadHeader) + four + "3 0 1 4"),
            "PLY: face 0 uses vertex 4, but there are 4 vertices");
  EXPECT_EQ(ply_error(ascii(kQuadHeader) + four + "3 0 1 -1"), "PLY: face 0 uses vertex -1");
  EXPECT_EQ(ply_error(ascii(kQuadHeader) + "0 0 0 1 0 nan 1 1 0 0 1 0 3 0 1 2"),
            "PLY: vertex 1 is not finite");
  EXPECT_EQ(ply_error(ascii(kQuadHeader) + "0 0 0 1 0 0 1e999 1 0 0 1 0 3 0 1 2"),
            "PLY: vertex 2 is not finite");
  EXPECT_EQ(ply_error(binary_quad(false, std::numeric_limits<float>::infinity())),
            "PLY: vertex 3 is not finite");
  EXPECT_EQ(ply_error(ascii(kQuadHeader) + "0 0 0 1 zero 0 1 1 0 0 1 0 3 0 1 2"),
            "PLY: vertex 1: the data end or do not contain a number");
}

TEST(Ply, VerticesThatNoFaceUsesNeedNoPlace) {
  std::string bytes = binary_quad(false, std::numeric_limits<float>::quiet_NaN());
  bytes.replace(bytes.size() - 17, 17,
                raw(std::uint8_t{3}, false) + raw(0, false) + raw(1, false) + raw(2, false));
  for (const std::string& file :
       {bytes, ascii(kQuadHeader) + "0 0 0 1 0 0 1 2 0 nan -inf 7\n3 0 1 2\n"}) {
    const auto mesh = testing::value_of(parse_ply(file));
    // At a vertex of a face, so that the box of the mesh stays.
    EXPECT_THAT(mesh.positions,
                ElementsAre(Vec3(0, 0, 0), Vec3(1, 0, 0), Vec3(1, 2, 0), Vec3(0, 0, 0)));
  }
  const auto empty =
      testing::value_of(parse_ply(ascii(kQuadHeader) + "0 0 0 1 0 0 1 2 0 nan 0 0\n2 0 1\n"));
  EXPECT_THAT(empty.indices, ElementsAre());
}

TEST(Ply, ByteOrderMarksAndAllEndsOfLinesAreRead) {
  const std::string text = ascii(kQuadHeader) + "0 0 0\n1 0 0\n1 2 0\n0 2 7\n4 0 1 2 3\n";
  for (const std::string end : {"\n", "\r\n", "\r"})
    for (const std::string mark : {"", "\xef\xbb\xbf"})
      for (const bool is_binary : {false, true}) {
        const std::string whole = is_binary ? binary_quad(false) : text;
        const std::size_t header = whole.find("end_header\n") + 11;
        std::string bytes = mark;
        for (const char c : whole.substr(0, is_binary ? header : whole.size()))
          bytes += c == '\n' ? end : std::string(1, c);
        if (is_binary) bytes += whole.substr(header);
        const auto mesh = testing::value_of(parse_ply(bytes));
        EXPECT_THAT(mesh.positions,
                    ElementsAre(Vec3(0, 0, 0), Vec3(1, 0, 0), Vec3(1, 2, 0), Vec3(0, 2, 7)));
        EXPECT_EQ(mesh.indices.size(), 6U);
      }
}

TEST(Ply, ErrorsNameTheHeaderLine) {
  EXPECT_EQ(ply_error(""), "PLY: header line 1: the file ends before \"end_header\"");
  EXPECT_EQ(ply_error("plyx\n"), "PLY: header line 1: expected \"ply\"");
  EXPECT_THAT(ply_error("ply\nformat utf8 1.0\n"), HasSubstr("line 2: format \"utf8\" is unknown"));
  EXPECT_THAT(ply_error(ascii("property float x\n")), HasSubstr("line 3: a property before any"));
  EXPECT_THAT(ply_error(ascii("element vertex -1\n")), HasSubstr("line 3: \"-1\" is not a count"));
  EXPECT_THAT(ply_error(ascii("element vertex 1\nproperty quad x\n")),
              HasSubstr("line 4: type \"quad\" is unknown"));
  EXPECT_THAT(ply_error(ascii("element face 1\nproperty list float int v\n")),
              HasSubstr("\"float\" cannot count a list"));
  EXPECT_EQ(ply_error("ply\nend_header\n"),
            "PLY: header line 2: no \"format\" before \"end_header\"");
  EXPECT_EQ(ply_error(ascii("end_header\n")), "PLY: no element \"vertex\"");
}

TEST(Ply, SizesInTheHeaderAreCheckedBeforeAnythingIsAllocated) {
  for (const char* format : {"ascii", "binary_little_endian"}) {
    const std::string start = std::string("ply\nformat ") + format + " 1.0\n";
    const std::string vertices =
        "property float x\nproperty float y\nproperty float z\nend_header\n0 0 0\n";
    EXPECT_THAT(ply_error(start + "element vertex 18446744073709551615\n" + vertices),
                HasSubstr("too short"));
    EXPECT_THAT(ply_error(start + "element vertex 1000000000\n" + vertices),
                HasSubstr("too short"));
    EXPECT_THAT(ply_error(start + "element dust 1000000000000\nend_header\n"),
                HasSubstr("has no properties"));
  }
  const std::string list =
      "ply\nformat binary_little_endian 1.0\nelement x 1\nproperty list uint double "
      "y\nend_header\n";
  EXPECT_EQ(ply_error(list + "\xff\xff\xff\xff"),
            "PLY: x 0: the data end or do not contain a number");
}

TEST(Ply, EveryTruncationIsAnError) {
  const std::string whole = binary_quad(true);
  ASSERT_TRUE(parse_ply(whole).ok());
  for (std::size_t size = 0; size < whole.size(); ++size)
    EXPECT_FALSE(parse_ply(whole.substr(0, size)).ok()) << size;
}

TEST(Ply, StopsOnRequest) {
  std::stop_source source;
  source.request_stop();
  EXPECT_TRUE(absl::IsCancelled(parse_ply(binary_quad(false), source.get_token()).status()));
}

}  // namespace
}  // namespace lucerna
