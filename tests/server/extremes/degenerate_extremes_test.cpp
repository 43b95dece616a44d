// Row 34: triangles and patches that are degenerate or nearly so.
#include <gtest/gtest.h>

#include <array>
#include <bit>
#include <cmath>
#include <limits>
#include <set>
#include <string>
#include <vector>

#include "lights/models/area_light.h"
#include "lights/shapes/all_shapes.h"
#include "tests/extremes_sweep.h"
#include "tests/reference_table.h"
#include "tests/server/extremes/file_scenes.h"

namespace lucerna::testing {
namespace {

Vec3 point(const ReferenceTable::Row& row, const std::string& name) {
  return {row[name + "x"], row[name + "y"], row[name + "z"]};
}

AreaLight needle(const ReferenceTable::Row& row) {
  const Triangle t{point(row, "a"), point(row, "b"), point(row, "c")};
  DiffuseEmission emission;
  emission.radiance_cd_m2 = Rgb(1);
  emission.two_sided = true;
  return value_of(AreaLight::create(emission, *TriangleMesh::create({t})));
}

/// Heron's formula, in float.
float textbook_area(const ReferenceTable::Row& row) {
  const Vec3f p(point(row, "a")), q(point(row, "b")), r(point(row, "c"));
  const float a = length(q - p), b = length(r - q), c = length(p - r), s = (a + b + c) / 2;
  return std::sqrt(s * (s - a) * (s - b) * (s - c));
}

TEST(DegenerateExtremes, AreaOfNeedles) {
  Sweep sweep(34, "needles, length : width", "1e3 ... 1e14", "flux");
  const ReferenceTable table("needles");
  for (const auto& row : table.rows()) {
    const auto light = needle(row);
    sweep.compare(luminance(light.power({}).lumens), 2 * kPi * row["area_m2"], row.text("ratio"));
    sweep.compare_textbook(textbook_area(row), row["area_m2"]);
  }
  sweep.expect_within(1e-12);
}

TEST(DegenerateExtremes, DensityOfNeedles) {
  Sweep sweep(34, "needles, length : width, 1 to 2 m away", "1e3 ... 1e14",
              "density by solid angle, at the samples");
  const ReferenceTable table("needles");
  for (const auto& row : table.rows()) {
    const auto light = needle(row);
    Receiver receiver(Vec3(point(row, "e")));
    receiver.area_sampling = AreaSampling::kSolidAngle;
    for (const double u : {0.0, 0.1, 0.5, 0.9, 1 - 0x1p-53})
      for (const double v : {0.0, 0.3, 1 - 0x1p-53}) {
        const auto s = light.sample_li(receiver, {u, v});
        ASSERT_EQ(s.reason, NoLight::kNone) << row.text("ratio") << " " << u << " " << v;
        sweep.compare(s.pdf.per_sr, 1 / row["solid_angle_sr"], row.text("ratio"));
      }
    const Vec3f p(point(row, "a")), q(point(row, "b")), r(point(row, "c")), eye(point(row, "e"));
    // Heron's area over the squared distance, with the cosine.
    const Vec3f n = normalized(cross(q - p, r - p)), to = (p + q + r) / 3.0F - eye;
    const float d2 = dot(to, to);
    sweep.compare_textbook(d2 / (textbook_area(row) * std::fabs(dot(n, normalized(to)))),
                           1 / row["solid_angle_sr"]);
  }
  sweep.expect_within(1e-7);
}

/// A mesh with few valid primitives: triangles or patches in the plane z = 0, lit from above.
struct Mesh {
  std::string shape;
  std::set<std::uint32_t> good;
  double area;  // of the valid primitives [m2]
};

const std::vector<Mesh>& degenerate_meshes() {
  static const std::vector<Mesh> meshes{
      // The same vertex two or three times; vertices on one line; two vertices at one place; all
      // vertices at one point.
      {"\"trianglemesh\" \"point3 P\" [0 0 0 1 0 0 0 1 0] \"integer indices\" [0 0 1 2 2 2 0 1 2]",
       {2},
       0.5},
      {"\"trianglemesh\" \"point3 P\" [0 0 0 1 0 0 0 1 0 2 0 0 3 0 0] \"integer indices\" [0 1 3 1 "
       "3 4 "
       "0 1 2]",
       {2},
       0.5},
      {"\"trianglemesh\" \"point3 P\" [0 0 0 1 0 0 0 1 0 1 0 0] \"integer indices\" [0 1 3 0 1 2]",
       {1},
       0.5},
      {"\"trianglemesh\" \"point3 P\" [5 5 5 5 5 5 5 5 5 0 0 0 1 0 0 0 1 0] \"integer indices\" [0 "
       "1 2 "
       "3 4 5]",
       {1},
       0.5},
      {"\"bilinearmesh\" \"point3 P\" [0 0 0 1 0 0 2 0 0 3 0 0 0 1 0 1 1 0] \"integer indices\" [0 "
       "1 2 "
       "3 0 0 0 0 0 1 4 5]",
       {2},
       1},
      // The valid primitive is first, last, or between two of the same area.
      {"\"trianglemesh\" \"point3 P\" [0 0 0 1 0 0 0 1 0 1 1 0] \"integer indices\" [0 0 1 0 1 2 2 "
       "2 "
       "1 1 3 2 3 3 3]",
       {1, 3},
       1},
      {"\"bilinearmesh\" \"point3 P\" [0 0 0 1 0 0 0 1 0 1 1 0 2 0 0 2 1 0] \"integer indices\" [0 "
       "0 "
       "0 0 0 1 2 3 1 1 3 3 1 4 3 5 4 4 4 4]",
       {1, 3},
       2},
  };
  return meshes;
}

TEST(DegenerateExtremes, PrimitivesWithoutArea) {
  Sweep sweep(34, "meshes of zero-area triangles and patches, and one that has an area",
              "duplicate indices, duplicate vertices, vertices on a line or at one point",
              "how often they are sampled, and their count");
  for (const Mesh& mesh : degenerate_meshes()) {
    const FileScene loaded = scene_of("AreaLightSource \"diffuse\" Shape " + mesh.shape);
    ASSERT_TRUE(loaded.status.ok()) << loaded.status;
    EXPECT_GT(loaded.scene->report().contents.shapes.at(0).without_area, 0U) << mesh.shape;
    EXPECT_EQ(loaded.remarks, "") << mesh.shape;
    EXPECT_NEAR(flux_lm(*loaded.scene), kPi * mesh.area, 1e-6);
    const Light& light = *loaded.scene->lights()[0].light;
    for (const double u : {0.0, 1e-30, 0.1, 0.25, 1.0 / 3, 0.5, 0.75, 0.999, 1 - 0x1p-53, 1.0})
      // At v = 0, u alone chooses.  Areas begin and end at 0, 1/2 and 1.
      for (const double v : {0.0, 0.5, 1.0}) {
        const Vec3 above(0.2, 0.3, 2), below(0.2, 0.3, -2);
        for (const auto& receiver : {above, below}) {
          const auto s = light.sample_li(receiver, {u, v});
          const NoLight seen = receiver.z > 0 ? NoLight::kNone : NoLight::kBehind;
          const bool sound = mesh.good.contains(s.primitive) && s.reason == seen &&
                             std::isfinite(s.pdf.per_sr) && s.pdf.per_sr > 0 && is_finite(s.value);
          sweep.answer(sound ? "never sampled, and counted" : "sampled: " + mesh.shape);
        }
      }
    // 1 / area of the first primitive.
    sweep.textbook_answer(std::isinf(1 / (0 * static_cast<float>(mesh.area))) ? "infinite density"
                                                                              : "finite");
  }
  sweep.expect_answers("never sampled, and counted");
}

/// Triangle (0 0 0), (1 0 0), (0 1 `last`) as a PLY file of `type`.  The bytes of its last
/// coordinate are inserted unchanged.
template <typename T>
std::string ply(const char* type, T last) {
  const T values[] = {0, 0, 0, 1, 0, 0, 0, 1, last};
  std::string bytes = std::string("ply\nformat binary_little_endian 1.0\nelement vertex 3\n") +
                      "property " + type + " x\nproperty " + type + " y\nproperty " + type +
                      " z\nelement face 1\nproperty list uchar int vertex_indices\nend_header\n";
  bytes.append(reinterpret_cast<const char*>(values), sizeof values);
  bytes += '\3';
  const std::int32_t indices[] = {0, 1, 2};
  bytes.append(reinterpret_cast<const char*>(indices), sizeof indices);
  return bytes;
}

TEST(DegenerateExtremes, InvalidVertices) {
  Sweep sweep(34, "vertices with a coordinate of", "NaN, infinity, 1e31 ... 1e300", "answer");
  const std::string same = "error with file, line and column";
  for (const bool emits : {false, true}) {
    const std::string light = emits ? "AreaLightSource \"diffuse\" \"float power\" 1\n" : "\n";
    for (const char* word : {"nan", "-nan", "inf", "-inf", "1e999", "1e300", "-1e31"}) {
      const std::string text =
          light + "Shape \"trianglemesh\" \"point3 P\" [0 0 0 1 0 0 0 1 " + word + "]";
      // The error points at the number where it is not valid, otherwise at the shape, which the
      // number makes too large.
      const FileScene loaded = scene_of(text);
      const bool number =
          std::string(word).find("1e") == std::string::npos || std::string(word) == "1e999";
      const std::string said = refusal(text, number ? std::string(word) + "]" : "Shape", loaded);
      EXPECT_EQ(said, same) << text;
      sweep.answer(said);
    }
    const std::string text = light + "Shape \"plymesh\" \"string filename\" \"a.ply\"";
    const auto refused = [&](const std::string& bytes) {
      const FileScene loaded = scene_of(text, {{"a.ply", bytes}});
      const std::string of_file = refusal(text, "\"string filename\"", loaded);
      const std::string said = of_file == same ? same : refusal(text, "Shape", loaded);
      EXPECT_EQ(said, same);
      sweep.answer(said);
    };
    refused(ply("float", std::numeric_limits<float>::quiet_NaN()));
    refused(ply("float", -std::numeric_limits<float>::infinity()));
    refused(ply("float", 1e30F));
    refused(ply("double", std::numeric_limits<double>::quiet_NaN()));
    refused(ply("double", std::numeric_limits<double>::infinity()));
    refused(ply("double", 1e300));
  }
  const float nan = std::numeric_limits<float>::quiet_NaN();
  const Vec3f n = cross(Vec3f(1, 0, 0), Vec3f(0, 1, nan));
  sweep.textbook_answer(std::isnan(1 / length(n)) ? "not a number" : "");
  sweep.expect_answers(same);
}

}  // namespace
}  // namespace lucerna::testing
