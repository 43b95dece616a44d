// The question of the power of lights: exact, by textbook formulas, or by rays that leave the
// lights.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "client/library/pages.h"
#include "client/terminal/luminance.h"
#include "client/tradeoff/question.h"
#include "lucerna/client/batches.h"
#include "proto/common/status_macros.h"
#include "proto/common/stopwatch.h"

namespace lucerna::tradeoff {
namespace {

// There is one call for each light, with at most this many rays.
constexpr std::uint64_t kMostLights = 64;
constexpr std::uint32_t kMaxRays = 1 << 18;

// Settings that only this query has.  They are not method flags.
constexpr char kApproximate[] = "approximate", kSampled[] = "sampled", kRays[] = "emitted rays";

class PowerQuestion : public Question {
 public:
  PowerQuestion(const client::Client& client, const QuestionOptions& options,
                std::vector<std::uint64_t> lights, const v1::EstimatePowerResponse& exact)
      : Question(options.call), client_(client), options_(options), lights_(std::move(lights)) {
    for (const v1::LightPower& light : exact.lights()) {
      layout_.labels.push_back(fmt::format("light {}", light.light_id()));
      exact_.push_back(light.power_lm());
      bounds_.push_back(light.error_lm());
    }
  }

  Query query() const override { return Query::kPower; }
  std::string quantity() const override { return "luminous flux of a light [lm]"; }
  const Layout& layout() const override { return layout_; }
  std::vector<Setting> settings() const override {
    return {{.flags = {}, .accuracy = {}},
            {.flags = {"--method", kApproximate}, .accuracy = {}},
            {.flags = {"--method", kSampled}, .accuracy = {}},
            {.flags = {"--method", kSampled}, .accuracy = {}, .by_target = true},
            {.flags = {kRays}, .accuracy = {}}};
  }
  std::vector<Amount> amounts_of(const Setting& setting) const override {
    if (!by_rays(setting) && !sampled(setting)) return {{.target = false, .value = 1}};
    return amounts(setting, kMaxRays);
  }
  absl::StatusOr<Answer> answer(const Setting& setting, const Amount& amount,
                                std::uint64_t seed) const override {
    if (by_rays(setting)) return emitted(static_cast<std::uint32_t>(amount.value), seed);
    v1::EstimatePowerRequest request;
    request.set_method(setting.flags.empty() ? v1::EstimatePowerRequest::METHOD_EXACT
                       : sampled(setting)    ? v1::EstimatePowerRequest::METHOD_SAMPLED
                                             : v1::EstimatePowerRequest::METHOD_APPROXIMATE);
    if (sampled(setting)) {
      *request.mutable_accuracy() = accuracy_of(setting, amount, dark_ * amount.value);
      request.set_seed(seed);
    }
    return server_power(std::move(request));
  }
  std::vector<ReferenceWay> reference_ways() const override {
    return {{"closed forms and quadrature with a stated bound (METHOD_EXACT)"}};
  }
  bool reference_is_exact() const override { return true; }
  absl::StatusOr<Answer> answer_reference(std::size_t, std::uint32_t,
                                          std::uint64_t) const override {
    Answer answer{.values = exact_};
    return answer;
  }
  std::vector<double> reference_bounds() const override { return bounds_; }
  /// The exact method made the reference, so it equals the reference.  Its error is the bound that
  /// it reports.
  Errors errors(const std::vector<double>& values, const std::vector<double>& reference,
                double dark) const override {
    if (values != exact_) return measure(values, reference, dark);
    std::vector<double> off = exact_;
    for (std::size_t i = 0; i < off.size(); ++i) off[i] += bounds_[i];
    return measure(off, reference, dark);
  }
  std::string command(const Setting& setting, const Amount& amount) const override {
    if (by_rays(setting)) {
      std::string ids;
      for (const std::uint64_t light : lights_) ids += fmt::format(" {}", light);
      const std::string emit =
          command_line(options_, "emit", fmt::format(" --light $id --count {:.0f}", amount.value));
      return fmt::format("for id in{}; do {}; done", ids, emit) +
             for_which_server(amount, kServerBatch, "--max-batch-items");
    }
    if (sampled(setting)) {
      return command_line(options_, "power",
                          join_flags(setting, amount) + floor_flag(amount, dark_)) +
             for_which_server(amount, kServerSamples, "--max-samples");
    }
    return command_line(options_, "power", setting.flags.empty() ? "" : " --method approximate");
  }
  std::string about(const Setting& setting) const override {
    if (by_rays(setting))
      return "rays of SampleLe that leave the light, whose flux the caller adds up";
    if (sampled(setting)) return "the mean over rays that leave the light, computed by the server";
    if (setting.flags.empty()) return "--method exact: closed forms, or quadrature with a bound";
    return "textbook formulas";
  }

