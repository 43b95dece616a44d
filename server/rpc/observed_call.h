// What unary calls and streams have in common: the record, the statistics and the log of a call.
#pragma once

#include <absl/status/status.h>
#include <google/protobuf/message.h>
#include <grpcpp/alarm.h>
#include <grpcpp/server_context.h>
#include <grpcpp/support/byte_buffer.h>

#include <atomic>
#include <chrono>
#include <memory>
#include <optional>
#include <stop_token>
#include <string>

#include "lucerna/v1/accuracy.pb.h"
#include "server/monitor/call_record.h"
#include "server/rpc/runtime.h"
#include "server/runtime/parallel.h"

namespace lucerna::rpc {

/// One call from its arrival to its end.  Not thread-safe, like the steps of a call.
class ObservedCall {
 public:
  ObservedCall(Runtime& runtime, grpc::CallbackServerContext& context, monitor::Call call);
  /// Its answers have been sent.
  ~ObservedCall();
  ObservedCall(const ObservedCall&) = delete;
  ObservedCall& operator=(const ObservedCall&) = delete;

  /// Admits the call, by the header "authorization".  Errors: those of access::Access::admit.
  absl::Status admit();
  /// Anybody before the call is admitted.
  const access::Caller& caller() const { return admission_.caller; }

  /// Counts the items of the call against the caller's quota.  RESOURCE_EXHAUSTED with a RetryInfo
  /// if the caller has computed too many in the last time.
  absl::Status take_items(std::uint64_t items);
  /// Counts the work so far as items, beyond those taken: one for each kItemSeconds of processor
  /// time.  So a call of few items and many samples counts what it computes.  Nothing is counted
  /// for a call without items.
  void count_work();

  monitor::CallRecord& record() { return record_; }
  /// The job's time in the queue of `lane`.
  void add_queue_time(Lane lane, double seconds);
  /// Who sends the call, for the turns of clients in a lane: the name of its token, or the address
  /// without its port.
  std::string client() const;
  /// The connection of the call, for turns within a client.  Only compared.  Null: not known.
  const void* connection() const { return connection_.get(); }
  LaneJob::Clock::time_point deadline() const { return deadline_; }

  /// Counts a call that was cancelled.  Call it in OnCancel().
  void cancelled() const;
  /// Counts the bytes of a message.
  void message_taken(std::size_t bytes);
  /// The client sends no more.
  void request_complete();
  /// RESOURCE_EXHAUSTED with a RetryInfo if many bytes wait until the client takes them, or if
  /// those of all clients leave no room for `bytes` more.
  absl::Status room_for_answers(std::size_t bytes = 0) const;
  /// Counts bytes from the moment that they are ready until gRPC has sent them.
  void answer_begun(std::size_t bytes);
  void answer_sent(std::size_t bytes);
  /// Counts and logs the call, and sends its id as trailing metadata.  Returns the status for
  /// gRPC.  Call it once, just before the call's Finish().
  grpc::Status end(const absl::Status& status);

 private:
  Runtime& runtime_;
  grpc::CallbackServerContext& context_;
  LaneJob::Clock::time_point deadline_;
  std::chrono::steady_clock::time_point arrived_ = std::chrono::steady_clock::now();
  monitor::CallRecord record_;
  std::string token_;                       // its name, or empty
  std::shared_ptr<Connection> connection_;  // null: not known
  std::uint64_t unsent_bytes_ = 0;
  std::uint64_t held_bytes_ = 0;  // of the message that was taken last
  bool has_request_ = false;      // which is not complete
  access::Admission admission_;
  std::uint64_t items_ = 0;  // that are counted against the quota
};

/// Stops work that takes longer than a call without a deadline may.  Does nothing for a call with a
/// deadline.
class ComputeLimit {
 public:
  /// `used_s`: time that the call has computed before.
  ComputeLimit(const Runtime& runtime, LaneJob::Clock::time_point deadline, std::stop_source stop,
               double used_s = 0);

  /// The status of work that was stopped: by this limit, by the deadline, or by the client.
  absl::Status stopped_status() const;

 private:
  double limit_s_;
  LaneJob::Clock::time_point deadline_;
  std::shared_ptr<std::atomic<bool>> passed_;
  std::optional<grpc::Alarm> alarm_;  // cancelled when the work ends
};

/// Adds the time of work on this thread to the record of its call, until it is destroyed.
class WorkTime {
 public:
  explicit WorkTime(monitor::CallRecord& record) : record_(record) {}
  ~WorkTime() {
    record_.cpu_s += meter_.seconds();
    record_.compute_s += std::chrono::duration<double>(Clock::now() - begin_).count();
  }
  WorkTime(const WorkTime&) = delete;
  WorkTime& operator=(const WorkTime&) = delete;

 private:
  using Clock = std::chrono::steady_clock;
  monitor::CallRecord& record_;
  const Clock::time_point begin_ = Clock::now();
  const CpuMeter meter_;
};

/// Parses the bytes, and frees them.  Drops unknown fields.  MALFORMED_MESSAGE with the parser's
/// reason if they are not a message of this type.
absl::Status parse_message(const grpc::ByteBuffer& bytes, google::protobuf::Message& message);
/// INTERNAL if the message is too large for Protobuf.
absl::Status encode_message(const google::protobuf::Message& message, grpc::ByteBuffer& bytes);

/// Directs Protobuf's messages to the log, and the parser's reasons to parse_message().  For the
/// whole process.
void set_up_protobuf_log();

void add_counts(const v1::Cost& cost, monitor::CallRecord& record);
void set_times(const monitor::CallRecord& record, v1::Cost* cost);

}  // namespace lucerna::rpc
