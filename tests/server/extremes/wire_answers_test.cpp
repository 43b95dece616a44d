// Wrong numbers are found in every field of an answer.  Without these tests, a test that finds no
// wrong number would prove nothing.
#include "tests/server/extremes/wire_answers.h"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <google/protobuf/descriptor.h>

#include <cstring>
#include <functional>
#include <limits>
#include <set>

#include "server/rpc/services.h"
#include "tests/server/extremes/wire_methods.h"

namespace lucerna::testing {
namespace {

using google::protobuf::Descriptor;
using google::protobuf::FieldDescriptor;
using google::protobuf::Message;
using ::testing::ElementsAre;
using ::testing::IsEmpty;

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
constexpr double kInfinity = std::numeric_limits<double>::infinity();
const std::vector<double> kNeverRight{kNan, kInfinity, -kInfinity};

template <typename Number = double>
std::string bytes_of(const std::vector<Number>& numbers) {
  std::string bytes(numbers.size() * sizeof(Number), '\0');
  std::memcpy(bytes.data(), numbers.data(), bytes.size());
  return bytes;
}

TEST(WrongNumbers, AreFoundInTheBytesOfTilesAndStreamedPictures) {
  v1::RenderTileResponse tile;
  v1::RenderImageResponse picture;
  for (v1::Tile* t : {tile.mutable_tile(), picture.mutable_tile()}) {
    const Message& whole = t == &tile.tile() ? static_cast<const Message&>(tile) : picture;
    t->set_sum(bytes_of<double>({1, 2, 3}));
    t->set_deviation(bytes_of<double>({0, 0, 0}));
    EXPECT_THAT(wrong_numbers(whole), IsEmpty());
    for (const double v : {kNan, kInfinity}) {
      t->set_sum(bytes_of<double>({1, 2, v}));
      EXPECT_THAT(wrong_numbers(whole), ElementsAre(fmt::format("lucerna.v1.Tile.sum[2] = {}", v)));
      t->set_sum(bytes_of<double>({1, -2, 3}));
      EXPECT_THAT(wrong_numbers(whole), IsEmpty());
    }
    for (const double v : {kNan, kInfinity, -1.0}) {
      t->set_deviation(bytes_of<double>({v, 0, 0}));
      EXPECT_THAT(wrong_numbers(whole),
                  ElementsAre(fmt::format("lucerna.v1.Tile.deviation[0] = {}", v)));
      t->set_deviation(bytes_of<double>({0, 0, 0}));
    }
    for (const double v : {kNan, kInfinity}) {
      t->set_moments(bytes_of<double>({1, v, -1}));
      EXPECT_THAT(wrong_numbers(whole),
                  ElementsAre(fmt::format("lucerna.v1.Tile.moments[1] = {}", v)));
      t->clear_moments();
    }
    const std::string sum = t->sum();
    t->set_sum(sum.substr(1));
    EXPECT_THAT(wrong_numbers(whole),
                ElementsAre("lucerna.v1.Tile.sum: 23 bytes are not whole doubles"));
    t->set_sum(sum);
    for (const float v : {float(kNan), float(kInfinity), -float(kInfinity)}) {
      const std::string one = bytes_of<float>({v});
      t->set_upper(one);
      EXPECT_THAT(wrong_numbers(whole),
                  ElementsAre(fmt::format("lucerna.v1.Tile.upper[0] = {}", v)));
      t->set_upper(one.substr(1));
      EXPECT_THAT(wrong_numbers(whole),
                  ElementsAre("lucerna.v1.Tile.upper: 3 bytes are not whole floats"));
      t->clear_upper();
    }
  }
}

// The code below finds the fields by the types of the answers, not in the answers.

using Path = std::vector<const FieldDescriptor*>;

void for_each_path(const Descriptor& type, Path& path, const std::function<void(const Path&)>& f) {
  for (int i = 0; i < type.field_count(); ++i) {
    path.push_back(type.field(i));
    if (type.field(i)->message_type() != nullptr)
      for_each_path(*type.field(i)->message_type(), path, f);
    else
      f(path);
    path.pop_back();
  }
}

template <typename T>
void put(Message* m, const FieldDescriptor* f, T v,
         void (google::protobuf::Reflection::*set)(Message*, const FieldDescriptor*, T) const,
         void (google::protobuf::Reflection::*add)(Message*, const FieldDescriptor*, T) const) {
  const google::protobuf::Reflection* r = m->GetReflection();
  if (!f->is_repeated()) return (r->*set)(m, f, v);
  (r->*add)(m, f, T{});
  (r->*add)(m, f, v);
}

/// Puts one number at the end of the path: into the second entry of each list on the way.
void plant(Message* m, const Path& path, double v) {
  using R = google::protobuf::Reflection;
  for (std::size_t i = 0; i + 1 < path.size(); ++i) {
    const R* r = m->GetReflection();
    if (path[i]->is_repeated()) {
      r->AddMessage(m, path[i]);
      m = r->AddMessage(m, path[i]);
    } else {
      m = r->MutableMessage(m, path[i]);
    }
  }
  const FieldDescriptor* f = path.back();
  if (f->cpp_type() == FieldDescriptor::CPPTYPE_FLOAT)
    put<float>(m, f, static_cast<float>(v), &R::SetFloat, &R::AddFloat);
  else if (f->cpp_type() == FieldDescriptor::CPPTYPE_DOUBLE)
    put<double>(m, f, v, &R::SetDouble, &R::AddDouble);
  else if (holds_floats(*f))
    m->GetReflection()->SetString(m, f, bytes_of<float>({0, static_cast<float>(v)}));
  else
    m->GetReflection()->SetString(m, f, bytes_of<double>({0, v}));
}

TEST(WrongNumbers, AreFoundInEveryFieldOfEveryAnswer) {
  std::set<std::string> fields, met_signed;
  for (const google::protobuf::MethodDescriptor* method : all_methods()) {
    const Message* prototype =
        google::protobuf::MessageFactory::generated_factory()->GetPrototype(method->output_type());
    Path path;
    for_each_path(*method->output_type(), path, [&](const Path& to) {
      const FieldDescriptor& f = *to.back();
      if (!holds_numbers(f)) return;
      fields.insert(f.full_name());
      const bool is_signed = signed_fields().contains(f.full_name());
      if (is_signed) met_signed.insert(f.full_name());
      const auto wrong = [&](double v) {
        const std::unique_ptr<Message> answer(prototype->New());
        plant(answer.get(), to, v);
        return wrong_numbers(*answer);
      };
      EXPECT_THAT(wrong(1), IsEmpty()) << method->full_name() << " " << f.full_name();
      for (const double v : kNeverRight)
        EXPECT_EQ(wrong(v).size(), 1u) << method->full_name() << " " << f.full_name() << " " << v;
      EXPECT_EQ(wrong(-1).size(), is_signed ? 0u : 1u)
          << method->full_name() << " " << f.full_name();
    });
  }
  EXPECT_GT(fields.size(), 70u);
  // An exception must name a field that exists in some answer.
  for (const auto& [name, why] : signed_fields()) EXPECT_TRUE(met_signed.contains(name)) << name;
}

}  // namespace
}  // namespace lucerna::testing
