// Sends every query of LightingService and RenderService about one scene with random extreme items,
// and checks the answers.  The queries are grouped by subject in
// wire_{light,emission,point,render}_queries.cpp; items and checks of answers are in
// wire_items.cpp.
#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <map>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "tests/server/extremes/extreme_numbers.h"
#include "tests/server/extremes/wire_scenes.h"
#include "tests/server/rpc/service_fixture.h"

namespace lucerna::testing {

inline Vec3 vec(const v1::Vector3& v) { return {v.x(), v.y(), v.z()}; }

/// Triple `i` of an interleaved array.
inline Vec3f triple(const google::protobuf::RepeatedField<float>& v, std::size_t i) {
  const int k = static_cast<int>(3 * i);
  return {v[k], v[k + 1], v[k + 2]};
}

/// Bit `i` of one bit an item.
inline bool bit(const std::string& bits, std::size_t i) {
  return (static_cast<unsigned char>(bits[i / 8]) >> (i % 8) & 1) != 0;
}

class WireQueries {
 public:
  /// Requests the lights and the summary of the scene, and checks these answers too.  `batch`:
  /// items of most queries.  One query in 24 has more items than the server computes in one go
  /// (512).
  WireQueries(Service& service, ExtremeNumbers& numbers, const WireScene& scene, int batch);

  const std::vector<v1::Light>& lights() const { return lights_; }
  /// SampleLi, PdfLi, SampleLe, PdfLe and Le of one light.
  void query_light(const v1::Light& light);
  /// All queries about the scene as a whole.
  void query_scene();
  /// The same without those for pictures.
  void query_points();
  /// Requests with one number that is never valid: each must be refused as a whole.
  void send_invalid();
  /// Starts a lease of a random length, lists it, and ends it.  The scene may be gone afterwards.
  void query_lease();
  /// Changes a light by any numbers, and ends the revision.
  void query_edit();

  /// How many items were sent to each method, by its name.
  using ItemsOf = std::map<std::string, std::uint64_t>;
  const ItemsOf& items() const { return items_; }
  /// How many visible segments and samples arrive in part only, and how many pixels are below 0.
  std::uint64_t in_part_count() const { return in_part_; }
  std::uint64_t negative_count() const { return negative_; }
  /// Every condition that did not hold, as text.
  const std::vector<std::string>& failures() const { return failures_; }
  /// How often each query answered an item with each status.
  using Counts = std::map<std::pair<std::string, v1::ItemStatus>, std::uint64_t>;
  const Counts& counts() const { return counts_; }

 private:
  /// What is known about an item before it is sent.
  enum class Item { kGood, kInvalid, kEither };
  using Items = std::vector<Item>;
  using Floats = google::protobuf::RepeatedField<float>;

  void sample_li(const v1::Light* light);
  void estimates(const v1::ReceiverEstimates& r, const Items& items, std::size_t wavelengths);
  void pdf_li(const v1::Light& light);
  void sample_le(const v1::Light* light);
  void pdf_le(const v1::Light& light);
  void le(const v1::Light* light);
  void power(bool all);
  void visibility();
  void irradiance();
  void tile();
  void image();
  void surfaces();

  int batch();
  /// Random points: anywhere, in the scene, and on lights.
  Items points(int n, v1::Points* out);
  /// Random vectors.  Vectors that are not valid directions mark their entry of `items` as invalid.
  void directions(Floats* out, Items& items, const v1::Points* from = nullptr);
  void normals(Floats* out, Items& items);
  void sample_values(v1::SampleValues* out, int each, bool named, Items& items);
  /// `arriving`: for light that arrives, which has no spectrum in coloured media.
  void wavelengths(google::protobuf::RepeatedField<double>* out, bool arriving = false);
  void methods(v1::Accuracy* out);
  void stop_rule(v1::Accuracy* out);
  void target_or_time(v1::Accuracy* out);
  /// Reflections: a few, several, or unset for all.
  template <typename Request>
  void bounces(Request* out);
  /// A moment, the shutter's open interval, or neither.
  template <typename Request>
  void render_time(Request* out);
  Vec3 place();
  void keep(const Vec3& place);
  void keep(const v1::Points& points);

  /// Sends a call and returns its answer, in bounded time.
  template <typename Call>
  static grpc::Status call(Call&& invoke) {
    grpc::ClientContext context;
    context.set_deadline(std::chrono::system_clock::now() + std::chrono::minutes(2));
    return invoke(&context);
  }
  template <typename Request>
  grpc::Status send(const Request& request, ResponseTo<Request>* response) {
    return call([&](grpc::ClientContext* c) { return service_.call(c, request, response); });
  }
  /// Sends a request, and checks its answer as `answered` does.
  template <typename Request>
  bool ask(const Request& request, ResponseTo<Request>* response) {
    std::string name = Request::descriptor()->name();
    name.resize(name.size() - std::string("Request").size());
    return answered(name, send(request, response), request, *response);
  }
  /// Whether the call was answered.  Checks the numbers of the answer first.
  bool answered(const std::string& name, const grpc::Status& status,
                const google::protobuf::Message& request,
                const google::protobuf::Message& response);
  /// Items of a query that has no status for each item.
  void count(const std::string& name, std::uint64_t items) { items_[name] += items; }
  /// The status of each item.  Checks that it fits `items` and is one of the `typed` reasons of
  /// this query.
  std::vector<v1::ItemStatus> statuses(const std::string& name,
                                       const google::protobuf::RepeatedField<int>& status,
                                       const Items& items, bool typed);
  void hold(bool what, const std::string& name, std::size_t item, const std::string& words);
  void is_probability(const std::string& name, std::size_t item, double p);
  void is_light(const std::string& name, std::size_t item, std::uint64_t id);
  void tile_holds(const std::string& name, const v1::Tile& tile, const v1::PixelRect& rect,
                  bool target, bool intervals);
  /// Whether light may arrive in part, so that the answer has a `transmittance`.
  bool in_part(const v1::Accuracy& accuracy) const;
  void are_shares(const std::string& name, const Floats& transmittance, const std::string& visible,
                  std::size_t items, bool in_part);
  void is_unit(const std::string& name, std::size_t item, const Floats& v);
  void is_zero(const std::string& name, std::size_t item, const Floats& v, std::size_t each);
  void expect(const std::string& name, std::size_t size, std::size_t expected,
              const std::string& field);

  Service& service_;
  ExtremeNumbers& n_;
  WireScene scene_;
  std::string scene_id_;
  int batch_;
  std::vector<v1::Light> lights_;
  v1::SceneSummary summary_;
  std::set<std::uint64_t> ids_;
  std::vector<Vec3> places_;  ///< world; of lights, and points on them
  ItemsOf items_;
  std::vector<std::string> failures_;
  Counts counts_;
  std::uint64_t in_part_ = 0, negative_ = 0;
};

template <typename Request>
void WireQueries::bounces(Request* out) {
  switch (n_.below(6)) {
    case 0:
      break;
    case 1:
      out->set_bounces(static_cast<std::uint32_t>(n_.below(32)));
      break;
    default:
      out->set_bounces(static_cast<std::uint32_t>(n_.below(3)));
      break;
  }
}

}  // namespace lucerna::testing
