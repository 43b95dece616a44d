// Quotas of callers over the wire: items a second, and bytes of uploaded files.
#include <gmock/gmock.h>

#include <fstream>
#include <mutex>
#include <vector>

#include "every_query.h"
#include "proto/common/sha256.h"
#include "tests/temp_directory.h"

namespace lucerna::testing {
namespace {

using ::testing::HasSubstr;

/// A server with tokens.  The token of the caller NAME is "the secret of NAME".
class Quotas : public ::testing::Test {
 protected:
  Quotas() {
    add("loader", "roles = [\"load\"]");
    service_ = std::make_unique<Service>(options());
    grpc::ClientContext context;
    authorize(context, "loader");
    v1::LoadSceneRequest request;
    request.set_path("point.pbrt");
    v1::LoadSceneResponse response;
    const grpc::Status s = service_->scenes.LoadScene(&context, request, &response);
    EXPECT_TRUE(s.ok()) << s.error_message();
    scene_ = response.scene_id();
  }

  rpc::ServerOptions options() {
    rpc::ServerOptions options = service_options();
    options.connections.token_file = (directory_.path() / "tokens.toml").string();
    options.on_call = [this](const monitor::CallRecord& record) {
      const std::lock_guard lock(mutex_);
      callers_.push_back(record.caller);
    };
    return options;
  }
  void add(const std::string& name, const std::string& rest) {
    std::ofstream(directory_.path() / "tokens.toml", std::ios::app)
        << "[[token]]\nname = \"" << name << "\"\ntoken = \"the secret of " << name << "\"\n"
        << rest << "\n";
    if (service_ == nullptr) return;
    const absl::Status reloaded = service_->server->reload(options());
    EXPECT_TRUE(reloaded.ok()) << reloaded;
  }
  static void authorize(grpc::ClientContext& context, const std::string& name) {
    context.AddMetadata("authorization", "Bearer the secret of " + name);
  }

  /// A call with some hundred items that computes little.
  using Call = std::function<grpc::Status(grpc::ClientContext*)>;

  /// The first call of `name` may have more items than the rate.  The second is minutes too early.
  void expect_counts(const std::string& name, const Call& call) {
    SCOPED_TRACE(name);
    add(name, "roles = [\"query\"]\nmax-items-per-second = 1");
    grpc::ClientContext first, second;
    authorize(first, name);
    const grpc::Status good = call(&first);
    EXPECT_TRUE(good.ok()) << good.error_message();
    authorize(second, name);
    const grpc::Status refused = call(&second);
    expect_error(refused, grpc::StatusCode::RESOURCE_EXHAUSTED, "\"" + name + "\" requested ");
    EXPECT_THAT(refused.error_message(), HasSubstr(" items, allowed: 1 per second"));
    EXPECT_EQ(detail<google::rpc::ErrorInfo>(refused).reason(), "OVER_QUOTA");
    const auto delay = detail<google::rpc::RetryInfo>(refused).retry_delay();
    EXPECT_GT(delay.seconds() + 1e-9 * delay.nanos(), 0);
  }

