// The question of illuminance at points with normals.
#include <fmt/format.h>

#include <limits>
#include <utility>

#include "client/tradeoff/estimate_question.h"
#include "lucerna/client/batches.h"
#include "proto/common/status_macros.h"
#include "proto/common/stopwatch.h"

namespace lucerna::tradeoff {
namespace {

constexpr std::uint32_t kMostPointSamples = 1 << 16;
// A multiple of the number of replicates, so that the answer has errors.
constexpr std::uint32_t kClosedFormPointSamples = 64;

class IrradianceQuestion : public EstimateQuestion {
 public:
  IrradianceQuestion(const client::Client& client, const QuestionOptions& options,
                     std::uint64_t lights)
      : EstimateQuestion(client, options, lights, kMostPointSamples) {
    layout_.points = options.points;
    request_.set_scene_id(options.scene_id);
    *request_.mutable_receivers() = client::make_points(options.points);
    client::fill(options.normals, request_.mutable_normals());
    if (options.bounces) request_.set_bounces(*options.bounces);
  }

  Query query() const override { return Query::kIrradiance; }
  std::string quantity() const override { return "illuminance [lx]"; }
  absl::StatusOr<std::optional<std::vector<double>>> closed_form(
      std::uint64_t seed) const override {
    v1::Accuracy accuracy;
    accuracy.set_samples(kClosedFormPointSamples);
    LUCERNA_ASSIGN_OR_RETURN(const auto response, respond(accuracy, seed));
    std::optional<std::vector<double>> result = values(response);
    for (int i = 0; i < response.illuminance_lx_size(); ++i) {
      const float value = response.illuminance_lx(i);
      const bool exact = response.standard_error_lx(i) == 0 && response.zero_bound_lx(i) == 0 &&
                         response.lower_lx(i) == value && response.upper_lx(i) == value;
      if (has(response, i) && !exact) return std::nullopt;
    }
    return result;
  }
  std::string command(const Setting& setting, const Amount& amount) const override {
    return command_line(options_, "irradiance",
                        " --points " + shell_word(options_.points_file) + flags(setting, amount)) +
           for_which_server(amount, kServerSamples, "--max-samples");
  }

 private:
  absl::StatusOr<v1::EstimateIrradianceResponse> respond(const v1::Accuracy& accuracy,
                                                         std::uint64_t seed) const {
    v1::EstimateIrradianceRequest request = request_;
    *request.mutable_accuracy() = accuracy;
    request.mutable_seed()->set_seed(seed);
    return client::estimate_irradiance_in_batches(client_, request,
                                                  {.max_items = 0, .call = call()});
  }

  static bool has(const v1::EstimateIrradianceResponse& response, int i) {
    // Light that every setting may miss does not matter here.
    return response.status().empty() || response.status(i) == v1::ITEM_STATUS_OK ||
           response.status(i) == v1::ITEM_STATUS_MAY_MISS_LIGHT;
  }
  static std::vector<double> values(const v1::EstimateIrradianceResponse& response) {
    std::vector<double> result;
    for (int i = 0; i < response.illuminance_lx_size(); ++i) {
      result.push_back(has(response, i) ? static_cast<double>(response.illuminance_lx(i))
                                        : std::numeric_limits<double>::quiet_NaN());
    }
    return result;
  }

  absl::StatusOr<Answer> estimate(const v1::Accuracy& accuracy, std::uint64_t seed) const override {
    const Stopwatch watch;
    const auto response = respond(accuracy, seed);
    const double seconds = watch.seconds();
    if (!response.ok()) return response.status();
    return Answer{.values = values(*response),
                  .seconds = seconds,
                  .samples = static_cast<double>(response->cost().samples()),
                  .rays = rays_of(response->cost())};
  }

  v1::EstimateIrradianceRequest request_;
};

}  // namespace

absl::StatusOr<std::unique_ptr<Question>> make_irradiance_question(const client::Client& client,
                                                                   const QuestionOptions& options) {
  v1::GetSceneRequest request;
  request.set_scene_id(options.scene_id);
  LUCERNA_ASSIGN_OR_RETURN(const auto scene, client.get_scene(request, options.call));
  return std::make_unique<IrradianceQuestion>(client, options, scene.summary().lights());
}

}  // namespace lucerna::tradeoff
