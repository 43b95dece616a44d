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

/// Coordinates, directions, normals and times; nothing else has a sign.
bool may_be_negative(const FieldDescriptor& field) {
  static const std::set<std::string> names{
      "lucerna.v1.Vector3.x",
      "lucerna.v1.Vector3.y",
      "lucerna.v1.Vector3.z",
      "lucerna.v1.Points.offsets_m",
      "lucerna.v1.SampleLiResponse.wi",
      "lucerna.v1.SampleLiResponse.light_offsets_m",
      "lucerna.v1.SampleLiResponse.light_normals",
      "lucerna.v1.SampleLeResponse.directions",
      "lucerna.v1.SampleLeResponse.light_normals",
      "lucerna.v1.KeyFrame.time_s",
      "lucerna.v1.KeyFrame.angle_rad",
      "lucerna.v1.RoundShape.z_min_m",
      "lucerna.v1.RoundShape.z_max_m",
      "lucerna.v1.SceneSummary.shutter_open_s",
      "lucerna.v1.SceneSummary.shutter_close_s",
  };
  return names.contains(field.full_name());
}

/// Bytes that hold doubles.
bool holds_doubles(const FieldDescriptor& field) {
  return field.full_name() == "lucerna.v1.Tile.sum" ||
         field.full_name() == "lucerna.v1.Tile.deviation";
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
        if (!repeated && holds_doubles(f)) doubles(f, r.GetString(m, &f));
        break;
      default:
        break;
    }
  }

  void doubles(const FieldDescriptor& f, const std::string& bytes) {
    for (std::size_t i = 0; i + sizeof(double) <= bytes.size(); i += sizeof(double)) {
      double v = 0;
      std::memcpy(&v, bytes.data() + i, sizeof v);
      number(f, static_cast<int>(i / sizeof v), v);
    }
  }

  void number(const FieldDescriptor& f, int i, double v) {
    ++seen;
    if (std::isfinite(v) && (v >= 0 || may_be_negative(f))) return;
    wrong_.push_back(fmt::format("{}[{}] = {}", f.full_name(), i, v));
  }

  std::vector<std::string>& wrong_;
};

}  // namespace

std::vector<std::string> wrong_numbers(const Message& message) {
  std::vector<std::string> wrong;
  Walk(wrong).message(message);
  return wrong;
}

std::uint64_t numbers_seen() { return seen; }

}  // namespace lucerna::testing
