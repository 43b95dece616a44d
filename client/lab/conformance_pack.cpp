#include "client/lab/conformance_pack.h"

#include <fmt/format.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <limits>
#include <utility>

#include "client/library/batch_parts.h"
#include "client/library/batches.h"
#include "client/terminal/error.h"
#include "client/terminal/output.h"
#include "lucerna/client/upload.h"

namespace lucerna::conformance {
namespace {

namespace fs = std::filesystem;
using client::Double3;

/// Rows of numbers as CSV.
class Rows {
 public:
  explicit Rows(const std::vector<std::string>& names)
      : text_(fmt::format("{}\n", fmt::join(names, ","))) {}

  template <class... Values>
  void add(const Values&... values) {
    std::string line;
    ((line += fmt::format(",{}", values)), ...);
    text_ += line.substr(1) + "\n";
    ++count_;
  }

  std::uint64_t count() const { return count_; }
  const std::string& text() const { return text_; }

 private:
  std::string text_;
  std::uint64_t count_ = 0;
};

using Floats = google::protobuf::RepeatedField<float>;

bool is_ok(const google::protobuf::RepeatedField<int>& statuses, int i) {
  return i >= statuses.size() || statuses[i] == v1::ITEM_STATUS_OK;
}

/// Asks about the one light of a scene, and writes the tables.
class CaseWriter {
 public:
  CaseWriter(cli::Session& session, std::string scene_id, const v1::Light& light,
             const std::vector<Receiver>& receivers, std::string directory,
             const PackOptions& options)
      : session_(session),
        scene_id_(std::move(scene_id)),
        light_(light),
        directory_(std::move(directory)),
        options_(options) {
    for (const Receiver& receiver : receivers) {
      points_.push_back(receiver.point);
      normals_.push_back(receiver.normal);
    }
  }

  /// Samples of the light, and the densities of their directions.
  void write_samples(CaseSummary* summary) {
    v1::SampleLiRequest request;
    request.set_scene_id(scene_id_);
    request.set_light_id(light_.id());
    *request.mutable_receivers() = client::make_points(points_);
    client::fill(normals_, request.mutable_normals());
    request.mutable_seed()->set_seed(options_.seed);
    request.mutable_accuracy()->set_samples(options_.samples);
    const auto found = answer(client::sample_li_in_batches, request);
    Rows rows({"x", "y", "z", "nx", "ny", "nz", "light", "wx", "wy", "wz", "pdf", "r", "g", "b",
               "distance"});
    std::vector<std::size_t> receivers;
    std::vector<Double3> directions;
    for (int i = 0; i < found.pdf_per_sr_size(); ++i) {
      if (!is_ok(found.status(), i)) continue;
      const std::size_t at = static_cast<std::size_t>(i) / options_.samples;
      const auto &p = points_[at], &n = normals_[at];
      const Floats &w = found.wi(), &value = found.value();
      const double distance = found.distance_m(i) > 0 ? double{found.distance_m(i)}
                                                      : std::numeric_limits<double>::infinity();
      rows.add(p[0], p[1], p[2], n[0], n[1], n[2], light_.id(), w[3 * i], w[3 * i + 1],
               w[3 * i + 2], found.pdf_per_sr(i), value[3 * i], value[3 * i + 1], value[3 * i + 2],
               static_cast<float>(distance));
      receivers.push_back(at);
      directions.push_back({w[3 * i], w[3 * i + 1], w[3 * i + 2]});
    }
    summary->samples = rows.count();
    write("samples.csv", rows);
    // Directions that the light rarely or never samples, spread over the sphere.
    constexpr int kDirections = 32;
    constexpr double kGolden = 0.6180339887498949;
    for (std::size_t at = 0; at < points_.size(); ++at) {
      for (int k = 0; k < kDirections; ++k) {
        const double z = 1 - (2 * k + 1.0) / kDirections;
        const double phi =
            2 * 3.141592653589793 * std::fmod(static_cast<double>(at + 1) * k * kGolden, 1.0);
        const double r = std::sqrt(1 - z * z);
        receivers.push_back(at);
        // As floats, which the server gets.
        directions.push_back({static_cast<float>(r * std::cos(phi)),
                              static_cast<float>(r * std::sin(phi)), static_cast<float>(z)});
      }
    }
    write_densities(receivers, directions, summary);
  }

