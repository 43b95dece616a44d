// Loads scenes that tests write.
#pragma once

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <string>
#include <variant>

#include "server/pbrt/load_pbrt.h"
#include "tests/temp_directory.h"
#include "tests/value_of.h"

namespace lucerna::testing {

inline std::string message(const absl::Status& status) {
  return std::string(status.message().data(), status.message().size());
}

/// A temporary directory for each test.
class SceneFiles {
 public:
  const std::filesystem::path& path() const { return directory_.path(); }

  void write(const std::string& name, const std::string& bytes) const {
    std::filesystem::create_directories((path() / name).parent_path());
    std::ofstream(path() / name, std::ios::binary) << bytes;
  }

  absl::StatusOr<SceneDescription> load(const std::string& name, std::stop_token stop = {}) const {
    auto reader = AssetReader::open(path().string());
    if (!reader.ok()) return reader.status();
    return load_pbrt(*reader, name, std::move(stop));
  }

 private:
  TempDirectory directory_;
};

/// The scene of a file with this text; `scene.pbrt` is its name in errors.
inline absl::StatusOr<SceneDescription> load_text(const std::string& text) {
  const SceneFiles files;
  files.write("scene.pbrt", text);
  return files.load("scene.pbrt");
}

/// The same with WorldBegin before it on the same line, so columns shift by 11.
inline absl::StatusOr<SceneDescription> load_world(const std::string& text) {
  return load_text("WorldBegin " + text);
}

/// A square of 1 m with its corner at the origin, normal +z.
inline const std::string kPatch = "Shape \"bilinearmesh\" \"point3 P\" [0 0 0 1 0 0 0 1 0 1 1 0] ";

/// The error of loading; empty if there is none.
inline std::string error_of(const std::string& text) { return message(load_text(text).status()); }
inline std::string world_error_of(const std::string& text) {
  return message(load_world(text).status());
}

/// "line:column what -> instead" for each remark, one per line.
inline std::string remarks_of(const SceneDescription& scene) {
  std::string result;
  for (const Remark& remark : scene.remarks)
    result += std::to_string(remark.where.line) + ":" + std::to_string(remark.where.column) + " " +
              remark.what + " -> " + remark.instead + "\n";
  return result;
}

/// The parameters of the only light of `text` in the world.
template <typename Params>
Params light_of(const std::string& text) {
  const auto scene = load_world(text);
  if (!scene.ok() || scene->lights.size() != 1) {
    ADD_FAILURE() << text << ": " << scene.status();
    return {};
  }
  return std::get<Params>(scene->lights[0].params);
}

inline std::string world_remarks_of(const std::string& text) {
  const auto scene = load_world(text);
  EXPECT_TRUE(scene.ok()) << scene.status();
  return scene.ok() ? remarks_of(*scene) : "";
}

}  // namespace lucerna::testing
