// Counts the lights of a scene on a server of its own, without GoogleTest.
#include <iostream>

#include "lucerna/client/testing/local_server.h"

#ifdef TEST_F
#error "local_server.h includes GoogleTest"
#endif

int main() {
  const auto server = lucerna::testing::LocalServer::start({.scene_root = SCENES});
  if (!server.ok()) {
    std::cerr << server.status() << '\n';
    return 1;
  }
  lucerna::v1::LoadSceneRequest load;
  load.set_path("point.pbrt");
  const auto loaded = server->client().load_scene(load);
  lucerna::v1::ListLightsRequest list;
  if (loaded.ok()) list.set_scene_id(loaded->scene_id());
  const auto lights = server->client().list_lights(list);
  return lights.ok() && lights->lights_size() == 1 ? 0 : 1;
}
