// Random rooms, and their text.
#include <fmt/format.h>

#include <algorithm>

#include "tests/oracle/interior.h"
#include "tests/oracle/random_lights.h"

namespace lucerna::oracle {
namespace {

std::string numbers(const Vec& v) {
  return fmt::format("{:.17g} {:.17g} {:.17g}", static_cast<double>(v.x), static_cast<double>(v.y),
                     static_cast<double>(v.z));
}

std::string material_text(const Sheet& sheet) {
  switch (sheet.kind) {
    case Sheet::Kind::kGrey:
      return fmt::format("\"diffuse\" \"rgb reflectance\" [{0:.17g} {0:.17g} {0:.17g}]",
                         sheet.value);
    case Sheet::Kind::kMirror:
      return fmt::format(
          "\"conductor\" \"rgb reflectance\" [{0:.17g} {0:.17g} {0:.17g}] \"float roughness\" 0",
          sheet.value);
    case Sheet::Kind::kPane:
      return fmt::format("\"thindielectric\" \"float eta\" {:.17g}", sheet.value);
  }
  return "";
}

/// A lamp in the world.
void add_lamp(const Interior& room, const Lamp& lamp, World& world) {
  const Real area = room.unit_m * room.unit_m;
  Light light;
  light.level = lamp.level;
  light.angle = lamp.angle;
  light.edge = lamp.edge;
  Shape shape;
  shape.radiance = lamp.level;
  switch (lamp.kind) {
    case Lamp::Kind::kPoint:
    case Lamp::Kind::kSpot:
      light.kind = lamp.kind == Lamp::Kind::kPoint ? LightKind::kPoint : LightKind::kSpot;
      light.at = room.world_point(lamp.at);
      light.level *= area;
      break;
    case Lamp::Kind::kDistant:
      light.kind = LightKind::kDistant;
      break;
    case Lamp::Kind::kRectangle: {
      const Sheet& s = lamp.sheet;
      shape.kind = ShapeKind::kParallelogram;
      shape.at = {room.world_point(s.corner), room.world_point(s.corner + s.u),
                  room.world_point(s.corner + s.v)};
      world.shapes.push_back(shape);
      return;
    }
    case Lamp::Kind::kSphere:
      shape.kind = ShapeKind::kSphere;
      shape.at[0] = room.world_point(lamp.at);
      shape.radius = lamp.radius * room.unit_m;
      world.shapes.push_back(shape);
      return;
  }
  const Vec w = room.world_vector(lamp.axis);
  light.axes = {across(w), cross(w, across(w)), w};
  world.lights.push_back(light);
}

class Maker {
 public:
  explicit Maker(std::uint64_t number) : random_(number) {}

  Interior make() {
    for (double& side : sides_) side = random_.between(0.6, 1.4);
    if (random_.chance(0.5)) room_.unit_m = random_.power(-6, 6);
    if (random_.chance(0.7)) room_.axes = random_frame(random_, random_.direction());
    if (random_.chance(0.7))
      room_.origin = random_.direction() * (room_.unit_m * random_.power(0, 4));
    add_walls();
    const int patches = random_.below(3);
    const int first = random_.below(6);
    for (int i = 0; i < patches; ++i) add_patch((first + i) % 6);
    if (random_.chance(0.35)) add_free_sheet();
    // The world lists lights without a surface first.
    const int lamps = 1 + random_.below(2);
    for (int i = 0; i < lamps; ++i) add_lamp();
    std::ranges::stable_partition(room_.lamps, [](const Lamp& l) { return !l.has_size(); });
    for (int i = 0; i < 2; ++i) room_.receivers.push_back({place(0.08, 0.12), some_direction()});
    return room_;
  }

