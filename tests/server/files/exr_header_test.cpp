// Headers of OpenEXR files that state more than the file holds.  OpenImageIO writes a valid file,
// and the test changes its header.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdint>
#include <cstring>
#include <initializer_list>
#include <stdexcept>
#include <string>
#include <vector>

#include "server/files/image_reader.h"
#include "tests/server/files/picture_texts.h"

namespace lucerna {
namespace {

using ::testing::HasSubstr;
using testing::message;
using testing::written;

/// 32-bit integers as OpenEXR stores them.
std::string ints(std::initializer_list<std::int32_t> values) {
  std::string bytes;
  for (const std::int32_t value : values) bytes.append(reinterpret_cast<const char*>(&value), 4);
  return bytes;
}

/// An attribute that states `size` bytes, and `value`.
std::string attribute(const std::string& name, const std::string& type, std::int32_t size,
                      const std::string& value = "") {
  return name + '\0' + type + '\0' + ints({size}) + value;
}

/// A file of 2 x 1 texels with these attributes before its own.  It is valid if they are.
std::string exr_with(const std::string& attributes) {
  constexpr std::size_t kMagicAndVersion = 8;
  const OIIO::ImageSpec spec(2, 1, 3, OIIO::TypeDesc::FLOAT);
  std::string bytes = written("a.exr", spec, std::vector<float>{1, 2, 3, 4, 5, 6});
  // The place of the rows stands right before the rows.
  for (std::uint64_t rows = bytes.size(); rows > sizeof rows; --rows) {
    char* const at = bytes.data() + rows - sizeof rows;
    if (std::memcmp(at, &rows, sizeof rows) != 0) continue;
    const std::uint64_t moved = rows + attributes.size();
    std::memcpy(at, &moved, sizeof moved);
    return bytes.insert(kMagicAndVersion, attributes);
  }
  throw std::runtime_error("no place of the rows");
}

const std::string kWindow = attribute("dataWindow", "box2i", 16);

/// Changes the data window at `at`.
void set_size(std::string& bytes, std::size_t at, int width, int height) {
  bytes.replace(at + kWindow.size(), 16, ints({0, 0, width - 1, height - 1}));
}

/// A valid file whose header states this size.
std::string exr_of_size(int width, int height) {
  std::string bytes = exr_with("");
  set_size(bytes, bytes.find(kWindow), width, height);
  return bytes;
}

absl::Status decoded(const std::string& bytes) { return decode_image({"a.exr", bytes}).status(); }

TEST(ExrHeader, AnAttributeWithinTheFileIsAccepted) {
  EXPECT_TRUE(decoded(exr_with(attribute("a", "unknown", 3, "abc"))).ok())
      << decoded(exr_with(attribute("a", "unknown", 3, "abc")));
}

TEST(ExrHeader, AnAttributeLargerThanTheFileIsRefusedWithItsNameAndSize) {
  for (const std::string type : {"unknown", "string", "stringvector", "floatvector"}) {
    const absl::Status status = decoded(exr_with(attribute("a", type, 1900000000)));
    EXPECT_EQ(status.code(), absl::StatusCode::kInvalidArgument) << type;
    EXPECT_EQ(message(status),
              fmt::format("a.exr: cannot be read as an image: Attribute 'a', type '{}': Invalid "
                          "size 1900000000, allowed: a complete OpenEXR file",
                          type));
  }
}

TEST(ExrHeader, AnAttributeBehindAnotherOfAWrongSizeIsNotRead) {
  // A float of 17 bytes: a reader that takes 4 bytes for it finds an attribute in the others.
  const std::string hidden = attribute("b", "string", 1900000000);
  const auto size = static_cast<std::int32_t>(4 + hidden.size());
  EXPECT_EQ(message(decoded(exr_with(attribute("a", "float", size, ints({0}) + hidden)))),
            fmt::format("a.exr: cannot be read as an image: Attribute 'a': Invalid size {} (exp "
                        "'float' size 4 * 1 (4)), allowed: a complete OpenEXR file",
                        size));
}

TEST(ExrHeader, AnAttributeWithoutATypeIsRefused) {
  // Behind the attributes that a file needs.  OpenEXR's C library reports it there, and goes on.
  std::string bytes = exr_with("");
  const std::string last = attribute("screenWindowWidth", "float", 4);
  bytes.insert(bytes.find(last) + last.size() + 4, attribute("a", "", 1900000000));
  EXPECT_THAT(message(decoded(bytes)),
              HasSubstr("empty string encountered parsing attribute type for attribute 'a'"));
}

TEST(ExrHeader, ChannelsThatDoNotEndWithTheirAttributeAreRefused) {
  // OpenEXR's C library takes the end of the list for the end of the header.
  std::string bytes = exr_with("");
  const std::string channels = attribute("channels", "chlist", 55);
  const std::size_t at = bytes.find(channels);
  ASSERT_NE(at, std::string::npos);
  bytes.replace(at, channels.size(), attribute("channels", "chlist", 54));
  bytes.insert(at + channels.size() + 55, attribute("a", "unknown", 1900000000));
  EXPECT_THAT(message(decoded(bytes)),
              HasSubstr("the list of channels does not end with its attribute"));
}

TEST(ExrHeader, ASizeBelowZeroIsRefused) {
  EXPECT_THAT(message(decoded(exr_with(attribute("a", "unknown", -5)))),
              HasSubstr("Attribute 'a', type 'unknown': Invalid negative size -5"));
}

TEST(ExrHeader, AHeaderThatEndsEarlyIsRefused) {
  const std::string bytes = exr_with("");
  // The first four bytes are the mark of the format.
  for (std::size_t length = 4; length < 100; ++length)
    EXPECT_THAT(message(decoded(bytes.substr(0, length))),
                HasSubstr("allowed: a complete OpenEXR file"))
        << length;
}

TEST(ExrHeader, TheNumberOfTexelsIsCheckedBeforeBuffersAreAllocated) {
  // OpenEXR's own limit on the bytes of a row would be the error otherwise.
  const absl::Status status = decoded(exr_of_size(1 << 29, 2));
  EXPECT_EQ(status.code(), absl::StatusCode::kResourceExhausted);
  EXPECT_EQ(message(status), "a.exr: 536870912 x 2 texels, allowed: 134217728 in all");
  EXPECT_THAT(message(decoded(exr_of_size(0x7fffffff, 0x7fffffff))),
              HasSubstr("Invalid data window (0, 0 - 2147483646, 2147483646)"));
}

TEST(ExrHeader, ManyAttributesAreRefusedBeforeTheyAreRead) {
  // The libraries compare each attribute with all before it.
  const auto with = [](int count) {
    std::string attributes;
    for (int i = 0; i < count; ++i)
      attributes += attribute(fmt::format("a{}", i), "int", 4, ints({i}));
    return decoded(exr_with(attributes));
  };
  EXPECT_TRUE(with(2000).ok()) << with(2000);
  EXPECT_THAT(message(with(3000)), HasSubstr("attributes, allowed: at most 2048"));
}

TEST(ExrHeader, ManyChannelsAreRefusedBeforeTheyAreRead) {
  // OpenEXR's C library inserts each channel into a sorted list.
  const auto with = [](int count) {
    std::string channels;
    for (int i = 0; i < count; ++i)
      channels += fmt::format("c{:05}", i) + '\0' + ints({2, 0, 1, 1});
    const auto size = static_cast<std::int32_t>(channels.size() + 1);
    return decoded(exr_with(attribute("b", "chlist", size, channels + '\0')));
  };
  EXPECT_TRUE(with(1000).ok()) << with(1000);
  EXPECT_EQ(message(with(5000)), "a.exr: 5003 channels, allowed: at most 1024");
}

TEST(ExrHeader, ChannelsOfAllPicturesCount) {
  const std::vector specs(400, OIIO::ImageSpec(1, 1, 3, OIIO::TypeDesc::FLOAT));
  const std::vector values(400, std::vector<float>{1, 2, 3});
  EXPECT_EQ(message(decoded(testing::exr_parts(specs, values))),
            "a.exr: 1200 channels, allowed: at most 1024");
}

TEST(ExrHeader, EveryPictureOfTheFileIsChecked) {
  const OIIO::ImageSpec spec(1, 1, 3, OIIO::TypeDesc::FLOAT);
  std::string bytes = testing::exr_parts({spec, spec}, {{1, 2, 3}, {1, 2, 3}});
  EXPECT_TRUE(decoded(bytes).ok()) << decoded(bytes);
  set_size(bytes, bytes.rfind(kWindow), 1 << 29, 1);
  EXPECT_EQ(message(decoded(bytes)), "a.exr: 536870912 x 1 texels, allowed: 134217728 in all");
}

}  // namespace
}  // namespace lucerna