 private:
  static bool by_rays(const Setting& setting) {
    return !setting.flags.empty() && setting.flags[0] == kRays;
  }

  static bool sampled(const Setting& setting) {
    return setting.flags.size() == 2 && setting.flags[1] == kSampled;
  }

  absl::StatusOr<Answer> server_power(v1::EstimatePowerRequest request) const {
    request.set_scene_id(options_.scene_id);
    request.mutable_light_ids()->Add(lights_.begin(), lights_.end());
    const Stopwatch watch;
    LUCERNA_ASSIGN_OR_RETURN(const auto response, client_.estimate_power(request, call()));
    Answer answer{.values = {}, .seconds = watch.seconds()};
    for (const v1::LightPower& light : response.lights()) {
      answer.values.push_back(light.power_lm());
      answer.samples += static_cast<double>(light.samples());
    }
    return answer;
  }

  absl::StatusOr<Answer> emitted(std::uint32_t count, std::uint64_t seed) const {
    Answer answer;
    const Stopwatch watch;
    for (const std::uint64_t light : lights_) {
      v1::SampleLeRequest request;
      request.set_scene_id(options_.scene_id);
      request.set_light_id(light);
      request.set_count(count);
      request.mutable_seed()->set_seed(seed);
      LUCERNA_ASSIGN_OR_RETURN(
          const auto rays,
          client::sample_le_in_batches(client_, request, {.max_items = 0, .call = call()}));
      double sum = 0;
      for (int i = 0; i < rays.directions_size() / 3; ++i) {
        if (!rays.status().empty() && rays.status(i) != v1::ITEM_STATUS_OK) continue;
        const auto dot = [&](int k) {
          return rays.light_normals(3 * i + k) * rays.directions(3 * i + k);
        };
        const bool surface = rays.light_normals(3 * i) != 0 || rays.light_normals(3 * i + 1) != 0 ||
                             rays.light_normals(3 * i + 2) != 0;
        double weight = surface ? std::fabs(dot(0) + dot(1) + dot(2)) : 1;
        if (rays.pdf_position_per_m2(i) > 0) weight /= rays.pdf_position_per_m2(i);
        if (rays.pdf_direction_per_sr(i) > 0) weight /= rays.pdf_direction_per_sr(i);
        sum += cli::luminance(rays.value().data() + 3 * static_cast<std::ptrdiff_t>(i)) * weight;
      }
      answer.values.push_back(sum / count);
      answer.samples += count;
    }
    answer.seconds = watch.seconds();
    return answer;
  }

  const client::Client& client_;
  QuestionOptions options_;
  std::vector<std::uint64_t> lights_;
  Layout layout_;
  std::vector<double> exact_, bounds_;
};

}  // namespace

absl::StatusOr<std::unique_ptr<Question>> make_power_question(const client::Client& client,
                                                              const QuestionOptions& options) {
  std::vector<std::uint64_t> all;
  v1::ListLightsRequest list;
  list.set_scene_id(options.scene_id);
  LUCERNA_ASSIGN_OR_RETURN(const auto lights, client::all_pages(list, [&](const auto& request) {
                             return client.list_lights(request, options.call);
                           }));
  for (const v1::Light& light : lights.lights()) all.push_back(light.id());
  if (all.empty()) {
    return absl::InvalidArgumentError("--query power: the scene has no lights");
  }
  // If there are many lights, take some evenly from the list, so that every kind is likely to be
  // among them.
  const std::uint64_t count = std::min<std::uint64_t>(all.size(), kMostLights);
  v1::EstimatePowerRequest request;
  request.set_scene_id(options.scene_id);
  request.set_method(v1::EstimatePowerRequest::METHOD_EXACT);
  std::vector<std::uint64_t> some;
  for (std::uint64_t i = 0; i < count; ++i) some.push_back(all[i * all.size() / count]);
  request.mutable_light_ids()->Add(some.begin(), some.end());
  LUCERNA_ASSIGN_OR_RETURN(const auto exact, client.estimate_power(request, options.call));
  return std::make_unique<PowerQuestion>(client, options, std::move(some), exact);
}

}  // namespace lucerna::tradeoff
