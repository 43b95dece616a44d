#include "tests/server/extremes/extreme_scenes.h"

#include <fmt/format.h>

#include <functional>
#include <limits>

namespace lucerna::testing {
namespace {

class Writer {
 public:
  Writer(const SceneScale& scale, ExtremeNumbers& numbers) : scale_(scale), n_(numbers) {}

  /// A length of a light or shape [m].
  double size() { return scale_.wild ? wild() : scale_.metres * part(); }
  /// A coordinate [m].
  double coordinate(double offset_m = 0) {
    if (scale_.wild) return n_.chance(0.2) ? 0 : n_.with_sign(wild());
    return offset_m + scale_.metres * n_.uniform(-1, 1);
  }
  std::string point() { return fmt::format("{} {} {}", coordinate(), coordinate(), coordinate()); }

  /// A level of light.  A tenth are 0.  Others are the largest float, or beyond the range of
  /// floats.
  double amount() {
    switch (n_.below(20)) {
      case 0:
      case 1:
        return 0;
      case 2:
        return std::numeric_limits<float>::max();
      case 3:
        return n_.magnitude(1e-300, 1e300);
      default:
        return n_.magnitude();
    }
  }
  std::string level() {
    const auto one = [&] { return amount(); };
    switch (n_.below(6)) {
      case 0:
        return fmt::format(R"("blackbody I" [{}] "float scale" [{}])", n_.magnitude(100, 1e7),
                           one());
      case 1:
        return fmt::format(R"("spectrum I" [300 {} 500 {} 700 {}] "float scale" [{}])",
                           n_.magnitude(1e-6, 1e6), n_.magnitude(1e-6, 1e6),
                           n_.magnitude(1e-6, 1e6), one());
      case 2:
        return fmt::format(R"("rgb I" [{} {} {}])", one(), one(), one());
      default: {
        const double grey = one();
        return fmt::format(R"("rgb I" [{} {} {}])", grey, grey, grey);
      }
    }
  }
  /// The same for lights that call it L.
  std::string radiance() {
    std::string text = level();
    text[text.find(" I\"") + 1] = 'L';
    return text;
  }
  /// For lights with a picture.
  std::string scale() { return fmt::format(R"("float scale" [{}])", amount()); }

  std::string area() {
    return fmt::format(R"(AreaLightSource "diffuse" {} "bool twosided" {} )", radiance(), sides());
  }
  std::string painted() {
    return fmt::format(R"(AreaLightSource "diffuse" {} {} "bool twosided" {} )",
                       file("screen.exr", "picture.pfm"), filter(), sides());
  }
  std::string panel() {
    return fmt::format(R"(AreaLightSource "diffuse" "string profile" "{}" {} "bool twosided" {} )",
                       n_.chance(0.5) ? one_of("downlight.ies", "luminaire.ies")
                                      : one_of("sconce.ldt", "luminaire.ldt"),
                       scale(), sides());
  }
  /// One of two files, and a scale.  The second file is from extreme_files.h.
  std::string file(const char* tame, const char* extreme) {
    return fmt::format(R"("string filename" "{}" {})", one_of(tame, extreme), scale());
  }
  std::string filter() {
    return fmt::format(R"( "string filter" "{}" )", n_.chance(0.5) ? "nearest" : "bilinear");
  }

  /// The reflectance of a shape that emits no light, constant or by a texture.
  std::string material() {
    const std::string rgb =
        fmt::format("[{} {} {}]", n_.uniform(), n_.chance(0.2) ? 0 : 1, n_.magnitude(1e-30, 1));
    if (n_.chance(0.7)) return fmt::format(R"(Material "diffuse" "rgb reflectance" {} )", rgb);
    // Clamped to [0, 1].
    const std::string name = fmt::format("texture {:016x}", n_.seed());
    return fmt::format(R"(Texture "{0}" "spectrum" "scale" "rgb tex" {1} "float scale" [{2}] )"
                       R"(Material "diffuse" "texture reflectance" "{0}" )",
                       name, rgb, n_.magnitude());
  }

