#include "server/scene.h"

#include <fmt/format.h>
#include <openssl/evp.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <map>
#include <set>
#include <type_traits>

#include "server/denormals.h"
#include "server/scene_lights.h"

namespace lucerna {
namespace {

std::string digest_of(const std::vector<Asset>& assets) {
  std::string text;
  for (const Asset& a : assets) {
    // Lengths first: no two lists of assets give the same bytes.
    text += fmt::format("{}:{}{}:", a.name.size(), a.name, a.sha256.size());
    text += a.sha256;
  }
  std::array<unsigned char, EVP_MAX_MD_SIZE> hash{};
  unsigned size = 0;
  EVP_Digest(text.data(), text.size(), hash.data(), &size, EVP_sha256(), nullptr);
  std::string hex;
  for (unsigned i = 0; i < size; ++i) hex += fmt::format("{:02x}", hash[i]);
  return hex;
}

// Rounded to a multiple of the least power of two that is not less than the extent.
Vec3<double> origin_for(const Bounds& bounds) {
  if (bounds.empty()) return {};
  const double extent = max_abs(bounds.upper - bounds.lower);
  if (!std::isfinite(extent)) return {};
  const Vec3<double> centre = bounds.lower * 0.5 + bounds.upper * 0.5;
  // A single point has no extent: its own coordinate, rounded to a metre, does.
  const double step = extent > 0 ? std::exp2(std::ceil(std::log2(extent))) : 1;
  const auto snap = [&](double c) { return std::nearbyint(c / step) * step + 0.0; };
  return {snap(centre.x), snap(centre.y), snap(centre.z)};
}

std::uint64_t primitives(const GeometrySet& s) {
  return s.triangles.size() / 3 + s.patches.size() + s.spheres.size() + s.disks.size() +
         s.cylinders.size();
}

// Entries as Embree will hold them: exactly what its float matrices say.
Transform rounded_to_float(const Transform& t) {
  Transform::Matrix m = t.matrix();
  for (auto& row : m)
    for (double& v : row) v = static_cast<float>(v);
  return Transform::from_matrix(m).value_or(t);
}

class Stopwatch {
 public:
  double ms() const {
    return std::chrono::duration<double, std::milli>(Clock::now() - start_).count();
  }

 private:
  using Clock = std::chrono::steady_clock;
  Clock::time_point start_ = Clock::now();
};

}  // namespace

/// Turns a description into a scene, step by step.
class Scene::Builder {
 public:
  Builder(SceneDescription& description, std::stop_token stop)
      : in_(description), stop_(std::move(stop)), scene_(new Scene) {}

  absl::StatusOr<std::shared_ptr<const Scene>> build(const std::string& isa) {
    const DenormalsAreZero denormals;
    if (absl::Status s = check_references(); !s.ok()) return s;
    if (absl::Status s = place(); !s.ok()) return s;
    if (absl::Status s = build_lights(); !s.ok()) return s;
    if (absl::Status s = build_geometry(isa); !s.ok()) return s;
    if (absl::Status s = choose_by_power(); !s.ok()) return s;
    scene_->id_ = digest_of(in_.assets);
    scene_->camera_ = Camera(in_.camera, in_.film, scene_->origin_);
    scene_->hints_ = in_.hints;
    scene_->remarks_ = std::move(in_.remarks);
    scene_->assets_ = std::move(in_.assets);
    return scene_;
  }

 private:
  absl::Status check_references() const {
    const auto check = [&](const ShapeDescription& s) -> absl::Status {
      if (s.material < in_.materials.size()) return absl::OkStatus();
      return located(absl::InvalidArgumentError(fmt::format("material number {}, allowed below {}",
                                                            s.material, in_.materials.size())),
                     s.where);
    };
    for (const auto& s : in_.shapes)
      if (absl::Status status = check(s); !status.ok()) return status;
    for (const auto& o : in_.objects)
      for (const auto& s : o.shapes)
        if (absl::Status status = check(s); !status.ok()) return status;
    for (const auto& i : in_.instances)
      if (i.object >= in_.objects.size())
        return absl::InvalidArgumentError(
            fmt::format("object number {}, allowed below {}", i.object, in_.objects.size()));
    return absl::OkStatus();
  }

