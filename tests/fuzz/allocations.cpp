#include "tests/fuzz/allocations.h"

#include <algorithm>
#include <cstdint>
#include <cstdio>
#include <cstdlib>

#if defined(__has_feature)
#if __has_feature(address_sanitizer)
#define LUCERNA_HAS_MALLOC_HOOKS 1
#endif
#elif defined(__SANITIZE_ADDRESS__)
#define LUCERNA_HAS_MALLOC_HOOKS 1
#endif

#ifdef LUCERNA_HAS_MALLOC_HOOKS
#include <sanitizer/allocator_interface.h>
#else
#include <malloc.h>

#include <new>
#endif

namespace lucerna::fuzz {
namespace {

// Each thread counts its own memory, since parsers use one thread.
thread_local std::int64_t held = 0, most_held = 0;

void add(std::size_t bytes) {
  held += static_cast<std::int64_t>(bytes);
  most_held = std::max(most_held, held);
}

void subtract(std::size_t bytes) { held -= static_cast<std::int64_t>(bytes); }

#ifdef LUCERNA_HAS_MALLOC_HOOKS
const int kInstalled = __sanitizer_install_malloc_and_free_hooks(
    [](const volatile void*, std::size_t bytes) { add(bytes); },
    [](const volatile void* at) {
      if (at != nullptr)
        subtract(__sanitizer_get_allocated_size(const_cast<const void*>(at)));  // NOLINT
    });
#endif

}  // namespace

AllocationBound::AllocationBound(const char* parser, std::size_t input_bytes)
    : parser_(parser), input_bytes_(input_bytes) {
#ifdef LUCERNA_HAS_MALLOC_HOOKS
  if (kInstalled == 0) std::abort();
#endif
  held = most_held = 0;
}

std::size_t AllocationBound::peak_bytes() const { return static_cast<std::size_t>(most_held); }

std::size_t AllocationBound::peak_beyond_result_bytes() const {
  return static_cast<std::size_t>(most_held - std::max<std::int64_t>(held, 0));
}

void AllocationBound::require(std::size_t bytes) const {
  require_at_most(bytes, kFactor * input_bytes_ + kFixedBytes);
}

void AllocationBound::require_at_most(std::size_t bytes, std::size_t allowed) const {
  if (bytes <= allowed) return;
  std::fprintf(stderr, "%s: %zu bytes of memory for %zu bytes of input, allowed: %zu\n", parser_,
               bytes, input_bytes_, allowed);
  std::abort();
}

}  // namespace lucerna::fuzz

#ifndef LUCERNA_HAS_MALLOC_HOOKS
// Without a sanitizer, the operators count.
void* operator new(std::size_t bytes) {
  void* at = std::malloc(std::max<std::size_t>(bytes, 1));  // NOLINT
  if (at == nullptr) throw std::bad_alloc();
  lucerna::fuzz::add(malloc_usable_size(at));
  return at;
}
void operator delete(void* at) noexcept {
  if (at == nullptr) return;
  lucerna::fuzz::subtract(malloc_usable_size(at));
  std::free(at);  // NOLINT
}
void operator delete(void* at, std::size_t) noexcept { operator delete(at); }
#endif
