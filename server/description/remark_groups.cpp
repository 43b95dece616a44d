#include "server/description/remark_groups.h"

#include <fmt/format.h>

#include <functional>
#include <utility>

namespace lucerna {

void RemarkGroups::add(SourceLocation where, std::string what, std::string instead) {
  // A byte that no text holds separates the parts.
  std::string key = what + '\0' + instead;
  const std::string all =
      fmt::format("{}{}{}:{}:{}", key, '\0', where.file.str(), where.line, where.column);
  if (!seen_.insert(std::hash<std::string>()(all)).second) return;
  if (const auto found = numbers_.find(key); found != numbers_.end()) {
    Remark& group = groups_[found->second];
    ++group.count;
    if (group.more.size() < kMostMorePlaces) group.more.push_back(std::move(where));
    return;
  }
  if (groups_.size() >= kMostGroups) {
    ++left_out_;
    return;
  }
  numbers_.emplace(std::move(key), groups_.size());
  groups_.push_back({std::move(where), std::move(what), std::move(instead)});
}

std::vector<Remark> RemarkGroups::take(const std::string& file) {
  if (left_out_ > 0)
    groups_.push_back({{file},
                       fmt::format("{} more things are not modelled", left_out_),
                       "see the remarks before this one"});
  return std::move(groups_);
}

}  // namespace lucerna
