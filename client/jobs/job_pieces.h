// Which of a job's pieces are done, being done, and next.
#pragma once

#include <chrono>
#include <cstdint>
#include <deque>
#include <map>
#include <optional>
#include <set>
#include <tuple>
#include <unordered_map>
#include <utility>
#include <vector>

namespace lucerna::client {

/// Every operation costs the logarithm of the attempts under way, at most.
class JobPieces {
 public:
  using Time = std::chrono::steady_clock::time_point;
  using ServerId = std::size_t;
  using AttemptId = std::uint64_t;
  struct Attempt {
    std::size_t piece;
    ServerId server;
  };

  explicit JobPieces(std::size_t count);

  std::size_t count() const { return done_.size(); }
  std::size_t done_count() const { return done_count_; }
  bool done(std::size_t piece) const { return done_[piece]; }
  bool all_done() const { return done_count_ == done_.size(); }
  /// Whether there is a piece that no server is at.
  bool any_pending() const { return !pending_.empty(); }
  /// Whether there is one that another server could do as well.
  bool any_to_duplicate() const { return !to_duplicate_.empty(); }

  /// The next piece that no server is at is the server's now.
  std::optional<AttemptId> begin(ServerId server, Time now);
  /// As above, for a piece that others are at, which may hang or be slow: the one with the fewest
  /// attempts, and of those the one that was begun longest ago.  The server is at none itself.
  std::optional<AttemptId> begin_duplicate(ServerId server);
  const Attempt& attempt(AttemptId id) const { return attempts_.at(id); }
  /// The attempts at a piece.
  std::vector<AttemptId> attempts_at(std::size_t piece) const;
  /// The attempts of a server.
  std::vector<AttemptId> attempts_of(ServerId server) const;

  void complete(std::size_t piece);
  /// The attempt is over.  A piece that is then neither done nor being done is the next to be
  /// given.
  void end(AttemptId attempt);

 private:
  struct Active {
    Time begun;
    std::vector<AttemptId> attempts;
  };
  using Key = std::tuple<std::size_t, Time, std::size_t>;  // attempts, begun, piece

  /// Puts the piece among those to duplicate, or takes it out.
  void file(std::size_t piece, const Active& active, bool in);
  AttemptId add(std::size_t piece, Active& active, ServerId server);

  std::deque<std::size_t> pending_;
  std::vector<bool> done_;
  std::size_t done_count_ = 0;
  std::unordered_map<AttemptId, Attempt> attempts_;
  std::unordered_map<std::size_t, Active> active_;  // by piece
  std::set<Key> to_duplicate_;
  AttemptId next_id_ = 0;
};

}  // namespace lucerna::client
