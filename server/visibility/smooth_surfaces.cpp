#include "server/visibility/smooth_surfaces.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "lights/maths/stop_poll.h"
#include "server/materials/material.h"
#include "server/scene/light_at_time.h"
#include "server/visibility/face_plane.h"
#include "server/visibility/primitive_faces.h"

namespace lucerna {
namespace {

/// A shape with faces in more planes than this counts as curved.  In a scene with more planes that
/// refract, all of these do: their sequences are many, and each path must be solved.
constexpr std::size_t kMostPlanes = 1024, kMostRefractingPlanes = 16;
/// Of all parts together.
constexpr std::size_t kMostParts = 4096, kMostFaces = 1 << 22;

/// The place of the first smooth surface.
SourceLocation first_smooth(const Scene& scene) {
  if (!scene.geometry().surfaces().smooth.empty())
    return scene.geometry().surfaces().smooth[0].where;
  for (std::uint32_t i = 0; i < scene.geometry().accelerator().instance_count(); ++i)
    if (const auto& own =
            scene.geometry().surfaces_of(scene.geometry().accelerator().instance(i).object).smooth;
        !own.empty())
      return own[0].where;
  return {};
}

}  // namespace

std::pair<double, double> SmoothPart::heights_over(const SmoothPart& other) const {
  const double middle_m = dot(other.n, middle - other.middle);
  const double reach =
      is_sphere ? radius_m : std::fabs(dot(other.n, half_u)) + std::fabs(dot(other.n, half_v));
  return {middle_m - reach, middle_m + reach};
}

bool SmoothPart::may_contain(const Vec3& p) const {
  constexpr double kMargin = 1.001;
  const auto within = [&](const Vec3& half) {
    const double size2 = dot(half, half);
    return std::fabs(dot(p - middle, half)) <= kMargin * size2;
  };
  return within(half_u) && within(half_v);
}

/// Collects the parts of one scene.
class SmoothSurfaces::Collector {
 public:
  Collector(const Scene& scene, SmoothSurfaces& to) : scene_(scene), to_(to) {}

  void collect() {
    const std::span<const Material> materials = scene_.geometry().materials();
    // Without a list of materials, all are diffuse.
    to_.has_rough_surfaces_ = materials.empty() && !scene_.geometry().empty();
    for (std::uint32_t m = 0; m < materials.size(); ++m)
      to_.has_rough_surfaces_ |= traits_of(m).is_rough;
    add_all();
    const auto refracting = std::ranges::count_if(
        planes_, [](const FacePlane& p) { return p.part.refracts && p.part.eta != 1; });
    if (static_cast<std::size_t>(refracting) > kMostRefractingPlanes) {
      solves_refraction_ = false;
      planes_.clear(), to_.of_shape_.clear(), to_.unsolved_.clear();
      faces_ = 0;
      add_all();
    }
    to_.parts_.reserve(planes_.size());
    for (const FacePlane& p : planes_) to_.parts_.push_back(p.finished());
  }

 private:
  /// Consecutive primitives of one kind and one surface.
  struct SurfaceRun {
    std::uint32_t surface;
    HitKind kind;
    std::uint32_t first, count;
  };
  /// The planes of one surface, before they join those of the scene.
  struct SurfacePlanes {
    std::vector<FacePlane> planes;
    struct OfKind {
      HitKind kind;
      std::uint32_t first;
      std::vector<std::int32_t> planes;  // of each primitive
    };
    std::vector<OfKind> kinds;
  };

  void add_all() {
    add(scene_.geometry().accelerator().scene(), scene_.geometry().surfaces(), -1);
    for (std::uint32_t i = 0; i < scene_.geometry().accelerator().instance_count(); ++i) {
      const std::uint32_t object = scene_.geometry().accelerator().instance(i).object;
      add(scene_.geometry().accelerator().object(object), scene_.geometry().surfaces_of(object),
          static_cast<std::int32_t>(i));
    }
  }

  void add(const GeometrySet& set, const SurfaceTable& table, std::int32_t instance) {
    if (table.smooth.empty()) return;
    std::vector<SurfaceRun> runs;
    const auto counts = set.counts();
    for (std::size_t kind = 0; kind < kHitKinds; ++kind)
      for (std::size_t r = 0; r < table.runs[kind].size(); ++r) {
        const PrimitiveRun& run = table.runs[kind][r];
        const std::size_t end =
            r + 1 < table.runs[kind].size() ? table.runs[kind][r + 1].first : counts[kind];
        runs.push_back({run.surface, static_cast<HitKind>(kind), run.first,
                        static_cast<std::uint32_t>(end - run.first)});
      }
    std::ranges::stable_sort(runs, {}, &SurfaceRun::surface);
    for (const SurfaceTable::SmoothSurface& s : table.smooth) {
      const auto of_surface = std::ranges::equal_range(runs, s.surface, {}, &SurfaceRun::surface);
      add(set, table, instance, s, {of_surface.begin(), of_surface.end()});
    }
  }

