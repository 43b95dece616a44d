#include "client/cli/picture_files.h"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <filesystem>
#include <set>
#include <utility>

#include "client/terminal/certainty.h"
#include "client/terminal/error.h"
#include "client/terminal/luminance.h"

namespace lucerna::cli {
namespace {

using client::Picture;
using client::PictureFile;
using client::PictureFormat;

bool is_without_light(const Picture& picture, std::size_t i) {
  return luminance(picture.pixels.data() + 3 * i) == 0 && picture.upper[i] > 0;
}

/// Standard errors.  A pixel without light has its upper bound, since its standard error would be
/// 0.
std::vector<float> errors_of(const Picture& picture) {
  std::vector<float> values = picture.standard_error;
  for (std::size_t i = 0; i < picture.upper.size(); ++i)
    if (is_without_light(picture, i)) std::fill_n(&values[3 * i], 3, picture.upper[i]);
  return values;
}

std::vector<float> intervals_of(const Picture& picture) {
  std::vector<float> values;
  values.reserve(picture.pixels.size());
  for (std::size_t i = 0; i < picture.upper.size(); ++i)
    values.insert(values.end(), {static_cast<float>(luminance(picture.pixels.data() + 3 * i)),
                                 picture.lower[i], picture.upper[i]});
  return values;
}

/// Pictures have three channels, so a count becomes grey.
std::vector<float> counts_of(const Picture& picture) {
  std::vector<float> values;
  values.reserve(picture.pixels.size());
  for (const std::uint32_t n : picture.samples)
    values.insert(values.end(), 3, static_cast<float>(n));
  return values;
}

std::string joined(const std::string& a, const std::string& b) {
  return a.empty() || b.empty() ? a + b : a + "; " + b;
}

}  // namespace

void PictureNames::add(CLI::App& command) {
  command
      .add_option("-o,--output", pictures,
                  "File of the picture: .exr or .pfm (linear RGB, 32-bit float) or .png (8-bit "
                  "sRGB); may be repeated")
      ->allow_extra_args(false)
      ->type_name("FILE")
      ->required();
  command
      .add_option("--stderr", errors,
                  "Also write a picture of the standard error of each pixel; a pixel whose "
                  "samples found no light has its upper bound.  With this file or --interval, "
                  "samples come in independent blocks, which have more noise")
      ->type_name("FILE");
  command
      .add_option("--interval", intervals,
                  "Also write the confidence interval of the luminance of each pixel: .exr "
                  "with the channels Y, lower.Y and upper.Y")
      ->type_name("FILE");
  command
      .add_option("--counts", counts,
                  "Also write a picture of the number of samples of each pixel: .exr or .pfm")
      ->type_name("FILE");
}

void PictureNames::check(std::optional<std::uint32_t> samples) const {
  const auto needs_more = [&](const std::string& name, const char* option, const char* what) {
    if (!name.empty() && samples == 1U)
      wrong_use(
          fmt::format("{}: a single sample has no {}; --samples must be 2 or more", option, what));
  };
  needs_more(errors, "--stderr", "standard error");
  needs_more(intervals, "--interval", "interval");
  const auto is = [](const std::string& name, PictureFormat format) {
    const auto given = client::picture_format(name);
    return given.ok() && *given == format;
  };
  if (is(counts, PictureFormat::kPng))
    wrong_use("--counts " + counts + ": 8 bits cannot store counts; must be .exr or .pfm");
  if (!intervals.empty() && !is(intervals, PictureFormat::kExr))
    wrong_use("--interval " + intervals + ": must be .exr, whose channels have names");
}

std::size_t pixels_without_light(const Picture& picture) {
  std::size_t count = 0;
  for (std::size_t i = 0; i < picture.upper.size(); ++i) count += is_without_light(picture, i);
  return count;
}

PictureFiles::PictureFiles(const PictureNames& names) {
  std::set<std::filesystem::path> taken;
  const auto create = [&](const std::string& path) {
    if (!taken.insert(std::filesystem::absolute(path).lexically_normal()).second)
      wrong_use("-o, --stderr, --interval and --counts: " + path + " is given twice");
    auto file = PictureFile::create(path);
    if (!file.ok()) wrong_use(std::string(file.status().message()));
    return *std::move(file);
  };
  for (const std::string& path : names.pictures) pictures_.push_back(create(path));
  if (!names.errors.empty()) errors_ = create(names.errors);
  if (!names.intervals.empty()) intervals_ = create(names.intervals);
  if (!names.counts.empty()) counts_ = create(names.counts);
}

void PictureFiles::write(const Picture& picture, const std::string& description, double confidence,
                         double exposure_ev) {
  const auto put = [&](PictureFile& file, const std::vector<float>& values,
                       const std::string& holds, double exposure,
                       client::ChannelNames channels = {"R", "G", "B"}) {
    const absl::Status status = file.write({.width = picture.width,
                                            .height = picture.height,
                                            .rgb = values,
                                            .description = joined(description, holds),
                                            .channels = std::move(channels)},
                                           exposure);
    if (!status.ok()) throw CommandError(kServerRefused, std::string(status.message()));
  };
  const auto describe = [&](const PictureFile& file, const std::string& holds) {
    summary_ += fmt::format("{}: {}; ", file.path(), holds);
  };
  if ((errors_ || intervals_) && (picture.standard_error.empty() || picture.upper.empty()))
    throw CommandError(kServerRefused, fmt::format("{}: a single block of samples has no {}",
                                                   errors_ ? "--stderr" : "--interval",
                                                   errors_ ? "standard error" : "interval"));
  for (PictureFile& file : pictures_) put(file, picture.pixels, "", exposure_ev);
  if (errors_) {
    std::string holds = "standard errors";
    if (const std::size_t n = pixels_without_light(picture); n > 0)
      holds += fmt::format(", upper bounds at {} {} without light", n, n == 1 ? "pixel" : "pixels");
    put(*errors_, errors_of(picture), holds, exposure_ev);
    describe(*errors_, holds);
  }
  if (intervals_) {
    const std::string holds = fmt::format("{}% confidence intervals", percent(confidence));
    put(*intervals_, intervals_of(picture), holds, 0, {"Y", "lower.Y", "upper.Y"});
    describe(*intervals_, holds);
  }
  if (counts_) put(*counts_, counts_of(picture), "", 0);
}

}  // namespace lucerna::cli