  // Bounds, origins and the scene's sphere.
  absl::Status place() {
    std::vector<Bounds> object_bounds(in_.objects.size());
    const auto grow = [](Bounds& bounds, const ShapeDescription& shape) -> absl::Status {
      const absl::StatusOr<Bounds> b = shape_bounds(shape);
      if (!b.ok()) return b.status();
      if (!b->empty()) bounds.add(b->lower), bounds.add(b->upper);
      return absl::OkStatus();
    };
    // What `motion` sweeps, within what rays can be asked about.
    const auto sweep = [](const Bounds& still, const Motion& motion, const SourceLocation& where,
                          Bounds& swept) -> absl::Status {
      if (still.empty()) return absl::OkStatus();
      const auto [lower, upper] = motion.bounds(still.lower, still.upper);
      const double reach = std::fmax(max_abs(lower), max_abs(upper));
      if (!(reach <= Accelerator::kMaxCoordinate))
        return located(absl::InvalidArgumentError(fmt::format(
                           "motion reaching to {} m, allowed are coordinates up to 1e18", reach)),
                       where);
      swept.add(lower), swept.add(upper);
      return absl::OkStatus();
    };
    Bounds world;
    for (const auto& s : in_.shapes) {
      Bounds still;
      if (absl::Status status = grow(s.motion ? still : world, s); !status.ok()) return status;
      if (!s.motion) continue;
      if (absl::Status status = sweep(still, *s.motion, s.where, world); !status.ok())
        return status;
      moving_origins_.push_back(origin_for(still));
    }
    for (std::size_t i = 0; i < in_.objects.size(); ++i) {
      for (const auto& s : in_.objects[i].shapes)
        if (absl::Status status = grow(object_bounds[i], s); !status.ok()) return status;
      object_origins_.push_back(origin_for(object_bounds[i]));
    }
    for (const auto& instance : in_.instances) {
      const Bounds& b = object_bounds[instance.object];
      Bounds placed;
      for (int corner = 0; corner < 8 && !b.empty(); ++corner)
        placed.add(instance.world_from_object.point({corner & 1 ? b.upper.x : b.lower.x,
                                                     corner & 2 ? b.upper.y : b.lower.y,
                                                     corner & 4 ? b.upper.z : b.lower.z}));
      if (instance.motion) {
        if (absl::Status s = sweep(placed, *instance.motion, instance.where, world); !s.ok())
          return s;
      } else if (!placed.empty()) {
        world.add(placed.lower), world.add(placed.upper);
      }
    }
    // A light far off must not coarsen the geometry: the origin is the geometry's, if there is any.
    Bounds with_lights = world;
    for (const auto& light : in_.lights)
      if (const auto box = box_of(light); box && is_finite(box->first) && is_finite(box->second)) {
        Bounds still;
        still.add(box->first), still.add(box->second);
        if (!light.motion) {
          with_lights.add(box->first), with_lights.add(box->second);
        } else if (absl::Status s = sweep(still, *light.motion, light.where, with_lights);
                   !s.ok()) {
          return s;
        }
      }
    scene_->origin_ = origin_for(world.empty() ? with_lights : world);
    if (!with_lights.empty()) {
      const Vec3<double> centre = with_lights.lower * 0.5 + with_lights.upper * 0.5;
      scene_->sphere_ = {centre - scene_->origin_, length(with_lights.upper - centre)};
    }
    return absl::OkStatus();
  }

  /// `light`: about `origin`, from where `motion` leads to the scene's coordinates.
  absl::Status add_light(absl::StatusOr<Light<float>> light, const SourceLocation& where,
                         const Vec3<double>& origin, std::shared_ptr<const Motion> motion) {
    if (!light.ok()) return located(light.status(), where);
    const auto index = static_cast<std::uint32_t>(scene_->lights_.size());
    std::visit(
        [&]<typename L>(const L& l) {
          if constexpr (SeenBeyond<L>) scene_->infinite_lights_.push_back(index);
          scene_->has_visible_lights_ |= !l.kDelta;
        },
        *light);
    float reach_m = 0;
    if (motion)
      std::visit(
          [&](const auto& l) {
            if constexpr (requires { l.shape(); })
              reach_m =
                  std::fmax(max_abs(l.shape().bounds().first), max_abs(l.shape().bounds().second));
          },
          *light);
    scene_->lights_.push_back(
        {index + 1u, *std::move(light), where, std::move(motion), origin, reach_m});
    return absl::OkStatus();
  }

