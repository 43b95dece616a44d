// Typed parameters: "float radius" 0.35.
#pragma once

#include <initializer_list>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "lights/maths/vec.h"
#include "server/pbrt/context.h"
#include "server/pbrt/place.h"

namespace lucerna::pbrt {

/// Files give angles in degrees.
inline constexpr double kRadPerDegree = kPi / 180;

/// One parameter as written.  The number of values is a positive multiple of what its type takes.
struct Parameter {
  std::string type;  ///< point, vector and normal3 are read as point3, vector3 and normal
  std::string name;
  Place place;
  std::vector<double> numbers;  ///< finite; whole for integer, 0 or 1 for bool
  std::vector<std::string> strings;
};

/// How many values one item of a type takes; 0: any number (spectrum).  Nothing for no type.
std::optional<std::size_t> values_per_item(std::string_view type);

/// The parameters of one directive, and those that an Attribute directive gave before it.  Keeps
/// track of which were asked for.
class ParameterSet {
 public:
  ParameterSet() = default;
  /// `inherited` yield to `own`, later ones win over earlier, and they may go unused.
  ParameterSet(std::vector<std::shared_ptr<const Parameter>> own,
               const std::vector<std::shared_ptr<const Parameter>>& inherited);

  /// The parameter of this name if it is of one of the types; null if there is none.  Fails where
  /// the directive itself gives it with another type.
  const Parameter* find(std::string_view name, std::initializer_list<std::string_view> types) const;

  /// One value.  Each fails on another type and on more than one value.
  double number(std::string_view name, double otherwise) const;
  std::optional<double> number(std::string_view name) const;
  int integer(std::string_view name, int otherwise) const;
  bool boolean(std::string_view name, bool otherwise) const;
  std::string string(std::string_view name, const std::string& otherwise) const;
  Vec3<double> point(std::string_view name, const Vec3<double>& otherwise) const;

  /// Any number of values; empty where it is not given.
  std::vector<double> numbers(std::string_view name) const;
  std::vector<std::uint32_t> indices(std::string_view name) const;  ///< fails on negative ones
  std::vector<Vec3<double>> vectors(std::string_view name, std::string_view type) const;

  /// Where the first of `names` that is given stands; `otherwise` where none is.
  Place place_of(std::initializer_list<std::string_view> names, const Place& otherwise) const;

  /// Whether the directive itself gives it, not an Attribute directive before it.
  bool is_own(const Parameter& parameter) const;

  /// Takes parameters as read that change nothing here.
  void ignore(std::initializer_list<std::string_view> names) const;

  /// A remark on every own parameter that nothing asked for.  `owner`: `Shape "sphere"`.
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
