#include "client/library/tev.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <mutex>
#include <random>

#include "client/library/picture.h"
#include "tests/tev_receiver.h"

namespace lucerna {
namespace {

using client::TevSender;
using std::chrono::milliseconds;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

constexpr milliseconds kPatience = std::chrono::minutes(10);

v1::PixelRect rect(std::uint32_t x0, std::uint32_t y0, std::uint32_t x1, std::uint32_t y1) {
  v1::PixelRect result;
  result.set_x0(x0);
  result.set_y0(y0);
  result.set_x1(x1);
  result.set_y1(y1);
  return result;
}

std::vector<float> noise(std::size_t count, unsigned seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<float> values(-1, 1000);
  std::vector<float> result(count);
  for (float& value : result) value = values(random);
  return result;
}

class Tev : public ::testing::Test {
 protected:
  std::unique_ptr<TevSender> connect(const std::string& address) {
    auto sender = TevSender::create(address, [this](const std::string& event) {
      const std::lock_guard lock(mutex_);
      events_.push_back(event);
    });
    EXPECT_TRUE(sender.ok()) << sender.status();
    return *std::move(sender);
  }
  /// Sends a picture of noise in tiles of this edge, and keeps the picture.
  void send_noise(TevSender& sender, std::uint32_t width, std::uint32_t height, std::uint32_t edge,
                  unsigned seed) {
    sent_.width = width;
    sent_.height = height;
    sent_.pixels.resize(std::size_t{3} * width * height);
    for (std::uint32_t y = 0; y < height; y += edge) {
      for (std::uint32_t x = 0; x < width; x += edge) {
        const v1::PixelRect r = rect(x, y, std::min(x + edge, width), std::min(y + edge, height));
        const std::vector<float> rgb =
            noise(std::size_t{3} * (r.x1() - r.x0()) * (r.y1() - r.y0()), ++seed);
        client::put_pixels(r, rgb, &sent_);
        ASSERT_TRUE(sender.update(r, rgb).ok());
      }
    }
  }
  std::vector<std::string> events() {
    const std::lock_guard lock(mutex_);
    return events_;
  }

  client::Picture sent_;

