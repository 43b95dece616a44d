// Keeps track of a job's pieces: pending, in progress, done.
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

/// An operation costs at most the logarithm of the number of attempts in progress.
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
  /// Whether a piece waits for a server.
  bool any_pending() const { return !pending_.empty(); }
  /// Whether a second server may get a piece in progress.
  bool any_to_duplicate() const { return !to_duplicate_.empty(); }

  /// Gives the server the next pending piece; nothing if there is none.
  std::optional<AttemptId> begin(ServerId server, Time now);
  /// Gives the server a piece that other servers are working on, because those may hang or be slow.
  /// Chooses the piece with the fewest attempts in progress, and of these the piece begun first.
  /// The server must have no attempt in progress.
  std::optional<AttemptId> begin_duplicate(ServerId server);
  const Attempt& attempt(AttemptId id) const { return attempts_.at(id); }
  /// Attempts of a piece that are in progress.
  std::vector<AttemptId> attempts_at(std::size_t piece) const;
  /// Attempts of a server that are in progress.
  std::vector<AttemptId> attempts_of(ServerId server) const;

  void complete(std::size_t piece);
  /// Ends an attempt.  If the piece is neither done nor in progress elsewhere, begin() gives it
  /// next.
  void end(AttemptId attempt);

 private:
  struct Active {
    Time begun;
    std::vector<AttemptId> attempts;
  };
  using Key = std::tuple<std::size_t, Time, std::size_t>;  // attempts, begun, piece

  /// Adds the piece to `to_duplicate_`, or removes it.
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
