#include "client/cli/bench_questions.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <random>

#include "client/library/points.h"
#include "lucerna/v1/admin.pb.h"
#include "lucerna/v1/lighting.pb.h"
#include "lucerna/v1/render.pb.h"

namespace lucerna::bench {
namespace {

using client::Double3;

// Different requests, so that no cache of the server or of the processor has the answer.
constexpr std::uint32_t kRequests = 16;
// Requests of all sizes together stay far below the memory of a client.
constexpr std::uint64_t kMostItems = 1 << 19;

/// Points and directions inside of a sphere.
class RandomPlaces {
 public:
  RandomPlaces(const v1::SceneSummary& scene, std::uint64_t seed)
      : center_{scene.center_m().x(), scene.center_m().y(), scene.center_m().z()},
        // A scene without surfaces has no size.
        radius_(scene.radius_m() > 0 ? scene.radius_m() : 1),
        random_(seed) {}

  double number() { return uniform_(random_); }
  std::uint64_t seed() { return random_(); }

  /// A vector in the unit ball, not zero.
  Double3 in_ball() {
    for (;;) {
      const Double3 v = {2 * number() - 1, 2 * number() - 1, 2 * number() - 1};
      const double square = v[0] * v[0] + v[1] * v[1] + v[2] * v[2];
      if (square <= 1 && square > 1e-6) return v;
    }
  }
  Double3 point() { return place(in_ball()); }

  std::vector<Double3> points(std::uint32_t n) {
    std::vector<Double3> result(n);
    std::ranges::generate(result, [&] { return point(); });
    return result;
  }
  std::vector<Double3> directions(std::uint32_t n) {
    std::vector<Double3> result(n);
    std::ranges::generate(result, [&] { return in_ball(); });
    return result;
  }
  /// The points of a square grid across the middle of the sphere, row by row.  `height` is in [-1,
  /// 1].
  std::vector<Double3> grid(std::uint32_t n, double height) const {
    const auto side = static_cast<std::uint32_t>(std::ceil(std::sqrt(static_cast<double>(n))));
    std::vector<Double3> result(n);
    for (std::uint32_t i = 0; i < n; ++i)
      result[i] =
          place({(2.0 * (i % side) + 1) / side - 1, (2.0 * (i / side) + 1) / side - 1, height});
    return result;
  }

 private:
  Double3 place(const Double3& v) const {
    return {center_[0] + radius_ * v[0], center_[1] + radius_ * v[1], center_[2] + radius_ * v[2]};
  }

  Double3 center_;
  double radius_;
  std::mt19937_64 random_;
  std::uniform_real_distribution<double> uniform_{0, 1};
};

class Maker {
 public:
  Maker(std::uint32_t batch, const QuestionOptions& options)
      : batch_(batch), options_(options), places_(options.scene, options.seed) {}

  std::string visibility() {
    v1::TestVisibilityRequest request;
    request.set_scene_id(options_.scene.scene_id());
    v1::Segments& segments = *request.mutable_segments();
    if (options_.coherent) {
      // As a camera looks: all segments begin at one point.
      *segments.mutable_from() = client::make_points(std::vector<Double3>(batch_, places_.point()));
      *segments.mutable_to() = client::make_points(places_.grid(batch_, 2 * places_.number() - 1));
    } else {
      *segments.mutable_from() = client::make_points(places_.points(batch_));
      *segments.mutable_to() = client::make_points(places_.points(batch_));
    }
    return request.SerializeAsString();
  }

  std::string irradiance() {
    v1::EstimateIrradianceRequest request;
    put_receivers(request);
    client::fill(options_.coherent ? std::vector<Double3>(batch_, places_.in_ball())
                                   : places_.directions(batch_),
                 request.mutable_normals());
    if (options_.bounces) request.set_bounces(*options_.bounces);
    return request.SerializeAsString();
  }

  std::string samples() {
    v1::SampleLiRequest request;
    put_receivers(request);
    options_.light.put(request);
    return request.SerializeAsString();
  }

  std::string emission() {
    v1::SampleLeRequest request;
    request.set_scene_id(options_.scene.scene_id());
    request.set_count(batch_);
    request.mutable_seed()->set_seed(places_.seed());
    options_.light.put(request);
    return request.SerializeAsString();
  }

  std::string power() {
    v1::EstimatePowerRequest request;
    request.set_scene_id(options_.scene.scene_id());
    const std::vector<std::uint64_t>& ids = options_.light_ids;
    const std::size_t first = places_.seed() % ids.size();
    for (std::uint32_t i = 0; i < batch_; ++i) request.add_light_ids(ids[(first + i) % ids.size()]);
    return request.SerializeAsString();
  }

