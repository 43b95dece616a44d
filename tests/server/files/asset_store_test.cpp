#include "server/files/asset_store.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <filesystem>
#include <fstream>
#include <optional>
#include <thread>
#include <utility>

#include "tests/server/pbrt/pbrt_fixture.h"

namespace lucerna {
namespace {

using ::testing::IsEmpty;
using testing::message;
using ::testing::Not;
using testing::SceneFiles;

constexpr auto kForever = std::chrono::hours(1);

class AssetStoreTest : public ::testing::Test {
 protected:
  void SetUp() override { open({}); }

  /// Opens a store with `options` in this test's directory.
  void open(AssetStoreOptions options) {
    store_.reset();
    options.directory = (files_.path() / "assets").string();
    auto store = AssetStore::open(options);
    ASSERT_TRUE(store.ok()) << store.status();
    store_ = *std::move(store);
  }

  /// Sends all of `bytes`.
  absl::Status put(const std::string& bytes, const AssetOwner& sender = {}) const {
    auto upload = store_->upload(sha256(bytes), bytes.size(), 0, sender);
    if (!upload.ok()) return upload.status();
    if (absl::Status s = upload->append(bytes); !s.ok()) return s;
    return upload->finish();
  }

  /// The content stored under the digest of `bytes`.
  std::string get(const std::string& bytes) const {
    auto file = store_->read(sha256(bytes));
    if (!file.ok()) return message(file.status());
    std::string found(file->size + 1, '\0');
    found.resize(static_cast<std::size_t>(read_fully(file->fd.get(), found.data(), found.size())));
    return found;
  }

  std::vector<std::string> names() const {
    std::vector<std::string> all;
    for (const auto& file : std::filesystem::directory_iterator(files_.path() / "assets"))
      if (file.path().filename() != "lock") all.push_back(file.path().filename());
    return all;
  }

