// The question of pixels: all pixels of a small picture, or tiles spread over a large picture.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <utility>

#include "client/tradeoff/estimate_question.h"
#include "client/tradeoff/flip.h"
#include "lucerna/client/picture.h"
#include "proto/common/status_macros.h"
#include "proto/common/stopwatch.h"

namespace lucerna::tradeoff {
namespace {

constexpr std::uint32_t kMostPixelSamples = 1 << 14;
// A tile is much larger than FLIP's filters, which have a radius of 10 pixels.  It is small enough
// that a question of one sample takes a fraction of a second.
constexpr std::uint32_t kTile = 32;
// Samples that show whether pixels are exact: the least number with a target error.
constexpr std::uint32_t kClosedFormPixelSamples = 64;
constexpr double kClosedFormError = 0.1;
constexpr std::uint32_t kColumns = 3, kRows = 2;

/// One tile in the middle of each of kColumns x kRows parts of the picture.  For a picture of at
/// most that size, tiles that cover it.
std::vector<v1::PixelRect> spread_tiles(std::uint32_t width, std::uint32_t height) {
  std::vector<v1::PixelRect> tiles;
  const auto add = [&](std::uint32_t x, std::uint32_t y, std::uint32_t w, std::uint32_t h) {
    v1::PixelRect rect;
    rect.set_x0(x);
    rect.set_y0(y);
    rect.set_x1(x + w);
    rect.set_y1(y + h);
    tiles.push_back(rect);
  };
  if (std::uint64_t{width} * height <= std::uint64_t{kTile} * kTile * kColumns * kRows) {
    // Several tiles, because one tile could exceed the limit of a server.
    for (std::uint32_t y = 0; y < height; y += kTile)
      for (std::uint32_t x = 0; x < width; x += kTile)
        add(x, y, std::min(kTile, width - x), std::min(kTile, height - y));
    return tiles;
  }
  for (std::uint32_t row = 0; row < kRows; ++row) {
    for (std::uint32_t column = 0; column < kColumns; ++column) {
      const std::uint32_t w = std::min(kTile, width / kColumns),
                          h = std::min(kTile, height / kRows);
      add((2 * column + 1) * width / (2 * kColumns) - w / 2,
          (2 * row + 1) * height / (2 * kRows) - h / 2, w, h);
    }
  }
  return tiles;
}

/// Whether each pixel's interval is a single value.  Both ends are then the same float or, because
/// they are rounded outwards, neighbours.
bool are_points(const v1::Tile& tile) {
  if (tile.lower().empty() || tile.lower().size() != tile.upper().size()) return false;
  for (std::size_t i = 0; i + sizeof(float) <= tile.lower().size(); i += sizeof(float)) {
    float lower = 0, upper = 0;
    std::memcpy(&lower, tile.lower().data() + i, sizeof lower);
    std::memcpy(&upper, tile.upper().data() + i, sizeof upper);
    if (!(upper <= std::nextafter(lower, std::numeric_limits<float>::max()))) return false;
  }
  return true;
}

class PictureQuestion : public EstimateQuestion {
 public:
  PictureQuestion(const client::Client& client, const QuestionOptions& options,
                  const v1::SceneSummary& scene)
      : EstimateQuestion(client, options, scene.lights(), kMostPixelSamples) {
    layout_.tiles = spread_tiles(scene.image_width(), scene.image_height());
    request_.set_scene_id(options.scene_id);
    if (options.bounces) request_.set_bounces(*options.bounces);
  }

  Query query() const override { return Query::kRender; }
  std::string quantity() const override { return "pixels, linear RGB [cd/m2 x film scale]"; }

  Errors errors(const std::vector<double>& values, const std::vector<double>& reference,
                double dark) const override {
    Errors result = measure(values, reference, dark);
    const double exposure = std::exp2(options_.exposure_ev);
    const auto exposed = [&](const std::vector<double>& v, std::size_t first, std::size_t count) {
      std::vector<float> rgb(count);
      for (std::size_t i = 0; i < count; ++i) rgb[i] = static_cast<float>(exposure * v[first + i]);
      return rgb;
    };
    double sum = 0;
    std::size_t first = 0;
    for (const v1::PixelRect& tile : layout_.tiles) {
      const std::uint32_t w = tile.x1() - tile.x0(), h = tile.y1() - tile.y0();
      const std::size_t count = std::size_t{3} * w * h;
      for (const float d :
           flip(exposed(reference, first, count), exposed(values, first, count), w, h))
        sum += static_cast<double>(d);
      first += count;
    }
    result.flip = sum / (static_cast<double>(first) / 3);
    return result;
  }

