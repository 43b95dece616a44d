// The questions of direct illuminance and of the visible share of the lights, from samples of
// light.  The caller adds up the samples.  With a target error, the server adds them up.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <utility>

#include "client/library/batch_parts.h"
#include "client/terminal/luminance.h"
#include "client/tradeoff/question.h"
#include "lucerna/client/batches.h"
#include "proto/common/status_macros.h"
#include "proto/common/stopwatch.h"

namespace lucerna::tradeoff {
namespace {

// An answer takes 70 bytes for each sample, all in memory.
constexpr std::uint32_t kMostLightSamples = 1 << 10;
constexpr double kMostAnswers = 1 << 20;
constexpr std::uint32_t kLeastMostSamples = 64;  // the least max_samples of TargetError

class SampleQuestion : public Question {
 public:
  SampleQuestion(const client::Client& client, const QuestionOptions& options, std::uint64_t lights,
                 bool visibility)
      : Question(options.call),
        client_(client),
        options_(options),
        lights_(lights),
        visibility_(visibility) {
    layout_.points = options.points;
    request_.set_scene_id(options.scene_id);
    *request_.mutable_receivers() = client::make_points(options.points);
    client::fill(options.normals, request_.mutable_normals());
    request_.set_test_visibility(true);
    for (const client::Double3& n : options.normals) {
      const double length = std::hypot(n[0], n[1], n[2]);
      unit_normals_.push_back({n[0] / length, n[1] / length, n[2] / length});
    }
  }

  Query query() const override { return visibility_ ? Query::kVisibility : Query::kSample; }
  std::string quantity() const override {
    return visibility_ ? "share of the lights that is visible" : "direct illuminance [lx]";
  }
  const Layout& layout() const override { return layout_; }
  std::vector<Setting> settings() const override {
    return tradeoff::settings(query(), {.lights = lights_});
  }
  std::vector<Amount> amounts_of(const Setting& setting) const override {
    return amounts(setting, std::max(1U, most_samples()));
  }
  absl::StatusOr<Answer> answer(const Setting& setting, const Amount& amount,
                                std::uint64_t seed) const override {
    v1::Accuracy accuracy = accuracy_of(setting, amount, dark_ * amount.value);
    if (by_area(setting)) accuracy.set_area_sampling(v1::AREA_SAMPLING_SQUARE_ROOT);
    if (amount.target)
      accuracy.mutable_target_error()->set_max_samples(std::max(kLeastMostSamples, most_samples()));
    return sampled(accuracy, seed);
  }

  std::vector<ReferenceWay> reference_ways() const override {
    if (!visibility_) return reference_ways_for(lights_);
    return {
        {"points on lights by area (parallelogram) from independent samples, each tested by "
         "TestVisibility: exact rays"}};
  }
  absl::StatusOr<Answer> answer_reference(std::size_t way, std::uint32_t samples,
                                          std::uint64_t seed) const override {
    return visibility_ ? seen(samples, seed) : estimated(way, samples, seed);
  }

  std::string command(const Setting& setting, const Amount& amount) const override {
    std::string rest = fmt::format(" --points {} --visible{}", shell_word(options_.points_file),
                                   join_flags(setting, amount));
    if (by_area(setting)) rest += " --area-sampling square-root";
    rest += floor_flag(amount, dark_);
    if (amount.target)
      rest += fmt::format(" --max-samples {}", std::max(kLeastMostSamples, most_samples()));
    return command_line(options_, "sample", rest) +
           for_which_server(amount, kServerBatch, "--max-batch-items");
  }

 private:
  /// The most samples of each point.  They are limited because all answers are in memory.
  std::uint32_t most_samples() const {
    const double most = kMostAnswers / static_cast<double>(layout_.points.size());
    return static_cast<std::uint32_t>(std::min<double>(most, kMostLightSamples));
  }
  /// Whether to choose points by area.  The visible shares of light samples estimate the same
  /// quantity only with points by area.
  bool by_area(const Setting& setting) const {
    return visibility_ && setting.accuracy.area_sampling() == v1::AREA_SAMPLING_UNSPECIFIED;
  }

