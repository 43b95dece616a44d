#include "lucerna/client/render_job.h"

#include <algorithm>
#include <bit>
#include <chrono>
#include <map>
#include <numeric>
#include <optional>
#include <utility>

#include "client/library/batch_parts.h"
#include "client/library/journal.h"
#include "proto/common/sample_blocks.h"
#include "proto/common/sha256.h"
#include "proto/common/status_macros.h"

namespace lucerna::client {
namespace {

constexpr std::uint32_t kDefaultTileSize = 64;
constexpr std::uint32_t kDefaultSamples = 64;  // the default of RenderImage

/// The pieces of one picture.
class Render final : public DistributedWork {
 public:
  explicit Render(const RenderJobOptions& options) : options_(options) {}

  /// Lays out the pieces, and finds those in the journal.
  absl::Status begin(const v1::SceneSummary& scene,
                     const v1::GetServerInfoResponse& server) override {
    scene_ = scene;
    const v1::RenderImageRequest& request = options_.request;
    const std::uint32_t edge = request.has_tile_size() ? request.tile_size() : kDefaultTileSize;
    if (edge == 0) return absl::InvalidArgumentError("tile_size = 0, allowed: at least 1");
    v1::RenderImageRequest named = request;
    named.set_scene_id(scene_.scene_id());
    named.set_tile_size(edge);
    if (request.accuracy().has_time_budget_s())
      return absl::InvalidArgumentError(
          "accuracy.time_budget_s: not allowed in a job, whose tiles wait for servers; set samples "
          "or a target error");
    if (request.accuracy().has_target_error()) {
      LUCERNA_RETURN_IF_ERROR(lay_out_by_area(edge));
      return open_journal(named, server);
    }
    const std::uint32_t hint =
        scene_.samples_per_pixel() > 0 ? scene_.samples_per_pixel() : kDefaultSamples;
    const std::uint32_t samples =
        request.accuracy().has_samples() ? request.accuracy().samples() : hint;
    if (samples == 0) return absl::InvalidArgumentError("accuracy.samples = 0, allowed: 1 or more");
    per_block_ = request.has_samples_per_block() ? request.samples_per_block()
                                                 : default_samples_per_block(samples, kTileBlocks);
    if (!std::has_single_bit(per_block_) || samples % per_block_ != 0)
      return absl::InvalidArgumentError("samples_per_block = " + std::to_string(per_block_) +
                                        ", allowed: a power of two that divides " +
                                        std::to_string(samples) + " samples");
    LUCERNA_RETURN_IF_ERROR(lay_out(samples / per_block_, edge));
    named.mutable_accuracy()->set_samples(samples);
    named.set_samples_per_block(per_block_);
    return open_journal(named, server);
  }

  /// Removes the pieces that the journal has from the pieces to do.
  absl::Status open_journal(const v1::RenderImageRequest& named,
                            const v1::GetServerInfoResponse& server) {
    if (options_.journal.empty()) return absl::OkStatus();
    std::string job = named.SerializeAsString() + std::to_string(options_.samples_per_piece);
    if (!options_.job.allow_mixed) job += server.fingerprint().digest();
    LUCERNA_ASSIGN_OR_RETURN(journal_, Journal::open(options_.journal, hexadecimal(sha256(job)),
                                                     [this](const std::string& record) {
                                                       return from_journal(record);
                                                     }));
    std::erase_if(to_do_, [this](std::size_t piece) { return done_[piece]; });
    return absl::OkStatus();
  }

  std::size_t size() const override { return to_do_.size(); }

