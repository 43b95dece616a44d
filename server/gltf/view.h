// A value in the JSON text with its place, read with checks.
#pragma once

#include <cstddef>
#include <cstdint>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "server/gltf/gltf_load_state.h"

namespace lucerna::gltf {

using Json = nlohmann::json;

/// A range of numbers.
struct Range {
  double least = -1e300, most = 1e300;
};
inline constexpr Range kNotNegative{0, 1e300};
inline constexpr Range kUnit{0, 1};

/// Refers to the JSON value and the context, which must outlive it.  Errors are INVALID_ARGUMENT
/// with the JSON pointer, the value and what is allowed.
class View {
 public:
  View(LoadState& context, const Json& value, std::string pointer)
      : context_(&context), value_(&value), pointer_(std::move(pointer)) {}

  const std::string& pointer() const { return pointer_; }
  LoadState& context() const { return *context_; }
  const Json& json() const { return *value_; }

  /// The member `key` of an object; nothing if it does not exist.
  std::optional<View> find(std::string_view key) const;
  /// The same; fails if it does not exist.
  View at(std::string_view key) const;
  /// The extension of this name in "extensions".
  std::optional<View> extension(std::string_view name) const;
  /// The element of an array.
  View operator[](std::size_t i) const;
  std::size_t size() const { return value_->size(); }

  // Checks of the type of this value.
  const View& require_object() const;
  const View& require_array(std::size_t least = 0, std::size_t most = SIZE_MAX) const;
  double number(Range range = {}) const;
  std::uint64_t integer(std::uint64_t least, std::uint64_t most) const;
  /// An index below `count`; `what` names the things in messages ("node").
  std::size_t index(std::size_t count, std::string_view what) const;
  const std::string& text() const;
  bool boolean() const;
  /// `count` numbers.
  std::vector<double> numbers(std::size_t count, Range range = {}) const;

  // Members that may be missing.
  double number(std::string_view key, double otherwise, Range range = {}) const;
  std::uint64_t integer(std::string_view key, std::uint64_t otherwise, std::uint64_t least,
                        std::uint64_t most) const;
  bool boolean(std::string_view key, bool otherwise) const;
  std::vector<double> numbers(std::string_view key, std::vector<double> otherwise,
                              Range range = {}) const;
  std::optional<std::size_t> index(std::string_view key, std::size_t count,
                                   std::string_view what) const;
  std::string text(std::string_view key, std::string otherwise) const;

  [[noreturn]] void fail(const std::string& what) const { context_->fail(pointer_, what); }
  [[noreturn]] void fail(const absl::Status& status) const { context_->fail(pointer_, status); }

 private:
  [[noreturn]] void refuse(std::string_view allowed) const;

  LoadState* context_;
  const Json* value_;
  std::string pointer_;
};

}  // namespace lucerna::gltf
