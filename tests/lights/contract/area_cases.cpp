// Area lights: a table of shapes and emissions.  The expected answers come from solid geometry and
// from hat functions, not from the code of the shapes.
#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

#include "lights/models/area_light.h"
#include "lights/shapes/all_shapes.h"
#include "tests/lights/contract/light_case.h"

namespace lucerna::testing {
namespace {

constexpr Rgb kLevel{1, 2, 4};

/// A shape, and what is known of it.
struct Surface {
  std::string name{};
  std::function<std::shared_ptr<const Shape>(const Placement&)> make{};
  std::vector<Vec3> receivers{};
  std::function<double(const Vec3&)> distance{};
  /// Where the ray meets a side that emits, with a slack for rounded directions.
  std::function<std::optional<Vec3>(const Vec3& r, const Vec3& wi)> hit{};
  std::function<CaseRegion(const Vec3& receiver)> region{};
  /// A map of the unit square onto the surface that keeps area, and its inverse.
  std::function<Vec3(double, double)> position{};
  std::function<Vec2(const Vec3&)> where{};
  double area_m2 = 0;
  /// Of the side that emits.
  std::function<Vec3(const Vec3&)> normal{};
  /// Coordinates of pictures, and the area of a unit of them.  Without it: by a grid of positions.
  std::function<Vec2(const Vec3&)> uv{};
  std::function<double(double u, double v)> area_of_uv{};
  ImageFilter filter = ImageFilter::kBilinear;
  /// C0 of the photometry.
  Vec3 tangent{1, 0, 0};
  bool mirrored = false;
  std::vector<Vec3> near_receivers{};
  bool two_sided = false, flat = false, confined = true, enclosed = false;
  Vec3 far_direction{0, 0, 1};
};

// ---- Emission. ----

constexpr int kColumns = 4, kRows = 3;

/// Rows from the top.
Rgbf texel(int x, int y) {
  constexpr float kLuminance[kRows][kColumns] = {{1, 6, 2, 0.5}, {3, 0.25, 5, 4}, {8, 2, 1, 7}};
  const float v = kLuminance[y][x];
  return {v, 0.5F * v + 0.125F * float(x), 0.25F + 0.25F * float(y)};
}

Picture picture(ImageFilter filter) {
  std::vector<Rgbf> texels;
  for (int y = 0; y < kRows; ++y)
    for (int x = 0; x < kColumns; ++x) texels.push_back(texel(x, y));
  return {*Image::create(kColumns, kRows, std::move(texels)), filter, "test"};
}

/// The picture at (u, v), v upwards: a sum of hats about the texels' centres.
Rgb shown(Vec2 uv, ImageFilter filter) {
  const auto share = [&](double at, int n, int i) {
    const double c = std::fmin(std::fmax(at * n - 0.5, 0), n - 1);
    if (filter == ImageFilter::kNearest) return std::lround(c) == i ? 1.0 : 0.0;
    return std::fmax(0, 1 - std::fabs(c - i));
  };
  Rgb sum;
  for (int y = 0; y < kRows; ++y)
    for (int x = 0; x < kColumns; ++x)
      sum += Rgb(texel(x, y)) * (share(uv.x, kColumns, x) * share(1 - uv.y, kRows, y));
  return sum;
}

constexpr int kPolar = 5, kPlanes = 4;
/// Intensity at 0, 45, 90, 135 and 180 degrees from +z, in the planes C0, C90, C180 and C270 [cd].
constexpr double kIntensity[kPlanes][kPolar] = {
    {100, 80, 30, 15, 10}, {100, 120, 20, 25, 10}, {100, 60, 10, 5, 10}, {100, 40, 40, 35, 10}};

std::shared_ptr<const PhotometricWeb> web() {
  PhotometricWebParams params;
  params.vertical_deg = {0, 45, 90, 135, 180};
  params.horizontal_deg = {0, 90, 180, 270, 360};
  for (int plane = 0; plane <= kPlanes; ++plane)
    for (const double cd : kIntensity[plane % kPlanes]) params.intensity_cd.push_back(cd);
  return *PhotometricWeb::create(params);
}

/// Intensity towards `w` in photometric axes: C0 is +x, C90 is -y.
double intensity(const Vec3& w) {
  const double theta = std::atan2(std::hypot(w.x, w.y), w.z) / (kPi / 4);
  double phi = std::atan2(-w.y, w.x) / (kPi / 2);
  if (phi < 0) phi += 4;
  const int row = std::min(int(theta), 3), plane = std::min(int(phi), 3);
  const double t = theta - row, s = phi - plane;
  const auto at = [&](int p, int r) { return kIntensity[p % kPlanes][r]; };
  return (at(plane, row) * (1 - t) + at(plane, row + 1) * t) * (1 - s) +
         (at(plane + 1, row) * (1 - t) + at(plane + 1, row + 1) * t) * s;
}

/// The mean of `f` over the unit square, by midpoints.
template <typename F>
auto mean(int grid, F&& f) {
  auto sum = f(0.0, 0.0) * 0.0;
  for (int i = 0; i < grid; ++i)
    for (int j = 0; j < grid; ++j)
      sum += f((i + 0.5) / grid, (j + 0.5) / grid) * (1 / (double(grid) * grid));
  return sum;
}

/// The integral of the intensity over the angles up to `widest` from +z.  The grid's lines fall
/// between its steps.
double flux(double widest) {
  return widest * 2 * kPi * mean(2000, [&](double x, double y) {
           const double r = std::sin(widest * x), phi = 2 * kPi * y;
           return r * intensity({r * std::cos(phi), r * std::sin(phi), std::cos(widest * x)});
         });
}

/// The integral of the picture over the surface.  The grid is a multiple of twice the texels, so
/// the function is smooth between its points.
Rgb painted_area(const Surface& s) {
  if (s.area_of_uv)
    return mean(1200, [&](double u, double v) {
      return shown({u, v}, s.filter) * s.area_of_uv(u, v);
    });
  return mean(2000, [&](double x, double y) {
    return shown(s.uv(s.position(x, y)), s.filter) * s.area_m2;
  });
}

/// The radiance of `s` at `p` towards `w`.
Rgb radiance(const Surface& s, bool with_picture, bool with_profile, const Vec3& p, const Vec3& w) {
  const Rgb level = with_picture ? kLevel * shown(s.uv(p), s.filter) : kLevel;
  if (!with_profile) return level;
  const Vec3 z{0, 0, 1}, x = normalized(Vec3{s.tangent.x, s.tangent.y, 0});
  const Vec3 y = s.mirrored ? cross(x, z) : cross(z, x);
  return level * (intensity({dot(w, x), dot(w, y), w.z}) / (s.area_m2 * std::fabs(w.z)));
}

LightCase area_light(const Surface& s, bool with_picture, bool with_profile) {
  LightCase c;
  c.name = s.name + (with_picture ? "_picture" : "") + (with_profile ? "_profile" : "");
  c.make = [=](const Placement& at) {
    EmissionPattern pattern;
    if (with_picture) pattern.picture = picture(s.filter);
    if (with_profile) {
      pattern.profile.emplace();
      pattern.profile->web = web();
      pattern.profile->tangent = at.direction(s.tangent);
      pattern.profile->mirrored = s.mirrored;
    }
    return std::make_unique<const AreaLight>(
        *AreaLight::create({kLevel, s.two_sided}, s.make(at), std::move(pattern)));
  };
  c.receivers = s.receivers;
  c.near_receivers = s.near_receivers;
  c.emitted = [=](const Vec3& p, const Vec3& w) {
    return radiance(s, with_picture, with_profile, p, w);
  };
  c.value = [=](const Vec3& r, const Vec3& wi) {
    const auto p = s.hit(r, wi);
    return p ? radiance(s, with_picture, with_profile, *p, -wi) : Rgb{};
  };
  c.region = s.region;
  c.distance_to_surface = s.distance;
  c.power_lm = [=] {
    const Rgb m2 = with_picture ? painted_area(s) : Rgb(s.area_m2);
    return kLevel * m2 *
           (with_profile ? flux(s.two_sided ? kPi : kPi / 2) / s.area_m2
                         : kPi * (s.two_sided ? 2 : 1));
  };
  c.emission_position = [=](const Vec3&, double x, double y) { return s.position(x, y); };
  c.emission_where = [=](const Vec3& p, const Vec3&) { return s.where(p); };
  c.emission_area_m2 = s.area_m2;
  const auto normal = s.normal ? s.normal : [](const Vec3&) { return Vec3{0, 0, 1}; };
  if (s.normal) c.emission_direction = normal;
  c.emission_region = [normal, both = s.two_sided](const Vec3& p) {
    return both ? Region{} : Region{normal(p), kPi / 2};
  };
  // The candela of a file do not depend on the size.
  if (with_profile) c.value_length_power = -2, c.power_length_power = 0;
  if (with_picture && !s.area_of_uv) c.power_tolerance = 1e-5;  // of the grid, across kinks
  // Positions of 10 m have a rounding of 2e-15 m.  By that, texels of 0.1 m differ by a few 1e-14
  // of their value, times at most 60, the ratio of the brightest to the darkest.  Directions have a
  // rounding of 2e-16, and their cosine is rarely less than 1e-3.
  if (with_picture || with_profile) c.moved_tolerance = 1e-11;
  c.far_direction = s.far_direction;
  c.enclosed = s.enclosed;
  c.confined = s.confined && !s.two_sided;
  return c;
}

// ---- Shapes. ----

/// All within `reach` of `middle`.  About a corner, edges would run along the cells of the
/// quadrature.
std::function<CaseRegion(const Vec3&)> within(double reach, const Vec3& middle = {}) {
  return [=](const Vec3& r) {
    const Vec3 to = middle - r;
    if (length(to) < 1.1 * reach) return Region{{0, 0, -1}, kPi / 2};
    return Region{normalized(to), 1.05 * std::asin(reach / length(to))};
  };
}

/// The angle of `p` about z, as a share of `whole`.
double share_of_turn(const Vec3& p, double whole) {
  const double phi = std::atan2(p.y, p.x);
  return (phi < -1e-6 ? phi + 2 * kPi : phi) / whole;
}

Vec3 polar(double r, double phi, double z = 0) { return {r * std::cos(phi), r * std::sin(phi), z}; }

/// Completes a surface in the plane z = 0 that faces +z.  `outside`: how far a point of the plane
/// is from it, negative within.
template <typename Outside>
Surface flat(Surface s, Outside outside) {
  s.flat = true;
  s.distance = [=](const Vec3& p) { return std::fmax(std::fabs(p.z), outside(p)); };
  s.hit = [=, both = s.two_sided](const Vec3& r, const Vec3& wi) -> std::optional<Vec3> {
    const double t = -r.z / wi.z;
    if (!(t > 0) || (r.z < 0 && !both)) return std::nullopt;
    const Vec3 p = r + wi * t;
    return outside(p) < 1e-6 ? std::optional(p) : std::nullopt;
  };
  return s;
}

template <typename S>
std::shared_ptr<const Shape> shared(absl::StatusOr<S> shape) {
  return std::make_shared<const S>(*std::move(shape));
}

/// The triangle (0, 0), (1, 0), (0, 1) in two parts of unequal area.  The picture's border
/// continues beyond u = 1.
Surface triangles() {
  const auto uv = [](const Vec3& p) { return Vec2{0.25 + p.x, 0.125 + 0.25 * p.x + 0.75 * p.y}; };
  Surface s;
  s.name = "triangles";
  s.make = [=](const Placement& at) {
    const Vec3 corners[] = {{0, 0, 0}, {0.25, 0, 0}, {0, 1, 0}, {0.25, 0, 0}, {1, 0, 0}, {0, 1, 0}};
    std::vector<Vec3> p;
    std::vector<Vec2f> corner_uv;
    for (const Vec3& corner : corners) {
      p.push_back(at.point(corner));
      corner_uv.push_back({float(uv(corner).x), float(uv(corner).y)});
    }
    return shared(TriangleMesh::create({{p[0], p[1], p[2]}, {p[3], p[4], p[5]}}, corner_uv));
  };
  s.receivers = {{0.5, 0.25, 2}, {-2, 1, 2}, {0, 3, 1.5}};
  s.region = within(0.79, {0.31, 0.29, 0});
  // The width shrinks linearly to the corner (1, 0), so s^2 is a share of area.
  s.position = [](double x, double y) { return Vec3{1 - std::sqrt(x), std::sqrt(x) * y, 0}; };
  s.where = [](const Vec3& p) { return Vec2{(1 - p.x) * (1 - p.x), p.y / (1 - p.x)}; };
  s.area_m2 = 0.5;
  s.uv = uv;
  s.tangent = {1, 2, 0};
  return flat(s, [](const Vec3& p) { return std::fmax(std::fmax(-p.x, -p.y), p.x + p.y - 1); });
}

/// A parallelogram, or a rectangle without a `slant`: one patch, or two triangles that are cut from
/// corner to corner.
Surface parallelogram(const std::string& name, double slant, bool of_triangles) {
  const auto at = [=](double u, double v) {
    return Vec3{2 * u - 1 + slant * (v - 0.5), v - 0.5, 0};
  };
  Surface s;
  s.name = name;
  s.make = [=](const Placement& placement) {
    const auto p = [&](double u, double v) { return placement.point(at(u, v)); };
    if (of_triangles)
      return shared(TriangleMesh::create({{p(1, 0), p(1, 1), p(0, 0)}, {p(0, 1), p(0, 0), p(1, 1)}},
                                         {{1, 0}, {1, 1}, {0, 0}, {0, 1}, {0, 0}, {1, 1}}));
    return shared(PatchMesh::create({{p(0, 0), p(1, 0), p(0, 1), p(1, 1)}}));
  };
  s.receivers = {{0.5, 0.25, 2}, {-2, 1, 2}, {1, -3, 1}};
  s.region = within(slant == 0 ? 1.12 : 1.4);
  s.position = at;
  s.where = [=](const Vec3& p) { return Vec2{(p.x + 1 - slant * p.y) / 2, p.y + 0.5}; };
  s.area_m2 = 2;
  s.uv = s.where;
  s.area_of_uv = [](double, double) { return 2.0; };
  if (slant != 0) s.tangent = {1, 1, 0.5};
  return flat(s, [uv = s.uv](const Vec3& p) {
    return std::fmax(std::fabs(uv(p).x - 0.5), std::fabs(uv(p).y - 0.5)) - 0.5;
  });
}

/// It emits on both sides.  The picture lies on its side and shows its texels without a filter.
Surface trapezoid() {
  const auto at = [](double s, double t) { return Vec3{(2 * s - 1) * (1 - t / 2), 2 * t - 1, 0}; };
  const auto st = [](const Vec3& p) {
    const double t = (p.y + 1) / 2;
    return Vec2{(p.x / (1 - t / 2) + 1) / 2, t};
  };
  Surface s;
  s.name = "trapezoid";
  s.make = [=](const Placement& placement) {
    const auto p = [&](double s, double t) { return placement.point(at(s, t)); };
    return shared(PatchMesh::create({{p(0, 0), p(1, 0), p(0, 1), p(1, 1)}},
                                    {{1, 0}, {1, 1}, {0, 0}, {0, 1}}));
  };
  s.receivers = {{0.5, 0.25, 2}, {0.5, -1, -2.5}};
  s.near_receivers = {{1.5, 0.25, 0.125}, {0.25, 0.125, 0.0625}};
  s.region = within(1.42);
  // The area below t is 4 t - t^2, of 3.
  s.position = [=](double x, double y) { return at(x, 2 - std::sqrt(4 - 3 * y)); };
  s.where = [=](const Vec3& p) { return Vec2{st(p).x, (4 - st(p).y) * st(p).y / 3}; };
  s.area_m2 = 3;
  s.uv = [=](const Vec3& p) { return Vec2{1 - st(p).y, st(p).x}; };
  // |dp/ds x dp/dt| = 4 - 2 t, t = 1 - u.
  s.area_of_uv = [](double u, double) { return 2 + 2 * u; };
  s.filter = ImageFilter::kNearest;
  s.two_sided = true;
  return flat(s, [=](const Vec3& p) {
    return std::fmax(std::fabs(st(p).x - 0.5), std::fabs(st(p).y - 0.5)) - 0.5;
  });
}

/// A saddle z = x y / 2 over |x|, |y| < 1 that emits on both sides.
class Saddle {
 public:
  Surface surface() const {
    Surface s;
    s.name = "saddle";
    s.make = [](const Placement& at) {
      const auto p = [&](double x, double y) { return at.point({x, y, x * y / 2}); };
      return shared(PatchMesh::create({{p(-1, -1), p(1, -1), p(-1, 1), p(1, 1)}}));
    };
    s.receivers = {{0.5, 0.25, 3}, {0.5, -1, -2.5}};
    s.distance = [](const Vec3& p) {
      const double aside = std::fmax(std::fabs(p.x), std::fabs(p.y)) - 1;
      return std::fmax(std::fabs(p.z - p.x * p.y / 2), aside);
    };
    // Its radiance is the same everywhere.
    s.hit = [](const Vec3& r, const Vec3&) { return std::optional(r); };
    s.region = within(1.5);
    s.position = [own = *this](double x, double y) { return own.position(x, y); };
    s.where = [own = *this](const Vec3& p) { return own.where(p); };
    s.area_m2 = strips_.back();
    s.two_sided = true;
    return s;
  }

