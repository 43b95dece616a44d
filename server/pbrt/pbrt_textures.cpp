#include "server/pbrt/pbrt_textures.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <string_view>
#include <utility>

#include "server/pbrt/older_pbrt.h"
#include "server/pbrt/pbrt_images.h"
#include "server/pbrt/pbrt_spectra.h"

namespace lucerna::pbrt {
namespace {

TextureMapping mapping_of(const ParameterSet& params, const Transform& world_from_texture) {
  using Kind = TextureMapping::Kind;
  TextureMapping m;
  m.kind = params.choice<Kind>("mapping", "uv",
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
  return {clamped_reflectance(context, parameter->place, "", value.constant)};
}

/// Makes the value of one Texture directive.  Each function is that of a class of textures.
class TextureTable::Maker {
 public:
  Maker(TextureTable& table, LoadState& context, const std::string& name, bool is_float,
        const ParameterSet& params, const Transform& world_from_texture)
      : table_(table),
        context_(context),
        name_(name),
        is_float_(is_float),
        params_(params),
        world_from_texture_(world_from_texture) {}

  ColourValue constant() { return part("value", 1); }

  ColourValue scale() {
    const NumberValue scale = table_.number(params_, "scale", 1);
    const ColourValue tex = part("tex", 1), factor{Rgb(scale.constant), scale.texture};
    // pbrt-v4 leaves out a factor of 1.
    const bool is_kept = scale.constant != 1 && tex.constant.r != 1;
    if (is_float_ &&
        (is_kept || table_.is_computed(params_, "tex") || table_.is_computed(params_, "scale")))
      table_.computed_.insert(name_);
    if (tex.is_constant() && factor.is_constant()) return {tex.constant * factor.constant};
    return node(ScaleTexture{tex, factor});
  }

  ColourValue mix() {
    const NumberValue amount = table_.number(params_, "amount", 0.5);
    const ColourValue a = part("tex1", 0), b = part("tex2", 1);
    const double t = amount.constant;
    if (is_float_) table_.computed_.insert(name_);
    if (a.is_constant() && b.is_constant() && amount.is_constant())
      return {a.constant * (1 - t) + b.constant * t};
    return node(MixTexture{{a, b}, amount});
  }

  ColourValue direction_mix() {
    const auto given = params_.vectors("dir", "vector3");
    const Vec3 direction =
        normalized(world_from_texture_.vector(given.empty() ? Vec3{0, 1, 0} : given[0]));
    if (max_abs(direction) == 0 || !is_finite(direction))
      fail(params_.place(), "\"vector3 dir\" has no direction");
    return node(DirectionMixTexture{{part("tex1", 0), part("tex2", 1)}, direction});
  }

  ColourValue picture() {
    ImageTexture made = image();
    ColourValue value{Rgb(0.5)};
    if (made.image == nullptr) {
      table_.unreadable_.insert((is_float_ ? "float " : "spectrum ") + name_);
    } else {
      LoadBudget::Share levels(context_.meter.budget());
      if (uses_levels(made.filter)) LoadState::require(levels.resize(made.image->bytes()));
      value = {{}, context_.scene.textures.add(std::move(made), context_.stop)};
    }
    context_.poll();
    return value;
  }

  ColourValue checkerboard() {
    const int dimension = params_.integer("dimension", 2);
    if (dimension != 2 && dimension != 3)
      fail(params_.place_of({"dimension"}),
           fmt::format("\"integer dimension\" = {}, allowed: 2, 3", dimension));
    TextureMapping m = dimension == 2 ? mapping() : TextureMapping{};
    if (dimension == 3) m.texture_from_world = world_from_texture_.inverse();
    return node(CheckerboardTexture{m, dimension, {part("tex1", 1), part("tex2", 0)}});
  }

  ColourValue bilerp() {
    const auto corner = [&](const char* parameter, double otherwise) {
      const ColourValue c = part(parameter, otherwise);
      if (!c.is_constant())
        fail(params_.place_of({parameter}),
             fmt::format("\"{}\" of a bilerp is a texture, allowed: a constant", parameter));
      return c.constant;
    };
    return node(BilerpTexture{
        mapping(), {corner("v00", 0), corner("v01", 1), corner("v10", 0), corner("v11", 1)}});
  }

  ColourValue dots() {
    const ColourValue value = node(DotsTexture{mapping(), part("inside", 1), part("outside", 0)});
    context_.remark(params_.place(), fmt::format("the dots of texture \"{}\"", printable(name_)),
                    "as many as in pbrt-v4, in other squares");
    return value;
  }

 private:
  /// Parts of float textures are not reflectances and may exceed 1.
  ColourValue part(const char* parameter, double otherwise) const {
    if (!is_float_) return table_.reflectance(context_, params_, parameter, {Rgb(otherwise)});
    const NumberValue value = table_.number(params_, parameter, otherwise);
    return {Rgb(value.constant), value.texture};
  }
  TextureMapping mapping() const { return mapping_of(params_, world_from_texture_); }
  ColourValue node(TextureNode made) { return {{}, context_.scene.textures.add(std::move(made))}; }

  ImageTexture image() const {
    ImageTexture t;
    t.mapping = mapping();
    const Parameter* file = params_.find("filename", {"string"});
    if (file == nullptr) fail(params_.place(), "Texture \"imagemap\" lacks \"string filename\"");
    t.image = read_texels(context_, *file, encoding_of(params_), "grey 0.5; as an alpha, 1");
    t.wrap_s = params_.choice<TextureWrap>("wrap", "repeat",
                                           {{"repeat", TextureWrap::kRepeat},
                                            {"black", TextureWrap::kBlack},
                                            {"clamp", TextureWrap::kClamp},
                                            {"octahedralsphere", TextureWrap::kOctahedral}});
    t.wrap_t = t.wrap_s;
    t.filter = params_.choice<TextureFilter>("filter", "bilinear",
                                             {{"point", TextureFilter::kNearest},
                                              {"bilinear", TextureFilter::kBilinear},
                                              {"trilinear", TextureFilter::kTrilinear},
                                              {"EWA", TextureFilter::kEwa},
                                              {"ewa", TextureFilter::kEwa}});
    t.most_anisotropy = params_.number(
        "maxanisotropy", 8, [](double n) { return n >= 1 && n <= 1000; }, ", allowed: 1 to 1000");
    t.scale = params_.number("scale", 1);
    t.invert = params_.boolean("invert", false);
    return t;
  }

  TextureTable& table_;
  LoadState& context_;
  const std::string& name_;
  bool is_float_;
  const ParameterSet& params_;
  const Transform& world_from_texture_;
};

void TextureTable::make(LoadState& context, const std::string& name, const std::string& kind,
                        const ParameterSet& params, const Transform& world_from_texture) {
  struct Class {
    std::string_view name;
    ColourValue (Maker::*make)();
  };
  static constexpr auto kClasses = std::to_array<Class>({{"constant", &Maker::constant},
                                                         {"scale", &Maker::scale},
                                                         {"mix", &Maker::mix},
                                                         {"directionmix", &Maker::direction_mix},
                                                         {"imagemap", &Maker::picture},
                                                         {"checkerboard", &Maker::checkerboard},
                                                         {"bilerp", &Maker::bilerp},
                                                         {"dots", &Maker::dots}});
  const FilePosition& place = params.place();
  const std::string& type = params.type();
  if (kind != "float" && kind != "spectrum")
    fail(place,
         fmt::format("texture \"{}\" has type \"{}\", expected \"float\" or \"spectrum\"{}",
                     printable(name), printable(kind), hint_of_older_pbrt("texture type", kind)));
  // A texture that uses its own name would use itself, so it is not in the table yet.
  if (values_.contains(kind + " " + name))
    fail(place, fmt::format("{} texture \"{}\" is already defined", kind, printable(name)));
  ColourValue value{Rgb(0.5)};
  if (const auto* known = std::ranges::find(kClasses, std::string_view(type), &Class::name);
      known != kClasses.end()) {
    Maker maker(*this, context, name, kind == "float", params, world_from_texture);
    value = (maker.*known->make)();
    params.remark_unused(context, fmt::format("texture \"{}\"", printable(name)));
  } else if (is_one_of(type, {"fbm", "wrinkled", "windy", "marble", "ptex"})) {
    context.remark(place, fmt::format("texture \"{}\" ({}) is not modelled", printable(name), type),
                   "constant 0.5");
  } else {
    fail(place, fmt::format("unknown texture class \"{}\"", printable(type)));
  }
  values_.insert_or_assign(kind + " " + name, value);
}

}  // namespace lucerna::pbrt
