// The bytes of a JPEG file for OpenImageIO.  Only for the files of this room.
#pragma once

#include <OpenImageIO/filesystem.h>

#include <cstddef>
#include <cstdint>
#include <stop_token>
#include <string_view>
#include <vector>

namespace lucerna {

/// Gives libjpeg one scan at a time, and no bytes after a request to stop.  libjpeg reads all scans
/// of a progressive file before the first row, for seconds, and OpenImageIO has no other way to
/// stop it: libjpeg takes the missing bytes for the end of the file.
class JpegSource final : public OIIO::Filesystem::IOFile {
 public:
  /// `bytes` must outlive the object.
  JpegSource(std::string_view bytes, std::stop_token stop);
  ~JpegSource() override;
  bool seek(std::int64_t offset) override;
  std::size_t read(void* to, std::size_t size) override;
  std::size_t pread(void* to, std::size_t size, std::int64_t offset) override;
  std::size_t size() const override { return state_->bytes.size(); }

 private:
  struct State {
    std::string_view bytes;
    std::stop_token stop;
    std::vector<std::size_t> scans;  ///< where they begin
    std::size_t at = 0;
    bool is_paused = false;  ///< at the scan that begins at `at`
  };
  explicit JpegSource(State* state);
  static std::FILE* open(State* state);
  /// The next bytes of the scan; -1 once at its end.
  static std::int64_t next(State& state, char* to, std::size_t size);

  State* state_;
};

}  // namespace lucerna
