// render --frames: the pictures of an animation, one after the other.
#pragma once

#include <CLI/CLI.hpp>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "client/jobs/held_scene.h"
#include "client/terminal/session.h"
#include "lucerna/v1/render.pb.h"

namespace lucerna::cli {

/// "7", "1-240" or "1-240:2".
struct FrameRange {
  std::uint64_t first = 0, last = 0, step = 1;

  /// INVALID_ARGUMENT for what is none, runs backwards or has more than a million frames.
  static absl::StatusOr<FrameRange> parse(const std::string& text);
  std::uint64_t count() const { return (last - first) / step + 1; }
};

/// A file name with one place for a frame's number: %d, or %04d for four digits at least; %% stands
/// for a percent sign.
class FramePattern {
 public:
  /// INVALID_ARGUMENT for none, more than one, and anything else after a percent sign.
  static absl::StatusOr<FramePattern> create(const std::string& text);
  std::string name(std::uint64_t frame) const;

 private:
  std::string before_, after_;
  int digits_ = 1;
};

/// What is rendered from what into what.
struct Frame {
  std::uint64_t number = 0;
  std::string scene;
  bool own_scene = false;  ///< a file for this frame alone
  std::vector<std::string> outputs;
  std::string error_output;         ///< empty: none
  std::string counts_output;        ///< empty: none
  std::string journal;              ///< empty: none
  double later_s = 0;               ///< than frame 1
  std::optional<double> shutter_s;  ///< unset: as long as the scene file says

  /// Moves the moment, or the shutter, to the frame's place in time.  A scene file of the frame's
  /// own has it already.
  void put(v1::RenderImageRequest& request) const;
};

/// As the command line has them, with their patterns.
struct FrameNames {
  std::string scene;
  std::vector<std::string> outputs;
  std::string error_output;
  std::string counts_output;
  std::string journal;
};

struct FramesOption {
  std::string frames;
  std::optional<double> fps;
  std::optional<double> shutter_s;
  bool skip_existing = false;

  void add(CLI::App& command);
  explicit operator bool() const { return !frames.empty(); }
  /// Ends the program where the others are given without --frames.
  void check() const;
  /// All frames in order.  Ends the program for patterns that cannot be, files that cannot be
  /// written and frames that would write the same one.  `at_moment`: --time is given.
  std::vector<Frame> plan(const FrameNames& names, bool at_moment) const;
};

/// Goes through the frames: brings each one's scene to where it is rendered, and lets go of it.
class FrameRun {
 public:
  /// `many`: the scenes go to the servers of a job, by `held()`, and not to the session's.
  FrameRun(Session& session, std::vector<Frame> frames, bool skip_existing, bool many)
      : session_(session), frames_(std::move(frames)), skip_existing_(skip_existing), many_(many) {}

  /// The next frame that is to be rendered, null after the last.  Its scene is, where it is not for
  /// many servers, the id of one that is loaded.
  const Frame* next();
  /// What `next` gave last is written.
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
