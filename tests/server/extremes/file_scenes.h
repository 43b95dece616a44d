// Scenes from files that a test writes, and their figures.
#pragma once

#include <map>
#include <memory>
#include <string>

#include "server/scene/scene.h"
#include "tests/server/pbrt/pbrt_fixture.h"

namespace lucerna::testing {

/// A scene, or the error.
struct FileScene {
  absl::Status status;
  std::string remarks;
  std::shared_ptr<const Scene> scene;
};

/// The scene of `text`, which follows "WorldBegin\n".  `files` are written beside it, by name.
inline FileScene scene_of(const std::string& text,
                          const std::map<std::string, std::string>& files = {}) {
  const SceneFiles folder;
  for (const auto& [name, bytes] : files) folder.write(name, bytes);
  folder.write("scene.pbrt", "WorldBegin\n" + text);
  FileScene loaded;
  auto description = folder.load("scene.pbrt");
  loaded.status = description.status();
  if (!description.ok()) return loaded;
  loaded.remarks = remarks_of(*description);
  auto scene = Scene::build(*std::move(description));
  loaded.status = scene.status();
  if (scene.ok()) loaded.scene = *scene;
  return loaded;
}

/// The flux of all its lights together [lm].
inline double flux_lm(const Scene& scene) {
  double sum = 0;
  for (const SceneLight& l : scene.lights())
    sum += luminance(l.light->power(scene.sphere()).lumens);
  return sum;
}

/// The bound on the error of that flux [lm].
inline double flux_error_lm(const Scene& scene) {
  double sum = 0;
  for (const SceneLight& l : scene.lights()) sum += l.light->power(scene.sphere()).error_lumens;
  return sum;
}

/// How a scene with one mistake is answered, in the words of docs/extremes.md.  The error must
/// point at the text `mistake`.
inline std::string refusal(const std::string& text, const std::string& mistake,
                           const FileScene& loaded) {
  if (loaded.status.ok()) return "taken";
  const std::string said = message(loaded.status);
  const std::size_t at = text.find(mistake);
  const std::size_t begin = text.rfind('\n', at) + 1;  // 0 where the text does not occur
  const auto line =
      2 + std::count(text.begin(), text.begin() + static_cast<std::ptrdiff_t>(at), '\n');
  const std::string place =
      "scene.pbrt:" + std::to_string(line) + ":" + std::to_string(at - begin + 1) + ": ";
  if (!said.starts_with(place)) return "an error elsewhere: " + said;
  for (const char* words : {"allowed", "the file ends before", "expected", "is not finite"})
    if (said.find(words) != std::string::npos) return "error with file, line and column";
  return "an error that allows nothing: " + said;
}

}  // namespace lucerna::testing