  absl::StatusOr<std::optional<std::vector<double>>> closed_form(
      std::uint64_t seed) const override {
    // Blocks of equal values may all have missed a light.  With a target error, the interval of
    // each pixel is exact if no block scatters.
    v1::Accuracy accuracy;
    accuracy.set_samples(kClosedFormPixelSamples);
    LUCERNA_ASSIGN_OR_RETURN(auto responses, respond(accuracy, seed));
    const auto scatters = [](const v1::RenderTileResponse& response) {
      const std::string& deviation = response.tile().deviation();
      return std::any_of(deviation.begin(), deviation.end(), [](char c) { return c != 0; });
    };
    if (std::any_of(responses.begin(), responses.end(), scatters)) return std::nullopt;
    accuracy.mutable_target_error()->set_relative(kClosedFormError);
    accuracy.mutable_target_error()->set_max_samples(kClosedFormPixelSamples);
    LUCERNA_ASSIGN_OR_RETURN(responses, respond(accuracy, seed));
    for (const v1::RenderTileResponse& response : responses) {
      const v1::Tile& tile = response.tile();
      if (scatters(response) || !are_points(tile)) return std::nullopt;
    }
    LUCERNA_ASSIGN_OR_RETURN(auto known, values(responses));
    return std::optional(std::move(known));
  }
  std::string command(const Setting& setting, const Amount& amount) const override {
    return command_line(options_, "render", " -o picture.exr" + flags(setting, amount)) +
           for_which_server(amount, kServerSamples, "--max-samples");
  }

 private:
  absl::StatusOr<std::vector<v1::RenderTileResponse>> respond(const v1::Accuracy& accuracy,
                                                              std::uint64_t seed) const {
    v1::RenderTileRequest request = request_;
    *request.mutable_accuracy() = accuracy;
    request.set_seed(seed);
    std::vector<v1::RenderTileResponse> responses;
    for (const v1::PixelRect& tile : layout_.tiles) {
      *request.mutable_rect() = tile;
      LUCERNA_ASSIGN_OR_RETURN(auto response, client_.render_tile(request, call()));
      responses.push_back(std::move(response));
    }
    return responses;
  }

  static absl::StatusOr<std::vector<double>> values(
      const std::vector<v1::RenderTileResponse>& responses) {
    std::vector<double> result;
    for (const v1::RenderTileResponse& response : responses) {
      client::PictureAssembler assembler;
      LUCERNA_RETURN_IF_ERROR(assembler.add(response.tile()));
      LUCERNA_ASSIGN_OR_RETURN(const auto pixels, assembler.pixels(response.tile().rect()));
      result.insert(result.end(), pixels.begin(), pixels.end());
    }
    return result;
  }

  absl::StatusOr<Answer> estimate(const v1::Accuracy& accuracy, std::uint64_t seed) const override {
    const Stopwatch watch;
    const auto responses = respond(accuracy, seed);
    const double seconds = watch.seconds();
    if (!responses.ok()) return responses.status();
    LUCERNA_ASSIGN_OR_RETURN(auto pixels, values(*responses));
    Answer answer{.values = std::move(pixels), .seconds = seconds};
    for (const v1::RenderTileResponse& response : *responses) {
      answer.samples += static_cast<double>(response.cost().samples());
      answer.rays += rays_of(response.cost());
    }
    return answer;
  }

  v1::RenderTileRequest request_;
};

}  // namespace

absl::StatusOr<std::unique_ptr<Question>> make_picture_question(const client::Client& client,
                                                                const QuestionOptions& options) {
  v1::GetSceneRequest request;
  request.set_scene_id(options.scene_id);
  LUCERNA_ASSIGN_OR_RETURN(const auto scene, client.get_scene(request, options.call));
  if (scene.summary().image_width() == 0) {
    return absl::InvalidArgumentError("--query render: the scene has no camera");
  }
  return std::make_unique<PictureQuestion>(client, options, scene.summary());
}

}  // namespace lucerna::tradeoff
