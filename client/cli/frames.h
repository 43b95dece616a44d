// render --frames: the pictures of an animation, one after the other.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "client/cli/picture_files.h"
#include "client/library/held_scene.h"
#include "client/terminal/session.h"
#include "lucerna/v1/render.pb.h"

namespace CLI {
class App;
}

namespace lucerna::cli {

/// Frame numbers as the user types them: "7", "1-240" or "1-240:2".
struct FrameRange {
  std::uint64_t first = 0, last = 0, step = 1;

  /// INVALID_ARGUMENT for other texts, ranges whose end is before their beginning, and more than a
  /// million frames.
  static absl::StatusOr<FrameRange> parse(const std::string& text);
  std::uint64_t count() const { return (last - first) / step + 1; }
};

/// A file name with one place for the number of a frame: %d, or %04d for at least four digits.  %%
/// is a percent sign.
class FramePattern {
 public:
  /// INVALID_ARGUMENT for no place, more than one, and anything else after a percent sign.
  static absl::StatusOr<FramePattern> create(const std::string& text);
  std::string name(std::uint64_t frame) const;

 private:
  std::string before_, after_;
  int digits_ = 1;
};

/// One picture of an animation: its scene and its files.
struct Frame {
  std::uint64_t number = 0;
  std::string scene;
  bool own_scene = false;  ///< only this frame uses the scene file
  PictureNames files{};
  std::string journal;              ///< empty: none
  double later_s = 0;               ///< time after frame 1
  std::optional<double> shutter_s;  ///< unset: as in the scene file

  /// Sets the moment or the shutter to the time of the frame.  If the frame has its own scene file,
  /// the request stays unchanged, since that file has its own shutter.
  void put(v1::RenderImageRequest& request) const;
};

/// The names on the command line, with their patterns.
struct FrameNames {
  std::string scene;
  PictureNames files{};
  std::string journal;
};

struct FramesOption {
  std::string frames;
  std::optional<double> fps;
  std::optional<double> shutter_s;
  bool skip_existing = false;

  void add(CLI::App& command);
  explicit operator bool() const { return !frames.empty(); }
  /// Ends the program if the other options are given without --frames.
  void check() const;
  /// All frames in order.  Ends the program for wrong patterns, files that cannot be written, and
  /// frames that write the same file.  `at_moment`: --time is given.
  std::vector<Frame> plan(const FrameNames& names, bool at_moment) const;
};

/// Iterates over the frames.  Loads the scene of each frame, and releases it afterwards.
class FrameRun {
 public:
  /// `many`: held() loads the scenes on the servers of a job.  Otherwise the session loads them on
  /// its server.
  FrameRun(Session& session, std::vector<Frame> frames, bool skip_existing, bool many)
      : session_(session), frames_(std::move(frames)), skip_existing_(skip_existing), many_(many) {}

  /// The next frame to render; null after the last.  Without `many`, its scene is the id of a
  /// loaded scene.
  const Frame* next();
  /// Call it when the files of the last frame from next() are written.
  void done();
  client::HeldScene& held() { return held_; }

 private:
  bool is_there(const Frame& frame) const;
  v1::LoadSceneResponse load(const Frame& frame);

  Session& session_;
  std::vector<Frame> frames_;
  bool skip_existing_, many_;
  std::size_t next_ = 0;
  Frame current_;
  client::HeldScene held_;
};

}  // namespace lucerna::cli
