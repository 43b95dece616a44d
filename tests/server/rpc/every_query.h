// A valid request of every query.
#pragma once

#include <concepts>
#include <string>

#include "tests/server/rpc/service_fixture.h"

namespace lucerna::testing {

template <typename T, typename... Any>
concept OneOf = (std::same_as<T, Any> || ...);

/// Calls `use` with a request of each query for `items` items, about light 1 of the scene where a
/// light is needed.  Pictures have `items` columns and 1 row, or are whole.
template <typename Use>
void for_each_query(const std::string& scene, int items, Use&& use) {
  v1::Points points;
  points.mutable_offsets_m()->Resize(3 * items, 0.5F);
  google::protobuf::RepeatedField<float> up;
  up.Resize(3 * items, 1);

  auto li = about<v1::SampleLiRequest>(scene);
  *li.mutable_receivers() = points;
  use(li);
  auto li_density = about<v1::PdfLiRequest>(scene);
  li_density.set_light_id(1);
  *li_density.mutable_receivers() = points;
  *li_density.mutable_wi() = up;
  use(li_density);
  auto emitted = about<v1::SampleLeRequest>(scene);
  emitted.set_count(static_cast<std::uint32_t>(items));
  use(emitted);
  auto emitted_density = about<v1::PdfLeRequest>(scene);
  emitted_density.set_light_id(1);
  *emitted_density.mutable_points() = points;
  *emitted_density.mutable_directions() = up;
  use(emitted_density);
  auto radiance = about<v1::LeRequest>(scene);
  *radiance.mutable_points() = points;
  *radiance.mutable_directions() = up;
  use(radiance);
  auto between = about<v1::TestVisibilityRequest>(scene);
  *between.mutable_segments()->mutable_from() = points;
  *between.mutable_segments()->mutable_to() = points;
  between.mutable_segments()->mutable_to()->mutable_origin_m()->set_x(1);
  use(between);
  auto meter = about<v1::EstimateIrradianceRequest>(scene);
  *meter.mutable_receivers() = points;
  *meter.mutable_normals() = up;
  meter.set_bounces(0);
  meter.mutable_accuracy()->set_samples(1);
  use(meter);
  auto power = about<v1::EstimatePowerRequest>(scene);
  power.mutable_light_ids()->Resize(items, 1);
  use(power);
  auto tile = about<v1::RenderTileRequest>(scene);
  set_rect(&tile, static_cast<std::uint32_t>(items), 1);
  tile.mutable_accuracy()->set_samples(1);
  use(tile);
  auto image = about<v1::RenderImageRequest>(scene);
  image.mutable_accuracy()->set_samples(1);
  use(image);
  auto seen = about<v1::FindSurfacesRequest>(scene);
  seen.mutable_places()->Resize(2 * items, 1);
  use(seen);
}

}  // namespace lucerna::testing
