#include "server/rpc/handlers/render_tile_handler.h"

#include <fmt/core.h>

#include <bit>
#include <optional>
#include <utility>

#include "proto/common/sample_blocks.h"
#include "proto/common/status_macros.h"
#include "server/rpc/handlers/render_query.h"
#include "server/rpc/messages/checks.h"
#include "server/rpc/messages/errors.h"
#include "server/runtime/time_budget.h"

namespace lucerna::rpc {
namespace {

// Predicted processor time of one sample of a pixel [s]: a path with a few rays.
constexpr double kSampleSeconds = 1e-5;

std::string text(const v1::PixelRect& r) {
  return fmt::format("[{}, {}) x [{}, {})", r.x0(), r.x1(), r.y0(), r.y1());
}

absl::StatusOr<PixelRect> check_rect(const CallContext& context, const Scene& scene,
                                     const v1::RenderTileRequest& request) {
  const int width = scene.camera().width(), height = scene.camera().height();
  PixelRect rect{0, 0, width, height};
  if (request.has_rect()) {
    const v1::PixelRect& r = request.rect();
    if (r.x0() >= r.x1() || r.y0() >= r.y1() || r.x1() > static_cast<std::uint32_t>(width) ||
        r.y1() > static_cast<std::uint32_t>(height)) {
      return bad_field("rect", text(r), "not empty and within [0, {}) x [0, {})", width, height);
    }
    rect = {static_cast<int>(r.x0()), static_cast<int>(r.y0()), static_cast<int>(r.x1()),
            static_cast<int>(r.y1())};
  }
  LUCERNA_RETURN_IF_ERROR(
      check_limit("pixels of rect", area(rect), context.limits.max_tile_pixels));
  LUCERNA_RETURN_IF_ERROR(check_answer_size(context, "pixels of rect", area(rect),
                                            tile_size(request.accuracy(), request.intervals())));
  return rect;
}

/// Sets the run of blocks that the request selects.
absl::Status put_run(const v1::RenderTileRequest& request, const RenderQuery& query,
                     TileSettings& settings) {
  const std::uint64_t first = request.first_sample();
  if (query.rule.samples == 0) {
    if (first == 0) return absl::OkStatus();
    return bad_field(
        "first_sample", first,
        "0 with accuracy.target_error or accuracy.time_budget_s, which set the samples");
  }
  const std::uint32_t samples = query.rule.samples, block = settings.samples_per_block;
  if (!std::has_single_bit(samples / block)) {
    return bad_field("accuracy.samples", samples,
                     "a power of two times samples_per_block = {}; for other counts, "
                     "render and merge several tiles",
                     block);
  }
  if (first % samples != 0) {
    return bad_field("first_sample", first, "a multiple of accuracy.samples = {}", samples);
  }
  // Samples are numbered in 32 bits within the sampler's sequences.
  const std::uint64_t most_first =
      settings.one_sequence ? kMostSamplesPerBlock - samples : std::uint64_t{1} << 40;
  if (first > most_first) {
    return bad_field("first_sample", first, "[0, {}]", most_first);
  }
  settings.first_block = first / block;
  return absl::OkStatus();
}

/// A request of RenderTile.
struct TileQuery {
  std::shared_ptr<const Scene> scene;
  RenderQuery render;
};

absl::StatusOr<TileQuery> parse(const CallContext& context, const v1::RenderTileRequest& request) {
  TileQuery query;
  LUCERNA_ASSIGN_OR_RETURN(query.scene, find_scene(context, request.scene_id()));
  const Scene& scene = *query.scene;
  LUCERNA_ASSIGN_OR_RETURN(const PixelRect rect, check_rect(context, scene, request));
  LUCERNA_ASSIGN_OR_RETURN(
      query.render,
      check_render(context, scene, request, std::bit_floor(proposed_samples(context, scene))));
  query.render.settings.rect = rect;
  LUCERNA_RETURN_IF_ERROR(put_run(request, query.render, query.render.settings));
  return query;
}

/// The settings with this number of samples, a power of two.
TileSettings with_samples(const RenderQuery& query, std::uint32_t samples) {
  TileSettings settings = query.settings;
  settings.samples_per_block =
      query.samples_per_block.value_or(default_samples_per_block(samples, kTileBlocks));
  settings.block_count = samples / settings.samples_per_block;
  return settings;
}

/// The tile; nothing if `stop` was requested.
std::optional<TileResult> render(const Scene& scene, const TileSettings& settings,
                                 const std::stop_token& stop) {
  TileResult result = lucerna::render_tile(scene, settings, stop);
  if (result.stopped) return std::nullopt;
  return result;
}

/// Renders as many samples as the time budget allows; sets their number in `settings`.
std::optional<TileResult> render_in_time(const TileQuery& query, const std::stop_token& stop,
                                         TileSettings& settings) {
  const std::uint32_t least = least_samples(query.render);
  auto [result, times] = within_time(
      *query.render.rule.time_budget_s, query.render.most_samples / least, stop,
      [&](std::uint32_t n, const std::stop_token& in_time) {
        return render(*query.scene, with_samples(query.render, n * least), in_time);
      },
      [](std::uint32_t n) { return std::bit_floor(n); });
  settings = with_samples(query.render, times * least);
  return std::move(result);
}

/// For a number of samples; else 0, because the number is not known before.
double predicted_seconds(const RenderQuery& query) {
  if (query.rule.target || query.rule.time_budget_s) return 0;
  const TileSettings& s = query.settings;
  return kSampleSeconds * static_cast<double>(area(s.rect)) * static_cast<double>(s.block_count) *
         static_cast<double>(s.samples_per_block);
}

absl::Status answer(const TileQuery& query, SceneStore& scenes, const std::stop_token& stop,
                    v1::RenderTileResponse* response) {
  TileSettings settings = query.render.settings;
  // Only a few calls run at once, so the memory of small tiles does not matter.
  constexpr std::uint64_t kSmall = std::uint64_t{1} << 20;
  constexpr std::uint64_t kCopies = 3;  // the result, the message and its bytes
  std::shared_ptr<LoadBudget> memory;
  if (const std::uint64_t bytes = kCopies * area(settings.rect) * pixel_bytes(settings);
      bytes > kSmall) {
    memory = scenes.count_call(*query.scene);
    LUCERNA_RETURN_IF_ERROR(load_error(memory->claim(bytes)));
  }
  const std::optional<TileResult> result = query.render.rule.time_budget_s
                                               ? render_in_time(query, stop, settings)
                                               : render(*query.scene, settings, stop);
  if (!result) return absl::CancelledError("stopped");
  set_tile(*query.scene, settings, settings.first_block, settings.block_count, *result,
           response->mutable_tile());
  set_counts(response->mutable_cost(), result->work);
  return absl::OkStatus();
}

}  // namespace

Prepared handle_render_tile(const CallContext& context, const v1::RenderTileRequest& request,
                            v1::RenderTileResponse* response) {
  LUCERNA_ASSIGN_OR_RETURN(const TileQuery query, parse(context, request));
  Task task =
      batch_task(predicted_seconds(query.render), area(query.render.settings.rect), response,
                 [query, &scenes = context.scenes, response](const std::stop_token& stop) {
                   return answer(query, scenes, stop, response);
                 });
  task.bulk = true;
  return task;
}

}  // namespace lucerna::rpc
