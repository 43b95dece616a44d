#include <fmt/format.h>

#include "tests/oracle/world.h"

namespace lucerna::oracle {
namespace {

std::string number(Real x) { return fmt::format("{:.17g}", static_cast<double>(x)); }
std::string numbers(const Vec& v) { return number(v.x) + " " + number(v.y) + " " + number(v.z); }

/// A frame whose third axis is `w`.
std::array<Vec, 3> frame(const Vec& w) {
  const Vec u = across(w);
  return {u, cross(w, u), w};
}

std::string shape_text(const Shape& shape) {
  std::string text;
  if (shape.radiance > 0)
    text +=
        fmt::format("  AreaLightSource \"diffuse\" \"rgb L\" [{0} {0} {0}] \"bool twosided\" {1}\n",
                    number(shape.radiance), shape.two_sided);
  const auto& [a, b, c] = shape.at;
  switch (shape.kind) {
    case ShapeKind::kTriangle:
      return text +
             fmt::format(
                 "  Shape \"trianglemesh\" \"point3 P\" [{}  {}  {}] \"integer indices\" [0 1 2]\n",
                 numbers(a), numbers(b), numbers(c));
    case ShapeKind::kParallelogram: {
      const Vec d{static_cast<double>(b.x + (c.x - a.x)), static_cast<double>(b.y + (c.y - a.y)),
                  static_cast<double>(b.z + (c.z - a.z))};
      return text + fmt::format("  Shape \"bilinearmesh\" \"point3 P\" [{}  {}  {}  {}]\n",
                                numbers(a), numbers(b), numbers(c), numbers(d));
    }
    case ShapeKind::kDisk: {
      const auto [u, v, w] = frame(unit(b - a));
      return text + fmt::format(
                        "  Transform [{} 0 {} 0 {} 0 {} 1]\n  Shape \"disk\" \"float radius\" {}\n",
                        numbers(u), numbers(v), numbers(w), numbers(a), number(shape.radius));
    }
    case ShapeKind::kSphere:
      return text + fmt::format("  Translate {}\n  Shape \"sphere\" \"float radius\" {}\n",
                                numbers(a), number(shape.radius));
  }
  return text;
}

std::string light_text(const Light& light) {
  if (light.kind == LightKind::kPoint)
    return fmt::format("LightSource \"point\" \"rgb I\" [{0} {0} {0}] \"point3 from\" [{1}]\n",
                       number(light.level), numbers(light.at));
  return fmt::format(
      "LightSource \"distant\" \"rgb L\" [{0} {0} {0}] \"point3 from\" [{1}] \"point3 to\" [0 0 "
      "0]\n",
      number(light.level), numbers(light.at));
}

}  // namespace

std::string pbrt_text(const World& world) {
  std::string text = "WorldBegin\n";
  for (const Light& light : world.lights) text += light_text(light);
  for (const Shape& shape : world.shapes)
    text += "AttributeBegin\n" + shape_text(shape) + "AttributeEnd\n";
  return text;
}

}  // namespace lucerna::oracle
