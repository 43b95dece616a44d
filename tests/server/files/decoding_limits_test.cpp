// Small files for which the libraries of pictures would work or store far more than their size.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <pthread.h>
#include <zlib.h>

#include <atomic>
#include <chrono>
#include <ctime>
#include <stop_token>
#include <thread>

#include "server/files/image_reader.h"
#include "tests/server/files/picture_texts.h"

namespace lucerna {
namespace {

using testing::chars;
using ::testing::HasSubstr;
using testing::message;
using testing::written;

absl::Status picture_status(const std::string& bytes) {
  return decode_image({"a", bytes}).status();
}

/// A segment of a JPEG file.
std::string jpeg_segment(int marker, const std::string& data) {
  return chars({0xff, marker, 0, static_cast<int>(data.size()) + 2}) + data;
}

/// A grey progressive JPEG file of black texels.  Each scan after the first has no coefficient, and
/// takes 12 bytes.
std::string progressive_jpeg(int side, int scans) {
  const std::string one_code(chars({1}) + std::string(15, '\0'));
  std::string bytes =
      chars({0xff, 0xd8}) + jpeg_segment(0xdb, std::string(1, '\0') + std::string(64, 1)) +
      jpeg_segment(0xc2, chars({8, side >> 8, side & 255, side >> 8, side & 255, 1, 1, 0x11, 0})) +
      jpeg_segment(0xc4, std::string(1, '\0') + one_code + '\0') +
      jpeg_segment(0xc4, chars({0x10}) + one_code + chars({0xe0}));
  const auto blocks = static_cast<std::size_t>(side / 8) * static_cast<std::size_t>(side / 8);
  bytes += jpeg_segment(0xda, chars({1, 1, 0, 0, 0, 0})) + std::string((blocks + 7) / 8, '\0');
  const std::string runs = chars({0, 1});  // one run of 2^14 blocks without coefficients
  for (int i = 1; i < scans; ++i) bytes += jpeg_segment(0xda, chars({1, 1, 0, 1, 63, 1})) + runs;
  return bytes + chars({0xff, 0xd9});
}

TEST(DecodingLimits, ManyScansOfAJpegAreRefusedBeforeDecoding) {
  EXPECT_TRUE(picture_status(progressive_jpeg(8, 1)).ok())
      << picture_status(progressive_jpeg(8, 1));
  EXPECT_TRUE(picture_status(progressive_jpeg(8, 100)).ok())
      << picture_status(progressive_jpeg(8, 100));
  for (const int scans : {101, 20000}) {
    EXPECT_EQ(picture_status(progressive_jpeg(8, scans)).code(),
              absl::StatusCode::kInvalidArgument);
    EXPECT_THAT(message(picture_status(progressive_jpeg(8, scans))),
                HasSubstr(std::to_string(scans) + " scans of 64 texels, allowed: at most 100"));
  }
}

TEST(DecodingLimits, LargePicturesMayHaveFewerScans) {
  EXPECT_THAT(message(picture_status(progressive_jpeg(10240, 41))),
              HasSubstr("41 scans of 104857600 texels, allowed: at most 40"));
}

double cpu_s(clockid_t clock) {
  timespec time{};
  clock_gettime(clock, &time);
  return static_cast<double>(time.tv_sec) + 1e-9 * static_cast<double>(time.tv_nsec);
}

// Compares processor times, which other work of the machine does not change by a factor of 4.
TEST(DecodingLimits, ManyScansStopBetweenScans) {
  const AssetContent content{"a", progressive_jpeg(4096, 100)};
  const double before_s = cpu_s(CLOCK_THREAD_CPUTIME_ID);
  EXPECT_TRUE(decode_image(content).ok());
  const double whole_s = cpu_s(CLOCK_THREAD_CPUTIME_ID) - before_s;
  std::stop_source stop;
  std::atomic<bool> is_over = false;
  absl::Status status;
  double stopped_s = 0;
  std::thread decoder([&] {
    status = decode_image(content, {.stop = stop.get_token()}).status();
    stopped_s = cpu_s(CLOCK_THREAD_CPUTIME_ID);
    is_over = true;
  });
  clockid_t clock{};
  ASSERT_EQ(pthread_getcpuclockid(decoder.native_handle(), &clock), 0);
  while (!is_over && cpu_s(clock) < whole_s / 10)
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  stop.request_stop();
  decoder.join();
  EXPECT_TRUE(absl::IsCancelled(status)) << status;
  EXPECT_LT(stopped_s, 0.35 * whole_s);
}

TEST(DecodingLimits, OtherBytesAreNoScans) {
  // The marker of a scan within a comment.
  const std::string comment = jpeg_segment(0xfe, std::string(100, 'a') + chars({0xff, 0xda, 0, 8}));
  std::string bytes = progressive_jpeg(8, 1);
  for (int i = 0; i < 200; ++i) bytes.insert(2, comment);
  EXPECT_TRUE(picture_status(bytes).ok()) << picture_status(bytes);
}

/// A chunk of a PNG file.
std::string chunk_with_sum(const std::string& kind, const std::string& data) {
  const auto big = [](std::uint32_t n) {
    return chars({static_cast<int>(n >> 24), static_cast<int>(n >> 16 & 255),
                  static_cast<int>(n >> 8 & 255), static_cast<int>(n & 255)});
  };
  const std::string body = kind + data;
  return big(static_cast<std::uint32_t>(data.size())) + body +
         big(static_cast<std::uint32_t>(::crc32(0, reinterpret_cast<const Bytef*>(body.data()),
                                                static_cast<uInt>(body.size()))));
}

TEST(DecodingLimits, ManyPackedTextsOfAPngAreRefused) {
  std::string packed(::compressBound(1), '\0');
  uLongf size = packed.size();
  ASSERT_EQ(::compress(reinterpret_cast<Bytef*>(packed.data()), &size,
                       reinterpret_cast<const Bytef*>("a"), 1),
            Z_OK);
  packed.resize(size);
  constexpr std::size_t kAfterHeader = 33;
  for (const std::string kind : {"zTXt", "iTXt"}) {
    const std::string text =
        chunk_with_sum(kind, std::string("a") + '\0' +
                                 (kind == "zTXt" ? "" : std::string("\1\0\0", 3)) + '\0' + packed);
    std::string bytes = written("a.png", OIIO::ImageSpec(1, 1, 3, OIIO::TypeDesc::UINT8),
                                std::vector<unsigned char>{1, 2, 3});
    for (int i = 0; i < 16; ++i) bytes.insert(kAfterHeader, text);
    EXPECT_TRUE(picture_status(bytes).ok()) << picture_status(bytes);
    bytes.insert(bytes.size() - 12, text);  // also those after the texels
    EXPECT_EQ(message(picture_status(bytes)),
              "a: 17 packed texts and profiles, allowed: at most 16");
  }
}

}  // namespace
}  // namespace lucerna
