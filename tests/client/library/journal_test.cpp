#include "client/library/journal.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/stat.h>

#include <filesystem>
#include <fstream>
#include <optional>
#include <vector>

#include "tests/temp_directory.h"

namespace lucerna::client {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

class JournalTest : public ::testing::Test {
 protected:
  absl::StatusOr<Journal> open(const std::string& job = "job") {
    records_.clear();
    return Journal::open(path_, job, [this](const std::string& record) {
      records_.push_back(record);
      return absl::OkStatus();
    });
  }

  const TempDirectory directory_;
  std::string path_ = (directory_.path() / "journal").string();
  std::vector<std::string> records_;
};

TEST_F(JournalTest, ReturnsItsRecords) {
  {
    auto journal = open();
    ASSERT_TRUE(journal.ok()) << journal.status();
    EXPECT_THAT(records_, IsEmpty());
    for (const std::string& record :
         {std::string("one"), std::string(), std::string(100'000, '\n')})
      ASSERT_TRUE(journal->add(record).ok());
  }
  {
    auto journal = open();
    ASSERT_TRUE(journal.ok()) << journal.status();
    EXPECT_THAT(records_, ElementsAre("one", "", std::string(100'000, '\n')));
    ASSERT_TRUE(journal->add("more").ok());
  }
  ASSERT_TRUE(open().ok());
  EXPECT_EQ(records_.size(), 4U);
}

TEST_F(JournalTest, APipeIsRefused) {
  ASSERT_EQ(mkfifo(path_.c_str(), 0600), 0);
  EXPECT_THAT(std::string(open().status().message()), HasSubstr("is a pipe or a device"));
  EXPECT_FALSE(Journal::has_records(path_));
}

TEST_F(JournalTest, ATruncatedRecordIsDroppedAtEveryLength) {
  {
    auto journal = open();
    ASSERT_TRUE(journal->add("first").ok());
    ASSERT_TRUE(journal->add("second").ok());
  }
  const auto whole = std::filesystem::file_size(path_);
  for (auto size = whole; size-- > 0;) {
    std::filesystem::resize_file(path_, size);
    {
      auto journal = open();
      ASSERT_TRUE(journal.ok()) << journal.status() << " at " << size;
      EXPECT_LT(records_.size(), 2U);
    }
    // The journal continues from there.
    ASSERT_TRUE(open()->add("third").ok());
    ASSERT_TRUE(open().ok());
    EXPECT_EQ(records_.back(), "third");
    // Shorter than the next record, so that each length occurs.
    std::filesystem::resize_file(path_, std::min(size, std::filesystem::file_size(path_)));
  }
}

TEST_F(JournalTest, AChangedRecordEndsTheJournal) {
  {
    auto journal = open();
    ASSERT_TRUE(journal->add("first").ok());
    ASSERT_TRUE(journal->add("second").ok());
    ASSERT_TRUE(journal->add("third").ok());
  }
  std::fstream file(path_, std::ios::in | std::ios::out | std::ios::binary);
  std::string bytes((std::istreambuf_iterator<char>(file)), {});
  file.seekp(static_cast<std::streamoff>(bytes.find("second")));
  file << "SECOND";
  file.close();
  ASSERT_TRUE(open().ok());
  EXPECT_THAT(records_, ElementsAre("first"));
}

TEST_F(JournalTest, AnotherJobsJournalIsUnchanged) {
  ASSERT_TRUE(open("one")->add("x").ok());
  const auto size = std::filesystem::file_size(path_);
  EXPECT_EQ(open("two").status().code(), absl::StatusCode::kFailedPrecondition);
  EXPECT_EQ(std::filesystem::file_size(path_), size);
  std::ofstream(path_) << "a letter to my aunt\n";
  EXPECT_EQ(open("one").status().code(), absl::StatusCode::kFailedPrecondition);
  path_ = "/no/such/place";
  EXPECT_EQ(open().status().code(), absl::StatusCode::kUnknown);
}

TEST_F(JournalTest, OneJobAtATimeMayOpenIt) {
  std::optional<absl::StatusOr<Journal>> journal = open();
  ASSERT_TRUE((*journal)->add("first").ok());
  for (const char* job : {"job", "another"}) {
    const absl::Status second = open(job).status();
    EXPECT_EQ(second.code(), absl::StatusCode::kUnknown);
    EXPECT_THAT(second.message(), HasSubstr("journal: another job is using this journal"));
    EXPECT_THAT(records_, IsEmpty());
  }
  ASSERT_TRUE((*journal)->add("second").ok());
  journal.reset();
  ASSERT_TRUE(open().ok());
  EXPECT_THAT(records_, ElementsAre("first", "second"));
}

TEST_F(JournalTest, HasRecordsOnlyAfterTheFirst) {
  EXPECT_FALSE(Journal::has_records(path_));
  ASSERT_TRUE(open().ok());
  EXPECT_FALSE(Journal::has_records(path_));
  ASSERT_TRUE(open()->add("").ok());
  EXPECT_TRUE(Journal::has_records(path_));
}

}  // namespace
}  // namespace lucerna::client