  /// A smooth thin pane.  Indices beyond 1e-3 and 1e3 are clamped.
  std::string pane() {
    const double eta =
        n_.chance(0.5) ? 1 + n_.with_sign(n_.magnitude(1e-16, 0.9)) : n_.magnitude(1e-4, 1e4);
    return fmt::format(R"(Material "thindielectric" "float eta" [{}] )", eta);
  }
  /// A medium of a new name that absorbs light.  `colour`: whether its channels may differ.
  std::string medium(const std::string& name, bool colour) {
    const auto one = [&] { return n_.chance(0.5) ? n_.magnitude() : 1 / size(); };
    const double grey = one();
    const std::string rgb = colour
                                ? fmt::format("{} {} {}", n_.chance(0.2) ? 0 : one(), grey, one())
                                : fmt::format("{0} {0} {0}", grey);
    return fmt::format(R"(MakeNamedMedium "{}" "string type" "homogeneous" "rgb sigma_a" [{}] )"
                       R"("rgb sigma_s" [0 0 0] )",
                       name, rgb);
  }
  /// A medium of its own on one side of a shape, which rays may pass.
  std::string boundary() {
    const std::string name = fmt::format("medium {:016x}", n_.seed());
    const char* sides =
        n_.chance(0.5) ? R"(MediumInterface "{0}" "" )" : R"(MediumInterface "" "{0}" )";
    return medium(name, n_.chance(0.5)) + fmt::format(fmt::runtime(sides), name) +
           (n_.chance(0.7) ? R"(Material "interface" )" : "");
  }
  /// Mitchell's filter and the windowed sinc have negative weights.
  std::string pixel_filter() {
    switch (n_.below(5)) {
      case 0:
        return R"(PixelFilter "mitchell")";
      case 1:
        return R"(PixelFilter "sinc")";
      case 2:
        return R"(PixelFilter "box")";
      case 3:
        return R"(PixelFilter "triangle")";
      default:
        return R"(PixelFilter "gaussian")";
    }
  }

  std::string triangle(bool uv = false) {
    return fmt::format(
        R"(Shape "trianglemesh" "point3 P" [{}  {}  {}] "integer indices" [0 1 2] {})", point(),
        point(), point(), uv ? R"("point2 uv" [0 0  1 0  0 1])" : "");
  }
  /// Two triangles in one plane.
  std::string triangles() {
    const double x = size(), y = size();
    return fmt::format(R"(Shape "trianglemesh" "point3 P" [0 0 0  {0} 0 0  {0} {1} 0  0 {1} 0] )"
                       R"("point2 uv" [0 0  1 0  1 1  0 1] "integer indices" [0 1 2  0 2 3])",
                       x, y);
  }
  std::string rectangle() {
    const double x = size(), y = size();
    return fmt::format(R"(Shape "bilinearmesh" "point3 P" [0 0 0  {0} 0 0  0 {1} 0  {0} {1} 0])", x,
                       y);
  }
  std::string patch() {
    return fmt::format(R"(Shape "bilinearmesh" "point3 P" [{}  {}  {}  {}])", point(), point(),
                       point(), point());
  }
  std::string sphere() {
    const double r = size();
    if (n_.chance(0.6)) return fmt::format(R"(Shape "sphere" "float radius" [{}])", r);
    return fmt::format(
        R"(Shape "sphere" "float radius" [{}] "float zmin" [{}] "float zmax" [{}] "float phimax" [{}])",
        r, -r * n_.uniform(), r * n_.uniform(), n_.magnitude(1e-3, 360));
  }
  std::string disk() {
    const double r = size();
    if (n_.chance(0.6)) return fmt::format(R"(Shape "disk" "float radius" [{}])", r);
    return fmt::format(
        R"(Shape "disk" "float radius" [{}] "float innerradius" [{}] "float phimax" [{}] "float height" [{}])",
        r, r * n_.uniform(), n_.magnitude(1e-3, 360), coordinate());
  }
  std::string cylinder() {
    const double z = size();
    return fmt::format(
        R"(Shape "cylinder" "float radius" [{}] "float zmin" [{}] "float zmax" [{}] "float phimax" [{}])",
        size(), -z * n_.uniform(), z, n_.chance(0.7) ? 360 : n_.magnitude(1e-3, 360));
  }

