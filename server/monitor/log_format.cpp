#include "server/monitor/log_format.h"

#include <fmt/format.h>
#include <spdlog/details/log_msg.h>
#include <spdlog/pattern_formatter.h>

#include <nlohmann/json.hpp>
#include <string_view>
#include <utility>

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

class LimitedSink final : public spdlog::sinks::sink {
 public:
  LimitedSink(std::shared_ptr<spdlog::sinks::sink> out, std::shared_ptr<LogLimit> limit)
      : out_(std::move(out)), limit_(std::move(limit)) {}

  void log(const spdlog::details::log_msg& message) override {
    const auto left_out = limit_->take();
    if (!left_out) return;
    if (*left_out > 0) {
      const std::string text = describe_left_out(*left_out);
      spdlog::details::log_msg missing(message.logger_name, spdlog::level::warn, text);
      missing.time = message.time;
      out_->log(missing);
    }
    out_->log(message);
  }
  void flush() override { out_->flush(); }
  void set_pattern(const std::string& pattern) override { out_->set_pattern(pattern); }
  void set_formatter(std::unique_ptr<spdlog::formatter> formatter) override {
    out_->set_formatter(std::move(formatter));
  }

 private:
  std::shared_ptr<spdlog::sinks::sink> out_;
  std::shared_ptr<LogLimit> limit_;
};

}  // namespace

std::string json_string(const std::string& text) {
  return nlohmann::json(text).dump(-1, ' ', false, nlohmann::json::error_handler_t::replace);
}

std::string describe_left_out(std::uint64_t lines) {
  return fmt::format("{} lines were left out, because there were too many in a second", lines);
}

std::unique_ptr<spdlog::formatter> make_formatter(LogFormat format) {
  if (format == LogFormat::kJson) return std::make_unique<JsonFormatter>();
  return std::make_unique<TextFormatter>();
}

std::shared_ptr<spdlog::sinks::sink> limited(std::shared_ptr<spdlog::sinks::sink> out,
                                             std::shared_ptr<LogLimit> limit) {
  return std::make_shared<LimitedSink>(std::move(out), std::move(limit));
}

}  // namespace lucerna::monitor
