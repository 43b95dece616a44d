#include "server/pbrt/pbrt_params.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <utility>

#include "lights/maths/stop_poll.h"
#include "server/pbrt/older_pbrt.h"

namespace lucerna::pbrt {

const ParameterType* parameter_type(std::string_view name) {
  static constexpr std::array<ParameterType, 13> kTypes{{{"float", 1},
                                                         {"integer", 1},
                                                         {"bool", 1},
                                                         {"string", 1},
                                                         {"texture", 1},
                                                         {"blackbody", 1},
                                                         {"point2", 2},
                                                         {"vector2", 2},
                                                         {"point3", 3},
                                                         {"vector3", 3},
                                                         {"normal", 3},
                                                         {"rgb", 3},
                                                         {"spectrum", 0}}};
  if (name == "point") name = "point3";
  if (name == "vector") name = "vector3";
  if (name == "normal3") name = "normal";
  const auto found = std::ranges::find(kTypes, name, &ParameterType::name);
  return found == kTypes.end() ? nullptr : &*found;
}

std::size_t Parameter::count() const {
  return numbers().size() + integers().size() + 3 * vectors().size() + strings().size();
}

ParameterSet::ParameterSet(std::string type, std::vector<std::shared_ptr<Parameter>> own,
                           const std::vector<std::shared_ptr<Parameter>>& inherited,
                           FilePosition place)
    : type_(std::move(type)), place_(place) {
  for (auto& parameter : own) entries_.push_back({std::move(parameter), false});
  std::for_each(inherited.rbegin(), inherited.rend(), [&](const auto& parameter) {
    entries_.push_back({parameter, true});
  });
}

const Parameter* ParameterSet::find(std::string_view name,
                                    std::initializer_list<std::string_view> types) const {
  for (const Entry& entry : entries_) {
    const Parameter& parameter = *entry.parameter;
    if (parameter.name != name) continue;
    if (!is_one_of(parameter.type, types)) {
      if (entry.inherited) continue;
      fail(
          parameter.place,
          fmt::format("parameter \"{}\" has type \"{}\", expected \"{}\"{}", name, parameter.type,
                      fmt::join(types, "\" or \""),
                      hint_of_older_pbrt("parameter", fmt::format("{} {}", parameter.type, name))));
    }
    entry.used = true;
    return &parameter;
  }
  return nullptr;
}

const Parameter* ParameterSet::one(std::string_view name,
                                   std::initializer_list<std::string_view> types) const {
  const Parameter* parameter = find(name, types);
  if (parameter == nullptr) return nullptr;
  const std::size_t expected = parameter_type(parameter->type)->values_per_item;
  if (parameter->count() != expected)
    fail(parameter->place, fmt::format("parameter \"{}\" has {} values, expected {}", name,
                                       parameter->count(), expected));
  return parameter;
}

std::optional<double> ParameterSet::number(std::string_view name) const {
  const Parameter* parameter = one(name, {"float"});
  return parameter != nullptr ? std::optional(parameter->numbers()[0]) : std::nullopt;
}

double ParameterSet::number(std::string_view name, double otherwise) const {
  return number(name).value_or(otherwise);
}

int ParameterSet::integer(std::string_view name, int otherwise) const {
  const Parameter* parameter = one(name, {"integer"});
  return parameter != nullptr ? static_cast<std::int32_t>(parameter->integers()[0]) : otherwise;
}

bool ParameterSet::boolean(std::string_view name, bool otherwise) const {
  const Parameter* parameter = one(name, {"bool"});
  return parameter != nullptr ? parameter->numbers()[0] != 0 : otherwise;
}

std::string ParameterSet::string(std::string_view name, const std::string& otherwise) const {
  const Parameter* parameter = one(name, {"string"});
  return parameter != nullptr ? parameter->strings()[0] : otherwise;
}

Vec3 ParameterSet::point(std::string_view name, const Vec3& otherwise) const {
  const Parameter* parameter = one(name, {"point3"});
  if (parameter == nullptr) return otherwise;
  return parameter->vectors()[0];
}

std::vector<double> ParameterSet::numbers(std::string_view name) const {
  const Parameter* parameter = find(name, {"float", "integer"});
  if (parameter == nullptr) return {};
  std::vector<double> result = parameter->numbers();
  StopPoll poll;
  for (const std::uint32_t value : parameter->integers())
    poll(), result.push_back(static_cast<std::int32_t>(value));
  return result;
}

Vectors ParameterSet::vectors(std::string_view name, std::string_view type) const {
  const Parameter* parameter = find(name, {type});
  return parameter != nullptr ? parameter->vectors() : Vectors();
}

template <typename T>
T ParameterSet::take(const Parameter* parameter) {
  if (parameter == nullptr) return {};
  const auto entry =
      std::ranges::find(entries_, parameter, [](const Entry& e) { return e.parameter.get(); });
  // Other directives may need the values of an Attribute directive.
  T& values = std::get<T>(entry->parameter->values);
  return entry->inherited ? values : std::exchange(values, {});
}

Vectors ParameterSet::take_vectors(std::string_view name, std::string_view type) {
  return take<Vectors>(find(name, {type}));
}

Integers ParameterSet::take_indices(std::string_view name) {
  const Parameter* parameter = find(name, {"integer"});
  Integers indices = take<Integers>(parameter);
  StopPoll poll;
  for (const std::uint32_t index : indices) {
    poll();
    if (static_cast<std::int32_t>(index) < 0)
      fail(parameter->place, fmt::format("\"{}\" holds {}, allowed: not negative", name,
                                         static_cast<std::int32_t>(index)));
  }
  return indices;
}

void ParameterSet::refuse(std::string_view name, double value, std::string_view allowed) const {
  const Parameter* given = find(name, {"float"});
  fail(given != nullptr ? given->place : place_,
       fmt::format("\"float {}\" = {}{}", name, value, allowed));
}

void ParameterSet::refuse(std::string_view name, const std::string& given,
                          const std::vector<std::string_view>& words) const {
  fail(find(name, {"string"})->place, fmt::format("\"string {}\" = \"{}\", allowed: {}", name,
                                                  printable(given), fmt::join(words, ", ")));
}

FilePosition ParameterSet::place_of(std::initializer_list<std::string_view> names) const {
  for (const std::string_view name : names)
    for (const Entry& entry : entries_)
      if (entry.parameter->name == name) return entry.parameter->place;
  return place_;
}

bool ParameterSet::is_own(const Parameter& parameter) const {
  return std::ranges::any_of(entries_, [&](const Entry& entry) {
    return entry.parameter.get() == &parameter && !entry.inherited;
  });
}

bool ParameterSet::has_textures() const {
  return std::ranges::any_of(entries_,
                             [](const Entry& entry) { return entry.parameter->type == "texture"; });
}

std::uint64_t ParameterSet::long_bytes() const {
  std::uint64_t sum = 0;
  for (const Entry& entry : entries_) sum += entry.parameter->share.bytes();
  return sum;
}

void ParameterSet::ignore(std::initializer_list<std::string_view> names) const {
  for (const Entry& entry : entries_)
    if (is_one_of(entry.parameter->name, names)) entry.used = true;
}

void ParameterSet::remark_unused(LoadState& context, const std::string& owner) const {
  for (const Entry& entry : entries_) {
    if (entry.used || entry.inherited) continue;
    const Parameter& parameter = *entry.parameter;
    std::string what =
        fmt::format("parameter \"{}\" of {} is not known", printable(parameter.name), owner);
    if (const std::string_view now = name_in_pbrt_v4(parameter.name); !now.empty())
      what += fmt::format("; it is of pbrt-v2 and pbrt-v3, use \"{}\"", now);
    // Without its picture, a light would shine with its colour everywhere.
    if (parameter.name == "mapname") fail(parameter.place, what);
    context.remark(parameter.place, std::move(what), "it changes nothing");
  }
}

}  // namespace lucerna::pbrt
