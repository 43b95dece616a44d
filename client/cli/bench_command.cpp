#include "client/cli/bench_command.h"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <memory>
#include <string>
#include <vector>

#include "client/cli/bench_load.h"
#include "client/cli/bench_questions.h"
#include "client/cli/bench_report.h"
#include "client/cli/rate_search.h"
#include "client/cli/server_target.h"
#include "client/library/byte_calls.h"
#include "client/terminal/output.h"
#include "client/terminal/print.h"
#include "client/terminal/session.h"
#include "client/terminal/validators.h"

namespace lucerna::cli {
namespace {

using bench::Question;

// The searched rate is known this precisely.
constexpr double kRatePrecision = 0.05;
constexpr double kFewestCalls = 10;
// Calls in flight for the throughput from which a search starts.
constexpr std::uint32_t kSearchInFlight = 4;

struct BenchOptions {
  std::string question, scene;
  std::vector<std::uint32_t> batches, in_flight;
  std::vector<double> rates;
  std::string limit;
  bench::Plan plan;
  bench::QuestionOptions items;
};

std::vector<std::uint32_t> default_batches(Question question) {
  switch (question) {
    case Question::kIrradiance:
      return {256};
    case Question::kPower:
      return {1};
    case Question::kTile:
      return {1024};
    case Question::kVisibility:
    case Question::kSamples:
    case Question::kEmission:
      return {4096};
    case Question::kEmpty:
      break;
  }
  return {1};
}

Question question_of(const std::string& name) {
  const auto found = std::ranges::find(bench::kQuestionNames, name);
  return static_cast<Question>(found - std::begin(bench::kQuestionNames));
}

/// Ends the program for options that do not fit the call.
void check(Question question, const BenchOptions& options) {
  const auto refuse = [&](bool given, const char* option, std::initializer_list<Question> calls) {
    if (!given || std::ranges::find(calls, question) != calls.end()) return;
    std::string names;
    for (const Question q : calls)
      names += fmt::format("{}{}", names.empty() ? "" : ", ",
                           bench::kQuestionNames[static_cast<std::size_t>(q)]);
    wrong_use(
        fmt::format("{} has no effect on {}, allowed with: {}", option, options.question, names));
  };
  using enum Question;
  if (question == kEmpty) {
    if (!options.scene.empty()) wrong_use("SCENE: an empty call has no scene");
    if (!options.batches.empty()) wrong_use("--batch: an empty call has no items");
  } else if (options.scene.empty()) {
    wrong_use(fmt::format("SCENE is missing; {} needs a scene", options.question));
  }
  refuse(options.items.coherent, "--coherent", {kVisibility, kIrradiance, kSamples});
  refuse(options.items.light.given(), "--light", {kSamples, kEmission});
  refuse(options.items.samples.has_value(), "--samples", {kIrradiance, kSamples, kTile});
  refuse(options.items.bounces.has_value(), "--bounces", {kIrradiance, kTile});
}

/// Finds out what requests need to know of the scene.
void describe_scene(Session& session, Question question, BenchOptions& options) {
  if (question == Question::kEmpty) return;
  v1::GetSceneRequest request;
  request.set_scene_id(session.query_scene_id(options.scene));
  options.items.scene =
      session.value_or_fail(session.client().get_scene(request, session.call_options())).summary();
  if (question != Question::kPower) return;
  const v1::ListLightsResponse lights = list_lights(session, request.scene_id());
  for (const v1::Light& light : lights.lights()) options.items.light_ids.push_back(light.id());
}

class Bench {
 public:
  Bench(Session& session, const BenchOptions& options, Question question)
      : session_(session),
        options_(options),
        question_(question),
        calls_(session.value_or_fail(client::ByteCalls::connect(
            {.target = session.server(), .security = session.security()}))) {
    report_.server = session.server();
    report_.question = options.question;
    report_.scene_id = options.items.scene.scene_id();
  }

  void run() {
    if (!options_.limit.empty()) report_.limit = bench::read_latency_limit(options_.limit);
    const std::vector<std::uint32_t> batches =
        options_.batches.empty() ? default_batches(question_) : options_.batches;
    for (const std::uint32_t batch : batches) {
      const auto requests = bench::make_requests(question_, batch, options_.items);
      if (!requests.ok()) wrong_use(std::string(requests.status().message()));
      bench::ServerTarget target(session_.client(), calls_, question_, *requests,
                                 session_.call_options());
      if (report_.limit) {
        search(target, requests->items);
      } else if (!options_.rates.empty()) {
        for (const double rate : options_.rates) add_open(target, requests->items, rate);
      } else {
        const std::vector<std::uint32_t> all =
            options_.in_flight.empty() ? std::vector<std::uint32_t>{4} : options_.in_flight;
        for (const std::uint32_t n : all)
          add({.batch = requests->items,
               .in_flight = n,
               .rate = {},
               .figures = bench::closed_loop(target, n, options_.plan),
               .holds = {}});
      }
    }
    if (session_.json()) {
      shell::print_text(stdout, "{}", bench::json_of(report_));
    } else {
      session_.show(bench::rows_of(report_), session_.csv() ? "" : bench::found_of(report_));
      session_.print_remarks();
    }
  }

 private:
  const bench::Row& add(bench::Row row) {
    check_answers(row.figures, row.rate.has_value() && report_.limit);
    if (report_.limit && row.rate) row.holds = bench::holds(row.figures, *report_.limit);
    report_.rows.push_back(std::move(row));
    return report_.rows.back();
  }

