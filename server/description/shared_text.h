// Text that many hold, such as the name of a file.
#pragma once

#include <concepts>
#include <memory>
#include <string>
#include <string_view>
#include <utility>

namespace lucerna {

/// A text that does not change.  Its copies share it.
class SharedText {
 public:
  SharedText() = default;
  SharedText(std::string text)
      : text_(text.empty() ? nullptr : std::make_shared<const std::string>(std::move(text))) {}
  SharedText(const char* text) : SharedText(std::string(text)) {}

  const std::string& str() const {
    static const std::string kEmpty;
    return text_ == nullptr ? kEmpty : *text_;
  }
  operator const std::string&() const { return str(); }

  bool operator==(const SharedText& other) const { return str() == other.str(); }
  template <std::convertible_to<std::string_view> Text>
  bool operator==(const Text& other) const {
    return str() == std::string_view(other);
  }

 private:
  std::shared_ptr<const std::string> text_;
};

}  // namespace lucerna
