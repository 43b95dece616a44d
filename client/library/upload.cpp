#include "lucerna/client/upload.h"

#include <algorithm>
#include <chrono>
#include <condition_variable>
#include <filesystem>
#include <fstream>
#include <map>
#include <mutex>
#include <optional>
#include <set>
#include <utility>

#include "client/library/retry.h"
#include "proto/common/sha256.h"
#include "proto/common/status_macros.h"

namespace lucerna::client {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kChunkBytes = std::size_t{1} << 20;
constexpr int kTries = 5;  // attempts in a row without progress
// Most rounds, since files may name further files.  No real scene needs as many.
constexpr int kMostRounds = 100;

/// Waits; returns false if the call should end.
bool wait(std::chrono::milliseconds time, const CallOptions& options) {
  std::mutex mutex;
  std::unique_lock lock(mutex);
  std::condition_variable_any stopped;
  const auto end = std::min(CallOptions::Clock::now() + time, options.deadline);
  stopped.wait_until(lock, options.stop, end, [] { return false; });
  return !options.stop.stop_requested() && CallOptions::Clock::now() < options.deadline;
}

struct File {
  fs::path path;
  std::string digest;
  std::uint64_t size = 0;
};

absl::StatusOr<File> hashed(const fs::path& path) {
  std::ifstream in(path, std::ios::binary);
  if (!in) return absl::InvalidArgumentError(path.string() + ": cannot be read");
  File file{path, {}, 0};
  Sha256 sha;
  std::string chunk(kChunkBytes, '\0');
  while (in.read(chunk.data(), static_cast<std::streamsize>(chunk.size())), in.gcount() > 0) {
    sha.add(std::string_view(chunk).substr(0, static_cast<std::size_t>(in.gcount())));
    file.size += static_cast<std::uint64_t>(in.gcount());
  }
  if (in.bad()) return absl::InvalidArgumentError(path.string() + ": cannot be read");
  file.digest = sha.finish();
  return file;
}

class Upload {
 public:
  Upload(const Client& client, const UploadOptions& upload, const CallOptions& options)
      : client_(client), upload_(upload), options_(options) {}

  absl::Status begin(const std::string& path) {
    std::error_code error;
    const fs::path main = fs::canonical(path, error);
    if (error || !fs::is_regular_file(main, error))
      return absl::NotFoundError(path + ": no such file");
    root_ = upload_.root.empty() ? main.parent_path() : fs::canonical(upload_.root, error);
    if (error) return absl::NotFoundError(upload_.root + ": no such directory");
    const fs::path name = main.lexically_relative(root_);
    if (name.empty() || *name.begin() == "..")
      return absl::InvalidArgumentError(path + ": is not inside " + root_.string());
    request_.mutable_manifest()->set_main(name.generic_string());
    if (upload_.lease_s > 0) request_.set_lease_s(upload_.lease_s);
    if (upload_.blender) *request_.mutable_blender() = *upload_.blender;
    *request_.mutable_edits() = upload_.edits;
    return add(name.generic_string());
  }

  absl::StatusOr<v1::LoadSceneResponse> run() {
    for (int round = 0; round < kMostRounds; ++round) {
      absl::StatusOr<v1::LoadSceneResponse> response = client_.load_scene(request_, options_);
      if (!response.ok() || response->missing().empty()) return response;
      std::set<std::string> wanted;  // digests
      for (const v1::NamedAsset& asset : response->missing()) {
        if (!files_.contains(asset.name())) {
          LUCERNA_RETURN_IF_ERROR(add(asset.name()));
        }
        if (const std::string& digest = files_[asset.name()].digest; !digest.empty())
          wanted.insert(digest);
      }
      LUCERNA_RETURN_IF_ERROR(send(wanted));
    }
    return absl::InternalError("the server still requests files after 100 rounds");
  }

