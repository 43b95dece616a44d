#include "server/pbrt/camera.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <initializer_list>
#include <numbers>
#include <string_view>

namespace lucerna::pbrt {
namespace {

void check_type(const Setting& setting, const char* directive,
                std::initializer_list<std::string_view> types) {
  if (!is_one_of(setting.type, types))
    fail(setting.place, fmt::format("unknown {} \"{}\", expected one of {}", directive,
                                    printable(setting.type), fmt::join(types, " ")));
}

void apply_film(Context& context, const Settings& settings) {
  static const Setting kDefault{"rgb", {}, {}};
  const Setting& setting = settings.film ? *settings.film : kDefault;
  check_type(setting, "Film", {"rgb", "gbuffer", "spectral"});
  const ParameterSet& params = setting.params;
  Film& film = context.scene.film;
  film.width = params.integer("xresolution", film.width);
  film.height = params.integer("yresolution", film.height);
  constexpr int kMaxPixels = 1 << 16;
  for (const int n : {film.width, film.height})
    if (n < 1 || n > kMaxPixels)
      fail(setting.place, fmt::format("Film of {} by {} pixels, allowed 1 to {} each way",
                                      film.width, film.height, kMaxPixels));
  if (setting.type != "rgb")
    context.remark(setting.place, fmt::format("Film \"{}\" is not modelled", setting.type),
                   "linear RGB");

  const std::string sensor = params.string("sensor", "cie1931");
  if (sensor != "cie1931")
    context.remark(setting.place, fmt::format("sensor \"{}\" is not modelled", printable(sensor)),
                   "cie1931");
  if (params.number("whitebalance", 0) != 0)
    context.remark(setting.place, "\"whitebalance\" is not modelled", "none");
  if (params.number("maxcomponentvalue"))
    context.remark(setting.place, "\"maxcomponentvalue\" is not modelled",
                   "values are not clipped");
  // The imaging ratio of pbrt-v4: exposure time times ISO speed over 100.
  double exposure_s = 1;
  context.scene.hints.shutter_close_s = 1;
  if (settings.camera) {
    const ParameterSet& camera = settings.camera->params;
    RenderHints& hints = context.scene.hints;
    hints.shutter_open_s = camera.number("shutteropen", 0);
    hints.shutter_close_s = camera.number("shutterclose", 1);
    exposure_s = hints.shutter_close_s - hints.shutter_open_s;
    if (!(exposure_s > 0))
      fail(settings.camera->place,
           fmt::format("the shutter is open for {} s, allowed: more than 0", exposure_s));
  }
  const double iso = params.number("iso", 100);
  if (!(iso > 0)) fail(setting.place, fmt::format("\"float iso\" = {}, allowed: above 0", iso));
  film.scale = exposure_s * iso / 100;

  const std::vector<double> crop = params.numbers("cropwindow");
  if (!crop.empty() && crop != std::vector<double>{0, 1, 0, 1})
    context.remark(setting.place, "\"cropwindow\" is not modelled", "the whole image");
  const std::vector<double> bounds = params.numbers("pixelbounds");
  if (!bounds.empty() && bounds != std::vector<double>{0, static_cast<double>(film.width), 0,
                                                       static_cast<double>(film.height)})
    context.remark(setting.place, "\"pixelbounds\" is not modelled", "the whole image");
  params.ignore({"filename", "savefp16", "diagonal", "coordinatesystem", "nbuckets", "lambdamin",
                 "lambdamax"});
  params.remark_unused(context, fmt::format("Film \"{}\"", setting.type));
}

void apply_camera(Context& context, const Settings& settings) {
  static const Setting kDefault{"perspective", {}, {}};
  const Setting& setting = settings.camera ? *settings.camera : kDefault;
  check_type(setting, "Camera", {"perspective", "orthographic", "realistic", "spherical"});
  const ParameterSet& params = setting.params;
  PerspectiveCamera& camera = context.scene.camera;
  camera.world_from_camera = settings.camera_from_world.inverse();
  camera.motion = settings.camera_motion;
  const double width = context.scene.film.width;
  const double height = context.scene.film.height;
  double fov = 90;
  double aspect = width / height;
  std::vector<double> window;
  if (setting.type == "perspective") {
    fov = params.number("fov", 90);
    if (!(fov > 0 && fov < 180))
      fail(setting.place, fmt::format("\"float fov\" = {} degrees, allowed (0, 180)", fov));
    aspect = params.number("frameaspectratio", aspect);
    if (!(aspect > 0))
      fail(setting.place, fmt::format("\"float frameaspectratio\" = {}, allowed: above 0", aspect));
    window = params.numbers("screenwindow");
    if (!window.empty() &&
        (window.size() != 4 || !(window[0] < window[1]) || !(window[2] < window[3])))
      fail(setting.place, "\"float screenwindow\", expected four values x0 < x1, y0 < y1");
    if (params.number("lensradius", 0) > 0)
      context.remark(setting.place, "\"lensradius\" is not modelled", "a pinhole");
    params.ignore({"focaldistance", "shutteropen", "shutterclose"});
    params.remark_unused(context, "Camera \"perspective\"");
  } else {
    context.remark(setting.place, fmt::format("Camera \"{}\" is not modelled", setting.type),
                   "a perspective camera, 90 degrees across the shorter side");
  }
  if (window.empty()) {
    // The shorter side spans -1 to 1.
    const double x = std::max(aspect, 1.0);
    const double y = std::max(1 / aspect, 1.0);
    window = {-x, x, -y, y};
  }
  const double tangent = std::tan(fov * std::numbers::pi / 360);
  camera.screen_min = {window[0] * tangent, window[2] * tangent};
  camera.screen_max = {window[1] * tangent, window[3] * tangent};
}

void apply_hints(Context& context, const Settings& settings) {
  RenderHints& hints = context.scene.hints;
  hints.max_depth = 5;
  hints.samples_per_pixel = 16;
  if (settings.integrator) {
    const Setting& integrator = *settings.integrator;
    check_type(integrator, "Integrator",
               {"path", "volpath", "simplepath", "simplevolpath", "bdpt", "mlt", "sppm",
                "lightpath", "randomwalk", "ambientocclusion", "function"});
    const int depth = integrator.params.integer("maxdepth", 5);
    if (depth < 0)
      fail(integrator.place,
           fmt::format("\"integer maxdepth\" = {}, allowed: not negative", depth));
    hints.max_depth = depth;
    if (is_one_of(integrator.type, {"ambientocclusion", "function"}))
      context.remark(integrator.place,
                     fmt::format("Integrator \"{}\" is not modelled", integrator.type), "path");
    if (integrator.params.boolean("regularize", false))
      context.remark(integrator.place, "\"regularize\" is not modelled", "not regularised");
    integrator.params.ignore({"lightsampler", "samplelights", "samplebsdf", "visualizestrategies",
                              "visualizeweights", "mutationsperpixel", "chains", "bootstrapsamples",
                              "sigma", "largestepprobability", "photonsperiteration", "radius",
                              "seed", "cossample", "maxdistance", "function", "filename",
                              "imagefilename", "skipbad"});
    integrator.params.remark_unused(context, fmt::format("Integrator \"{}\"", integrator.type));
  }
  if (settings.sampler) {
    const Setting& sampler = *settings.sampler;
    check_type(
        sampler, "Sampler",
        {"zsobol", "paddedsobol", "sobol", "halton", "pmj02bn", "independent", "stratified"});
    int samples = 0;
    if (sampler.type == "stratified") {
      const std::int64_t product = std::int64_t{sampler.params.integer("xsamples", 4)} *
                                   sampler.params.integer("ysamples", 4);
      samples = static_cast<int>(std::clamp<std::int64_t>(product, 0, 1 << 30));
    } else {
      samples = sampler.params.integer("pixelsamples", 16);
    }
    if (samples < 1)
      fail(sampler.place, fmt::format("{} samples for each pixel, allowed: 1 or more", samples));
    hints.samples_per_pixel = samples;
    sampler.params.ignore({"seed", "randomization", "jitter"});
    sampler.params.remark_unused(context, fmt::format("Sampler \"{}\"", sampler.type));
  }
  if (settings.filter) {
    const Setting& filter = *settings.filter;
    check_type(filter, "PixelFilter", {"box", "gaussian", "mitchell", "sinc", "triangle"});
    // The default radius of each filter covers at least one pixel; only that of box is exactly one.
    const double otherwise = filter.type == "box" ? 0.5 : 2;
    const double x = filter.params.number("xradius", otherwise);
    const double y = filter.params.number("yradius", otherwise);
    if (filter.type != "box" || x != 0.5 || y != 0.5)
      context.remark(filter.place, fmt::format("PixelFilter \"{}\" is not modelled", filter.type),
                     "a box filter of one pixel");
    filter.params.ignore({"sigma", "B", "C", "tau"});
    filter.params.remark_unused(context, fmt::format("PixelFilter \"{}\"", filter.type));
  }
}

}  // namespace

void apply(Context& context, const Settings& settings) {
  apply_film(context, settings);
  apply_camera(context, settings);
  apply_hints(context, settings);
}

}  // namespace lucerna::pbrt
