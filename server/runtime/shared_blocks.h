// A sequence whose copies share memory.
#pragma once

#include <compare>
#include <cstddef>
#include <iterator>
#include <memory>
#include <utility>
#include <vector>

namespace lucerna {

/// A sequence in blocks.  Copies share a block until one of them changes an element of it.  Const
/// members may be called from any thread.
template <typename T>
class SharedBlocks {
 public:
  class Iterator {
   public:
    using value_type = T;
    using reference = const T&;
    using pointer = const T*;
    using difference_type = std::ptrdiff_t;
    using iterator_category = std::random_access_iterator_tag;

    Iterator() = default;
    Iterator(const SharedBlocks* of, std::ptrdiff_t at) : of_(of), at_(at) {}
    reference operator*() const { return (*of_)[static_cast<std::size_t>(at_)]; }
    pointer operator->() const { return &**this; }
    reference operator[](difference_type n) const { return *(*this + n); }
    Iterator& operator+=(difference_type n) { return at_ += n, *this; }
    Iterator& operator-=(difference_type n) { return at_ -= n, *this; }
    Iterator& operator++() { return *this += 1; }
    Iterator& operator--() { return *this -= 1; }
    Iterator operator++(int) { return std::exchange(*this, *this + 1); }
    Iterator operator--(int) { return std::exchange(*this, *this - 1); }
    friend Iterator operator+(Iterator a, difference_type n) { return a += n; }
    friend Iterator operator+(difference_type n, Iterator a) { return a += n; }
    friend Iterator operator-(Iterator a, difference_type n) { return a -= n; }
    friend difference_type operator-(const Iterator& a, const Iterator& b) { return a.at_ - b.at_; }
    friend bool operator==(const Iterator& a, const Iterator& b) { return a.at_ == b.at_; }
    friend auto operator<=>(const Iterator& a, const Iterator& b) { return a.at_ <=> b.at_; }

   private:
    const SharedBlocks* of_ = nullptr;
    std::ptrdiff_t at_ = 0;
  };

  std::size_t size() const { return size_; }
  bool empty() const { return size_ == 0; }
  const T& operator[](std::size_t i) const { return elements_[i / kBlock][i % kBlock]; }
  const T& back() const { return (*this)[size_ - 1]; }
  Iterator begin() const { return {this, 0}; }
  Iterator end() const { return {this, static_cast<std::ptrdiff_t>(size_)}; }

  void push_back(T value) {
    if (size_ % kBlock == 0) {
      blocks_.push_back(std::make_shared<std::vector<T>>());
      elements_.push_back(nullptr);
    }
    own(blocks_.size() - 1).push_back(std::move(value));
    elements_.back() = blocks_.back()->data();
    ++size_;
  }
  void replace(std::size_t i, T value) { own(i / kBlock)[i % kBlock] = std::move(value); }
  /// Frees what the last block holds for more elements.
  void shrink_to_fit() {
    if (empty()) return;
    own(blocks_.size() - 1).shrink_to_fit();
    elements_.back() = blocks_.back()->data();
    blocks_.shrink_to_fit(), elements_.shrink_to_fit();
  }

  /// Memory, without the blocks that `other` has too.
  std::size_t bytes_beside(const SharedBlocks& other) const {
    std::size_t sum =
        blocks_.capacity() * sizeof blocks_[0] + elements_.capacity() * sizeof elements_[0];
    for (std::size_t i = 0; i < blocks_.size(); ++i)
      if (i >= other.blocks_.size() || blocks_[i] != other.blocks_[i])
        sum += sizeof(std::vector<T>) + blocks_[i]->capacity() * sizeof(T);
    return sum;
  }

 private:
  static constexpr std::size_t kBlock = 64;

  /// The block, for this sequence alone.
  std::vector<T>& own(std::size_t block) {
    if (blocks_[block].use_count() != 1) {
      blocks_[block] = std::make_shared<std::vector<T>>(*blocks_[block]);
      elements_[block] = blocks_[block]->data();
    }
    return *blocks_[block];
  }

  std::vector<std::shared_ptr<std::vector<T>>> blocks_;
  std::vector<const T*> elements_;  // of each block, so that reading takes no further step
  std::size_t size_ = 0;
};

}  // namespace lucerna
