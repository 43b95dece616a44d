// A question that the study repeats: a query, its items, and the calls of the client.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "absl/status/statusor.h"
#include "client/tradeoff/settings.h"
#include "client/tradeoff/study_errors.h"
#include "lucerna/client/client.h"
#include "lucerna/client/points.h"

namespace lucerna::tradeoff {

struct Answer {
  /// One value for each item, or three for each pixel.  NaN for items without an answer.
  std::vector<double> values{};
  double seconds = 0;  ///< wall time from before the call to after the answer
  double samples = 0;  ///< over all items
  double rays = 0;     ///< of all kinds
};

/// An estimator of the reference.
struct ReferenceWay {
  std::string words;
  /// Whether the estimator needs a check.  It does if it draws lights by the light BVH, since
  /// settings do the same.  A light that the tree never draws would then be missing from both.
  bool checked = false;
};

/// How the page shows the items.
struct Layout {
  /// Points [m], if items are points.
  std::vector<client::Double3> points;
  /// Tiles of a picture in the order of the values, if items are pixels.
  std::vector<v1::PixelRect> tiles;
  /// Names of items, if they have names.
  std::vector<std::string> labels;
};

/// Not thread-safe.
class Question {
 public:
  virtual ~Question() = default;

  virtual Query query() const = 0;
  /// The quantity of the values: "illuminance [lx]".
  virtual std::string quantity() const = 0;
  virtual const Layout& layout() const = 0;
  virtual std::vector<Setting> settings() const = 0;
  virtual std::vector<Amount> amounts_of(const Setting& setting) const = 0;
  virtual absl::StatusOr<Answer> answer(const Setting& setting, const Amount& amount,
                                        std::uint64_t seed) const = 0;

  /// Estimators of the reference.  None of them is a setting.  At least one does not need a check.
  virtual std::vector<ReferenceWay> reference_ways() const = 0;
  /// Whether the reference is computed with a bound instead of estimated.
  virtual bool reference_is_exact() const { return false; }
  virtual absl::StatusOr<Answer> answer_reference(std::size_t way, std::uint32_t samples,
                                                  std::uint64_t seed) const = 0;
  /// The values of automatic if its answer reports that all of them are exact, else nothing.  The
  /// caller must check them.
  virtual absl::StatusOr<std::optional<std::vector<double>>> closed_form(std::uint64_t) const {
    return std::nullopt;
  }
  /// Bounds on the error of each value of an exact reference.
  virtual std::vector<double> reference_bounds() const { return {}; }

  /// The errors of `values`: those of measure(), and further ones for some queries.
  virtual Errors errors(const std::vector<double>& values, const std::vector<double>& reference,
                        double dark) const {
    return measure(values, reference, dark);
  }
  /// Sets the dark level, below which target errors are absolute.
  void set_dark_level(double dark) { dark_ = dark; }
  /// Sets the deadline of the next calls.
  void set_call(client::CallOptions call) { call_ = std::move(call); }
  const client::CallOptions& call() const { return call_; }

  /// An explanation of a setting; empty if its name is enough.
  virtual std::string about(const Setting&) const { return {}; }
  /// The command line of a setting.
  virtual std::string command(const Setting& setting, const Amount& amount) const = 0;

 protected:
  explicit Question(client::CallOptions call) : call_(std::move(call)) {}

  double dark_ = 0;

 private:
  client::CallOptions call_;
};

/// The options of a question.
struct QuestionOptions {
  std::string scene{};   ///< as the user typed it
  std::string server{};  ///< as the user typed it; empty if commands use this server by default
  std::string scene_id{};
  std::string points_file{};
  std::vector<client::Double3> points{}, normals{};
  std::optional<std::uint32_t> bounces{};
  double exposure_ev = 0;
  client::CallOptions call{};
};

/// INVALID_ARGUMENT if the scene lacks what the query needs.
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

/// The methods of estimator `way` of reference_ways_for(), for a scene with this number of lights.
/// All use independent samples, the balance heuristic, points by area in a map of low distortion,
/// and no closed forms.  They take every light, or one light drawn uniformly, by power or, with
/// many lights, by the light BVH.
v1::Accuracy reference_accuracy(std::size_t way, std::uint64_t lights);
std::vector<ReferenceWay> reference_ways_for(std::uint64_t lights);

/// A word for a shell, quoted if necessary.
std::string shell_word(const std::string& word);
/// "lucerna COMMAND SCENE", then `rest`, then --server.  `rest` is empty or begins with a space.
std::string command_line(const QuestionOptions& options, const std::string& command,
                         const std::string& rest);
/// The default limits of a server: samples of an item, and items of a call.
inline constexpr double kServerSamples = 1 << 20, kServerBatch = 1 << 16;
/// A comment for the end of a command whose amount exceeds `most`, the default of the server's
/// `option`; empty for other amounts.
std::string for_which_server(const Amount& amount, double most, const std::string& option);
/// The flags of a command, with a space before each.
std::string join_flags(const Setting& setting, const Amount& amount);

/// " --floor X" for a target error, which is absolute for items below `dark`; else empty.
std::string floor_flag(const Amount& amount, double dark);

/// The request for a setting's methods and an amount.
v1::Accuracy accuracy_of(const Setting& setting, const Amount& amount, double floor = 0);

/// Rays of all kinds.
double rays_of(const v1::Cost& cost);

}  // namespace lucerna::tradeoff
