// What the renderer under test produced: rows of numbers from one file.
#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "client/files/number_table.h"
#include "client/library/points.h"

namespace lucerna::verify {

using client::Double3;

/// The kinds of files.
enum class Kind : std::uint8_t {
  kSamples,     ///< samples of the light that arrives at points
  kDensities,   ///< densities for given directions
  kEmission,    ///< rays that leave lights
  kPower,       ///< powers of lights
  kIrradiance,  ///< illuminances at points
  kVisibility,  ///< whether pairs of points see each other
};

/// "samples", "densities" and so on: the word of the command line.
const char* name(Kind kind);

/// The columns of a file in the order that a file without names has.
std::vector<std::string> columns(Kind kind);

/// One entry per row.  A vector is empty if the file does not have its columns.  NaN: not given in
/// this row.
struct Records {
  Kind kind = Kind::kSamples;
  std::size_t rows = 0;
  /// Receivers, starts of rays or segments, world [m].
  std::vector<Double3> points;
  /// Unit normals of the receivers; in emission those of the light.
  std::vector<Double3> normals;
  /// Unit geometric normals, where `normals` are the shading normals.
  std::vector<Double3> geometric_normals;
  /// Unit normals of the light at the sampled points.
  std::vector<Double3> light_normals;
  /// Unit, from the receiver to the light; in emission away from the light.
  std::vector<Double3> directions;
  /// Ends of segments [m].
  std::vector<Double3> targets;
  /// Ids of lights; 0 for none.
  std::vector<std::uint64_t> lights;
  /// [1/sr]
  std::vector<double> pdf;
  /// Luminance of the value: [cd/m2], for delta lights [lx]; in power [lm], in irradiance [lx].
  std::vector<double> value;
  /// RGB of the value.  Empty if the file has only its luminance.
  std::vector<Double3> rgb;
  /// [m]
  std::vector<double> distance;
  /// With which probability the light was chosen.
  std::vector<double> selection;
  /// The density from which the given directions were drawn [1/sr].
  std::vector<double> drawn;
  /// Standard error of `value`.
  std::vector<double> standard_error;
  /// [1/m2] and [1/sr].
  std::vector<double> pdf_position, pdf_direction;
  std::vector<bool> visible;
  /// "file:line" of each row.
  std::function<std::string(std::size_t)> place;
};

/// Reads a file.  `light_of_name` returns the id of the light with a name.  `is_light` is true for
/// ids of lights of the scene; `lights` describes what is allowed.  A wrong file ends the program
/// with its place, the value and what is allowed.
Records read_records(Kind kind, const std::string& path,
                     const std::function<absl::StatusOr<double>(std::string_view)>& light_of_name,
                     const std::function<bool(std::uint64_t)>& is_light, const std::string& lights);

/// The rows with these numbers.
Records rows_of(const Records& records, const std::vector<std::size_t>& rows);

}  // namespace lucerna::verify