  absl::StatusOr<v1::SampleLiResponse> samples_of_light(const v1::Accuracy& accuracy,
                                                        std::uint64_t seed, bool visibility) const {
    v1::SampleLiRequest request = request_;
    *request.mutable_accuracy() = accuracy;
    request.mutable_seed()->set_seed(seed);
    request.set_test_visibility(visibility);
    return client::sample_li_in_batches(client_, request, {.max_items = 0, .call = call()});
  }

  static bool ok(const v1::SampleLiResponse& r, int i) {
    return r.status().empty() || r.status(i) == v1::ITEM_STATUS_OK;
  }
  static double chosen_with(const v1::SampleLiResponse& r, int i) {
    return i < r.selection_probability_size() ? r.selection_probability(i) : 1;
  }

  /// The estimate of one light sample at receiver `point`.
  double value(const v1::SampleLiResponse& r, int i, std::size_t point) const {
    if (!ok(r, i) || !client::bit(r.visible(), i)) return 0;
    if (visibility_) return 1 / (chosen_with(r, i) * static_cast<double>(lights_));
    const client::Double3& n = unit_normals_[point];
    const double cosine = n[0] * r.wi(3 * i) + n[1] * r.wi(3 * i + 1) + n[2] * r.wi(3 * i + 2);
    const double density = client::bit(r.delta(), i) ? 1 : r.pdf_per_sr(i);
    std::array<float, 3> arriving{};
    for (int c = 0; c < 3; ++c) {
      const float share = r.transmittance().empty() ? 1 : r.transmittance(3 * i + c);
      arriving[static_cast<std::size_t>(c)] = r.value(3 * i + c) * share;
    }
    return cli::luminance(arriving.data()) * std::max(0.0, cosine) / (density * chosen_with(r, i));
  }

  absl::StatusOr<Answer> sampled(const v1::Accuracy& accuracy, std::uint64_t seed) const {
    const Stopwatch watch;
    LUCERNA_ASSIGN_OR_RETURN(const auto response, samples_of_light(accuracy, seed, true));
    const std::size_t points = layout_.points.size();
    Answer answer{.values = std::vector<double>(points)};
    if (response.has_estimates()) {
      const v1::ReceiverEstimates& e = response.estimates();
      for (int i = 0; i < e.illuminance_lx_size(); ++i) {
        const bool has = e.status().empty() || e.status(i) == v1::ITEM_STATUS_OK;
        answer.values[static_cast<std::size_t>(i)] =
            has ? double{e.illuminance_lx(i)} : std::numeric_limits<double>::quiet_NaN();
      }
    } else {
      const std::size_t each = static_cast<std::size_t>(response.pdf_per_sr_size()) / points;
      for (std::size_t k = 0; k < points * each; ++k) {
        answer.values[k / each] += value(response, static_cast<int>(k), k / each) /
                                   static_cast<double>(accuracy.samples());
      }
    }
    answer.seconds = watch.seconds();  // includes the caller's sum
    answer.samples = static_cast<double>(response.cost().samples());
    answer.rays = rays_of(response.cost());
    return answer;
  }

  absl::StatusOr<Answer> estimated(std::size_t way, std::uint32_t samples,
                                   std::uint64_t seed) const {
    v1::EstimateIrradianceRequest request;
    request.set_scene_id(options_.scene_id);
    *request.mutable_receivers() = request_.receivers();
    *request.mutable_normals() = request_.normals();
    request.set_bounces(0);
    *request.mutable_accuracy() = reference_accuracy(way, lights_);
    request.mutable_accuracy()->set_samples(samples);
    request.mutable_seed()->set_seed(seed);
    const Stopwatch watch;
    LUCERNA_ASSIGN_OR_RETURN(
        const auto response,
        client::estimate_irradiance_in_batches(client_, request, {.max_items = 0, .call = call()}));
    Answer answer{.values = {}, .seconds = watch.seconds()};
    for (int i = 0; i < response.illuminance_lx_size(); ++i) {
      const bool has = response.status().empty() || response.status(i) == v1::ITEM_STATUS_OK;
      answer.values.push_back(has ? static_cast<double>(response.illuminance_lx(i))
                                  : std::numeric_limits<double>::quiet_NaN());
    }
    return answer;
  }

