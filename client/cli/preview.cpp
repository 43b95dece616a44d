#include "client/cli/preview.h"

#include <fmt/core.h>

#include <algorithm>
#include <chrono>
#include <condition_variable>
#include <mutex>
#include <stop_token>
#include <thread>
#include <utility>

#include "client/cli/session.h"
#include "client/cli/validators.h"

namespace lucerna::cli {
namespace {

using client::PictureFile;
using client::PictureFormat;

constexpr double kShortestRedraw_s = 0.1;
constexpr double kLongestRedraw_s = 86400;
// A viewer that is well takes all there is in no time.
constexpr std::chrono::milliseconds kTevPatience(1000);

}  // namespace

/// Draws the newest picture into files, in a thread of its own.
class Preview::Redraw {
 public:
  Redraw(std::vector<PictureFile*> files, double exposure_ev, double every_s)
      : files_(std::move(files)),
        exposure_ev_(exposure_ev),
        every_(every_s),
        thread_([this](const std::stop_token& stop) { run(stop); }) {}

  void update(const v1::Tile& tile, const std::vector<float>& rgb) {
    const std::lock_guard lock(mutex_);
    if (newest_.pixels.empty()) {
      newest_.width = tile.image_width();
      newest_.height = tile.image_height();
      newest_.pixels.resize(std::size_t{3} * newest_.width * newest_.height);
    }
    client::put_pixels(tile.rect(), rgb, &newest_);
    changed_ = true;
    wake_.notify_all();
  }

 private:
  void run(const std::stop_token& stop) {
    client::Picture picture;
    std::unique_lock lock(mutex_);
    while (wake_.wait(lock, stop, [this] { return changed_; }) && !stop.stop_requested()) {
      picture = newest_;
      changed_ = false;
      lock.unlock();
      const bool drawn = draw(picture);
      lock.lock();
      if (!drawn) return;
      // From the end of the drawing, so that large pictures do not keep a core busy.
      wake_.wait_for(lock, stop, every_, [] { return false; });
    }
  }

  bool draw(const client::Picture& picture) {
    for (PictureFile* file : files_) {
      const absl::Status status = file->write_preview(
          {.width = picture.width, .height = picture.height, .rgb = picture.pixels}, exposure_ev_);
      if (status.ok()) continue;
      fmt::print(stderr, "--preview: {}; draws no more\n", std::string(status.message()));
      return false;
    }
    return true;
  }

  const std::vector<PictureFile*> files_;
  const double exposure_ev_;
  const std::chrono::duration<double> every_;
  std::mutex mutex_;
  std::condition_variable_any wake_;
  client::Picture newest_;
  bool changed_ = false;
  std::jthread thread_;  // the last: it uses all of the above
};

void PreviewOption::add(CLI::App& command) {
  command
      .add_option("--tev", tev,
                  fmt::format("Show the picture in the viewer tev as it comes; port {} unless "
                              "another is said",
                              client::kTevPort))
      ->type_name("HOST[:PORT]");
  // A flag with a value, =SECONDS, which never takes the word after it for one.  CLI11 takes only
  // whole numbers as the values of flags, and any text.
  command
      .add_flag("--preview{2}", redraw_text,
                "Redraw the PNGs among the outputs as tiles come, every 2 s, or =SECONDS; what is "
                "still to come is black")
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
      option.tev, [](const std::string& event) { fmt::print(stderr, "{}\n", event); });
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
  const auto rgb = so_far.pixels(tile.rect());
  if (!rgb.ok()) return;
  // They fit: the tile has become part of a picture of this size.
  if (sender_) {
    if (!std::exchange(begun_, true)) {
      sender_->begin(name_, tile.image_width(), tile.image_height()).IgnoreError();
    }
    sender_->update(tile.rect(), *rgb).IgnoreError();
  }
  if (redraw_) redraw_->update(tile, *rgb);
}

void Preview::files_done() { redraw_.reset(); }

void Preview::finish() {
  if (sender_ && begun_) sender_->flush(kTevPatience);
}

}  // namespace lucerna::cli