 private:
  void add_walls() {
    const bool has_grey = random_.chance(0.4);
    for (int wall = 0; wall < 6; ++wall) {
      const double kind = random_.uniform();
      Sheet sheet = on_wall(wall, 0, {0, 1}, {0, 1});
      if (kind < (has_grey ? 0.6 : 0)) {
        sheet.value = random_.between(0, 0.9);
      } else if (kind < (has_grey ? 0.75 : 0.4)) {
        absent_.push_back(wall);
        continue;
      } else if (kind < (has_grey ? 0.9 : 0.7)) {
        make_smooth(sheet, 1);
      }
      room_.sheets.push_back(sheet);
    }
  }

  /// A rectangle before a wall; `u`, `v`: its ends as shares of the wall.
  Sheet on_wall(int wall, double gap, std::array<double, 2> u, std::array<double, 2> v) const {
    const std::size_t a = static_cast<std::size_t>(wall) / 2, b = (a + 1) % 3, c = (a + 2) % 3;
    std::array<double, 3> corner{}, eu{}, ev{};
    corner[a] = wall % 2 == 0 ? gap : sides_[a] - gap;
    corner[b] = u[0] * sides_[b];
    corner[c] = v[0] * sides_[c];
    eu[b] = (u[1] - u[0]) * sides_[b];
    ev[c] = (v[1] - v[0]) * sides_[c];
    const auto vec = [](const std::array<double, 3>& x) { return Vector{x[0], x[1], x[2]}; };
    return finished({.corner = vec(corner), .u = vec(eu), .v = vec(ev)});
  }

  void make_smooth(Sheet& sheet, double mirrors) {
    const bool mirror = random_.chance(mirrors);
    sheet.kind = mirror ? Sheet::Kind::kMirror : Sheet::Kind::kPane;
    sheet.value = mirror ? random_.between(0.2, 0.95) : random_.between(1.3, 2);
  }

  void add_patch(int wall) {
    const auto ends = [&] {
      const double size = random_.between(0.15, 0.9);
      const double start = random_.between(0.05, 0.95 - size);
      return std::array<double, 2>{start, start + size};
    };
    const auto u = ends(), v = ends();
    Sheet sheet = on_wall(wall, random_.power(-3, -1.7), u, v);
    make_smooth(sheet, 0.5);
    room_.sheets.push_back(sheet);
  }

  void add_free_sheet() {
    const Vector middle = between(0.3);
    const std::array<Vec, 3> frame =
        random_frame(random_, random_.chance(0.5) ? random_.direction() : Vec{0, 0, 1});
    const auto half = [&](const Vec& axis) {
      const double size = random_.between(0.04, 0.1);
      return Vector{static_cast<double>(axis.x), static_cast<double>(axis.y),
                    static_cast<double>(axis.z)} *
             size;
    };
    const Vector u = half(frame[0]), v = half(frame[1]);
    Sheet sheet = finished({.corner = middle - u - v, .u = u * 2, .v = v * 2});
    if (random_.chance(0.8))
      make_smooth(sheet, 0.5);
    else if (room_.has_grey())
      sheet.value = random_.between(0, 0.9);
    free_ = static_cast<int>(room_.sheets.size());
    room_.sheets.push_back(sheet);
  }

  void add_lamp() {
    Lamp lamp;
    lamp.kind = static_cast<Lamp::Kind>(random_.below(5));
    if (lamp.kind == Lamp::Kind::kDistant && absent_.empty()) lamp.kind = Lamp::Kind::kPoint;
    lamp.level = random_.power(-0.5, 0.5);
    lamp.at = place(0.3, 0.3);
    lamp.axis = some_direction();
    switch (lamp.kind) {
      case Lamp::Kind::kPoint:
        break;
      case Lamp::Kind::kSpot:
        lamp.angle = random_.between(0.25, 1.4);
        if (random_.chance(0.6)) lamp.edge = lamp.angle * random_.between(0.05, 1);
        break;
      case Lamp::Kind::kDistant: {
        const int wall =
            absent_[static_cast<std::size_t>(random_.below(static_cast<int>(absent_.size())))];
        const double out = wall % 2 == 0 ? -1 : 1;
        if (wall / 2 == 0) lamp.axis.x = out;
        if (wall / 2 == 1) lamp.axis.y = out;
        if (wall / 2 == 2) lamp.axis.z = out;
        lamp.axis = unit(lamp.axis);
        break;
      }
      case Lamp::Kind::kRectangle: {
        const Vector n = lamp.axis;
        const Vector u = unit(cross(std::fabs(n.x) < 0.6 ? Vector{1, 0, 0} : Vector{0, 1, 0}, n));
        const Vector a = u * random_.between(0.01, 0.06),
                     b = cross(n, u) * random_.between(0.01, 0.06);
        lamp.sheet = finished({.corner = lamp.at - (a + b) * 0.5, .u = a, .v = b});
        lamp.level *= 100;
        break;
      }
      case Lamp::Kind::kSphere:
        lamp.radius = random_.between(0.005, 0.04);
        lamp.level *= 100;
        break;
    }
    room_.lamps.push_back(lamp);
  }

