#include "server/rpc/token_file.h"

#include <absl/strings/ascii.h>
#include <absl/strings/escaping.h>
#include <fmt/format.h>
#include <toml++/toml.h>

#include <algorithm>
#include <sstream>

#include "proto/common/sha256.h"
#include "server/runtime/text_file.h"

namespace lucerna::access {
namespace {

// A shorter token can be guessed.
constexpr std::size_t kShortestToken = 16;
constexpr std::size_t kLongestName = 64;
constexpr std::size_t kLongestShown = 80;

/// The value as an error shows it.  A text may be a secret in the wrong line, so it is not shown.
std::string shown(const toml::node& node) {
  if (node.is_string()) return "a text";
  std::ostringstream out;
  node.visit([&](const auto& value) { out << value; });
  std::string text = out.str();
  std::replace(text.begin(), text.end(), '\n', ' ');
  if (text.size() > kLongestShown) text = text.substr(0, kLongestShown) + "...";
  return text;
}

class Reader {
 public:
  explicit Reader(std::string path) : path_(std::move(path)) {}

  void read(const toml::table& file) {
    for (const auto& [key, node] : file) {
      const toml::array* tokens = node.as_array();
      if (key.str() != "token" || tokens == nullptr || !tokens->is_array_of_tables()) {
        error(key.source(), fmt::format("{}, allowed: tables [[token]]", key.str()));
        continue;
      }
      for (const toml::node& token : *tokens) read_token(*token.as_table());
    }
  }
  void error(const toml::source_region& at, const std::string& what) {
    errors.push_back(fmt::format("{}:{}:{}: {}", path_, at.begin.line, at.begin.column, what));
  }

  std::vector<std::string> errors;
  std::vector<Token> tokens;

 private:
  void read_token(const toml::table& table) {
    Token token;
    bool has_roles = false;
    for (const auto& [key, node] : table) {
      const std::string_view name = key.str();
      if (name == "name") {
        read_name(key, node, token);
      } else if (name == "sha256" || name == "token") {
        if (name == "token" && table.contains("sha256")) {
          error(key.source(), "token and sha256, allowed: one of them");
        } else {
          read_secret(key, node, token);
        }
      } else if (name == "roles") {
        has_roles = true;
        read_roles(key, node, token);
      } else if (name == "max-requests") {
        read_number(key, node, token.quota.requests);
      } else if (name == "max-leases") {
        read_number(key, node, token.quota.leases);
      } else if (name == "max-scenes") {
        read_number(key, node, token.quota.scenes);
      } else if (name == "max-items-per-second") {
        read_number(key, node, token.quota.items_per_second);
      } else if (name == "max-asset-bytes") {
        read_number(key, node, token.quota.asset_bytes);
      } else {
        error(key.source(), fmt::format("{}, allowed: name, sha256, token, roles, max-requests, "
                                        "max-leases, max-scenes, max-items-per-second, "
                                        "max-asset-bytes",
                                        name));
      }
    }
    if (!table.contains("name")) error(table.source(), "the token has no name");
    if (!table.contains("sha256") && !table.contains("token")) {
      error(table.source(), "the token has no sha256");
    }
    if (!has_roles) error(table.source(), "the token has no roles");
    tokens.push_back(std::move(token));
  }

  void read_name(const toml::key& key, const toml::node& node, Token& token) {
    const auto* text = node.as_string();
    if (text == nullptr || text->get().empty() || text->get().size() > kLongestName ||
        !std::ranges::all_of(text->get(), [](unsigned char c) {
          return absl::ascii_isalnum(c) || c == '-' || c == '_' || c == '.';
        })) {
      return error(key.source(),
                   fmt::format("name, allowed: 1 to {} letters, digits, - _ .", kLongestName));
    }
    token.name = text->get();
  }

  void read_secret(const toml::key& key, const toml::node& node, Token& token) {
    const auto* text = node.as_string();
    if (key.str() == "sha256") {
      if (text == nullptr || text->get().size() != 2 * kSha256Bytes ||
          !std::ranges::all_of(text->get(), absl::ascii_isxdigit))
        return error(key.source(), "sha256, allowed: the 64 hexadecimal digits of a SHA-256");
      token.sha256 = absl::HexStringToBytes(text->get());
    } else if (text == nullptr || text->get().size() < kShortestToken) {
      error(key.source(), fmt::format("token, allowed: at least {} characters", kShortestToken));
    } else {
      token.sha256 = sha256(text->get());
    }
    const bool known = std::any_of(tokens.begin(), tokens.end(), [&](const Token& other) {
      return !token.sha256.empty() && other.sha256 == token.sha256;
    });
    if (known) error(key.source(), "the same token twice, allowed: each token once");
  }

  void read_roles(const toml::key& key, const toml::node& node, Token& token) {
    const toml::array* list = node.as_array();
    bool good = list != nullptr && !list->empty();
    for (std::size_t i = 0; good && i < list->size(); ++i) {
      const auto* text = (*list)[i].as_string();
      const auto* role = text == nullptr ? monitor::kRoleNames.end()
                                         : std::find(monitor::kRoleNames.begin(),
                                                     monitor::kRoleNames.end(), text->get());
      good = role != monitor::kRoleNames.end();
      if (good) token.roles.insert(static_cast<Role>(role - monitor::kRoleNames.begin()));
    }
    if (!good) {
      error(key.source(),
            fmt::format("roles, allowed: a list of {}", fmt::join(monitor::kRoleNames, ", ")));
    }
  }

  void read_number(const toml::key& key, const toml::node& node, std::uint64_t& value) {
    const auto* number = node.as_integer();
    if (number == nullptr || number->get() < 0) {
      return error(key.source(),
                   fmt::format("{} = {}, allowed: a whole number, at least 0; 0: no limit",
                               key.str(), shown(node)));
    }
    value = static_cast<std::uint64_t>(number->get());
  }

  std::string path_;
};

}  // namespace

absl::StatusOr<std::vector<Token>> read_token_file(const std::string& path) {
  const absl::StatusOr<std::string> text = read_text_file(path);
  if (!text.ok()) {
    return absl::InvalidArgumentError(
        fmt::format("{}: {}", path, std::string(text.status().message())));
  }
  Reader reader(path);
  try {
    reader.read(toml::parse(*text, path));
  } catch (const toml::parse_error& error) {
    reader.error(error.source(), std::string(error.description()));
  }
  if (reader.errors.empty() && reader.tokens.empty()) {
    reader.errors.push_back(fmt::format("{}: no [[token]], so nobody could call the server", path));
  }
  if (!reader.errors.empty()) {
    return absl::InvalidArgumentError(fmt::format("{}", fmt::join(reader.errors, "\n")));
  }
  return std::move(reader.tokens);
}

}  // namespace lucerna::access
