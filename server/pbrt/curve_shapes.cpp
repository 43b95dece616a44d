#include "server/pbrt/curve_shapes.h"

#include <fmt/format.h>

#include <cmath>

#include "server/description/curve_pieces.h"

namespace lucerna::pbrt {
namespace {

/// A width at one end of a curve, in the shape's own space.
double width(const ShapeDirective& shape, const char* name, double otherwise) {
  const double width = shape.params.number(name, otherwise);
  if (!(width >= 0))
    fail(shape.params.place_of({name, "width"}),
         fmt::format("\"float {}\" = {} m, allowed: at least 0", name, width));
  return width;
}

/// The factor from a length in the shape's own space to metres.  Adds a remark if there is no
/// single one.
double scale_of_widths(LoadState& context, const ShapeDirective& shape) {
  const Transform& t = shape.world_from_object;
  const Vec3 x = t.vector({1, 0, 0}), y = t.vector({0, 1, 0}), z = t.vector({0, 0, 1});
  const double scale = std::cbrt(std::fabs(dot(cross(x, y), z)));
  constexpr double kRounded = 1e-6;
  const double s2 = kRounded * scale * scale;
  const auto differs = [&](const Vec3& v) { return std::fabs(dot(v, v) - scale * scale) > s2; };
  if (differs(x) || differs(y) || differs(z) || std::fabs(dot(x, y)) > s2 ||
      std::fabs(dot(y, z)) > s2 || std::fabs(dot(z, x)) > s2)
    context.remark(shape.place(), "a transform that deforms the cross-section of a curve",
                   "the width is multiplied by the mean scale");
  return scale;
}

}  // namespace

CurveData make_curve(LoadState& context, const ShapeDirective& shape) {
  shape.params.ignore({"splitdepth"});
  const auto one_of = [&](const char* name, const std::string& otherwise,
                          std::initializer_list<const char*> allowed) {
    const std::string value = shape.params.string(name, otherwise);
    std::string list;
    for (const char* a : allowed) {
      if (value == a) return value;
      list += fmt::format("{}\"{}\"", list.empty() ? "" : ", ", a);
    }
    fail(shape.params.place_of({name}),
         fmt::format("\"string {}\" = \"{}\", allowed: {}", name, printable(value), list));
  };
  const std::string type = one_of("type", "flat", {"flat", "cylinder", "ribbon"});
  CurveData curves;
  curves.kind = type == "flat"       ? CurveKind::kFlat
                : type == "cylinder" ? CurveKind::kCylinder
                                     : CurveKind::kRibbon;
  curves.is_b_spline = one_of("basis", "bezier", {"bezier", "bspline"}) == "bspline";
  curves.degree = shape.params.integer("degree", 3);
  if (curves.degree != 2 && curves.degree != 3)
    fail(shape.params.place_of({"degree"}),
         fmt::format("\"integer degree\" = {}, allowed: 2 or 3", curves.degree));
  const double scale = scale_of_widths(context, shape);
  const double both = width(shape, "width", 1);
  curves.start_width_m = width(shape, "width0", both) * scale;
  curves.end_width_m = width(shape, "width1", both) * scale;
  curves.points = world_positions(shape, shape.params.take_vectors("P", "point3"));
  const std::vector<Vec3> normals = shape.params.take_vectors("N", "normal");
  const FilePosition normals_place = shape.params.place_of({"N"});
  if (type != "ribbon") {
    if (!normals.empty())
      context.remark(normals_place, "\"normal N\" of a curve that is no ribbon", "not used");
  } else {
    if (normals.empty()) fail(shape.place(), "a ribbon lacks \"normal N\"");
    const bool turned = shape.reverse_orientation != shape.world_from_object.swaps_handedness();
    for (const Vec3& n : normals) {
      const Vec3 unit = normalized(shape.world_from_object.normal(n));
      if (!is_finite(unit) || max_abs(unit) == 0)
        fail(normals_place, "a normal of a ribbon has no direction");
      curves.normals.push_back(turned ? -unit : unit);
    }
  }
  if (const absl::Status status = check_curves(curves); !status.ok())
    fail(shape.params.place_of({"P"}), status);
  return curves;
}

}  // namespace lucerna::pbrt
