#include "tests/oracle/oracle_question.h"

#include <array>

namespace lucerna::oracle {

std::string name_of(Question::Kind kind) {
  constexpr std::array kNames{"visibility", "illuminance", "target",  "solid",   "power",
                              "rays",       "delta",       "samples", "density", "le"};
  return kNames.at(static_cast<std::size_t>(kind));
}

std::vector<Question> questions_about(const World& world) {
  using Kind = Question::Kind;
  std::vector<Question> questions;
  for (const auto& segment : world.segments)
    questions.push_back({Kind::kVisibility, segment.from, segment.to});
  for (const Place& receiver : world.receivers) {
    questions.push_back({Kind::kIlluminance, receiver});
    questions.push_back({Kind::kSolid, receiver});
  }
  questions.push_back({Kind::kTarget, world.receivers[0]});
  const int lights = static_cast<int>(world.lights.size());
  const int sources = lights + static_cast<int>(emitting_shapes(world).size());
  for (int i = 0; i < sources; ++i) {
    questions.push_back({Kind::kPower, {}, {}, i});
    questions.push_back({Kind::kRays, {}, {}, i});
    const Place& receiver = world.receivers[static_cast<std::size_t>(i) % world.receivers.size()];
    if (i < lights) {
      questions.push_back({Kind::kDelta, receiver, {}, i});
      if (world.lights[static_cast<std::size_t>(i)].kind == LightKind::kPortal)
        questions.push_back({Kind::kLe, receiver, {}, i});
    } else {
      questions.push_back({Kind::kSamples, receiver, {}, i});
      questions.push_back({Kind::kDensity, receiver, {}, i});
      questions.push_back({Kind::kLe, receiver, {}, i});
    }
  }
  return questions;
}

}  // namespace lucerna::oracle