  void add(const GeometrySet& set, const SurfaceTable& table, std::int32_t instance,
           const SurfaceTable::SmoothSurface& s, std::span<const SurfaceRun> runs) {
    const Surface& surface = table.surfaces[s.surface];
    const SmoothTraits traits = traits_of(surface.material);
    const GeometryInstance* placed =
        instance < 0
            ? nullptr
            : &scene_.geometry().accelerator().instance(static_cast<std::uint32_t>(instance));
    SmoothPart like{.reflects = traits.reflects,
                    .refracts = traits.passes && !surface.pane_eta,
                    .glossy_alpha = traits.glossy_alpha,
                    .eta = traits.eta.value_or(1),
                    .reflected = reflected(surface.material, traits.glossy_alpha),
                    .material = surface.material};
    const bool moves = placed != nullptr && placed->motion != nullptr;
    std::size_t faces = 0;
    for (const SurfaceRun& run : runs) faces += run.count;
    const bool bends = like.refracts && traits.eta != 1;
    const bool sends = traits.is_smooth() || traits.is_glossy();
    bool solved = sends && !moves && !traits.turns_normals && faces_ + faces <= kMostFaces &&
                  (!bends || (solves_refraction_ && traits.eta.has_value()));
    SurfacePlanes found;
    for (const SurfaceRun& run : runs)
      solved = solved && find(set, table, placed, run, like, found);
    if (solved && planes_.size() + found.planes.size() <= kMostParts) {
      faces_ += faces;
      join(found, static_cast<std::uint64_t>(instance + 1) << 32 | s.surface);
    } else {
      solved = false;
    }
    // Directions find light by way of rougher surfaces.
    constexpr double kRarelyFound = 0.05;
    const bool is_nearly = traits.is_nearly_smooth ||
                           (!solved && traits.is_glossy() && traits.glossy_alpha <= kRarelyFound) ||
                           (traits.has_roughness_texture && may_be_narrow(surface.material));
    if ((solved || !traits.is_smooth()) && !is_nearly) return;
    Bounds bounds;
    for (const SurfaceRun& run : runs)
      add_bounds(set, placed, {run.kind, run.first, run.count}, bounds);
    using Kind = UnsolvedSurface::Kind;
    const Kind kind = traits.is_smooth() && !solved ? Kind::kSmooth : Kind::kNearlySmooth;
    if (to_.unsolved_.size() < kMostParts) return to_.unsolved_.push_back({s.where, bounds, kind});
    // The last one stands for all others.
    UnsolvedSurface& last = to_.unsolved_.back();
    last.bounds_m.add(bounds.lower), last.bounds_m.add(bounds.upper);
    if (kind == Kind::kSmooth) last.kind = kind;
  }

  SmoothTraits traits_of(std::uint32_t material) const {
    return smooth_traits(
        [&](std::uint32_t i) -> const Material& { return scene_.geometry().materials()[i]; },
        material);
  }
  /// Whether a material with a texture sends light nearly in one direction somewhere.
  bool may_be_narrow(std::uint32_t material) const {
    constexpr int kLooks = 32;     // in u and in v
    constexpr double kNarrow = 2;  // [1/sr]
    const Vec3 w{0.28, 0, 0.96};
    bool is_narrow = false;
    for_each_of_mix(
        [&](std::uint32_t i) -> const Material& { return scene_.geometry().materials()[i]; },
        material,
        [&](const Material& m) {
          for (int i = 0; i < kLooks * kLooks && !is_narrow; ++i) {
            TexturePoint p;
            p.uv = {(i % kLooks + 0.5) / kLooks, (i / kLooks + 0.5) / kLooks};
            const Bsdf bsdf = bsdf_of(m, scene_.geometry().textures(), p);
            is_narrow = !bsdf.all_delta() && bsdf.pdf(w, mirrored(w)).per_sr > kNarrow;
          }
        });
    return is_narrow;
  }
  /// The share that a material reflects along its normal.  Textures have other values elsewhere.
  double reflected(std::uint32_t material, double glossy_alpha) const {
    constexpr Vec3 kNormal{0, 0, 1};
    // GGX along the normal is 1 / (4 pi alpha^2) times this share.
    const double facets = 4 * kPi * glossy_alpha * glossy_alpha;
    double most = 0;
    for_each_of_mix(
        [&](std::uint32_t i) -> const Material& { return scene_.geometry().materials()[i]; },
        material,
        [&](const Material& m) {
          const Bsdf bsdf = bsdf_of(m, scene_.geometry().textures(), TexturePoint{});
          const Rgb single = bsdf.single(kNormal, Side::kReflected);
          const Rgb glossy = bsdf.value(kNormal, kNormal) * facets;
          most = std::max(most, (single + glossy).max_component());
        });
    return most;
  }