  /// Its place.  One in six also moves.
  std::string placed(const std::string& what) {
    const Vec3& o = scale_.offset_m;
    const Vec3 axis = n_.direction();
    std::string text = fmt::format(
        "AttributeBegin Translate {} {} {} Rotate {} {} {} {} ", coordinate(o.x), coordinate(o.y),
        coordinate(o.z), n_.chance(0.3) ? 0 : n_.uniform(-180, 180), axis.x, axis.y, axis.z);
    if (n_.chance(0.1)) {
      const double s = n_.with_sign(n_.magnitude(1e-3, 1e3));
      text += n_.chance(0.5) ? fmt::format("Scale {} {} {} ", s, s, s)
                             : fmt::format("Scale {} {} {} ", s, n_.magnitude(1e-3, 1e3), 1);
    }
    if (n_.chance(1.0 / 6)) {
      text += fmt::format(
          "ActiveTransform EndTime Translate {} {} {} Rotate {} 0 0 1 ActiveTransform All ",
          coordinate(), coordinate(), coordinate(), n_.uniform(-170, 170));
    }
    return text + what + " AttributeEnd";
  }

  double cone_degrees() { return n_.magnitude(1e-6, 180); }
  std::string cone() {
    const double cone = cone_degrees();
    const double delta = n_.chance(0.3) ? 0 : cone * n_.magnitude(1e-12, 1);
    return fmt::format(R"("float coneangle" [{}] "float conedeltaangle" [{}])", cone, delta);
  }
  std::string to() {
    const Vec3 w = n_.direction();
    const double length = n_.magnitude();
    return fmt::format(R"("point3 from" [0 0 0] "point3 to" [{} {} {}])", w.x * length,
                       w.y * length, w.z * length);
  }
  std::string portal() {
    const double x = size(), y = size(), z = coordinate();
    return fmt::format(R"("point3 portal" [0 0 {2}  {0} 0 {2}  {0} {1} {2}  0 {1} {2}])", x, y, z);
  }
  ExtremeNumbers& numbers() { return n_; }

 private:
  /// Shapes extend to at most 1e30 m.
  double wild() {
    return n_.chance(0.03) ? n_.magnitude(1e-300, 1e300) : n_.magnitude(1e-30, 1e30);
  }
  double part() { return n_.chance(0.3) ? n_.uniform() : n_.magnitude(1e-12, 1); }
  const char* one_of(const char* tame, const char* extreme) {
    return n_.chance(0.5) ? tame : extreme;
  }
  const char* sides() { return n_.chance(0.3) ? "true" : "false"; }

