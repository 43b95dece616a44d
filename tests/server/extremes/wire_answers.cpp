#include "tests/server/extremes/wire_answers.h"

#include <fmt/format.h>
#include <google/protobuf/descriptor.h>
#include <google/protobuf/reflection.h>

#include <cmath>
#include <cstring>
#include <set>

namespace lucerna::testing {
namespace {

using google::protobuf::FieldDescriptor;
using google::protobuf::Message;

std::uint64_t seen = 0;

/// Bytes that do not hold numbers.
bool holds_no_numbers(const FieldDescriptor& field) {
  static const std::set<std::string> names{
      "lucerna.v1.SampleLiResponse.delta",                    // bits
      "lucerna.v1.SampleLiResponse.visible",                  // bits
      "lucerna.v1.TestVisibilityResponse.visible",            // bits
      "lucerna.v1.FindSurfacesResponse.found",                // bits
      "lucerna.v1.Tile.samples",                              // whole numbers
      "lucerna.v1.NamedAsset.sha256",                         // a digest
      "lucerna.v1.FindMissingAssetsResponse.missing_sha256",  // digests
  };
  return names.contains(field.full_name());
}

class Walk {
 public:
  explicit Walk(std::vector<std::string>& wrong) : wrong_(wrong) {}

  void message(const Message& m) {
    const google::protobuf::Reflection& r = *m.GetReflection();
    std::vector<const FieldDescriptor*> fields;
    r.ListFields(m, &fields);
    for (const FieldDescriptor* f : fields) field(m, r, *f);
  }

 private:
  void field(const Message& m, const google::protobuf::Reflection& r, const FieldDescriptor& f) {
    const bool repeated = f.is_repeated();
    switch (f.cpp_type()) {
      case FieldDescriptor::CPPTYPE_FLOAT:
        if (repeated) {
          int i = 0;
          for (const float v : r.GetRepeatedFieldRef<float>(m, &f)) number(f, i++, double{v});
        } else {
          number(f, 0, double{r.GetFloat(m, &f)});
        }
        break;
      case FieldDescriptor::CPPTYPE_DOUBLE:
        if (repeated) {
          int i = 0;
          for (const double v : r.GetRepeatedFieldRef<double>(m, &f)) number(f, i++, v);
        } else {
          number(f, 0, r.GetDouble(m, &f));
        }
        break;
      case FieldDescriptor::CPPTYPE_MESSAGE:
        if (repeated) {
          for (int i = 0; i < r.FieldSize(m, &f); ++i) message(r.GetRepeatedMessage(m, &f, i));
        } else {
          message(r.GetMessage(m, &f));
        }
        break;
      case FieldDescriptor::CPPTYPE_STRING:
        if (f.type() == FieldDescriptor::TYPE_BYTES) bytes(m, r, f);
        break;
      default:
        break;
    }
  }

  void bytes(const Message& m, const google::protobuf::Reflection& r, const FieldDescriptor& f) {
    if (holds_no_numbers(f)) return;
    if (f.is_repeated() || (!holds_doubles(f) && !holds_floats(f))) {
      wrong_.push_back(fmt::format("{}: bytes of unknown meaning", f.full_name()));
      return;
    }
    if (holds_doubles(f))
      numbers<double>(f, r.GetString(m, &f), "doubles");
    else
      numbers<float>(f, r.GetString(m, &f), "floats");
  }

  template <typename Number>
  void numbers(const FieldDescriptor& f, const std::string& plane, const char* what) {
    if (plane.size() % sizeof(Number) != 0)
      wrong_.push_back(
          fmt::format("{}: {} bytes are not whole {}", f.full_name(), plane.size(), what));
    for (std::size_t i = 0; i + sizeof(Number) <= plane.size(); i += sizeof(Number)) {
      Number v = 0;
      std::memcpy(&v, plane.data() + i, sizeof v);
      number(f, static_cast<int>(i / sizeof v), double{v});
    }
  }

  void number(const FieldDescriptor& f, int i, double v) {
    ++seen;
    if (std::isfinite(v) && (v >= 0 || signed_fields().contains(f.full_name()))) return;
    wrong_.push_back(fmt::format("{}[{}] = {}", f.full_name(), i, v));
  }

  std::vector<std::string>& wrong_;
};

}  // namespace

const std::map<std::string, std::string>& signed_fields() {
  static const std::map<std::string, std::string> fields{
      {"lucerna.v1.Vector3.x", "of a point, a direction or a normal"},
      {"lucerna.v1.Vector3.y", "of a point, a direction or a normal"},
      {"lucerna.v1.Vector3.z", "of a point, a direction or a normal"},
      {"lucerna.v1.Points.offsets_m", "coordinates"},
      {"lucerna.v1.SampleLiResponse.wi", "directions"},
      {"lucerna.v1.SampleLiResponse.light_offsets_m", "coordinates"},
      {"lucerna.v1.SampleLiResponse.light_normals", "normals"},
      {"lucerna.v1.SampleLeResponse.directions", "directions"},
      {"lucerna.v1.SampleLeResponse.light_normals", "normals"},
      {"lucerna.v1.FindSurfacesResponse.normals", "normals"},
      {"lucerna.v1.KeyFrame.time_s", "a time of the scene, which may begin before 0"},
      {"lucerna.v1.Tile.sum", "pixels of a filter with negative weights"},
      {"lucerna.v1.Tile.lower", "the same"},
      {"lucerna.v1.Tile.upper", "the same"},
      {"lucerna.v1.Tile.moments", "third moments"},
      {"lucerna.v1.RoundShape.z_min_m", "a coordinate along the shape's own axis"},
      {"lucerna.v1.RoundShape.z_max_m", "a coordinate along the shape's own axis"},
      {"lucerna.v1.SceneSummary.shutter_open_s", "a time of the scene"},
      {"lucerna.v1.SceneSummary.shutter_close_s", "a time of the scene"},
  };
  return fields;
}

bool holds_doubles(const FieldDescriptor& field) {
  return field.full_name() == "lucerna.v1.Tile.sum" ||
         field.full_name() == "lucerna.v1.Tile.deviation" ||
         field.full_name() == "lucerna.v1.Tile.moments";
}

bool holds_floats(const FieldDescriptor& field) {
  return field.full_name() == "lucerna.v1.Tile.lower" ||
         field.full_name() == "lucerna.v1.Tile.upper";
}

std::vector<std::string> wrong_numbers(const Message& message) {
  std::vector<std::string> wrong;
  Walk(wrong).message(message);
  return wrong;
}

std::uint64_t numbers_seen() { return seen; }

}  // namespace lucerna::testing
