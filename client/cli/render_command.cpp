// The command render.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <chrono>
#include <cstdio>
#include <memory>
#include <tuple>
#include <utility>

#include "absl/cleanup/cleanup.h"
#include "client/cli/commands.h"
#include "client/cli/frames.h"
#include "client/cli/picture_files.h"
#include "client/cli/preview.h"
#include "client/cli/render_servers.h"
#include "client/library/picture.h"
#include "client/terminal/certainty.h"
#include "client/terminal/luminance.h"
#include "client/terminal/method_options.h"
#include "client/terminal/output.h"
#include "client/terminal/print.h"
#include "client/terminal/progress.h"
#include "client/terminal/session.h"
#include "client/terminal/stop_option.h"
#include "client/terminal/time_option.h"
#include "client/terminal/validators.h"
#include "proto/common/quantile.h"

namespace lucerna::cli {
namespace {

struct RenderOptions {
  std::string scene;
  PictureNames files;
  StopOption stop;
  MethodOptions methods;
  TimeOption time;
  std::uint64_t seed = 0;
  std::optional<std::uint32_t> bounces;
  std::optional<std::uint32_t> tile_size;
  double exposure_ev = 0;
  ServersOption servers;
  PreviewOption preview;
  FramesOption frames;
  const Frame* frame = nullptr;  ///< null: a single picture
};

/// Progress of a picture: by its samples, by its time, or by its pixels.
class PictureProgress {
 public:
  explicit PictureProgress(std::optional<double> budget_s) : budget_s_(budget_s) {}

  void update(const v1::RenderImageResponse& response) {
    const v1::PixelRect& rect = response.tile().rect();
    if (response.samples_total() > 0) {
      bar_.update(response.samples_done(), response.samples_total());
    } else if (budget_s_) {
      const std::chrono::duration<double> since = std::chrono::steady_clock::now() - begin_;
      constexpr double kSteps = 1000;
      const double share = std::min(1.0, since.count() / *budget_s_);
      bar_.update(static_cast<std::uint64_t>(kSteps * share), static_cast<std::uint64_t>(kSteps));
    } else {
      pixels_ += std::uint64_t{rect.x1() - rect.x0()} * (rect.y1() - rect.y0());
      bar_.update(pixels_,
                  std::uint64_t{response.tile().image_width()} * response.tile().image_height());
    }
  }