  const SceneScale& scale_;
  ExtremeNumbers& n_;
};

using Make = std::function<std::string(Writer&)>;

const std::vector<std::pair<std::string, Make>>& makers() {
  const auto light = [](const std::string& type, const auto& parameters) -> Make {
    return [=](Writer& w) {
      return w.placed(fmt::format("LightSource \"{}\" {}", type, parameters(w)));
    };
  };
  const auto pictured = [](const char* tame, const char* extreme) {
    return [=](Writer& w) { return w.file(tame, extreme); };
  };
  static const std::vector<std::pair<std::string, Make>> all{
      {"point", light("point", [](Writer& w) { return w.level(); })},
      {"spot", light("spot", [](Writer& w) { return w.level() + w.to() + w.cone(); })},
      {"quadratic spot", light("spot",
                               [](Writer& w) {
                                 return w.level() + w.to() + w.cone() +
                                        R"("string profile" "quadratic")";
                               })},
      {"quartic spot", light("spot",
                             [](Writer& w) {
                               return w.level() + w.to() + w.cone() +
                                      R"("string profile" "quartic")";
                             })},
      {"distant", light("distant", [](Writer& w) { return w.radiance() + w.to(); })},
      {"sun", light("distant",
                    [](Writer& w) {
                      return w.radiance() + w.to() +
                             fmt::format(R"("float angulardiameter" [{}])", w.cone_degrees());
                    })},
      {"infinite", light("infinite", [](Writer& w) { return w.radiance(); })},
      {"sky", light("infinite", pictured("sky.exr", "square.pfm"))},
      {"latlong sky", light("infinite",
                            [](Writer& w) {
                              return w.file("sky.exr", "picture.pfm") + w.filter() +
                                     R"("string mapping" "latlong")";
                            })},
      {"portal", light("infinite", [](Writer& w) { return w.radiance() + w.portal(); })},
      {"sky behind a portal",
       light("infinite", [](Writer& w) { return w.file("sky.exr", "square.pfm") + w.portal(); })},
      {"goniometric", light("goniometric", [](Writer& w) { return w.level(); })},
      {"goniometric map", light("goniometric", pictured("sky.exr", "square.pfm"))},
      {"IES luminaire", light("goniometric", pictured("downlight.ies", "luminaire.ies"))},
      {"EULUMDAT luminaire", light("goniometric", pictured("sconce.ldt", "luminaire.ldt"))},
      {"projection", light("projection",
                           [](Writer& w) {
                             return w.file("slide.exr", "picture.pfm") + w.filter() +
                                    fmt::format(R"("float fov" [{}])",
                                                w.numbers().magnitude(1e-6, 179.999999));
                           })},
      {"even projection", light("projection",
                                [](Writer& w) {
                                  return w.scale() +
                                         fmt::format(R"("float fov" [{}])",
                                                     w.numbers().magnitude(1e-6, 179.999999));
                                })},
      {"beam", light("projection",
                     [](Writer& w) {
                       return w.file("slide.exr", "picture.pfm") + w.filter() +
                              fmt::format(
                                  R"("string projection" "orthographic" "float extent" [{}])",
                                  w.size());
                     })},
      {"even beam", light("projection",
                          [](Writer& w) {
                            return w.scale() +
                                   fmt::format(
                                       R"("string projection" "orthographic" "float extent" [{}])",
                                       w.size());
                          })},
      {"triangle", [](Writer& w) { return w.placed(w.area() + w.triangle()); }},
      {"rectangle", [](Writer& w) { return w.placed(w.area() + w.rectangle()); }},
      {"patch", [](Writer& w) { return w.placed(w.area() + w.patch()); }},
      {"sphere", [](Writer& w) { return w.placed(w.area() + w.sphere()); }},
      {"disk", [](Writer& w) { return w.placed(w.area() + w.disk()); }},
      {"cylinder", [](Writer& w) { return w.placed(w.area() + w.cylinder()); }},
      {"painted triangle", [](Writer& w) { return w.placed(w.painted() + w.triangle(true)); }},
      {"painted triangles", [](Writer& w) { return w.placed(w.painted() + w.triangles()); }},
      {"painted rectangle", [](Writer& w) { return w.placed(w.painted() + w.rectangle()); }},
      {"painted patch", [](Writer& w) { return w.placed(w.painted() + w.patch()); }},
      {"painted sphere", [](Writer& w) { return w.placed(w.painted() + w.sphere()); }},
      {"painted disk", [](Writer& w) { return w.placed(w.painted() + w.disk()); }},
      {"painted cylinder", [](Writer& w) { return w.placed(w.painted() + w.cylinder()); }},
      {"panel of triangles", [](Writer& w) { return w.placed(w.panel() + w.triangles()); }},
      {"panel", [](Writer& w) { return w.placed(w.panel() + w.rectangle()); }},
      {"round panel", [](Writer& w) { return w.placed(w.panel() + w.disk()); }},
  };
  return all;
}

}  // namespace

const std::vector<std::string>& light_kinds() {
  static const std::vector<std::string> kinds = [] {
    std::vector<std::string> names;
    for (const auto& [name, make] : makers()) names.push_back(name);
    return names;
  }();
  return kinds;
}

SceneScale SceneScale::random(ExtremeNumbers& numbers) {
  SceneScale scale;
  switch (numbers.below(8)) {
    case 0:
    case 1:
      scale.wild = true;
      break;
    case 2:  // in metres, at an offset
      scale.offset_m = numbers.direction() * numbers.magnitude(1, 1e16);
      break;
    case 3:
      break;
    default:
      scale.metres = numbers.magnitude(1e-30, 1e30);
      break;
  }
  return scale;
}

SceneLine light_line(const std::string& kind, const SceneScale& scale, ExtremeNumbers& numbers) {
  Writer writer(scale, numbers);
  for (const auto& [name, make] : makers())
    if (name == kind) return {kind, make(writer)};
  return {kind, ""};
}

SceneLine shape_line(const SceneScale& scale, ExtremeNumbers& numbers) {
  Writer w(scale, numbers);
  std::string material = numbers.chance(0.2) ? w.pane() : w.material();
  if (numbers.chance(0.15)) material += w.boundary();
  switch (numbers.below(6)) {
    case 0:
      return {"shape", w.placed(material + w.triangle())};
    case 1:
      return {"shape", w.placed(material + w.sphere())};
    case 2:
      return {"shape", w.placed(material + w.disk())};
    case 3:
      return {"shape", w.placed(material + w.cylinder())};
    case 4:
      return {"shape", w.placed(material + w.patch())};
    default:
      return {"shape", w.placed(material + w.rectangle())};
  }
}

std::vector<std::string> head_lines(const SceneScale& scale, ExtremeNumbers& numbers) {
  Writer w(scale, numbers);
  const Vec3 axis = numbers.direction();
  const double begin = numbers.chance(0.8) ? 0 : numbers.with_sign(numbers.magnitude());
  const Vec3& o = scale.offset_m;
  std::string turn = "# a camera that rests",
              sampler = "# the number of samples is up to the server";
  if (numbers.chance(0.25))
    turn =
        fmt::format("ActiveTransform EndTime Rotate {} 0 1 0 Translate {} 0 0 ActiveTransform All",
                    numbers.uniform(-170, 170), w.coordinate());
  if (numbers.chance(0.5))
    sampler = fmt::format(R"(Sampler "halton" "integer pixelsamples" [{}] )"
                          R"(Integrator "volpath" "integer maxdepth" [{}])",
                          1 + numbers.below(8), numbers.below(8));
  const std::string around = numbers.chance(0.04) ? w.medium("around", numbers.chance(0.5)) +
                                                        R"(MediumInterface "" "around")"
                                                  : "# a camera in the vacuum";
  return {
      w.pixel_filter(),
      around,
      fmt::format(
          R"(Film "rgb" "integer xresolution" [8] "integer yresolution" [8] "float iso" [{}])",
          numbers.chance(0.5) ? 100 : numbers.magnitude(1e-20, 1e20)),
      fmt::format("TransformTimes {} {}", begin,
                  begin + std::fabs(begin) * 0.5 + numbers.magnitude(1e-6, 1e6)),
      fmt::format("Rotate {} {} {} {} Translate {} {} {}", numbers.uniform(-180, 180), axis.x,
                  axis.y, axis.z, -w.coordinate(o.x), -w.coordinate(o.y), -w.coordinate(o.z)),
      turn,
      sampler,
      fmt::format(R"(Camera "perspective" "float fov" [{}] "float shutterclose" [{}])",
                  numbers.magnitude(1e-6, 179.999999), numbers.magnitude()),
      "WorldBegin",
  };
}

}  // namespace lucerna::testing
