// Broken files for tests: those of a valid file with some bytes changed.
#pragma once

#include <cstddef>
#include <random>
#include <span>
#include <string>

namespace lucerna::testing {

/// Changes, inserts, removes or repeats some bytes of `text`, in one to `most_edits` places.
/// `words` are inserted, and belong to the language of the file.
inline std::string mutated(std::string text, std::mt19937& random,
                           std::span<const char* const> words, std::size_t most_edits = 3) {
  const auto below = [&](std::size_t n) { return n == 0 ? 0 : random() % n; };
  for (std::size_t edits = 1 + below(most_edits); edits > 0; --edits) {
    const std::size_t at = below(text.size());
    switch (below(4)) {
      case 0:
        text[at] = static_cast<char>(random());
        break;
      case 1:
        text.insert(at, words[below(words.size())]);
        break;
      case 2:
        text.erase(at, 1 + below(20));
        break;
      default:
        text.insert(at, text.substr(below(text.size()), below(40)));
    }
    if (text.empty()) text.push_back(' ');
  }
  return text;
}

}  // namespace lucerna::testing
