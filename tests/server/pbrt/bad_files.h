// Loads one light whose file is unusual or broken.
#pragma once

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <string>
#include <utility>

#include "server/pbrt/syntax/place.h"
#include "server/scene/scene.h"
#include "tests/server/pbrt/pbrt_fixture.h"

namespace lucerna::testing {

/// The result for one light and its file.
struct Outcome {
  absl::Status status;
  std::string place;  ///< place of the parameter, "scene.pbrt:2:24: "
  std::string remarks;
  double lumens = 0;
  bool lit = false;
  bool is_left_out = false;  ///< the scene has no light
};

/// `source` has FILE for the file name, after the parameter `parameter`.
inline Outcome load(const std::string& source, const std::string& parameter,
                    const std::string& name, const std::string& bytes) {
  const SceneFiles files;
  files.write(name, bytes);
  std::string text = source;
  text.replace(text.find("FILE"), 4, "\"" + name + "\"");
  // A floor gives the scene a size, and so a flux to lights at infinity.
  files.write(
      "scene.pbrt",
      "WorldBegin Shape \"bilinearmesh\" \"point3 P\" [-1 -1 0 1 -1 0 -1 1 0 1 1 0]\n" + text);
  Outcome outcome;
  outcome.place = "scene.pbrt:2:" + std::to_string(text.find("\"string " + parameter) + 1) + ": ";
  auto description = files.load("scene.pbrt");
  outcome.status = description.status();
  if (!description.ok()) return outcome;
  outcome.remarks = remarks_of(*description);
  const auto scene = Scene::build(*std::move(description));
  outcome.status = scene.status();
  if (!scene.ok()) return outcome;
  outcome.is_left_out = (*scene)->lights().empty();
  if (outcome.is_left_out) return outcome;
  EXPECT_EQ((*scene)->lights().size(), 1U);
  const Light& light = *(*scene)->lights()[0].light;
  outcome.lumens = luminance(light.power((*scene)->sphere()).lumens);
  // A point that all of the lights illuminate.
  for (int i = 0; i < 16; ++i) {
    const auto s = light.sample_li(Receiver(0.1, 0.2, 0.7), {(i % 4) / 4.0, (i / 4) / 4.0});
    outcome.lit |= s.reason == NoLight::kNone && s.value.g > 0;
    EXPECT_TRUE(is_finite(s.value) && std::isfinite(s.pdf.per_sr));
  }
  return outcome;
}

inline void expect_error(const Outcome& o, const std::string& parameter, const std::string& name) {
  EXPECT_FALSE(o.status.ok());
  const std::string text = message(o.status);
  EXPECT_THAT(text, ::testing::StartsWith(o.place));
  EXPECT_THAT(text, ::testing::HasSubstr("\"string " + parameter + "\""));
  EXPECT_THAT(text, ::testing::HasSubstr(name));
  EXPECT_THAT(text, ::testing::AnyOf(::testing::HasSubstr("allowed"),
                                     ::testing::HasSubstr("the file ends before")));
  EXPECT_TRUE(pbrt::is_printable(text)) << text;
}

}  // namespace lucerna::testing
