#include "client/files/map_file.h"

#include <OpenImageIO/imagecache.h>
#include <OpenImageIO/imageio.h>
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <optional>
#include <string_view>
#include <utility>

#include "proto/common/status_macros.h"

namespace lucerna::client {
namespace {

constexpr float kCacheMegabytes = 32;
constexpr int kRowsPerRead = 32;  // OpenEXR compresses 16 or 32 scan lines together

std::string lower(std::string text) {
  std::transform(text.begin(), text.end(), text.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return text;
}

/// Three channels of one part.
struct Triple {
  int part = 0;
  std::array<int, 3> channels{};
};

/// The channels of the parts of a file.
class Channels {
 public:
  explicit Channels(std::vector<OIIO::ImageSpec> parts) : parts_(std::move(parts)) {}

  /// The channels x, y and z of the layer.  If its name is empty, the channels without a layer.
  std::optional<Triple> find(const std::string& layer) const {
    for (const std::string_view names : {"xyz", "rgb"}) {
      for (std::size_t part = 0; part < parts_.size(); ++part) {
        Triple found{static_cast<int>(part), {}};
        const bool all = std::equal(names.begin(), names.end(), found.channels.begin(),
                                    [&](char name, int& channel) {
                                      channel = index(parts_[part], layer, name);
                                      return channel >= 0;
                                    });
        if (all) return found;
      }
    }
    return {};
  }

  OIIO::TypeDesc type(const Triple& triple, int i) const {
    return parts_[triple.part].channelformat(triple.channels[i]);
  }
  std::string name(const Triple& triple, int i) const {
    return parts_[triple.part].channelnames[triple.channels[i]];
  }
  std::string names() const {
    std::string all;
    for (const OIIO::ImageSpec& part : parts_) {
      for (const std::string& name : part.channelnames) all += (all.empty() ? "" : ", ") + name;
    }
    return all;
  }
  const OIIO::ImageSpec& part(const Triple& triple) const { return parts_[triple.part]; }

 private:
  /// -1 if there is none.
  static int index(const OIIO::ImageSpec& part, const std::string& layer, char name) {
    const std::string wanted = layer.empty() ? std::string(1, name) : layer + "." + name;
    const std::string within = '.' + wanted;
    for (int i = 0; i < part.nchannels; ++i) {
      const std::string there = lower(part.channelnames[i]);
      if (there == wanted || (!layer.empty() && there.ends_with(within))) return i;
    }
    return -1;
  }

  std::vector<OIIO::ImageSpec> parts_;
};

class MapFile final : public VectorFile {
 public:
  explicit MapFile(std::string path)
      : path_(std::move(path)),
        cache_(OIIO::ImageCache::create(false), [](auto* c) { OIIO::ImageCache::destroy(c); }) {
    cache_->attribute("max_memory_MB", kCacheMegabytes);
    cache_->attribute("autotile", kRowsPerRead);
    cache_->attribute("autoscanline", 1);
  }

  absl::Status open(VectorKind kind) {
    const auto file = OIIO::ImageInput::open(path_);
    if (!file) return bad(OIIO::geterror());
    if (std::string_view(file->format_name()) != "openexr") return bad("is not an OpenEXR file");
    std::vector<OIIO::ImageSpec> parts;
    while (file->seek_subimage(static_cast<int>(parts.size()), 0)) {
      parts.push_back(file->spec());
      if (parts.back().deep) return bad("has deep pixels, must be flat");
    }
    const Channels channels(std::move(parts));
    const auto layer = [&](const char* brief, const char* full) {
      const auto found = channels.find(brief);
      return found ? found : channels.find(full);
    };
    const auto points = kind == VectorKind::kPoints ? layer("p", "position") : std::nullopt;
    const auto normals = layer("n", "normal");
    std::optional<Triple> first = kind == VectorKind::kPoints ? points : normals;
    if (!first) first = channels.find("");
    if (!first)
      return bad(fmt::format("has channels {}; must have {}.X, {}.Y, {}.Z, or X, Y, Z, or R, G, B",
                             channels.names(), kind == VectorKind::kPoints ? 'P' : 'N',
                             kind == VectorKind::kPoints ? 'P' : 'N',
                             kind == VectorKind::kPoints ? 'P' : 'N'));
    triples_ = {*first};
    if (points && normals) triples_.push_back(*normals);
    for (std::size_t t = 0; t < triples_.size(); ++t) {
      const bool is_point = kind == VectorKind::kPoints && t == 0;
      for (int i = 0; i < 3; ++i) {
        const OIIO::TypeDesc type = channels.type(triples_[t], i);
        if (type == OIIO::TypeDesc::FLOAT || (type == OIIO::TypeDesc::HALF && !is_point)) continue;
        return bad(fmt::format("channel {} is of type {}, must be {}",
                               channels.name(triples_[t], i), type.c_str(),
                               is_point ? "float" : "float or half"));
      }
    }
    const OIIO::ImageSpec& spec = channels.part(triples_.front());
    window_ = {spec.x,      spec.y,      spec.width,      spec.height,
               spec.full_x, spec.full_y, spec.full_width, spec.full_height};
    const OIIO::ImageSpec& other = channels.part(triples_.back());
    if (other.x != spec.x || other.y != spec.y || other.width != spec.width ||
        other.height != spec.height)
      return bad("has points and normals of different windows");
    return absl::OkStatus();
  }

  std::uint64_t rows() const override {
    return static_cast<std::uint64_t>(window_.width) * static_cast<std::uint64_t>(window_.height);
  }
  std::size_t columns() const override { return 3 * triples_.size(); }
  const MapWindow* window() const override { return &window_; }

  absl::Status read(std::uint64_t first, std::span<double> values) override {
    const std::uint64_t width = window_.width;
    const std::uint64_t end = first + values.size() / columns();
    double* to = values.data();
    for (std::uint64_t texel = first; texel < end;) {
      const std::uint64_t stop = std::min(end, (texel / width + 1) * width);
      const std::size_t count = stop - texel;
      for (std::size_t t = 0; t < triples_.size(); ++t) {
        LUCERNA_RETURN_IF_ERROR(read(triples_[t], texel, count, to + 3 * t));
      }
      to += count * columns();
      texel = stop;
    }
    return absl::OkStatus();
  }

 private:
  absl::Status bad(const std::string& what) const {
    return absl::InvalidArgumentError(path_ + ": " + what);
  }

  /// Texels of one row.
  absl::Status read(const Triple& triple, std::uint64_t texel, std::size_t count, double* to) {
    const auto [least, most] = std::minmax_element(triple.channels.begin(), triple.channels.end());
    const std::size_t channels = *most - *least + 1;
    buffer_.resize(count * channels);
    const int x = window_.x + static_cast<int>(texel % window_.width);
    const int y = window_.y + static_cast<int>(texel / window_.width);
    if (!cache_->get_pixels(OIIO::ustring(path_), triple.part, 0, x, x + static_cast<int>(count), y,
                            y + 1, 0, 1, *least, *most + 1, OIIO::TypeDesc::FLOAT, buffer_.data()))
      return bad(cache_->geterror());
    for (std::size_t i = 0; i < count; ++i) {
      for (int c = 0; c < 3; ++c)
        to[i * columns() + c] = buffer_[i * channels + (triple.channels[c] - *least)];
    }
    return absl::OkStatus();
  }

  std::string path_;
  std::unique_ptr<OIIO::ImageCache, void (*)(OIIO::ImageCache*)> cache_;
  MapWindow window_;
  std::vector<Triple> triples_;
  std::vector<float> buffer_;
};

class Writer final : public MapWriter {
 public:
  Writer(std::string path, std::unique_ptr<OIIO::ImageOutput> file, const MapWindow& window)
      : path_(std::move(path)), file_(std::move(file)), y_(window.y) {}

  absl::Status write_row(std::span<const float> values) override {
    if (!file_->write_scanline(y_, 0, OIIO::TypeDesc::FLOAT, values.data())) return failed();
    ++y_;
    return absl::OkStatus();
  }
  absl::Status close() override { return file_->close() ? absl::OkStatus() : failed(); }

 private:
  absl::Status failed() const { return absl::UnknownError(path_ + ": " + file_->geterror()); }

  std::string path_;
  std::unique_ptr<OIIO::ImageOutput> file_;
  int y_;
};

}  // namespace

absl::StatusOr<std::unique_ptr<VectorFile>> open_map(const std::string& path, VectorKind kind) {
  auto file = std::make_unique<MapFile>(path);
  LUCERNA_RETURN_IF_ERROR(file->open(kind));
  return file;
}

absl::StatusOr<std::unique_ptr<MapWriter>> MapWriter::create(
    const std::string& path, const MapWindow& window, const std::vector<std::string>& channels,
    const std::string& description) {
  auto file = OIIO::ImageOutput::create("openexr");
  if (!file) return absl::UnknownError(path + ": " + OIIO::geterror());
  OIIO::ImageSpec spec(window.width, window.height, static_cast<int>(channels.size()),
                       OIIO::TypeDesc::FLOAT);
  spec.x = window.x;
  spec.y = window.y;
  spec.full_x = window.full_x;
  spec.full_y = window.full_y;
  spec.full_width = window.full_width;
  spec.full_height = window.full_height;
  spec.channelnames = channels;
  spec.attribute("oiio:ColorSpace", "Linear");
  spec.attribute("compression", "zip");
  if (!description.empty()) spec.attribute("ImageDescription", description);
  if (!file->open(path, spec)) return absl::UnknownError(path + ": " + file->geterror());
  return std::make_unique<Writer>(path, std::move(file), window);
}

}  // namespace lucerna::client