  // Beside the lights and not in them: where all are given RGB, nothing is kept.
  void keep_spectra() {
    const Stopwatch watch;
    std::vector<const std::shared_ptr<const Spectrum>*> given;  // in the order of the lights
    for (const auto& l : in_.lights) given.push_back(&l.spectrum);
    for (const auto& s : in_.shapes)
      if (s.emission) given.push_back(&s.emission->spectrum);
    const auto count =
        std::ranges::count_if(given, [](const auto* spectrum) { return *spectrum != nullptr; });
    if (count == 0) return;
    std::map<const Spectrum*, std::int32_t> numbers;
    std::uint64_t bytes = 0;
    scene_->light_spectra_.reserve(given.size());
    for (const auto* spectrum : given) {
      if (*spectrum == nullptr) {
        scene_->light_spectra_.push_back(-1);
        continue;
      }
      const auto [entry, is_new] =
          numbers.try_emplace(spectrum->get(), static_cast<std::int32_t>(numbers.size()));
      if (is_new) {
        scene_->spectra_.push_back(*spectrum);
        bytes += (*spectrum)->bytes();
      }
      scene_->light_spectra_.push_back(entry->second);
    }
    scene_->spectra_.shrink_to_fit();
    bytes += scene_->spectra_.size() * sizeof scene_->spectra_[0] +
             scene_->light_spectra_.size() * sizeof scene_->light_spectra_[0];
    part("spectra", bytes, watch,
         fmt::format("{} {} of {} {}", numbers.size(), numbers.size() == 1 ? "spectrum" : "spectra",
                     count, count == 1 ? "light" : "lights"));
  }

  absl::Status build_lights() {
    const Stopwatch watch;
    for (const auto& l : in_.lights) {
      Vec3<double> origin = scene_->origin_;
      std::shared_ptr<const Motion> motion;
      if (l.motion) {
        // About itself: its coordinates are then exact wherever it moves to.
        origin = position_of(l).value_or(l.motion->key_frames()[0].position_m);
        motion = about_scene(*l.motion, origin);
      }
      if (absl::Status s = add_light(create_light(l, origin), l.where, origin, std::move(motion));
          !s.ok())
        return s;
    }
    std::size_t moving_shape = 0;
    for (const auto& s : in_.shapes) {
      Vec3<double> origin = scene_->origin_;
      std::shared_ptr<const Motion> motion;
      if (s.motion) {
        // As the surface that rays hit.
        origin = moving_origins_[moving_shape++];
        motion = about_scene(*s.motion, origin);
      }
      if (!s.emission) continue;
      if (absl::Status status =
              add_light(create_area_light(s, origin), s.emission->where, origin, std::move(motion));
          !status.ok())
        return status;
    }
    if (scene_->lights_.empty()) return absl::OkStatus();
    std::uint64_t bytes = scene_->lights_.capacity() * sizeof(SceneLight);
    for (const SceneLight& l : scene_->lights_) bytes += light_bytes(l.light);
    part("lights", bytes, watch, fmt::format("{} lights", scene_->lights_.size()));
    keep_spectra();
    // Pictures are shared between lights: each counts once.
    std::set<const Image*> images;
    for (const SceneLight& l : scene_->lights_)
      if (const Image* picture = picture_of(l.light)) images.insert(picture);
    std::uint64_t image_bytes = 0;
    for (const Image* image : images) image_bytes += image->bytes();
    if (!images.empty())
      part("images", image_bytes, watch, fmt::format("{} pictures of lights", images.size()));
    // What goniometric lights and panels draw directions from is shared between lights: each counts
    // once.
    std::set<std::shared_ptr<const PhotometricWeb>> webs;
    std::set<std::shared_ptr<const IntensityMap>> maps;
    for (const SceneLight& l : scene_->lights_) {
      std::visit(
          [&](const auto& m) {
            if constexpr (requires { m.shape().profile(); }) webs.insert(m.shape().profile().web);
          },
          l.light);
      if (const auto* goniometric = std::get_if<GoniometricLight<float>>(&l.light)) {
        if (goniometric->params().web) webs.insert(goniometric->params().web);
        if (goniometric->params().map) maps.insert(goniometric->params().map);
      }
    }
    std::uint64_t web_bytes = 0, map_bytes = 0;
    for (const auto& web : webs) web_bytes += web->bytes();
    for (const auto& map : maps) map_bytes += map->table_bytes();
    if (!webs.empty())
      part("photometric webs", web_bytes, watch, fmt::format("{} luminaires", webs.size()));
    if (!maps.empty())
      part("intensity maps", map_bytes, watch,
           fmt::format("to draw directions from {} pictures", maps.size()));
    return absl::OkStatus();
  }

