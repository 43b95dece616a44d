// Scenes as .pbrt files.
#include <fmt/format.h>

#include <cstring>

#include "tests/oracle/world.h"

namespace lucerna::oracle {
namespace {

std::string number(Real x) { return fmt::format("{:.17g}", static_cast<double>(x)); }
std::string numbers(const Vec& v) { return number(v.x) + " " + number(v.y) + " " + number(v.z); }
std::string degrees(Real x) { return number(x * 180 / kPi); }
std::string rgb(const char* name, Real x) {
  return fmt::format(" \"rgb {0}\" [{1} {1} {1}]", name, number(x));
}

/// The directive that moves what follows; empty if it rests.
std::string motion_text(const Vec& moves) {
  if (!(length(moves) > 0)) return "";
  return fmt::format("  ActiveTransform EndTime\n  Translate {}\n  ActiveTransform All\n",
                     numbers(moves));
}

std::string frame_text(const std::array<Vec, 3>& axes, const Vec& at) {
  return fmt::format("  Transform [{} 0 {} 0 {} 0 {} 1]\n", numbers(axes[0]), numbers(axes[1]),
                     numbers(axes[2]), numbers(at));
}

/// A frame whose third axis is that of a disk or a cylinder.
std::string axis_text(const Shape& shape) {
  const Vec &w = shape.at[1], u = across(w);
  return fmt::format("  ConcatTransform [{} 0 {} 0 {} 0 {} 1]\n", numbers(u), numbers(cross(w, u)),
                     numbers(w), numbers(shape.at[0]));
}

std::string shape_text(const Shape& shape, const std::string& picture) {
  std::string text = motion_text(shape.moves);
  if (shape.radiance > 0) {
    text += "  AreaLightSource \"diffuse\"";
    text += shape.picture.empty()
                ? rgb("L", shape.radiance)
                : fmt::format(
                      " \"string filename\" \"{}\" \"string filter\" \"nearest\" \"float "
                      "scale\" {}",
                      picture, number(shape.radiance));
    text += fmt::format(" \"bool twosided\" {}\n", shape.two_sided);
  }
  const auto& [a, b, c, d] = shape.at;
  switch (shape.kind) {
    case ShapeKind::kTriangle:
      return text +
             fmt::format(
                 "  Shape \"trianglemesh\" \"point3 P\" [{}  {}  {}] \"integer indices\" [0 1 2]\n",
                 numbers(a), numbers(b), numbers(c));
    case ShapeKind::kParallelogram:
    case ShapeKind::kPatch: {
      const Vec implied{static_cast<double>(b.x + (c.x - a.x)),
                        static_cast<double>(b.y + (c.y - a.y)),
                        static_cast<double>(b.z + (c.z - a.z))};
      return text + fmt::format("  Shape \"bilinearmesh\" \"point3 P\" [{}  {}  {}  {}]\n",
                                numbers(a), numbers(b), numbers(c),
                                numbers(shape.kind == ShapeKind::kPatch ? d : implied));
    }
    case ShapeKind::kDisk:
      return text + axis_text(shape) +
             fmt::format("  Shape \"disk\" \"float radius\" {}\n", number(shape.radius));
    case ShapeKind::kCylinder:
      return text + axis_text(shape) +
             fmt::format(
                 "  Shape \"cylinder\" \"float radius\" {} \"float zmin\" {} \"float zmax\" {}\n",
                 number(shape.radius), number(-shape.half_height), number(shape.half_height));
    case ShapeKind::kSphere:
      return text + fmt::format("  Translate {}\n  Shape \"sphere\" \"float radius\" {}\n",
                                numbers(a), number(shape.radius));
  }
  return text;
}

std::string light_text(const Light& light, const std::string& file) {
  const std::string picture =
      light.picture.empty() ? "" : fmt::format(" \"string filename\" \"{}\"", file);
  std::string text = motion_text(light.moves);
  const auto posed = [&](const std::string& rest) {
    const auto& [u, v, w] = light.axes;
    return text +
           fmt::format("  ConcatTransform [{} 0 {} 0 {} 0 {} 1]\n  LightSource ", numbers(u),
                       numbers(v), numbers(w), numbers(light.at)) +
           rest + "\n";
  };
  switch (light.kind) {
    case LightKind::kPoint:
      return posed("\"point\"" + rgb("I", light.level));
    case LightKind::kSpot:
      return posed("\"spot\"" + rgb("I", light.level) +
                   fmt::format(" \"float coneangle\" {} \"float conedeltaangle\" {}",
                               degrees(light.angle), degrees(light.edge)));
    case LightKind::kPicture:
      return posed("\"goniometric\"" + picture + rgb("I", light.level));
    case LightKind::kWeb:
      return posed(fmt::format("\"goniometric\" \"string filename\" \"{}\"", file) +
                   rgb("I", light.level));
    case LightKind::kProjection:
      return posed("\"projection\"" + picture + rgb("I", light.level) +
                   fmt::format(" \"float fov\" {}", degrees(light.angle)));
    case LightKind::kBeam:
      return posed("\"projection\" \"string projection\" \"orthographic\"" + picture +
                   rgb("I", light.level) +
                   fmt::format(" \"float extent\" {}", number(2 * light.extent[0])));
    case LightKind::kDistant:
    case LightKind::kSun:
      text += "  LightSource \"distant\"" + rgb("L", light.level);
      text += fmt::format(" \"point3 from\" [{}] \"point3 to\" [0 0 0]", numbers(light.axes[2]));
      if (light.kind == LightKind::kSun)
        text += fmt::format(" \"float angulardiameter\" {}", degrees(light.angle));
      return text + "\n";
    case LightKind::kSky:
    case LightKind::kPortal: {
      if (light.kind == LightKind::kSky) text += frame_text(light.axes, {});
      text += "  LightSource \"infinite\"";
      text += light.picture.empty() ? rgb("L", light.level)
                                    : picture + " \"float scale\" " + number(light.level);
      if (light.kind == LightKind::kPortal) {
        const Vec u = light.axes[0] * light.extent[0], v = light.axes[1] * light.extent[1];
        text +=
            fmt::format(" \"point3 portal\" [{}  {}  {}  {}]", numbers(light.at),
                        numbers(light.at + u), numbers(light.at + u + v), numbers(light.at + v));
      }
      return text + "\n";
    }
  }
  return text;
}

/// A grey picture in the format PFM: rows from the bottom, little-endian.
std::string pfm(const Texels& picture) {
  std::string bytes = fmt::format("Pf\n{} {}\n-1\n", picture.width, picture.height);
  for (int y = picture.height - 1; y >= 0; --y) {
    for (int x = 0; x < picture.width; ++x) {
      const auto value = static_cast<float>(picture.at(x, y));
      std::array<char, sizeof value> raw{};
      std::memcpy(raw.data(), &value, sizeof value);
      bytes.append(raw.data(), raw.size());
    }
  }
  return bytes;
}

/// An absolute web of type C [LM63].
std::string ies(const Light& light) {
  std::string text = fmt::format("IESNA:LM-63-2002\nTILT=NONE\n1 -1 1 {} {} 1 2 0 0 0\n1 1 0\n",
                                 light.gammas.size(), light.planes);
  for (const Real x : light.gammas) text += number(x) + " ";
  text += "\n";
  for (int i = 0; i < light.planes; ++i)
    text += fmt::format("{} ", light.planes == 1 ? 0 : light.sweep * i / (light.planes - 1));
  for (std::size_t i = 0; i < light.candela.size(); ++i) {
    text += i % light.gammas.size() == 0 ? '\n' : ' ';
    text += number(light.candela[i]);
  }
  return text + "\n";
}

std::string file_of(std::size_t number, bool web) {
  return fmt::format("{}.{}", number, web ? "ies" : "pfm");
}

}  // namespace

std::string pbrt_text(const World& world) {
  std::string text = "WorldBegin\n";
  for (std::size_t i = 0; i < world.lights.size(); ++i) {
    const Light& light = world.lights[i];
    text += "AttributeBegin\n" + light_text(light, file_of(i, light.kind == LightKind::kWeb)) +
            "AttributeEnd\n";
  }
  for (std::size_t i = 0; i < world.shapes.size(); ++i)
    text += "AttributeBegin\n" +
            shape_text(world.shapes[i], file_of(world.lights.size() + i, false)) + "AttributeEnd\n";
  return text;
}

std::vector<std::pair<std::string, std::string>> pbrt_files(const World& world) {
  std::vector<std::pair<std::string, std::string>> files;
  for (std::size_t i = 0; i < world.lights.size(); ++i) {
    const Light& light = world.lights[i];
    if (light.kind == LightKind::kWeb) files.emplace_back(file_of(i, true), ies(light));
    if (!light.picture.empty()) files.emplace_back(file_of(i, false), pfm(light.picture));
  }
  for (std::size_t i = 0; i < world.shapes.size(); ++i) {
    const Texels& picture = world.shapes[i].picture;
    if (!picture.empty()) files.emplace_back(file_of(world.lights.size() + i, false), pfm(picture));
  }
  return files;
}

}  // namespace lucerna::oracle