  SceneFiles files_;
  std::unique_ptr<AssetStore> store_;
};

TEST_F(AssetStoreTest, StoresFilesUnderTheirDigest) {
  const std::string bytes("one\0two\n", 8);
  EXPECT_FALSE(store_->held(sha256(bytes)).whole);
  ASSERT_TRUE(put(bytes).ok());
  EXPECT_TRUE(store_->held(sha256(bytes)).whole);
  EXPECT_EQ(get(bytes), bytes);
  EXPECT_EQ(store_->bytes(), 8U);
  EXPECT_EQ(store_->read(sha256("other")).status().code(), absl::StatusCode::kNotFound);
  // The same file is not accepted again.
  EXPECT_EQ(put(bytes).code(), absl::StatusCode::kFailedPrecondition);
  EXPECT_EQ(store_->bytes(), 8U);
}

TEST_F(AssetStoreTest, KeepsEmptyFilesToo) {
  ASSERT_TRUE(put("").ok());
  EXPECT_TRUE(store_->held(sha256("")).whole);
  EXPECT_EQ(get(""), "");
}

TEST_F(AssetStoreTest, ContinuesABrokenUpload) {
  const std::string digest = sha256("abcdef");
  {
    auto upload = store_->upload(digest, 6, 0);
    ASSERT_TRUE(upload.ok());
    ASSERT_TRUE(upload->append("abc").ok());
    ASSERT_TRUE(upload->append("X").ok());
  }
  EXPECT_FALSE(store_->held(digest).whole);
  EXPECT_EQ(store_->held(digest).bytes, 4U);
  EXPECT_EQ(store_->bytes(), 4U);
  // From before the end: the bytes after this place are discarded.
  auto upload = store_->upload(digest, 6, 3);
  ASSERT_TRUE(upload.ok()) << upload.status();
  EXPECT_EQ(upload->bytes(), 3U);
  ASSERT_TRUE(upload->append("def").ok());
  ASSERT_TRUE(upload->complete());
  ASSERT_TRUE(upload->finish().ok());
  EXPECT_EQ(get("abcdef"), "abcdef");
}

/// Bytes that this process, or only this thread, has read by any call.
std::uint64_t bytes_read(const char* of = "self") {
  std::ifstream file(std::string("/proc/") + of + "/io");
  std::string name;
  std::uint64_t bytes = 0;
  file >> name >> bytes;
  EXPECT_EQ(name, "rchar:");
  return bytes;
}

TEST_F(AssetStoreTest, AnUploadThatContinuesDoesNotReadTheWholePartAgain) {
  constexpr std::size_t kBytes = std::size_t{33} << 20, kPiece = 100;
  std::string bytes(kBytes, 'a');
  for (std::size_t i = 0; i < kBytes; i += 4096) bytes[i] = static_cast<char>(i >> 12U);
  const std::string digest = sha256(bytes);
  std::uint64_t at = kBytes - 32 * kPiece;
  {
    auto upload = store_->upload(digest, kBytes, 0);
    ASSERT_TRUE(upload->append(std::string_view(bytes).substr(0, at)).ok());
  }
  const std::uint64_t before = bytes_read();
  for (; at < kBytes; at += kPiece) {
    // From the end, or from before it.
    auto upload = store_->upload(digest, kBytes, at);
    ASSERT_TRUE(upload.ok()) << upload.status();
    ASSERT_TRUE(upload->append(std::string_view(bytes).substr(at, kPiece)).ok());
    if (upload->complete()) {
      EXPECT_TRUE(upload->finish().ok());
    }
  }
  EXPECT_LT(bytes_read() - before, 32 * (std::size_t{5} << 20));
  EXPECT_TRUE(store_->held(digest).whole);
}

TEST_F(AssetStoreTest, TheNextServerReadsAPartInAThreadOfItsOwn) {
  const std::string bytes(std::size_t{41} << 20, 'b');
  const std::string digest = sha256(bytes);
  {
    auto upload = store_->upload(digest, bytes.size(), 0);
    ASSERT_TRUE(upload->append(std::string_view(bytes).substr(1)).ok());
  }
  open({});
  const std::uint64_t before = bytes_read("thread-self");
  std::optional<absl::StatusOr<AssetUpload>> upload;
  while (!upload || absl::IsFailedPrecondition(upload->status())) {
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
    upload.emplace(store_->upload(digest, bytes.size(), bytes.size() - 1));
  }
  EXPECT_LT(bytes_read("thread-self") - before, std::uint64_t{5} << 20);
  ASSERT_TRUE(upload->ok()) << upload->status();
  ASSERT_TRUE((**upload).append("b").ok());
  EXPECT_TRUE((**upload).finish().ok());
}

TEST_F(AssetStoreTest, AnUploadFromTheStartDoesNotWaitForThePart) {
  const std::string bytes(std::size_t{20} << 20, 'b');
  {
    auto upload = store_->upload(sha256(bytes), bytes.size(), 0);
    ASSERT_TRUE(upload->append(std::string_view(bytes).substr(1)).ok());
  }
  open({});
  EXPECT_TRUE(put(bytes).ok());
  EXPECT_EQ(get(bytes), bytes);
}

TEST_F(AssetStoreTest, AnUploadFromTheBeginningDiscardsTheBytesOfTheLast) {
  const std::string digest = sha256("abcdef");
  {
    auto upload = store_->upload(digest, 8, 0);
    ASSERT_TRUE(upload.ok());
    ASSERT_TRUE(upload->append("XXXXXXXX").ok());
  }
  auto upload = store_->upload(digest, 6, 0);
  ASSERT_TRUE(upload.ok()) << upload.status();
  ASSERT_TRUE(upload->append("abcdef").ok());
  ASSERT_TRUE(upload->finish().ok());
  EXPECT_EQ(get("abcdef"), "abcdef");
}

TEST_F(AssetStoreTest, DoesNotContinueBeyondItsBytes) {
  EXPECT_EQ(store_->upload(sha256("abcdef"), 6, 1).status().code(),
            absl::StatusCode::kInvalidArgument);
  EXPECT_THAT(names(), IsEmpty());
  EXPECT_TRUE(put("abcdef").ok());
}

TEST_F(AssetStoreTest, BytesWithAnotherDigestAreDiscarded) {
  const std::string digest = sha256("right");
  auto upload = store_->upload(digest, 5, 0);
  ASSERT_TRUE(upload.ok());
  ASSERT_TRUE(upload->append("wrong").ok());
  const absl::Status status = upload->finish();
  EXPECT_EQ(status.code(), absl::StatusCode::kInvalidArgument);
  EXPECT_EQ(message(status), hexadecimal(sha256("wrong")));
  EXPECT_EQ(store_->held(digest).bytes, 0U);
  EXPECT_THAT(names(), IsEmpty());
  EXPECT_TRUE(put("right").ok());
}

TEST_F(AssetStoreTest, OneWriterAtATime) {
  const std::string digest = sha256("abcdef");
  auto first = store_->upload(digest, 6, 0);
  ASSERT_TRUE(first.ok());
  ASSERT_TRUE(first->append("abc").ok());
  EXPECT_EQ(store_->upload(digest, 6, 0).status().code(), absl::StatusCode::kFailedPrecondition);
  ASSERT_TRUE(first->append("def").ok());
  EXPECT_TRUE(first->finish().ok());
}

TEST_F(AssetStoreTest, AnIdleWriterIsReplaced) {
  open({.patience = std::chrono::milliseconds(0)});
  const std::string digest = sha256("abcdef");
  auto first = store_->upload(digest, 6, 0);
  ASSERT_TRUE(first.ok());
  ASSERT_TRUE(first->append("abc").ok());
  auto second = store_->upload(digest, 6, 3);
  ASSERT_TRUE(second.ok()) << second.status();
  EXPECT_EQ(first->append("XYZ").code(), absl::StatusCode::kFailedPrecondition);
  { const AssetUpload gone = *std::move(first); }
  ASSERT_TRUE(second->append("def").ok());
  ASSERT_TRUE(second->finish().ok());
  EXPECT_EQ(get("abcdef"), "abcdef");
}

TEST_F(AssetStoreTest, LeastRecentlyUsedFilesAreDeletedFirst) {
  open({.budget_bytes = 10});
  ASSERT_TRUE(put("aaaa").ok());
  ASSERT_TRUE(put("bbbb").ok());
  EXPECT_TRUE(store_->held(sha256("aaaa")).whole);  // a query counts as use: newer than b now
  ASSERT_TRUE(put("cccc").ok());
  EXPECT_EQ(get("aaaa"), "aaaa");
  EXPECT_NE(get("bbbb"), "bbbb");
  EXPECT_EQ(store_->bytes(), 8U);
  // Interrupted uploads are deleted too.
  (void)store_->upload(sha256("ddd"), 3, 0)->append("d");
  EXPECT_TRUE(put("0123456789").ok());
  EXPECT_EQ(names().size(), 1U);
}

TEST_F(AssetStoreTest, FilesInUseAreNotDeleted) {
  open({.budget_bytes = 10});
  ASSERT_TRUE(put("aaaa").ok());
  auto writer = store_->upload(sha256("bbbb"), 4, 0);
  ASSERT_TRUE(writer.ok());
  {
    const AssetStore::Pins pins(*store_, {sha256("aaaa"), sha256("no such")});
    EXPECT_EQ(put("cccc").code(), absl::StatusCode::kResourceExhausted);
    EXPECT_EQ(get("aaaa"), "aaaa");
  }
  EXPECT_TRUE(put("cccc").ok());
  ASSERT_TRUE(writer->append("bbbb").ok());
  EXPECT_NE(get("aaaa"), "aaaa");
  EXPECT_TRUE(writer->finish().ok());
}

// A header without bytes must cost nobody a file.
TEST_F(AssetStoreTest, OnlyBytesThatArriveDeleteFilesOfOthers) {
  open({.budget_bytes = 10});
  ASSERT_TRUE(put("aaaa").ok());
  ASSERT_TRUE(put("bbbb").ok());
  {
    auto writer = store_->upload(sha256("cccccccc"), 8, 0);
    ASSERT_TRUE(writer.ok());
    EXPECT_EQ(store_->upload(sha256("ddd"), 3, 0).status().code(),
              absl::StatusCode::kResourceExhausted);
    ASSERT_TRUE(writer->append("cc").ok());
    EXPECT_EQ(names().size(), 3U);
    ASSERT_TRUE(writer->append("c").ok());
    EXPECT_NE(get("aaaa"), "aaaa");
    EXPECT_EQ(get("bbbb"), "bbbb");
  }
  EXPECT_EQ(store_->bytes(), 7U);
}

TEST_F(AssetStoreTest, AnUploadWhoseRoomIsTakenMeanwhileIsRefused) {
  open({.budget_bytes = 10});
  ASSERT_TRUE(put("aaaa").ok());
  auto writer = store_->upload(sha256("cccccccc"), 8, 0);
  ASSERT_TRUE(writer.ok());
  const AssetStore::Pins pins(*store_, {sha256("aaaa")});
  EXPECT_TRUE(writer->append("cccccc").ok());
  EXPECT_EQ(writer->append("cc").code(), absl::StatusCode::kResourceExhausted);
  EXPECT_EQ(get("aaaa"), "aaaa");
}

TEST_F(AssetStoreTest, RefusesTooLargeFilesAtOnce) {
  open({.max_asset_bytes = 3});
  EXPECT_EQ(put("aaaa").code(), absl::StatusCode::kResourceExhausted);
  EXPECT_TRUE(put("aaa").ok());
  open({.budget_bytes = 4});
  EXPECT_EQ(put("aaaaa").code(), absl::StatusCode::kResourceExhausted);
  EXPECT_EQ(get("aaa"), "aaa");  // a file that cannot fit deletes nothing
}

TEST_F(AssetStoreTest, AFileBeingReadMayBeDeleted) {
  ASSERT_TRUE(put("abc").ok());
  const auto file = store_->read(sha256("abc"));
  ASSERT_TRUE(file.ok());
  store_->drop(sha256("abc"));
  EXPECT_FALSE(store_->held(sha256("abc")).whole);
  std::string bytes(3, '\0');
  EXPECT_EQ(read_fully(file->fd.get(), bytes.data(), 3), 3);
  EXPECT_EQ(bytes, "abc");
}

TEST_F(AssetStoreTest, TheNextServerFindsTheFiles) {
  ASSERT_TRUE(put("abc").ok());
  (void)store_->upload(sha256("defg"), 4, 0)->append("de");
  files_.write("assets/README", "of somebody else");
  open({.patience = kForever});
  EXPECT_EQ(get("abc"), "abc");
  EXPECT_EQ(store_->held(sha256("defg")).bytes, 2U);
  auto upload = store_->upload(sha256("defg"), 4, 2);
  ASSERT_TRUE(upload.ok());
  ASSERT_TRUE(upload->append("fg").ok());
  EXPECT_TRUE(upload->finish().ok());
  EXPECT_EQ(store_->bytes(), 7U);
  EXPECT_TRUE(std::filesystem::exists(files_.path() / "assets/README"));
}

TEST_F(AssetStoreTest, TwoServersDoNotShareADirectory) {
  const auto other = AssetStore::open({.directory = (files_.path() / "assets").string()});
  EXPECT_EQ(other.status().code(), absl::StatusCode::kFailedPrecondition) << other.status();
  EXPECT_EQ(AssetStore::open({.directory = "/proc/nowhere"}).status().code(),
            absl::StatusCode::kInvalidArgument);
}

TEST_F(AssetStoreTest, RemovedFilesAreNotHeld) {
  ASSERT_TRUE(put("abc").ok());
  std::filesystem::remove(files_.path() / "assets" / hexadecimal(sha256("abc")));
  EXPECT_EQ(store_->read(sha256("abc")).status().code(), absl::StatusCode::kNotFound);
  EXPECT_TRUE(put("abc").ok());
  EXPECT_EQ(get("abc"), "abc");
}

TEST(AssetStore, TemporaryDirectoriesOfKilledServersAreDeleted) {
  const SceneFiles files;
  const char* const before = std::getenv("TMPDIR");
  const std::string old = before != nullptr ? before : "";
  setenv("TMPDIR", files.path().c_str(), 1);
  std::filesystem::create_directory(files.path() / "lucernad-assets-killed");
  files.write("lucernad-assets-killed/lock", "");
  files.write("lucernad-assets-killed/part", "bytes");
  const auto count = [&] {
    const std::filesystem::directory_iterator all(files.path());
    return std::distance(begin(all), end(all));
  };
  {
    const auto first = AssetStore::open({});
    ASSERT_TRUE(first.ok()) << first.status();
    EXPECT_EQ(count(), 1);
    const auto second = AssetStore::open({});  // does not delete what a server uses
    ASSERT_TRUE(second.ok()) << second.status();
    EXPECT_EQ(count(), 2);
  }
  EXPECT_EQ(count(), 0);
  if (old.empty())
    unsetenv("TMPDIR");
  else
    setenv("TMPDIR", old.c_str(), 1);
}

TEST(AssetStore, ATemporaryDirectoryIsDeletedWithTheStore) {
  const SceneFiles files;
  ASSERT_EQ(setenv("TMPDIR", files.path().c_str(), 1), 0);
  auto store = AssetStore::open({});
  ASSERT_EQ(unsetenv("TMPDIR"), 0);
  ASSERT_TRUE(store.ok()) << store.status();
  EXPECT_FALSE(std::filesystem::is_empty(files.path()));
  store->reset();
  EXPECT_TRUE(std::filesystem::is_empty(files.path()));
}

/// A disk that holds `room` bytes beside the files of the store, which it counts.
class FullDisk {
 public:
  FullDisk(std::filesystem::path directory, std::uint64_t room)
      : directory_(std::move(directory)), room_(room) {}