  TempDirectory directory_;
  std::mutex mutex_;
  std::vector<std::string> callers_;
  std::unique_ptr<Service> service_;
  std::string scene_;
};

TEST_F(Quotas, EveryQueryCountsItsItems) {
  for_each_query(scene_, 150, [&]<typename Request>(const Request& q) {
    ResponseTo<Request> r;
    expect_counts(q.GetTypeName(),
                  [&](grpc::ClientContext* c) { return service_->call(c, q, &r); });
  });
}

// Items of many samples count by the processor time that they took.
TEST_F(Quotas, CallsCountWhatTheyCompute) {
  add("farm", "roles = [\"query\"]\nmax-items-per-second = 10");
  auto q = about<v1::EstimatePowerRequest>(scene_);
  for (int i = 0; i < 9; ++i) q.add_light_ids(1);
  q.set_method(v1::EstimatePowerRequest::METHOD_SAMPLED);
  q.mutable_accuracy()->set_samples(1 << 20);
  const auto estimate = [&] {
    grpc::ClientContext context;
    authorize(context, "farm");
    v1::EstimatePowerResponse r;
    return service_->lighting.EstimatePower(&context, q, &r);
  };
  const grpc::Status first = estimate();
  EXPECT_TRUE(first.ok()) << first.error_message();
  q.mutable_light_ids()->Truncate(1);
  EXPECT_EQ(estimate().error_code(), grpc::StatusCode::RESOURCE_EXHAUSTED);
}

TEST_F(Quotas, PowersCountAllLights) {
  add("farm", "roles = [\"query\"]\nmax-items-per-second = 1");
  auto q = about<v1::EstimatePowerRequest>(scene_);
  for (int i = 0; i < 7; ++i) q.add_light_ids(1);
  q.set_page_size(1);
  grpc::Status status;
  for (int i = 0; i < 2; ++i) {
    grpc::ClientContext context;
    authorize(context, "farm");
    v1::EstimatePowerResponse r;
    status = service_->lighting.EstimatePower(&context, q, &r);
  }
  EXPECT_THAT(status.error_message(), HasSubstr("requested 7 items"));
}

TEST_F(Quotas, ANewFileChangesTheRateAtOnce) {
  add("farm", "roles = [\"query\"]\nmax-items-per-second = 1");
  const auto sample = [&] {
    grpc::ClientContext context;
    authorize(context, "farm");
    auto q = about<v1::SampleLiRequest>(scene_);
    q.mutable_receivers()->mutable_offsets_m()->Resize(3000, 0.5F);
    q.mutable_seed();
    v1::SampleLiResponse r;
    return service_->lighting.SampleLi(&context, q, &r);
  };
  EXPECT_TRUE(sample().ok());
  EXPECT_EQ(sample().error_code(), grpc::StatusCode::RESOURCE_EXHAUSTED);
  std::ofstream(directory_.path() / "tokens.toml") << "";
  add("farm", "roles = [\"query\"]\nmax-items-per-second = 1000000000");
  const grpc::Status after = sample();
  EXPECT_TRUE(after.ok()) << after.error_message();
}

TEST_F(Quotas, UploadsAreRefusedBeforeTheirBytesAreRead) {
  add("farm", "roles = [\"load\"]\nmax-asset-bytes = 100");
  const auto upload = [&](std::uint64_t size, bool with_bytes) {
    grpc::ClientContext context;
    authorize(context, "farm");
    v1::UploadAssetResponse response;
    const auto stream = service_->scenes.UploadAsset(&context, &response);
    v1::UploadAssetRequest message;
    const std::string bytes(size, static_cast<char>(size));
    message.mutable_header()->set_sha256(sha256(bytes));
    message.mutable_header()->set_size_bytes(size);
    stream->Write(message);
    message.set_chunk(bytes);
    if (with_bytes) {
      stream->Write(message);
      stream->WritesDone();
    }
    return stream->Finish();  // without bytes, the server ends the stream after the header
  };
  EXPECT_TRUE(upload(60, true).ok());
  const grpc::Status refused = upload(41, false);
  EXPECT_EQ(refused.error_code(), grpc::StatusCode::RESOURCE_EXHAUSTED);
  EXPECT_EQ(refused.error_message(),
            "a file of 41 bytes: files of \"farm\" take 60 bytes, 60 of them lately used, "
            "allowed: 100");
  EXPECT_EQ(detail<google::rpc::ErrorInfo>(refused).reason(), "OVER_QUOTA");
  EXPECT_TRUE(upload(40, true).ok());
}

// The log has the name of the token, also of a call that is refused.
TEST_F(Quotas, RecordsNameTheCaller) {
  const auto call = [&](const std::string& header) {
    grpc::ClientContext context;
    context.AddMetadata("authorization", header);
    v1::GetStatsResponse r;
    return service_->admin.GetStats(&context, {}, &r).error_code();
  };
  EXPECT_EQ(call("Bearer the secret of loader"), grpc::StatusCode::PERMISSION_DENIED);
  EXPECT_EQ(call("Bearer the secret of nobody"), grpc::StatusCode::UNAUTHENTICATED);
  service_.reset();
  EXPECT_THAT(callers_, ::testing::ElementsAre("loader", "loader", ""));
}

}  // namespace
}  // namespace lucerna::testing
