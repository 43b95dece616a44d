#include "client/result_file.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <vector>

#include "tests/temp_directory.h"

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

TEST_F(ResultFileTest, WhatIsThereStaysWhereItIsOfTheSameShape) {
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

TEST_F(ResultFileTest, OneAtATimeHasIt) {
  auto file = open();
  EXPECT_THAT(open().status().message(), HasSubstr("results: another process is writing it"));
  const ResultFile moved = *std::move(file);
  EXPECT_FALSE(open().ok());
}

TEST_F(ResultFileTest, WhatTheDiskDoesNotLetIsTold) {
  EXPECT_THAT(ResultFile::open((directory_.path() / "no" / "results").string(), "", 1, 1)
                  .status()
                  .message(),
              HasSubstr("No such file or directory"));
  // A mebibyte of rows of a mebibyte times a mebibyte: no disk has it.
  EXPECT_EQ(ResultFile::open(path_, "", std::uint64_t{1} << 40, 1 << 20).status().code(),
            absl::StatusCode::kUnknown);
}

}  // namespace
}  // namespace lucerna::client