 private:
  static constexpr int kStrips = 4096;

  /// The area from -1 to y on the line of constant x, where dA = sqrt(1 + (x^2 + y^2) / 4) dx dy.
  /// With s = y / 2 it is the integral of 2 sqrt(c + s^2), c = 1 + x^2 / 4.
  static double area_of_line(double x, double y) {
    const double c = 1 + x * x / 4;
    const auto to = [&](double s) {
      return s * std::sqrt(c + s * s) + c * std::asinh(s / std::sqrt(c));
    };
    return to(y / 2) - to(-0.5);
  }
  Vec3 position(double u, double v) const {
    const double target = u * strips_.back();
    const auto above = std::upper_bound(strips_.begin(), strips_.end(), target);
    const auto i = std::clamp<std::size_t>(above - strips_.begin(), 1, kStrips);
    const double part = (target - strips_[i - 1]) / (strips_[i] - strips_[i - 1]);
    const double x = 2 * (double(i - 1) + part) / kStrips - 1;
    double low = -1, high = 1;
    for (int step = 0; step < 50; ++step) {
      const double y = (low + high) / 2;
      (area_of_line(x, y) < v * area_of_line(x, 1) ? low : high) = y;
    }
    return {x, low, x * low / 2};
  }
  Vec2 where(const Vec3& p) const {
    const double at = std::clamp((p.x + 1) / 2 * kStrips, 0.0, kStrips - 0.001);
    const auto i = static_cast<std::size_t>(at);
    return {std::lerp(strips_[i], strips_[i + 1], at - double(i)) / strips_.back(),
            area_of_line(p.x, p.y) / area_of_line(p.x, 1)};
  }

