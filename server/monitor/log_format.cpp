#include "server/monitor/log_format.h"

#include <spdlog/details/log_msg.h>
#include <spdlog/pattern_formatter.h>

#include <nlohmann/json.hpp>
#include <string_view>

#include "proto/common/plain_text.h"

namespace lucerna::monitor {
namespace {

// ISO 8601 with the zone's offset.
constexpr char kTime[] = "%Y-%m-%dT%H:%M:%S.%e%z";

void append(std::string_view text, spdlog::memory_buf_t& out) {
  out.append(text.data(), text.data() + text.size());
}

/// Texts of requests must not forge lines, nor move the terminal of a reader.
void append_plain(std::string_view text, spdlog::memory_buf_t& out) {
  append(plain_line(text), out);
}

class TextFormatter final : public spdlog::formatter {
 public:
  void format(const spdlog::details::log_msg& message, spdlog::memory_buf_t& out) override {
    start_.format(message, out);
    append_plain({message.payload.data(), message.payload.size()}, out);
    append("\n", out);
  }
  std::unique_ptr<spdlog::formatter> clone() const override {
    return std::make_unique<TextFormatter>();
  }

 private:
  spdlog::pattern_formatter start_{std::string(kTime) + " [%l] ", spdlog::pattern_time_type::local,
                                   ""};
};

class JsonFormatter final : public spdlog::formatter {
 public:
  void format(const spdlog::details::log_msg& message, spdlog::memory_buf_t& out) override {
    append("{\"time\":\"", out);
    time_.format(message, out);
    const auto level = spdlog::level::to_string_view(message.level);
    append("\",\"level\":\"", out);
    append({level.data(), level.size()}, out);
    append("\",", out);
    const std::string_view text(message.payload.data(), message.payload.size());
    if (std::string_view(message.logger_name.data(), message.logger_name.size()) ==
        kMembersLogger) {
      append_plain(text, out);
    } else {
      append("\"message\":", out);
      append_plain(json_string(std::string(text)), out);
    }
    append("}\n", out);
  }
  std::unique_ptr<spdlog::formatter> clone() const override {
    return std::make_unique<JsonFormatter>();
  }

 private:
  spdlog::pattern_formatter time_{kTime, spdlog::pattern_time_type::local, ""};
};

}  // namespace

std::string json_string(const std::string& text) {
  return nlohmann::json(text).dump(-1, ' ', false, nlohmann::json::error_handler_t::replace);
}

std::unique_ptr<spdlog::formatter> make_formatter(LogFormat format) {
  if (format == LogFormat::kJson) return std::make_unique<JsonFormatter>();
  return std::make_unique<TextFormatter>();
}

}  // namespace lucerna::monitor