  void write_emission(CaseSummary* summary) {
    v1::SampleLeRequest request;
    request.set_scene_id(scene_id_);
    request.set_light_id(light_.id());
    request.set_count(options_.samples * static_cast<std::uint32_t>(points_.size()));
    request.mutable_seed()->set_seed(options_.seed);
    const auto found = answer(client::sample_le_in_batches, request);
    Rows rows({"x", "y", "z", "light", "wx", "wy", "wz", "pdf_position", "pdf_direction", "nx",
               "ny", "nz", "r", "g", "b"});
    const v1::Vector3& origin = found.points().origin_m();
    for (int i = 0; i < found.pdf_direction_per_sr_size(); ++i) {
      if (!is_ok(found.status(), i)) continue;
      const Floats &offset = found.points().offsets_m(), &w = found.directions(),
                   &n = found.light_normals(), &value = found.value();
      const int x = 3 * i, y = x + 1, z = x + 2;
      // A light without a surface has no normal.
      const bool surface = n[x] != 0 || n[y] != 0 || n[z] != 0;
      rows.add(origin.x() + double{offset[x]}, origin.y() + double{offset[y]},
               origin.z() + double{offset[z]}, light_.id(), w[x], w[y], w[z],
               found.pdf_position_per_m2(i), found.pdf_direction_per_sr(i), surface ? n[x] : w[x],
               surface ? n[y] : w[y], surface ? n[z] : w[z], value[x], value[y], value[z]);
    }
    summary->emission = rows.count();
    write("emission.csv", rows);
  }

  void write_power() {
    v1::EstimatePowerRequest request;
    request.set_scene_id(scene_id_);
    request.add_light_ids(light_.id());
    const auto found =
        session_.value_or_fail(session_.client().estimate_power(request, session_.call_options()));
    Rows rows({"light", "power", "stderr", "r", "g", "b"});
    for (const v1::LightPower& power : found.lights()) {
      const v1::Rgb& rgb = power.rgb_lm();
      rows.add(power.light_id(), power.power_lm(), power.error_lm(), rgb.r(), rgb.g(), rgb.b());
    }
    write("power.csv", rows);
  }

  void write_irradiance(CaseSummary* summary) {
    v1::EstimateIrradianceRequest request;
    request.set_scene_id(scene_id_);
    *request.mutable_receivers() = client::make_points(points_);
    client::fill(normals_, request.mutable_normals());
    request.set_bounces(0);
    request.mutable_seed()->set_seed(options_.seed);
    request.mutable_accuracy()->set_samples(options_.irradiance_samples);
    const auto found = answer(client::estimate_irradiance_in_batches, request);
    Rows rows({"x", "y", "z", "nx", "ny", "nz", "light", "illuminance", "stderr", "r", "g", "b"});
    Rows intervals({"lower", "upper", "exact"});
    for (int i = 0; i < found.illuminance_lx_size(); ++i) {
      if (!cli::has_answer(found.status(), static_cast<std::size_t>(i))) continue;
      const auto &p = points_[static_cast<std::size_t>(i)],
                 &n = normals_[static_cast<std::size_t>(i)];
      // Samples that found no light bound it.
      const float missed = i < found.zero_bound_lx_size() ? found.zero_bound_lx(i) : 0;
      const float lower = found.lower_lx(i), upper = std::max(found.upper_lx(i), missed);
      const Floats& rgb = found.irradiance_lx();
      rows.add(p[0], p[1], p[2], n[0], n[1], n[2], light_.id(), found.illuminance_lx(i),
               missed > 0 ? missed : found.standard_error_lx(i), rgb[3 * i], rgb[3 * i + 1],
               rgb[3 * i + 2]);
      intervals.add(lower, upper, lower == upper ? 1 : 0);
    }
    summary->irradiances = rows.count();
    write("irradiance.csv", rows);
    write("irradiance_intervals.csv", intervals);
  }

  /// Between receivers, and through the floor.
  void write_visibility(CaseSummary* summary) {
    std::vector<Double3> from, to;
    for (std::size_t i = 0; i < points_.size(); ++i) {
      const Double3& next = points_[(i + 5) % points_.size()];
      from.push_back(points_[i]);
      to.push_back(next);
      from.push_back(points_[i]);
      to.push_back({next[0], next[1], -next[2]});
    }
    v1::TestVisibilityRequest request;
    request.set_scene_id(scene_id_);
    *request.mutable_segments()->mutable_from() = client::make_points(from);
    *request.mutable_segments()->mutable_to() = client::make_points(to);
    const auto found = answer(client::test_visibility_in_batches, request);
    Rows rows({"x", "y", "z", "tx", "ty", "tz", "visible"});
    for (std::size_t i = 0; i < from.size(); ++i) {
      rows.add(from[i][0], from[i][1], from[i][2], to[i][0], to[i][1], to[i][2],
               client::bit(found.visible(), i) ? 1 : 0);
    }
    summary->visibilities = rows.count();
    write("visibility.csv", rows);
  }

