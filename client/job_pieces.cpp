#include "client/job_pieces.h"

#include <algorithm>
#include <map>
#include <numeric>
#include <set>

namespace lucerna::client {
namespace {

// The same piece at so many servers at once, at most.
constexpr std::size_t kMostAttempts = 3;

}  // namespace

JobPieces::JobPieces(std::size_t count) : pending_(count), done_(count) {
  std::iota(pending_.begin(), pending_.end(), std::size_t{0});
}

std::optional<JobPieces::Handle> JobPieces::begin(const void* server) {
  std::optional<std::size_t> piece;
  if (!pending_.empty()) {
    piece = pending_.front();
    pending_.pop_front();
  } else {
    std::map<std::size_t, std::size_t> at_it;
    std::set<std::size_t> own;
    for (const Attempt& attempt : attempts_) {
      ++at_it[attempt.piece];
      if (attempt.server == server) own.insert(attempt.piece);
    }
    const Attempt* best = nullptr;
    for (const Attempt& attempt : attempts_) {
      const std::size_t n = at_it[attempt.piece];
      if (done_[attempt.piece] || own.contains(attempt.piece) || n >= kMostAttempts) continue;
      if (best == nullptr || n < at_it[best->piece] ||
          (n == at_it[best->piece] && attempt.begun < best->begun))
        best = &attempt;
    }
    if (best != nullptr) piece = best->piece;
  }
  if (!piece) return std::nullopt;
  return attempts_.insert(attempts_.end(), {*piece, server, std::chrono::steady_clock::now(), {}});
}

void JobPieces::complete(std::size_t piece) {
  done_[piece] = true;
  ++done_count_;
  for (Attempt& attempt : attempts_)
    if (attempt.piece == piece) attempt.stop.request_stop();
}

void JobPieces::end(Handle attempt) {
  const std::size_t piece = attempt->piece;
  attempts_.erase(attempt);
  const auto is_it = [&](const Attempt& a) { return a.piece == piece; };
  if (!done_[piece] && std::none_of(attempts_.begin(), attempts_.end(), is_it))
    pending_.push_front(piece);
}

void JobPieces::stop(const void* server) {
  for (Attempt& attempt : attempts_)
    if (server == nullptr || attempt.server == server) attempt.stop.request_stop();
}

}  // namespace lucerna::client
