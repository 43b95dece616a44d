#include "tests/reliability/traffic.h"

namespace lucerna::reliability {
namespace {

// Ends programs that hang.
constexpr Seconds kLastAnswer(300);
constexpr Seconds kStep(0.01);

}  // namespace

Clock::time_point after(Clock::time_point from, Seconds time) {
  return from + std::chrono::duration_cast<Clock::duration>(time);
}

std::chrono::system_clock::time_point on_system_clock(Clock::time_point at) {
  return std::chrono::system_clock::now() +
         std::chrono::duration_cast<std::chrono::system_clock::duration>(at - Clock::now());
}

struct Traffic::Call {
  grpc::ClientContext context;
  grpc::ByteBuffer response;
  Ended ended{};
  Clock::time_point due;
  std::unique_ptr<grpc::ClientAsyncResponseReader<grpc::ByteBuffer>> reader;
};

std::shared_ptr<grpc::Channel> make_channel(const std::string& target) {
  grpc::ChannelArguments arguments;
  // Each sender has a connection of its own.
  arguments.SetInt(GRPC_ARG_USE_LOCAL_SUBCHANNEL_POOL, 1);
  arguments.SetInt(GRPC_ARG_ENABLE_RETRIES, 0);
  arguments.SetInt(GRPC_ARG_ENABLE_HTTP_PROXY, 0);
  arguments.SetMaxReceiveMessageSize(-1);
  return grpc::CreateCustomChannel(target, grpc::InsecureChannelCredentials(), arguments);
}

Traffic::Traffic(const std::string& target) : stub_(make_channel(target)) {}

Traffic::~Traffic() {
  for (Call* call : calls_) call->context.TryCancel();
  queue_.Shutdown();
  void* tag = nullptr;
  bool ok = false;
  while (queue_.Next(&tag, &ok)) delete static_cast<Call*>(tag);
}

void Traffic::begin(const Message& message, Clock::time_point due, Seconds patience) {
  auto call = std::make_unique<Call>();
  call->due = due;
  call->context.set_deadline(on_system_clock(after(due, patience)));
  call->reader = stub_.PrepareUnaryCall(&call->context, message.method, message.bytes, &queue_);
  call->reader->StartCall();
  Call* const tag = call.release();  // the queue returns it
  calls_.insert(tag);
  tag->reader->Finish(&tag->response, &tag->ended.status, tag);
}

void Traffic::poll(Clock::time_point until, const std::function<void(const Ended&)>& on_end) {
  const auto deadline = on_system_clock(until);
  void* tag = nullptr;
  bool ok = false;
  while (queue_.AsyncNext(&tag, &ok, deadline) == grpc::CompletionQueue::GOT_EVENT) {
    const std::unique_ptr<Call> call(static_cast<Call*>(tag));
    calls_.erase(call.get());
    call->ended.at = Clock::now();
    call->ended.latency_s = Seconds(call->ended.at - call->due).count();
    on_end(call->ended);
    if (Clock::now() >= until) return;
  }
}

std::vector<Ended> open_loop(Traffic& traffic, const std::vector<Message>& messages, double rate,
                             Seconds duration, Seconds patience) {
  std::vector<Ended> calls;
  const auto collect = [&](const Ended& call) { calls.push_back(call); };
  const auto start = Clock::now();
  const auto count = static_cast<std::size_t>(rate * duration.count());
  for (std::size_t i = 0; i < count; ++i) {
    const auto due = after(start, Seconds(static_cast<double>(i) / rate));
    if (due > Clock::now()) traffic.poll(due, collect);
    traffic.begin(messages[i % messages.size()], due, patience);
  }
  const auto last = after(Clock::now(), kLastAnswer);
  while (traffic.running() > 0 && Clock::now() < last)
    traffic.poll(after(Clock::now(), kStep), collect);
  return calls;
}

std::vector<Ended> closed_loop(Traffic& traffic, const std::vector<Message>& messages,
                               std::size_t at_once, Seconds duration, Seconds patience) {
  std::vector<Ended> calls;
  const auto end = after(Clock::now(), duration);
  std::size_t sent = 0;
  const auto send = [&] {
    traffic.begin(messages[sent++ % messages.size()], Clock::now(), patience);
  };
  const auto collect = [&](const Ended& call) {
    calls.push_back(call);
    if (Clock::now() < end) send();
  };
  for (std::size_t i = 0; i < at_once; ++i) send();
  while (Clock::now() < end) traffic.poll(end, collect);
  const auto last = after(end, kLastAnswer);
  while (traffic.running() > 0 && Clock::now() < last)
    traffic.poll(after(Clock::now(), kStep), collect);
  return calls;
}

std::vector<double> latencies(const std::vector<Ended>& calls, grpc::StatusCode code) {
  std::vector<double> result;
  for (const Ended& call : calls)
    if (call.status.error_code() == code) result.push_back(call.latency_s);
  return result;
}

}  // namespace lucerna::reliability