  Vector some_direction() {
    const Vec d = random_.direction();
    return {static_cast<double>(d.x), static_cast<double>(d.y), static_cast<double>(d.z)};
  }

  Vector between(double margin) {
    return {sides_[0] * random_.between(margin, 1 - margin),
            sides_[1] * random_.between(margin, 1 - margin),
            sides_[2] * random_.between(margin, 1 - margin)};
  }

  /// A point that is so far from all lamps, and not close to the free sheet.
  Vector place(double margin, double from_lamps) {
    for (int i = 0; i < 1000; ++i) {
      const Vector p = between(margin);
      const bool apart = std::ranges::all_of(room_.lamps, [&](const Lamp& l) {
        return l.kind == Lamp::Kind::kDistant || size(p - l.at) > from_lamps;
      });
      if (apart && (free_ < 0 || is_off(room_.sheets[static_cast<std::size_t>(free_)], p)))
        return p;
    }
    return between(margin);
  }
  static bool is_off(const Sheet& sheet, const Vector& p) {
    return std::fabs(dot(sheet.n, p - sheet.corner)) > 0.06 ||
           size(p - (sheet.corner + (sheet.u + sheet.v) * 0.5)) > 0.25;
  }

  Numbers random_;
  Interior room_;
  std::array<double, 3> sides_{};
  std::vector<int> absent_;
  int free_ = -1;
};

}  // namespace

Sheet finished(Sheet sheet) {
  sheet.width = size(sheet.u);
  sheet.height = size(sheet.v);
  sheet.along_u = unit(sheet.u);
  sheet.along_v = unit(sheet.v);
  sheet.n = cross(sheet.along_u, sheet.along_v);
  return sheet;
}

bool Interior::has_grey() const {
  return std::ranges::any_of(
      sheets, [](const Sheet& s) { return s.kind == Sheet::Kind::kGrey && s.value > 0; });
}

int Interior::smooth_sheets() const {
  return static_cast<int>(
      std::ranges::count_if(sheets, [](const Sheet& s) { return s.is_smooth(); }));
}

Place Interior::place_of(const Receiver& r) const {
  return {.at = world_point(r.at), .normal = floats(world_vector(r.n))};
}

std::string pbrt_text(const Interior& room) {
  World lamps;
  for (const Lamp& lamp : room.lamps) add_lamp(room, lamp, lamps);
  // Lamps reflect nothing.
  std::string text = pbrt_text(lamps);
  text.insert(text.find('\n') + 1, "Material " + material_text(Sheet{}) + "\n");
  for (const Sheet& s : room.sheets)
    text += fmt::format(
        "Material {}\nShape \"bilinearmesh\" \"point3 P\" [{}  {}  {}  {}]\n", material_text(s),
        numbers(room.world_point(s.corner)), numbers(room.world_point(s.corner + s.u)),
        numbers(room.world_point(s.corner + s.v)), numbers(room.world_point(s.corner + s.u + s.v)));
  return text;
}

Interior random_interior(std::uint64_t number) { return Maker(number).make(); }

}  // namespace lucerna::oracle