  ssize_t operator()(int fd, const void* bytes, std::size_t size) const {
    std::uint64_t used = 0;
    for (const auto& file : std::filesystem::directory_iterator(directory_))
      used += file.file_size();
    if (used >= room_) {
      errno = ENOSPC;
      return -1;
    }
    // As write(2) does, it writes what fits.
    return ::write(fd, bytes, std::min<std::size_t>(size, room_ - used));
  }

 private:
  std::filesystem::path directory_;
  std::uint64_t room_;
};

TEST_F(AssetStoreTest, AFullDiskDeletesUnusedFilesAndTriesAgain) {
  open({.write = FullDisk(files_.path() / "assets", 10)});
  ASSERT_TRUE(put("aaaa").ok());
  ASSERT_TRUE(put("bbbb").ok());
  // A broken upload goes first.
  (void)store_->upload(sha256("dd"), 2, 0)->append("d");
  ASSERT_TRUE(put("ccc").ok());
  EXPECT_EQ(get("ccc"), "ccc");
  EXPECT_EQ(store_->held(sha256("dd")).bytes, 0U);
  EXPECT_NE(get("aaaa"), "aaaa");
  EXPECT_EQ(get("bbbb"), "bbbb");
}

TEST_F(AssetStoreTest, AnUploadThatNeverFitsLeavesRoomForOthers) {
  open({.write = FullDisk(files_.path() / "assets", 10)});
  ASSERT_TRUE(put("aaaa").ok());
  {
    const AssetStore::Pins pins(*store_, {sha256("aaaa")});
    EXPECT_EQ(put("0123456789").code(), absl::StatusCode::kResourceExhausted);
    EXPECT_EQ(names().size(), 1U);
    EXPECT_TRUE(put("bbbb").ok());
    EXPECT_EQ(get("aaaa"), "aaaa");
  }
  EXPECT_EQ(get("bbbb"), "bbbb");
}

TEST_F(AssetStoreTest, OldPartsOfUploadsAreDeleted) {
  (void)store_->upload(sha256("abc"), 3, 0)->append("a");
  ASSERT_TRUE(put("whole").ok());
  open({.keep_parts = std::chrono::hours(1)});
  EXPECT_EQ(store_->held(sha256("abc")).bytes, 1U);
  // At the start, by the time of the file.
  for (const auto& file : std::filesystem::directory_iterator(files_.path() / "assets"))
    last_write_time(file.path(),
                    std::filesystem::file_time_type::clock::now() - std::chrono::hours(2));
  open({.keep_parts = std::chrono::hours(1)});
  EXPECT_EQ(store_->held(sha256("abc")).bytes, 0U);
  EXPECT_EQ(get("whole"), "whole");
  // And while the server runs.
  open({.keep_parts = std::chrono::seconds(0)});
  (void)store_->upload(sha256("abc"), 3, 0)->append("a");
  ASSERT_TRUE(put("other").ok());
  EXPECT_EQ(store_->held(sha256("abc")).bytes, 0U);
}

// The first file is refused by one byte, then fits exactly.
TEST_F(AssetStoreTest, TheFilesOfASenderHaveAQuota) {
  ASSERT_TRUE(put(std::string(60, 'a'), {"farm", 100}).ok());
  const absl::Status over = store_->upload(sha256("b"), 41, 0, {"farm", 100}).status();
  EXPECT_TRUE(absl::IsResourceExhausted(over)) << over;
  EXPECT_TRUE(over.GetPayload(kOverQuotaPayload).has_value());
  EXPECT_EQ(message(over),
            "a file of 41 bytes: files of \"farm\" take 60 bytes, 60 of them lately used, allowed: "
            "100");
  EXPECT_EQ(store_->bytes(), 60U);
  EXPECT_TRUE(put(std::string(40, 'b'), {"farm", 100}).ok());
  // Others have quotas of their own, or none.
  EXPECT_TRUE(put(std::string(41, 'c'), {"other", 100}).ok());
  EXPECT_TRUE(put(std::string(1000, 'd')).ok());
}

// Two uploads at once count in full from their beginning.
TEST_F(AssetStoreTest, RunningUploadsCountAgainstTheQuota) {
  const auto first = store_->upload(sha256("a"), 60, 0, {"farm", 100});
  ASSERT_TRUE(first.ok());
  EXPECT_TRUE(
      absl::IsResourceExhausted(store_->upload(sha256("b"), 41, 0, {"farm", 100}).status()));
  EXPECT_TRUE(store_->upload(sha256("b"), 40, 0, {"farm", 100}).ok());
}

TEST_F(AssetStoreTest, OldFilesOfTheSenderMakeRoomInItsQuota) {
  open({.keep_owned = std::chrono::seconds(0)});
  ASSERT_TRUE(put(std::string(40, 'a'), {"farm", 100}).ok());
  ASSERT_TRUE(put(std::string(40, 'b'), {"farm", 100}).ok());
  ASSERT_TRUE(put(std::string(40, 'o'), {"other", 100}).ok());
  EXPECT_EQ(get(std::string(40, 'a')), std::string(40, 'a'));  // used later than b
  ASSERT_TRUE(put(std::string(40, 'c'), {"farm", 100}).ok());
  EXPECT_EQ(get(std::string(40, 'a')), std::string(40, 'a'));
  EXPECT_NE(get(std::string(40, 'b')), std::string(40, 'b'));
  EXPECT_EQ(get(std::string(40, 'o')), std::string(40, 'o'));
  // A file that never fits deletes nothing.
  EXPECT_FALSE(put(std::string(101, 'd'), {"farm", 100}).ok());
  EXPECT_EQ(get(std::string(40, 'a')), std::string(40, 'a'));
  // Files in use stay.
  const AssetStore::Pins pins(*store_, {sha256(std::string(40, 'a'))});
  EXPECT_FALSE(put(std::string(61, 'e'), {"farm", 100}).ok());
  EXPECT_TRUE(put(std::string(60, 'e'), {"farm", 100}).ok());
  EXPECT_EQ(get(std::string(40, 'a')), std::string(40, 'a'));
}

TEST_F(AssetStoreTest, TheNextServerKnowsTheOwners) {
  ASSERT_TRUE(put(std::string(60, 'a'), {"farm", 100}).ok());
  open({});
  EXPECT_FALSE(put(std::string(41, 'b'), {"farm", 100}).ok());
  EXPECT_TRUE(put(std::string(41, 'b'), {"other", 100}).ok());
  // No name of an owner stays without its file.
  store_->drop(sha256(std::string(60, 'a')));
  store_->drop(sha256(std::string(41, 'b')));
  EXPECT_THAT(names(), IsEmpty());
}

TEST_F(AssetStoreTest, APartBesideItsWholeFileIsDeleted) {
  ASSERT_TRUE(put("whole").ok());
  const auto whole = files_.path() / "assets" / hexadecimal(sha256("whole"));
  std::ofstream(whole.string() + ".part") << "who";
  open({});
  EXPECT_EQ(names().size(), 1U);
  EXPECT_EQ(get("whole"), "whole");
}

}  // namespace
}  // namespace lucerna
