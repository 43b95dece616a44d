// Row 24: sums of very many samples.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <vector>

#include "proto/common/tile_statistics.h"
#include "server/estimate/block_stream.h"
#include "server/estimate/render.h"
#include "server/estimate/sample_sum.h"
#include "tests/extremes_sweep.h"
#include "tests/reference_table.h"
#include "tests/server/scene/scenes.h"

namespace lucerna::testing {
namespace {

/// A line of the table of means.
struct Samples {
  explicit Samples(const ReferenceTable::Row& row)
      : count(std::stoull(row.text("count"))),
        period(std::stoull(row.text("period"))),
        offset(std::stoull(row.text("offset"))),
        large(row["large"]),
        small(row["small"]),
        mean(row["mean"]) {}
  /// The first large sample from `i` on.
  std::uint64_t large_from(std::uint64_t i) const {
    return i + (offset + period - i % period) % period;
  }

  std::uint64_t count, period, offset;
  double large, small, mean;
};

/// Up to three lines at once, one in each channel: the mean of a block of samples from `first` on.
std::array<double, 3> block_mean(const std::vector<Samples>& samples, std::uint64_t first,
                                 std::uint64_t count) {
  const std::uint64_t end = first + count;
  std::array<double, 3> small{};
  std::array<std::uint64_t, 3> next{end, end, end};  // the next large sample
  for (std::size_t c = 0; c < samples.size(); ++c) {
    small[c] = samples[c].small;
    next[c] = samples[c].large_from(first);
  }
  const Rgb all_small(small[0], small[1], small[2]);
  SampleSum sum;
  for (std::uint64_t i = first; i < end; ++i) {
    for (const std::uint64_t until = std::min({next[0], next[1], next[2], end}); i < until; ++i)
      sum.add(all_small);
    if (i == end) break;
    std::array<double, 3> value = small;
    for (std::size_t c = 0; c < samples.size(); ++c)
      if (next[c] == i) value[c] = samples[c].large, next[c] += samples[c].period;
    sum.add({value[0], value[1], value[2]});
  }
  const Rgb mean = sum.value() / static_cast<double>(count);
  return {mean.r, mean.g, mean.b};
}

/// Sums pixels and receivers: a billion samples in blocks, whose means are merged.  Blocks of the
/// same samples have the same mean, which is computed once.
std::array<double, 3> means(const std::vector<Samples>& samples) {
  constexpr std::uint64_t kSamplesPerBlock = std::uint64_t{1} << 26;
  const std::uint64_t count = samples.front().count;
  const std::uint64_t per_block = count % kSamplesPerBlock == 0 ? kSamplesPerBlock : count;
  std::map<std::vector<std::uint64_t>, std::array<double, 3>> known;
  BlockStream<3> blocks(0);
  for (std::uint64_t first = 0; first < count; first += per_block) {
    std::vector<std::uint64_t> large;  // the positions in this block
    for (const Samples& s : samples)
      large.push_back(std::min(s.large_from(first) - first, per_block));
    const auto [mean, is_new] = known.try_emplace(large);
    if (is_new) mean->second = block_mean(samples, first, per_block);
    blocks.add(mean->second);
  }
  const auto total = blocks.total();
  const auto block_count = static_cast<double>(count / per_block);
  return {total[0].sum / block_count, total[1].sum / block_count, total[2].sum / block_count};
}

/// The mean by a running sum in one float.
float textbook_mean(const Samples& s) {
  const auto small = static_cast<float>(s.small), large = static_cast<float>(s.large);
  float sum = 0;
  std::uint64_t next = s.offset;
  for (std::uint64_t i = 0; i < s.count; ++i) {
    const float before = sum;
    if (i == next) {
      next += s.period;
      sum += large;
      if (sum == before && sum + small == sum) break;  // nothing more is added
    } else {
      sum += small;
      // Small samples that were lost stay lost: skip to the next large one.
      if (sum == before) i = next - 1;
    }
  }
  return sum / static_cast<float>(s.count);
}

void compare_means(Sweep& sweep, bool billion) {
  const ReferenceTable table("means");
  std::vector<Samples> together;
  const auto compare = [&] {
    const auto found = means(together);
    for (std::size_t c = 0; c < together.size(); ++c) {
      const Samples& s = together[c];
      sweep.compare(found[c], s.mean,
                    std::to_string(s.large) + " among " + std::to_string(s.small));
      sweep.compare_textbook(textbook_mean(s), s.mean);
    }
    together.clear();
  };
  for (const auto& row : table.rows()) {
    const Samples s(row);
    if ((s.count > 100'000'000) != billion) continue;
    together.push_back(s);
    if (together.size() == 3) compare();
  }
  if (!together.empty()) compare();
  sweep.expect_within(1e-15);
}

TEST(SumsExtremes, MeansOfABillionSamples) {
  Sweep sweep(24, "samples of a pixel or receiver: all 0.1, or one of 1e30 among ones",
              "2^30 samples", "mean");
  compare_means(sweep, true);
}

TEST(SumsExtremes, MeansOfSamplesOfMixedMagnitude) {
  Sweep sweep(24, "samples of a pixel or receiver: a mixture of 1e-30 ... 3e38", "1e8 samples",
              "mean");
  compare_means(sweep, false);
}

TEST(SumsExtremes, SumsThatOverflowAreInfinite) {
  SampleSum sum;
  for (int i = 0; i < 4; ++i) sum.add({1e308, 1, std::numeric_limits<double>::infinity()});
  EXPECT_EQ(sum.value().r, std::numeric_limits<double>::infinity());
  EXPECT_EQ(sum.value().g, 4);
  EXPECT_EQ(sum.value().b, std::numeric_limits<double>::infinity());
}

TEST(SumsExtremes, PixelsOfAnEvenSky) {
  Sweep sweep(24, "a pixel that sees only a sky of 0.1 cd/m2", "1 ... 2^22 samples a block",
              "mean, through RenderTile");
  SceneDescription d = description();
  d.lights = {{UniformInfiniteLightParams{Rgb(0.1)}, {"test.pbrt", 5, 1}}};
  const auto scene = build(d);
  for (int log = 0; log <= 22; log += 2) {
    TileSettings settings;
    settings.rect = {0, 0, 1, 1};
    settings.samples_per_block = 1U << log;
    settings.block_count = log < 20 ? 16 : 1;
    const TileResult tile = render_tile(*scene, settings, {});
    EXPECT_EQ(tile.work.samples, settings.samples_per_block * settings.block_count);
    sweep.compare(tile.channels[0].sum / static_cast<double>(settings.block_count), 0.1,
                  std::to_string(settings.samples_per_block));
    float textbook = 0;
    for (std::uint64_t i = 0; i < settings.samples_per_block * settings.block_count; ++i)
      textbook += 0.1F;
    sweep.compare_textbook(
        textbook / static_cast<float>(settings.samples_per_block * settings.block_count), 0.1);
  }
  sweep.expect_within(1e-15);
}

TEST(SumsExtremes, TilesOfManyBlocks) {
  Sweep sweep(24, "tiles merged from blocks of 0.1", "1 ... 2^20 blocks, numbered from 0 ... 2^62",
              "mean, merged by the server and by the client");
  for (int log = 0; log <= 20; ++log)
    for (const std::uint64_t first :
         {std::uint64_t{0}, std::uint64_t{1} << 33, std::uint64_t{1} << 62}) {
      const std::uint64_t count = std::uint64_t{1} << log;
      BlockStream<1> stream(first);
      BlockMerger merger(first, 1);
      // As servers answer: tiles of up to 2^12 blocks.
      const std::uint64_t tile = std::min<std::uint64_t>(count, 1U << 12);
      for (std::uint64_t b = first; b < first + count; b += tile) {
        BlockStream<1> of_tile(b);
        for (std::uint64_t i = 0; i < tile; ++i) {
          stream.add({0.1});
          of_tile.add({0.1});
        }
        ASSERT_TRUE(merger.add(b, tile, {of_tile.total()[0]}));
      }
      ASSERT_EQ(merger.blocks(), count);
      const BlockStatistics merged = merger.total()[0], streamed = stream.total()[0];
      EXPECT_EQ(merged.sum, streamed.sum);
      EXPECT_EQ(merged.deviation, streamed.deviation);
      const auto n = static_cast<double>(count);
      sweep.compare(merged.sum / n, 0.1, std::to_string(count));
      float textbook = 0;
      for (std::uint64_t i = 0; i < count; ++i) textbook += 0.1F;
      sweep.compare_textbook(textbook / static_cast<float>(count), 0.1);
    }
  sweep.expect_within(1e-15);
}

TEST(SumsExtremes, DeviationOfNearlyEqualBlocks) {
  Sweep sweep(24, "blocks of x and x + 1, alternately; x", "1 ... 1e15, 2^2 ... 2^20 blocks",
              "squared deviation, from which standard errors follow");
  for (double x = 1; x <= 1e15; x *= 10)
    for (int log = 2; log <= 20; log += 6) {
      const std::uint64_t count = std::uint64_t{1} << log;
      BlockStream<1> stream(0);
      float sum = 0, squares = 0;
      for (std::uint64_t i = 0; i < count; ++i) {
        const double value = x + static_cast<double>(i % 2);
        stream.add({value});
        sum += static_cast<float>(value);
        squares += static_cast<float>(value) * static_cast<float>(value);
      }
      const auto n = static_cast<double>(count);
      // Each is half away from the mean.
      sweep.compare(stream.total()[0].deviation, n / 4, std::to_string(x));
      sweep.compare_textbook(squares - sum * sum / static_cast<float>(n), n / 4);
    }
  // Means near 1e15 are rounded to an eighth.
  sweep.expect_within(1e-12);
}

TEST(SumsExtremes, CountsOfSamples) {
  Sweep sweep(24, "number of samples", "2^31 ... 2^52 a tile, 1024 tiles", "count");
  for (int log = 31; log <= 52; ++log) {
    WorkCounts tile, total;
    tile.samples = tile.camera_rays = tile.indirect_rays = tile.shadow_rays = std::uint64_t{1}
                                                                              << log;
    float textbook = 0;
    for (int i = 0; i < 1024; ++i) {
      total += tile;
      textbook += 1;
    }
    const double truth = std::ldexp(1.0, log + 10);
    for (const std::uint64_t count :
         {total.samples, total.camera_rays, total.indirect_rays, total.shadow_rays})
      sweep.compare(static_cast<double>(count), truth, "2^" + std::to_string(log));
    // A float that counts samples one by one stays at 2^24.
    sweep.compare_textbook(std::min(textbook * std::ldexp(1.0F, log), std::ldexp(1.0F, 24)), truth);
  }
  sweep.expect_within(0);
}

}  // namespace
}  // namespace lucerna::testing