  /// The visible share of light samples, by TestVisibility.
  absl::StatusOr<Answer> seen(std::uint32_t samples, std::uint64_t seed) const {
    v1::Accuracy accuracy;
    accuracy.set_samples(samples);
    accuracy.set_area_sampling(v1::AREA_SAMPLING_PARALLELOGRAM);
    accuracy.set_sampler(v1::SAMPLER_INDEPENDENT);
    const Stopwatch watch;
    LUCERNA_ASSIGN_OR_RETURN(const auto response, samples_of_light(accuracy, seed, false));
    const std::size_t points = layout_.points.size();
    const std::size_t each = static_cast<std::size_t>(response.pdf_per_sr_size()) / points;
    std::vector<client::Double3> from, to, start, along, from_normals, start_normals;
    std::vector<int> segments, rays;
    const v1::Vector3& o = request_.receivers().origin_m();
    for (int i = 0; i < response.pdf_per_sr_size(); ++i) {
      if (!ok(response, i)) continue;
      const std::size_t point = static_cast<std::size_t>(i) / each;
      const auto three = [i](const google::protobuf::RepeatedField<float>& v) {
        return client::Double3{v[3 * i], v[3 * i + 1], v[3 * i + 2]};
      };
      if (response.distance_m(i) > 0) {
        const client::Double3 offset = three(response.light_offsets_m());
        from.push_back(layout_.points[point]);
        to.push_back({o.x() + offset[0], o.y() + offset[1], o.z() + offset[2]});
        from_normals.push_back(unit_normals_[point]);
        segments.push_back(i);
      } else {
        start.push_back(layout_.points[point]);
        along.push_back(three(response.wi()));
        start_normals.push_back(unit_normals_[point]);
        rays.push_back(i);
      }
    }
    Answer answer{.values = std::vector<double>(points)};
    const auto look = [&](v1::TestVisibilityRequest& request,
                          const std::vector<client::Double3>& normals,
                          const std::vector<int>& items) -> absl::Status {
      if (items.empty()) return absl::OkStatus();
      request.set_scene_id(options_.scene_id);
      client::fill(normals, request.mutable_normals());
      LUCERNA_ASSIGN_OR_RETURN(
          const auto visible,
          client::test_visibility_in_batches(client_, request, {.max_items = 0, .call = call()}));
      for (std::size_t k = 0; k < items.size(); ++k) {
        if (!client::bit(visible.visible(), k)) continue;
        answer.values[static_cast<std::size_t>(items[k]) / each] +=
            1 / (chosen_with(response, items[k]) * static_cast<double>(lights_) * samples);
      }
      return absl::OkStatus();
    };
    v1::TestVisibilityRequest between, beyond;
    *between.mutable_segments()->mutable_from() = client::make_points(from);
    *between.mutable_segments()->mutable_to() = client::make_points(to);
    *beyond.mutable_rays()->mutable_from() = client::make_points(start);
    client::fill(along, beyond.mutable_rays()->mutable_directions());
    if (const auto status = look(between, from_normals, segments); !status.ok()) return status;
    if (const auto status = look(beyond, start_normals, rays); !status.ok()) return status;
    answer.seconds = watch.seconds();
    return answer;
  }

  const client::Client& client_;
  QuestionOptions options_;
  std::uint64_t lights_;
  bool visibility_;
  Layout layout_;
  v1::SampleLiRequest request_;
  std::vector<client::Double3> unit_normals_;
};

absl::StatusOr<std::unique_ptr<Question>> make(const client::Client& client,
                                               const QuestionOptions& options, bool visibility) {
  v1::GetSceneRequest request;
  request.set_scene_id(options.scene_id);
  LUCERNA_ASSIGN_OR_RETURN(const auto scene, client.get_scene(request, options.call));
  if (scene.summary().lights() == 0) {
    return absl::InvalidArgumentError("--query: the scene has no lights to sample");
  }
  return std::make_unique<SampleQuestion>(client, options, scene.summary().lights(), visibility);
}

}  // namespace

absl::StatusOr<std::unique_ptr<Question>> make_sample_question(const client::Client& client,
                                                               const QuestionOptions& options) {
  return make(client, options, false);
}

absl::StatusOr<std::unique_ptr<Question>> make_visibility_question(const client::Client& client,
                                                                   const QuestionOptions& options) {
  return make(client, options, true);
}

}  // namespace lucerna::tradeoff
