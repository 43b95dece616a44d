#include "server/pbrt/syntax/params.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <utility>

namespace lucerna::pbrt {

std::optional<std::size_t> values_per_item(std::string_view type) {
  if (type == "float" || type == "integer" || type == "bool" || type == "string" ||
      type == "texture" || type == "blackbody")
    return 1;
  if (type == "point2" || type == "vector2") return 2;
  if (type == "point3" || type == "vector3" || type == "normal" || type == "rgb") return 3;
  if (type == "spectrum") return 0;
  return std::nullopt;
}

ParameterSet::ParameterSet(std::vector<std::shared_ptr<const Parameter>> own,
                           const std::vector<std::shared_ptr<const Parameter>>& inherited) {
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
    if (std::find(types.begin(), types.end(), parameter.type) == types.end()) {
      if (entry.inherited) continue;
      fail(parameter.place, fmt::format("parameter \"{}\" has type \"{}\", expected \"{}\"", name,
                                        parameter.type, fmt::join(types, "\" or \"")));
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
  const std::size_t values = parameter->numbers.size() + parameter->strings.size();
  if (values != values_per_item(parameter->type))
    fail(parameter->place, fmt::format("parameter \"{}\" has {} values, expected {}", name, values,
                                       *values_per_item(parameter->type)));
  return parameter;
}

std::optional<double> ParameterSet::number(std::string_view name) const {
  const Parameter* parameter = one(name, {"float"});
  return parameter != nullptr ? std::optional(parameter->numbers[0]) : std::nullopt;
}

double ParameterSet::number(std::string_view name, double otherwise) const {
  return number(name).value_or(otherwise);
}

int ParameterSet::integer(std::string_view name, int otherwise) const {
  const Parameter* parameter = one(name, {"integer"});
  return parameter != nullptr ? static_cast<int>(parameter->numbers[0]) : otherwise;
}

bool ParameterSet::boolean(std::string_view name, bool otherwise) const {
  const Parameter* parameter = one(name, {"bool"});
  return parameter != nullptr ? parameter->numbers[0] != 0 : otherwise;
}

std::string ParameterSet::string(std::string_view name, const std::string& otherwise) const {
  const Parameter* parameter = one(name, {"string"});
  return parameter != nullptr ? parameter->strings[0] : otherwise;
}

Vec3<double> ParameterSet::point(std::string_view name, const Vec3<double>& otherwise) const {
  const Parameter* parameter = one(name, {"point3"});
  if (parameter == nullptr) return otherwise;
  return {parameter->numbers[0], parameter->numbers[1], parameter->numbers[2]};
}

std::vector<double> ParameterSet::numbers(std::string_view name) const {
  const Parameter* parameter = find(name, {"float", "integer"});
  return parameter != nullptr ? parameter->numbers : std::vector<double>{};
}

std::vector<std::uint32_t> ParameterSet::indices(std::string_view name) const {
  const Parameter* parameter = find(name, {"integer"});
  if (parameter == nullptr) return {};
  std::vector<std::uint32_t> result;
  result.reserve(parameter->numbers.size());
  for (const double index : parameter->numbers) {
    if (index < 0)
      fail(parameter->place, fmt::format("\"{}\" holds {}, allowed: not negative", name, index));
    result.push_back(static_cast<std::uint32_t>(index));
  }
  return result;
}

std::vector<Vec3<double>> ParameterSet::vectors(std::string_view name,
                                                std::string_view type) const {
  const Parameter* parameter = find(name, {type});
  if (parameter == nullptr) return {};
  std::vector<Vec3<double>> result;
  result.reserve(parameter->numbers.size() / 3);
  for (std::size_t i = 0; i + 2 < parameter->numbers.size(); i += 3)
    result.emplace_back(parameter->numbers[i], parameter->numbers[i + 1],
                        parameter->numbers[i + 2]);
  return result;
}

Place ParameterSet::place_of(std::initializer_list<std::string_view> names,
                             const Place& otherwise) const {
  for (const std::string_view name : names)
    for (const Entry& entry : entries_)
      if (entry.parameter->name == name) return entry.parameter->place;
  return otherwise;
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
    if (std::find(names.begin(), names.end(), entry.parameter->name) != names.end())
      entry.used = true;
}

void ParameterSet::remark_unused(Context& context, const std::string& owner) const {
  for (const Entry& entry : entries_)
    if (!entry.used && !entry.inherited)
      context.remark(entry.parameter->place,
                     fmt::format("parameter \"{}\" of {} is not known",
                                 printable(entry.parameter->name), owner),
                     "it changes nothing");
}

}  // namespace lucerna::pbrt