  /// The area from -1 to x, by the trapezoidal rule.  Its error is below 1e-8.
  std::vector<double> strips_ = [] {
    constexpr double kStep = 2.0 / kStrips;
    std::vector<double> sums{0};
    for (int i = 0; i < kStrips; ++i) {
      const double x = i * kStep - 1;
      sums.push_back(sums.back() + (area_of_line(x, 1) + area_of_line(x + kStep, 1)) * kStep / 2);
    }
    return sums;
  }();
};

/// A closed box, |x| < 1, |y| < 1/2, |z| < 1/4, that emits outwards.  Parts of it always face away.
class Box {
 public:
  static Surface surface() {
    return {.name = "box",
            .make = make,
            .receivers = {{2, 1.5, 1}, {0.125, 0.25, -2.5}},
            .distance =
                [](const Vec3& p) {
                  double outside = -INFINITY;
                  for (int axis = 0; axis < 3; ++axis)
                    outside = std::fmax(outside, std::fabs(p[axis]) - half()[axis]);
                  return std::fabs(outside);
                },
            .hit = hit,
            .region = within(1.15),
            .position = position,
            .where = where,
            .area_m2 = kArea,
            .normal = normal,
            .confined = false};
  }

 private:
  static Vec3 half() { return {1, 0.5, 0.25}; }
  static constexpr double kArea = 8 * (0.5 * 0.25 + 0.25 * 1 + 1 * 0.5);

