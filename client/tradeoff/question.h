// What is asked again and again: a query, its items, and how a client asks it.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "absl/status/statusor.h"
#include "client/tradeoff/errors.h"
#include "client/tradeoff/settings.h"
#include "lucerna/client/client.h"
#include "lucerna/client/points.h"

namespace lucerna::tradeoff {

struct Answer {
  /// One (of pictures three) an item; not a number where the item has none.
  std::vector<double> values{};
  double seconds = 0;  ///< of wall time, from before the question to after the answer
  double samples = 0;  ///< over all items
  double rays = 0;     ///< of all kinds
};

/// An estimator to make a reference with.
struct ReferenceWay {
  std::string words;
  /// It draws lights by the light BVH, as settings do: a light that the tree gives no chance would
  /// be missing from both, so its mean is held against that of a way without.
  bool checked = false;
};

/// What is drawn of the items.
struct Layout {
  /// Points, where items are points.
  std::vector<client::Double3> points;
  /// Tiles of a picture in the order of the values, where items are pixels.
  std::vector<v1::PixelRect> tiles;
  /// Names of items, where they have some.
  std::vector<std::string> labels;
};

/// Not thread-safe.
class Question {
 public:
  virtual ~Question() = default;

  virtual Query query() const = 0;
  /// "illuminance [lx]": what the values are.
  virtual std::string quantity() const = 0;
  virtual const Layout& layout() const = 0;
  virtual std::vector<Setting> settings() const = 0;
  virtual std::vector<Amount> amounts_of(const Setting& setting) const = 0;
  virtual absl::StatusOr<Answer> ask(const Setting& setting, const Amount& amount,
                                     std::uint64_t seed) const = 0;

  /// The ways to make a reference, each an estimator that no setting is; one at least is
  /// not `checked`.
  virtual std::vector<ReferenceWay> reference_ways() const = 0;
  /// Whether the reference is known, and not estimated.
  virtual bool reference_is_exact() const { return false; }
  virtual absl::StatusOr<Answer> ask_reference(std::size_t way, std::uint32_t samples,
                                               std::uint64_t seed) const = 0;
  /// Automatic's values where its answer says of all that they are exact, which is checked before
  /// they are believed; else nothing.
  virtual absl::StatusOr<std::optional<std::vector<double>>> closed_form(std::uint64_t) const {
    return std::nullopt;
  }
  /// Of an exact reference: bounds on the error of each value.
  virtual std::vector<double> reference_bounds() const { return {}; }

  /// What a difference is, beyond what `measure` finds.
  virtual Errors errors(const std::vector<double>& values, const std::vector<double>& reference,
                        double dark) const {
    return measure(values, reference, dark);
  }
  /// The level below which relative errors are absolute ones: what is asked for by target error has
  /// the same.
  void set_dark_level(double dark) { dark_ = dark; }
  /// How long calls may take from now on.
  void set_call(client::CallOptions call) { call_ = std::move(call); }
  const client::CallOptions& call() const { return call_; }

  /// What a setting is, in words, where its name does not tell.
  virtual std::string about(const Setting&) const { return {}; }
  /// The command of a setting, as a user types it.
  virtual std::string command(const Setting& setting, const Amount& amount) const = 0;

 protected:
  explicit Question(client::CallOptions call) : call_(std::move(call)) {}

  double dark_ = 0;

 private:
  client::CallOptions call_;
};

/// Where questions come from.
struct QuestionOptions {
  std::string scene{};   ///< as the user named it
  std::string server{};  ///< likewise; empty where it is the one that commands ask anyway
  std::string scene_id{};
  std::string points_file{};
  std::vector<client::Double3> points{}, normals{};
  std::optional<std::uint32_t> bounces{};
  double exposure_ev = 0;
  client::CallOptions call{};
};

/// INVALID_ARGUMENT where the query cannot be asked of this scene.
absl::StatusOr<std::unique_ptr<Question>> make_irradiance_question(const client::Client& client,
                                                                   const QuestionOptions& options);
absl::StatusOr<std::unique_ptr<Question>> make_picture_question(const client::Client& client,
                                                                const QuestionOptions& options);
absl::StatusOr<std::unique_ptr<Question>> make_sample_question(const client::Client& client,
                                                               const QuestionOptions& options);
absl::StatusOr<std::unique_ptr<Question>> make_power_question(const client::Client& client,
                                                              const QuestionOptions& options);
absl::StatusOr<std::unique_ptr<Question>> make_visibility_question(const client::Client& client,
                                                                   const QuestionOptions& options);

/// Of a reference by paths: independent samples, by the balance heuristic, of points by area in a
/// map of little distortion, without closed forms; of every light, or of one chosen by chance, by
/// power or, where there are many, by the light BVH (which settings have too).  `lights`: of the
/// scene; `way`: of those of reference_ways_for().
v1::Accuracy reference_accuracy(std::size_t way, std::uint64_t lights);
std::vector<ReferenceWay> reference_ways_for(std::uint64_t lights);

/// A word as a shell takes it: quoted where it must be.
std::string shell_word(const std::string& word);
/// "lucerna COMMAND SCENE", and what follows: words with a space before each, and the server.
std::string command_line(const QuestionOptions& options, const std::string& command,
                         const std::string& rest);
/// What servers take by default: samples of an item, and of all items where each has an answer.
inline constexpr double kServerSamples = 1 << 20, kServerBatch = 1 << 16;
/// Behind a command: that it is for a server with more than its own `option`, where that is `most`
/// by default and the amount is beyond.
std::string for_which_server(const Amount& amount, double most, const std::string& option);
/// Flags as they follow a command, with a space before each.
std::string join_flags(const Setting& setting, const Amount& amount);

/// " --floor X" of a target error, where items below `dark` have an absolute one.
std::string floor_flag(const Amount& amount, double dark);

/// With a setting's methods and an amount.
v1::Accuracy accuracy_of(const Setting& setting, const Amount& amount, double floor = 0);

/// The luminance of three floats of RGB.
double luminance(const float* rgb);
double rays_of(const v1::Cost& cost);

}  // namespace lucerna::tradeoff
