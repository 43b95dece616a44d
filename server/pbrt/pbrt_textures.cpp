#include "server/pbrt/pbrt_textures.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <string_view>
#include <utility>

#include "server/pbrt/older_pbrt.h"
#include "server/pbrt/pbrt_images.h"
#include "server/pbrt/pbrt_spectra.h"

namespace lucerna::pbrt {
namespace {

template <typename T>
T choice(const ParameterSet& params, const char* name, const char* otherwise,
         std::initializer_list<std::pair<std::string_view, T>> choices) {
  const std::string given = params.string(name, otherwise);
  std::string allowed;
  for (const auto& [word, value] : choices) {
    if (given == word) return value;
    allowed += fmt::format("{}{}", allowed.empty() ? "" : ", ", word);
  }
  fail(params.find(name, {"string"})->place,
       fmt::format("\"string {}\" = \"{}\", allowed: {}", name, printable(given), allowed));
}

TextureMapping mapping_of(const ParameterSet& params, const Transform& world_from_texture) {
  using Kind = TextureMapping::Kind;
  TextureMapping m;
  m.kind = choice<Kind>(params, "mapping", "uv",
                        {{"uv", Kind::kUv},
                         {"spherical", Kind::kSpherical},
                         {"cylindrical", Kind::kCylindrical},
                         {"planar", Kind::kPlanar}});
  if (m.kind == Kind::kUv) {
    m.scale = {params.number("uscale", 1), params.number("vscale", 1)};
    m.shift = {params.number("udelta", 0), params.number("vdelta", 0)};
    return m;
  }
  m.texture_from_world = world_from_texture.inverse();
  if (m.kind != Kind::kPlanar) return m;
  m.shift = {params.number("udelta", 0), params.number("vdelta", 0)};
  const auto axis = [&](const char* name, const Vec3& otherwise) {
    const auto given = params.vectors(name, "vector3");
    return given.empty() ? otherwise : given.front();
  };
  m.axis_s = axis("v1", m.axis_s);
  m.axis_t = axis("v2", m.axis_t);
  return m;
}

/// "sRGB", "linear" or "gamma 2.2".
Encoding encoding_of(const ParameterSet& params) {
  const std::string given = params.string("encoding", "sRGB");
  if (given == "sRGB") return kSrgb;
  if (given == "linear") return kLinear;
  constexpr std::string_view kGamma = "gamma ";
  double gamma = 0;
  if (given.starts_with(kGamma)) {
    const char* end = given.data() + given.size();
    if (std::from_chars(given.data() + kGamma.size(), end, gamma).ptr == end && gamma > 0 &&
        gamma < 100)
      return {gamma};
  }
  fail(params.find("encoding", {"string"})->place,
       fmt::format("\"string encoding\" = \"{}\", allowed: sRGB, linear, or gamma and a number "
                   "above 0",
                   printable(given)));
}

/// Whether two constants can be combined at once.
bool are_constant(std::initializer_list<bool> constant) {
  return std::ranges::all_of(constant, [](bool c) { return c; });
}

}  // namespace

ColourValue TextureTable::texture(const Parameter& parameter) const {
  for (const char* kind : {"spectrum ", "float "}) {
    const auto found = values_.find(kind + parameter.strings().front());
    if (found != values_.end()) return found->second;
  }
  fail(parameter.place, fmt::format("texture \"{}\" is not defined before this place",
                                    printable(parameter.strings().front())));
}

NumberValue TextureTable::number(const ParameterSet& params, const std::string& name,
                                 double otherwise) const {
  const Parameter* given = params.find(name, {"float", "texture"});
  if (given == nullptr) return {otherwise};
  if (given->type == "float") return {given->numbers().front()};
  const auto found = values_.find("float " + given->strings().front());
  if (found == values_.end())
    fail(given->place, fmt::format("float texture \"{}\" is not defined before this place",
                                   printable(given->strings().front())));
  return {found->second.constant.r, found->second.texture};
}

NumberValue TextureTable::alpha(const ParameterSet& params) const {
  const NumberValue value = number(params, "alpha", 1);
  const Parameter* given = params.find("alpha", {"float", "texture"});
  const bool is_unreadable = given != nullptr && given->type == "texture" &&
                             unreadable_.contains("float " + given->strings().front());
  return is_unreadable ? NumberValue{1} : value;
}

bool TextureTable::is_computed(const ParameterSet& params, const std::string& name) const {
  const Parameter* given = params.find(name, {"float", "texture"});
  return given != nullptr && given->type == "texture" &&
         computed_.contains(given->strings().front());
}

bool TextureTable::hides_only(const ParameterSet& params) const {
  const NumberValue value = alpha(params);
  return value.is_constant() && value.constant == 0 && !is_computed(params, "alpha");
}

ColourValue TextureTable::reflectance(LoadState& context, const ParameterSet& params,
                                      const std::string& name, const ColourValue& otherwise) const {
  const Parameter* parameter = params.find(name, {"rgb", "spectrum", "texture", "float"});
  if (parameter == nullptr) return otherwise;
  if (parameter->type != "texture") return {pbrt::reflectance(context, *parameter)};
  ColourValue value = texture(*parameter);
  if (!value.is_constant()) return value;
  const Rgb& c = value.constant;
  const Rgb clamped{std::clamp(c.r, 0.0, 1.0), std::clamp(c.g, 0.0, 1.0),
                    std::clamp(c.b, 0.0, 1.0)};
  if (clamped != c)
    context.remark(parameter->place, fmt::format("{} is not a valid reflectance", text(c)),
                   fmt::format("clamped to {}", text(clamped)));
  return {clamped};
}

/// A part of a texture.  Those of float textures are not reflectances and may exceed 1.
ColourValue TextureTable::colour(LoadState& context, const ParameterSet& params,
                                 const std::string& name, bool is_float, double otherwise) const {
  if (!is_float) return reflectance(context, params, name, {Rgb(otherwise)});
  const NumberValue value = number(params, name, otherwise);
  return {Rgb(value.constant), value.texture};
}

ImageTexture TextureTable::image(LoadState& context, const ParameterSet& params,
                                 const FilePosition& place, const TextureMapping& mapping) const {
  const Parameter* file = params.find("filename", {"string"});
  if (file == nullptr) fail(place, "Texture \"imagemap\" lacks \"string filename\"");
  ImageTexture t;
  t.mapping = mapping;
  t.image = read_texels(context, *file, encoding_of(params), "grey 0.5; as an alpha, 1");
  t.wrap_s = choice<TextureWrap>(params, "wrap", "repeat",
                                 {{"repeat", TextureWrap::kRepeat},
                                  {"black", TextureWrap::kBlack},
                                  {"clamp", TextureWrap::kClamp},
                                  {"octahedralsphere", TextureWrap::kOctahedral}});
  t.wrap_t = t.wrap_s;
  t.filter = choice<TextureFilter>(params, "filter", "bilinear",
                                   {{"point", TextureFilter::kNearest},
                                    {"bilinear", TextureFilter::kBilinear},
                                    {"trilinear", TextureFilter::kTrilinear},
                                    {"EWA", TextureFilter::kEwa},
                                    {"ewa", TextureFilter::kEwa}});
  t.most_anisotropy = params.number("maxanisotropy", 8);
  if (!(t.most_anisotropy >= 1 && t.most_anisotropy <= 1000))
    fail(params.place_of({"maxanisotropy"}, place),
         fmt::format("\"float maxanisotropy\" = {}, allowed: 1 to 1000", t.most_anisotropy));
  t.scale = params.number("scale", 1);
  t.invert = params.boolean("invert", false);
  return t;
}

void TextureTable::make(LoadState& context, const std::string& name, const std::string& kind,
                        const std::string& type, const ParameterSet& params,
                        const FilePosition& place, const Transform& world_from_texture) {
  if (kind != "float" && kind != "spectrum")
    fail(place,
         fmt::format("texture \"{}\" has type \"{}\", expected \"float\" or \"spectrum\"{}",
                     printable(name), printable(kind), hint_of_older_pbrt("texture type", kind)));
  const auto [it, added] = values_.try_emplace(kind + " " + name, ColourValue{Rgb(0.5)});
  if (!added)
    fail(place, fmt::format("{} texture \"{}\" is already defined", kind, printable(name)));
  // A texture that uses its own name would use itself.
  values_.erase(it);
  const bool is_float = kind == "float";
  const auto part = [&](const char* parameter, double otherwise) {
    return colour(context, params, parameter, is_float, otherwise);
  };
  const auto mapping = [&] { return mapping_of(params, world_from_texture); };
  const auto node = [&](TextureNode made) {
    return ColourValue{{}, context.scene.textures.add(std::move(made))};
  };
  ColourValue value{Rgb(0.5)};
  if (type == "constant") {
    value = part("value", 1);
  } else if (type == "scale") {
    const NumberValue scale = number(params, "scale", 1);
    const ColourValue tex = part("tex", 1), factor{Rgb(scale.constant), scale.texture};
    value = are_constant({tex.is_constant(), factor.is_constant()})
                ? ColourValue{tex.constant * factor.constant}
                : node(ScaleTexture{tex, factor});
    // pbrt-v4 leaves out a factor of 1.
    const bool is_kept = scale.constant != 1 && tex.constant.r != 1;
    if (is_float && (is_kept || is_computed(params, "tex") || is_computed(params, "scale")))
      computed_.insert(name);
  } else if (type == "mix") {
    const NumberValue amount = number(params, "amount", 0.5);
    const ColourValue a = part("tex1", 0), b = part("tex2", 1);
    const double t = amount.constant;
    value = are_constant({a.is_constant(), b.is_constant(), amount.is_constant()})
                ? ColourValue{a.constant * (1 - t) + b.constant * t}
                : node(MixTexture{{a, b}, amount});
    if (is_float) computed_.insert(name);
  } else if (type == "directionmix") {
    const auto given = params.vectors("dir", "vector3");
    const Vec3 direction =
        normalized(world_from_texture.vector(given.empty() ? Vec3{0, 1, 0} : given[0]));
    if (max_abs(direction) == 0 || !is_finite(direction))
      fail(place, "\"vector3 dir\" has no direction");
    value = node(DirectionMixTexture{{part("tex1", 0), part("tex2", 1)}, direction});
  } else if (type == "imagemap") {
    ImageTexture made = image(context, params, place, mapping());
    if (made.image == nullptr) {
      unreadable_.insert(kind + " " + name);
    } else {
      LoadBudget::Share levels(context.meter.budget());
      if (uses_levels(made.filter)) LoadState::require(levels.resize(made.image->bytes()));
      value = {{}, context.scene.textures.add(std::move(made), context.stop)};
      levels.reset();
    }
    context.poll();
  } else if (type == "checkerboard") {
    const int dimension = params.integer("dimension", 2);
    if (dimension != 2 && dimension != 3)
      fail(params.place_of({"dimension"}, place),
           fmt::format("\"integer dimension\" = {}, allowed: 2, 3", dimension));
    TextureMapping m = dimension == 2 ? mapping() : TextureMapping{};
    if (dimension == 3) m.texture_from_world = world_from_texture.inverse();
    value = node(CheckerboardTexture{m, dimension, {part("tex1", 1), part("tex2", 0)}});
  } else if (type == "bilerp") {
    const auto corner = [&](const char* parameter, double otherwise) {
      const ColourValue c = part(parameter, otherwise);
      if (!c.is_constant())
        fail(params.place_of({parameter}, place),
             fmt::format("\"{}\" of a bilerp is a texture, allowed: a constant", parameter));
      return c.constant;
    };
    value = node(BilerpTexture{
        mapping(), {corner("v00", 0), corner("v01", 1), corner("v10", 0), corner("v11", 1)}});
  } else if (type == "dots") {
    value = node(DotsTexture{mapping(), part("inside", 1), part("outside", 0)});
    context.remark(place, fmt::format("the dots of texture \"{}\"", printable(name)),
                   "as many as in pbrt-v4, in other squares");
  } else if (is_one_of(type, {"fbm", "wrinkled", "windy", "marble", "ptex"})) {
    context.remark(place, fmt::format("texture \"{}\" ({}) is not modelled", printable(name), type),
                   "constant 0.5");
    values_.insert_or_assign(kind + " " + name, value);
    return;
  } else {
    fail(place, fmt::format("unknown texture class \"{}\"", printable(type)));
  }
  params.remark_unused(context, fmt::format("texture \"{}\"", printable(name)));
  values_.insert_or_assign(kind + " " + name, value);
}

}  // namespace lucerna::pbrt