  static std::shared_ptr<const Shape> make(const Placement& at) {
    std::vector<BilinearPatch> faces;
    for (int axis = 0; axis < 3; ++axis) {
      for (const double side : {-1., 1.}) {
        const auto corner = [&](double s, double t) {
          // The handedness of the face changes with its side.
          const double v[3] = {side, side * s, t};
          return at.point({half().x * v[(3 - axis) % 3], half().y * v[(4 - axis) % 3],
                           half().z * v[(5 - axis) % 3]});
        };
        faces.push_back({corner(-1, -1), corner(1, -1), corner(-1, 1), corner(1, 1)});
      }
    }
    return shared(PatchMesh::create(std::move(faces)));
  }
  static std::optional<Vec3> hit(const Vec3& r, const Vec3& wi) {
    double enter = 0, leave = INFINITY;  // between the planes of each pair
    for (int axis = 0; axis < 3; ++axis) {
      const double slack = half()[axis] + 1e-6;
      const double a = (slack - r[axis]) / wi[axis], b = (-slack - r[axis]) / wi[axis];
      enter = std::fmax(enter, std::fmin(a, b)), leave = std::fmin(leave, std::fmax(a, b));
    }
    return enter < leave ? std::optional(r + wi * enter) : std::nullopt;
  }
  /// Faces one after the other, the two across x first, each with its share of the area.
  struct Face {
    int axis;
    double side, begin, end;  ///< its interval of the first coordinate
  };
  static std::vector<Face> faces() {
    std::vector<Face> all;
    double sum = 0;
    for (int axis = 0; axis < 3; ++axis)
      for (const double side : {-1., 1.}) {
        const double share = 4 * half()[(axis + 1) % 3] * half()[(axis + 2) % 3] / kArea;
        all.push_back({axis, side, sum, sum + share});
        sum += share;
      }
    return all;
  }
  static Vec3 position(double x, double y) {
    const auto all = faces();
    Face face = all.back();
    for (const Face& f : all)
      if (x >= f.begin && x < f.end) face = f;
    double v[3];
    v[face.axis] = face.side * half()[face.axis];
    const int s = (face.axis + 1) % 3, t = (face.axis + 2) % 3;
    v[s] = half()[s] * (2 * (x - face.begin) / (face.end - face.begin) - 1);
    v[t] = half()[t] * (2 * y - 1);
    return {v[0], v[1], v[2]};
  }
  static Vec2 where(const Vec3& p) {
    for (const Face& f : faces()) {
      if (std::fabs(p[f.axis] - f.side * half()[f.axis]) > 1e-6) continue;
      const int s = (f.axis + 1) % 3, t = (f.axis + 2) % 3;
      return {std::lerp(f.begin, f.end, (p[s] / half()[s] + 1) / 2), (p[t] / half()[t] + 1) / 2};
    }
    return {NAN, NAN};
  }
  static Vec3 normal(const Vec3& p) {
    Vec3 n;
    for (int axis = 0; axis < 3; ++axis)
      if (std::fabs(std::fabs(p[axis]) - half()[axis]) < 1e-6)
        n = Vec3{axis == 0 ? p.x : 0, axis == 1 ? p.y : 0, axis == 2 ? p.z : 0};
    return normalized(n);
  }
};

/// A part of an annulus.  Whole disks emit on both sides, with mirrored photometry.
Surface disk(double radius, double inner, double sweep) {
  const double ring = radius * radius - inner * inner;
  const bool whole = sweep == 2 * kPi;
  Surface s;
  s.name = whole ? "disk" : "half_annulus";
  s.make = [=](const Placement& at) {
    return shared(Disk::create({.radius_m = radius,
                                .inner_radius_m = inner,
                                .phi_max_rad = sweep,
                                .world_from_object = at.world_from_light()}));
  };
  s.receivers = {{0, 0.5, 2}, {2, -1, 1.5}};
  if (whole) s.receivers = {{0.5, 0.25, 2}, {0.5, -1, -1.5}};
  s.near_receivers = {{0, 0, radius / 3}, {1.0625 * radius, 0, radius / 8}};
  s.region = within(1.02 * radius);
  s.position = [=](double x, double y) {
    return polar(std::sqrt(inner * inner + ring * x), sweep * y);
  };
  s.where = [=](const Vec3& p) {
    return Vec2{(p.x * p.x + p.y * p.y - inner * inner) / ring, share_of_turn(p, sweep)};
  };
  s.area_m2 = ring * sweep / 2;
  s.uv = [=](const Vec3& p) {
    return Vec2{share_of_turn(p, sweep), (radius - std::hypot(p.x, p.y)) / (radius - inner)};
  };
  // r dr dphi
  s.area_of_uv = [=](double, double v) {
    return (radius - v * (radius - inner)) * (radius - inner) * sweep;
  };
  s.tangent = {1, 1, 0.5};
  s.mirrored = s.two_sided = whole;
  return flat(s, [=](const Vec3& p) {
    const double r = std::hypot(p.x, p.y);
    return std::fmax(std::fmax(r - radius, inner - r), whole ? -1.0 : -p.y);
  });
}

/// The zone above `z_min` of a sphere about the origin.  Cut ones are seen without their
/// silhouette: there the density by area has a pole, which no quadrature on a grid resolves.
Surface sphere(const std::string& name, double radius, double z_min, double sweep, bool inwards) {
  const bool whole = z_min <= -radius;
  const double height = radius - z_min, widest = std::acos(z_min / radius);
  Surface s;
  s.name = name;
  s.make = [=](const Placement& at) {
    SphereParams params{.radius_m = radius,
                        .phi_max_rad = sweep,
                        .reverse_orientation = inwards,
                        .world_from_object = at.world_from_light()};
    if (!whole) params.z_min_m = z_min;
    return shared(Sphere::create(params));
  };
  s.receivers = {{0, 0.5, 3}, {1, 0, 3}};
  if (whole) s.receivers = {{2, 1, 2}, {0, 0, -1.75}, {0, 80, 60}};
  s.distance = [=](const Vec3& p) {
    const double turn = sweep < kPi ? std::fmax(-p.x, -p.y) : -1;
    return std::fmax(std::fabs(length(p) - radius), std::fmax(whole ? -1 : z_min - p.z, turn));
  };
  s.hit = [=](const Vec3& r, const Vec3& wi) -> std::optional<Vec3> {
    if (length(cross(r, wi)) >= radius * (1 + 1e-5)) return std::nullopt;
    const double b = -dot(r, wi);
    const double root = std::sqrt(std::fmax(0, b * b - dot(r, r) + radius * radius));
    return r + wi * (inwards ? b + root : b - root);
  };
  s.region = within(radius);
  // Zones of equal height on a sphere have equal areas.  (Archimedes)
  s.position = [=](double x, double y) {
    const double z = z_min + height * x;
    return polar(std::sqrt(radius * radius - z * z), sweep * y, z);
  };
  s.where = [=](const Vec3& p) { return Vec2{(p.z - z_min) / height, share_of_turn(p, sweep)}; };
  s.area_m2 = sweep * radius * height;
  s.normal = [=](const Vec3& p) { return normalized(inwards ? -p : p); };
  s.confined = !whole;
  // A sphere that emits inwards is seen from within: no light leaves it.
  if (inwards) {
    s.receivers = {{0, 0, 0}, {0.25, -0.25, 0.375}};
    s.region = [](const Vec3&) { return Region{}; };
    s.enclosed = true;
  }
  if (sweep < kPi) {
    s.uv = [=](const Vec3& p) {
      const double theta = std::atan2(std::hypot(p.x, p.y), p.z);
      return Vec2{share_of_turn(p, sweep), 1 - theta / widest};
    };
    s.area_of_uv = [=](double, double v) {
      return radius * radius * std::sin(widest * (1 - v)) * widest * sweep;
    };
  }
  return s;
}

/// A quarter of a tube that emits outwards, seen from places that all of it faces, or a whole one
/// that emits inwards.
Surface tube(bool inwards) {
  constexpr double kRadius = 0.5, kHalfHeight = 0.75;
  const double sweep = inwards ? 2 * kPi : kPi / 2;
  const auto distance = [=](const Vec3& p) {
    const double off = std::fabs(std::hypot(p.x, p.y) - kRadius);
    const double cut = inwards ? -1 : std::fmax(-p.x, -p.y);
    return std::fmax(std::fmax(off, std::fabs(p.z) - kHalfHeight), cut);
  };
  Surface s;
  s.name = inwards ? "inward_tube" : "quarter_tube";
  s.make = [=](const Placement& at) {
    return shared(Cylinder::create({.radius_m = kRadius,
                                    .z_min_m = -kHalfHeight,
                                    .z_max_m = kHalfHeight,
                                    .phi_max_rad = sweep,
                                    .reverse_orientation = inwards,
                                    .world_from_object = at.world_from_light()}));
  };
  s.distance = distance;
  // By the quadratic equation.
  s.hit = [=](const Vec3& r, const Vec3& wi) -> std::optional<Vec3> {
    const double a = wi.x * wi.x + wi.y * wi.y, b = r.x * wi.x + r.y * wi.y;
    const double square = b * b - a * (r.x * r.x + r.y * r.y - kRadius * kRadius);
    if (!(a > 0) || square < -1e-5 * a) return std::nullopt;
    const double root = std::sqrt(std::fmax(0, square));
    const Vec3 p = r + wi * ((inwards ? root - b : -b - root) / a);
    return distance(p) < 1e-5 ? std::optional(p) : std::nullopt;
  };
  s.position = [=](double x, double y) {
    return polar(kRadius, sweep * y, kHalfHeight * (2 * x - 1));
  };
  s.where = [=](const Vec3& p) {
    return Vec2{(p.z / kHalfHeight + 1) / 2, share_of_turn(p, sweep)};
  };
  s.area_m2 = sweep * kRadius * 2 * kHalfHeight;
  s.normal = [=](const Vec3& p) { return normalized(Vec3{p.x, p.y, 0} * (inwards ? -1.0 : 1.0)); };
  s.confined = !inwards;
  s.far_direction = normalized(Vec3{1, 1, 0.5});
  if (inwards) {
    s.receivers = {{0, 0, 0}, {0.125, -0.25, 0.375}};
    // All directions, about a tilted axis.  About the tube's own, the rims would run along the
    // cells of the quadrature.
    s.region = [](const Vec3&) { return Region{normalized(Vec3{1, 2, 3}), kPi}; };
  } else {
    s.receivers = {{2, 1.5, 0.25}, {1, 2, -2}};
    s.region = within(0.91);
    s.uv = [=](const Vec3& p) { return Vec2{share_of_turn(p, sweep), p.z / 1.5 + 0.5}; };
    s.area_of_uv = [area = s.area_m2](double, double) { return area; };
  }
  return s;
}

// ---- Ways to sample a shape: each makes a light of its own, whose receivers request it. ----

/// The directions from outside to a ball about the origin, by the visible part of its surface.  The
/// cells have equal area on the surface.  The density by area has a pole at the silhouette; that of
/// these cells is 0 there.
struct SeenBall {
  Vec3 receiver;
  double radius;

