// Questions about rays that leave lights, and about rays that meet them.
#include <fmt/format.h>

#include "tests/oracle/numbers.h"
#include "tests/oracle/oracle_shapes.h"
#include "tests/oracle/wire_parts.h"

namespace lucerna::testing {
namespace {

/// The shape of a source, or null.
const oracle::Shape* shape_of(const oracle::World& world, int source) {
  const int lights = static_cast<int>(world.lights.size());
  if (source < lights) return nullptr;
  const auto number = static_cast<std::size_t>(source - lights);
  return &world.shapes[static_cast<std::size_t>(emitting_shapes(world)[number])];
}

}  // namespace

/// Whether rounding may move the point of a shape with a picture to another texel.
bool is_between_texels(const Truth& truth, const oracle::Shape& shape, const Vec& p) {
  if (shape.picture.empty()) return false;
  const Vec u = shape.at[1] - shape.at[0], v = shape.at[2] - shape.at[0], w = p - shape.at[0];
  const Vec n = cross(u, v);
  const Real error = 8 * (length(truth.rounding(shape)) + length(truth.rounding(p)));
  const auto near_edge = [&](Real at, Real error_of_at, int texels) {
    return std::fabs(at * texels - std::rint(at * texels)) <= error_of_at * texels;
  };
  const Real area = length(n), s = dot(cross(w, v), n) / (area * area),
             t = dot(cross(u, w), n) / (area * area);
  return near_edge(s, error * length(v) / area, shape.picture.width) ||
         near_edge(t, error * length(u) / area, shape.picture.height);
}

/// Whether PdfLe returns the densities that SampleLe reported.
bool Questioner::has_densities(const Truth& truth, const Question& question,
                               const v1::SampleLeResponse& rays, std::string& text) {
  auto q = about<v1::PdfLeRequest>(id_);
  q.set_time_s(static_cast<double>(truth.world().time));
  q.set_light_id(static_cast<std::uint64_t>(question.source) + 1);
  *q.mutable_points() = rays.points();
  *q.mutable_directions() = rays.directions();
  v1::PdfLeResponse r;
  const oracle::Shape* shape = shape_of(truth.world(), question.source);
  const grpc::Status s = call(q, &r);
  if (!s.ok()) {
    text = s.error_message();
    return false;
  }
  for (int i = 0; i < rays.pdf_direction_per_sr_size(); ++i) {
    if (rays.status_size() > 0 && rays.status(i) != v1::ITEM_STATUS_OK) continue;
    const auto agree = [](float a, float b) { return std::fabs(a - b) <= 1e-4F * std::fabs(a); };
    if (agree(rays.pdf_direction_per_sr(i), r.pdf_direction_per_sr(i)) &&
        agree(rays.pdf_position_per_m2(i), r.pdf_position_per_m2(i)))
      continue;
    const auto& origin = rays.points().origin_m();
    const Vec p = vec_of(rays.points().offsets_m(), i) + Vec{origin.x(), origin.y(), origin.z()};
    if (shape != nullptr && is_between_texels(truth, *shape, p)) continue;
    text = fmt::format(
        "light {}, ray {} from {} towards {}: SampleLe has the densities {} and {}, "
        "PdfLe {} and {}",
        question.source + 1, i, shown(vec_of(rays.points().offsets_m(), i)),
        shown(vec_of(rays.directions(), i)), rays.pdf_position_per_m2(i),
        rays.pdf_direction_per_sr(i), r.pdf_position_per_m2(i), r.pdf_direction_per_sr(i));
    return false;
  }
  return true;
}

Verdict Questioner::rays(const Truth& truth, const Question& question) {
  const auto amount = truth.power(question.source);
  if (!amount || !amount->sure) return {amount ? Kind::kUnsure : Kind::kNoAnswer};
  constexpr int kRays = 128;
  auto q = about<v1::SampleLeRequest>(id_);
  q.set_time_s(static_cast<double>(truth.world().time));
  q.set_light_id(static_cast<std::uint64_t>(question.source) + 1);
  q.set_count(kRays);
  q.mutable_seed()->set_seed(1);
  q.mutable_accuracy()->set_sampler(v1::SAMPLER_INDEPENDENT);
  v1::SampleLeResponse r;
  const grpc::Status s = call(q, &r);
  if (!s.ok()) return {Kind::kWrong, s.error_message()};
  const oracle::Shape* shape = shape_of(truth.world(), question.source);
  const auto& origin = r.points().origin_m();
  Real sum = 0, squares = 0;
  for (int i = 0; i < kRays; ++i) {
    const auto status = r.status_size() == 0 ? v1::ITEM_STATUS_OK : r.status(i);
    if (status == v1::ITEM_STATUS_OUT_OF_RANGE) return {Kind::kNoAnswer};
    if (status != v1::ITEM_STATUS_OK) continue;
    const Vec d = vec_of(r.directions(), i), n = vec_of(r.light_normals(), i);
    const Vec p = vec_of(r.points().offsets_m(), i) + Vec{origin.x(), origin.y(), origin.z()};
    Real x = r.value(3 * i + 1);
    if (dot(n, n) > 0) x *= std::fabs(dot(n, d));
    if (r.pdf_position_per_m2(i) > 0) x /= r.pdf_position_per_m2(i);
    if (r.pdf_direction_per_sr(i) > 0) x /= r.pdf_direction_per_sr(i);
    sum += x;
    squares += x * x;
    if (shape == nullptr || shape->kind == oracle::ShapeKind::kPatch) continue;
    const oracle::SurfacePoint own = nearest_point(*shape, p);
    const Real error = length(truth.rounding(*shape)) + length(truth.rounding(p)) +
                       0x1p-22L * length(vec_of(r.points().offsets_m(), i));
    const bool dark = !shape->two_sided && dot(own.normal, d) < -1e-5L - error / shape_size(*shape);
    if (length(own.at - p) > 8 * error || dark)
      return {Kind::kWrong, fmt::format("light {}: ray {} starts at {} towards {}, the nearest "
                                        "point of the light is {} with normal {}",
                                        question.source + 1, i, shown(p), shown(d), shown(own.at),
                                        shown(own.normal))};
  }
  std::string text;
  // Rounding may move a point to a black texel, or to a point of a curved light with another
  // normal.  The densities are then those before rounding.
  // A point of a beam's picture is as coarse.
  const oracle::Light* beam = nullptr;
  if (shape == nullptr) beam = &truth.world().lights[static_cast<std::size_t>(question.source)];
  if (beam != nullptr && beam->kind != oracle::LightKind::kBeam) beam = nullptr;
  const bool is_coarse_beam = beam != nullptr && !beam->picture.empty() &&
                              length(truth.rounding(beam->at)) > 1e-5L * beam->extent[0];
  const bool is_coarse =
      is_coarse_beam || (shape != nullptr && (!shape->picture.empty() || !is_flat(*shape)) &&
                         length(truth.rounding(shape->at[0])) > 1e-3L * shape_size(*shape));
  if (!is_coarse && !has_densities(truth, question, r, text)) return {Kind::kWrong, text};
  const Real mean = sum / kRays;
  const Real error = std::sqrt(std::fmax(0, squares / kRays - mean * mean) / (kRays - 1));
  text = fmt::format("rays of light {}: their flux is {} +- {} lm, right is {} lm",
                     question.source + 1, static_cast<double>(mean), static_cast<double>(error),
                     shown(*amount));
  const Real off = std::fabs(mean - amount->value);
  const Real slack = amount->bound + 1e-5L * amount->value;
  if (error <= 1e-5L * mean) return verdict_of(off <= slack, text);
  constexpr Real kFewest = 64, kDeviations = 2.6L;
  if (sum * sum < kFewest * squares) return {Kind::kNoAnswer};
  return {off <= slack + kDeviations * error ? Kind::kHolds : Kind::kMisses, text};
}

Verdict Questioner::le_of_portal(const Truth& truth, const Question& question) {
  const auto& portal = truth.world().lights[static_cast<std::size_t>(question.source)];
  Place from = question.from;
  from.normal = {};
  if (from.on >= 0) return {Kind::kNoAnswer};
  // In units of the sides: rays through the portal and beside it.
  constexpr std::array<std::pair<Real, Real>, 4> kPoints{
      {{0.37L, 0.61L}, {0.97L, 0.04L}, {1.03L, 0.61L}, {0.37L, -0.04L}}};
  auto q = about<v1::LeRequest>(id_);
  q.set_time_s(static_cast<double>(truth.world().time));
  q.set_light_id(static_cast<std::uint64_t>(question.source) + 1);
  std::array<Way, 4> free{};
  const Real error = length(truth.rounding(portal.at)) + length(truth.rounding(from.at));
  const Real narrow = std::fmin(portal.extent[0], portal.extent[1]);
  for (std::size_t i = 0; i < kPoints.size(); ++i) {
    const auto [s, t] = kPoints.at(i);
    const Vec way = portal.at + portal.axes[0] * (portal.extent[0] * s) +
                    portal.axes[1] * (portal.extent[1] * t) - from.at;
    const Real distance = length(way);
    const Vec d = floats(way * (1 / distance));
    const Real cosine = std::fabs(dot(portal.axes[2], way)) / distance;
    if (cosine < 0.02L || 4 * (error + 0x1p-22L * distance) / cosine > 0.01L * narrow)
      return {Kind::kNoAnswer};
    const Vec end = from.at + d * (truth.reach(from.at) / length(d));
    free.at(i) = truth.way(from, Place{.at = end, .far = true});
    if (i == 0)
      set_point(from, q.mutable_points());
    else
      for (int k = 0; k < 3; ++k) q.mutable_points()->add_offsets_m(0);
    for (const Real x : {d.x, d.y, d.z}) q.add_directions(static_cast<float>(x));
  }
  if (std::ranges::count(free, Way::kUnsure) > 0) return {};
  v1::LeResponse r;
  const grpc::Status sent = call(q, &r);
  if (!sent.ok()) return {Kind::kWrong, sent.error_message()};
  if (r.status_size() > 0 && r.status(0) == v1::ITEM_STATUS_OUT_OF_RANGE) return {Kind::kNoAnswer};
  const bool is_in_front = dot(portal.axes[2], from.at - portal.at) > 0;
  for (std::size_t i = 0; i < kPoints.size(); ++i) {
    const bool lit = is_in_front && i < 2 && free.at(i) == Way::kFree;
    const Real given = r.radiance_cd_m2(3 * static_cast<int>(i)), right = lit ? portal.level : 0;
    if (std::fabs(given - right) <= 1e-6L * right) continue;
    return {Kind::kWrong,
            fmt::format("from {}, ray {} to portal {}: the server says {} cd/m2, right is {} cd/m2",
                        shown(from), i, question.source + 1, static_cast<double>(given),
                        static_cast<double>(right))};
  }
  return {Kind::kAgrees};
}

Verdict Questioner::le(const Truth& truth, const Question& question) {
  if (question.source < static_cast<int>(truth.world().lights.size()))
    return le_of_portal(truth, question);
  const oracle::Shape& shape = *shape_of(truth.world(), question.source);
  if (!shape.picture.empty()) return {Kind::kNoAnswer};
  const int number = static_cast<int>(&shape - truth.world().shapes.data());
  // Queries of rays have no normal, and rays may start on the surface or behind it.
  Place from = question.from;
  from.normal = {};
  if (from.on >= 0) return {Kind::kNoAnswer};
  constexpr Real kS = 0.37L, kT = 0.61L;
  const oracle::SurfacePoint p = point_of(shape, kS, kT);
  const Vec way = p.at - from.at;
  const Real distance = length(way);
  const Vec direction{static_cast<float>(way.x / distance), static_cast<float>(way.y / distance),
                      static_cast<float>(way.z / distance)};
  // The rounded direction leads to a point that is a little off.
  const Real cosine = -dot(p.normal, way) / distance;
  const Real off =
      4 * (length(truth.rounding(shape)) + length(truth.rounding(from.at)) + 0x1p-22L * distance) /
      std::fabs(cosine);
  if (std::fabs(cosine) < 0.02L || off > 0.05L * shape_size(shape)) return {Kind::kNoAnswer};
  const Way free = truth.way(from, Place{.at = p.at, .on = number, .s = kS, .t = kT});
  if (free == Way::kUnsure) return {};
  if (free == Way::kBlocked && !is_flat(shape)) return {Kind::kNoAnswer};  // perhaps by itself
  auto q = about<v1::LeRequest>(id_);
  q.set_time_s(static_cast<double>(truth.world().time));
  set_point(from, q.mutable_points());
  for (const Real x : {direction.x, direction.y, direction.z})
    q.add_directions(static_cast<float>(x));
  v1::LeResponse r;
  const grpc::Status s = call(q, &r);
  if (!s.ok()) return {Kind::kWrong, s.error_message()};
  if (r.status_size() > 0 && r.status(0) == v1::ITEM_STATUS_OUT_OF_RANGE) return {Kind::kNoAnswer};
  const bool is_this = r.light_ids(0) == static_cast<std::uint64_t>(question.source) + 1;
  const Real right = shape.two_sided || cosine > 0 ? shape.radiance : 0;
  const bool same = std::fabs(r.radiance_cd_m2(1) - right) <= 1e-6L * right;
  const bool is_right = free == Way::kFree ? same && (is_this || right == 0) : !is_this;
  return verdict_of(is_right,
                    fmt::format("from {} towards {}: the server finds light {} with {} "
                                "cd/m2, right is {} of light {} with {} cd/m2",
                                shown(from), shown(direction), r.light_ids(0), r.radiance_cd_m2(1),
                                free == Way::kFree ? "that" : "another light than that",
                                question.source + 1, static_cast<double>(right)));
}

}  // namespace lucerna::testing
