// Points and vectors from arguments, CSV files and standard input.
#pragma once

#include <istream>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "lucerna/client/points.h"

namespace CLI {
class App;
}

namespace lucerna::cli {

using client::Double3;

struct PointSet {
  std::vector<Double3> points;
  /// A normal, a direction or a second point for each point; may be empty.
  std::vector<Double3> seconds;
};

enum class Triple { kPoint, kDirection };

/// Reads three numbers such as "1,2,-0.5".  INVALID_ARGUMENT for texts other than three finite
/// numbers.  Directions must be in the range of floats, and must not be 0 0 0 as floats.
absl::StatusOr<Double3> parse_triple(const std::string& text, Triple kind);

/// Reads any number of numbers, NaN and infinities included.  INVALID_ARGUMENT for other texts.
absl::StatusOr<std::vector<double>> parse_numbers(const std::string& text);

/// Reads the argument of --u for one sample: `count` numbers in [0, 1], two for a direction or four
/// for a ray.  With `chooses_light`, one more number in [0, 1).  INVALID_ARGUMENT for other texts.
absl::StatusOr<std::vector<double>> parse_sample_values(const std::string& text, std::size_t count,
                                                        bool chooses_light);

/// Reads lines of x,y,z or of x,y,z,nx,ny,nz; all lines have the same columns.  A header that
/// begins with x,y,z may come first.  Blank lines and lines that begin with # are skipped.
/// INVALID_ARGUMENT with a message that begins with "name:line: ".  NaN, infinities and directions
/// 0 0 0 are accepted.  The server marks such items, and answers the other lines of the file.
absl::StatusOr<PointSet> read_csv(std::istream& input, const std::string& name);

/// The options --point and --points.
class PointOptions {
 public:
  /// `second` names columns 4 to 6 of a file.
  void add(CLI::App& command, const std::string& second);
  /// One point or more.  Ends the program for wrong points or none.
  PointSet read() const;
  /// The argument of --points; empty if it is not given.  Ends the program if --point is given too.
  const std::string& file() const;

 private:
  std::vector<std::string> points_;
  std::string file_;
};

/// An option whose arguments are triples.  It may be repeated.
class TripleOption {
 public:
  void add(CLI::App& command, const std::string& flag, const std::string& what,
           Triple kind = Triple::kDirection);
  bool given() const { return !texts_.empty(); }
  /// One triple for each of `count` points.  A single argument is for all points.
  std::vector<Double3> read(std::size_t count) const;

 private:
  std::string flag_;
  Triple kind_ = Triple::kDirection;
  std::vector<std::string> texts_;
};

/// The directions of `option`, or columns 4 to 6.  Ends the program if both are absent.
std::vector<Double3> read_directions(const TripleOption& option, const PointSet& set);

using client::fill;

}  // namespace lucerna::cli