  double distance() const { return length(receiver); }
  /// The cosine at the centre, between the receiver and a visible point, is 1 minus x times this.
  double one_minus_cos() const { return 1 - radius / distance(); }
  Vec3 at(double x, double y) const { return normalized(point(x, y) - receiver); }
  Vec2 where(const Vec3& w) const {
    // The nearer of two hits.  A direction that is rounded past the silhouette counts as on it.
    const double b = -dot(receiver, w);
    const double half_chord =
        std::sqrt(std::fmax(0, radius * radius - dot(cross(receiver, w), cross(receiver, w))));
    const Vec3 n = normalized(receiver + w * (b - half_chord));
    const Vec3 local = Frame::around(normalized(receiver)).local_from_world(n);
    const double y = std::atan2(local.y, local.x) / (2 * kPi);
    return {(1 - local.z) / one_minus_cos(), y < 0 ? y + 1 : y};
  }
  /// dA cos / d^2; the area is 2 pi r^2 (1 - cos) for x and y from 0 to 1.
  double element_sr(double x, double y) const {
    const Vec3 p = point(x, y), to_receiver = receiver - p;
    const double d2 = dot(to_receiver, to_receiver);
    const double cos = dot(p, to_receiver) / (radius * std::sqrt(d2));
    return 2 * kPi * radius * radius * one_minus_cos() * cos / d2;
  }