  void start(std::size_t number, const Client& client, const std::string& scene_id,
             const CallOptions& options, Done done) override {
    const Piece piece = this->piece(to_do_[number]);
    v1::RenderTileRequest request;
    request.set_scene_id(scene_id);
    *request.mutable_rect() = piece.rect;
    request.set_seed(options_.request.seed());
    if (options_.request.has_bounces()) request.set_bounces(options_.request.bounces());
    if (options_.request.has_time_s()) request.set_time_s(options_.request.time_s());
    if (options_.request.has_shutter()) *request.mutable_shutter() = options_.request.shutter();
    *request.mutable_accuracy() = options_.request.accuracy();
    request.set_intervals(options_.request.intervals());
    request.set_one_sequence(options_.request.one_sequence());
    if (by_area_) {
      if (options_.request.has_samples_per_block())
        request.set_samples_per_block(options_.request.samples_per_block());
    } else {
      request.mutable_accuracy()->set_samples(
          static_cast<std::uint32_t>(piece.blocks * per_block_));
      request.set_samples_per_block(per_block_);
      request.set_first_sample(piece.first_block * per_block_);
    }
    client.render_tile(request, options, answer_as<v1::RenderTileResponse>(std::move(done)));
  }

  absl::Status accept(std::size_t number, Result result) override {
    auto& response = static_cast<v1::RenderTileResponse&>(*result);
    const Piece piece = this->piece(to_do_[number]);
    if (!same_rect(response.tile().rect(), piece.rect) ||
        response.tile().first_block() != piece.first_block ||
        !has_blocks_of(response.tile(), piece))
      return absl::InternalError("a server returned another tile than requested");
    client::append_cost(response.cost(), &cost_);
    if (journal_) {
      LUCERNA_RETURN_IF_ERROR(journal_->add(response.tile().SerializeAsString()));
    }
    return take(to_do_[number], std::move(*response.mutable_tile()));
  }

  absl::StatusOr<Picture> picture() const { return assembler_.picture(); }
  std::size_t pieces() const { return done_.size(); }
  const v1::Cost& cost() const { return cost_; }

 private:
  struct BlockRun {
    std::uint64_t first, blocks;
  };
  struct Piece {
    v1::PixelRect rect;
    std::uint64_t first_block, blocks;
    std::size_t tile;  // pieces of one tile are added in the order of their blocks
  };

  /// Pieces are numbered so that the first samples of all tiles come first, then the further
  /// samples.
  Piece piece(std::size_t number) const {
    const std::uint64_t tiles = across_ * down_, tile = number % tiles;
    const BlockRun& run = runs_[static_cast<std::size_t>(number / tiles)];
    Piece piece{{}, run.first, run.blocks, static_cast<std::size_t>(tile)};
    const auto x = static_cast<std::uint32_t>(tile % across_ * edge_),
               y = static_cast<std::uint32_t>(tile / across_ * edge_);
    piece.rect.set_x0(x);
    piece.rect.set_y0(y);
    piece.rect.set_x1(x + std::min(edge_, scene_.image_width() - x));
    piece.rect.set_y1(y + std::min(edge_, scene_.image_height() - y));
    return piece;
  }

  bool has_blocks_of(const v1::Tile& tile, const Piece& piece) const {
    if (by_area_) return !tile.samples().empty();
    return tile.block_count() == piece.blocks &&
           tile.moments().empty() != options_.request.intervals();
  }

  /// The number of the piece that equals the tile; nothing if no piece does.
  std::optional<std::size_t> number_of(const v1::Tile& tile) const {
    const auto before = [](const BlockRun& run, std::uint64_t first) { return run.first < first; };
    const auto run = std::lower_bound(runs_.begin(), runs_.end(), tile.first_block(), before);
    const std::uint64_t x = tile.rect().x0() / edge_, y = tile.rect().y0() / edge_;
    if (run == runs_.end() || run->first != tile.first_block() || x >= across_ || y >= down_)
      return std::nullopt;
    const auto number = static_cast<std::size_t>(
        (static_cast<std::uint64_t>(run - runs_.begin()) * down_ + y) * across_ + x);
    const Piece piece = this->piece(number);
    if (!same_rect(piece.rect, tile.rect()) || !has_blocks_of(tile, piece)) return std::nullopt;
    return number;
  }

  /// With a target error each pixel has its own block length, so tiles are not split by samples.
  absl::Status lay_out_by_area(std::uint32_t edge) {
    if (options_.samples_per_piece > 0)
      return absl::InvalidArgumentError(
          "samples_per_piece = " + std::to_string(options_.samples_per_piece) +
          ", allowed with a target error: 0, since its tiles cannot be split by samples");
    by_area_ = true;
    return lay_out(1, edge);
  }

