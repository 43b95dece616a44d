#include "client/terminal/stop_signals.h"

#include <pthread.h>
#include <signal.h>
#include <unistd.h>

#include <thread>

#include "client/terminal/session.h"

namespace lucerna::cli {
namespace {

std::atomic<int> arrived_signal = 0;

}  // namespace

std::stop_token stop_on_signals() {
  static std::stop_source source;
  static sigset_t signals;
  sigemptyset(&signals);
  sigaddset(&signals, SIGINT);
  sigaddset(&signals, SIGTERM);
  pthread_sigmask(SIG_BLOCK, &signals, nullptr);
  std::thread([] {
    int signal = 0;
    sigwait(&signals, &signal);
    arrived_signal = signal;
    source.request_stop();
    sigwait(&signals, &signal);
    _exit(kSignal + signal);
  }).detach();
  return source.get_token();
}

const std::atomic<int>& first_signal() { return arrived_signal; }

}  // namespace lucerna::cli
