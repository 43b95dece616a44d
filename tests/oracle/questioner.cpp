#include "tests/oracle/questioner.h"

#include <fmt/format.h>

#include <fstream>

#include "tests/oracle/oracle_lights.h"
#include "tests/oracle/oracle_shapes.h"
#include "tests/oracle/wire_parts.h"

namespace lucerna::testing {

grpc::Status Questioner::load(const oracle::World& world) {
  for (const auto& [name, bytes] : pbrt_files(world))
    std::ofstream(folder_ / name, std::ios::binary) << bytes;
  return load(pbrt_text(world));
}

grpc::Status Questioner::load(const std::string& text) {
  std::ofstream(folder_ / "scene.pbrt") << text;
  v1::LoadSceneRequest q;
  q.set_path("scene.pbrt");
  v1::LoadSceneResponse r;
  const grpc::Status s = call(q, &r);
  id_ = r.scene_id();
  return s;
}

void Questioner::release() {
  if (id_.empty()) return;  // the server refused the scene
  auto q = about<v1::ReleaseSceneRequest>(id_);
  v1::ReleaseSceneResponse r;
  const std::uint64_t before = repeats_;
  const grpc::Status s = call(q, &r);
  // A call that is sent again may find its work done.
  EXPECT_TRUE(s.ok() || (repeats_ > before && s.error_code() == grpc::StatusCode::NOT_FOUND))
      << s.error_message();
  id_.clear();
}

Verdict Questioner::judge(const Truth& truth, const Question& question) {
  switch (question.kind) {
    case Question::Kind::kVisibility:
      return visibility(truth, question);
    case Question::Kind::kIlluminance:
      return illuminance(truth, question);
    case Question::Kind::kTarget:
      return target(truth, question);
    case Question::Kind::kSolid:
      return solid(truth, question);
    case Question::Kind::kPower:
      return power(truth, question);
    case Question::Kind::kRays:
      return rays(truth, question);
    case Question::Kind::kDelta:
      return delta(truth, question);
    case Question::Kind::kSamples:
      return samples(truth, question);
    case Question::Kind::kDensity:
      return density(truth, question);
    case Question::Kind::kLe:
      return le(truth, question);
  }
  return {};
}

Verdict Questioner::visibility(const Truth& truth, const Question& question) {
  const Way way = truth.way(question.from, question.to);
  if (way == Way::kUnsure) return {};
  auto q = about<v1::TestVisibilityRequest>(id_);
  q.set_time_s(static_cast<double>(truth.world().time));
  set_point(question.from, q.mutable_segments()->mutable_from());
  set_point(question.to, q.mutable_segments()->mutable_to());
  if (length(question.from.normal) > 0) add_normal(question.from, q.mutable_normals());
  v1::TestVisibilityResponse r;
  const grpc::Status s = call(q, &r);
  if (!s.ok()) return {Kind::kWrong, s.error_message()};
  if (r.status_size() > 0 && r.status(0) == v1::ITEM_STATUS_OUT_OF_RANGE) return {Kind::kNoAnswer};
  const bool visible = (r.visible()[0] & 1) != 0;
  return verdict_of(visible == (way == Way::kFree),
                    fmt::format("from {}\nto {}\nvisible: the server says {}", shown(question.from),
                                shown(question.to), visible));
}

grpc::Status Questioner::irradiance(const Place& at, v1::EstimateIrradianceRequest q,
                                    v1::EstimateIrradianceResponse* r) {
  q.set_scene_id(id_);
  set_point(at, q.mutable_receivers());
  add_normal(at, q.mutable_normals());
  return call(q, r);
}

grpc::Status Questioner::direct(const Truth& truth, const Place& at,
                                v1::EstimateIrradianceRequest q,
                                v1::EstimateIrradianceResponse* r) {
  q.set_time_s(static_cast<double>(truth.world().time));
  q.set_bounces(0);
  return irradiance(at, std::move(q), r);
}

Verdict Questioner::compare(const Amount& amount, const v1::EstimateIrradianceResponse& r,
                            const Place& at) {
  if (r.status_size() > 0 && r.status(0) == v1::ITEM_STATUS_OUT_OF_RANGE) return {Kind::kNoAnswer};
  const Real slack = amount.bound + 1e-6L * amount.value;
  const bool exact = r.standard_error_lx(0) == 0 && r.lower_lx(0) == r.upper_lx(0);
  const bool holds = r.lower_lx(0) <= amount.value + slack && r.upper_lx(0) >= amount.value - slack;
  const std::string text =
      fmt::format("at {}\nilluminance: the server says {} from {} to {} lx, right is {} lx",
                  shown(at), r.illuminance_lx(0), r.lower_lx(0), r.upper_lx(0), shown(amount));
  // An answer of 0 must be exact or have an upper bound.
  const bool has_bound = r.illuminance_lx(0) > 0 || r.zero_bound_lx(0) == r.upper_lx(0);
  if (exact || !has_bound) return verdict_of(holds && has_bound, text);
  return {holds ? Kind::kHolds : Kind::kMisses, text};
}

Verdict Questioner::illuminance(const Truth& truth, const Question& question) {
  const Amount amount = truth.illuminance(question.from);
  if (!amount.sure) return {};
  v1::EstimateIrradianceResponse r;
  const grpc::Status s = direct(truth, question.from, {}, &r);
  if (!s.ok()) return {Kind::kWrong, s.error_message()};
  return compare(amount, r, question.from);
}

Verdict Questioner::target(const Truth& truth, const Question& question) {
  constexpr double kTarget = 0.05;
  const Amount amount = truth.illuminance(question.from);
  if (!amount.sure) return {};
  v1::EstimateIrradianceRequest q;
  q.mutable_accuracy()->mutable_target_error()->set_relative(kTarget);
  q.mutable_accuracy()->mutable_target_error()->set_max_samples(2048);
  v1::EstimateIrradianceResponse r;
  const grpc::Status s = direct(truth, question.from, q, &r);
  if (!s.ok()) return {Kind::kWrong, s.error_message()};
  Verdict verdict = compare(amount, r, question.from);
  const Real value = r.illuminance_lx(0);
  const bool reached = (r.upper_lx(0) - r.lower_lx(0)) / 2 <= kTarget * value;
  const bool is_within = std::fabs(value - amount.value) <= kTarget * value + amount.bound;
  if (verdict.kind == Kind::kHolds && reached && !is_within) verdict.kind = Kind::kMisses;
  return verdict;
}

Verdict Questioner::solid(const Truth& truth, const Question& question) {
  const Vec& at = question.from.at;
  const oracle::World& world = truth.world();
  if (question.from.on >= 0) return {Kind::kNoAnswer};
  const auto inside = [](const oracle::Shape& sphere, const Vec& p, Real share) {
    return length(p - sphere.at[0]) < share * sphere.radius;
  };
  for (const oracle::Shape& shape : world.shapes) {
    if (shape.kind != oracle::ShapeKind::kSphere || shape.radiance > 0) continue;
    if (!inside(shape, at, 0.9L)) continue;
    bool has_light = false;
    for (const oracle::Light& light : world.lights) {
      has_light |= inside(shape, light.at, 1.1L);
      // A beam begins at a rectangle.
      has_light |= light.kind == oracle::LightKind::kBeam &&
                   std::fabs(dot(light.axes[2], shape.at[0] - light.at)) < 1.1L * shape.radius;
    }
    if (has_light || !emitting_shapes(world).empty()) return {Kind::kNoAnswer};
    v1::EstimateIrradianceResponse r;
    const grpc::Status s = direct(truth, question.from, {}, &r);
    if (!s.ok()) return {Kind::kWrong, s.error_message()};
    const auto status = r.status_size() == 0 ? v1::ITEM_STATUS_OK : r.status(0);
    if (status == v1::ITEM_STATUS_OUT_OF_RANGE) return {Kind::kNoAnswer};
    // A point on a surface is not inside of a solid.
    for (std::size_t i = 0; i < world.shapes.size(); ++i)
      if (truth.may_lie_on(world.shapes[i], question.from)) return {Kind::kNoAnswer};
    return verdict_of(status == v1::ITEM_STATUS_INSIDE_SOLID,
                      fmt::format("inside of a sphere at {}: the server gives status {}",
                                  shown(question.from), static_cast<int>(status)));
  }
  return {Kind::kNoAnswer};
}

Verdict Questioner::power(const Truth& truth, const Question& question) {
  const auto amount = truth.power(question.source);
  if (!amount || !amount->sure) return {amount ? Kind::kUnsure : Kind::kNoAnswer};
  auto q = about<v1::EstimatePowerRequest>(id_);
  q.add_light_ids(static_cast<std::uint64_t>(question.source) + 1);
  v1::EstimatePowerResponse r;
  const grpc::Status s = call(q, &r);
  if (!s.ok()) return {Kind::kWrong, s.error_message()};
  const auto& light = r.lights(0);
  const Real slack = amount->bound + light.error_lm() + 1e-6L * amount->value;
  return verdict_of(
      std::fabs(light.power_lm() - amount->value) <= slack,
      fmt::format("power of light {}: the server says {} +- {} lm, right is {} lm",
                  question.source + 1, light.power_lm(), light.error_lm(), shown(*amount)));
}

v1::SampleLiResponse Questioner::sample(const Truth& truth, const Question& question,
                                        std::uint32_t samples, v1::AreaSampling sampling) {
  auto q = about<v1::SampleLiRequest>(id_);
  q.set_time_s(static_cast<double>(truth.world().time));
  q.set_light_id(static_cast<std::uint64_t>(question.source) + 1);
  set_point(question.from, q.mutable_receivers());
  add_normal(question.from, q.mutable_normals());
  q.set_test_visibility(true);
  q.mutable_accuracy()->set_samples(samples);
  q.mutable_accuracy()->set_area_sampling(sampling);
  q.mutable_accuracy()->set_sampler(v1::SAMPLER_INDEPENDENT);
  v1::SampleLiResponse r;
  const grpc::Status s = call(q, &r);
  EXPECT_TRUE(s.ok()) << s.error_message();
  return r;
}

Verdict Questioner::delta(const Truth& truth, const Question& question) {
  const auto& light = truth.world().lights[static_cast<std::size_t>(question.source)];
  const Vec& at = question.from.at;
  const auto a = arrival(light, at, truth.reach(at));
  if (!a) return {Kind::kNoAnswer};
  const Vec d = a->end.at - at;
  const Real distance = length(d);
  const Real slant =
      (a->end.far ? 0 : length(truth.rounding(at) + truth.rounding(a->end.at)) / distance) +
      0x1p-22L;
  if (!(slant < 1e-3L)) return {};
  Real change = 0;
  const Vec u = oracle::across(d * (1 / distance)), v = cross(d * (1 / distance), u);
  for (const Vec& side : {u, -u, v, -v}) {
    const auto there = arrival(light, at + side * (distance * slant), truth.reach(at));
    change = std::fmax(change, std::fabs(there->facing - a->facing));
  }
  if (change > 0.01L * a->facing) return {};
  const v1::SampleLiResponse r = sample(truth, question, 1, v1::AREA_SAMPLING_UNSPECIFIED);
  if (r.value_size() != 3) return {Kind::kWrong, "no sample"};
  const bool ok = r.status_size() == 0 || r.status(0) == v1::ITEM_STATUS_OK;
  if (!ok && r.status(0) == v1::ITEM_STATUS_OUT_OF_RANGE) return {Kind::kNoAnswer};
  const Real value = r.value(0), slack = change + a->facing * (4 * slant + 1e-6L);
  const std::string text = fmt::format(
      "light {} at {}\nsample: the server says {} lx from {}, visible {}, right is {} lx from {}",
      question.source + 1, shown(question.from), static_cast<double>(value),
      shown(vec_of(r.wi(), 0)), (r.visible()[0] & 1) != 0, static_cast<double>(a->facing),
      shown(d * (1 / distance)));
  // Numbers below the smallest normal float are 0.
  if (a->facing > 0 && a->facing < 1e-36L) return {Kind::kNoAnswer};
  if (std::fabs(value - a->facing) > slack) return {Kind::kWrong, text};
  if (a->facing == 0) return {Kind::kAgrees};
  if (length(vec_of(r.wi(), 0) - d * (1 / distance)) > 4 * slant) return {Kind::kWrong, text};
  const Way way = truth.way(question.from, a->end);
  if (way == Way::kUnsure) return {Kind::kAgrees};
  return verdict_of(((r.visible()[0] & 1) != 0) == (way == Way::kFree), text);
}

Verdict Questioner::samples(const Truth& truth, const Question& question) {
  const std::size_t number =
      static_cast<std::size_t>(question.source) - truth.world().lights.size();
  const int shape_number = emitting_shapes(truth.world())[number];
  const oracle::Shape& shape = truth.world().shapes[static_cast<std::size_t>(shape_number)];
  // Points of patches and of pictures are not uniform by area.
  if (shape.kind == oracle::ShapeKind::kPatch || !shape.picture.empty()) return {Kind::kNoAnswer};
  const Place& from = question.from;
  const v1::SampleLiResponse r = sample(truth, question, 16, v1::AREA_SAMPLING_SQUARE_ROOT);
  const Real at_ends = length(truth.rounding(shape)) + length(truth.rounding(from.at));
  bool compared = false;
  for (int i = 0; i < r.pdf_per_sr_size(); ++i) {
    const auto status = r.status_size() == 0 ? v1::ITEM_STATUS_OK : r.status(i);
    if (status == v1::ITEM_STATUS_OUT_OF_RANGE) continue;
    const Vec way = vec_of(r.light_offsets_m(), i), given = vec_of(r.light_normals(), i);
    const Real distance = length(way);
    if (!(distance > 0)) continue;
    const Vec w = way * (1 / distance);
    const oracle::SurfacePoint p = nearest_point(shape, from.at + way);
    const Real error = at_ends + 0x1p-22L * distance;
    const Real curved = is_flat(shape) ? 0 : error / shape.radius;
    const Real cosine = -dot(p.normal, w);
    const Real of_cosine = error / distance + curved + 0x1p-22L;
    if (std::fabs(cosine) < 100 * of_cosine) continue;
    const bool lit = shape.two_sided || cosine > 0;
    const std::string text = fmt::format(
        "light {} at {}\nsample {}: the server gives status {}, point {} from the receiver, normal "
        "{}, value {}, density {}, visible {}\nright is normal {}, value {}, density {}",
        question.source + 1, shown(from), i, static_cast<int>(status), shown(way), shown(given),
        r.value(3 * i), r.pdf_per_sr(i), (r.visible()[i / 8] >> i % 8 & 1) != 0, shown(p.normal),
        static_cast<double>(lit ? shape.radiance : 0),
        static_cast<double>(distance * distance / (area_of(shape).first * std::fabs(cosine))));
    if (length(p.at - from.at - way) > 8 * error) return {Kind::kWrong, text};
    if ((status == v1::ITEM_STATUS_OK) != lit) return {Kind::kWrong, text};
    compared = true;
    if (!lit) continue;
    const Real side = shape.two_sided && dot(given, p.normal) < 0 ? -1 : 1;
    if (length(given * side - p.normal) > 8 * curved + 1e-5L + error / shape_size(shape))
      return {Kind::kWrong, text};
    if (std::fabs(r.value(3 * i) - shape.radiance) > 1e-6L * shape.radiance)
      return {Kind::kWrong, text};
    const Real by_area = r.pdf_per_sr(i) * area_of(shape).first * std::fabs(cosine);
    const Real off = std::fabs(by_area / (distance * distance) - 1);
    if (off > 1e-5L + 4 * error / distance + 2 * of_cosine / std::fabs(cosine) +
                  8 * at_ends / shape_size(shape))
      return {Kind::kWrong, text};
    // Rays end beside the light, within the error of rays that meet it.
    const Vec beside = p.normal * (16 * length(truth.rounding(p.at)) / 4 + 0x1p-19L * distance);
    Way free = truth.way(from, Place{.at = p.at, .on = shape_number, .asked = true});
    for (const Vec& end : {p.at + beside, p.at - beside})
      if (truth.way(from, Place{.at = end, .on = shape_number, .asked = true}) != free)
        free = Way::kUnsure;
    const bool visible = (r.visible()[i / 8] >> i % 8 & 1) != 0;
    if (free != Way::kUnsure && visible != (free == Way::kFree)) return {Kind::kWrong, text};
  }
  return {compared ? Kind::kAgrees : Kind::kNoAnswer};
}

Verdict Questioner::density(const Truth& truth, const Question& question) {
  const std::size_t number =
      static_cast<std::size_t>(question.source) - truth.world().lights.size();
  const int shape = emitting_shapes(truth.world())[number];
  // Black parts of a picture have no samples.
  if (!truth.world().shapes[static_cast<std::size_t>(shape)].picture.empty())
    return {Kind::kNoAnswer};
  const Amount omega = truth.solid_angle(shape, question.from);
  if (!omega.sure) return {};
  const std::uint32_t samples = 256;
  const v1::SampleLiResponse r = sample(truth, question, samples, v1::AREA_SAMPLING_UNSPECIFIED);
  Real sum = 0, squares = 0;
  for (int i = 0; i < static_cast<int>(samples); ++i) {
    const bool ok = r.status_size() == 0 || r.status(i) == v1::ITEM_STATUS_OK;
    if (r.status_size() > 0 && r.status(i) == v1::ITEM_STATUS_OUT_OF_RANGE)
      return {Kind::kNoAnswer};
    const Real x = ok ? 1 / static_cast<Real>(r.pdf_per_sr(i)) : 0;
    sum += x;
    squares += x * x;
  }
  const Real mean = sum / samples;
  const Real error = std::sqrt(std::fmax(0, squares / samples - mean * mean) / (samples - 1));
  const std::string text =
      fmt::format("light {} at {}\nmean of 1/density: the server gives {} +- {} sr, right is {} sr",
                  question.source + 1, shown(question.from), static_cast<double>(mean),
                  static_cast<double>(error), shown(omega));
  const Real off = std::fabs(mean - omega.value), slack = omega.bound + 1e-5L * omega.value;
  if (mean > 0 && error <= 1e-5L * mean) return verdict_of(off <= slack, text);
  // If no sample found the light, it is a rare one at most.
  if (mean == 0) return {omega.value > 0 ? Kind::kMisses : Kind::kHolds, text};
  // The mean of few samples is not normally distributed.
  constexpr Real kFewest = 64, kDeviations = 2.6L;
  if (sum * sum < kFewest * squares) return {Kind::kNoAnswer};
  return {off <= slack + kDeviations * error ? Kind::kHolds : Kind::kMisses, text};
}

}  // namespace lucerna::testing
