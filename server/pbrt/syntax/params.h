// Typed parameters: "float radius" 0.35.
#pragma once

#include <algorithm>
#include <cstdint>
#include <initializer_list>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "lights/maths/vec.h"
#include "server/pbrt/syntax/context.h"
#include "server/pbrt/syntax/place.h"

namespace lucerna::pbrt {

/// Files give angles in degrees.
inline constexpr double kRadPerDegree = kPi / 180;

/// A parameter in the file.  The number of values is a positive multiple of values_per_item().
struct Parameter {
  std::string type;  ///< point, vector and normal3 become point3, vector3 and normal
  std::string name;
  Place place;
  std::vector<double> numbers;  ///< finite; whole for integer, 0 or 1 for bool
  std::vector<std::string> strings;
  LoadBudget::Share share{};  ///< of long lists of values
};

/// Number of values of one item of a type; 0: any number (spectrum).  Nothing for unknown types.
std::optional<std::size_t> values_per_item(std::string_view type);

/// Whether a word of the file is one of `words`.
inline bool is_one_of(std::string_view word, std::initializer_list<std::string_view> words) {
  return std::find(words.begin(), words.end(), word) != words.end();
}

/// The parameters of one directive, and those that Attribute directives gave before it.  Records
/// which parameters are used.
class ParameterSet {
 public:
  ParameterSet() = default;
  /// `own` parameters override `inherited` ones, and later inherited ones override earlier ones.
  /// Inherited ones may stay unused.
  ParameterSet(std::vector<std::shared_ptr<const Parameter>> own,
               const std::vector<std::shared_ptr<const Parameter>>& inherited);

  /// The parameter of this name if it has one of the types; null if there is none.  Fails if the
  /// directive itself gives it with another type.
  const Parameter* find(std::string_view name, std::initializer_list<std::string_view> types) const;

  /// A single value.  Fails on another type and on more than one value.
  double number(std::string_view name, double otherwise) const;
  std::optional<double> number(std::string_view name) const;
  int integer(std::string_view name, int otherwise) const;
  bool boolean(std::string_view name, bool otherwise) const;
  std::string string(std::string_view name, const std::string& otherwise) const;
  Vec3<double> point(std::string_view name, const Vec3<double>& otherwise) const;

  /// Any number of values; empty if it is not given.
  std::vector<double> numbers(std::string_view name) const;
  std::vector<std::uint32_t> indices(std::string_view name) const;  ///< fails on negative ones
  std::vector<Vec3<double>> vectors(std::string_view name, std::string_view type) const;

  /// The place of the first of `names` that is given; `otherwise` if none is.
  Place place_of(std::initializer_list<std::string_view> names, const Place& otherwise) const;

  /// Whether the directive itself gives the parameter, not an Attribute directive before it.
  bool is_own(const Parameter& parameter) const;

  /// Whether a parameter names a texture.
  bool has_textures() const;

  /// Memory of the numbers of long parameters.
  std::uint64_t long_bytes() const;

  /// Marks parameters as used that have no effect here.
  void ignore(std::initializer_list<std::string_view> names) const;

  /// Adds a remark for every own parameter that was not used.  `owner`: `Shape "sphere"`.
  void remark_unused(Context& context, const std::string& owner) const;

 private:
  struct Entry {
    std::shared_ptr<const Parameter> parameter;
    bool inherited = false;
    mutable bool used = false;
  };
  const Parameter* one(std::string_view name, std::initializer_list<std::string_view> types) const;
  std::vector<Entry> entries_;
};

}  // namespace lucerna::pbrt
