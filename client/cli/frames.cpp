#include "client/cli/frames.h"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <charconv>
#include <cstdio>
#include <filesystem>
#include <map>
#include <set>
#include <utility>

#include "client/files/write_picture.h"
#include "client/terminal/print.h"
#include "client/terminal/validators.h"

namespace lucerna::cli {
namespace {

namespace fs = std::filesystem;

constexpr std::uint64_t kMostFrames = 1000000;
constexpr std::uint64_t kLastFrame = 999999999;
constexpr double kDefaultFps = 24;

/// Removes the number at the beginning of `text` and returns it.
std::optional<std::uint64_t> take_number(std::string_view& text) {
  std::uint64_t value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc() || value > kLastFrame) return std::nullopt;
  text.remove_prefix(static_cast<std::size_t>(end - text.data()));
  return value;
}

bool take(std::string_view& text, char c) {
  if (text.empty() || text.front() != c) return false;
  text.remove_prefix(1);
  return true;
}

FramePattern pattern(const std::string& option, const std::string& text) {
  auto made = FramePattern::create(text);
  if (!made.ok()) wrong_use(option + ": " + std::string(made.status().message()));
  return *std::move(made);
}

/// Finds files that cannot be written, and files that would be written twice, before rendering.
class Outputs {
 public:
  void add(const std::string& path, std::uint64_t frame, bool is_picture) {
    const fs::path name = fs::absolute(path).lexically_normal();
    const auto [other, is_new] = names_.try_emplace(name, frame);
    if (!is_new && other->second == frame)
      wrong_use(fmt::format("frame {} would write {} twice", frame, path));
    if (!is_new)
      wrong_use(fmt::format("frames {} and {} would both write {}", other->second, frame, path));
    // Trying one file of each folder and format is enough.
    if (!is_picture || !places_.emplace(name.parent_path(), name.extension()).second) return;
    const auto file = client::PictureFile::create(path);
    if (!file.ok()) wrong_use(std::string(file.status().message()));
  }

 private:
  std::map<fs::path, std::uint64_t> names_;
  std::set<std::pair<fs::path, fs::path>> places_;
};

}  // namespace

absl::StatusOr<FrameRange> FrameRange::parse(const std::string& text) {
  FrameRange range;
  std::string_view rest = text;
  const auto first = take_number(rest);
  auto last = first;
  std::optional<std::uint64_t> step = 1;
  if (first && take(rest, '-')) last = take_number(rest);
  if (last && take(rest, ':')) step = take_number(rest);
  if (!first || !last || !step || !rest.empty()) {
    return absl::InvalidArgumentError(fmt::format(
        "\"{}\" is not a range of frames, allowed: N, A-B or A-B:STEP with whole numbers up to {}",
        text, kLastFrame));
  }
  range = {*first, *last, *step};
  if (range.last < range.first) {
    return absl::InvalidArgumentError(
        fmt::format("\"{}\" ends before it begins, allowed: A-B with A not after B", text));
  }
  if (range.step == 0) {
    return absl::InvalidArgumentError(
        fmt::format("\"{}\" has a step of 0, allowed: 1 or more", text));
  }
  if (range.count() > kMostFrames) {
    return absl::InvalidArgumentError(
        fmt::format("\"{}\" names {} frames, allowed: up to {}", text, range.count(), kMostFrames));
  }
  return range;
}

absl::StatusOr<FramePattern> FramePattern::create(const std::string& text) {
  FramePattern made;
  int places = 0;
  for (std::string_view rest = text; !rest.empty();) {
    std::string& part = places == 0 ? made.before_ : made.after_;
    const char c = rest.front();
    rest.remove_prefix(1);
    if (c != '%') {
      part += c;
      continue;
    }
    if (take(rest, '%')) {
      part += '%';
      continue;
    }
    const std::string_view from = rest;
    int digits = 1;
    if (take(rest, '0') && !rest.empty() && rest.front() >= '1' && rest.front() <= '9') {
      digits = rest.front() - '0';
      rest.remove_prefix(1);
    }
    if (!take(rest, 'd')) {
      return absl::InvalidArgumentError(
          fmt::format("\"{}\" has \"%{}\", which is not a frame number, allowed: %d, %04d for "
                      "four digits (1 to 9), and %% for a percent sign",
                      text, from.substr(0, 3)));
    }
    ++places;
    made.digits_ = digits;
  }
  if (places != 1) {
    return absl::InvalidArgumentError(
        fmt::format("\"{}\" has {} for the frame's number, needed: one, such as %04d", text,
                    places == 0 ? std::string("no place") : fmt::format("{} places", places)));
  }
  return made;
}

std::string FramePattern::name(std::uint64_t frame) const {
  return fmt::format("{}{:0{}}{}", before_, frame, digits_, after_);
}

void Frame::put(v1::RenderImageRequest& request) const {
  if (own_scene) return;
  if (request.has_time_s()) {
    request.set_time_s(request.time_s() + later_s);
    return;
  }
  request.mutable_shutter()->set_offset_s(later_s);
  if (shutter_s) request.mutable_shutter()->set_length_s(*shutter_s);
}

