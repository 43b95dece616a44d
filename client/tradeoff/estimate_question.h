// The common part of questions whose settings are methods of an estimate.
#pragma once

#include <fmt/format.h>

#include <string>
#include <vector>

#include "client/tradeoff/question.h"

namespace lucerna::tradeoff {

/// `client` must outlive the question.
class EstimateQuestion : public Question {
 public:
  const Layout& layout() const override { return layout_; }
  std::vector<Setting> settings() const override {
    return tradeoff::settings(query(), {.lights = lights_});
  }
  std::vector<Amount> amounts_of(const Setting& setting) const override {
    return amounts(setting, max_samples_);
  }
  absl::StatusOr<Answer> answer(const Setting& setting, const Amount& amount,
                                std::uint64_t seed) const override {
    return estimate(accuracy_of(setting, amount, dark_ * amount.value), seed);
  }
  std::vector<ReferenceWay> reference_ways() const override { return reference_ways_for(lights_); }
  absl::StatusOr<Answer> answer_reference(std::size_t way, std::uint32_t samples,
                                          std::uint64_t seed) const override {
    v1::Accuracy accuracy = reference_accuracy(way, lights_);
    accuracy.set_samples(samples);
    return estimate(accuracy, seed);
  }

 protected:
  /// `lights`: the number of lights of the scene.  `max_samples`: the most samples of an item in
  /// the sweep.
  EstimateQuestion(const client::Client& client, const QuestionOptions& options,
                   std::uint64_t lights, std::uint32_t max_samples)
      : Question(options.call),
        client_(client),
        options_(options),
        lights_(lights),
        max_samples_(max_samples) {}

  virtual absl::StatusOr<Answer> estimate(const v1::Accuracy& accuracy,
                                          std::uint64_t seed) const = 0;

  /// The flags after a command's scene and items, with which it repeats the measured question.
  std::string flags(const Setting& setting, const Amount& amount) const {
    std::string text = options_.bounces ? fmt::format(" --bounces {}", *options_.bounces) : "";
    return text + join_flags(setting, amount) + floor_flag(amount, dark_);
  }

  const client::Client& client_;
  QuestionOptions options_;
  Layout layout_;

 private:
  std::uint64_t lights_;
  std::uint32_t max_samples_;
};

}  // namespace lucerna::tradeoff