 private:
  Vec3 point(double x, double y) const {
    const double z = 1 - x * one_minus_cos(), r = std::sqrt((1 - z) * (1 + z));
    return Frame::around(normalized(receiver)).world_from_local(polar(r, 2 * kPi * y, z)) * radius;
  }
};

LightCase sampled(Surface s, AreaSampling way, std::vector<Vec3> receivers) {
  // Facing the light at an angle, so that some corners have larger weights.
  constexpr Vec3 kNormal{0.6, 0, -0.8};
  s.name += "_by_" + std::to_string(static_cast<int>(way));
  s.receivers = std::move(receivers);
  LightCase c = area_light(s, false, false);
  c.receivers_only = true;
  c.receiver_at = [=](const Vec3& p, const Placement& at) {
    Receiver r(p);
    r.normal = at.direction(kNormal);
    r.area_sampling = way;
    return r;
  };
  return c;
}

void add_ways(std::vector<LightCase>& cases) {
  using enum AreaSampling;
  Surface whole_disk = disk(1, 0, 2 * kPi);
  whole_disk.two_sided = false;
  // The last receivers are near: the light covers a quarter of their sphere.
  const std::vector<Vec3> receivers{{0.5, 0.25, 2}, {-2, 1, 2}, {0.25, 0.25, 0.25}};
  for (const AreaSampling way : {kSquareRoot, kKraemer, kParallelogram, kRejection, kLowDistortion,
                                 kSolidAngle, kCosineSolidAngle, kAutomatic})
    cases.push_back(sampled(triangles(), way, receivers));
  for (const AreaSampling way : {kLowDistortion, kSolidAngle, kCosineSolidAngle, kAutomatic})
    cases.push_back(sampled(parallelogram("rectangle", 0, false), way, receivers));
  // The second receiver is below the rim.
  for (const AreaSampling way : {kLowDistortion, kSolidAngle, kAutomatic})
    cases.push_back(
        sampled(whole_disk, way, {{0, 0, 2}, {1, 0, 1}, {-2, 1, 0.5}, {0.25, 0.125, 0.375}}));
  const Surface inside = sphere("inward_sphere", 0.75, -0.75, 2 * kPi, true);
  for (const AreaSampling way : {kLowDistortion, kSolidAngle}) {
    cases.push_back(sampled(inside, way, inside.receivers));
    // Seen from outside, points of the far wall are sampled by area, and the near wall hides them.
    cases.back().enclosed = way == kSolidAngle;
  }
  // From outside, at least half of a sphere faces away.  Near its silhouette the densities of
  // rounded directions differ much from each other, so only their sums and counts are compared.
  cases.push_back(sampled(sphere("sphere", 0.75, -0.75, 2 * kPi, false), kLowDistortion,
                          {{2, 1, 2}, {0, 0, -1}, {0.5, 0.5, 0.5}}));
  cases.back().value = nullptr;
  cases.back().region = [](const Vec3& r) { return SeenBall{r, 0.75}; };
}

}  // namespace

void add_area_lights(std::vector<LightCase>& cases) {
  for (const Surface& s :
       {triangles(), parallelogram("rectangle", 0, false),
        parallelogram("parallelogram", 0.5, false), parallelogram("two_triangles", 0.5, true),
        trapezoid(), Saddle().surface(), Box::surface(), disk(1, 0.5, kPi), disk(0.75, 0, 2 * kPi),
        sphere("sphere", 0.75, -0.75, 2 * kPi, false),
        sphere("inward_sphere", 0.75, -0.75, 2 * kPi, true), sphere("cap", 1, 0.75, 2 * kPi, false),
        sphere("quarter_cap", 1, 0.75, kPi / 2, false), tube(false), tube(true)})
    for (const bool with_picture : {false, true})
      for (const bool with_profile : {false, true})
        if ((s.uv || !with_picture) && (s.flat || !with_profile))
          cases.push_back(area_light(s, with_picture, with_profile));
  add_ways(cases);
}

}  // namespace lucerna::testing
