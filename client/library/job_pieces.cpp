#include "client/library/job_pieces.h"

#include <algorithm>
#include <numeric>

namespace lucerna::client {
namespace {

// Most servers that work on a piece at the same time.
constexpr std::size_t kMostAttempts = 3;

}  // namespace

JobPieces::JobPieces(std::size_t count) : pending_(count), done_(count) {
  std::iota(pending_.begin(), pending_.end(), std::size_t{0});
}

void JobPieces::file(std::size_t piece, const Active& active, bool in) {
  const std::size_t n = active.attempts.size();
  const Key key{n, active.begun, piece};
  if (!in) {
    to_duplicate_.erase(key);
  } else if (n > 0 && n < kMostAttempts && !done_[piece]) {
    to_duplicate_.insert(key);
  }
}

JobPieces::AttemptId JobPieces::add(std::size_t piece, Active& active, ServerId server) {
  file(piece, active, false);
  const AttemptId id = next_id_++;
  active.attempts.push_back(id);
  attempts_.emplace(id, Attempt{piece, server});
  file(piece, active, true);
  return id;
}

std::optional<JobPieces::AttemptId> JobPieces::begin(ServerId server, Time now) {
  if (pending_.empty()) return std::nullopt;
  const std::size_t piece = pending_.front();
  pending_.pop_front();
  return add(piece, active_[piece] = {now, {}}, server);
}

std::optional<JobPieces::AttemptId> JobPieces::begin_duplicate(ServerId server) {
  if (to_duplicate_.empty()) return std::nullopt;
  const std::size_t piece = std::get<2>(*to_duplicate_.begin());
  return add(piece, active_.at(piece), server);
}

std::vector<JobPieces::AttemptId> JobPieces::attempts_at(std::size_t piece) const {
  const auto found = active_.find(piece);
  return found == active_.end() ? std::vector<AttemptId>{} : found->second.attempts;
}

std::vector<JobPieces::AttemptId> JobPieces::attempts_of(ServerId server) const {
  std::vector<AttemptId> result;
  for (const auto& [id, attempt] : attempts_)
    if (attempt.server == server) result.push_back(id);
  std::sort(result.begin(), result.end());
  return result;
}

void JobPieces::complete(std::size_t piece) {
  if (const auto found = active_.find(piece); found != active_.end())
    file(piece, found->second, false);
  done_[piece] = true;
  ++done_count_;
}

void JobPieces::end(AttemptId attempt) {
  const std::size_t piece = attempts_.at(attempt).piece;
  attempts_.erase(attempt);
  Active& active = active_.at(piece);
  file(piece, active, false);
  std::erase(active.attempts, attempt);
  file(piece, active, true);
  if (!active.attempts.empty()) return;
  active_.erase(piece);
  if (!done_[piece]) pending_.push_front(piece);
}

}  // namespace lucerna::client
