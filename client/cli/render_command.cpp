// The command render.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <chrono>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <set>
#include <tuple>
#include <utility>

#include "absl/cleanup/cleanup.h"
#include "client/cli/commands.h"
#include "client/cli/frames.h"
#include "client/cli/preview.h"
#include "client/cli/render_servers.h"
#include "client/files/write_picture.h"
#include "client/jobs/picture.h"
#include "client/terminal/certainty.h"
#include "client/terminal/luminance.h"
#include "client/terminal/method_options.h"
#include "client/terminal/output.h"
#include "client/terminal/progress.h"
#include "client/terminal/session.h"
#include "client/terminal/stop_option.h"
#include "client/terminal/time_option.h"
#include "client/terminal/validators.h"

namespace lucerna::cli {
namespace {

using client::PictureFile;

struct RenderOptions {
  std::string scene;
  std::vector<std::string> outputs;
  std::string error_output, counts_output;
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

/// Ends the program before rendering if the file cannot be written.
PictureFile create(const std::string& path) {
  auto file = PictureFile::create(path);
  if (!file.ok()) wrong_use(std::string(file.status().message()));
  return *std::move(file);
}

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

void write(PictureFile file, const client::Picture& picture, const std::vector<float>& values,
           const std::string& description, double exposure_ev) {
  const absl::Status status = file.write(
      {.width = picture.width, .height = picture.height, .rgb = values, .description = description},
      exposure_ev);
  if (!status.ok()) throw CommandError(kServerRefused, std::string(status.message()));
}

/// "samples per pixel: at least 64, median 256, at most 4096".
std::string describe_samples(std::vector<std::uint32_t> samples) {
  const auto [least, most] = std::minmax_element(samples.begin(), samples.end());
  const std::string ends[] = {fmt::format("{}", *least), fmt::format("{}", *most)};
  const auto middle = samples.begin() + static_cast<std::ptrdiff_t>((samples.size() - 1) / 2);
  std::nth_element(samples.begin(), middle, samples.end());
  return fmt::format("samples per pixel: at least {}, median {}, at most {}", ends[0], *middle,
                     ends[1]);
}

/// Checks the luminance of each pixel.
TargetCheck check_target(const client::Picture& picture, const v1::TargetError& target) {
  TargetCheck check(target);
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
  if (!options.error_output.empty() && options.stop.samples == 1U)
    wrong_use("--stderr: a single sample has no standard error; --samples must be 2 or more");
  const auto format = client::picture_format(options.counts_output);
  if (!options.counts_output.empty() && format.ok() && *format == client::PictureFormat::kPng)
    wrong_use("--counts " + options.counts_output +
              ": 8 bits cannot store counts; must be .exr or .pfm");
}

void render(Session& session, const RenderOptions& options, Preview& preview) {
  check(options);
  if (!options.servers) session.need_one_server("a picture on several servers requires --servers");
  std::vector<PictureFile> files;
  std::set<std::filesystem::path> names;
  const auto add = [&](const std::string& path) {
    if (!names.insert(std::filesystem::absolute(path).lexically_normal()).second) {
      wrong_use("-o, --stderr and --counts: " + path + " is given twice");
    }
    return create(path);
  };
  for (const std::string& path : options.outputs) files.push_back(add(path));
  std::optional<PictureFile> error_file, counts_file;
  if (!options.error_output.empty()) error_file = add(options.error_output);
  if (!options.counts_output.empty()) counts_file = add(options.counts_output);
  // --skip-existing would take a preview for the picture.
  if (options.frame != nullptr) {
    for (PictureFile& file : files) file.keep_no_preview();
  }
  preview.begin(files, options.exposure_ev);
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
  client::Picture picture;
  v1::RenderImageResponse last;
  std::string description;
  if (options.servers) {
    client::RenderJobResult result =
        options.servers.render(session, options.scene, request, preview);
    picture = std::move(result.picture);
    *last.mutable_cost() = result.cost;
    description = describe_mixed(result.report);
    if (!description.empty()) fmt::print(stderr, "{}\n", description);
  } else {
    request.set_scene_id(session.query_scene_id(options.scene));
    std::tie(picture, last) = render_picture(session, request, preview);
  }
  preview.files_done();

  if (error_file && picture.standard_error.empty()) {
    throw CommandError(kServerRefused, "--stderr: a single block of samples has no standard error");
  }
  for (PictureFile& file : files) {
    write(std::move(file), picture, picture.pixels, description, options.exposure_ev);
  }
  if (error_file) {
    write(*std::move(error_file), picture, picture.standard_error, description,
          options.exposure_ev);
  }
  if (counts_file) {
    // Pictures have three channels, so a count becomes grey.
    std::vector<float> counts;
    counts.reserve(picture.pixels.size());
    for (const std::uint32_t n : picture.samples)
      counts.insert(counts.end(), 3, static_cast<float>(n));
    write(*std::move(counts_file), picture, counts, description, 0);
  }
  preview.finish();
  const v1::Accuracy& accuracy = request.accuracy();
  const TargetCheck target = check_target(picture, accuracy.target_error());
  if (session.json()) {
    std::string more = json_of_approximate(accuracy);
    if (accuracy.has_target_error())
      more += fmt::format(",\"pixelsNotReached\":{}", target.missed());
    fmt::print("{}", to_json(last, more));
  } else {
    const std::string counts =
        options.stop.error || options.stop.budget_s ? describe_samples(picture.samples) + "; " : "";
    const auto most = std::max_element(picture.samples.begin(), picture.samples.end());
    fmt::print(
        "{}: {} x {} pixels; {}{}{}{}{}\n", fmt::join(options.outputs, ", "), picture.width,
        picture.height, counts, target.describe("pixels"),
        describe_overrun(accuracy, last.cost(), most == picture.samples.end() ? 0 : *most, "pixel"),
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
  Preview preview(options.preview, options.outputs);
  const FrameNames names{options.scene, options.outputs, options.error_output,
                         options.counts_output, options.servers.journal};
  RenderOptions one = options;  // outlives the run, whose loads refer to its members
  FrameRun run(session, options.frames.plan(names, options.time.given()),
               options.frames.skip_existing, static_cast<bool>(options.servers));
  while (const Frame* frame = run.next()) {
    one.frame = frame;
    if (one.scene != frame->scene) one.scene = frame->scene;
    one.outputs = frame->outputs;
    one.error_output = frame->error_output;
    one.counts_output = frame->counts_output;
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
      "`approximate`, whether you chose an approximation (--far-light, --visibility shadow-maps);\n"
      "with --error also `pixelsNotReached`, the number of pixels that missed the target.");
  const auto options = std::make_shared<RenderOptions>();
  command->add_option("SCENE", options->scene, kSceneHelp)->required();
  command
      ->add_option("-o,--output", options->outputs,
                   "File of the picture: .exr or .pfm (linear RGB, 32-bit float) or .png (8-bit "
                   "sRGB); may be repeated")
      ->allow_extra_args(false)
      ->required();
  command->add_option("--stderr", options->error_output,
                      "Also write a picture of the standard error of each pixel");
  command->add_option("--counts", options->counts_output,
                      "Also write a picture of the number of samples of each pixel: .exr or .pfm");
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
    Preview preview(options->preview, options->outputs);
    render(session, *options, preview);
  });
}

}  // namespace lucerna::cli
