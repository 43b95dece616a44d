#include "client/lab/conformance_pictures.h"

#include <fmt/format.h>

#include <cstring>
#include <functional>

namespace lucerna::conformance {
namespace {

using Texel = std::array<float, 3>;

/// A picture of 32-bit floats, rows from the top.  The file has them from the bottom.
CaseFile pfm(const std::string& name, int width, int height,
             const std::function<Texel(int x, int y)>& texel) {
  std::string content = fmt::format("PF\n{} {}\n-1.0\n", width, height);
  for (int y = height - 1; y >= 0; --y) {
    for (int x = 0; x < width; ++x) {
      const Texel value = texel(x, y);
      char bytes[sizeof(Texel)];
      std::memcpy(bytes, value.data(), sizeof bytes);
      content.append(bytes, sizeof bytes);
    }
  }
  return {name, content};
}

/// Small steps, which are exact in floats.
Texel sky_texel(int x, int y) {
  if (x == 5 && y == 3) return {40, 30, 20};
  const auto step = [](int i) { return static_cast<float>(i % 8) / 8; };
  return {0.25F + step(x + y), 0.5F + step(3 * x), 0.75F + step(5 * y)};
}

Texel grey_texel(int x, int y) {
  const Texel colour = sky_texel(x, y);
  return {colour[1], colour[1], colour[1]};
}

}  // namespace

CaseFile sky() { return pfm("sky.pfm", 16, 16, sky_texel); }

CaseFile wide_sky() { return pfm("sky.pfm", 32, 16, sky_texel); }

CaseFile grey_sky() { return pfm("sky.pfm", 16, 16, grey_texel); }

CaseFile wide_grey_sky() { return pfm("sky.pfm", 32, 16, grey_texel); }

CaseFile bright_sky() {
  return pfm("sky.pfm", 16, 16, [](int x, int y) {
    return x == 9 && y == 9 ? Texel{1e6F, 1e6F, 1e6F} : Texel{1, 1, 1};
  });
}

CaseFile picture() {
  return pfm("picture.pfm", 6, 4, [](int x, int y) {
    if ((x + y) % 4 == 3) return Texel{0, 0, 0};
    return Texel{static_cast<float>(x + 1), static_cast<float>(y + 1),
                 static_cast<float>(x * y + 1)};
  });
}

CaseFile ies() {
  return {"lamp.ies",
          "IESNA:LM-63-2002\n[TEST] 1\n[TESTLAB] none\n[MANUFAC] none\n[LUMCAT] conformance\n"
          "TILT=NONE\n1 -1 1 5 5 1 2 0 0 0\n1 1 50\n0 20 45 70 90\n0 90 180 270 360\n"
          "300 280 200 60 0\n300 250 120 20 0\n300 290 180 50 0\n300 260 150 30 0\n"
          "300 280 200 60 0\n"};
}

CaseFile narrow_ies() {
  return {"lamp.ies",
          "IESNA:LM-63-2002\n[TEST] 1\n[TESTLAB] none\n[MANUFAC] none\n[LUMCAT] conformance\n"
          "TILT=NONE\n1 -1 1 4 1 1 2 0 0 0\n1 1 50\n0 0.5 1 90\n0\n1000000 1000000 0 0\n"};
}

}  // namespace lucerna::conformance
