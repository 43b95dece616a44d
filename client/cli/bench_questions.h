// The requests of `lucerna bench`.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "absl/status/statusor.h"
#include "client/terminal/light_option.h"
#include "lucerna/v1/scene.pb.h"

namespace lucerna::bench {

enum class Question : std::uint8_t {
  kVisibility,
  kIrradiance,
  kSamples,
  kEmission,
  kPower,
  kTile,
  kEmpty
};

/// The words of the command line, in the order of Question.
inline constexpr std::string_view kQuestionNames[] = {
    "visibility", "irradiance", "samples", "emission", "power", "tile", "empty"};

/// What the requests have in common.
struct QuestionOptions {
  v1::SceneSummary scene;
  /// Of the scene.
  std::vector<std::uint64_t> light_ids;
  cli::LightOption light;
  std::optional<std::uint32_t> samples, bounces;
  /// Items follow each other in space, instead of being independent.
  bool coherent = false;
  std::uint64_t seed = 0;
};

/// Serialised requests of one kind and size.
struct Requests {
  /// The full name of the method.
  std::string method;
  std::vector<std::string> bytes;
  /// Of each request.
  std::uint64_t items = 0;
};

/// Requests with random content inside of the scene's sphere.  `batch` is the number of segments,
/// receivers, rays, lights or pixels, at least 1.  A tile has the largest square of at most `batch`
/// pixels that fits the picture.  INVALID_ARGUMENT if the scene has fewer lights than `batch`.
absl::StatusOr<Requests> make_requests(Question question, std::uint32_t batch,
                                       const QuestionOptions& options);

/// Samples and rays of an answer.
struct Answer {
  std::uint64_t samples = 0, rays = 0;
};

/// Reads an answer, as a client does.  INTERNAL if it is not a message of its type.
absl::StatusOr<Answer> read_answer(Question question, const std::string& bytes);

}  // namespace lucerna::bench
