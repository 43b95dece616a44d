#include "client/terminal/completion.h"

#include <gmock/gmock.h>

#include <CLI/CLI.hpp>

namespace lucerna::shell {
namespace {

using testing::ElementsAre;
using testing::IsEmpty;

/// A program with two commands.
class Completion : public testing::Test {
 protected:
  Completion() {
    app_.add_option("--server", text_, "Address of the server; several answer in turn");
    CLI::App* power = app_.add_subcommand("power", "Print powers");
    power->add_option("SCENE", text_, "The scene");
    power->add_option("--method", text_, "How")
        ->check(CLI::Validator([](std::string&) { return std::string(); }, "{exact, sampled}"));
    power->add_option("--points", text_, "Points")->type_name("FILE");
    power->add_option("--out", text_, "Results")->type_name("DIR");
    power->add_option("--seed", seed_, "Seed");
    app_.add_subcommand("pdf", "Print densities");
    app_.add_subcommand("secret", "Not in the help")->group("");
  }

  Candidates ask(const std::vector<std::string>& words) {
    return complete(app_, words, [this] {
      ++scene_calls_;
      return std::vector<std::string>{"room.pbrt", "street.pbrt"};
    });
  }
  std::vector<std::string> words(const std::vector<std::string>& before) {
    std::vector<std::string> result;
    for (const Candidate& candidate : ask(before).words) result.push_back(candidate.word);
    return result;
  }

  CLI::App app_;
  std::string text_;
  int seed_ = 0;
  int scene_calls_ = 0;
};

TEST_F(Completion, CommandsBeginWithTheWord) {
  EXPECT_THAT(words({"p"}), ElementsAre("power", "pdf"));
  EXPECT_THAT(words({"po"}), ElementsAre("power"));
  EXPECT_THAT(words({"x"}), IsEmpty());
}

TEST_F(Completion, HiddenCommandsAreLeftOut) {
  EXPECT_THAT(words({""}), ElementsAre("power", "pdf"));
}

TEST_F(Completion, TheValueOfAnOptionBeforeTheCommandIsNoCommand) {
  EXPECT_THAT(words({"--server", "power", "pd"}), ElementsAre("pdf"));
}

TEST_F(Completion, OptionsAreThoseOfTheCommandAndOfTheProgram) {
  EXPECT_THAT(words({"power", "--s"}), ElementsAre("--seed", "--server"));
  EXPECT_THAT(words({"pdf", "--s"}), ElementsAre("--server"));
}

TEST_F(Completion, DescriptionsEndAtTheFirstSemicolon) {
  EXPECT_EQ(to_lines(ask({"--serv"})), "--server\tAddress of the server\n");
}

TEST_F(Completion, ValuesOfClosedSets) {
  EXPECT_THAT(words({"power", "--method", ""}), ElementsAre("exact", "sampled"));
  EXPECT_THAT(words({"power", "--method", "s"}), ElementsAre("sampled"));
  EXPECT_THAT(words({"power", "--method=s"}), ElementsAre("--method=sampled"));
}

TEST_F(Completion, FilesAndDirectories) {
  EXPECT_EQ(to_lines(ask({"power", "--points", ""})), ":files\n");
  EXPECT_EQ(to_lines(ask({"power", "--out", ""})), ":directories\n");
  EXPECT_EQ(to_lines(ask({"power", "--seed", ""})), "");
}

TEST_F(Completion, ScenesComeFromTheServerWhereASceneIsExpected) {
  EXPECT_THAT(words({"power", "--seed", "1", "ro"}), ElementsAre("room.pbrt"));
  EXPECT_EQ(scene_calls_, 1);
  EXPECT_THAT(words({"power", "room.pbrt", ""}), IsEmpty());
  EXPECT_THAT(words({"power", "--seed", ""}), IsEmpty());
  EXPECT_EQ(scene_calls_, 1);
}

TEST(CompletionWithoutCommands, TheProgramIsTheCommand) {
  CLI::App app;
  std::string scene;
  app.add_option("SCENE", scene);
  app.add_option("--query", scene);
  const auto scenes = [] { return std::vector<std::string>{"room.pbrt"}; };
  EXPECT_EQ(to_lines(complete(app, {"r"}, scenes)), "room.pbrt\n");
  EXPECT_EQ(to_lines(complete(app, {"--q"}, scenes)), "--query\n");
}

}  // namespace
}  // namespace lucerna::shell