  absl::Status build_geometry(const std::string& isa) {
    Stopwatch watch;
    GeometrySet set;
    std::vector<GeometrySet> objects(in_.objects.size() + moving_origins_.size());
    std::vector<GeometryInstance> instances;
    scene_->object_surfaces_.resize(objects.size());
    auto light = static_cast<std::int32_t>(in_.lights.size());
    std::size_t moving_shape = 0;
    for (const auto& s : in_.shapes) {
      if (stop_.stop_requested()) return absl::CancelledError("the build was cancelled");
      const std::int32_t emitter = s.emission ? light++ : -1;
      if (!s.motion) {
        if (absl::Status status = append_shape(s, scene_->origin_, emitter, set, scene_->surfaces_);
            !status.ok())
          return status;
        continue;
      }
      // An object of its own, about its own origin, with one instance.
      const Vec3<double>& origin = moving_origins_[moving_shape];
      const std::size_t object = in_.objects.size() + moving_shape++;
      if (absl::Status status =
              append_shape(s, origin, emitter, objects[object], scene_->object_surfaces_[object]);
          !status.ok())
        return status;
      if (primitives(objects[object]) > 0)
        instances.push_back(
            {static_cast<std::uint32_t>(object), Transform(), about_scene(*s.motion, origin)});
    }
    for (std::size_t i = 0; i < in_.objects.size(); ++i)
      for (const auto& s : in_.objects[i].shapes)
        if (absl::Status status =
                append_shape(s, object_origins_[i], -1, objects[i], scene_->object_surfaces_[i]);
            !status.ok())
          return status;
    for (const auto& i : in_.instances) {
      if (primitives(objects[i.object]) == 0) continue;
      const Transform scene_from_object = Transform::translate(-scene_->origin_) *
                                          i.world_from_object *
                                          Transform::translate(object_origins_[i.object]);
      if (i.motion)
        instances.push_back({i.object, scene_from_object, about_scene(*i.motion, scene_->origin_)});
      else
        instances.push_back({i.object, rounded_to_float(scene_from_object)});
    }
    report_motion(instances);
    scene_->materials_ = std::move(in_.materials);
    report_geometry(set, objects, watch);
    in_.shapes.clear();
    in_.objects.clear();

    watch = Stopwatch();
    const std::size_t instance_count = instances.size();
    auto accelerator =
        Accelerator::build(std::move(set), std::move(objects), std::move(instances), isa, stop_);
    if (!accelerator.ok()) return accelerator.status();
    scene_->accelerator_ = *std::move(accelerator);
    if (scene_->accelerator_->empty()) return absl::OkStatus();
    const std::uint64_t all = scene_->accelerator_->bytes();
    part("bvh", all > read_by_embree_ ? all - read_by_embree_ : 0, watch,
         fmt::format("rays against {} primitives{}", scene_->primitive_count(),
                     instance_count > 0 ? fmt::format(", {} instances", instance_count) : ""));
    return absl::OkStatus();
  }

  std::shared_ptr<const Motion> about_scene(const Motion& motion, const Vec3<double>& from) const {
    return std::make_shared<const Motion>(motion.about(from, scene_->origin_));
  }

  void report_motion(const std::vector<GeometryInstance>& instances) {
    std::uint64_t lights = 0, surfaces = 0, bytes = 0;
    for (const SceneLight& l : scene_->lights_) {
      if (!l.motion) continue;
      ++lights;
      bytes += sizeof(Motion) + l.motion->bytes();
    }
    for (const GeometryInstance& i : instances) {
      if (!i.motion) continue;
      ++surfaces;
      bytes += sizeof(Motion) + i.motion->bytes();
    }
    if (lights + surfaces == 0) return;
    scene_->moves_ = true;
    part("motion", bytes, Stopwatch(),
         fmt::format("{} lights, {} shapes and instances move", lights, surfaces));
  }

