// The bytes of picture files for tests.
#pragma once

#include <OpenImageIO/imageio.h>
#include <gtest/gtest.h>

#include <fstream>
#include <iterator>
#include <stdexcept>
#include <string>
#include <vector>

#include "server/files/image_reader.h"
#include "tests/server/pbrt/pbrt_fixture.h"

namespace lucerna::testing {

/// "what -> instead" for each remark, one per line.
inline std::string remarks_of(const DecodedImage& d) {
  std::string all;
  for (const ImageRemark& r : d.remarks) all += r.what + " -> " + r.instead + "\n";
  return all;
}

/// The bytes of these numbers, for files written by hand.
inline std::string chars(const std::vector<int>& numbers) {
  return {numbers.begin(), numbers.end()};
}

/// A .pfm file: three floats per texel, rows from the top.
inline std::string pfm(int width, int height, const std::vector<float>& rgb) {
  std::string bytes = "PF\n" + std::to_string(width) + " " + std::to_string(height) + "\n-1.0\n";
  const std::size_t row = static_cast<std::size_t>(width) * 3;
  for (int y = height; y-- > 0;)
    bytes.append(reinterpret_cast<const char*>(rgb.data() + static_cast<std::size_t>(y) * row),
                 row * sizeof(float));
  return bytes;
}

/// A .pfm file with equal texels.
inline std::string even_pfm(int width, int height, float value) {
  return pfm(width, height, std::vector<float>(std::size_t{3} * width * height, value));
}

/// The file that OpenImageIO writes for `name`: texels of the type in `spec`, from values of type
/// `as`.
template <typename T>
std::string written(const std::string& name, const OIIO::ImageSpec& spec,
                    const std::vector<T>& values,
                    OIIO::TypeDesc as = OIIO::BaseTypeFromC<T>::value) {
  const SceneFiles files;
  const std::string path = (files.path() / name).string();
  const auto file = OIIO::ImageOutput::create(path);
  if (!file || !file->open(path, spec) || !file->write_image(as, values.data()) || !file->close())
    throw std::runtime_error(file ? file->geterror() : OIIO::geterror());
  std::ifstream in(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), {}};
}

/// An OpenEXR file of one picture of floats for each of `specs`.
inline std::string exr_parts(const std::vector<OIIO::ImageSpec>& specs,
                             const std::vector<std::vector<float>>& values) {
  const SceneFiles files;
  const std::string path = (files.path() / "parts.exr").string();
  const auto file = OIIO::ImageOutput::create(path);
  bool ok = file && file->open(path, static_cast<int>(specs.size()), specs.data());
  for (std::size_t i = 0; ok && i < specs.size(); ++i)
    ok = (i == 0 || file->open(path, specs[i], OIIO::ImageOutput::AppendSubimage)) &&
         file->write_image(OIIO::TypeDesc::FLOAT, values[i].data());
  if (!ok || !file->close()) throw std::runtime_error(file ? file->geterror() : OIIO::geterror());
  std::ifstream in(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), {}};
}

inline DecodedImage decoded_picture(const std::string& bytes, Encoding encoding = kSrgb) {
  return value_of(decode_image({"a.hdr", bytes}, {.encoding = encoding}));
}

inline Rgbf first_texel(const std::string& bytes, Encoding encoding = kSrgb) {
  return decoded_picture(bytes, encoding).image->texel(0, 0);
}

inline void expect_near(const Rgbf& c, const Rgb& expected, double error) {
  EXPECT_NEAR(c.r, expected.r, error);
  EXPECT_NEAR(c.g, expected.g, error);
  EXPECT_NEAR(c.b, expected.b, error);
}

}  // namespace lucerna::testing
