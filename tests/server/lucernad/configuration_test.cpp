#include "server/lucernad/configuration.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdlib>
#include <fstream>

#include "server/lucernad/command_line.h"

namespace lucerna::config {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

/// A configuration file that lives as long as the test.
class ConfigurationFile : public ::testing::Test {
 protected:
  std::string write(const std::string& text) {
    const std::string path = ::testing::TempDir() + "lucernad_" +
                             ::testing::UnitTest::GetInstance()->current_test_info()->name() +
                             ".toml";
    std::ofstream(path) << text;
    return path;
  }
};

Held held(const Configuration& configuration, const std::string& name) {
  for (const Held& h : configuration.held) {
    if (h.name == name) return h;
  }
  ADD_FAILURE() << "no setting " << name;
  return {};
}

TEST_F(ConfigurationFile, IsWeakerThanTheEnvironmentAndTheEnvironmentWeakerThanFlags) {
  const std::string file = write("threads = 1\nbulk-queue = 11\nmemory-budget = \"3GiB\"\n");
  const Configuration all =
      configure({.flags = {{"threads", {"3"}}},
                 .environment = {{"LUCERNAD_THREADS", "2"}, {"LUCERNAD_BULK_QUEUE", "12"}},
                 .file = file});
  ASSERT_THAT(all.errors, IsEmpty());
  EXPECT_EQ(all.options.server.lanes.threads, 3);
  EXPECT_EQ(all.options.server.lanes.bulk_queue, 12U);
  EXPECT_EQ(all.options.server.scenes.memory_budget_bytes, std::uint64_t{3} << 30);
  EXPECT_EQ(held(all, "threads").source, "--threads");
  EXPECT_EQ(held(all, "bulk-queue").source, "LUCERNAD_BULK_QUEUE");
  EXPECT_EQ(held(all, "memory-budget").source, file + ":3:1");
  EXPECT_EQ(held(all, "memory-budget").value, "3GiB");
  EXPECT_EQ(held(all, "max-lease").source, "default");
}

TEST_F(ConfigurationFile, MayBeNamedByTheEnvironment) {
  const std::string file = write("threads = 7\n");
  EXPECT_EQ(configure({.flags = {}, .environment = {{"LUCERNAD_CONFIG", file}}, .file = ""})
                .options.server.lanes.threads,
            7);
}

TEST_F(ConfigurationFile, SetsTextsListsAndNumbers) {
  const std::string file = write(
      "listen = \"[::1]:7\"\nload = [\"a.pbrt\", \"b.pbrt\"]\nmax-lease = 2.5\n"
      "asset-budget = 1024\n");
  const Configuration all = configure({.flags = {}, .environment = {}, .file = file});
  ASSERT_THAT(all.errors, IsEmpty());
  EXPECT_EQ(all.options.server.listen, "[::1]:7");
  EXPECT_THAT(all.options.server.load, ElementsAre("a.pbrt", "b.pbrt"));
  EXPECT_EQ(all.options.server.scenes.max_lease_s, 2.5);
  EXPECT_EQ(all.options.server.assets.budget_bytes, 1024U);
}

TEST_F(ConfigurationFile, ReportsEveryErrorWithItsPlace) {
  const std::string file = write(
      "threads = 5000\n  no-such = 1\nlisten = 5\nload = [1]\nmemory-budget = -1\n"
      "max-lease = nan\nisa = true\nbulk-queue = 2.5\n[table]\nthreads = 2\n");
  const Configuration all = configure({.flags = {}, .environment = {}, .file = file});
  EXPECT_THAT(all.errors,
              ::testing::UnorderedElementsAre(
                  file + ":1:1: threads = 5000, allowed: 0 to 1024",
                  HasSubstr(file + ":2:3: no-such: no such setting"),
                  file + ":3:1: listen = 5, allowed: a text in quotes",
                  HasSubstr(file + ":4:1: load = [ 1 ], allowed: a list of texts"),
                  file + ":5:1: memory-budget = -1, allowed: at least 0 bytes, such as 8GiB",
                  file + ":6:1: max-lease = nan, allowed: 1 to 1000000000",
                  file + ":7:1: isa = true, allowed: a text in quotes",
                  file + ":8:1: bulk-queue = 2.5, allowed: 1 to 1048576",
                  HasSubstr(file + ":9:2: table: no such setting")));
}

TEST_F(ConfigurationFile, ReportsTheFirstErrorOfSyntax) {
  const std::string file = write("threads = 1\nbulk-queue = = 2\n");
  const Configuration all = configure({.flags = {}, .environment = {}, .file = file});
  EXPECT_THAT(all.errors, ElementsAre(HasSubstr(file + ":2:")));
}

TEST(Configuration, NamesAFileThatCannotBeRead) {
  const Configuration all =
      configure({.flags = {}, .environment = {}, .file = "/no/such/lucernad.toml"});
  EXPECT_THAT(all.errors, ElementsAre("/no/such/lucernad.toml: cannot be read: No such file or "
                                      "directory"));
}

TEST(Configuration, WarnsOfVariablesThatAreNoSettings) {
  const Configuration all =
      configure({.flags = {}, .environment = {{"LUCERNAD_TREADS", "4"}}, .file = ""});
  EXPECT_THAT(all.errors, IsEmpty());
  EXPECT_THAT(all.warnings, ElementsAre("LUCERNAD_TREADS: no such setting"));
}

TEST(Configuration, SeparatesAListInTheEnvironmentByCommas) {
  const Configuration all =
      configure({.flags = {}, .environment = {{"LUCERNAD_LOAD", "a.pbrt,b.pbrt"}}, .file = ""});
  EXPECT_THAT(all.options.server.load, ElementsAre("a.pbrt", "b.pbrt"));
}

/// Every setting with a number refuses these, and states what is allowed.
TEST(Configuration, RefusesNumbersOutOfRange) {
  Options options;
  int numbers = 0;
  for (const Setting& setting : settings(options)) {
    if (std::holds_alternative<Text>(setting.value) ||
        std::holds_alternative<Texts>(setting.value)) {
      continue;
    }
    // Words and switches refuse them too.
    ++numbers;
    for (const char* text : {"-1", "nan", "inf", "1e30", "", "1x", "18446744073709551616"}) {
      const std::string before = text_of(setting);
      const Configuration all =
          configure({.flags = {{setting.name, {text}}}, .environment = {}, .file = ""});
      EXPECT_THAT(all.errors, ElementsAre("--" + setting.name + " = " + text +
                                          ", allowed: " + allowed(setting)));
      EXPECT_EQ(held(all, setting.name).value, before);
    }
  }
  EXPECT_GE(numbers, 13);
}

TEST(Setting, TakesUnitsOfBytes) {
  std::uint64_t bytes = 0;
  const Setting setting{.name = "size", .type = "", .help = "", .value = Bytes{&bytes, 0, 1 << 30}};
  const std::pair<const char*, std::uint64_t> good[] = {
      {"7", 7}, {"7B", 7}, {"1K", 1024}, {"1kb", 1024}, {"2 MiB", 2 << 20}, {"1g", 1 << 30}};
  for (const auto& [text, expected] : good) {
    EXPECT_TRUE(set(setting, {text}).ok()) << text;
    EXPECT_EQ(bytes, expected) << text;
  }
  for (const char* text : {"2G", "1.5K", "K", "1KiBs", "1 Q", "16777216T"}) {
    EXPECT_FALSE(set(setting, {text}).ok()) << text;
  }
}

TEST(Setting, PrintsWhatItAccepts) {
  Options options, other;
  const std::vector<Setting> from = settings(options), to = settings(other);
  for (std::size_t i = 0; i < from.size(); ++i) {
    if (std::holds_alternative<Texts>(from[i].value)) continue;
    EXPECT_TRUE(set(to[i], {text_of(from[i])}).ok()) << from[i].name;
  }
}

TEST(CommandLine, GivesTheTextsOfItsFlags) {
  const char* const words[] = {"lucernad", "--threads", "-1", "--load", "a", "--load", "b"};
  const CommandLine line = parse_command_line(std::size(words), words, "0");
  EXPECT_EQ(line.exit_status, std::nullopt);
  EXPECT_THAT(line.given.flags.at("threads"), ElementsAre("-1"));
  EXPECT_THAT(line.given.flags.at("load"), ElementsAre("a", "b"));
  EXPECT_FALSE(line.given.flags.contains("listen"));
}

TEST(CommandLine, RefusesUnknownAndRepeatedFlags) {
  const char* const unknown[] = {"lucernad", "--no-such"};
  EXPECT_EQ(parse_command_line(std::size(unknown), unknown, "0").exit_status, 2);
  const char* const twice[] = {"lucernad", "--threads", "1", "--threads", "2"};
  EXPECT_EQ(parse_command_line(std::size(twice), twice, "0").exit_status, 2);
}

}  // namespace
}  // namespace lucerna::config
