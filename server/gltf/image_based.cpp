#include "server/gltf/image_based.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "lights/maths/level_validation.h"
#include "lights/pictures/sphere_map.h"
#include "server/files/image_reader.h"
#include "server/gltf/matrix.h"

namespace lucerna::gltf {
namespace {

constexpr const char* kName = "EXT_lights_image_based";
/// The picture then has kMaxImageTexels.
constexpr int kMostFaceTexels = 4096;

/// The six faces in the order of the extension: +x, -x, +y, -y, +z, -z.
struct Cube {
  int size = 0;  ///< texels along an edge
  std::array<std::vector<Rgbf>, 6> faces;

  /// The texel that a direction meets.  Seen from the inside, the faces are upright and not
  /// mirrored: the extension flips the faces of the usual cube maps.
  const Rgbf& texel(const Vec3& w) const {
    const double x = std::abs(w.x), y = std::abs(w.y), z = std::abs(w.z);
    const double largest = std::max({x, y, z});
    std::size_t face = 0;
    double right = 0, down = 0;
    if (x == largest) {
      face = w.x > 0 ? 0 : 1;
      right = w.x > 0 ? w.z : -w.z;
      down = -w.y;
    } else if (y == largest) {
      face = w.y > 0 ? 2 : 3;
      right = -w.x;
      down = w.y > 0 ? w.z : -w.z;
    } else {
      face = w.z > 0 ? 4 : 5;
      right = w.z > 0 ? -w.x : w.x;
      down = -w.y;
    }
    const auto place = [&](double coordinate) {
      const double from_0_to_1 = (coordinate / largest + 1) / 2;
      return std::clamp(static_cast<int>(from_0_to_1 * size), 0, size - 1);
    };
    return faces[face][static_cast<std::size_t>(place(down)) * static_cast<std::size_t>(size) +
                       static_cast<std::size_t>(place(right))];
  }
};

/// The images of the faces of the first level.
View faces_of(const View& light) {
  const View levels = light.at("specularImages");
  levels.require_array(1);
  const View faces = levels[0];
  faces.require_array(6, 6);
  return faces;
}

/// The texels of a face; empty if it cannot be decoded.
std::vector<Rgbf> face_texels(const Document& document, const View& face, int size) {
  const std::size_t index = face.index(document.count("images"), "image");
  const std::shared_ptr<const Image> image = document.image(index);
  if (image == nullptr) return {};
  if (image->width() != size || image->height() != size)
    face.fail(
        fmt::format("a picture of {} x {} texels, allowed: {} x {}, as specularImageSize says",
                    image->width(), image->height(), size, size));
  document.context().claim(face.pointer(), image->bytes(), 1);
  const auto alpha = decode_alpha(*document.read(document.root().at("images")[index]),
                                  document.context().image_options(kLinear));
  if (!alpha.ok()) face.fail(alpha.status());
  std::vector<Rgbf> texels(image->texels().begin(), image->texels().end());
  for (std::size_t i = 0; i < alpha->values.size() && i < texels.size(); ++i) {
    // A divisor of 0 has no meaning.  Encoders write it only for black.
    if (alpha->values[i] > 0) texels[i] = texels[i] / alpha->values[i];
  }
  return texels;
}

std::shared_ptr<const Image> panorama(const Document& document, const Cube& cube,
                                      const View& light) {
  // Small faces keep their edges: the picture is smooth between its texels.
  constexpr int kLeast = 16;
  const int height = 2 * std::max(cube.size, kLeast), width = 2 * height;
  const auto count = static_cast<std::size_t>(width) * static_cast<std::size_t>(height);
  document.context().claim(light.pointer(), count, sizeof(Rgbf));
  std::vector<Rgbf> texels;
  texels.reserve(count);
  constexpr int kParts = 4;  // places along each side of a texel
  for (int y = 0; y < height; ++y) {
    document.context().poll();
    for (int x = 0; x < width; ++x) {
      Rgb sum;
      for (int i = 0; i < kParts * kParts; ++i) {
        const double u = (x + (i % kParts + 0.5) / kParts) / width;
        const double v = (y + (i / kParts + 0.5) / kParts) / height;
        sum += Rgb(cube.texel(direction_from_square(SphereMapping::kLatitudeLongitude, {u, v})));
      }
      texels.emplace_back(sum / double{kParts * kParts});
    }
  }
  auto image = Image::create(width, height, std::move(texels));
  if (!image.ok()) light.fail(image.status());
  return *std::move(image);
}

}  // namespace

void read_environment_pictures(const Document& document) {
  const auto extension = document.root().extension(kName);
  if (!extension) return;
  const View lights = extension->at("lights");
  for (std::size_t i = 0; i < lights.require_array().size(); ++i) {
    const View faces = faces_of(lights[i]);
    for (std::size_t f = 0; f < 6; ++f)
      document.image(faces[f].index(document.count("images"), "image"));
  }
}

void add_environment(const Document& document, const Tree& tree) {
  const auto scene = tree.scene();
  const auto use = scene ? scene->extension(kName) : std::nullopt;
  if (!use) return;
  const View light = document.light_of(kName, *use);
  const View faces = faces_of(light);
  Cube cube;
  cube.size = static_cast<int>(light.at("specularImageSize").integer(1, kMostFaceTexels));
  for (std::size_t f = 0; f < 6; ++f) {
    cube.faces[f] = face_texels(document, faces[f], cube.size);
    if (cube.faces[f].empty()) return;  // a remark says that the light is left out
  }

  auto map = SphereMap::create(panorama(document, cube, light), SphereMapping::kLatitudeLongitude,
                               ImageFilter::kBilinear);
  if (!map.ok()) light.fail(map.status());
  ImageInfiniteLightParams params;
  params.map = *std::move(map);
  params.image_name = light.text("name", document.context().location(light.pointer()).file);
  // check_structure() has checked its length.
  const std::vector<double> rotation = light.numbers("rotation", {0, 0, 0, 1}, {-1e9, 1e9});
  params.world_from_map = *Transform::from_matrix(
      from_parts({0, 0, 0}, {rotation[0], rotation[1], rotation[2], rotation[3]}, {1, 1, 1}));
  params.radiance_cd_m2 = Rgb(light.number("intensity", 1, kNotNegative) *
                              document.context().scene.level_factors.emission);
  if (const auto status = check_light_value("infinite.radiance of the brightest texel",
                                            params.map->brightest() * params.radiance_cd_m2,
                                            "cd/m2", kMostInAnswers);
      !status.ok())
    light.fail(status);
  LightDescription result;
  result.params = std::move(params);
  result.where = document.context().location(light.pointer());
  result.name = document.context().light_name(light.pointer(), {light.text("name", "")});
  document.context().scene.lights.push_back(std::move(result));
}

}  // namespace lucerna::gltf