  const bench::Row& add_open(bench::Target& target, std::uint64_t items, double rate) {
    return add({.batch = items,
                .in_flight = {},
                .rate = rate,
                .figures = bench::open_loop(target, rate, options_.items.seed, options_.plan),
                .holds = {}});
  }

  void search(bench::Target& target, std::uint64_t items) {
    const bench::Figures most = bench::closed_loop(target, kSearchInFlight, options_.plan);
    check_answers(most);
    const double capacity = static_cast<double>(most.calls()) / most.seconds;
    const std::optional<double> rate = bench::highest_rate(
        [&](double r) {
          // So few calls say nothing of a quantile, and even lower rates say less.
          if (r * options_.plan.time_s < kFewestCalls) return false;
          return *add_open(target, items, r).holds;
        },
        capacity / 2, kRatePrecision);
    report_.found.push_back({.batch = items, .rate = rate});
  }

  /// Ends the program after an interruption, and if no call had an answer.  `may_be_empty`: not if
  /// there was no call at all.
  void check_answers(const bench::Figures& figures, bool may_be_empty = false) {
    if (session_.call_options().stop.stop_requested())
      session_.fail(absl::CancelledError("interrupted"));
    if (std::chrono::system_clock::now() >= session_.call_options().deadline)
      session_.fail(absl::DeadlineExceededError("--timeout ended before the load"));
    // An overload during the warm-up leaves no figures, and is an answer.
    if (figures.calls() > 0 || figures.overloaded) return;
    if (!figures.error.ok()) session_.fail(figures.error);
    // By chance no call may be due.
    if (may_be_empty) return;
    session_.fail(absl::DeadlineExceededError(
        fmt::format("no call ended within --time, {:g} s", options_.plan.time_s)));
  }

  Session& session_;
  const BenchOptions& options_;
  const Question question_;
  const client::ByteCalls calls_;
  bench::Report report_;
};

CLI::Validator latency_limit() {
  return {[](std::string& text) -> std::string {
            if (bench::read_latency_limit(text)) return {};
            return text + " is not a limit such as p99=5ms: a percentage in (0, 100) and a time";
          },
          "LIMIT"};
}

void add_load_options(CLI::App& command, BenchOptions& options) {
  CLI::Option* in_flight = command
                               .add_option("--in-flight", options.in_flight,
                                           "Calls in flight, one or a list; default: 4")
                               ->delimiter(',')
                               ->type_name("N,...")
                               ->check(whole(1, bench::kMostInFlight).name(""));
  CLI::Option* rate = command
                          .add_option("--rate", options.rates,
                                      "Open loop: calls in a second at random times, one or a list")
                          ->delimiter(',')
                          ->type_name("RATE,...")
                          ->check(positive().name(""))
                          ->excludes(in_flight);
  command
      .add_option("--latency-limit", options.limit,
                  "Search for the highest rate that holds this limit, such as p99=5ms")
      ->check(latency_limit())
      ->excludes(in_flight)
      ->excludes(rate);
  const auto add_time = [&](const char* name, double& time_s, const std::string& help) {
    command.add_option(name, time_s, fmt::format("{}; default: {:g}s", help, time_s))
        ->type_name("TIME")
        ->transform(duration());
  };
  add_time("--time", options.plan.time_s, "Most time of each load");
  add_time("--warm-up", options.plan.warm_up_s, "Time before each load that does not count");
  add_time("--window", options.plan.window_s, "Length of a window");
  command
      .add_option("--stable", options.plan.stable_share,
                  "A closed loop ends when the throughput of three windows differs by less than "
                  "this; default: 5%")
      ->transform(share());
}

}  // namespace

void add_bench_command(CLI::App& app, Session& session) {
  CLI::App* command =
      app.add_subcommand("bench", "Load the server with one kind of call, and measure it");
  command->footer(
      "CALL: visibility, irradiance, samples (SampleLi), emission (SampleLe), power, tile, or "
      "empty (GetServerInfo).\nItems are random, inside of the scene.\nExample:\n"
      "  lucerna bench visibility room.pbrt --batch 1,64,4096 --in-flight 1,4\n"
      "  lucerna bench empty --rate 1000\n"
      "  lucerna bench irradiance room.pbrt --samples 16 --latency-limit p99=20ms");
  const auto options = std::make_shared<BenchOptions>();
  std::vector<std::string> names(std::begin(bench::kQuestionNames),
                                 std::end(bench::kQuestionNames));
  command->add_option("CALL", options->question, "The kind of call")
      ->required()
      ->check(one_of(names));
  command->add_option("SCENE", options->scene, kSceneHelp);
  command
      ->add_option("--batch", options->batches,
                   "Segments, receivers, rays, lights or pixels of each call, one or a list")
      ->delimiter(',')
      ->type_name("N,...")
      ->check(whole(1).name(""));
  add_load_options(*command, *options);
  options->items.light.add(*command, "Id or name of the light that samples and emission use");
  command
      ->add_option("--samples", options->items.samples,
                   "Samples of each receiver or pixel; default: that of the call")
      ->check(sample_count());
  command
      ->add_option("--bounces", options->items.bounces,
                   "Most reflections of light; default: that of the call")
      ->check(whole(0));
  command->add_flag("--coherent", options->items.coherent,
                    "Put the items of a call in order: grids, and segments from one point");
  command->add_option("--seed", options->items.seed, "Random seed of items and arrivals")
      ->check(whole64())
      ->capture_default_str();
  session.prints_table(*command);
  command->callback([options, &session] {
    session.need_one_server("a bench loads one server");
    const Question question = question_of(options->question);
    check(question, *options);
    describe_scene(session, question, *options);
    Bench(session, *options, question).run();
  });
}

}  // namespace lucerna::cli
