#include "server/pictures/jpeg_source.h"

#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <utility>

#include "server/pictures/decoding_limits.h"

namespace lucerna {

JpegSource::JpegSource(std::string_view bytes, std::stop_token stop)
    : JpegSource(new State{bytes, std::move(stop), jpeg_scans(bytes).scans}) {}

JpegSource::JpegSource(State* state) : IOFile(open(state), Read), state_(state) {}

JpegSource::~JpegSource() {
  if (m_file != nullptr) std::fclose(m_file);
  delete state_;
}

std::FILE* JpegSource::open(State* state) {
  cookie_io_functions_t functions{};
  functions.read = [](void* of, char* to, std::size_t size) -> ssize_t {
    return next(*static_cast<State*>(of), to, size);
  };
  functions.seek = [](void* of, off64_t* offset, int from) {
    State& s = *static_cast<State*>(of);
    const auto all = static_cast<off64_t>(s.bytes.size());
    const off64_t base = from == SEEK_END ? all : from == SEEK_CUR ? static_cast<off64_t>(s.at) : 0;
    *offset = std::clamp<off64_t>(base + *offset, 0, all);
    s.at = static_cast<std::size_t>(*offset);
    return 0;
  };
  std::FILE* file = fopencookie(state, "rb", functions);
  // Else the stream would ask for more than libjpeg does.
  if (file != nullptr) std::setvbuf(file, nullptr, _IONBF, 0);
  return file;
}

std::int64_t JpegSource::next(State& state, char* to, std::size_t size) {
  if (state.stop.stop_requested()) return 0;
  const auto following = std::ranges::lower_bound(state.scans, state.at);
  const bool is_at_scan = following != state.scans.end() && *following == state.at;
  // An error ends this read with what it has, and not those after it.
  if (is_at_scan && !std::exchange(state.is_paused, true)) {
    errno = EAGAIN;
    return -1;
  }
  state.is_paused = false;
  const auto end = is_at_scan ? std::next(following) : following;
  const std::size_t limit = end == state.scans.end() ? state.bytes.size() : *end;
  const std::size_t n = std::min(size, limit - state.at);
  std::memcpy(to, state.bytes.data() + state.at, n);
  state.at += n;
  return static_cast<std::int64_t>(n);
}

bool JpegSource::seek(std::int64_t offset) {
  return m_file != nullptr && std::fseek(m_file, static_cast<long>(offset), SEEK_SET) == 0;
}

std::size_t JpegSource::read(void* to, std::size_t size) {
  const std::size_t n = pread(to, size, static_cast<std::int64_t>(state_->at));
  state_->at += n;
  return n;
}

std::size_t JpegSource::pread(void* to, std::size_t size, std::int64_t offset) {
  if (offset < 0 || static_cast<std::size_t>(offset) >= state_->bytes.size()) return 0;
  const std::size_t n = std::min(size, state_->bytes.size() - static_cast<std::size_t>(offset));
  std::memcpy(to, state_->bytes.data() + offset, n);
  return n;
}

}  // namespace lucerna
