// The files of one picture: the picture itself, its errors, its intervals and its sample counts.
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "client/files/write_picture.h"
#include "client/library/picture.h"

namespace CLI {
class App;
}

namespace lucerna::cli {

/// Names of files.  An empty name: not written.
struct PictureNames {
  std::vector<std::string> pictures{};
  std::string errors{}, intervals{}, counts{};

  /// Adds --output, --stderr, --interval and --counts.
  void add(CLI::App& command);
  /// Ends the program for file types that cannot hold the values, and for errors of one sample.
  void check(std::optional<std::uint32_t> samples) const;
  bool want_intervals() const { return !errors.empty() || !intervals.empty(); }
};

/// Number of pixels whose samples all missed the light.  Their upper bounds are above 0.
std::size_t pixels_without_light(const client::Picture& picture);

class PictureFiles {
 public:
  /// Ends the program, before anything is rendered, if a file cannot be written or is named twice.
  explicit PictureFiles(const PictureNames& names);

  std::vector<client::PictureFile>& pictures() { return pictures_; }

  /// Writes all files.  `description` becomes part of them.  `confidence`: of the intervals.
  /// Throws CommandError.
  void write(const client::Picture& picture, const std::string& description, double confidence,
             double exposure_ev);

  /// What the files of errors and intervals hold, after write(): "e.exr: standard errors, upper
  /// bounds at 12 pixels without light; i.exr: 95% confidence intervals; ".  Empty without such
  /// files.
  const std::string& summary() const { return summary_; }

 private:
  std::vector<client::PictureFile> pictures_;
  std::optional<client::PictureFile> errors_, intervals_, counts_;
  std::string summary_;
};

}  // namespace lucerna::cli
