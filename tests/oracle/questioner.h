// Questions about a random scene, asked to a server over the wire and answered by the oracle.
#pragma once

#include <chrono>
#include <filesystem>
#include <string>
#include <utility>

#include "tests/oracle/oracle_question.h"
#include "tests/oracle/oracle_truth.h"
#include "tests/server/rpc/service_fixture.h"

namespace lucerna::testing {

using oracle::Question;

/// What comparing two answers gave.
struct Verdict {
  enum class Kind : std::uint8_t {
    kAgrees,   ///< an answer without random error is right
    kHolds,    ///< an interval contains the right value
    kMisses,   ///< an interval does not contain it, which may happen in 5%
    kWrong,    ///< an answer without random error is wrong
    kUnsure,   ///< the floats of scene and request do not decide it
    kNoAnswer  ///< the server gave a status that the contract allows
  };
  Kind kind = Kind::kUnsure;
  std::string text{};  ///< of wrong answers: the question and both answers
};

/// The status of `call(&context)`.  Sends a call again if its connection breaks, as clients do, and
/// adds 1 to `repeats` each time.  The server closes a connection if 20 s pass between its ping and
/// the answer: that happens to a process that other programs stop twice.
template <typename Call>
grpc::Status status_on_any_connection(Call&& call, std::uint64_t& repeats) {
  constexpr int kMostRepeats = 3;
  grpc::ClientContext first;
  grpc::Status status = call(&first);
  for (int i = 0; i < kMostRepeats && status.error_code() == grpc::StatusCode::UNAVAILABLE; ++i) {
    ++repeats;
    grpc::ClientContext context;
    // Without this, a call fails at once while the channel connects again.
    context.set_wait_for_ready(true);
    context.set_deadline(std::chrono::system_clock::now() + std::chrono::minutes(5));
    status = call(&context);
  }
  return status;
}

class Questioner {
 public:
  /// `folder`: the server's scene root.
  Questioner(Service& service, std::filesystem::path folder)
      : service_(service), folder_(std::move(folder)) {}

  /// Loads the scene in place of the one before.
  grpc::Status load(const oracle::World& world);
  /// The same from the text of a .pbrt file.
  grpc::Status load(const std::string& text);
  /// Of the loaded scene.
  Verdict judge(const oracle::Truth& truth, const Question& question);
  void release();
  /// Asks for the illuminance of one place in the loaded scene; `q`: how.
  grpc::Status irradiance(const oracle::Place& at, v1::EstimateIrradianceRequest q,
                          v1::EstimateIrradianceResponse* r);
  /// How often a call was sent again.
  std::uint64_t repeats() const { return repeats_; }

 private:
  template <typename Request>
  grpc::Status call(const Request& q, ResponseTo<Request>* r) {
    return status_on_any_connection([&](auto* c) { return service_.call(c, q, r); }, repeats_);
  }
  Verdict visibility(const oracle::Truth& truth, const Question& question);
  Verdict illuminance(const oracle::Truth& truth, const Question& question);
  Verdict target(const oracle::Truth& truth, const Question& question);
  Verdict solid(const oracle::Truth& truth, const Question& question);
  Verdict power(const oracle::Truth& truth, const Question& question);
  Verdict rays(const oracle::Truth& truth, const Question& question);
  Verdict delta(const oracle::Truth& truth, const Question& question);
  Verdict samples(const oracle::Truth& truth, const Question& question);
  Verdict density(const oracle::Truth& truth, const Question& question);
  Verdict le(const oracle::Truth& truth, const Question& question);
  Verdict le_of_portal(const oracle::Truth& truth, const Question& question);
  grpc::Status direct(const oracle::Truth& truth, const oracle::Place& at,
                      v1::EstimateIrradianceRequest q, v1::EstimateIrradianceResponse* r);
  static Verdict compare(const oracle::Amount& amount, const v1::EstimateIrradianceResponse& r,
                         const oracle::Place& at);
  bool has_densities(const oracle::Truth& truth, const Question& question,
                     const v1::SampleLeResponse& rays, std::string& text);
  v1::SampleLiResponse sample(const oracle::Truth& truth, const Question& question,
                              std::uint32_t samples, v1::AreaSampling sampling);

  Service& service_;
  std::filesystem::path folder_;
  std::string id_;
  std::uint64_t repeats_ = 0;
};

}  // namespace lucerna::testing
