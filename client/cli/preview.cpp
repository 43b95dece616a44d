#include "client/cli/preview.h"

#include <fmt/core.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <map>
#include <mutex>
#include <stop_token>
#include <thread>
#include <utility>

#include "client/terminal/print.h"
#include "client/terminal/session.h"
#include "client/terminal/validators.h"

namespace lucerna::cli {
namespace {

using client::PictureFile;
using client::PictureFormat;

constexpr double kShortestRedraw_s = 0.1;
constexpr double kLongestRedraw_s = 86400;
// A working viewer takes all bytes within milliseconds.
constexpr std::chrono::milliseconds kTevPatience(1000);

// A preview keeps the whole picture, and a server may name any size.
constexpr std::uint64_t kMostPixels = std::uint64_t{1} << 26;

}  // namespace

/// Draws the newest picture into files, in its own thread with its own copy of the picture.  The
/// caller of update() waits only until the tile is handed over.
class Preview::Redraw {
 public:
  Redraw(std::vector<PictureFile*> files, double exposure_ev, double every_s)
      : files_(std::move(files)),
        exposure_ev_(exposure_ev),
        every_(every_s),
        thread_([this](const std::stop_token& stop) { run(stop); }) {}

  void update(const v1::Tile& tile, std::vector<float> rgb) {
    const v1::PixelRect& rect = tile.rect();
    const std::lock_guard lock(mutex_);
    width_ = tile.image_width();
    height_ = tile.image_height();
    // Rectangles are equal or disjoint, so the newest part of each rectangle needs at most one
    // picture of memory.
    Part& part = waiting_[{rect.x0(), rect.y0()}];
    part.rect = rect;
    part.rgb.swap(rgb);
    wake_.notify_all();
  }

 private:
  struct Part {
    v1::PixelRect rect;
    std::vector<float> rgb;
  };
  using Parts = std::map<std::pair<std::uint32_t, std::uint32_t>, Part>;  // by the corner (x0, y0)

  void run(const std::stop_token& stop) {
    client::Picture picture;
    std::unique_lock lock(mutex_);
    while (wake_.wait(lock, stop, [this] { return !waiting_.empty(); }) && !stop.stop_requested()) {
      Parts parts = std::exchange(waiting_, {});
      picture.width = width_;
      picture.height = height_;
      lock.unlock();
      picture.pixels.resize(std::size_t{3} * picture.width * picture.height);
      for (const auto& [place, part] : parts) client::put_pixels(part.rect, part.rgb, &picture);
      parts.clear();
      const bool drawn = draw(picture);
      lock.lock();
      if (!drawn) return;
      // The pause starts when the drawing ends, so that large pictures do not keep a core busy.
      wake_.wait_for(lock, stop, every_, [] { return false; });
    }
  }

  bool draw(const client::Picture& picture) {
    for (PictureFile* file : files_) {
      const absl::Status status = file->write_preview(
          {.width = picture.width, .height = picture.height, .rgb = picture.pixels}, exposure_ev_);
      if (status.ok()) continue;
      shell::print_text(stderr, "--preview: {}; the preview stops\n",
                        std::string(status.message()));
      return false;
    }
    return true;
  }

  const std::vector<PictureFile*> files_;
  const double exposure_ev_;
  const std::chrono::duration<double> every_;
  std::mutex mutex_;
  std::condition_variable_any wake_;
  std::uint32_t width_ = 0, height_ = 0;  // of the picture
  Parts waiting_;
  std::jthread thread_;  // the last member: it uses all others
};

void PreviewOption::add(CLI::App& command) {
  command
      .add_option("--tev", tev,
                  fmt::format("Show the unfinished picture in the viewer tev; default port {}",
                              client::kTevPort))
      ->type_name("HOST[:PORT]");
  // A flag never takes the next word as its value.  CLI11 reads the values of flags as whole
  // numbers or as text, so this is text.
  command
      .add_flag("--preview{2}", redraw_text,
                "Redraw the unfinished PNGs every 2 s, or every =SECONDS; missing tiles are black")
      ->check(checked_number(
          fmt::format("a number of seconds from {} to {}", kShortestRedraw_s, kLongestRedraw_s),
          [](double v) { return v >= kShortestRedraw_s && v <= kLongestRedraw_s; }))
      ->each([this](const std::string& seconds) { redraw_s = std::stod(seconds); });
}

Preview::Preview(const PreviewOption& option, const std::vector<std::string>& outputs)
    : redraw_s_(option.redraw_s) {
  const auto is_png = [](const std::string& path) {
    const auto format = client::picture_format(path);
    return format.ok() && *format == PictureFormat::kPng;
  };
  if (redraw_s_ > 0 && std::none_of(outputs.begin(), outputs.end(), is_png)) {
    wrong_use("--preview redraws PNGs, so an -o must end in .png");
  }
  if (option.tev.empty()) return;
  auto sender = client::TevSender::create(
      option.tev, [](const std::string& event) { shell::print_text(stderr, "{}\n", event); });
  if (!sender.ok()) wrong_use("--tev: " + std::string(sender.status().message()));
  sender_ = *std::move(sender);
}

Preview::~Preview() = default;

void Preview::begin(std::vector<PictureFile>& files, double exposure_ev) {
  name_ = files.front().path();
  begun_ = false;
  if (redraw_s_ == 0) return;
  std::vector<PictureFile*> pngs;
  for (PictureFile& file : files) {
    if (file.format() == PictureFormat::kPng) pngs.push_back(&file);
  }
  redraw_ = std::make_unique<Redraw>(std::move(pngs), exposure_ev, redraw_s_);
}

void Preview::update(const v1::Tile& tile, const client::PictureAssembler& so_far) {
  if (!*this) return;
  if (std::uint64_t{tile.image_width()} * tile.image_height() > kMostPixels) {
    if (!std::exchange(begun_, true))
      shell::print_text(stderr, "no preview: the picture has more than {} pixels\n", kMostPixels);
    return;
  }
  auto rgb = so_far.pixels(tile.rect());
  if (!rgb.ok()) return;
  // The sizes fit, as the tile is part of this picture already.
  if (sender_) {
    if (!std::exchange(begun_, true)) {
      sender_->begin(name_, tile.image_width(), tile.image_height()).IgnoreError();
    }
    sender_->update(tile.rect(), *rgb).IgnoreError();
  }
  if (redraw_) redraw_->update(tile, *std::move(rgb));
}

void Preview::files_done() { redraw_.reset(); }

void Preview::finish() {
  if (sender_ && begun_) sender_->flush(kTevPatience);
}

}  // namespace lucerna::cli