 private:
  ProgressBar bar_;
  std::optional<double> budget_s_;
  std::chrono::steady_clock::time_point begin_ = std::chrono::steady_clock::now();
  std::uint64_t pixels_ = 0;
};

/// The whole picture, and the last message without its tile.
std::pair<client::Picture, v1::RenderImageResponse> render_picture(
    Session& session, const v1::RenderImageRequest& request, Preview& preview) {
  client::PictureAssembler assembler;
  v1::RenderImageResponse last;
  absl::Status bad_tile;
  {
    PictureProgress progress(request.accuracy().has_time_budget_s()
                                 ? std::optional(request.accuracy().time_budget_s())
                                 : std::nullopt);
    const absl::Status status = session.client().render_image(
        request,
        [&](const v1::RenderImageResponse& response) {
          bad_tile = assembler.add(response.tile());
          if (bad_tile.ok()) preview.update(response.tile(), assembler);
          progress.update(response);
          last.set_samples_done(response.samples_done());
          last.set_samples_total(response.samples_total());
          *last.mutable_cost() = response.cost();
          return bad_tile.ok();
        },
        session.call_options());
    if (!bad_tile.ok()) session.fail(bad_tile);
    if (!status.ok()) session.fail(status);
  }
  return {session.value_or_fail(assembler.picture()), last};
}

/// "samples per pixel: at least 64, median 256, at most 4096".
std::string describe_samples(const std::vector<std::uint32_t>& samples) {
  const auto [least, most] = std::minmax_element(samples.begin(), samples.end());
  return fmt::format("samples per pixel: at least {}, median {}, at most {}", *least,
                     median(samples), *most);
}

/// Checks the luminance of each pixel; without a target error, nothing.
TargetCheck check_target(const client::Picture& picture, const v1::Accuracy& accuracy) {
  TargetCheck check(accuracy.target_error());
  if (!accuracy.has_target_error()) return check;
  for (std::size_t i = 0; i < picture.upper.size(); ++i) {
    // The number of samples of a pixel is a power of two.
    check.add(luminance(picture.pixels.data() + 3 * i), picture.lower[i], picture.upper[i],
              2ULL * picture.samples[i]);
  }
  return check;
}

/// Ends the program for options that exclude each other.
void check(const RenderOptions& options) {
  options.servers.check();
  if (options.servers && options.stop.budget_s)
    wrong_use("--budget: not with --servers, where tiles wait in queues; use --error or --samples");
  if (options.servers.samples_per_piece > 0 && options.stop.error)
    wrong_use("--split-samples: not with --error, where each pixel has its own number of samples");
  options.files.check(options.stop.samples);
}

void render(Session& session, const RenderOptions& options, Preview& preview) {
  check(options);
  if (!options.servers) session.need_one_server("a picture on several servers requires --servers");
  PictureFiles files(options.files);
  // --skip-existing would take a preview for the picture.
  if (options.frame != nullptr) {
    for (client::PictureFile& file : files.pictures()) file.keep_no_preview();
  }
  preview.begin(files.pictures(), options.exposure_ev);
  // Runs before the files are destroyed.
  const absl::Cleanup no_more = [&preview] { preview.files_done(); };

  v1::RenderImageRequest request;
  request.set_seed(options.seed);
  if (options.bounces) request.set_bounces(*options.bounces);
  if (options.tile_size) request.set_tile_size(*options.tile_size);
  options.stop.put(request);
  options.methods.put(request);
  options.time.put(request);
  if (options.frame != nullptr) options.frame->put(request);
  request.set_final_only(!preview);
  request.set_intervals(options.files.want_intervals());
  // Independent blocks have more noise.  Only files of errors and intervals need them.
  request.set_one_sequence(!options.files.want_intervals() && !options.stop.error &&
                           !options.stop.budget_s);
  client::Picture picture;
  v1::RenderImageResponse last;
  std::string description;
  if (options.servers) {
    client::RenderJobResult result =
        options.servers.render(session, options.scene, request, preview);
    picture = std::move(result.picture);
    *last.mutable_cost() = result.cost;
    description = describe_mixed(result.report);
    if (!description.empty()) shell::print_text(stderr, "{}\n", description);
  } else {
    request.set_scene_id(session.query_scene_id(options.scene));
    std::tie(picture, last) = render_picture(session, request, preview);
  }
  preview.files_done();

  files.write(picture, description, options.stop.confidence(), options.exposure_ev);
  preview.finish();
  const v1::Accuracy& accuracy = request.accuracy();
  const TargetCheck target = check_target(picture, accuracy);
  if (session.json()) {
    std::string more = json_of_approximate(accuracy);
    if (accuracy.has_target_error())
      more += fmt::format(",\"pixelsNotReached\":{}", target.missed());
    if (!picture.upper.empty())
      more += fmt::format(",\"pixelsWithoutLight\":{}", pixels_without_light(picture));
    if (picture.may_miss_light) more += ",\"mayMissLight\":true";
    shell::print_text(stdout, "{}", to_json(last, more));
  } else {
    const std::string counts =
        options.stop.error || options.stop.budget_s ? describe_samples(picture.samples) + "; " : "";
    const auto most = std::max_element(picture.samples.begin(), picture.samples.end());
    shell::print_text(
        stdout, "{}: {} x {} pixels; {}{}{}{}{}{}{}\n", fmt::join(options.files.pictures, ", "),
        picture.width, picture.height, counts, files.summary(), target.describe("pixels"),
        describe_overrun(accuracy, last.cost(), most == picture.samples.end() ? 0 : *most, "pixel"),
        picture.may_miss_light ? "light by way of curved smooth surfaces may be missing; " : "",
        describe(last.cost()), describe_approximations(accuracy, last.cost()));
    session.print_remarks();
  }
  std::fflush(stdout);  // so that a reader sees each frame at once
}

/// Renders the frames one after the other.  Each has the bits of a `render` without --frames.
void render_frames(Session& session, const RenderOptions& options) {
  check(options);
  if (options.preview.redraw_s > 0 && options.frames.skip_existing)
    wrong_use("--preview and --skip-existing: a preview would count as a finished picture");
  Preview preview(options.preview, options.files.pictures);
  const FrameNames names{options.scene, options.files, options.servers.journal};
  RenderOptions one = options;  // outlives the run, whose loads refer to its members
  FrameRun run(session, options.frames.plan(names, options.time.given()),
               options.frames.skip_existing, static_cast<bool>(options.servers));
  while (const Frame* frame = run.next()) {
    one.frame = frame;
    if (one.scene != frame->scene) one.scene = frame->scene;
    one.files = frame->files;
    one.servers.journal = frame->journal;
    one.servers.held = &run.held();
    render(session, one, preview);
    run.done();
  }
}

}  // namespace

void add_render_command(CLI::App& app, Session& session) {
  CLI::App* command = app.add_subcommand("render", "Render the picture of the scene's camera");
  command->footer(
      "Example:\n  lucerna render room.pbrt -o room.png --samples 256 --exposure -2\n"
      "  lucerna render room.pbrt -o room.exr --error 1% --floor 0.01 --counts samples.exr\n"
      "  lucerna render --servers a:50051,b:50051 --upload room.pbrt -o room.exr\n"
      "  lucerna render room.pbrt -o room.png --preview=5 --tev localhost\n"
      "  lucerna render flight.pbrt --frames 1-240 --fps 24 -o flight.%04d.exr\n"
      "If SCENE has a place for the frame number, each frame has its own scene file with its\n"
      "own shutter.  Otherwise frame 1 has the shutter of the scene file, and the shutter of each\n"
      "further frame opens 1/fps later.\n"
      "--json prints the last RenderImageResponse without its tile, one line for each frame, and\n"
      "`approximate`, whether you chose an approximation (--far-light, --visibility shadow-maps,\n"
      "--thin-glass blocks);\n"
      "with --error also `pixelsNotReached`, the number of pixels that missed the target;\n"
      "with --error, --stderr or --interval also `pixelsWithoutLight`, the number of pixels\n"
      "whose samples found no light.");
  const auto options = std::make_shared<RenderOptions>();
  command->add_option("SCENE", options->scene, kSceneHelp)->required();
  options->files.add(*command);
  // A pixel's luminance is in this unit.
  options->stop.add(*command, "pixel", "as in the scene file", "cd/m2 times the film's scale");
  options->methods.add(*command);
  options->time.add(*command, "the whole time that the shutter is open");
  command->add_option("--seed", options->seed, "Random seed of the experiment")
      ->check(whole64())
      ->capture_default_str();
  command
      ->add_option("--bounces", options->bounces,
                   "Most reflections after the first surface, 0 for direct light; default: as in "
                   "the scene file, or no limit")
      ->check(whole(0));
  command
      ->add_option("--tile-size", options->tile_size,
                   "Width and height of a tile [pixels]; default 64")
      ->check(whole(1));
  command
      ->add_option("--exposure", options->exposure_ev,
                   "PNG only: multiply the brightness by 2 to this power [EV]")
      ->check(
          checked_number("a number from -100 to 100", [](double v) { return std::fabs(v) <= 100; }))
      ->capture_default_str();
  options->preview.add(*command);
  options->servers.add(*command);
  options->frames.add(*command);
  command->callback([options, &session] {
    options->frames.check();
    if (options->frames) return render_frames(session, *options);
    Preview preview(options->preview, options->files.pictures);
    render(session, *options, preview);
  });
}

}  // namespace lucerna::cli