  absl::Status lay_out(std::uint64_t blocks, std::uint32_t edge) {
    const std::uint64_t most =
        options_.samples_per_piece == 0
            ? blocks
            : std::max<std::uint64_t>(1, options_.samples_per_piece / per_block_);
    edge_ = edge;
    across_ = (std::uint64_t{scene_.image_width()} + edge - 1) / edge;
    down_ = (std::uint64_t{scene_.image_height()} + edge - 1) / edge;
    for (std::uint64_t first = 0; first < blocks; first += runs_.back().blocks) {
      runs_.push_back({first, std::min(aligned_run(first, blocks), std::bit_floor(most))});
      if (across_ * down_ * runs_.size() > kMostPieces)
        return absl::InvalidArgumentError(
            "the picture has more than " + std::to_string(kMostPieces) +
            " pieces, the limit; use larger tiles or more samples for each piece");
    }
    const std::uint64_t pieces = across_ * down_ * runs_.size();
    waiting_.resize(static_cast<std::size_t>(across_ * down_));
    next_block_.resize(waiting_.size());
    done_.resize(static_cast<std::size_t>(pieces));
    to_do_.resize(done_.size());
    std::iota(to_do_.begin(), to_do_.end(), std::size_t{0});
    return absl::OkStatus();
  }

  absl::Status from_journal(const std::string& record) {
    v1::Tile tile;
    const auto number = tile.ParseFromString(record) ? number_of(tile) : std::nullopt;
    if (!number)
      return absl::FailedPreconditionError(options_.journal +
                                           ": has a record that is not a piece of this job");
    // A second record of a piece (two jobs shared the journal) has the same bits.
    if (done_[*number]) return absl::OkStatus();
    return take(*number, std::move(tile));
  }

  absl::Status take(std::size_t number, v1::Tile tile) {
    const Piece piece = this->piece(number);
    done_[number] = true;
    auto& waiting = waiting_[piece.tile];
    waiting.emplace(piece.first_block, std::move(tile));
    std::uint64_t& next = next_block_[piece.tile];
    while (!waiting.empty() && waiting.begin()->first == next) {
      const v1::Tile& first = waiting.begin()->second;
      LUCERNA_RETURN_IF_ERROR(assembler_.add(first));
      if (options_.on_tile) options_.on_tile(first, assembler_);
      next += first.block_count();
      waiting.erase(waiting.begin());
    }
    return absl::OkStatus();
  }

  const RenderJobOptions& options_;
  v1::SceneSummary scene_;
  std::uint32_t per_block_ = 1;
  bool by_area_ = false;        // each tile is one piece with all of its samples
  std::vector<BlockRun> runs_;  // of blocks, in order
  std::uint32_t edge_ = 1;
  std::uint64_t across_ = 0, down_ = 0;  // tiles
  std::vector<std::size_t> to_do_;       // pieces, by number
  std::vector<bool> done_;
  std::vector<std::map<std::uint64_t, v1::Tile>> waiting_;  // of each tile, by first block
  std::vector<std::uint64_t> next_block_;                   // of each tile
  PictureAssembler assembler_;
  std::optional<Journal> journal_;
  v1::Cost cost_;
};

}  // namespace

absl::StatusOr<RenderJobResult> run_render_job(const RenderJobOptions& options) {
  const auto begun = std::chrono::steady_clock::now();
  Render render(options);
  LUCERNA_ASSIGN_OR_RETURN(auto report, run_job(render, options.job));
  LUCERNA_ASSIGN_OR_RETURN(Picture picture, render.picture());
  RenderJobResult result{std::move(picture), std::move(report), render.pieces(),
                         render.pieces() - render.size(), render.cost()};
  const std::chrono::duration<double> wall = std::chrono::steady_clock::now() - begun;
  result.cost.set_wall_time_s(wall.count());
  return result;
}

}  // namespace lucerna::client
