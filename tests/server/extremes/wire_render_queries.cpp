// RenderTile and RenderImage.
#include <fmt/format.h>

#include <algorithm>
#include <cstring>
#include <limits>

#include "proto/common/luminance_moments.h"
#include "tests/server/extremes/wire_queries.h"

namespace lucerna::testing {

/// A moment, the shutter's open interval, or neither.
template <typename Request>
void WireQueries::render_time(Request* out) {
  switch (n_.below(3)) {
    case 0:
      out->set_time_s(n_.scalar());
      break;
    case 1:
      out->mutable_shutter()->set_offset_s(n_.with_sign(n_.magnitude()));
      if (n_.chance(0.7)) out->mutable_shutter()->set_length_s(n_.chance(0.1) ? 0 : n_.magnitude());
      break;
    default:
      break;
  }
}

void WireQueries::tile_holds(const std::string& name, const v1::Tile& tile,
                             const v1::PixelRect& rect, bool target, bool intervals) {
  hold(tile.rect().SerializeAsString() == rect.SerializeAsString(), name, 0,
       fmt::format("{}, not {}", tile.rect().ShortDebugString(), rect.ShortDebugString()));
  const std::size_t pixels = std::size_t{rect.x1() - rect.x0()} * (rect.y1() - rect.y0());
  expect(name, tile.sum().size(), 3 * sizeof(double) * pixels, "bytes of sum");
  expect(name, tile.deviation().size(), 3 * sizeof(double) * pixels, "bytes of deviation");
  expect(name, tile.samples().size(), target ? sizeof(float) * pixels : 0, "bytes of samples");
  for (const std::string* plane : {&tile.lower(), &tile.upper()})
    expect(name, plane->size(), target || intervals ? sizeof(float) * pixels : 0,
           "bytes of intervals");
  expect(name, tile.moments().size(), intervals && !target ? kMomentBytes * pixels : 0,
         "bytes of moments");
  hold(tile.block_count() > 0, name, 0, "no blocks");
  if (!failures_.empty()) return;
  const auto number = [](const std::string& plane, std::size_t i, auto value) {
    std::memcpy(&value, plane.data() + i * sizeof value, sizeof value);
    return value;
  };
  for (std::size_t i = 0; i < 3 * pixels; ++i) {
    if (number(tile.sum(), i, 0.0) >= 0) continue;
    hold(scene_.has_signed_filter, name, i, "a pixel below 0");
    ++negative_;
  }
  for (std::size_t i = 0; i < tile.lower().size() / sizeof(float); ++i) {
    const float lower = number(tile.lower(), i, 0.0F), upper = number(tile.upper(), i, 0.0F);
    hold(lower <= upper && (lower >= 0 || scene_.has_signed_filter), name, i,
         fmt::format("an interval from {} to {}", lower, upper));
  }
  count(name, pixels);
}

void WireQueries::tile() {
  auto q = about<v1::RenderTileRequest>(scene_id_);
  q.set_seed(n_.seed());
  bounces(&q);
  methods(q.mutable_accuracy());
  render_time(&q);
  q.set_intervals(n_.chance(0.3));
  // The scene file proposes only a few.
  if (n_.chance(0.2)) {
    target_or_time(q.mutable_accuracy());
  } else if (!summary_.has_samples_per_pixel() || n_.chance(0.5)) {
    const std::uint32_t samples = 1U << n_.below(4);
    q.mutable_accuracy()->set_samples(samples);
    if (n_.chance(0.5)) q.set_samples_per_block(samples >> n_.below(4));
    if (q.samples_per_block() == 0) q.clear_samples_per_block();
    // Up to 2^40, the largest number of samples that the server accepts.
    if (n_.chance(0.5)) q.set_first_sample(samples * (n_.seed() >> (27 + n_.below(37))));
  }
  v1::PixelRect rect;
  const auto begin_end = [&](std::uint32_t size, auto set_begin, auto set_end) {
    const auto begin = static_cast<std::uint32_t>(n_.below(size));
    (rect.*set_begin)(begin);
    (rect.*set_end)(begin + 1 + static_cast<std::uint32_t>(n_.below(size - begin)));
  };
  if (n_.chance(0.5)) {
    begin_end(summary_.image_width(), &v1::PixelRect::set_x0, &v1::PixelRect::set_x1);
    begin_end(summary_.image_height(), &v1::PixelRect::set_y0, &v1::PixelRect::set_y1);
    *q.mutable_rect() = rect;
  } else {
    rect.set_x1(summary_.image_width());
    rect.set_y1(summary_.image_height());
  }
  v1::RenderTileResponse r;
  if (ask(q, &r))
    tile_holds("RenderTile", r.tile(), rect, q.accuracy().has_target_error(), q.intervals());
}

void WireQueries::image() {
  auto q = about<v1::RenderImageRequest>(scene_id_);
  q.set_seed(n_.seed());
  bounces(&q);
  methods(q.mutable_accuracy());
  render_time(&q);
  q.set_intervals(n_.chance(0.3));
  if (n_.chance(0.2)) {
    target_or_time(q.mutable_accuracy());
  } else if (!summary_.has_samples_per_pixel() || n_.chance(0.5)) {
    const auto blocks = static_cast<std::uint32_t>(1 + n_.below(7));
    const std::uint32_t block = 1U << n_.below(2);
    q.mutable_accuracy()->set_samples(blocks * block);
    if (n_.chance(0.5)) q.set_samples_per_block(block);
  }
  const std::uint32_t width = summary_.image_width(), height = summary_.image_height();
  if (n_.chance(0.7))
    q.set_tile_size(
        static_cast<std::uint32_t>(1 + n_.below(std::min(1024U, 2 * std::max(width, height)))));
  q.set_final_only(n_.chance(0.3));
  std::uint64_t done = 0, total = 1;
  const grpc::Status s = call([&](grpc::ClientContext* context) {
    const auto stream = service_.render.RenderImage(context, q);
    v1::RenderImageResponse r;
    while (stream->Read(&r)) {
      answered("RenderImage", grpc::Status::OK, q, r);
      const v1::PixelRect& rect = r.tile().rect();
      hold(rect.x0() < rect.x1() && rect.x1() <= width && rect.y0() < rect.y1() &&
               rect.y1() <= height,
           "RenderImage", 0, rect.ShortDebugString() + " is not within the picture");
      tile_holds("RenderImage", r.tile(), rect, q.accuracy().has_target_error(), q.intervals());
      // Tiles that a time limit ended, or that were kept until the end, are sent as they were.
      hold(r.samples_done() > done || q.accuracy().has_time_budget_s(), "RenderImage", 0,
           "no samples were added");
      done = r.samples_done();
      total = r.samples_total();
    }
    return stream->Finish();
  });
  hold(s.ok(), "RenderImage", 0, fmt::format("{} {}", int(s.error_code()), s.error_message()));
  const bool counted = q.accuracy().stop_case() != v1::Accuracy::kTargetError &&
                       q.accuracy().stop_case() != v1::Accuracy::kTimeBudgetS;
  hold(counted ? done == total : total == 0, "RenderImage", 0,
       fmt::format("{} of {} samples are done", done, total));
}

/// Places on the picture, at its edges, beside it, and numbers of any size.
void WireQueries::surfaces() {
  auto q = about<v1::FindSurfacesRequest>(scene_id_);
  if (n_.chance(0.5)) q.set_time_s(n_.chance(0.5) ? 0.5 : 0);
  Items items(static_cast<std::size_t>(batch()));
  for (Item& item : items) {
    item = Item::kGood;
    for (const std::uint32_t size : {summary_.image_width(), summary_.image_height()}) {
      const float place =
          n_.chance(0.1) ? n_.component() : static_cast<float>(n_.below(4 * size + 1)) / 4;
      q.add_places(place);
      const bool inside =
          place > -std::numeric_limits<float>::min() && place <= static_cast<float>(size);
      if (!inside) item = Item::kInvalid;
    }
  }
  v1::FindSurfacesResponse r;
  if (!ask(q, &r)) return;
  expect("FindSurfaces", r.points().offsets_m_size(), 3 * items.size(), "offsets");
  expect("FindSurfaces", r.normals_size(), 3 * items.size(), "numbers of normals");
  expect("FindSurfaces", r.found().size(), (items.size() + 7) / 8, "bytes of found");
  expect("FindSurfaces", r.light_ids_size(), items.size(), "light ids");
  if (!failures_.empty()) return;
  const auto statuses_of_items = statuses("FindSurfaces", r.status(), items, false);
  for (std::size_t i = 0; i < items.size(); ++i) {
    const std::uint64_t light = r.light_ids(static_cast<int>(i));
    if (light != 0) is_light("FindSurfaces", i, light);
    if (bit(r.found(), i)) {
      is_unit("FindSurfaces", i, r.normals());
      hold(statuses_of_items[i] == v1::ITEM_STATUS_OK, "FindSurfaces", i,
           "found beside the picture");
    } else {
      is_zero("FindSurfaces", i, r.normals(), 3);
      is_zero("FindSurfaces", i, r.points().offsets_m(), 3);
      hold(light == 0, "FindSurfaces", i, "a light without a surface");
    }
  }
}

}  // namespace lucerna::testing
