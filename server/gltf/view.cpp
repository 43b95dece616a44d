#include "server/gltf/view.h"

#include <fmt/format.h>

#include <cmath>

namespace lucerna::gltf {
namespace {

/// A key as a part of a JSON pointer.  [RFC6901, 3]
std::string escaped(std::string_view key) {
  std::string result;
  for (const char c : key) {
    if (c == '~')
      result += "~0";
    else if (c == '/')
      result += "~1";
    else
      result += c;
  }
  return result;
}

}  // namespace

void View::refuse(std::string_view allowed) const {
  std::string value;
  if (value_->is_object())
    value = "an object";
  else if (value_->is_array())
    value = fmt::format("an array of {}", value_->size());
  else
    value = printable(value_->dump(-1, ' ', false, Json::error_handler_t::replace));
  fail(fmt::format("found {}, allowed: {}", value, allowed));
}

std::optional<View> View::find(std::string_view key) const {
  if (!value_->is_object()) return std::nullopt;
  const auto found = value_->find(key);
  if (found == value_->end()) return std::nullopt;
  return View(*context_, *found, fmt::format("{}/{}", pointer_, escaped(key)));
}

View View::at(std::string_view key) const {
  require_object();
  if (auto found = find(key)) return *std::move(found);
  fail(fmt::format("\"{}\" is missing", key));
}

std::optional<View> View::extension(std::string_view name) const {
  const auto extensions = find("extensions");
  if (!extensions) return std::nullopt;
  auto found = extensions->require_object().find(name);
  if (found) found->require_object();
  return found;
}

View View::operator[](std::size_t i) const {
  return {*context_, (*value_)[i], fmt::format("{}/{}", pointer_, i)};
}

const View& View::require_object() const {
  if (!value_->is_object()) refuse("an object");
  return *this;
}

const View& View::require_array(std::size_t least, std::size_t most) const {
  if (!value_->is_array() || value_->size() < least || value_->size() > most) {
    if (least == most) refuse(fmt::format("an array of {}", least));
    refuse(least > 0 ? fmt::format("an array of {} or more", least) : "an array");
  }
  return *this;
}

double View::number(Range range) const {
  const double value = value_->is_number() ? value_->get<double>() : std::nan("");
  if (!(value >= range.least && value <= range.most)) {
    if (range.least == Range{}.least) refuse("a finite number");
    if (range.most == Range{}.most) refuse(fmt::format("a finite number from {}", range.least));
    refuse(fmt::format("a number from {} to {}", range.least, range.most));
  }
  return value;
}

std::uint64_t View::integer(std::uint64_t least, std::uint64_t most) const {
  // 3.0 is an integer in JSON.
  const double value = value_->is_number() ? value_->get<double>() : -1;
  if (!(value >= static_cast<double>(least) && value <= static_cast<double>(most) &&
        value == std::floor(value)))
    refuse(fmt::format("an integer from {} to {}", least, most));
  return static_cast<std::uint64_t>(value);
}

std::size_t View::index(std::size_t count, std::string_view what) const {
  const double value = value_->is_number() ? value_->get<double>() : -1;
  if (!(value >= 0 && value < static_cast<double>(count) && value == std::floor(value)))
    refuse(count == 0 ? fmt::format("nothing, because the file has no {}", what)
                      : fmt::format("the index of a {}, 0 to {}", what, count - 1));
  return static_cast<std::size_t>(value);
}

const std::string& View::text() const {
  if (!value_->is_string()) refuse("a string");
  return value_->get_ref<const std::string&>();
}

bool View::boolean() const {
  if (!value_->is_boolean()) refuse("true or false");
  return value_->get<bool>();
}

std::vector<double> View::numbers(std::size_t count, Range range) const {
  require_array(count, count);
  std::vector<double> result;
  result.reserve(count);
  for (std::size_t i = 0; i < count; ++i) result.push_back((*this)[i].number(range));
  return result;
}

double View::number(std::string_view key, double otherwise, Range range) const {
  const auto found = find(key);
  return found ? found->number(range) : otherwise;
}

std::uint64_t View::integer(std::string_view key, std::uint64_t otherwise, std::uint64_t least,
                            std::uint64_t most) const {
  const auto found = find(key);
  return found ? found->integer(least, most) : otherwise;
}

bool View::boolean(std::string_view key, bool otherwise) const {
  const auto found = find(key);
  return found ? found->boolean() : otherwise;
}

std::vector<double> View::numbers(std::string_view key, std::vector<double> otherwise,
                                  Range range) const {
  const auto found = find(key);
  return found ? found->numbers(otherwise.size(), range) : otherwise;
}

std::optional<std::size_t> View::index(std::string_view key, std::size_t count,
                                       std::string_view what) const {
  const auto found = find(key);
  if (!found) return std::nullopt;
  return found->index(count, what);
}

std::string View::text(std::string_view key, std::string otherwise) const {
  const auto found = find(key);
  return found ? found->text() : otherwise;
}

}  // namespace lucerna::gltf