 private:
  /// Adds the file of this name to the manifest.  If it does not exist, the manifest states that.
  absl::Status add(const std::string& name) {
    v1::NamedAsset asset;
    asset.set_name(name);
    File& file = files_[name];
    std::error_code error;
    const fs::path path = fs::canonical(root_ / fs::path(name).relative_path(), error);
    if (!error && fs::is_regular_file(path, error)) {
      // Symbolic links out of the root are refused too.
      const fs::path within = path.lexically_relative(root_);
      if (within.empty() || *within.begin() == "..")
        return absl::InvalidArgumentError(name + ": is outside " + root_.string() +
                                          "; only files inside it are sent");
      LUCERNA_ASSIGN_OR_RETURN(File found, hashed(path));
      file = std::move(found);
      asset.set_sha256(file.digest);
      names_.try_emplace(file.digest, name);
    }
    *request_.mutable_manifest()->add_assets() = std::move(asset);
    return absl::OkStatus();
  }

  absl::Status send(const std::set<std::string>& digests) {
    v1::FindMissingAssetsRequest request;
    for (const std::string& digest : digests) request.add_sha256(digest);
    LUCERNA_ASSIGN_OR_RETURN(const auto missing, client_.find_missing_assets(request, options_));
    for (int i = 0; i < missing.missing_sha256_size(); ++i) {
      const auto name = names_.find(missing.missing_sha256(i));
      if (name == names_.end() || i >= missing.received_bytes_size())
        return absl::InternalError("the server requests a file that is not in the manifest");
      LUCERNA_RETURN_IF_ERROR(send(name->second, missing.received_bytes(i)));
    }
    return absl::OkStatus();
  }

  /// Sends until the server has the whole file.
  absl::Status send(const std::string& name, std::uint64_t offset) {
    const File& file = files_[name];
    std::chrono::milliseconds pause(50);
    for (int tries = 0;;) {
      const std::uint64_t before = offset;
      const absl::StatusOr<v1::UploadAssetResponse> sent = send_from(name, file, offset);
      if (sent.ok()) {
        if (sent->received_bytes() == file.size) return absl::OkStatus();
        return absl::InvalidArgumentError(file.path.string() + ": changed while it was sent");
      }
      const bool elsewhere = absl::IsFailedPrecondition(sent.status());
      if (!absl::IsUnavailable(sent.status()) && !elsewhere) return sent.status();
      if (!wait(retry_delay(sent.status()).value_or(pause), options_)) return sent.status();
      // Progress of another client that sends the same file also counts.
      v1::FindMissingAssetsRequest request;
      request.add_sha256(file.digest);
      const auto now = client_.find_missing_assets(request, options_);
      if (now.ok() && now->missing_sha256().empty()) return absl::OkStatus();
      if (now.ok()) offset = now->received_bytes(0);
      tries = offset > before ? 0 : tries + (elsewhere ? 0 : 1);
      if (tries == kTries) return sent.status();
      pause = std::min(2 * pause, std::chrono::milliseconds(2000));
    }
  }

  absl::StatusOr<v1::UploadAssetResponse> send_from(const std::string& name, const File& file,
                                                    std::uint64_t offset) {
    std::ifstream in(file.path, std::ios::binary);
    in.seekg(static_cast<std::streamoff>(offset));
    if (!in) return absl::InvalidArgumentError(file.path.string() + ": cannot be read");
    v1::AssetHeader header;
    header.set_sha256(file.digest);
    header.set_size_bytes(file.size);
    header.set_offset_bytes(offset);
    std::uint64_t at = offset;
    return client_.upload_asset(
        header,
        [&](std::string& chunk) {
          if (upload_.progress) upload_.progress({name, at, file.size});
          chunk.resize(kChunkBytes);
          in.read(chunk.data(), static_cast<std::streamsize>(chunk.size()));
          chunk.resize(static_cast<std::size_t>(in.gcount()));
          at += chunk.size();
          return !chunk.empty();
        },
        options_);
  }

  const Client& client_;
  const UploadOptions& upload_;
  const CallOptions& options_;
  fs::path root_;
  v1::LoadSceneRequest request_;
  /// By the name in the manifest.  A file without a digest does not exist.
  std::map<std::string, File> files_;
  std::map<std::string, std::string> names_;  // by digest, one name each
};

}  // namespace

absl::StatusOr<v1::LoadSceneResponse> upload_scene(const Client& client, const std::string& path,
                                                   const UploadOptions& upload,
                                                   const CallOptions& options) {
  Upload run(client, upload, options);
  LUCERNA_RETURN_IF_ERROR(run.begin(path));
  return run.run();
}

}  // namespace lucerna::client