  /// Finds the planes of a run.  Returns false if it is curved or has too many.
  bool find(const GeometrySet& set, const SurfaceTable& table, const GeometryInstance* placed,
            const SurfaceRun& run, const SmoothPart& like, SurfacePlanes& found) const {
    found.kinds.push_back({run.kind, run.first, {}});
    std::vector<std::int32_t>& planes = found.kinds.back().planes;
    StopPoll poll;
    for (std::uint32_t i = run.first; i < run.first + run.count; ++i, poll()) {
      if (run.kind == kHitKind<Sphere>) {
        auto sphere = whole_sphere(set.of<Sphere>()[i], placed, like);
        if (!sphere || like.refracts || !like.reflects || may_hold_light(sphere->part))
          return false;
        planes.push_back(static_cast<std::int32_t>(found.planes.size()));
        found.planes.push_back(*sphere);
        continue;
      }
      Face face = face_of(set, run.kind, i);
      if (face.empty() || has_other_normals(set, table, run.kind, i)) return false;
      for (Vec3& p : face) p = placed ? placed->scene_from_object.point(p) : p;
      Vec3 n = face_normal(set, run.kind, i);
      if (placed) n = placed->scene_from_object.normal(n);
      n = normalized(n);
      // No ray meets a face without area.
      if (!is_finite(n) || !(length(n) > 0.5)) {
        planes.push_back(kNone);
        continue;
      }
      const auto same = std::ranges::find_if(
          found.planes, [&](const FacePlane& p) { return p.contains(n, face); });
      planes.push_back(static_cast<std::int32_t>(same - found.planes.begin()));
      if (same != found.planes.end())
        same->add(face);
      else
        found.planes.emplace_back(like, n, face);
      if (found.planes.size() > (like.refracts ? kMostRefractingPlanes : kMostPlanes)) return false;
    }
    return true;
  }

  /// Whether a light may be inside of a ball, whose inside is no part.
  bool may_hold_light(const SmoothPart& ball) const {
    constexpr std::size_t kFewLights = 64;
    const auto is_within = [&](const Bounds& box) {
      const Vec3 nearest{std::clamp(ball.middle.x, box.lower.x, box.upper.x),
                         std::clamp(ball.middle.y, box.lower.y, box.upper.y),
                         std::clamp(ball.middle.z, box.lower.z, box.upper.z)};
      return length(nearest - ball.middle) < ball.radius_m;
    };
    if (scene_.lights().size() > kFewLights) return is_within(all_lights());
    return std::ranges::any_of(scene_.lights(), [&](const SceneLight& light) {
      const auto bounds = LightAtTime(light, 0)->bounds();
      return bounds && is_within({bounds->lower, bounds->upper});
    });
  }
  /// A box of all lights with a place.
  const Bounds& all_lights() const {
    if (!lights_m_) {
      lights_m_.emplace();
      for (const SceneLight& light : scene_.lights())
        if (const auto bounds = LightAtTime(light, 0)->bounds())
          lights_m_->add(bounds->lower), lights_m_->add(bounds->upper);
    }
    return *lights_m_;
  }
  /// Adds the planes of a surface to those of the scene.
  void join(const SurfacePlanes& found, std::uint64_t shape) {
    std::vector<std::int32_t> numbers;
    StopPoll poll;
    for (const FacePlane& p : found.planes) {
      poll();
      const auto same =
          std::ranges::find_if(planes_, [&](const FacePlane& q) { return q.joins(p); });
      numbers.push_back(static_cast<std::int32_t>(same - planes_.begin()));
      if (same == planes_.end())
        planes_.push_back(p);
      else
        same->add(p.rectangle());
    }
    for (const SurfacePlanes::OfKind& of : found.kinds) {
      ShapeParts& parts = to_.of_shape_[key(shape, of.kind)];
      if (parts.parts.empty()) parts.first = of.first;
      // Runs of one shape follow each other, except for those of other kinds between them.
      parts.parts.resize(of.first - parts.first, kNone);
      for (const std::int32_t p : of.planes) parts.parts.push_back(p < 0 ? kNone : numbers[p]);
    }
  }