 private:
  std::mutex mutex_;
  std::vector<std::string> events_;
};

TEST_F(Tev, PacketsFollowTheProtocolByteForByte) {
  TevReceiver viewer;
  const auto sender = connect(viewer.address());
  ASSERT_TRUE(sender->begin("a.exr", 2, 3).ok());
  // Two pixels, one above the other.
  ASSERT_TRUE(sender->update(rect(1, 1, 2, 3), std::vector<float>{1, 2, -3, 0.5F, 0, 4}).ok());
  ASSERT_TRUE(sender->flush(kPatience));
  using namespace std::string_literals;
  const std::string expected =
      // 30 bytes, CreateImage, with focus, its name, 2 x 3, three channels
      "\x1e\0\0\0\x04\x01"s + "a.exr\0"s + "\x02\0\0\0\x03\0\0\0\x03\0\0\0"s + "R\0G\0B\0"s +
      // 110 bytes, UpdateImage (third version), without focus, its name, three channels
      "\x6e\0\0\0\x06\0"s + "a.exr\0"s + "\x03\0\0\0"s + "R\0G\0B\0"s +
      // at 1, 1; 1 x 2
      "\x01\0\0\0\x01\0\0\0\x01\0\0\0\x02\0\0\0"s +
      // offsets 0, 1, 2, strides 3, 3, 3
      "\0\0\0\0\0\0\0\0\x01\0\0\0\0\0\0\0\x02\0\0\0\0\0\0\0"s +
      "\x03\0\0\0\0\0\0\0\x03\0\0\0\0\0\0\0\x03\0\0\0\0\0\0\0"s +
      // 1, 2, -3, 0.5, 0, 4 as IEEE 754
      "\0\0\x80\x3f\0\0\0\x40\0\0\x40\xc0\0\0\0\x3f\0\0\0\0\0\0\x80\x40"s;
  ASSERT_TRUE(TevReceiver::wait_for([&] { return viewer.bytes().size() >= expected.size(); }));
  EXPECT_EQ(viewer.bytes(), expected);
  EXPECT_THAT(events(), IsEmpty());
}

TEST_F(Tev, PicturesArriveBitForBitForAllTileSizes) {
  TevReceiver viewer;
  const auto sender = connect(viewer.address());
  for (const std::uint32_t edge : {1000U, 64U, 37U}) {
    const std::string name = std::to_string(edge) + ".exr";
    ASSERT_TRUE(sender->begin(name, 700, 301).ok());
    send_noise(*sender, 700, 301, edge, edge);
    ASSERT_TRUE(sender->flush(kPatience));
    EXPECT_TRUE(TevReceiver::wait_for([&] { return viewer.images()[name].rgb == sent_.pixels; }))
        << edge;
  }
  EXPECT_EQ(viewer.connections(), 1U);
  EXPECT_THAT(viewer.faults(), IsEmpty());
  EXPECT_THAT(events(), IsEmpty());
}

TEST_F(Tev, AViewerThatDoesNotReadDelaysNothingAndGetsTheNewestPixels) {
  TevReceiver viewer({.asleep = true});
  const auto sender = connect(viewer.address());
  ASSERT_TRUE(sender->begin("a.exr", 1500, 1500).ok());
  constexpr int kRounds = 12;
  for (int round = 0; round < kRounds; ++round) send_noise(*sender, 1500, 1500, 150, 1000 * round);
  EXPECT_FALSE(sender->flush(milliseconds(500)));
  EXPECT_FALSE(sender->flush(std::chrono::hours(1)));  // does not wait again
  EXPECT_THAT(events(), ElementsAre(HasSubstr("did not accept the whole picture")));
  viewer.read_on();
  EXPECT_TRUE(TevReceiver::wait_for([&] { return viewer.images()["a.exr"].rgb == sent_.pixels; }));
  EXPECT_TRUE(sender->flush(kPatience));
  // The newest version of each of the 100 tiles, after the packets in the buffers of the sockets.
  EXPECT_LT(viewer.images()["a.exr"].updates, 100U * kRounds / 2);
  EXPECT_THAT(viewer.faults(), IsEmpty());
}

TEST_F(Tev, WithoutAViewerItContinuesAndReportsOnce) {
  int port = 0;
  {
    const TevReceiver gone;
    port = gone.port();
  }
  const auto sender = connect("127.0.0.1:" + std::to_string(port));
  ASSERT_TRUE(sender->begin("a.exr", 100, 80).ok());
  send_noise(*sender, 100, 80, 30, 1);
  EXPECT_FALSE(sender->flush(kPatience));
  // A late viewer gets the whole picture.
  const TevReceiver viewer({.port = port});
  EXPECT_TRUE(TevReceiver::wait_for([&] { return viewer.images()["a.exr"].rgb == sent_.pixels; }));
  EXPECT_TRUE(sender->flush(kPatience));
  EXPECT_THAT(events(), ElementsAre(HasSubstr("Connection refused")));
  EXPECT_THAT(viewer.faults(), IsEmpty());
}

TEST_F(Tev, AViewerThatLeavesWithinAPacketGetsTheWholePictureAgain) {
  TevReceiver viewer({.close_after = 100'001});
  const auto sender = connect(viewer.address());
  ASSERT_TRUE(sender->begin("a.exr", 512, 512).ok());
  send_noise(*sender, 512, 512, 64, 1);
  ASSERT_TRUE(TevReceiver::wait_for([&] { return viewer.connections() == 2; }));
  EXPECT_TRUE(TevReceiver::wait_for([&] { return viewer.images()["a.exr"].rgb == sent_.pixels; }));
  EXPECT_TRUE(sender->flush(kPatience));
  EXPECT_THAT(events(), ElementsAre(HasSubstr("the connection ended")));
  EXPECT_THAT(viewer.faults(), IsEmpty());
}

TEST_F(Tev, ANewPictureReplacesUnsentPixels) {
  TevReceiver viewer({.asleep = true});
  const auto sender = connect(viewer.address());
  ASSERT_TRUE(sender->begin("a.exr", 2000, 2000).ok());
  send_noise(*sender, 2000, 2000, 250, 1);
  ASSERT_TRUE(sender->begin("b.exr", 40, 30).ok());
  send_noise(*sender, 40, 30, 16, 2);
  sent_.pixels.resize(std::size_t{3} * 40 * 30);
  viewer.read_on();
  ASSERT_TRUE(sender->flush(kPatience));
  EXPECT_TRUE(TevReceiver::wait_for([&] { return viewer.images()["b.exr"].updates >= 6; }));
  EXPECT_LT(viewer.images()["a.exr"].updates, 64U);
  EXPECT_THAT(viewer.faults(), IsEmpty());
}

TEST_F(Tev, EndsAtOnceWhileAViewerDoesNotRead) {
  TevReceiver viewer({.asleep = true});
  const auto sender = connect(viewer.address());
  ASSERT_TRUE(sender->begin("a.exr", 2000, 2000).ok());
  send_noise(*sender, 2000, 2000, 250, 1);
  // Otherwise the destructor waits forever.
}

TEST_F(Tev, DefaultPortIsThatOfTev) {
  std::unique_ptr<TevReceiver> viewer;
  try {
    viewer = std::make_unique<TevReceiver>(TevReceiver::Options{.port = client::kTevPort});
  } catch (const std::runtime_error&) {
    GTEST_SKIP() << "a tev runs here";
  }
  const auto sender = connect("localhost");
  ASSERT_TRUE(sender->begin("a.exr", 1, 1).ok());
  EXPECT_TRUE(sender->flush(kPatience));
  EXPECT_TRUE(TevReceiver::wait_for([&] { return viewer->images().contains("a.exr"); }));
}

TEST_F(Tev, RefusesWrongAddresses) {
  for (const char* bad : {"", ":14158", "localhost:", "localhost:0", "localhost:65536",
                          "localhost:1x", "[::1", "[::1]14158", "a:b:1", "[]:1"}) {
    const auto sender = TevSender::create(bad);
    EXPECT_EQ(sender.status().code(), absl::StatusCode::kInvalidArgument) << bad;
    EXPECT_THAT(std::string(sender.status().message()), HasSubstr(", allowed: ")) << bad;
  }
  const std::string no_name(70, 'x');  // parts of names have 63 letters at most
  EXPECT_THAT(std::string(TevSender::create(no_name).status().message()), HasSubstr("xxx: "));
  EXPECT_TRUE(TevSender::create("[::1]:14158").ok());
}

TEST_F(Tev, RefusesRectanglesOutsideOfThePicture) {
  const TevReceiver viewer;
  const auto sender = connect(viewer.address());
  const auto refused = [&](const v1::PixelRect& r, std::size_t numbers) {
    return absl::IsInvalidArgument(sender->update(r, std::vector<float>(numbers)));
  };
  EXPECT_TRUE(refused(rect(0, 0, 1, 1), 3));  // before begin()
  EXPECT_FALSE(sender->begin("a.exr", 0, 4).ok());
  EXPECT_FALSE(sender->begin("a.exr", 1 << 16, 1 << 15).ok());
  ASSERT_TRUE(sender->begin("a.exr", 4, 3).ok());
  EXPECT_TRUE(refused(rect(0, 0, 5, 1), 15));
  EXPECT_TRUE(refused(rect(0, 2, 1, 4), 6));
  EXPECT_TRUE(refused(rect(1, 0, 1, 1), 0));
  EXPECT_TRUE(refused(rect(0, 0, 2, 1), 5));
  EXPECT_FALSE(refused(rect(0, 0, 4, 3), 36));
}

}  // namespace
}  // namespace lucerna
