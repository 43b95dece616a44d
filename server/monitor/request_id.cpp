#include "server/monitor/request_id.h"

#include <absl/strings/ascii.h>
#include <fmt/format.h>

#include <algorithm>
#include <cstdint>
#include <random>

namespace lucerna::monitor {
namespace {

constexpr std::size_t kMostIdBytes = 128;
constexpr std::size_t kSceneIdDigits = 64;

bool is_hexadecimal(std::string_view text) {
  return text.find_first_not_of("0123456789abcdef") == std::string_view::npos;
}

bool is_harmless(char c) {
  constexpr std::string_view kOthers = "-_.:+/=@";
  return absl::ascii_isalnum(static_cast<unsigned char>(c)) ||
         kOthers.find(c) != std::string_view::npos;
}

bool is_zero(std::string_view text) {
  return text.find_first_not_of('0') == std::string_view::npos;
}

}  // namespace

bool is_request_id(std::string_view text) {
  return !text.empty() && text.size() <= kMostIdBytes &&
         std::all_of(text.begin(), text.end(), is_harmless);
}

std::string printable_name(std::string_view text) {
  std::string name(text.substr(0, kMostIdBytes));
  std::replace_if(
      name.begin(), name.end(), [](char c) { return !is_harmless(c) && c != '*'; }, '?');
  return name;
}

std::string make_request_id() {
  // Ids only tell requests apart, so they need no cryptographic generator.
  thread_local std::mt19937_64 random = [] {
    std::random_device device;
    std::seed_seq seed{device(), device(), device(), device()};
    return std::mt19937_64(seed);
  }();
  return fmt::format("{:016x}", static_cast<std::uint64_t>(random()));
}

bool is_traceparent(std::string_view text) {
  // 00-<32 digits>-<16 digits>-<2 digits>
  return text.size() == 55 && text.substr(0, 3) == "00-" && text[35] == '-' && text[52] == '-' &&
         is_hexadecimal(text.substr(3, 32)) && !is_zero(text.substr(3, 32)) &&
         is_hexadecimal(text.substr(36, 16)) && !is_zero(text.substr(36, 16)) &&
         is_hexadecimal(text.substr(53, 2));
}

bool is_scene_id(std::string_view text) {
  return text.size() == kSceneIdDigits && is_hexadecimal(text);
}

}  // namespace lucerna::monitor
