#include "tests/server/extremes/wire_scenes.h"

#include <fmt/format.h>

#include <algorithm>
#include <fstream>
#include <iterator>
#include <regex>
#include <set>

#include "proto/common/sha256.h"
#include "tests/paths.h"
#include "tests/server/extremes/extreme_files.h"
#include "tests/server/extremes/wire_answers.h"

namespace lucerna::testing {
namespace {

constexpr char kMain[] = "scene.pbrt";

std::string text_of(const std::vector<SceneLine>& lines) {
  std::string text;
  for (const SceneLine& line : lines) text += line.text + "\n";
  return text;
}

bool is_light(const SceneLine& line) {
  return std::ranges::find(light_kinds(), line.kind) != light_kinds().end();
}

void expect_answer(const grpc::Status& status, const google::protobuf::Message& response) {
  EXPECT_TRUE(status.ok()) << status.error_message();
  for (const std::string& wrong : wrong_numbers(response)) ADD_FAILURE() << wrong;
}

}  // namespace

WireScenes::WireScenes(Service& service, std::filesystem::path root)
    : service_(service), root_(std::move(root)) {
  const std::filesystem::path data(test_data());
  for (const char* file : {"reference/sky.exr", "reference/slide.exr", "reference/screen.exr",
                           "lights/downlight.ies", "lights/sconce.ldt"}) {
    std::ifstream in(data / file, std::ios::binary);
    write((data / file).filename(), {std::istreambuf_iterator<char>(in), {}});
  }
}

WireScene WireScenes::load(std::uint64_t number, ExtremeNumbers& numbers) {
  constexpr std::size_t kLights = 12;
  const SceneScale scale = SceneScale::random(numbers);
  for (const auto& [name, bytes] : extreme_files(numbers)) write(name, bytes);
  std::vector<SceneLine> lines;
  for (const std::string& line : head_lines(scale, numbers)) lines.push_back({"", line});
  for (std::size_t i = 0; i < kLights; ++i) {
    const auto& kinds = light_kinds();
    lines.push_back(light_line(kinds[(number * kLights + i) % kinds.size()], scale, numbers));
  }
  for (int i = 0; i < 3; ++i) lines.push_back(shape_line(scale, numbers));

  const bool upload = numbers.chance(1.0 / 8);
  static const std::regex kPlace("^[^:]*:([0-9]+):");
  WireScene scene;
  for (int refused = 1;; ++refused) {
    const grpc::Status s = load_text(lines, upload, &scene.id);
    if (s.ok()) break;
    std::smatch place;
    const std::string message = s.error_message();
    const bool placed = std::regex_search(message, place, kPlace);
    EXPECT_EQ(s.error_code(), grpc::StatusCode::INVALID_ARGUMENT) << message;
    EXPECT_TRUE(placed) << message;
    if (!placed || s.error_code() != grpc::StatusCode::INVALID_ARGUMENT) return {};
    ++refused_;
    // Draws another line of the same kind; after a few attempts, none.
    SceneLine& line = lines.at(std::stoul(place[1]) - 1);
    line = is_light(line) && refused % 4 != 0 ? light_line(line.kind, scale, numbers)
                                              : SceneLine{"", "# " + message.substr(0, 60)};
  }
  for (std::size_t i = 0; i < lines.size(); ++i)
    scene.kinds[fmt::format("{}:{}", kMain, i + 1)] = lines[i].kind;
  const auto mentions = [&](const char* words) { return text_.find(words) != std::string::npos; };
  scene.has_panes = mentions(R"("thindielectric")");
  scene.has_media = mentions("MediumInterface");
  static const std::regex kGrey(R"(sigma_a" \[(\S+) \1 \1\])"), kAny(R"(sigma_a" \[)");
  const auto count = [&](const std::regex& what) {
    return std::distance(std::sregex_iterator(text_.begin(), text_.end(), what), {});
  };
  scene.has_coloured_media = count(kGrey) < count(kAny);
  scene.has_signed_filter = mentions(R"("mitchell")") || mentions(R"("sinc")");
  return scene;
}

void WireScenes::release(const std::string& id) {
  auto request = about<v1::ReleaseSceneRequest>(id);
  const grpc::Status s = service_.status(request);
  EXPECT_TRUE(s.ok() || s.error_code() == grpc::StatusCode::NOT_FOUND) << s.error_message();
}

void WireScenes::write(const std::string& name, const std::string& bytes) {
  std::ofstream(root_ / name, std::ios::binary) << bytes;
  files_[name] = bytes;
}

grpc::Status WireScenes::load_text(const std::vector<SceneLine>& lines, bool upload,
                                   std::string* id) {
  text_ = text_of(lines);
  write(kMain, text_);
  v1::LoadSceneRequest request;
  if (upload)
    this->upload(request.mutable_manifest());
  else
    request.set_path(kMain);
  v1::LoadSceneResponse response;
  const grpc::Status s = service_.call(request, &response);
  ++items_["LoadScene"];
  *id = response.scene_id();
  for (const std::string& wrong : wrong_numbers(response)) ADD_FAILURE() << wrong;
  EXPECT_EQ(response.missing_size(), 0) << response.ShortDebugString();
  return s;
}

void WireScenes::upload(v1::SceneManifest* manifest) {
  v1::FindMissingAssetsRequest find;
  for (const auto& [name, bytes] : files_) {
    v1::NamedAsset* asset = manifest->add_assets();
    asset->set_name(name);
    asset->set_sha256(sha256(bytes));
    find.add_sha256(asset->sha256());
  }
  manifest->set_main(kMain);
  v1::FindMissingAssetsResponse missing;
  expect_answer(service_.call(find, &missing), missing);
  ++items_["FindMissingAssets"];
  const std::set<std::string> wanted(missing.missing_sha256().begin(),
                                     missing.missing_sha256().end());
  for (const v1::NamedAsset& asset : manifest->assets())
    if (wanted.contains(asset.sha256())) put(files_.at(asset.name()), asset.sha256());
}

void WireScenes::put(const std::string& bytes, const std::string& digest) {
  v1::UploadAssetRequest header, chunk;
  header.mutable_header()->set_sha256(digest);
  header.mutable_header()->set_size_bytes(bytes.size());
  chunk.set_chunk(bytes);
  v1::UploadAssetResponse response;
  grpc::ClientContext context;
  const auto stream = service_.scenes.UploadAsset(&context, &response);
  stream->Write(header);
  stream->Write(chunk);
  stream->WritesDone();
  expect_answer(stream->Finish(), response);
  ++items_["UploadAsset"];
}

}  // namespace lucerna::testing
