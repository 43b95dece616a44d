#include "client/library/result_file.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <vector>

#include "tests/temp_directory.h"

namespace {
int fallocate_error = 0;
}  // namespace

// Replaces the C library's function, so that disks fail on demand.
extern "C" int fallocate(int file, int mode, off_t offset, off_t size) {
  if (fallocate_error != 0) {
    errno = fallocate_error;
    return -1;
  }
  return static_cast<int>(::syscall(SYS_fallocate, file, mode, offset, size));
}

namespace lucerna::client {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;

class ResultFileTest : public ::testing::Test {
 protected:
  absl::StatusOr<ResultFile> open(std::uint64_t rows = 4, const std::string& header = "head") {
    return ResultFile::open(path_, header, rows, 2);
  }

  const TempDirectory directory_;
  const std::string path_ = (directory_.path() / "results").string();
};

TEST_F(ResultFileTest, RowsAreWrittenInAnyOrder) {
  auto file = open();
  ASSERT_TRUE(file.ok()) << file.status();
  EXPECT_EQ(std::filesystem::file_size(path_), 4U + 4 * 2 * 4);
  ASSERT_TRUE(file->write(3, std::vector<float>{6, 7}).ok());
  ASSERT_TRUE(file->write(0, std::vector<float>{0, 1, 2, 3}).ok());
  std::vector<float> rows(8);
  ASSERT_TRUE(file->read(0, rows).ok());
  EXPECT_THAT(rows, ElementsAre(0, 1, 2, 3, 0, 0, 6, 7));
  rows.resize(2);
  ASSERT_TRUE(file->read(1, rows).ok());
  EXPECT_THAT(rows, ElementsAre(2, 3));
}

TEST_F(ResultFileTest, ResultsOfTheSameShapeStay) {
  const auto first_row = [&](std::uint64_t rows, const std::string& header) {
    auto file = open(rows, header);
    EXPECT_TRUE(file.ok()) << file.status();
    std::vector<float> row(2);
    EXPECT_TRUE(file->read(0, row).ok());
    EXPECT_TRUE(file->write(0, std::vector<float>{1, 2}).ok());
    return row;
  };
  EXPECT_THAT(first_row(4, "head"), ElementsAre(0, 0));
  EXPECT_THAT(first_row(4, "head"), ElementsAre(1, 2));
  EXPECT_THAT(first_row(5, "head"), ElementsAre(0, 0));
  EXPECT_THAT(first_row(5, "tail"), ElementsAre(0, 0));
}

TEST_F(ResultFileTest, OneProcessAtATimeMayOpenIt) {
  auto file = open();
  EXPECT_THAT(open().status().message(), HasSubstr("results: another process is writing it"));
  const ResultFile moved = *std::move(file);
  EXPECT_FALSE(open().ok());
}

TEST_F(ResultFileTest, DiskErrorsAreReported) {
  EXPECT_THAT(ResultFile::open((directory_.path() / "no" / "results").string(), "", 1, 1)
                  .status()
                  .message(),
              HasSubstr("No such file or directory"));
  // 2^20 rows of 2^20 columns: more than any disk has.
  EXPECT_EQ(ResultFile::open(path_, "", std::uint64_t{1} << 40, 1 << 20).status().code(),
            absl::StatusCode::kUnknown);
}

TEST_F(ResultFileTest, MissingDiskSpaceIsReportedEachTime) {
  for (const int error : {ENOSPC, EDQUOT, EFBIG, EIO}) {
    SCOPED_TRACE(std::strerror(error));
    fallocate_error = error;
    // The second time too: the failed file must not look complete.
    for (int i = 0; i < 2; ++i) {
      const absl::Status status = open().status();
      EXPECT_EQ(status.code(), absl::StatusCode::kUnknown);
      EXPECT_THAT(status.message(), HasSubstr("results: 36 bytes: "));
      EXPECT_THAT(status.message(), HasSubstr(std::strerror(error)));
      EXPECT_EQ(std::filesystem::file_size(path_), 0U);
    }
    fallocate_error = 0;
  }
  EXPECT_TRUE(open().ok());
}

TEST_F(ResultFileTest, WithoutAllocationTheFileIsStillCreated) {
  for (const int error : {EOPNOTSUPP, ENOSYS, EINVAL}) {
    std::filesystem::remove(path_);
    fallocate_error = error;
    EXPECT_TRUE(open().ok()) << std::strerror(error);
    fallocate_error = 0;
    EXPECT_EQ(std::filesystem::file_size(path_), 36U);
  }
}

TEST_F(ResultFileTest, AnotherFileIsKeptOnRequest) {
  const auto keep = [&](const std::string& header) {
    return ResultFile::open(path_, header, 4, 2, ResultFile::Other::kKeep).status();
  };
  EXPECT_TRUE(keep("head").ok());  // there was no file
  EXPECT_TRUE(keep("head").ok());
  EXPECT_EQ(keep("tail").code(), absl::StatusCode::kFailedPrecondition);
  EXPECT_EQ(keep("longer").code(), absl::StatusCode::kFailedPrecondition);
  EXPECT_TRUE(keep("head").ok());
  std::ofstream(path_, std::ios::trunc).close();
  EXPECT_TRUE(keep("tail").ok());
}

}  // namespace
}  // namespace lucerna::client
