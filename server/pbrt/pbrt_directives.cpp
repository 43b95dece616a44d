// Reads the arguments of each directive and passes them to the builder.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <numbers>
#include <string_view>
#include <utility>
#include <variant>

#include "server/pbrt/parse_pbrt.h"

namespace lucerna::pbrt {

bool Parser::transform_directive(const Token& word) {
  const std::string name(word.text);
  const auto numbers = [&](auto& values) {
    for (double& value : values) value = number(name);
  };
  if (name == "Identity") {
    builder_.set_transform(Transform());
  } else if (name == "Translate") {
    std::array<double, 3> n;
    numbers(n);
    concatenate(Transform::translate({n[0], n[1], n[2]}), name, word.place);
  } else if (name == "Scale") {
    std::array<double, 3> n;
    numbers(n);
    const bool regular = n[0] != 0 && n[1] != 0 && n[2] != 0;
    const auto scale = regular ? Transform::scale({n[0], n[1], n[2]}) : std::nullopt;
    if (!scale)
      fail(word.place, fmt::format("Scale {} {} {} has no inverse, allowed: factors other than 0 "
                                   "whose reciprocals a double holds",
                                   n[0], n[1], n[2]));
    builder_.concatenate(*scale);
  } else if (name == "Rotate") {
    std::array<double, 4> n;
    numbers(n);
    const Vec3 axis{n[1], n[2], n[3]};
    if (max_abs(axis) == 0) fail(word.place, "Rotate about the axis 0 0 0, which has no direction");
    concatenate(Transform::rotate(n[0] * std::numbers::pi / 180, axis), name, word.place);
  } else if (name == "LookAt") {
    std::array<double, 9> n;
    numbers(n);
    const auto world_from_camera =
        Transform::look_at({n[0], n[1], n[2]}, {n[3], n[4], n[5]}, {n[6], n[7], n[8]});
    if (!world_from_camera)
      fail(word.place, "LookAt: eye and target coincide, or up is parallel to their difference");
    builder_.concatenate(world_from_camera->inverse());
  } else if (name == "Transform" || name == "ConcatTransform") {
    const auto transform = Transform::from_matrix(matrix(name, word.place));
    if (!transform) fail(word.place, fmt::format("this {} has no inverse", name));
    name == "Transform" ? builder_.set_transform(*transform) : builder_.concatenate(*transform);
  } else if (name == "CoordinateSystem") {
    builder_.coordinate_system(string(name));
  } else if (name == "CoordSysTransform") {
    builder_.coord_sys_transform(string(name), word.place);
  } else if (name == "ActiveTransform") {
    const Token which = next();
    const bool all = which.text == "All";
    if (which.kind != Token::Kind::kWord ||
        (!all && which.text != "StartTime" && which.text != "EndTime"))
      fail(which.place,
           fmt::format("expected All, StartTime or EndTime, found {}", described(which)));
    builder_.active_transform(all || which.text == "StartTime", all || which.text == "EndTime");
  } else if (name == "TransformTimes") {
    std::array<double, 2> n;
    numbers(n);
    builder_.transform_times(n[0], n[1], word.place);
  } else {
    return false;
  }
  return true;
}

bool Parser::settings_directive(const Token& word) {
  const std::string name(word.text);
  constexpr std::array<std::string_view, 6> kOnce{"Camera",  "Film",        "Integrator",
                                                  "Sampler", "PixelFilter", "Accelerator"};
  if (std::find(kOnce.begin(), kOnce.end(), name) != kOnce.end()) {
    const std::string type = string(name);
    builder_.setting(name, type, parameters(), word.place);
  } else if (name == "ColorSpace") {
    const std::string space = string(name);
    const RgbPrimaries* primaries = named_primaries(space);
    if (primaries == nullptr)
      fail(word.place, fmt::format("unknown colour space \"{}\", expected one of srgb rec2020 "
                                   "aces2065-1 dci-p3",
                                   printable(space)));
    builder_.set_colour_space(*primaries == kRec709 ? nullptr : primaries);
  } else if (name == "Option") {
    const std::string option = string(name);
    const Token setting = next();
    if (setting.kind != Token::Kind::kWord && setting.kind != Token::Kind::kString)
      fail(setting.place, fmt::format("expected a value for Option \"{}\", found {}",
                                      printable(option), described(setting)));
    context_.remark(word.place, fmt::format("Option \"{}\" is not modelled", printable(option)),
                    "it changes nothing");
  } else if (name == "Include" || name == "Import") {
    const Token file = next();
    if (file.kind != Token::Kind::kString)
      fail(file.place,
           fmt::format("expected a quoted file name for {}, found {}", name, described(file)));
    if (name == "Import") builder_.import_begin(word.place);
    open(file.place, unescaped(file), name == "Import");
  } else if (name == "WorldBegin") {
    builder_.world_begin(word.place);
  } else {
    return false;
  }
  return true;
}

namespace {

using WithParameters = void (Builder::*)(const std::string&, Parameters, const FilePosition&);
using WithName = void (Builder::*)(const std::string&, const FilePosition&);
using WithoutArguments = void (Builder::*)(const FilePosition&);

struct Directive {
  std::string_view name;
  std::variant<WithParameters, WithName, WithoutArguments> take;
};

// TransformBegin and TransformEnd are the older names in pbrt-v4.
constexpr auto kOfWorld = std::to_array<Directive>({
    {"AttributeBegin", &Builder::attribute_begin},
    {"TransformBegin", &Builder::attribute_begin},
    {"AttributeEnd", &Builder::attribute_end},
    {"TransformEnd", &Builder::attribute_end},
    {"Attribute", &Builder::attribute},
    {"ReverseOrientation", &Builder::reverse_orientation},
    {"Shape", &Builder::shape},
    {"LightSource", &Builder::light_source},
    {"AreaLightSource", &Builder::area_light_source},
    {"Material", &Builder::material},
    {"MakeNamedMaterial", &Builder::make_named_material},
    {"NamedMaterial", &Builder::named_material},
    {"ObjectBegin", &Builder::object_begin},
    {"ObjectEnd", &Builder::object_end},
    {"ObjectInstance", &Builder::object_instance},
    {"MakeNamedMedium", &Builder::make_named_medium},
});

}  // namespace

bool Parser::world_directive(const Token& word) {
  const std::string name(word.text);
  if (const auto* known = std::ranges::find(kOfWorld, name, &Directive::name);
      known != kOfWorld.end()) {
    if (const auto* take = std::get_if<WithoutArguments>(&known->take)) {
      (builder_.**take)(word.place);
      return true;
    }
    const std::string argument = string(name);
    if (const auto* take = std::get_if<WithName>(&known->take))
      (builder_.**take)(argument, word.place);
    else
      (builder_.*std::get<WithParameters>(known->take))(argument, parameters(), word.place);
  } else if (name == "Texture") {
    const std::string texture = string(name);
    const std::string kind = string(name);
    const std::string type = string(name);
    builder_.texture(texture, kind, type, parameters(), word.place);
  } else if (name == "MediumInterface") {
    const std::string inside = string(name);
    std::string outside = inside;
    if (const Token second = next(); second.kind == Token::Kind::kString) {
      outside = unescaped(second);
    } else {
      put_back(second);
    }
    builder_.medium_interface(inside, outside, word.place);
  } else {
    return false;
  }
  return true;
}

}  // namespace lucerna::pbrt