  const Scene& scene_;
  SmoothSurfaces& to_;
  std::vector<FacePlane> planes_;
  bool solves_refraction_ = true;
  std::size_t faces_ = 0;  // of parts
  mutable std::optional<Bounds> lights_m_;
};

namespace {

/// Whether a lamp without a size lies on glass or on a plane that is nearly a mirror.  On a mirror,
/// its image is in the same place.
bool has_lamp_on(const Scene& scene, const SmoothPart& part) {
  if (part.is_sphere || !(part.glossy_alpha > 0 || (part.refracts && part.eta != 1))) return false;
  const double reach = max_abs(part.middle) + length(part.half_u) + length(part.half_v);
  return std::ranges::any_of(scene.lights(), [&](const SceneLight& light) {
    const auto bounds = LightAtTime(light, 0)->bounds();
    return is_delta(light) && bounds && part.may_contain(bounds->lower) &&
           std::fabs(part.height(bounds->lower)) <= 4 * kFloatRoundoff * reach;
  });
}

}  // namespace

SmoothSurfaces::SmoothSurfaces(const Scene& scene) {
  Collector(scene, *this).collect();
  if (parts_.size() > kFewParts) tree_ = PartTree(parts_);
  using Kind = UnsolvedSurface::Kind;
  const auto add = [&](Kind kind, const auto& has) {
    UnsolvedSurface all{first_smooth(scene), {}, kind};
    for (const SmoothPart& p : parts_) {
      if (!has(p)) continue;
      const Vec3 reach{p.radius_m + std::fabs(p.half_u.x) + std::fabs(p.half_v.x),
                       p.radius_m + std::fabs(p.half_u.y) + std::fabs(p.half_v.y),
                       p.radius_m + std::fabs(p.half_u.z) + std::fabs(p.half_v.z)};
      all.bounds_m.add(p.middle - reach), all.bounds_m.add(p.middle + reach);
    }
    unsolved_.push_back(all);
  };
  // Directions find light by way of rougher planes.
  constexpr double kRarelyFound = 0.05;
  const auto is_nearly = [](const SmoothPart& p) {
    return p.glossy_alpha > 0 && p.glossy_alpha <= kRarelyFound;
  };
  const auto is_ball = [](const SmoothPart& p) { return p.is_sphere; };
  const auto is_any = [](const SmoothPart&) { return true; };
  if (parts_.size() > 1 && std::ranges::any_of(parts_, is_nearly))
    add(Kind::kNearlySmoothChain, is_any);
  if (!tree_.empty())
    add(Kind::kCrowd, is_any);
  else if (std::ranges::count_if(parts_, is_ball) > 1)
    add(Kind::kCrowd, is_ball);
  const auto holds_lamp = [&](const SmoothPart& p) { return has_lamp_on(scene, p); };
  if (std::ranges::any_of(parts_, holds_lamp)) add(Kind::kSmooth, holds_lamp);
  const auto nearly = static_cast<std::size_t>(std::ranges::count_if(parts_, is_nearly));
  if (nearly * scene.lights().size() > kMostGuidedPairs) add(Kind::kNearlySmooth, is_nearly);
}

std::int32_t SmoothSurfaces::part_of(const SurfaceHit& hit) const {
  const auto of = of_shape_.find(key(hit.shape, hit.kind));
  if (of == of_shape_.end() || hit.primitive < of->second.first) return kNone;
  const std::size_t i = hit.primitive - of->second.first;
  return i < of->second.parts.size() ? of->second.parts[i] : kNone;
}

std::string SmoothSurfaces::why() const {
  return fmt::format("{} mirrors, panes and glass faces; {} curved smooth surfaces", parts_.size(),
                     unsolved_.size());
}

std::size_t SmoothSurfaces::bytes() const {
  std::size_t sum = tree_.bytes() + parts_.capacity() * sizeof(SmoothPart) +
                    unsolved_.capacity() * sizeof(UnsolvedSurface);
  for (const auto& [shape, of] : of_shape_)
    sum += sizeof of + sizeof shape + of.parts.capacity() * sizeof(std::int32_t);
  return sum;
}

const SmoothSurfaces& smooth_surfaces(const Scene& scene) {
  return scene.attached<AttachedLazyPart<SmoothSurfaces, Scene>>().get();
}

}  // namespace lucerna
