// Typed parameters: "float radius" 0.35.
#pragma once

#include <algorithm>
#include <cstdint>
#include <initializer_list>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <variant>
#include <vector>

#include "lights/maths/rgb_primaries.h"
#include "lights/maths/vec.h"
#include "server/pbrt/file_position.h"
#include "server/pbrt/pbrt_load_state.h"

namespace lucerna::pbrt {

/// Files give angles in degrees.
inline constexpr double kRadPerDegree = kPi / 180;

/// A type of parameters.
struct ParameterType {
  std::string_view name;        ///< point, vector and normal3 are point3, vector3 and normal
  std::size_t values_per_item;  ///< 0: any number (spectrum)
};

/// The type of this name; null if there is none.
const ParameterType* parameter_type(std::string_view name);

/// The finite numbers of float, bool (0 or 1), point2, vector2, rgb, spectrum and blackbody.
using Numbers = std::vector<double>;
/// The values of integer, each as static_cast<std::uint32_t>(std::int32_t).
using Integers = std::vector<std::uint32_t>;
/// The finite items of point3, vector3 and normal.
using Vectors = std::vector<Vec3>;
/// The values of string and texture, and the name of a spectrum.
using Strings = std::vector<std::string>;

/// A parameter in the file.  The number of values is a positive multiple of `values_per_item` of
/// its type.  They are stored as meshes store them, so that long lists need not exist twice.
struct Parameter {
  std::string_view type;
  std::string name;
  FilePosition place;
  const RgbPrimaries* primaries = nullptr;  ///< of an rgb; null: Rec. 709
  std::variant<Numbers, Integers, Vectors, Strings> values{};
  LoadBudget::Share share{};  ///< of long lists of values

  /// Those of other types are empty.
  const Numbers& numbers() const { return values_or_none<Numbers>(); }
  const Integers& integers() const { return values_or_none<Integers>(); }
  const Vectors& vectors() const { return values_or_none<Vectors>(); }
  const Strings& strings() const { return values_or_none<Strings>(); }
  /// The number of values; an item of `vectors` has three.
  std::size_t count() const;
  /// Memory of the list.
  std::uint64_t capacity_bytes() const {
    return std::visit(
        []<typename T>(const std::vector<T>& list) -> std::uint64_t {
          return list.capacity() * sizeof(T);
        },
        values);
  }

 private:
  template <typename T>
  const T& values_or_none() const {
    static const T kNone;
    const T* given = std::get_if<T>(&values);
    return given == nullptr ? kNone : *given;
  }
};

/// Whether a word of the file is one of `words`.
inline bool is_one_of(std::string_view word, std::initializer_list<std::string_view> words) {
  return std::find(words.begin(), words.end(), word) != words.end();
}

/// A directive of a type: its parameters, and those that Attribute directives gave before it.
/// Records which parameters are used.
class ParameterSet {
 public:
  ParameterSet() = default;
  /// `own` parameters override `inherited` ones, and later inherited ones override earlier ones.
  /// Inherited ones may stay unused.
  ParameterSet(std::string type, std::vector<std::shared_ptr<Parameter>> own,
               const std::vector<std::shared_ptr<Parameter>>& inherited, FilePosition place);

  /// The type, such as "sphere", and the place of the directive.
  const std::string& type() const { return type_; }
  const FilePosition& place() const { return place_; }

  /// The parameter of this name if it has one of the types; null if there is none.  Fails if the
  /// directive itself gives it with another type.
  const Parameter* find(std::string_view name, std::initializer_list<std::string_view> types) const;

  /// A single value.  Fails on another type and on more than one value.
  double number(std::string_view name, double otherwise) const;
  std::optional<double> number(std::string_view name) const;
  /// The same; fails unless `is_allowed(value)`, with `"float name" = value` and then `allowed`.
  template <typename F>
  double number(std::string_view name, double otherwise, F&& is_allowed,
                std::string_view allowed) const {
    const double value = number(name, otherwise);
    if (!is_allowed(value)) refuse(name, value, allowed);
    return value;
  }
  int integer(std::string_view name, int otherwise) const;
  bool boolean(std::string_view name, bool otherwise) const;
  std::string string(std::string_view name, const std::string& otherwise) const;
  /// What the string means.  Fails on words other than those of `choices`.
  template <typename T>
  T choice(std::string_view name, const char* otherwise,
           std::initializer_list<std::pair<std::string_view, T>> choices) const {
    const std::string given = string(name, otherwise);
    std::vector<std::string_view> words;
    for (const auto& [word, value] : choices) {
      if (given == word) return value;
      words.push_back(word);
    }
    refuse(name, given, words);
  }
  Vec3 point(std::string_view name, const Vec3& otherwise) const;

  /// Any number of values; empty if it is not given.
  std::vector<double> numbers(std::string_view name) const;
  Vectors vectors(std::string_view name, std::string_view type) const;
  /// Moves the values out of a parameter of this directive.  Copies those of an Attribute
  /// directive.
  Vectors take_vectors(std::string_view name, std::string_view type);
  Integers take_indices(std::string_view name);  ///< fails on negative ones

  /// The place of the first of `names` that is given; that of the directive if none is.
  FilePosition place_of(std::initializer_list<std::string_view> names) const;

  /// Whether the directive itself gives the parameter, not an Attribute directive before it.
  bool is_own(const Parameter& parameter) const;

  /// Whether a parameter names a texture.
  bool has_textures() const;

  /// Memory of the numbers of long parameters.
  std::uint64_t long_bytes() const;

  /// Marks parameters as used that have no effect here.
  void ignore(std::initializer_list<std::string_view> names) const;

  /// Adds a remark for every own parameter that was not used.  Fails if it is the picture of a
  /// light of an earlier pbrt.  `owner`: `Shape "sphere"`.
  void remark_unused(LoadState& context, const std::string& owner) const;

 private:
  struct Entry {
    std::shared_ptr<Parameter> parameter;
    bool inherited = false;
    mutable bool used = false;
  };
  const Parameter* one(std::string_view name, std::initializer_list<std::string_view> types) const;
  [[noreturn]] void refuse(std::string_view name, double value, std::string_view allowed) const;
  [[noreturn]] void refuse(std::string_view name, const std::string& given,
                           const std::vector<std::string_view>& words) const;
  template <typename T>
  T take(const Parameter* parameter);
  std::string type_;
  FilePosition place_;
  std::vector<Entry> entries_;
};

}  // namespace lucerna::pbrt
