#include "client/files/map_file.h"

#include <ImfChannelList.h>
#include <ImfCompression.h>
#include <ImfFrameBuffer.h>
#include <ImfHeader.h>
#include <ImfInputPart.h>
#include <ImfMultiPartInputFile.h>
#include <ImfOutputFile.h>
#include <ImfPartType.h>
#include <ImfStandardAttributes.h>
#include <ImfStdIO.h>
#include <ImfTestFile.h>
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <cerrno>
#include <cstring>
#include <exception>
#include <filesystem>
#include <fstream>
#include <optional>
#include <string_view>
#include <utility>

#include "proto/common/status_macros.h"

namespace lucerna::client {
namespace {

constexpr std::size_t kMaxBufferFloats = std::size_t{8} << 20;  // 32 MiB
constexpr int kRowsPerRead = 32;  // OpenEXR compresses up to 32 scan lines together

std::string lower(std::string text) {
  std::transform(text.begin(), text.end(), text.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return text;
}

struct NamedChannel {
  std::string name;
  Imf::Channel channel;
};

/// Three channels of one part.
struct Triple {
  int part = 0;
  std::array<NamedChannel, 3> channels{};
};

/// The channels of the parts of a file.
class Channels {
 public:
  void add_part(const Imf::ChannelList& list) {
    auto& part = parts_.emplace_back();
    for (auto i = list.begin(); i != list.end(); ++i) part.push_back({i.name(), i.channel()});
  }

  /// The channels x, y and z of the layer.  If its name is empty, the channels without a layer.
  std::optional<Triple> find(const std::string& layer) const {
    for (const std::string_view names : {"xyz", "rgb"}) {
      for (std::size_t part = 0; part < parts_.size(); ++part) {
        Triple found{static_cast<int>(part), {}};
        const bool all = std::equal(names.begin(), names.end(), found.channels.begin(),
                                    [&](char name, NamedChannel& channel) {
                                      const auto* const there = find(parts_[part], layer, name);
                                      if (there != nullptr) channel = *there;
                                      return there != nullptr;
                                    });
        if (all) return found;
      }
    }
    return {};
  }

  std::string names() const {
    std::string all;
    for (const auto& part : parts_) {
      for (const NamedChannel& channel : part) all += (all.empty() ? "" : ", ") + channel.name;
    }
    return all;
  }

 private:
  /// Null if there is none.
  static const NamedChannel* find(const std::vector<NamedChannel>& part, const std::string& layer,
                                  char name) {
    const std::string wanted = layer.empty() ? std::string(1, name) : layer + "." + name;
    const std::string within = '.' + wanted;
    const auto found = std::ranges::find_if(part, [&](const NamedChannel& channel) {
      const std::string there = lower(channel.name);
      return there == wanted || (!layer.empty() && there.ends_with(within));
    });
    return found == part.end() ? nullptr : &*found;
  }

  std::vector<std::vector<NamedChannel>> parts_;
};

std::string_view type_name(Imf::PixelType type) {
  switch (type) {
    case Imf::UINT:
      return "uint";
    case Imf::HALF:
      return "half";
    default:
      return "float";
  }
}

/// Rows of one triple that were read: `channels` of each texel side by side.
struct RowBuffer {
  int first = 0;
  int end = 0;
  std::vector<float> values{};
};

class MapFile final : public VectorFile {
 public:
  explicit MapFile(std::string path) : path_(std::move(path)) {}

  absl::Status open(VectorKind kind) {
    if (std::filesystem::exists(path_) && !Imf::isOpenExrFile(path_.c_str()))
      return bad("is not an OpenEXR file");
    try {
      file_ = std::make_unique<Imf::MultiPartInputFile>(path_.c_str());
      return choose_channels(kind);
    } catch (const std::exception& error) {
      return bad(error.what());
    }
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
        LUCERNA_RETURN_IF_ERROR(read(t, texel, count, to + 3 * t));
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

  absl::Status choose_channels(VectorKind kind) {
    Channels channels;
    for (int part = 0; part < file_->parts(); ++part) {
      const Imf::Header& header = file_->header(part);
      if (header.hasType() && Imf::isDeepData(header.type()))
        return bad("has deep pixels, must be flat");
      channels.add_part(header.channels());
    }
    const auto layer = [&](const char* brief, const char* full) {
      const auto found = channels.find(brief);
      return found ? found : channels.find(full);
    };
    const auto points = kind == VectorKind::kPoints ? layer("p", "position") : std::nullopt;
    const auto normals = layer("n", "normal");
    std::optional<Triple> first = kind == VectorKind::kPoints ? points : normals;
    if (!first) first = channels.find("");
    const char letter = kind == VectorKind::kPoints ? 'P' : 'N';
    if (!first)
      return bad(fmt::format("has channels {}; must have {}.X, {}.Y, {}.Z, or X, Y, Z, or R, G, B",
                             channels.names(), letter, letter, letter));
    triples_ = {*first};
    if (points && normals) triples_.push_back(*normals);
    for (std::size_t t = 0; t < triples_.size(); ++t)
      LUCERNA_RETURN_IF_ERROR(check_types(triples_[t], kind == VectorKind::kPoints && t == 0));
    return find_window();
  }

  absl::Status check_types(const Triple& triple, bool is_point) const {
    for (const auto& [name, channel] : triple.channels) {
      if (channel.type != Imf::FLOAT && (channel.type != Imf::HALF || is_point))
        return bad(fmt::format("channel {} is of type {}, must be {}", name,
                               type_name(channel.type), is_point ? "float" : "float or half"));
      if (channel.xSampling != 1 || channel.ySampling != 1)
        return bad(fmt::format("channel {} is subsampled by {} x {}, must have every texel", name,
                               channel.xSampling, channel.ySampling));
    }
    return absl::OkStatus();
  }

  absl::Status find_window() {
    const Imf::Header& header = file_->header(triples_.front().part);
    const Imath::Box2i& data = header.dataWindow();
    const Imath::Box2i& shown = header.displayWindow();
    window_ = {
        data.min.x,  data.min.y,  data.max.x - data.min.x + 1,   data.max.y - data.min.y + 1,
        shown.min.x, shown.min.y, shown.max.x - shown.min.x + 1, shown.max.y - shown.min.y + 1};
    if (file_->header(triples_.back().part).dataWindow() != data)
      return bad("has points and normals of different windows");
    buffers_.resize(triples_.size());
    return absl::OkStatus();
  }

  /// Texels of one row.
  absl::Status read(std::size_t t, std::uint64_t texel, std::size_t count, double* to) {
    const int y = window_.y + static_cast<int>(texel / window_.width);
    RowBuffer& buffer = buffers_[t];
    if (y < buffer.first || y >= buffer.end) LUCERNA_RETURN_IF_ERROR(read_rows(t, y));
    const float* from =
        buffer.values.data() +
        3 * (static_cast<std::size_t>(y - buffer.first) * window_.width + texel % window_.width);
    for (std::size_t i = 0; i < count; ++i, from += 3) std::copy_n(from, 3, to + i * columns());
    return absl::OkStatus();
  }

  /// Fills the triple's buffer with rows from `y` on.
  absl::Status read_rows(std::size_t t, int y) {
    RowBuffer& buffer = buffers_[t];
    const auto row = 3 * static_cast<std::size_t>(window_.width);
    const int most = static_cast<int>(
        std::clamp<std::size_t>(kMaxBufferFloats / row / triples_.size(), 1, kRowsPerRead));
    // Starts at a multiple of the rows, where groups of compressed scan lines start.
    const int first = y - (y - window_.y) % most;
    const int end = std::min(first + most, window_.y + window_.height);
    buffer = {.first = y, .end = y, .values = std::move(buffer.values)};
    try {
      buffer.values.resize(row * static_cast<std::size_t>(end - first));
      Imf::InputPart part(*file_, triples_[t].part);
      Imf::FrameBuffer slices;
      const std::size_t texel = 3 * sizeof(float);
      for (std::size_t c = 0; c < 3; ++c) {
        slices.insert(triples_[t].channels[c].name,
                      Imf::Slice::Make(Imf::FLOAT, buffer.values.data() + c,
                                       Imath::Box2i({window_.x, first},
                                                    {window_.x + window_.width - 1, end - 1}),
                                       texel, row * sizeof(float)));
      }
      part.setFrameBuffer(slices);
      part.readPixels(first, end - 1);
    } catch (const std::exception& error) {
      return bad(error.what());
    }
    buffer.first = first;
    buffer.end = end;
    return absl::OkStatus();
  }

  std::string path_;
  std::unique_ptr<Imf::MultiPartInputFile> file_;
  MapWindow window_;
  std::vector<Triple> triples_;
  std::vector<RowBuffer> buffers_;  ///< one per triple
};

class Writer final : public MapWriter {
 public:
  Writer(std::string path, const MapWindow& window, std::vector<std::string> channels)
      : path_(std::move(path)), window_(window), channels_(std::move(channels)) {}

  absl::Status open(const std::string& description) {
    bytes_.open(path_, std::ios::binary);
    if (!bytes_) return failed(std::strerror(errno));
    const auto box = [](int x, int y, int width, int height) {
      return Imath::Box2i({x, y}, {x + width - 1, y + height - 1});
    };
    Imf::Header header(box(window_.full_x, window_.full_y, window_.full_width, window_.full_height),
                       box(window_.x, window_.y, window_.width, window_.height));
    header.compression() = Imf::ZIP_COMPRESSION;
    for (const std::string& channel : channels_)
      header.channels().insert(channel, Imf::Channel(Imf::FLOAT));
    if (!description.empty()) Imf::addComments(header, description);
    try {
      stream_ = std::make_unique<Imf::StdOFStream>(bytes_, path_.c_str());
      file_ = std::make_unique<Imf::OutputFile>(*stream_, header);
    } catch (const std::exception& error) {
      return failed(error.what());
    }
    return absl::OkStatus();
  }

  absl::Status write_row(std::span<const float> values) override {
    const std::size_t texel = channels_.size() * sizeof(float);
    const int y = window_.y + rows_++;
    try {
      Imf::FrameBuffer slices;
      for (std::size_t c = 0; c < channels_.size(); ++c) {
        slices.insert(channels_[c],
                      Imf::Slice::Make(
                          Imf::FLOAT, values.data() + c,
                          Imath::Box2i({window_.x, y}, {window_.x + window_.width - 1, y}), texel));
      }
      file_->setFrameBuffer(slices);
      file_->writePixels(1);
    } catch (const std::exception& error) {
      return failed(error.what());
    }
    return absl::OkStatus();
  }

  // OpenEXR writes the table of rows when its file object is destroyed, and ignores errors there.
  // The stream keeps them.
  absl::Status close() override {
    file_.reset();
    bytes_.close();
    return bytes_ ? absl::OkStatus() : failed("cannot be written in full");
  }

 private:
  absl::Status failed(const std::string& why) const {
    return absl::UnknownError(path_ + ": " + why);
  }

  std::string path_;
  MapWindow window_;
  std::vector<std::string> channels_;
  int rows_ = 0;
  std::ofstream bytes_;
  std::unique_ptr<Imf::StdOFStream> stream_;
  std::unique_ptr<Imf::OutputFile> file_;  ///< last member: destroyed first
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
  auto writer = std::make_unique<Writer>(path, window, channels);
  LUCERNA_RETURN_IF_ERROR(writer->open(description));
  return writer;
}

}  // namespace lucerna::client
