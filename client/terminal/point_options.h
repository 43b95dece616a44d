// Points and vectors from arguments, CSV files and standard input.
#pragma once

#include <CLI/CLI.hpp>
#include <istream>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "lucerna/client/points.h"

namespace lucerna::cli {

using client::Double3;

struct PointSet {
  std::vector<Double3> points;
  /// What comes with each point, a normal, a direction or another point; empty or one a point.
  std::vector<Double3> seconds;
};

enum class Triple { kPoint, kDirection };

/// "1,2,-0.5".  INVALID_ARGUMENT for all that is not three finite numbers, and for directions that
/// do not fit floats, which the contract's are, or are 0 0 0 as floats.
absl::StatusOr<Double3> parse_triple(const std::string& text, Triple kind);

/// Any number of numbers, NaN and infinities too.  INVALID_ARGUMENT for all else.
absl::StatusOr<std::vector<double>> parse_numbers(const std::string& text);

/// What --u gives for one sample: `count` numbers in [0, 1], two of a direction or four of a ray,
/// and where `chooses_light` one in [0, 1).  INVALID_ARGUMENT for all else.
absl::StatusOr<std::vector<double>> parse_sample_values(const std::string& text, std::size_t count,
                                                        bool chooses_light);

/// Lines of x,y,z or of x,y,z,nx,ny,nz, all alike, after an optional header that begins with x,y,z.
/// Blank lines and lines that begin with # are nothing.  INVALID_ARGUMENT that begins with
/// "name:line: ".  NaN, infinities and directions 0 0 0 pass: the server's answer tells them item
/// by item, so that one of them does not stop a file.
absl::StatusOr<PointSet> read_csv(std::istream& input, const std::string& name);

/// The options by which commands are given points.
class PointOptions {
 public:
  /// --point and --points; `second` says what columns 4 to 6 of a file are.
  void add(CLI::App& command, const std::string& second);
  /// At least one point; ends the program with what is wrong otherwise.
  PointSet read() const;
  /// What --points names; empty where it is not given.  --point beside it is told as read() tells
  /// it.
  const std::string& file() const;

 private:
  std::vector<std::string> points_;
  std::string file_;
};

/// Triples given by a repeatable option.
class TripleOption {
 public:
  void add(CLI::App& command, const std::string& flag, const std::string& what,
           Triple kind = Triple::kDirection);
  bool given() const { return !texts_.empty(); }
  /// One for each of `count` points: a single one is for all of them.
  std::vector<Double3> read(std::size_t count) const;

 private:
  std::string flag_;
  Triple kind_ = Triple::kDirection;
  std::vector<std::string> texts_;
};

/// Those that `option` gives, or columns 4 to 6; ends the program where there are none.
std::vector<Double3> read_directions(const TripleOption& option, const PointSet& set);

using client::fill;

}  // namespace lucerna::cli