 private:
  template <class Request, class Response>
  Response answer(absl::StatusOr<Response> (*in_batches)(const client::Client&, const Request&,
                                                         const client::BatchOptions&),
                  const Request& request) {
    return session_.value_or_fail(
        in_batches(session_.client(), request, {.max_items = 0, .call = session_.call_options()}));
  }

  void write_densities(const std::vector<std::size_t>& receivers,
                       const std::vector<Double3>& directions, CaseSummary* summary) {
    std::vector<Double3> points, normals;
    for (const std::size_t at : receivers) {
      points.push_back(points_[at]);
      normals.push_back(normals_[at]);
    }
    v1::PdfLiRequest request;
    request.set_scene_id(scene_id_);
    request.set_light_id(light_.id());
    *request.mutable_receivers() = client::make_points(points);
    client::fill(normals, request.mutable_normals());
    client::fill(directions, request.mutable_wi());
    const auto found = answer(client::pdf_li_in_batches, request);
    Rows rows({"x", "y", "z", "nx", "ny", "nz", "light", "wx", "wy", "wz", "pdf"});
    for (int i = 0; i < found.pdf_per_sr_size(); ++i) {
      const auto at = static_cast<std::size_t>(i);
      const auto &p = points[at], &n = normals[at], &w = directions[at];
      rows.add(p[0], p[1], p[2], n[0], n[1], n[2], light_.id(), static_cast<float>(w[0]),
               static_cast<float>(w[1]), static_cast<float>(w[2]), found.pdf_per_sr(i));
    }
    summary->densities = rows.count();
    write("densities.csv", rows);
  }

  void write(const std::string& name, const Rows& rows) {
    write_file((fs::path(directory_) / name).string(), rows.text());
  }

  cli::Session& session_;
  std::string scene_id_;
  const v1::Light& light_;
  std::vector<Double3> points_, normals_;
  std::string directory_;
  const PackOptions& options_;
};

[[noreturn]] void fail(const Case& scene, const std::string& what) {
  throw cli::CommandError(cli::kServerRefused, fmt::format("case {}: {}", scene.name, what));
}

/// The name of the light's kind in the contract: "point", "diffuse_area".
std::string kind_of(const v1::Light& light) {
  const auto* kind = v1::Light::GetReflection()->GetOneofFieldDescriptor(
      light, v1::Light::descriptor()->FindOneofByName("kind"));
  return kind == nullptr ? "" : kind->name();
}

}  // namespace

void write_file(const std::string& path, const std::string& content) {
  std::ofstream file(path, std::ios::binary);
  file.write(content.data(), static_cast<std::streamsize>(content.size()));
  file.close();
  if (!file) throw cli::CommandError(cli::kServerRefused, path + ": cannot be written");
}

CaseSummary write_case(cli::Session& session, const Case& scene, const std::string& directory,
                       const PackOptions& options) {
  CaseSummary summary;
  summary.name = scene.name;
  summary.about = scene.about;
  summary.extreme = scene.extreme;
  summary.scene = scene.name + "/" + scene.scene.name;
  const std::string folder = (fs::path(directory) / scene.name).string();
  fs::create_directory(folder);
  const auto put = [&](const CaseFile& file) {
    write_file((fs::path(folder) / file.name).string(), file.content);
  };
  put(scene.scene);
  for (const CaseFile& file : scene.files) put(file);
  const auto loaded = session.value_or_fail(
      client::upload_scene(session.client(), (fs::path(directory) / summary.scene).string(), {},
                           session.call_options()));
  if (loaded.remarks_size() > 0) fail(scene, cli::describe(loaded.remarks(0)));
  const v1::ListLightsResponse lights = cli::list_lights(session, loaded.scene_id());
  if (lights.lights_size() != 1)
    fail(scene, fmt::format("{} lights, expected 1", lights.lights_size()));
  const v1::Light& light = lights.lights(0);
  summary.kind = kind_of(light);
  CaseWriter writer(session, loaded.scene_id(), light, receivers(scene), folder, options);
  writer.write_samples(&summary);
  if (summary.samples == 0) fail(scene, "no receiver gets any light");
  writer.write_emission(&summary);
  writer.write_power();
  writer.write_irradiance(&summary);
  writer.write_visibility(&summary);
  if (!loaded.already_loaded()) {
    v1::ReleaseSceneRequest release;
    release.set_scene_id(loaded.scene_id());
    session.value_or_fail(session.client().release_scene(release, session.call_options()));
  }
  return summary;
}

}  // namespace lucerna::conformance
