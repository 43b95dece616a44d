// Row 30: closed meshes.  Only faces turned to the receiver count.
#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "lights/shapes/all_shapes.h"
#include "tests/lights/extremes/area_extremes.h"

namespace lucerna::testing {
namespace {

/// The faces of the box |x|, |y|, |z| <= 1/2, normals outwards.
std::vector<BilinearPatch> box_faces() {
  std::vector<BilinearPatch> faces;
  for (int axis = 0; axis < 3; ++axis)
    for (const double side : {-0.5, 0.5}) {
      const auto corner = [&](double u, double v) {
        double p[3];
        p[axis] = side;
        p[(axis + 1) % 3] = u * (side < 0 ? -1 : 1), p[(axis + 2) % 3] = v;
        return Vec3(p[0], p[1], p[2]);
      };
      const double h = 0.5;
      faces.push_back({corner(-h, -h), corner(h, -h), corner(-h, h), corner(h, h)});
    }
  return faces;
}

std::vector<Triangle> box_triangles() {
  std::vector<Triangle> triangles;
  for (const auto& f : box_faces()) {
    triangles.push_back({f.p00, f.p10, f.p11});
    triangles.push_back({f.p00, f.p11, f.p01});
  }
  return triangles;
}

/// Samples each of `count` primitives of equal area in turn.  Bits that a float lacks in u.x come
/// from u.y, so the sample may be off its place by 2^-24.
template <typename Light>
Seen seen_of_each(const Light& light, const Receiver& receiver, int count, By by_y) {
  Seen all;
  for (int i = 0; i < count; ++i) {
    // The sample values are off their places, so no two sums are equal.
    constexpr double kEnough = 1e-6;
    const Seen seen = seen_in_halves(light, receiver, by_y, {double(i) / count, 0},
                                     {double(i + 1) / count, 1}, kEnough, 10);
    all.solid_angle_sr += seen.solid_angle_sr;
    all.irradiance_lx += seen.irradiance_lx;
    all.disagreement = std::fmax(all.disagreement, seen.disagreement);
    all.without += seen.without;
  }
  return all;
}

template <typename Light>
void sweep_box(const Light& light, int count, By by_y, Sweep& sweep) {
  const ReferenceTable table("closed_box");
  for (const auto& row : table.rows()) {
    const Seen seen = seen_of_each(light, receiver_in(row, AreaSampling::kSolidAngle), count, by_y);
    const std::string at = row.text("receiver_x") + " " + row.text("receiver_z");
    EXPECT_EQ(seen.disagreement, 0) << at;
    EXPECT_GT(seen.without, 0) << at;
    sweep.compare(seen.solid_angle_sr, row["solid_angle_sr"], at);
    sweep.compare(seen.irradiance_lx, row["irradiance_lx"], at);
  }
}

TEST(ClosedMeshExtremes, IrradianceFromABoxOfTriangles) {
  Sweep sweep(30, "closed emissive box of 12 triangles", "1e-9 ... 1e9 of its size away",
              "solid angle and irradiance");
  sweep_box(*AreaLight::create({Rgb(1)}, *TriangleMesh::create(box_triangles())), 12, By::kRoot,
            sweep);
  sweep.expect_within(1e-5);
}

TEST(ClosedMeshExtremes, IrradianceFromABoxOfPatches) {
  Sweep sweep(30, "closed emissive box of 6 bilinear patches", "1e-9 ... 1e9 of its size away",
              "solid angle and irradiance");
  sweep_box(*AreaLight::create({Rgb(1)}, *PatchMesh::create(box_faces())), 6, By::kShare, sweep);
  sweep.expect_within(1e-5);
}

TEST(ClosedMeshExtremes, DensityOfDirectionsIgnoresFacesTurnedAway) {
  Sweep sweep(30, "closed emissive box of 12 triangles", "1e-9 ... 1e9 of its size away",
              "density of a sample's direction");
  const auto light = *AreaLight::create({Rgb(1)}, *TriangleMesh::create(box_triangles()));
  const auto mesh = *TriangleMesh::create(box_triangles());
  const ReferenceTable table("closed_box");
  for (const auto& row : table.rows()) {
    const auto receiver = receiver_in(row, AreaSampling::kLowDistortion);
    for (const double x : {0.03, 0.28, 0.53, 0.78, 0.86, 0.93, 0.98})
      for (const double y : {0.2, 0.7}) {
        const auto s = light.sample_li(receiver, {x, y});
        if (s.reason != NoLight::kNone) {
          EXPECT_EQ(s.reason, NoLight::kBehind);
          continue;
        }
        const std::string at = row.text("receiver_x") + " " + row.text("receiver_z");
        sweep.compare(light.pdf_li(receiver, s.wi).per_sr, s.pdf.per_sr, at);
        // The textbook's mixture adds up all surfaces that the direction meets.
        double sum = 0;
        mesh.for_each_hit(receiver.position, s.wi,
                          [&](const SurfacePoint& p) { sum += mesh.pdf(receiver, p).per_sr; });
        sweep.compare_textbook(sum, s.pdf.per_sr);
      }
  }
  // From 1e9 sizes away, a direction in double gives the place on the box to 1e-7 of its size.
  sweep.expect_within(1e-13);
}

TEST(ClosedMeshExtremes, ReceiversInsideGetNoLight) {
  Sweep sweep(30, "closed emissive box, the receiver inside", "1e-12 ... 0.5 below a face",
              "answer");
  const auto light = *AreaLight::create({Rgb(1)}, *TriangleMesh::create(box_triangles()));
  for (double depth = 0.5; depth > 1e-12; depth /= 10)
    for (const AreaSampling way : {AreaSampling::kSolidAngle, AreaSampling::kLowDistortion}) {
      Receiver receiver(0.125, 0.0625, 0.5 - depth);
      receiver.area_sampling = way;
      for (int i = 0; i < 48; ++i) {
        const auto s = light.sample_li(receiver, {(i + 0.5) / 48, 0.3});
        EXPECT_EQ(light.pdf_li(receiver, s.wi).per_sr, 0);
        sweep.answer(s.reason);
      }
    }
  sweep.expect_answers(NoLight::kBehind);
}

}  // namespace
}  // namespace lucerna::testing