  void report_geometry(const GeometrySet& set, const std::vector<GeometrySet>& objects,
                       const Stopwatch& watch) {
    GeometrySet all;  // only counted
    std::array<std::uint64_t, 6> counts{}, bytes{};
    std::uint64_t surface_bytes = scene_->surfaces_.bytes();
    const auto count = [&](const GeometrySet& s) {
      const auto add = [&](int kind, const auto& v, std::size_t per) {
        counts[kind] += v.size() / per;
        bytes[kind] += v.capacity() * sizeof v[0];
      };
      add(0, s.vertices, 1), add(1, s.triangles, 3), add(2, s.patches, 1);
      add(3, s.spheres, 1), add(4, s.disks, 1), add(5, s.cylinders, 1);
    };
    count(set);
    for (const auto& o : objects) count(o);
    for (const auto& t : scene_->object_surfaces_) surface_bytes += t.bytes();
    static constexpr std::array<const char*, 6> kNames{"vertices", "triangles", "patches",
                                                       "spheres",  "disks",     "cylinders"};
    for (int i = 0; i < 6; ++i)
      if (counts[i] > 0) {
        part(kNames[i], bytes[i], watch, fmt::format("{} {}", counts[i], kNames[i]));
        read_by_embree_ += bytes[i];
      }
    if (surface_bytes > 0)
      part("surfaces", surface_bytes + scene_->materials_.capacity() * sizeof(DiffuseMaterial),
           watch, "materials, shading normals and lights of what is hit");
  }

  absl::Status choose_by_power() {
    if (scene_->lights_.size() < 2) return absl::OkStatus();
    const Stopwatch watch;
    // Light from infinitely far arrives at receivers even where the scene is but a point.
    SceneSphere sphere = scene_->sphere_;
    if (!(sphere.radius_m > 0)) sphere.radius_m = 1;
    std::vector<double> lumens;
    for (const SceneLight& l : scene_->lights_) {
      const Power power = visit_light(l, -std::numeric_limits<double>::infinity(),
                                      [&](const auto& m) { return m.power(sphere); });
      // The largest channel, not the luminance: a light of one channel has its share of noise too.
      lumens.push_back(std::fmin(power.lumens.max_component(), 1e300));
    }
    scene_->light_distribution_ = LightDistribution(lumens);
    part("light choice", scene_->light_distribution_.bytes(), watch,
         fmt::format("{} lights to choose from by power", lumens.size()));
    return absl::OkStatus();
  }

  void part(std::string name, std::uint64_t bytes, const Stopwatch& watch, std::string why) {
    scene_->parts_.push_back({std::move(name), bytes, watch.ms(), std::move(why)});
  }

  SceneDescription& in_;
  std::stop_token stop_;
  std::shared_ptr<Scene> scene_;
  std::vector<Vec3<double>> object_origins_;
  std::uint64_t read_by_embree_ = 0;          ///< the geometry's, which its own count holds too
  std::vector<Vec3<double>> moving_origins_;  // of each moving shape
};

absl::StatusOr<std::shared_ptr<const Scene>> Scene::build(SceneDescription description,
                                                          const std::string& isa,
                                                          std::stop_token stop) {
  return Builder(description, std::move(stop)).build(isa);
}

std::optional<std::uint32_t> Scene::find_light(std::uint64_t id) const {
  if (id == 0 || id > lights_.size()) return std::nullopt;
  return static_cast<std::uint32_t>(id - 1);
}

std::uint64_t Scene::shape_count() const {
  std::uint64_t sum = surfaces_.surfaces.size();
  for (const SurfaceTable& o : object_surfaces_) sum += o.surfaces.size();
  return sum;
}

std::uint64_t Scene::primitive_count() const {
  std::uint64_t sum = primitives(accelerator_->scene());
  for (std::uint32_t i = 0; i < object_surfaces_.size(); ++i)
    sum += primitives(accelerator_->object(i));
  return sum;
}

std::string Scene::isa() const { return accelerator_->isa(); }

LightChoice choose_light(const Scene& scene, double u) {
  if (scene.light_distribution().empty()) return {0, 1};
  return scene.light_distribution().choose(u);
}

}  // namespace lucerna
