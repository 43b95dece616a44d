// Who does which piece of a job.
#pragma once

#include <chrono>
#include <cstddef>
#include <deque>
#include <list>
#include <optional>
#include <stop_token>
#include <vector>

namespace lucerna::client {

/// Not thread-safe.  Servers are told apart by the address of whatever stands for them.
class JobPieces {
 public:
  struct Attempt {
    std::size_t piece;
    const void* server;
    std::chrono::steady_clock::time_point begun;
    std::stop_source stop;
  };
  using Handle = std::list<Attempt>::iterator;

  explicit JobPieces(std::size_t count);

  std::size_t count() const { return done_.size(); }
  std::size_t done_count() const { return done_count_; }
  bool done(std::size_t piece) const { return done_[piece]; }
  bool all_done() const { return done_count_ == done_.size(); }

  /// Gives the server a piece: one that nobody does, or else the one that was begun longest ago by
  /// the fewest others, which may hang or be slow.  Nothing where there is none for it.
  std::optional<Handle> begin(const void* server);
  /// The piece is done: whoever else is at it may stop.
  void complete(std::size_t piece);
  /// The attempt is over.  A piece that is then neither done nor being done is the next to be
  /// given.
  void end(Handle attempt);
  /// Tells all attempts, or those of one server, to stop.
  void stop(const void* server = nullptr);

 private:
  std::deque<std::size_t> pending_;
  std::vector<bool> done_;
  std::size_t done_count_ = 0;
  std::list<Attempt> attempts_;
};

}  // namespace lucerna::client