  std::string tile() {
    v1::RenderTileRequest request;
    request.set_scene_id(options_.scene.scene_id());
    request.set_seed(places_.seed());
    const auto [width, height] = tile_size();
    const auto put = [&](std::uint32_t size, std::uint32_t whole) {
      return static_cast<std::uint32_t>(places_.number() * (whole - size + 1));
    };
    v1::PixelRect& rect = *request.mutable_rect();
    rect.set_x0(put(width, options_.scene.image_width()));
    rect.set_y0(put(height, options_.scene.image_height()));
    rect.set_x1(rect.x0() + width);
    rect.set_y1(rect.y0() + height);
    if (options_.bounces) request.set_bounces(*options_.bounces);
    if (options_.samples) request.mutable_accuracy()->set_samples(*options_.samples);
    return request.SerializeAsString();
  }

  std::pair<std::uint32_t, std::uint32_t> tile_size() const {
    const auto side = static_cast<std::uint32_t>(std::sqrt(static_cast<double>(batch_)));
    return {std::min(side, options_.scene.image_width()),
            std::min(side, options_.scene.image_height())};
  }

 private:
  template <class Request>
  void put_receivers(Request& request) {
    request.set_scene_id(options_.scene.scene_id());
    *request.mutable_receivers() =
        client::make_points(options_.coherent ? places_.grid(batch_, 2 * places_.number() - 1)
                                              : places_.points(batch_));
    request.mutable_seed()->set_seed(places_.seed());
    if (options_.samples) request.mutable_accuracy()->set_samples(*options_.samples);
  }

  std::uint32_t batch_;
  const QuestionOptions& options_;
  RandomPlaces places_;
};

template <class Response>
absl::StatusOr<Answer> read(const std::string& bytes) {
  Response response;
  if (!response.ParseFromString(bytes)) {
    return absl::InternalError(
        fmt::format("the answer is not a {}", Response::descriptor()->full_name()));
  }
  Answer answer;
  if constexpr (requires { response.cost(); }) {
    const v1::Cost& cost = response.cost();
    answer = {.samples = cost.samples(),
              .rays = cost.camera_rays() + cost.indirect_rays() + cost.shadow_rays()};
  }
  return answer;
}

}  // namespace

absl::StatusOr<Requests> make_requests(Question question, std::uint32_t batch,
                                       const QuestionOptions& options) {
  if (question == Question::kPower && batch > options.light_ids.size()) {
    return absl::InvalidArgumentError(
        fmt::format("--batch: {} lights, but the scene has {}", batch, options.light_ids.size()));
  }
  Maker maker(batch, options);
  Requests requests{.method = {}, .bytes = {}, .items = batch};
  const auto fill = [&](const char* method, std::string (Maker::*make)()) {
    requests.method = method;
    const std::uint64_t count = std::clamp<std::uint64_t>(kMostItems / batch, 1, kRequests);
    for (std::uint64_t i = 0; i < count; ++i) requests.bytes.push_back((maker.*make)());
  };
  switch (question) {
    case Question::kVisibility:
      fill("/lucerna.v1.LightingService/TestVisibility", &Maker::visibility);
      break;
    case Question::kIrradiance:
      fill("/lucerna.v1.LightingService/EstimateIrradiance", &Maker::irradiance);
      break;
    case Question::kSamples:
      fill("/lucerna.v1.LightingService/SampleLi", &Maker::samples);
      break;
    case Question::kEmission:
      fill("/lucerna.v1.LightingService/SampleLe", &Maker::emission);
      break;
    case Question::kPower:
      fill("/lucerna.v1.LightingService/EstimatePower", &Maker::power);
      break;
    case Question::kTile: {
      fill("/lucerna.v1.RenderService/RenderTile", &Maker::tile);
      const auto [width, height] = maker.tile_size();
      requests.items = std::uint64_t{width} * height;
      break;
    }
    case Question::kEmpty:
      requests = {.method = "/lucerna.v1.AdminService/GetServerInfo", .bytes = {""}, .items = 0};
      break;
  }
  return requests;
}

absl::StatusOr<Answer> read_answer(Question question, const std::string& bytes) {
  switch (question) {
    case Question::kVisibility:
      return read<v1::TestVisibilityResponse>(bytes);
    case Question::kIrradiance:
      return read<v1::EstimateIrradianceResponse>(bytes);
    case Question::kSamples:
      return read<v1::SampleLiResponse>(bytes);
    case Question::kEmission:
      return read<v1::SampleLeResponse>(bytes);
    case Question::kPower:
      return read<v1::EstimatePowerResponse>(bytes);
    case Question::kTile:
      return read<v1::RenderTileResponse>(bytes);
    case Question::kEmpty:
      return read<v1::GetServerInfoResponse>(bytes);
  }
  return absl::InternalError("unknown question");
}

}  // namespace lucerna::bench
