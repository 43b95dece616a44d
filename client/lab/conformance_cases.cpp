#include "client/lab/conformance_cases.h"

#include <fmt/format.h>

#include <cmath>
#include <utility>

#include "client/lab/conformance_pictures.h"
#include "client/lab/gltf_cases.h"

namespace lucerna::conformance {
namespace {

constexpr const char* kFloor =
    "Shape \"bilinearmesh\" \"point3 P\" [-4 -4 0  4 -4 0  -4 4 0  4 4 0]\n";

/// A scene file with one light above a floor.
Case pbrt(std::string name, std::string about, const std::string& light,
          std::vector<CaseFile> files = {}) {
  const std::string text = fmt::format(
      "# {}: {}\n"
      "Film \"rgb\" \"integer xresolution\" [16] \"integer yresolution\" [16]\n"
      "LookAt 0 -6 2   0 0 1   0 0 1\nCamera \"perspective\" \"float fov\" [60]\n"
      "WorldBegin\n{}{}\n",
      name, about, kFloor, light);
  return {.name = std::move(name),
          .about = std::move(about),
          .scene = {"scene.pbrt", text},
          .files = std::move(files)};
}

Case extreme(Case c) {
  c.extreme = true;
  return c;
}

/// A light with a surface, which emits downwards if it is flat.
std::string area(const std::string& light, const std::string& transform, const std::string& shape) {
  return fmt::format(
      "AttributeBegin\n  {}\n  AreaLightSource \"diffuse\" {}\n  Shape {}\nAttributeEnd", transform,
      light, shape);
}

constexpr const char* kDown = "Translate 0.3 -0.2 3\n  Rotate 180 1 0 0";
constexpr const char* kTriangle =
    "\"trianglemesh\" \"point3 P\" [-0.5 -0.5 0  0.7 -0.5 0  -0.5 0.6 0]\n"
    "    \"point2 uv\" [0 0  1 0  0 1] \"integer indices\" [0 1 2]";
constexpr const char* kRectangle =
    "\"bilinearmesh\" \"point3 P\" [-0.6 -0.3 0  0.6 -0.3 0  -0.6 0.3 0  0.6 0.3 0]";
constexpr const char* kPlain = "\"rgb L\" [10 12 8]";
constexpr const char* kPainted = "\"string filename\" \"picture.pfm\" \"float scale\" [3]";
constexpr const char* kPanel = "\"string profile\" \"lamp.ies\" \"float scale\" [2]";

void add_points(std::vector<Case>& all) {
  all.push_back(pbrt("point", "a point light",
                     "LightSource \"point\" \"rgb I\" [12 6 3] \"point3 from\" [0.3 -0.2 3]"));
  all.push_back(
      extreme(pbrt("point_at_receiver", "a point light a tenth of a millimetre beside a receiver",
                   "LightSource \"point\" \"rgb I\" [1 1 1] \"point3 from\" [0 0 0.2501]")));
  all.push_back(
      extreme(pbrt("point_bright", "a point light of 1e20 cd",
                   "LightSource \"point\" \"rgb I\" [1e20 1e20 1e20] \"point3 from\" [0 0 3]")));
  Case far = extreme(pbrt("point_far_away", "a scene 100 km from the origin of coordinates",
                          "LightSource \"point\" \"rgb I\" [5 5 5] \"point3 from\" [0 0 3]"));
  const std::string world = "WorldBegin\n";
  far.scene.content.insert(far.scene.content.find(world) + world.size(),
                           "Translate 100000 -50000 0\n");
  far.center = {100000, -50000, 0};
  all.push_back(std::move(far));
}

void add_spots(std::vector<Case>& all) {
  const auto spot = [](const std::string& parameters) {
    return "LightSource \"spot\" \"rgb I\" [40 30 20] \"point3 from\" [0.5 -0.4 3.5] "
           "\"point3 to\" [0 0 0]\n    " +
           parameters;
  };
  all.push_back(pbrt("spot", "a spot whose edge is a smoothstep of the cosine, as in pbrt-v4",
                     spot("\"float coneangle\" [40] \"float conedeltaangle\" [15]")));
  all.push_back(pbrt("spot_quartic", "a spot with the edge of pbrt-v2",
                     spot("\"float coneangle\" [40] \"float conedeltaangle\" [15] "
                          "\"string profile\" \"quartic\"")));
  all.push_back(pbrt("spot_quadratic", "a spot with the edge of glTF",
                     spot("\"float coneangle\" [40] \"float conedeltaangle\" [15] "
                          "\"string profile\" \"quadratic\"")));
  all.push_back(pbrt("spot_hard", "a spot without a soft edge",
                     spot("\"float coneangle\" [40] \"float conedeltaangle\" [0]")));
  all.push_back(extreme(pbrt("spot_narrow", "a spot with a half angle of 0.1 degrees",
                             "LightSource \"spot\" \"rgb I\" [1e6 1e6 1e6] \"point3 from\" [0 0 3] "
                             "\"point3 to\" [0 0 0]\n    \"float coneangle\" [0.1] "
                             "\"float conedeltaangle\" [0.05]")));
  all.push_back(extreme(pbrt("spot_wide", "a spot with a half angle of 179 degrees",
                             spot("\"float coneangle\" [179] \"float conedeltaangle\" [90]"))));
}

void add_infinite(std::vector<Case>& all) {
  all.push_back(pbrt(
      "distant", "parallel light",
      "LightSource \"distant\" \"rgb L\" [2 3 4] \"point3 from\" [1 -2 3] \"point3 to\" [0 0 0]"));
  all.push_back(extreme(pbrt("distant_grazing", "parallel light, 0.01 degrees above the floor",
                             "LightSource \"distant\" \"rgb L\" [2 2 2] "
                             "\"point3 from\" [1 0 0.000174533] \"point3 to\" [0 0 0]")));
  const auto sun = [](double degrees) {
    return fmt::format(
        "LightSource \"distant\" \"rgb L\" [3 3 2] \"point3 from\" [-1 -2 3] \"point3 to\" [0 0 0] "
        "\"float angulardiameter\" [{}]",
        degrees);
  };
  all.push_back(pbrt("sun", "a disk of 0.53 degrees in the sky", sun(0.53)));
  all.push_back(extreme(pbrt("sun_tiny", "a disk of 0.001 degrees in the sky", sun(0.001))));
  all.push_back(extreme(pbrt("sun_wide", "a disk of 170 degrees in the sky", sun(170))));
  all.push_back(
      pbrt("infinite", "a uniform sky", "LightSource \"infinite\" \"rgb L\" [0.5 0.6 0.7]"));
  all.push_back(extreme(pbrt("infinite_dark", "a uniform sky of 1e-20 cd/m2",
                             "LightSource \"infinite\" \"rgb L\" [1e-20 1e-20 1e-20]")));
  const std::string image = "LightSource \"infinite\" \"string filename\" \"sky.pfm\"";
  all.push_back(pbrt("infinite_picture", "a sky with an equal-area picture", image, {sky()}));
  all.push_back(pbrt("infinite_latlong", "a sky with a latitude-longitude picture",
                     image + " \"string mapping\" \"latlong\"", {wide_sky()}));
  all.push_back(pbrt("infinite_bilinear", "a sky with a picture and the bilinear filter",
                     image + " \"string filter\" \"bilinear\"", {sky()}));
  all.push_back(extreme(pbrt("infinite_bright_texel",
                             "a sky with one texel 1e6 times brighter than the others", image,
                             {bright_sky()})));
  const std::string portal = "\"point3 portal\" [-1 -1 3  -1 1 3  1 1 3  1 -1 3]";
  all.push_back(pbrt("portal", "a uniform sky through a portal",
                     "LightSource \"infinite\" \"rgb L\" [4 4 4] " + portal));
  all.push_back(pbrt("portal_picture", "a sky with a picture through a portal",
                     image + " \"string filter\" \"nearest\" " + portal, {sky()}));
  all.push_back(extreme(pbrt("portal_tiny", "a uniform sky through a portal of one millimetre",
                             "LightSource \"infinite\" \"rgb L\" [4 4 4] \"point3 portal\" "
                             "[-0.0005 -0.0005 3  -0.0005 0.0005 3  0.0005 0.0005 3  "
                             "0.0005 -0.0005 3]")));
}

void add_pictures_and_luminaires(std::vector<Case>& all) {
  const auto placed = [](const std::string& light) {
    return fmt::format("AttributeBegin\n  {}\n  LightSource {}\nAttributeEnd", kDown, light);
  };
  // Above the first receiver, which is the only one in a narrow beam.
  const auto above = [](const std::string& light) {
    return fmt::format(
        "AttributeBegin\n  Translate 0 0 3\n  Rotate 180 1 0 0\n  LightSource {}\nAttributeEnd",
        light);
  };
  all.push_back(pbrt("goniometric", "equal intensity in all directions, as a goniometric light",
                     placed("\"goniometric\" \"rgb I\" [7 6 5]")));
  all.push_back(pbrt("goniometric_ies", "a luminaire of an IES file",
                     placed("\"goniometric\" \"string filename\" \"lamp.ies\""), {ies()}));
  all.push_back(
      extreme(pbrt("goniometric_ies_narrow", "a luminaire whose beam is 2 degrees wide",
                   above("\"goniometric\" \"string filename\" \"lamp.ies\""), {narrow_ies()})));
  all.push_back(pbrt("goniometric_picture", "intensities in an equal-area picture",
                     placed("\"goniometric\" \"string filename\" \"sky.pfm\""), {grey_sky()}));
  all.push_back(pbrt("goniometric_latlong", "intensities in a latitude-longitude picture",
                     placed("\"goniometric\" \"string filename\" \"sky.pfm\" "
                            "\"string mapping\" \"latlong\""),
                     {wide_grey_sky()}));
  const std::string projection = "\"projection\" \"float scale\" [50]";
  const std::string slide = " \"string filename\" \"picture.pfm\"";
  const std::string beam = " \"string projection\" \"orthographic\"";
  all.push_back(pbrt("projection", "a projector of a uniform square",
                     placed(projection + " \"float fov\" [50]")));
  all.push_back(pbrt("projection_picture", "a projector of a picture",
                     placed(projection + " \"float fov\" [50]" + slide), {picture()}));
  all.push_back(extreme(pbrt("projection_narrow", "a projector with a field of view of 0.1 degrees",
                             above(projection + " \"float fov\" [0.1]"))));
  all.push_back(extreme(pbrt("projection_wide", "a projector with a field of view of 170 degrees",
                             placed(projection + " \"float fov\" [170]" + slide), {picture()})));
  all.push_back(pbrt("beam", "parallel rays from a square",
                     placed(projection + beam + " \"float extent\" [3]")));
  all.push_back(pbrt("beam_picture", "parallel rays from a picture",
                     placed(projection + beam + " \"float extent\" [3]" + slide), {picture()}));
  all.push_back(extreme(pbrt("beam_narrow", "parallel rays from a square of one millimetre",
                             above(projection + beam + " \"float extent\" [0.001]"))));
}

void add_areas(std::vector<Case>& all) {
  struct Shape {
    const char *name, *about, *text;
    bool flat;
  };
  constexpr Shape kShapes[] = {
      {"triangle", "a triangle", kTriangle, true},
      {"rectangle", "a rectangle", kRectangle, true},
      {"disk", "a disk", "\"disk\" \"float radius\" [0.4]", true},
      {"sphere", "a sphere", "\"sphere\" \"float radius\" [0.35]", false},
      {"cylinder", "a cylinder",
       "\"cylinder\" \"float radius\" [0.1] \"float zmin\" [-0.5] \"float zmax\" [0.5]", false},
  };
  for (const Shape& shape : kShapes) {
    const std::string name = shape.name, about = shape.about;
    all.push_back(pbrt(name, about, area(kPlain, kDown, shape.text)));
    all.push_back(pbrt(name + "_picture", about + " with a picture",
                       area(kPainted, kDown, shape.text), {picture()}));
    if (shape.flat)
      all.push_back(pbrt(name + "_profile", about + " with the profile of a luminaire",
                         area(kPanel, kDown, shape.text), {ies()}));
  }
  all.push_back(pbrt("rectangle_two_sided", "a rectangle that emits on both sides",
                     area("\"rgb L\" [5 5 5] \"bool twosided\" true",
                          "Translate 0 0 1.1\n  Rotate 70 1 0 0", kRectangle)));
  all.push_back(pbrt("patch_bent", "a bilinear patch that is not flat",
                     area(kPlain, kDown,
                          "\"bilinearmesh\" \"point3 P\" "
                          "[-0.6 -0.4 0.1  0.6 -0.4 0  -0.6 0.4 0  0.6 0.4 0.15]")));
  all.push_back(
      pbrt("disk_ring", "a disk with a hole",
           area(kPlain, kDown, "\"disk\" \"float radius\" [0.5] \"float innerradius\" [0.4]")));
  all.push_back(pbrt("cylinder_half", "half of a cylinder",
                     area(kPlain, kDown,
                          "\"cylinder\" \"float radius\" [0.3] \"float zmin\" [-0.5] "
                          "\"float zmax\" [0.5] \"float phimax\" [180]")));
  const auto hard = [&](const char* name, const char* about, const char* transform,
                        const char* shape, const char* light = kPlain) {
    all.push_back(extreme(pbrt(name, about, area(light, transform, shape))));
  };
  hard("triangle_needle", "a triangle of 2 m by a tenth of a millimetre", kDown,
       "\"trianglemesh\" \"point3 P\" [-1 0 0  1 0 0  1 0.0001 0] \"integer indices\" [0 1 2]",
       "\"rgb L\" [1e5 1e5 1e5]");
  hard("triangle_tiny", "a triangle of a tenth of a millimetre", kDown,
       "\"trianglemesh\" \"point3 P\" [0 0 0  0.0001 0 0  0 0.0001 0] \"integer indices\" [0 1 2]",
       "\"rgb L\" [1e8 1e8 1e8]");
  hard("rectangle_close", "a sheet of 200 m, one millimetre above some receivers",
       "Translate 0 0 0.251\n  Rotate 180 1 0 0",
       "\"bilinearmesh\" \"point3 P\" [-100 -100 0  100 -100 0  -100 100 0  100 100 0]");
  hard("rectangle_edge_on", "a rectangle whose plane is one millimetre above some receivers",
       "Translate 0 3 0.251\n  Rotate 180 1 0 0", kRectangle,
       "\"rgb L\" [9 9 9] \"bool twosided\" true");
  hard("sphere_tiny", "a sphere with a radius of a tenth of a millimetre", kDown,
       "\"sphere\" \"float radius\" [0.0001]", "\"rgb L\" [1e8 1e8 1e8]");
  hard("sphere_around", "a sphere around the receivers that emits inwards",
       "Translate 0 0 1\n  ReverseOrientation", "\"sphere\" \"float radius\" [10]");
  hard("disk_ring_thin", "a ring of a tenth of a millimetre", kDown,
       "\"disk\" \"float radius\" [0.5] \"float innerradius\" [0.4999]", "\"rgb L\" [1e4 1e4 1e4]");
  hard("cylinder_thin", "a wire with a radius of a tenth of a millimetre",
       "Translate 0 0 2\n  Rotate 90 0 1 0",
       "\"cylinder\" \"float radius\" [0.0001] \"float zmin\" [-1] \"float zmax\" [1]",
       "\"rgb L\" [1e5 1e5 1e5]");
}

}  // namespace

std::vector<Case> cases() {
  std::vector<Case> all;
  add_points(all);
  add_spots(all);
  add_infinite(all);
  add_pictures_and_luminaires(all);
  add_areas(all);
  for (Case& c : gltf_cases()) all.push_back(std::move(c));
  return all;
}

std::vector<Receiver> receivers(const Case& scene) {
  // The first is below the lights at the origin.  The others spread by the golden ratio, so that
  // none is on an axis of symmetry.
  constexpr int kCount = 16;
  constexpr double kGolden = 0.6180339887498949;
  std::vector<Receiver> all;
  for (int i = 0; i < kCount; ++i) {
    const double a = 2 * 3.141592653589793 * std::fmod(i * kGolden, 1.0);
    const double r = 2 * std::sqrt(static_cast<double>(i) / kCount);
    const double height = i % 3 == 2 ? 1.25 : 0.25;
    Receiver receiver;
    const client::Double3 local = {r * std::cos(a), r * std::sin(a), height};
    for (std::size_t k = 0; k < 3; ++k) receiver.point[k] = scene.center[k] + local[k];
    receiver.normal = {0, 0, 1};
    if (i % 4 == 3) receiver.normal = {-0.6 * std::cos(a), -0.6 * std::sin(a), 0.8};
    if (i % 8 == 5) receiver.normal = {-std::cos(a), -std::sin(a), 0};
    all.push_back(receiver);
  }
  return all;
}

}  // namespace lucerna::conformance
