// Sends a lucernad four queries about a scene file.  Usage: ask HOST:PORT SCENE
#include <iostream>

#include "lucerna/client/client.h"
#include "lucerna/client/points.h"

int main(int argc, char** argv) {
  if (argc != 3) return 2;
  namespace v1 = lucerna::v1;
  const auto client = lucerna::client::Client::connect({.target = argv[1]}).value();
  v1::LoadSceneRequest load;
  load.set_path(argv[2]);
  const std::string scene = client.load_scene(load).value().scene_id();
  const lucerna::client::Double3 here[] = {{1.2, -1.5, 0}}, there[] = {{1.2, -1.5, 3.2}};

  v1::SampleLiRequest sample;
  sample.set_scene_id(scene);
  *sample.mutable_receivers() = lucerna::client::make_points(here);
  sample.mutable_seed()->set_seed(1);
  const auto li = client.sample_li(sample).value();
  std::cout << "sample " << li.value(0) << " at " << li.distance_m(0) << " m\n";

  v1::EstimatePowerRequest power;
  power.set_scene_id(scene);
  std::cout << "power " << client.estimate_power(power).value().total().power_lm() << " lm\n";

  v1::TestVisibilityRequest visibility;
  visibility.set_scene_id(scene);
  *visibility.mutable_segments()->mutable_from() = lucerna::client::make_points(here);
  *visibility.mutable_segments()->mutable_to() = lucerna::client::make_points(there);
  std::cout << "visible " << (client.test_visibility(visibility).value().visible()[0] & 1) << "\n";

  v1::RenderTileRequest tile;
  tile.set_scene_id(scene);
  tile.mutable_accuracy()->set_samples(4);
  const auto picture = client.render_tile(tile).value().tile();
  std::cout << "tile " << picture.image_width() << " x " << picture.image_height() << "\n";
}
