#include "server/pbrt/pbrt_camera.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <initializer_list>
#include <numbers>
#include <string_view>
#include <utility>
#include <variant>

#include "server/pbrt/older_pbrt.h"

namespace lucerna::pbrt {
namespace {

void check_type(const ParameterSet& setting, const char* directive,
                std::initializer_list<std::string_view> types) {
  if (!is_one_of(setting.type(), types))
    fail(setting.place(), fmt::format("unknown {} \"{}\", expected one of {}{}", directive,
                                      printable(setting.type()), fmt::join(types, " "),
                                      hint_of_older_pbrt(directive, setting.type())));
}

/// Four values, each pair in ascending order; empty if the parameter is not given.
std::vector<double> bounds_of(const ParameterSet& setting, const char* name) {
  std::vector<double> v = setting.numbers(name);
  if (v.empty()) return v;
  if (v.size() != 4)
    fail(setting.place_of({name}),
         fmt::format("\"{}\" has {} values, expected four: x0 x1 y0 y1", name, v.size()));
  if (v[1] < v[0]) std::swap(v[0], v[1]);
  if (v[3] < v[2]) std::swap(v[2], v[3]);
  return v;
}

/// The part of the film that the picture shows.  As in pbrt-v4, the crop window counts if both are
/// given.
void apply_crop(LoadState& context, const ParameterSet& setting) {
  Film& film = context.scene.film;
  const std::vector<double> window = bounds_of(setting, "cropwindow");
  const std::vector<double> bounds = bounds_of(setting, "pixelbounds");
  if (window.empty() && bounds.empty()) return;
  const auto place = [&](const char* name) { return setting.place_of({name}); };
  FilmCrop crop{};
  if (!bounds.empty()) {
    if (!(bounds[0] >= 0 && bounds[2] >= 0 && bounds[1] <= film.width && bounds[3] <= film.height &&
          bounds[0] < bounds[1] && bounds[2] < bounds[3]))
      fail(place("pixelbounds"),
           fmt::format("\"pixelbounds\" [{}], allowed: not empty and within [0 {} 0 {}]",
                       fmt::join(bounds, " "), film.width, film.height));
    crop = {static_cast<int>(bounds[0]), static_cast<int>(bounds[2]), static_cast<int>(bounds[1]),
            static_cast<int>(bounds[3])};
  }
  if (!window.empty()) {
    if (!bounds.empty())
      context.remark(place("pixelbounds"), "\"pixelbounds\" beside \"cropwindow\"",
                     "\"cropwindow\" counts");
    // In floats, so that the crop has the same pixels as in pbrt-v4.
    const auto pixel = [](double share, int size) {
      return static_cast<int>(std::ceil(static_cast<float>(size) * static_cast<float>(share)));
    };
    const auto text = fmt::format("\"cropwindow\" [{}]", fmt::join(window, " "));
    if (!std::ranges::all_of(window, [](double share) { return share >= 0 && share <= 1; }))
      fail(place("cropwindow"), text + ", allowed: four values in [0, 1]");
    crop = {pixel(window[0], film.width), pixel(window[2], film.height),
            pixel(window[1], film.width), pixel(window[3], film.height)};
    if (crop.x0 >= crop.x1 || crop.y0 >= crop.y1)
      fail(place("cropwindow"),
           fmt::format("{} holds no pixel of a film of {} by {}", text, film.width, film.height));
  }
  if (crop.x0 > 0 || crop.y0 > 0 || crop.x1 < film.width || crop.y1 < film.height) film.crop = crop;
}

/// The filter of a directive that is checked to be one of pbrt's.
PixelFilterParams filter_params(const ParameterSet& setting) {
  const auto with_radius = [&](double radius, auto shape) {
    return PixelFilterParams{{setting.number("xradius", radius), setting.number("yradius", radius)},
                             shape};
  };
  if (setting.type() == "box") return with_radius(0.5, BoxFilter{});
  if (setting.type() == "triangle") return with_radius(2, TriangleFilter{});
  if (setting.type() == "mitchell")
    return with_radius(2,
                       MitchellFilter{setting.number("B", 1.0 / 3), setting.number("C", 1.0 / 3)});
  if (setting.type() == "sinc") return with_radius(4, SincFilter{setting.number("tau", 3)});
  return with_radius(1.5, GaussianFilter{setting.number("sigma", 0.5)});
}

void apply_filter(LoadState& context, const Settings& settings) {
  static const ParameterSet kDefault("gaussian", {}, {}, {});
  const ParameterSet& setting = settings.filter ? *settings.filter : kDefault;
  check_type(setting, "PixelFilter", {"box", "gaussian", "mitchell", "sinc", "triangle"});
  const PixelFilterParams params = filter_params(setting);
  setting.remark_unused(context, fmt::format("PixelFilter \"{}\"", setting.type()));
  if (std::holds_alternative<BoxFilter>(params.shape) && params.radius_px == Vec2{0.5, 0.5}) return;
  auto filter = PixelFilter::create(params);
  if (!filter.ok())
    fail(setting.place(), fmt::format("PixelFilter \"{}\": {}", setting.type(),
                                      std::string(filter.status().message())));
  context.scene.film.filter = *std::move(filter);
}

void apply_film(LoadState& context, const Settings& settings) {
  static const ParameterSet kDefault("rgb", {}, {}, {});
  const ParameterSet& setting = settings.film ? *settings.film : kDefault;
  check_type(setting, "Film", {"rgb", "gbuffer", "spectral"});
  Film& film = context.scene.film;
  film.width = setting.integer("xresolution", film.width);
  film.height = setting.integer("yresolution", film.height);
  constexpr int kMaxPixels = 1 << 16;
  for (const int n : {film.width, film.height})
    if (n < 1 || n > kMaxPixels)
      fail(setting.place(), fmt::format("Film of {} by {} pixels, allowed 1 to {} each way",
                                        film.width, film.height, kMaxPixels));
  if (setting.type() != "rgb")
    context.remark(setting.place(), fmt::format("Film \"{}\" is not modelled", setting.type()),
                   "linear RGB");

  const std::string sensor = setting.string("sensor", "cie1931");
  if (sensor != "cie1931")
    context.remark(setting.place(), fmt::format("sensor \"{}\" is not modelled", printable(sensor)),
                   "cie1931");
  if (setting.number("whitebalance", 0) != 0)
    context.remark(setting.place(), "\"whitebalance\" is not modelled", "none");
  if (setting.number("maxcomponentvalue"))
    context.remark(setting.place(), "\"maxcomponentvalue\" is not modelled",
                   "values are not clipped");
  // The imaging ratio of pbrt-v4: exposure time times ISO speed over 100.
  double exposure_s = 1;
  context.scene.hints.shutter_close_s = 1;
  if (settings.camera) {
    const ParameterSet& camera = *settings.camera;
    RenderHints& hints = context.scene.hints;
    hints.shutter_open_s = camera.number("shutteropen", 0);
    hints.shutter_close_s = camera.number("shutterclose", 1);
    exposure_s = hints.shutter_close_s - hints.shutter_open_s;
    if (!(exposure_s > 0))
      fail(settings.camera->place(),
           fmt::format("the shutter is open for {} s, allowed: more than 0", exposure_s));
  }
  const double iso = setting.number("iso", 100);
  if (!(iso > 0)) fail(setting.place(), fmt::format("\"float iso\" = {}, allowed: above 0", iso));
  film.scale = exposure_s * iso / 100;
  // The fourth power of a pixel's value must fit a double, for the intervals of pixels.
  constexpr double kMostScale = 1e30;
  if (!(film.scale > 0 && film.scale <= kMostScale)) {
    const ParameterSet& scaled =
        settings.camera && !setting.number("iso") ? *settings.camera : setting;
    fail(scaled.place_of({"iso"}),
         fmt::format("\"float iso\" = {} and a shutter open for {} s multiply pixels by {}, "
                     "allowed: more than 0, at most {:g}",
                     iso, exposure_s, film.scale, kMostScale));
  }

  apply_crop(context, setting);
  setting.ignore({"filename", "savefp16", "diagonal", "coordinatesystem", "nbuckets", "lambdamin",
                  "lambdamax"});
  setting.remark_unused(context, fmt::format("Film \"{}\"", setting.type()));
}

/// The parameter, which must be within [low, high].
double number_within(const ParameterSet& setting, const char* name, double otherwise, double low,
                     double high) {
  return setting.number(
      name, otherwise, [&](double v) { return v >= low && v <= high; },
      fmt::format(", allowed [{:g}, {:g}]", low, high));
}

/// x0 x1 y0 y1 of the screen.  Without a window, its shorter side spans -1 to 1.
std::vector<double> screen_of(const ParameterSet& setting, double aspect) {
  constexpr double kMostAspect = 1e6, kMostScreen = 1e9;
  aspect = number_within(setting, "frameaspectratio", aspect, 1 / kMostAspect, kMostAspect);
  std::vector<double> window = setting.numbers("screenwindow");
  if (window.empty()) {
    const double x = std::max(aspect, 1.0), y = std::max(1 / aspect, 1.0);
    return {-x, x, -y, y};
  }
  const auto fits = [](double v) { return std::fabs(v) <= kMostScreen; };
  if (window.size() != 4 || !(window[0] < window[1]) || !(window[2] < window[3]) ||
      !std::all_of(window.begin(), window.end(), fits))
    fail(setting.place_of({"screenwindow"}),
         fmt::format("\"float screenwindow\" [{}], expected four values x0 < x1, y0 < y1 in "
                     "[-{:g}, {:g}]",
                     fmt::join(window, " "), kMostScreen, kMostScreen));
  return window;
}

/// A perspective or orthographic camera.
void apply_lens_and_screen(LoadState& context, const ParameterSet& setting) {
  CameraDescription& camera = context.scene.camera;
  double fov = 90;
  if (setting.type() == "perspective")
    fov = setting.number(
        "fov", 90, [](double f) { return f > 0 && f < 180; }, " degrees, allowed (0, 180)");
  const auto window =
      screen_of(setting, static_cast<double>(context.scene.film.width) / context.scene.film.height);
  camera.lens_radius = number_within(setting, "lensradius", 0, 0, 1e6);
  camera.focal_distance = number_within(setting, "focaldistance", 1e6, 1e-6, 1e30);
  const double unit =
      camera.projection == Projection::kOrthographic ? 1 : std::tan(fov * std::numbers::pi / 360);
  camera.screen_min = {window[0] * unit, window[2] * unit};
  camera.screen_max = {window[1] * unit, window[3] * unit};
}

Projection spherical_projection(const ParameterSet& setting) {
  const std::string mapping = setting.string("mapping", "equalarea");
  if (mapping == "equirectangular") return Projection::kEquirectangular;
  if (mapping != "equalarea")
    fail(setting.place_of({"mapping"}),
         fmt::format("unknown mapping \"{}\", expected one of equalarea equirectangular",
                     printable(mapping)));
  return Projection::kEqualArea;
}

void apply_camera(LoadState& context, const Settings& settings) {
  static const ParameterSet kDefault("perspective", {}, {}, {});
  const ParameterSet& setting = settings.camera ? *settings.camera : kDefault;
  check_type(setting, "Camera", {"perspective", "orthographic", "realistic", "spherical"});
  CameraDescription& camera = context.scene.camera;
  camera.world_from_camera = settings.camera_from_world.inverse();
  camera.motion = settings.camera_motion;
  if (setting.type() == "realistic") {
    context.remark(setting.place(), "Camera \"realistic\" is not modelled",
                   "a perspective camera, 90 degrees across the shorter side");
    apply_lens_and_screen(context, ParameterSet("perspective", {}, {}, setting.place()));
    return;
  }
  if (setting.type() == "spherical") {
    camera.projection = spherical_projection(setting);
    // These have no effect in pbrt-v4 either.
    setting.ignore({"lensradius", "focaldistance", "frameaspectratio", "screenwindow"});
  } else {
    if (setting.type() == "orthographic") camera.projection = Projection::kOrthographic;
    apply_lens_and_screen(context, setting);
  }
  setting.ignore({"shutteropen", "shutterclose"});
  setting.remark_unused(context, fmt::format("Camera \"{}\"", setting.type()));
}

void apply_hints(LoadState& context, const Settings& settings) {
  RenderHints& hints = context.scene.hints;
  hints.max_depth = 5;
  hints.samples_per_pixel = 16;
  if (settings.integrator) {
    const ParameterSet& integrator = *settings.integrator;
    check_type(integrator, "Integrator",
               {"path", "volpath", "simplepath", "simplevolpath", "bdpt", "mlt", "sppm",
                "lightpath", "randomwalk", "ambientocclusion", "function"});
    const int depth = integrator.integer("maxdepth", 5);
    if (depth < 0)
      fail(integrator.place(),
           fmt::format("\"integer maxdepth\" = {}, allowed: not negative", depth));
    hints.max_depth = depth;
    if (is_one_of(integrator.type(), {"ambientocclusion", "function"}))
      context.remark(integrator.place(),
                     fmt::format("Integrator \"{}\" is not modelled", integrator.type()), "path");
    if (integrator.boolean("regularize", false))
      context.remark(integrator.place(), "\"regularize\" is not modelled", "not regularised");
    integrator.ignore({"lightsampler", "samplelights", "samplebsdf", "visualizestrategies",
                       "visualizeweights", "mutationsperpixel", "chains", "bootstrapsamples",
                       "sigma", "largestepprobability", "photonsperiteration", "radius", "seed",
                       "cossample", "maxdistance", "function", "filename", "imagefilename",
                       "skipbad"});
    integrator.remark_unused(context, fmt::format("Integrator \"{}\"", integrator.type()));
  }
  if (settings.sampler) {
    const ParameterSet& sampler = *settings.sampler;
    check_type(
        sampler, "Sampler",
        {"zsobol", "paddedsobol", "sobol", "halton", "pmj02bn", "independent", "stratified"});
    int samples = 0;
    if (sampler.type() == "stratified") {
      const std::int64_t product =
          std::int64_t{sampler.integer("xsamples", 4)} * sampler.integer("ysamples", 4);
      samples = static_cast<int>(std::clamp<std::int64_t>(product, 0, 1 << 30));
    } else {
      samples = sampler.integer("pixelsamples", 16);
    }
    if (samples < 1)
      fail(sampler.place(), fmt::format("{} samples for each pixel, allowed: 1 or more", samples));
    hints.samples_per_pixel = samples;
    sampler.ignore({"seed", "randomization", "jitter"});
    sampler.remark_unused(context, fmt::format("Sampler \"{}\"", sampler.type()));
  }
}

}  // namespace

void apply(LoadState& context, const Settings& settings) {
  apply_film(context, settings);
  apply_filter(context, settings);
  apply_camera(context, settings);
  apply_hints(context, settings);
}

}  // namespace lucerna::pbrt
