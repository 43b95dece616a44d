// A gRPC server that answers every call with the same bytes: what any server with these messages
// must do at least.
//
//     LUCERNA_ECHO_ANSWER=FILE echo_server --listen ADDRESS ...
//
// Ignores further options, so that LocalServer can start it in place of lucernad.
#include <fmt/core.h>
#include <grpcpp/generic/async_generic_service.h>
#include <grpcpp/grpcpp.h>
#include <grpcpp/health_check_service_interface.h>
#include <signal.h>

#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>
#include <string_view>

namespace {

std::string bytes_of(const char* path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}

/// Reads one message and writes one.
class Echo final : public grpc::ServerGenericBidiReactor {
 public:
  explicit Echo(const std::string& answer) : answer_(answer) { StartRead(&request_); }
  void OnReadDone(bool ok) override {
    if (!ok) return Finish(grpc::Status::CANCELLED);
    // A new copy for each answer, as a server writes its answers.
    const grpc::Slice slice(answer_);
    response_ = grpc::ByteBuffer(&slice, 1);
    StartWriteAndFinish(&response_, {}, grpc::Status::OK);
  }
  void OnDone() override { delete this; }

 private:
  const std::string& answer_;
  grpc::ByteBuffer request_, response_;
};

class EchoService final : public grpc::CallbackGenericService {
 public:
  explicit EchoService(std::string answer) : answer_(std::move(answer)) {}
  grpc::ServerGenericBidiReactor* CreateReactor(grpc::GenericCallbackServerContext*) override {
    return new Echo(answer_);  // deletes itself
  }

 private:
  const std::string answer_;
};

int run(int argc, char** argv) {
  const char* path = std::getenv("LUCERNA_ECHO_ANSWER");
  std::string address;
  for (int i = 1; i + 1 < argc; ++i)
    if (std::string_view(argv[i]) == "--listen") address = argv[i + 1];
  if (path == nullptr || address.empty()) {
    fmt::print(stderr, "usage: LUCERNA_ECHO_ANSWER=FILE echo_server --listen ADDRESS\n");
    return 2;
  }
  sigset_t signals;
  sigemptyset(&signals);
  sigaddset(&signals, SIGTERM);
  sigaddset(&signals, SIGINT);
  pthread_sigmask(SIG_BLOCK, &signals, nullptr);
  EchoService service(bytes_of(path));
  grpc::EnableDefaultHealthCheckService(true);
  grpc::ServerBuilder builder;
  int port = 0;
  builder.AddListeningPort(address, grpc::InsecureServerCredentials(), &port);
  builder.SetMaxReceiveMessageSize(-1);
  builder.SetMaxSendMessageSize(-1);
  builder.RegisterCallbackGenericService(&service);
  const auto server = builder.BuildAndStart();
  if (server == nullptr) return 1;
  // The form in which lucernad states its address.
  fmt::print("listening on {}:{}\n", address.substr(0, address.rfind(':')), port);
  std::fflush(stdout);
  int signal = 0;
  sigwait(&signals, &signal);
  server->Shutdown(std::chrono::system_clock::now());
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  try {
    return run(argc, argv);
  } catch (const std::exception& e) {
    fmt::print(stderr, "echo_server: {}\n", e.what());
    return 1;
  }
}
