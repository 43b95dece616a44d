// Illuminance at points with normals.
#include <fmt/format.h>

#include <limits>
#include <utility>

#include "client/cli/points.h"
#include "client/tradeoff/question.h"
#include "client/tradeoff/stopwatch.h"
#include "lucerna/client/batches.h"

namespace lucerna::tradeoff {
namespace {

constexpr std::uint32_t kMaxSamples = 1 << 16;

class IrradianceQuestion : public Question {
 public:
  IrradianceQuestion(const client::Client& client, const QuestionOptions& options,
                     std::uint64_t lights)
      : client_(client), options_(options), lights_(lights) {
    layout_.points = options.points;
    request_.set_scene_id(options.scene_id);
    *request_.mutable_receivers() = client::make_points(options.points);
    cli::fill(options.normals, request_.mutable_normals());
    if (options.bounces) request_.set_bounces(*options.bounces);
  }

  Query query() const override { return Query::kIrradiance; }
  std::string quantity() const override { return "illuminance [lx]"; }
  const Layout& layout() const override { return layout_; }
  std::vector<Setting> settings() const override {
    return tradeoff::settings(query(), {.lights = lights_});
  }
  std::vector<Amount> amounts_of(const Setting& setting) const override {
    return amounts(setting, kMaxSamples);
  }
  absl::StatusOr<Answer> ask(const Setting& setting, const Amount& amount,
                             std::uint64_t seed) const override {
    return answer(accuracy_of(setting, amount, dark_ * amount.value), seed);
  }
  std::vector<std::string> reference_ways() const override { return reference_ways_for(lights_); }
  absl::StatusOr<Answer> ask_reference(std::size_t way, std::uint32_t samples,
                                       std::uint64_t seed) const override {
    v1::Accuracy accuracy = reference_accuracy(way);
    accuracy.set_samples(samples);
    return answer(accuracy, seed);
  }
  std::string command(const Setting& setting, const Amount& amount) const override {
    std::string text =
        fmt::format("lucerna irradiance {} --points {}", options_.scene, options_.points_file);
    if (options_.bounces) text += fmt::format(" --bounces {}", *options_.bounces);
    text += join_flags(setting, amount);
    if (amount.target) text += fmt::format(" --floor {:.3g}", dark_ * amount.value);
    return text;
  }

 private:
  absl::StatusOr<Answer> answer(const v1::Accuracy& accuracy, std::uint64_t seed) const {
    v1::EstimateIrradianceRequest request = request_;
    *request.mutable_accuracy() = accuracy;
    request.mutable_seed()->set_seed(seed);
    const Stopwatch watch;
    const auto response = client::estimate_irradiance_in_batches(
        client_, request, {.max_items = 0, .call = options_.call});
    const double seconds = watch.seconds();
    if (!response.ok()) return response.status();
    Answer answer{.values = {},
                  .seconds = seconds,
                  .samples = static_cast<double>(response->cost().samples()),
                  .rays = rays_of(response->cost())};
    for (int i = 0; i < response->illuminance_lx_size(); ++i) {
      const bool ok = response->status().empty() || response->status(i) == v1::ITEM_STATUS_OK;
      answer.values.push_back(ok ? static_cast<double>(response->illuminance_lx(i))
                                 : std::numeric_limits<double>::quiet_NaN());
    }
    return answer;
  }

  const client::Client& client_;
  QuestionOptions options_;
  std::uint64_t lights_;
  Layout layout_;
  v1::EstimateIrradianceRequest request_;
};

}  // namespace

absl::StatusOr<std::unique_ptr<Question>> make_irradiance_question(const client::Client& client,
                                                                   const QuestionOptions& options) {
  v1::GetSceneRequest request;
  request.set_scene_id(options.scene_id);
  const auto scene = client.get_scene(request, options.call);
  if (!scene.ok()) return scene.status();
  return std::make_unique<IrradianceQuestion>(client, options, scene->summary().lights());
}

}  // namespace lucerna::tradeoff
