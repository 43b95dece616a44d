// Every query of LightingService and RenderService, asked of one scene with random extreme items,
// and what holds for the answers.
#pragma once

#include <map>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "tests/server/extremes/extreme_numbers.h"
#include "tests/server/service_fixture.h"

namespace lucerna::testing {

inline Vec3<double> vec(const v1::Vector3& v) { return {v.x(), v.y(), v.z()}; }

/// Triple `i` of an interleaved array.
inline Vec3<float> triple(const google::protobuf::RepeatedField<float>& v, std::size_t i) {
  const int k = static_cast<int>(3 * i);
  return {v[k], v[k + 1], v[k + 2]};
}

class WireQueries {
 public:
  /// Asks for the scene's lights and its summary, and looks at these answers too.  `batch`: items
  /// of most queries.
  WireQueries(Service& service, ExtremeNumbers& numbers, std::string scene_id, int batch);

  const std::vector<v1::Light>& lights() const { return lights_; }
  /// SampleLi, PdfLi, SampleLe, PdfLe and Le of one light.
  void ask_light(const v1::Light& light);
  /// All queries of the scene as a whole.
  void ask_scene();
  /// Requests with one number that no request may have: each refused as a whole.
  void ask_refused();

  /// How many items were asked.
  std::uint64_t items() const { return items_; }
  /// Everything that did not hold, in words.
  const std::vector<std::string>& failures() const { return failures_; }
  /// How often each query answered an item with each status.
  using Counts = std::map<std::pair<std::string, v1::ItemStatus>, std::uint64_t>;
  const Counts& counts() const { return counts_; }

 private:
  /// What is known of an item before it is asked.
  enum class Item { kGood, kInvalid, kEither };
  using Items = std::vector<Item>;
  using Floats = google::protobuf::RepeatedField<float>;

  void sample_li(const v1::Light* light);
  void pdf_li(const v1::Light& light);
  void sample_le(const v1::Light* light);
  void pdf_le(const v1::Light& light);
  void le(const v1::Light* light);
  void power();
  void visibility();
  void irradiance();
  void tile();

  /// Random points: anywhere, in the scene, and such as lie on lights.
  Items points(int n, v1::Points* out);
  /// Random vectors, into `items` too: those that are no directions are invalid.
  void directions(Floats* out, Items& items, const v1::Points* from = nullptr);
  void normals(Floats* out, Items& items);
  void sample_values(v1::SampleValues* out, int each, bool named, Items& items);
  void wavelengths(google::protobuf::RepeatedField<double>* out);
  void area_sampling(v1::Accuracy* out);
  Vec3<double> place();
  void keep(const Vec3<double>& place);
  void keep(const v1::Points& points);

  template <typename Request, typename Response>
  bool ask(const std::string& name, const Request& request, Response* response,
           grpc::Status (v1::LightingService::Stub::*call)(grpc::ClientContext*, const Request&,
                                                           Response*));
  /// The status of each item, after looking at whether they fit `items` and are of the `typed`
  /// reasons that this query has.
  std::vector<v1::ItemStatus> statuses(const std::string& name,
                                       const google::protobuf::RepeatedField<int>& status,
                                       const Items& items, bool typed);
  void numbers_hold(const std::string& name, const google::protobuf::Message& message);
  void hold(bool what, const std::string& name, std::size_t item, const std::string& words);
  void is_unit(const std::string& name, std::size_t item, const Floats& v);
  void is_zero(const std::string& name, std::size_t item, const Floats& v, std::size_t each);
  void expect(const std::string& name, std::size_t size, std::size_t expected,
              const std::string& field);

  Service& service_;
  ExtremeNumbers& n_;
  std::string scene_id_;
  int batch_;
  std::vector<v1::Light> lights_;
  v1::SceneSummary summary_;
  std::set<std::uint64_t> ids_;
  std::vector<Vec3<double>> places_;  ///< world; of lights, and points on them
  std::uint64_t items_ = 0;
  std::vector<std::string> failures_;
  Counts counts_;
};

}  // namespace lucerna::testing
