// Counts the memory that a parser holds.
#pragma once

#include <cstddef>

namespace lucerna::fuzz {

/// Counts what this thread allocates from here on.  Not more than one at a time on a thread.
class AllocationBound {
 public:
  /// Times the size of the input.
  static constexpr std::size_t kFactor = 8;
  /// For what does not grow with the input: buffers of streams, messages of errors, tables that are
  /// made at their first use.
  static constexpr std::size_t kFixedBytes = std::size_t{64} << 10;

  AllocationBound(const char* parser, std::size_t input_bytes);
  AllocationBound(const AllocationBound&) = delete;
  AllocationBound& operator=(const AllocationBound&) = delete;

  /// The most bytes that were held at once.
  std::size_t peak_bytes() const;
  /// The same without the bytes that are held now.  Call it while the result of the parse exists.
  std::size_t peak_beyond_result_bytes() const;

  /// Ends the program if `bytes` exceed kFactor times the input and kFixedBytes.
  void require(std::size_t bytes) const;
  /// The same for any number of `allowed` bytes.
  void require_at_most(std::size_t bytes, std::size_t allowed) const;

 private:
  const char* parser_;
  std::size_t input_bytes_;
};

/// The same for .pbrt files: also 256 open blocks with their attributes, and the parameters of a
/// directive.
inline constexpr std::size_t kPbrtFixedBytes = std::size_t{2} << 20;
/// The same for toml++, which holds each key and value with its place: far more than its text.
inline constexpr std::size_t kTomlFactor = 128;
inline constexpr std::size_t kTomlFixedBytes = std::size_t{256} << 10;

}  // namespace lucerna::fuzz
