// Numbers on the command line: whole numbers, sizes in bytes and numbers with a fraction, each with
// its range.
#pragma once

#include <cstdint>
#include <string>

namespace lucerna {

/// A range of allowed numbers, both ends included.
template <typename Number>
struct Range {
  Number least, most;
};

/// Each checks `text` and returns an error for people, or nothing if the number is in the range.
/// Text that is no number, such as "nan" or "1e30" for a whole number, is an error too.
std::string check_whole(const std::string& text, const Range<std::uint64_t>& range);
std::string check_real(const std::string& text, const Range<double>& range);
/// The same for a size such as 8GiB, 512 MB or 4096.  Units count in powers of 1024: B, K, M, G, T,
/// P, each also with B or iB, in upper or lower case.  Replaces `text` by the bytes.
std::string to_bytes(std::string& text, const Range<std::uint64_t>& range);

}  // namespace lucerna
