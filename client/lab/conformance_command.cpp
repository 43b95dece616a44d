#include "client/lab/conformance_command.h"

#include <fmt/core.h>

#include <CLI/CLI.hpp>
#include <filesystem>
#include <memory>
#include <string>
#include <system_error>

#include "client/lab/conformance_pack.h"
#include "client/terminal/output.h"
#include "client/terminal/print.h"
#include "client/terminal/session.h"
#include "client/terminal/validators.h"

namespace lucerna::cli {
namespace {

namespace fs = std::filesystem;

/// A folder that gets its name when it is complete.
class NewFolder {
 public:
  explicit NewFolder(std::string path)
      : path_(std::move(path)), unfinished_(path_ + ".unfinished") {
    std::error_code error;
    if (fs::exists(path_, error) && !fs::is_empty(path_, error))
      wrong_use(fmt::format("{}: exists; name a new folder, or an empty one", path_));
    // A killed run may have left one.
    fs::remove_all(unfinished_, error);
    if (!fs::create_directories(unfinished_, error))
      wrong_use(fmt::format("{}: cannot be made: {}", unfinished_, error.message()));
  }
  NewFolder(const NewFolder&) = delete;
  NewFolder& operator=(const NewFolder&) = delete;
  ~NewFolder() {
    std::error_code ignored;
    if (!finished_) fs::remove_all(unfinished_, ignored);
  }

  const std::string& path() const { return unfinished_; }

  void finish() {
    std::error_code error;
    fs::remove(path_, error);
    fs::rename(unfinished_, path_, error);
    if (error)
      throw CommandError(kServerRefused,
                         fmt::format("{}: cannot be written: {}", path_, error.message()));
    finished_ = true;
  }

 private:
  std::string path_, unfinished_;
  bool finished_ = false;
};

void conformance(Session& session, std::string directory, const conformance::PackOptions& options) {
  session.need_one_server("a pack has the answers of one server");
  while (directory.size() > 1 && directory.ends_with('/')) directory.pop_back();
  NewFolder folder(directory);
  std::vector<conformance::CaseSummary> summaries;
  for (const conformance::Case& scene : conformance::cases())
    summaries.push_back(conformance::write_case(session, scene, folder.path(), options));
  conformance::write_overview(session, summaries, folder.path(), options);
  folder.finish();
  if (session.json()) {
    shell::print_text(stdout, "{{\"directory\":\"{}\",\"cases\":{}}}\n", directory,
                      summaries.size());
    return;
  }
  Table table({{"case", true},
               {"kind", true},
               {"setting", true},
               {"samples"},
               {"densities"},
               {"rays"},
               {"irradiances"},
               {"segments"}});
  for (const conformance::CaseSummary& s : summaries) {
    table.add({s.name, s.kind, s.extreme ? "extreme" : "ordinary", std::to_string(s.samples),
               std::to_string(s.densities), std::to_string(s.emission),
               std::to_string(s.irradiances), std::to_string(s.visibilities)});
  }
  session.show(table, fmt::format("{} cases in {}\n", summaries.size(), directory));
}

}  // namespace

void add_conformance_command(CLI::App& app, Session& session) {
  CLI::App* command = app.add_subcommand(
      "conformance", "Write scenes of every kind of light with the answers about them, as CSV");
  command->footer(
      "Others compare their renderer with the pack, without a server.  README.md in the pack\n"
      "explains the columns, which are those of `lucerna verify`.\n"
      "Example:\n  lucerna conformance pack");
  const auto directory = std::make_shared<std::string>();
  const auto options = std::make_shared<conformance::PackOptions>();
  command->add_option("DIR", *directory, "A new folder, or an empty one")->required();
  command->add_option("--samples", options->samples, "Light samples at each of 16 receivers")
      ->check(whole(1, 4096))
      ->capture_default_str();
  command
      ->add_option("--irradiance-samples", options->irradiance_samples,
                   "Samples of the illuminance at each receiver")
      ->check(sample_count(16))
      ->capture_default_str();
  command->add_option("--seed", options->seed, "Random seed")
      ->check(whole64())
      ->capture_default_str();
  session.prints_table(*command);
  command->callback([directory, options, &session] { conformance(session, *directory, *options); });
}

}  // namespace lucerna::cli