void FramesOption::add(CLI::App& command) {
  command
      .add_option("--frames", frames,
                  "Render the frames N, A-B or A-B:STEP of an animation; %d or %04d in SCENE and "
                  "in the file names is replaced by the frame number")
      ->type_name("RANGE");
  command
      .add_option(
          "--fps", fps,
          fmt::format("With --frames of one scene: frames per second; default {:g}", kDefaultFps))
      ->check(positive());
  command
      .add_option("--shutter", shutter_s,
                  "With --frames of one scene: time that the shutter is open for a frame [s]; "
                  "default: as in the scene file")
      ->check(positive());
  command.add_flag("--skip-existing", skip_existing,
                   "With --frames: skip frames whose files all exist");
}

void FramesOption::check() const {
  if (!frames.empty()) return;
  const auto needs = [](bool given, const char* name) {
    if (given) wrong_use(fmt::format("{} requires --frames", name));
  };
  needs(fps.has_value(), "--fps");
  needs(shutter_s.has_value(), "--shutter");
  needs(skip_existing, "--skip-existing");
}

std::vector<Frame> FramesOption::plan(const FrameNames& names, bool at_moment) const {
  const auto range = FrameRange::parse(frames);
  if (!range.ok()) wrong_use("--frames: " + std::string(range.status().message()));
  std::optional<FramePattern> scene, errors, intervals, counts, journal;
  if (names.scene.find('%') != std::string::npos) {
    scene = pattern("SCENE", names.scene);
    const auto needs_one_scene = [](bool given, const char* name) {
      if (given)
        wrong_use(
            fmt::format("{} requires one scene file for all frames, since a scene file for each "
                        "frame has its own shutter",
                        name));
    };
    needs_one_scene(fps.has_value(), "--fps");
    needs_one_scene(shutter_s.has_value(), "--shutter");
  }
  if (shutter_s && at_moment) wrong_use("--shutter and --time: a moment has no length");
  std::vector<FramePattern> outputs;
  for (const std::string& path : names.files.pictures) outputs.push_back(pattern("--output", path));
  if (!names.files.errors.empty()) errors = pattern("--stderr", names.files.errors);
  if (!names.files.intervals.empty()) intervals = pattern("--interval", names.files.intervals);
  if (!names.files.counts.empty()) counts = pattern("--counts", names.files.counts);
  if (!names.journal.empty()) journal = pattern("--journal", names.journal);

  std::vector<Frame> planned;
  planned.reserve(range->count());
  Outputs written;
  for (std::uint64_t n = range->first; n <= range->last; n += range->step) {
    Frame& frame = planned.emplace_back();
    frame.number = n;
    frame.scene = scene ? scene->name(n) : names.scene;
    frame.own_scene = scene.has_value();
    frame.later_s = (static_cast<double>(n) - 1) / fps.value_or(kDefaultFps);
    frame.shutter_s = shutter_s;
    for (const FramePattern& p : outputs)
      written.add(frame.files.pictures.emplace_back(p.name(n)), n, true);
    if (errors) written.add(frame.files.errors = errors->name(n), n, true);
    if (intervals) written.add(frame.files.intervals = intervals->name(n), n, true);
    if (counts) written.add(frame.files.counts = counts->name(n), n, true);
    if (journal) written.add(frame.journal = journal->name(n), n, false);
  }
  return planned;
}

bool FrameRun::is_there(const Frame& frame) const {
  const auto exists = [](const std::string& path) {
    std::error_code ignored;
    return fs::is_regular_file(path, ignored);
  };
  const PictureNames& files = frame.files;
  const auto is_done = [&](const std::string& path) { return path.empty() || exists(path); };
  return std::all_of(files.pictures.begin(), files.pictures.end(), exists) &&
         is_done(files.errors) && is_done(files.intervals) && is_done(files.counts);
}

const Frame* FrameRun::next() {
  for (; next_ < frames_.size(); ++next_) {
    current_ = frames_[next_];
    if (skip_existing_ && is_there(current_)) {
      if (!session_.json()) {
        shell::print_text(stdout, "{}: exists already\n", fmt::join(current_.files.pictures, ", "));
        std::fflush(stdout);
      }
      continue;
    }
    if (!many_) {
      auto scene = session_.value_or_fail(held_.renew(session_.client(), session_.call_options()));
      if (!scene) held_.hold(session_.client(), scene.emplace(load(current_)));
      current_.scene = scene->scene_id();
    }
    ++next_;
    return &current_;
  }
  held_.release(false, session_.call_options());
  return nullptr;
}

void FrameRun::done() {
  // The pictures are written, so the journal is not needed any more.
  std::error_code ignored;
  if (!current_.journal.empty()) fs::remove(current_.journal, ignored);
  if (current_.own_scene) held_.release(true, session_.call_options());
}

v1::LoadSceneResponse FrameRun::load(const Frame& frame) {
  const auto lease_s = static_cast<double>(client::kJobLease.count());
  if (frame.own_scene) {
    v1::LoadSceneResponse loaded = load_scene(session_, frame.scene, lease_s);
    if (!loaded.already_loaded()) {
      for (const v1::Remark& remark : loaded.remarks())
        shell::print_text(stderr, "{}\n", describe(remark));
    }
    return loaded;
  }
  v1::LoadSceneResponse loaded;
  loaded.set_scene_id(session_.scene_id(frame.scene));
  loaded.set_already_loaded(true);
  v1::RenewLeaseRequest request;
  request.set_scene_id(loaded.scene_id());
  request.set_lease_s(lease_s);
  loaded.set_lease_id(
      session_.value_or_fail(session_.client().renew_lease(request, session_.call_options()))
          .lease_id());
  return loaded;
}

}  // namespace lucerna::cli
